"""Scenes of the primer's study: spheres of one material, planes, and one contact law of which every part can be turned off by its number."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from demsolver import ContactLaw, Gravity, Particles, Plane, Scene, Simulation
    from demverify.frames import Floats

KN, RADIUS, DENSITY, G = 1e4, 0.005, 2500.0, 9.81
MASS = DENSITY * 4.0 / 3.0 * pi * RADIUS**3
NOTHING = {"kn": KN, "gamman": 0.0, "shear_stiffness": 2.0 / 7.0 * KN, "gammat": 0.0, "mu": 0.0, "rolling_friction": 0.0}


def law(shape: tuple[int, ...], *, friction: str = "primer", limit: bool = False, **given: Any) -> ContactLaw:
    """Spring and dashpot (1.6), tangential spring and dashpot (1.11) with Coulomb's limit (1.17), rolling resistance (1.20); levers end at the
    contact point. given: coefficients, each one number or a table of `shape`; what is not given is off."""
    from demsolver import ContactLaw

    tables = {name: np.broadcast_to(np.asarray(value, dtype=float), shape).copy() for name, value in (NOTHING | given).items()}
    return ContactLaw(
        "hooke", "velocity", "constant", "absolute", friction, tables, surface_arm="contact", torque_arm="contact", limit_damping=limit,
        rolling="primer",
    )  # fmt: skip


def spheres(x: Any, radius: Any = RADIUS, *, v: Any = 0.0, omega: Any = 0.0, kind: Any = 1) -> Particles:
    """Particles at x (n, 3); radius and type one for all or (n,), v and omega one for all or (n, 3)."""
    from demsolver import Particles

    x = np.atleast_2d(np.asarray(x, dtype=float))
    n = len(x)
    radii = np.broadcast_to(np.asarray(radius, dtype=float), (n,)).copy()
    mass = DENSITY * 4.0 / 3.0 * pi * radii**3
    v, omega = (np.broadcast_to(np.asarray(part, dtype=float), (n, 3)).copy() for part in (v, omega))
    types = np.broadcast_to(np.asarray(kind, dtype=np.int64), (n,)).copy()
    return Particles(np.arange(1, n + 1), types, x, v, omega, radii, mass, np.ones(n, int), np.zeros((n, 3), int))


def scene(
    particles: Particles, dt: float, *, pair: ContactLaw | None = None, walls: Sequence[tuple[Plane, ContactLaw]] = (),
    gravity: Sequence[float] = (0.0, 0.0, 0.0), euler: bool = False,
) -> Scene:  # fmt: skip
    """A scene in open space."""
    from demsolver import Box, EulerSphere, Neighbor, NveSphere, Scene, Wall

    ntypes = int(particles.type.max())
    return Scene(
        Box(np.full(3, -1e3), np.full(3, 1e3), ("ff", "ff", "ff")), particles, ntypes, dt, pair=pair,
        walls=tuple(Wall(f"plane {k}", plane, one) for k, (plane, one) in enumerate(walls, 1)), forces=(_field(gravity),),
        integrate=(EulerSphere(),) if euler else (NveSphere(),), neighbor=Neighbor(2.0 * RADIUS), lost="ignore",
    )  # fmt: skip


def _field(gravity: Sequence[float]) -> Gravity:
    from demsolver import Gravity

    x, y, z = gravity
    return Gravity((x, y, z))


def stage(particles: Particles, dt: float, *, gravity: float = 0.0, pair: dict[str, Any] | None = None, wall: dict[str, Any] | None = None) -> Scene:
    """Spheres over the plane z = 0, and over z = 100, which never pulls (limit_damping). pair, wall: coefficients."""
    from demsolver import Plane

    n = int(particles.type.max())
    floors = ((Plane((0.0, 0.0, 1.0), 0.0), law((n,), **(wall or {}))), (Plane((0.0, 0.0, 1.0), -100.0), law((n,), limit=True, **(wall or {}))))
    return scene(particles, dt, pair=law((n, n), **(pair or {})), walls=floors, gravity=(0.0, 0.0, -gravity))


def squeezed(
    dt: float, *, x: float = 0.0, v: float = 0.0, along: Literal[0, 2] = 2, pull: float = 0.0, euler: bool = True, friction: str = "primer",
    **given: Any,
) -> Scene:  # fmt: skip
    """A sphere between two planes that press on it from below and above, each with half a radius of overlap.

    Moving along z it is m x'' = -2 kn x - 2 gamman x' exactly; along x both tangential springs act and no spin comes of it. pull: acceleration
    along x.
    """
    from demsolver import Plane

    one = law((1,), friction=friction, **given)
    walls = [(Plane((0.0, 0.0, 1.0), side * 0.5 * RADIUS), one) for side in (1.0, -1.0)]
    way = np.eye(3)[along]
    return scene(spheres(x * way, v=v * way), dt, walls=walls, gravity=(pull, 0.0, 0.0), euler=euler)


def started(what: Scene, *, budget: bool = False) -> Simulation:
    """The scene, set up."""
    from demsolver import Simulation

    simulation = Simulation(what, budget=budget, on_instability="off")
    simulation.setup()
    return simulation


def path(what: Scene, steps: int, along: int = 2) -> tuple[Floats, Floats]:
    """Position and velocity (steps + 1,) of the first sphere along an axis."""
    simulation = started(what)
    x, v = np.empty(steps + 1), np.empty(steps + 1)
    for k in range(steps + 1):
        x[k], v[k] = simulation.bodies.x[0, along], simulation.bodies.v[0, along]
        if k < steps:
            simulation.advance(1)
    return x, v

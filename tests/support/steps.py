"""Scenes held in contact, a little disturbed: does the disturbance grow at a step, or stay what it was?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demsolver import Box, ContactLaw, Gravity, LostParticles, Neighbor, NveSphere, Scene, Simulation, Slab, Unstable, Wall
from tests.support.scenes import spheres

KN, RADIUS, OVERLAP = 1e4, 5e-3, 1e-5
MASS = 2500.0 * 4 / 3 * np.pi * RADIUS**3
HELD = KN * OVERLAP / MASS
"""Acceleration that keeps one sphere of MASS pressed OVERLAP deep into a linear contact."""


def linear(shape: tuple[int, ...], *, gamman: float = 0.0, kt: float = 0.0, xt: float = 0.0, mu: float = 1e6, **names: str) -> ContactLaw:
    """Linear springs and dashpots; with this mu a contact never slips."""
    values = {"kn": KN, "gamman": gamman, "shear_stiffness": kt, "xt": xt, "mu": mu}
    chosen = {"damping": "mass_velocity", "tangential_stiffness": "constant", "tangential_damping": "scaled", "friction": "classic_history"} | names
    return ContactLaw("hooke", **chosen, coefficients={name: np.full(shape, value) for name, value in values.items()})  # type: ignore[arg-type]


def pair(dt: float, law: ContactLaw, *, along: float = 0.0, across: float = 0.0) -> Scene:
    """Two equal spheres pressed together along x by opposite forces; disturbed along x and along y."""
    p = spheres(np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]) * (RADIUS - 0.5 * OVERLAP), np.full(2, RADIUS))
    p.v[:] = np.array([[along, across, 0.0], [-along, -across, 0.0]])
    p = replace(p, mask=np.array([1 | 2, 1 | 4]))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    held = (Gravity((HELD, 0.0, 0.0), 1), Gravity((-HELD, 0.0, 0.0), 2))
    return Scene(box, p, 1, dt, pair=law, walls=floors(law), forces=held, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


def on_floor(dt: float, law: ContactLaw, *, along: float = 0.0, across: float = 0.0, overlap: float = OVERLAP, pull: float = HELD) -> Scene:
    """A sphere pressed onto a floor; disturbed along z and along x. law: of a wall. The pair law is the same, for one compiled loop."""
    p = spheres(np.array([[0.0, 0.0, RADIUS - overlap]]), np.array([RADIUS]), v=np.array([[across, 0.0, along]]))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    table = {name: np.broadcast_to(value, (1, 1)).copy() for name, value in law.coefficients.items()}
    held = (Gravity((0.0, 0.0, -pull), 0), Gravity((0.0, 0.0, 0.0), 1))
    walls = (Wall("floor", Slab(2, lo=0.0), law),)
    return Scene(box, p, 1, dt, pair=replace(law, coefficients=table), walls=walls, forces=held, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


def floors(law: ContactLaw) -> tuple[Wall, ...]:
    """A floor far below, of the same law."""
    return (Wall("floor", Slab(2, lo=-0.09), replace(law, coefficients={name: np.ravel(table)[:1] for name, table in law.coefficients.items()})),)


def growth(scene: Scene, steps: int = 200) -> float:
    """Largest change of any force or torque since the start, as the way it makes in a step, over the way that the disturbance makes in one: a few
    for springs that hold. (Ways themselves may grow without harm: a ball rolls on.) inf when the run ends in nonsense."""
    simulation = Simulation(scene)
    simulation.setup()
    p = scene.particles
    first = scene.timestep * max(np.abs(p.v).max(), (p.radius[:, None] * np.abs(p.omega)).max())
    pushed, per_turn = scene.timestep**2 / p.mass[:, None], scene.timestep**2 / (0.4 * p.mass * p.radius)[:, None]
    start, farthest = simulation.bodies.force, 0.0
    for _ in range(steps // 10):
        try:
            simulation.advance(10)
        except (Unstable, LostParticles):
            return np.inf
        b = simulation.bodies
        farthest = max(farthest, float((pushed * np.abs(b.force - start)).max()), float((per_turn * np.abs(b.torque)).max()))
    return farthest / first

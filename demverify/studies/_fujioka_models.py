"""The models that the paper compares, as contact laws, and the scenes they are put into. SI units.

All scenes have one shape (a pair law, one floor, gravity, a group that may be frozen, semi-implicit Euler), so that each model is compiled once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from demsolver import Box, ContactLaw, EulerSphere, Freeze, Gravity, Neighbor, Particles, Scene, Simulation, Slab, Wall
from demsolver.restitution import fraction_for
from demverify.frames import Floats

RESTITUTION = 0.7
GRAVITY = 9.8
DIAMETER = 225.0
DENSITY = 1.0
STIFFNESS = (pi / 10) ** 2  # a = k dt^2/m of C, F and P: half a period of an undamped contact takes ten steps
HERTZ_STIFFNESS = 1.45  # K dt^2 sqrt(d_c)/m of T, where the force is K overlap^(3/2)
FREE, FROZEN = 0, 1  # groups
FAR = 1e30


@dataclass(frozen=True)
class Model:
    """One model of the comparison. name: as in the paper's tables. normal: its law; damped: whether a dashpot belongs to it. style: in charts."""

    name: str
    said: str
    normal: str
    damped: bool
    style: int


MODELS = (
    Model("C", "linear spring and dashpot (Cundall, Kawaguchi)", "hooke", True, 0),
    Model("T", "Hertz spring and dashpot (Tanaka)", "hertz", True, 1),
    Model("F", "Fujioka & Ushijima 2005, a reconstruction", "fujioka2005", False, 2),
    Model("P", "Fujioka & Ushijima 2006, as printed", "fujioka2006_printed", False, 3),
    Model("P mended", "Fujioka & Ushijima 2006, mended", "fujioka2006", False, 5),
)
PAPER = ("C", "T", "F", "P")


def stiffness(model: Model, mass: float, reff: float, length: float, dt: float, a: float = STIFFNESS) -> float:
    """kn of the model's law for the reduced mass: a mass/dt^2, or for Hertz K/sqrt(reff). length: d_c, the diameter."""
    return mass / dt**2 * (HERTZ_STIFFNESS / sqrt(length * reff) if model.normal == "hertz" else a)


def law(model: Model, kn: Floats, restitution: float = RESTITUTION) -> ContactLaw:
    """The model as a contact law without friction. Dashpots may pull at the end of a contact."""
    number = fraction_for(restitution, "hertz" if model.normal == "hertz" else "hooke") if model.damped else restitution
    coefficients: Mapping[str, Floats] = {"kn": kn, ("damping_fraction" if model.damped else "restitution"): np.full(np.shape(kn), number)}
    return ContactLaw(model.normal, "fraction" if model.damped else "none", "none", "none", "none", coefficients)


@dataclass(frozen=True)
class Spheres:
    """Where spheres start. x, v: (n, 3). radius, mass: (n,). frozen: (n,) bool."""

    x: Floats
    v: Floats
    radius: Floats
    mass: Floats
    frozen: Sequence[bool] = ()

    def particles(self) -> Particles:
        """As the solver takes them: one type, no spin; frozen ones in a group of their own."""
        n = len(self.x)
        frozen = np.array(self.frozen, dtype=int) if len(self.frozen) else np.zeros(n, dtype=int)
        mask = (1 << FREE) + (frozen << FROZEN)
        number = np.arange(1, n + 1)
        return Particles(number, np.ones(n, dtype=int), self.x, self.v, np.zeros((n, 3)), self.radius, self.mass, mask, np.zeros((n, 3), dtype=int))


def simulation(
    spheres: Spheres, pair: ContactLaw, floor: ContactLaw, dt: float, *, level: float = 0.0, skin: float = 1.0, gravity: float = GRAVITY,
    moved: int = FREE,
) -> Simulation:  # fmt: skip
    """A scene at its set-up: spheres over the plane z = level (far below where there is to be none). moved: the group that moves."""
    scene = Scene(
        Box(np.full(3, -FAR), np.full(3, FAR), ("ff", "ff", "ff"), np.ones(3)), spheres.particles(), 1, dt, pair,
        walls=(Wall("floor", Slab(2, lo=level), floor),), forces=(Gravity((0.0, 0.0, -gravity), FREE), Freeze(FROZEN)),
        integrate=(EulerSphere(moved),), neighbor=Neighbor(skin),
    )  # fmt: skip
    made = Simulation(scene, on_instability="off")
    made.setup()
    return made


def sphere_mass(radius: float) -> float:
    """Mass of a sphere of the paper's density."""
    return DENSITY * 4.0 / 3.0 * pi * radius**3


def over_floor(
    model: Model, heights: Floats, speed: Floats | float, dt: float, *, a: float = STIFFNESS, gravity: float = GRAVITY, moved: int = FREE
) -> Simulation:
    """Spheres of the paper's diameter in a square array over the floor, lowest points at `heights` (n,), moving down with `speed` (n,) or one."""
    n, radius = len(heights), DIAMETER / 2
    side = int(np.ceil(np.sqrt(n)))
    k, mass = np.arange(n), sphere_mass(radius)
    x = np.column_stack([1.5 * DIAMETER * (k % side), 1.5 * DIAMETER * (k // side), radius + heights])
    v = np.column_stack([np.zeros((n, 2)), -np.broadcast_to(speed, n)])
    spheres = Spheres(x, v, np.full(n, radius), np.full(n, mass))
    pair = law(model, np.full((1, 1), stiffness(model, mass / 2, radius / 2, DIAMETER, dt, a)))
    floor = law(model, np.full(1, stiffness(model, mass, radius, DIAMETER, dt, a)))
    return simulation(spheres, pair, floor, dt, skin=0.2 * DIAMETER, gravity=gravity, moved=moved)

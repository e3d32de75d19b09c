"""Collisions for the tests of the laws of Fujioka & Ushijima: one contact in reduced numbers, and many at once through `Simulation`."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from demsolver import Box, ContactLaw, EulerSphere, Gravity, Neighbor, NveSphere, Particles, Scene, Simulation, Slab, Wall, contact

Floats = NDArray[np.float64]
STEPS = 14  # a contact of these laws takes at most a few


class Collision(NamedTuple):
    """What came out of one contact: rebound over impact speed, its steps, states (s, a), and the account of energy after each step."""

    restitution: float
    steps: int
    states: list[float]
    account: list[float]


def law_of(name: str) -> ModuleType:
    """The module of a normal law."""
    return contact.law("normal", name)


def collide(name: str, a: float, e: float, phase: float) -> Collision:
    """One contact alone, reduced mass 1, step 1, impact speed 1, so that kn = a. phase: overlap at the contact step, 0 to 1."""
    law, u, d, taken = law_of(name), 1.0, phase, 0.0
    states, account = [], []
    while d > 0.0:
        force, shift, loss = law.step(d, -u, 1.0, 1.0, a, e)
        taken += loss
        states.append(u / d)
        account.append(0.5 * u * u + law.energy(d, -u, 1.0, 1.0, a, e) + taken)
        u -= force
        d += u - shift
        assert len(states) < 100
    return Collision(-u, len(states), states, [*account, 0.5 * u * u + taken])


def contact_law(name: str, kn: Floats, restitution: Floats) -> ContactLaw:
    """The law and nothing else."""
    return ContactLaw(name, "none", "none", "none", "none", {"kn": kn, "restitution": restitution})


def particles(kind: Floats, x: Floats, v: Floats, radius: Floats, mass: Floats) -> Particles:
    """Spheres without spin in group 0."""
    n = len(x)
    return Particles(np.arange(1, n + 1), kind.astype(int), x, v, np.zeros((n, 3)), radius, mass, np.ones(n, dtype=int), np.zeros((n, 3), int))


def scene(
    name: str,
    p: Particles,
    coefficients: tuple[Floats, Floats],
    dt: float,
    integrator: EulerSphere | NveSphere,
    *,
    gravity: float = 0.0,
    floor: float = 0.0,
) -> Scene:
    """Spheres over a floor, one law for all. Every scene is of this shape, so that few loops are compiled.

    coefficients: kn, e of the pairs of types, (ntypes, ntypes); a type against the floor has those of its own pair."""
    kn, e = coefficients
    wall = Wall("floor", Slab(2, lo=floor), contact_law(name, np.diag(kn).copy(), np.diag(e).copy()))
    box = Box(np.full(3, -2000.0), np.full(3, 2000.0), ("ff", "ff", "ff"))
    fields = (Gravity((0.0, 0.0, -gravity)),)
    return Scene(box, p, len(kn), dt, contact_law(name, kn, e), (wall,), fields, (integrator,), Neighbor(0.5))  # type: ignore[arg-type]


def on_walls(name: str, a: Floats, e: Floats, phase: Floats, integrator: EulerSphere | NveSphere) -> Simulation:
    """One sphere of radius 1 for each (a, e, phase), a type of its own, falling on z = 0 at 0.4 a step; the contact begins in the second step."""
    n, u, dt = len(a), 0.4, 0.01
    x = np.column_stack([10.0 * np.arange(n), np.zeros(n), 1.0 + u * (2.0 - phase)])
    v = np.tile([0.0, 0.0, -u / dt], (n, 1))
    mass = np.linspace(0.5, 2.0, n)
    p = particles(np.arange(1, n + 1), x, v, np.ones(n), mass)
    return Simulation(scene(name, p, (np.diag(a * mass / dt**2), np.diag(e)), dt, integrator), budget=True, on_instability="off")


def head_on(name: str, a: Floats, e: Floats, phase: Floats, integrator: EulerSphere | NveSphere) -> Simulation:
    """Pairs of unequal spheres along x, each in a row and of a type of its own, one of them at rest; contact begins in the second step."""
    n, u, dt = len(a), 0.4, 0.01
    mass = np.column_stack([np.linspace(0.5, 2.0, n), np.linspace(3.0, 0.7, n)])
    x, v = np.zeros((2 * n, 3)), np.zeros((2 * n, 3))
    x[:, 1] = 10.0 * np.repeat(np.arange(n), 2)
    x[1::2, 0] = 2.5 + u * (2.0 - phase)
    v[::2, 0] = u / dt
    p = particles(np.repeat(np.arange(1, n + 1), 2), x, v, np.tile([1.0, 1.5], n), mass.ravel())
    kn = np.diag(a * mass.prod(axis=1) / mass.sum(axis=1) / dt**2)
    return Simulation(scene(name, p, (kn, np.diag(e)), dt, integrator, floor=-1000.0), budget=True, on_instability="off")


def totals(simulation: Simulation, steps: int) -> Floats:
    """The energy that a scene holds and lost, after each of so many steps."""
    simulation.setup()
    found = [simulation.energy_budget().total]
    for _ in range(steps):
        simulation.advance(1)
        found.append(simulation.energy_budget().total)
    return np.array(found)

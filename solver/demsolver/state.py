"""The arrays of a running simulation, named once, for Python and for the compiled loop alike."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import EulerSphere, Freeze, Scene

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Bodies(NamedTuple):
    """Per-particle arrays, n rows, C order, float64 unless said. Changed in place by the compiled loop.

    x, v, omega, force, torque: (n, 3). radius, mass: (n,). kind: type - 1. mask: group bits. frozen: bool.
    kick: dt/2m, spin: dt/2I (semi-implicit Euler: dt/m, dt/I), drift: dt; all zero where no integrator moves the particle.
    held: (n, 3) positions at the last list build. aside: (n, 3) what step laws move a particle by on
    top; in implicit scenes the part of the force that the step solves anew: springs and gravity; (0, 3) in other scenes.
    """

    x: Floats
    v: Floats
    omega: Floats
    force: Floats
    torque: Floats
    radius: Floats
    mass: Floats
    kind: Ints
    mask: Ints
    frozen: NDArray[np.bool_]
    kick: Floats
    spin: Floats
    drift: Floats
    held: Floats
    aside: Floats


class Pairs(NamedTuple):
    """The neighbour list in rows: partners of particle i are partner[first[i]:first[i + 1]].

    shift: (m,) index into the table of periodic shifts. touching: (m,) uint8. memory: (m, c) floats that belong to the contact: its
    tangential history, and what the energy budget remembers of the last step.
    """

    first: Ints
    partner: Ints
    shift: Ints
    touching: NDArray[np.uint8]
    memory: Floats


def selected(mask: Ints, bit: int) -> NDArray[np.bool_]:
    """Members of group `bit`, (n,) bool."""
    members: NDArray[np.bool_] = (mask >> bit) & 1 == 1
    return members


def bodies_of(scene: Scene, *, aside: bool) -> Bodies:
    """Fresh arrays of a scene's particles; forces and torques zero. aside: whether the scene needs that array."""
    p = scene.particles
    n = len(p.id)
    frozen = np.zeros(n, dtype=bool)
    for force in scene.forces:
        if isinstance(force, Freeze):
            frozen |= selected(p.mask, force.bit)
    kick, spin, drift = _integration(scene)
    return Bodies(
        x=_copy(p.x),
        v=_copy(p.v),
        omega=_copy(p.omega),
        force=np.zeros((n, 3)),
        torque=np.zeros((n, 3)),
        radius=_copy(p.radius),
        mass=_copy(p.mass),
        kind=np.ascontiguousarray(p.type, dtype=np.int64) - 1,
        mask=np.array(p.mask, dtype=np.int64),
        frozen=frozen,
        kick=kick,
        spin=spin,
        drift=drift,
        held=_copy(p.x),
        aside=np.zeros((n if aside else 0, 3)),
    )


def _integration(scene: Scene) -> tuple[Floats, Floats, Floats]:
    p = scene.particles
    kick, spin, drift = (np.zeros(len(p.id)) for _ in range(3))
    for integrator in scene.integrate:
        part = scene.timestep * (1.0 if isinstance(integrator, EulerSphere) else 0.5)
        moved = selected(p.mask, integrator.bit)
        kick[moved] = part / p.mass[moved]
        inertia = integrator.inertia * p.mass * p.radius**2
        spins = moved & (p.radius > 0.0)
        spin[spins] = part / inertia[spins]
        drift[moved] = scene.timestep
    return kick, spin, drift


def inertia_of(scene: Scene) -> Floats:
    """Moment of inertia (n,): 2/5 m R^2, or the factor of the integrator that moves the particle (1/2 for discs)."""
    p = scene.particles
    factor = np.full(len(p.id), 0.4)
    for integrator in scene.integrate:
        factor[selected(p.mask, integrator.bit)] = integrator.inertia
    return factor * p.mass * p.radius**2


def _copy(values: Floats) -> Floats:
    return np.array(values, dtype=np.float64, order="C")



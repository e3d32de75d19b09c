"""The arrays of a running simulation, named once, for Python and for the compiled loop alike."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import EulerSphere, Freeze, Scene

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Bodies(NamedTuple):
    """Per-particle arrays, n rows, C order, float64 unless said. Changed in place by the compiled loop.

    x, v, omega, force, torque: (n, 3). radius, mass: (n,). kind: type - 1. mask: group bits. frozen: bool.
    moving: whether an integrator moves the particle. kick: dt/2m, spin: dt/2I (semi-implicit Euler: dt/m, dt/I), thrice a row; where all
    are alike (1, 3), for all. omega, torque, spin: (0, 3) where nothing turns anything. held: (n, 3) positions at the last list build.
    aside: (n, 3) what step laws move a particle by on top; in implicit scenes the part of the force that the step solves anew: springs and
    gravity; (0, 3) in other scenes.
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
    moving: NDArray[np.bool_]
    held: Floats
    aside: Floats


class Flat(NamedTuple):
    """What moves, and by what: views (3 n,) of arrays of Bodies, over which one loop goes."""

    x: Floats
    v: Floats
    omega: Floats
    force: Floats
    torque: Floats
    kick: Floats
    spin: Floats
    aside: Floats


class Pairs(NamedTuple):
    """The neighbour list in rows: entries of particle i are first[i]:first[i + 1]. Every pair stands in the row of its lower index.

    first: (n + 1,) int64. row, partner: (m,) uint32, ascending within a row, ties by code. code: (m,) uint8, or (0,) when no face of the box is
    periodic: s + 32 a, where s is the row of neighbors.SHIFTS by which the image of the other particle is shifted as seen from the particle
    that feels the entry; a = 0: the row's particle feels it, 1: the partner does. A pair with no face between them (s = HOME) is listed once and
    felt by both; across a face it is listed twice, once for each. touching: (m,) uint8. memory: (m, c) floats that belong to the contact, as the
    particle feels it whose entry it is (HOME: the row's): its tangential history, and what the energy budget remembers of the last step.
    """

    first: Ints
    row: NDArray[np.uint32]
    partner: NDArray[np.uint32]
    code: NDArray[np.uint8]
    touching: NDArray[np.uint8]
    memory: Floats


def selected(mask: Ints, bit: int) -> NDArray[np.bool_]:
    """Members of group `bit`, (n,) bool."""
    members: NDArray[np.bool_] = (mask >> bit) & 1 == 1
    return members


def bodies_of(scene: Scene, *, aside: bool = False, rotates: bool = True, uniform: bool = False) -> Bodies:
    """Fresh arrays of a scene's particles; forces and torques zero. aside: whether the scene needs that array; rotates: omega, torque and spin;
    uniform: whether all are alike."""
    p = scene.particles
    n = len(p.id)
    frozen = np.zeros(n, dtype=bool)
    for force in scene.forces:
        if isinstance(force, Freeze):
            frozen |= selected(p.mask, force.bit)
    kick, spin = _integration(scene)
    turning, alike = n if rotates else 0, 1 if uniform else n
    return Bodies(
        x=_copy(p.x),
        v=_copy(p.v),
        omega=_copy(p.omega[:turning]),
        force=np.zeros((n, 3)),
        torque=np.zeros((turning, 3)),
        radius=_copy(p.radius),
        mass=_copy(p.mass),
        kind=np.ascontiguousarray(p.type, dtype=np.int64) - 1,
        mask=np.array(p.mask, dtype=np.int64),
        frozen=frozen,
        kick=np.repeat(kick[:alike, None], 3, axis=1),
        spin=np.repeat(spin[: min(turning, alike), None], 3, axis=1),
        moving=moved(scene),
        held=_copy(p.x),
        aside=np.zeros((n if aside else 0, 3)),
    )


def flat_of(bodies: Bodies) -> Flat:
    """The same numbers without rows."""
    return Flat(*(getattr(bodies, name).reshape(-1) for name in Flat._fields))


def moved(scene: Scene) -> NDArray[np.bool_]:
    """(n,) whether an integrator moves the particle."""
    found = np.zeros(len(scene.particles.id), dtype=bool)
    for integrator in scene.integrate:
        found |= selected(scene.particles.mask, integrator.bit)
    return found


def _integration(scene: Scene) -> tuple[Floats, Floats]:
    """kick and spin, (n,): of a particle that nothing moves those of the last integrator."""
    p = scene.particles
    kick, spin = (np.zeros(len(p.id)) for _ in range(2))
    for integrator in scene.integrate:
        part = scene.timestep * (1.0 if isinstance(integrator, EulerSphere) else 0.5)
        todo = selected(p.mask, integrator.bit) | ~moved(scene)
        kick[todo] = part / p.mass[todo]
        inertia = integrator.inertia * p.mass * p.radius**2
        turns = todo & (p.radius > 0.0)
        spin[turns] = part / inertia[turns]
    return kick, spin


def inertia_of(scene: Scene) -> Floats:
    """Moment of inertia (n,): 2/5 m R^2, or the factor of the integrator that moves the particle (1/2 for discs)."""
    p = scene.particles
    return inertias(scene, p.mask, p.mass, p.radius)


def inertias(scene: Scene, mask: Ints, mass: Floats, radius: Floats) -> Floats:
    """The same of particles of a scene, in any order."""
    factor = np.full(len(mask), 0.4)
    for integrator in scene.integrate:
        factor[selected(mask, integrator.bit)] = integrator.inertia
    return factor * mass * radius**2


def _copy(values: Floats) -> Floats:
    return np.array(values, dtype=np.float64, order="C")


def outside(array: NDArray[Any], order: Ints) -> NDArray[Any]:
    """A copy of an array of rows in the scene's order; of one that is not of rows as it is."""
    if len(array) != len(order):
        return array.copy()
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    return array.take(place, axis=0)  # many times as fast as array[place]


def movers_first(b: Bodies, rows: Ints) -> Ints:
    """`rows` with those of particles that move before the others."""
    return np.concatenate([rows[b.moving[rows]], rows[~b.moving[rows]]])

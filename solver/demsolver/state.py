"""The arrays of a running simulation, named once, for Python and for the compiled loop alike."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import EulerSphere, Freeze, Gravity, NveClumps, NveSphere, Particles, Scene
from demsolver.shapes import superquadric

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Shaped(NamedTuple):
    """What is more of superquadrics, n rows as in scene.Superquadrics; size: (n,) radius of a sphere of the same volume, of spheres their own."""

    quat: Floats
    angmom: Floats
    inertia: Floats
    axes: Floats
    blockiness: Floats
    size: Floats


class Clumped(NamedTuple):
    """What is more of members of clumps. clump: (n,) its row, -1 of free particles. heft: (n,) mass that contacts see, of the whole clump."""

    clump: Ints
    heft: Floats


class Bodies(NamedTuple):
    """Per-particle arrays, n rows, C order, float64 unless said. Changed in place by the compiled loop.

    x, v, omega, force, torque: (n, 3). radius, mass: (n,). kind: type - 1. mask: group bits. frozen: bool.
    moving: whether an integrator moves the particle. kick: dt/2m, spin: dt/2I (semi-implicit Euler: dt/m, dt/I), thrice a row; where all
    are alike (1, 3), for all. omega, torque, spin: (0, 3) where nothing turns anything. held: (n, 3) positions at the last list build.
    aside: (n, 3) what step laws move a particle by on top; in implicit scenes the part of the force that the step solves anew: springs and
    gravity; (0, 3) in other scenes. Scenes with superquadrics have the fields of Shaped behind these, scenes with clumps those of Clumped: others
    are not handed what they lack. `shaped_of` and `clumped_of` give them apart.
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


ShapedBodies: Any = namedtuple("ShapedBodies", (*Bodies._fields, *Shaped._fields))  # type: ignore[misc]  # noqa: PYI024
ClumpedBodies: Any = namedtuple("ClumpedBodies", (*Bodies._fields, *Clumped._fields))  # type: ignore[misc]  # noqa: PYI024
MixedBodies: Any = namedtuple("MixedBodies", (*Bodies._fields, *Shaped._fields, *Clumped._fields))  # type: ignore[misc]  # noqa: PYI024


def shaped_of(b: Bodies) -> Shaped | None:
    """The arrays of superquadrics, not copied; None where the scene has none."""
    return Shaped(*(getattr(b, name) for name in Shaped._fields)) if hasattr(b, "axes") else None


def clumped_of(b: Bodies) -> Clumped | None:
    """The same of members of clumps."""
    return Clumped(*(getattr(b, name) for name in Clumped._fields)) if hasattr(b, "clump") else None


class Rigid(NamedTuple):
    """Clumps, m rows; members of clump c: first[c]:first[c + 1] of the arrays of members. Changed in place by the compiled loop.

    member: (k,) row of the particle. offset: (k, 3) from the centre of mass along the principal axes. home: (k, 3) what periodic wraps
    have added to the member's place. x, v, angmom, omega, force, torque, inertia: (m, 3); quat: (m, 4); mass: (m,). weight: (m, 3) acceleration that
    pulls at the centre.
    """

    first: Ints
    member: Ints
    offset: Floats
    home: Floats
    x: Floats
    v: Floats
    quat: Floats
    angmom: Floats
    omega: Floats
    force: Floats
    torque: Floats
    mass: Floats
    inertia: Floats
    weight: Floats


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
    plain = Bodies(
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
    return _with(plain, _shaped(p), _clumped(p))


def _with(plain: Bodies, shaped: Shaped | None, clumped: Clumped | None) -> Bodies:
    """With what the scene has more."""
    kinds = {(False, False): Bodies, (True, False): ShapedBodies, (False, True): ClumpedBodies, (True, True): MixedBodies}
    kind = kinds[shaped is not None, clumped is not None]
    return cast("Bodies", kind(*plain, *(shaped or ()), *(clumped or ())))


def _shaped(p: Particles) -> Shaped | None:
    one = p.superquadrics
    if one is None:
        return None
    size, shaped = np.array(p.radius, dtype=np.float64), one.axes[:, 0] > 0.0
    size[shaped] = superquadric.equivalent_radius(one.axes[shaped], one.blockiness[shaped])
    return Shaped(*(_copy(part) for part in (one.quat, one.angmom, one.inertia, one.axes, one.blockiness, size)))


def _clumped(p: Particles) -> Clumped | None:
    if p.clumps is None:
        return None
    member, heft = p.clumps.body >= 0, _copy(p.mass)
    heft[member] = p.clumps.mass[p.clumps.body[member]]
    return Clumped(np.array(p.clumps.body, dtype=np.int64), heft)


def of_each(b: Bodies, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Bodies:
    """What `change` makes of each array."""
    return type(b)(*(change(array) for array in b))


def rigid_of(scene: Scene) -> Rigid:
    """Fresh arrays of a scene's clumps; of a scene without them arrays without rows."""
    c = scene.particles.clumps
    if c is None:
        empty: dict[str, Any] = {name: np.zeros((0, 3)) for name in Rigid._fields}
        none = np.zeros(0, dtype=np.int64)
        return Rigid(**empty | {"first": np.zeros(1, dtype=np.int64), "member": none, "quat": np.zeros((0, 4)), "mass": np.zeros(0)})
    member = np.argsort(c.body, kind="stable")[int((c.body < 0).sum()) :]
    m = len(c.id)
    first = np.searchsorted(c.body[member], np.arange(m + 1)).astype(np.int64)
    weight = np.zeros((m, 3))
    for field in scene.forces if not c.members_weigh else ():
        if isinstance(field, Gravity):
            weight[selected(c.mask, field.bit)] += field.acceleration
    home = scene.particles.image[member] * (np.asarray(scene.box.lo) - np.asarray(scene.box.hi))
    moves = {name: _copy(getattr(c, name)) for name in ("x", "v", "quat", "angmom", "omega", "mass", "inertia")}
    return Rigid(
        first=first, member=member, offset=_copy(c.offset[member]), home=_copy(home), force=np.zeros((m, 3)), torque=np.zeros((m, 3)),
        weight=weight, **moves,
    )  # fmt: skip


def placed(c: Rigid, b: Bodies) -> None:
    """Puts the members where their clumps are, in place; b in the scene's order."""
    from demsolver.shapes.rotation import to_space

    who = np.repeat(np.arange(len(c.mass)), np.diff(c.first))
    arm = to_space(c.quat[who], c.offset)
    b.x[c.member] = c.x[who] + arm + c.home
    b.v[c.member] = c.v[who] + np.cross(c.omega[who], arm)
    b.omega[c.member] = c.omega[who]


def flat_of(bodies: Bodies) -> Flat:
    """The same numbers without rows."""
    return Flat(*(getattr(bodies, name).reshape(-1) for name in Flat._fields))


def moved(scene: Scene) -> NDArray[np.bool_]:
    """(n,) whether an integrator moves the particle."""
    p = scene.particles
    clumped = p.clumps.body >= 0 if p.clumps else np.zeros(len(p.id), dtype=bool)
    found = np.zeros(len(p.id), dtype=bool)
    for integrator in scene.integrate:
        found |= clumped if isinstance(integrator, NveClumps) else selected(p.mask, integrator.bit) & ~clumped
    return found


def _integration(scene: Scene) -> tuple[Floats, Floats]:
    """kick and spin, (n,): of a particle that nothing moves those of the last integrator; 0 of what turns as a whole."""
    p = scene.particles
    kick, spin = (np.zeros(len(p.id)) for _ in range(2))
    for integrator in scene.integrate:
        if isinstance(integrator, NveClumps):
            continue
        part = scene.timestep * (1.0 if isinstance(integrator, EulerSphere) else 0.5)
        todo = selected(p.mask, integrator.bit) | ~moved(scene)
        kick[todo] = part / p.mass[todo]
        inertia = factor_of(integrator) * p.mass * p.radius**2
        turns = todo & (p.radius > 0.0)
        spin[turns] = part / inertia[turns]
    if p.superquadrics is not None:
        spin[p.superquadrics.axes[:, 0] > 0.0] = 0.0
    if p.clumps is not None:
        kick[p.clumps.body >= 0] = spin[p.clumps.body >= 0] = 0.0
    return kick, spin


def factor_of(integrator: object) -> float:
    """Moment of inertia of its spheres over m R^2."""
    return integrator.inertia if isinstance(integrator, NveSphere | EulerSphere) else 0.4


def inertia_of(scene: Scene) -> Floats:
    """Moment of inertia (n,): 2/5 m R^2, or the factor of the integrator that moves the particle (1/2 for discs)."""
    p = scene.particles
    return inertias(scene, p.mask, p.mass, p.radius)


def inertias(scene: Scene, mask: Ints, mass: Floats, radius: Floats) -> Floats:
    """The same of particles of a scene, in any order."""
    factor = np.full(len(mask), 0.4)
    for integrator in scene.integrate:
        if not isinstance(integrator, NveClumps):
            factor[selected(mask, integrator.bit)] = factor_of(integrator)
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
    """`rows` with those of particles that move before the others, free ones before members of clumps."""
    more, moving = clumped_of(b), b.moving[rows]
    clumped = more.clump[rows] >= 0 if more else np.zeros(len(rows), dtype=bool)
    return np.concatenate([rows[moving & ~clumped], rows[moving & clumped], rows[~moving]])

"""Who touches whom in a scene, as arrays, and how easily each particle moves. Only overlaps above zero count as contacts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from demsolver import neighbors
from demsolver.listed import Listed, listed
from demsolver.scene import ContactLaw, Cylinder, Enforce2D, Freeze, Plane, Scene, SetForce, Slab
from demsolver.state import Bodies, Floats, Ints, bodies_of, inertia_of, selected

PAIR = -1
"""The law of pairs, where a number would name a wall."""


@dataclass(frozen=True)
class Mobility:
    """Inverse masses and inertias, (n, 3) each, axis by axis; zero where nothing lets a particle answer to a force: not integrated, frozen,
    its force set, or held in the plane."""

    translation: Floats
    rotation: Floats


@dataclass(frozen=True)
class Contacts:
    """m contacts. i, j: rows of the particles; j = -1 for a wall. law: PAIR or the number of the wall. n: (m, 3) unit normals towards i.
    distance: between the centres; inf at a wall. overlap: (m,) above zero. reff: (m,) effective radii as the laws see them."""

    i: Ints
    j: Ints
    law: Ints
    n: Floats
    distance: Floats
    overlap: Floats
    reff: Floats

    def __len__(self) -> int:
        """Their number."""
        return len(self.i)


def mobility(scene: Scene) -> Mobility:
    """How the particles of a scene answer to forces and torques."""
    p = scene.particles
    moved = np.zeros(len(p.id), dtype=bool)
    for integrator in scene.integrate:
        moved |= selected(p.mask, integrator.bit)
    with np.errstate(divide="ignore"):
        mass = np.where(moved, 1.0 / p.mass, 0.0)
        inertia = np.where(moved & (p.radius > 0.0), 1.0 / inertia_of(scene), 0.0)
    found = Mobility(np.repeat(mass[:, None], 3, axis=1), np.repeat(inertia[:, None], 3, axis=1))
    for force in scene.forces:
        chosen = selected(p.mask, force.bit)
        if isinstance(force, Freeze):
            found.translation[chosen] = found.rotation[chosen] = 0.0
        elif isinstance(force, Enforce2D):
            found.translation[chosen, 2] = 0.0
            found.rotation[chosen, :2] = 0.0
        elif isinstance(force, SetForce):
            found.translation[np.outer(chosen, [c is not None for c in force.force])] = 0.0
    return found


def law_of(scene: Scene, number: int) -> ContactLaw:
    """The law of contacts whose `law` is `number`. Raises ValueError for pairs in a scene without a pair law."""
    if number != PAIR:
        return scene.walls[number].law
    if scene.pair is None:
        message = "the scene has no pair law"
        raise ValueError(message)
    return scene.pair


def check_spheres(scene: Scene) -> None:
    """Raises ValueError for a scene of other bodies, whose contacts, inertias and limits are not those of spheres."""
    p = scene.particles
    for what, there in (("superquadrics", p.superquadrics), ("clumps", p.clumps)):
        if there is not None:
            message = f"the limits of a step are known for spheres on their own, not for {what}"
            raise ValueError(message)


def contacts_of(scene: Scene) -> Contacts:
    """The contacts of a scene as it stands. Raises ValueError when a periodic box is shorter than the reach of a contact, and for bodies that are
    no spheres on their own."""
    check_spheres(scene)
    bodies = bodies_of(scene)
    lo, hi = np.array(scene.box.lo, dtype=float), np.array(scene.box.hi, dtype=float)
    neighbors.wrap(bodies.x, lo, hi, scene.box.periodic)
    rows = np.arange(len(bodies.x))
    if scene.pair is None:
        return contacts_in(scene, bodies, listed(neighbors.empty_pairs(len(bodies.x), 0), rows), hi - lo)
    near = replace(scene, neighbor=replace(scene.neighbor, skin=0.0))
    pairs = neighbors.build(near, bodies, lo, hi, 0, neighbors.exclusions(near, bodies.mask, bodies.kind))
    return contacts_in(scene, bodies, listed(pairs, rows), hi - lo)


def contacts_in(scene: Scene, bodies: Bodies, pairs: Listed, size: Floats) -> Contacts:
    """The contacts of a running scene, from its own list; size: (3,) of its box."""
    found = [_pairs(bodies, pairs, size), *(_wall(scene, k, bodies) for k in range(len(scene.walls)))]
    return Contacts(*(np.concatenate([getattr(part, name) for part in found]) for name in Contacts.__dataclass_fields__))


def _pairs(b: Bodies, pairs: Listed, size: Floats) -> Contacts:
    once = (pairs.i < pairs.j) | (pairs.shift == neighbors.HOME)  # across a face a pair is listed twice
    i, j, shift = pairs.i[once], pairs.j[once], pairs.shift[once]
    d = b.x[i] - b.x[j] - neighbors.SHIFTS[shift] * size
    distance, reach = np.sqrt((d * d).sum(axis=1)), b.radius[i] + b.radius[j]
    touch = (distance < reach) & (distance > 0.0)
    i, j, d, distance, reach = i[touch], j[touch], d[touch], distance[touch], reach[touch]
    return Contacts(i, j, np.full(len(i), PAIR), d / distance[:, None], distance, reach - distance, b.radius[i] * b.radius[j] / reach)


def _wall(scene: Scene, number: int, b: Bodies) -> Contacts:
    wall = scene.walls[number]
    away, reff = _from_wall(wall.shape, b.x, b.radius)
    distance = np.sqrt((away * away).sum(axis=1))
    i = np.flatnonzero((distance < b.radius) & (distance > 0.0) & selected(b.mask, wall.bit))
    far, none = np.full(len(i), np.inf), np.full(len(i), -1)
    return Contacts(i, none, np.full(len(i), number), away[i] / distance[i, None], far, b.radius[i] - distance[i], reff[i])


def _from_wall(shape: Slab | Cylinder | Plane, x: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Vectors (n, 3) from the nearest points of a wall to x, zero where it is not felt, and effective radii (n,)."""
    away, reff = np.zeros_like(x), radius
    if isinstance(shape, Plane):
        normal = np.array(shape.normal)
        high = (x @ normal + shape.offset) / (normal @ normal)
        away = np.where(shape.one_sided & (high < 0.0), 0.0, high)[:, None] * normal
    elif isinstance(shape, Slab):
        low, high = x[:, shape.axis] - shape.lo, shape.hi - x[:, shape.axis]
        away[:, shape.axis] = np.where(low < high, low, -high)
    else:
        axes = [(shape.axis + 1) % 3, (shape.axis + 2) % 3]
        d = x[:, axes] - np.array(shape.center)
        off = np.hypot(d[:, 0], d[:, 1])
        felt = (off > 0.0) & ((shape.side == "both") | ((off < shape.radius) == (shape.side == "in")))
        away[:, axes] = d * np.where(felt, (off - shape.radius) / np.where(off > 0.0, off, 1.0), 0.0)[:, None]
        if shape.effective_radius == "curved":
            curvature = np.where(off < shape.radius, -2.0, 2.0) * shape.radius
            reff = radius * curvature / (radius + curvature)
    return away, reff


def centred(scene: Scene, number: int, b: Bodies) -> Ints:
    """Rows of the particles whose centres lie in a plane wall, which has no normal there."""
    wall, shape = scene.walls[number], scene.walls[number].shape
    if isinstance(shape, Cylinder):
        return np.zeros(0, dtype=np.int64)
    two_sided = replace(shape, one_sided=False) if isinstance(shape, Plane) else shape  # behind one that is not felt nobody is near
    away = _from_wall(two_sided, b.x, b.radius)[0]
    return np.flatnonzero(~away.any(axis=1) & (b.radius > 0.0) & selected(b.mask, wall.bit))


def wall_radius(scene: Scene, number: int, i: int) -> float:
    """Effective radius of particle i, where it is, at a wall."""
    p = scene.particles
    return float(_from_wall(scene.walls[number].shape, p.x[i : i + 1], p.radius[i : i + 1])[1][0])


def is_frozen(scene: Scene) -> NDArray[np.bool_]:
    """(n,) whether contacts see a particle as infinitely heavy."""
    frozen = np.zeros(len(scene.particles.id), dtype=bool)
    for force in scene.forces:
        if isinstance(force, Freeze):
            frozen |= selected(scene.particles.mask, force.bit)
    return frozen


def encounters(scene: Scene, i: Ints, j: Ints, overlap: Floats, reff: Floats) -> Floats:
    """(m, 7) rows of `Encounter`: contacts of the particles i and j (-1: a wall) as their law sees them. reff: (m,), what a wall's curvature
    makes of it."""
    p, frozen = scene.particles, is_frozen(scene)
    pair = j >= 0
    radius, partner = p.radius[i], np.where(pair, p.radius[j], np.inf)
    mass, other = p.mass[i], np.where(pair, p.mass[j], np.inf)
    meff = np.where(frozen[i] & pair, other, np.where(frozen[j] & pair, mass, 1.0 / (1.0 / mass + 1.0 / other)))
    with np.errstate(divide="ignore"):  # points
        heavy, far = 1.0 / (mass * radius * radius), 1.0 / (other * partner * partner)
    row = np.where(pair, (p.type[i] - 1) * scene.ntypes + p.type[j] - 1, p.type[i] - 1)
    return np.column_stack([row, overlap, radius, partner, reff, meff, scene.rolling_inertia / (heavy + far)])


def arms(law: ContactLaw, radius: Floats, overlap: Floats) -> Floats:
    """Lever of the tangential motion: the geometric mean of the lever of the spin and that of the torque, where these differ."""
    near = np.maximum(radius - 0.5 * overlap, 0.0)
    return np.sqrt((near if law.surface_arm == "contact" else radius) * (near if law.torque_arm == "contact" else radius))

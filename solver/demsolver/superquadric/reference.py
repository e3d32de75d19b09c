"""Superquadrics in plain Python: every pair and plane, no neighbour list; forces as LIGGGHTS has them, and a step of motion.

Contact points are afresh in every step: no result depends on the one before, but for what the laws remember. Laws are those of spheres, called by
`demsolver.reference`, with volume-equivalent radii, the velocity of both surfaces at the contact point, and arms from the centres to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from demsolver import rotation
from demsolver.reference import Touch, action
from demsolver.rotation import Floats
from demsolver.scene import ContactLaw
from demsolver.shapes import superquadric
from demsolver.shapes.rotation import to_body
from demsolver.superquadric import Body, body, bounding_radius, pairs, planes

Key = tuple[str, int, int]
History = Mapping[Key, Floats]
"""Memory (m,) of the law of each contact, ("pair", i, j), i < j, as felt by i, or (name of the plane, 0, i)."""
_WALL = -1
"""Partner of a contact with a plane: its angular velocity counts as it is, not with the arm's ratio that spheres have there."""


@dataclass(frozen=True)
class Planes:
    """Planes at rest of one law: the point nearest to x is x with x[axis] = place."""

    name: str
    axis: int
    place: float
    law: ContactLaw


@dataclass(frozen=True)
class Shaped:
    """Bodies. x, v, angmom, omega: (n, 3) in space. quat: (n, 4) w x y z. shape, inertia: (n, 3) semi-axes, moments. blockiness: (n, 2)."""

    x: Floats
    v: Floats
    quat: Floats
    angmom: Floats
    omega: Floats
    shape: Floats
    blockiness: Floats
    mass: Floats
    inertia: Floats

    @property
    def radius(self) -> Floats:
        """(n,) of spheres of the same volume."""
        return superquadric.equivalent_radius(self.shape, self.blockiness)

    def bodies(self) -> list[Body]:
        """For the geometry."""
        return [body(*row) for row in zip(self.x, self.quat, self.shape, self.blockiness, strict=True)]


def forces(
    shaped: Shaped, law: ContactLaw, walls: tuple[Planes, ...], history: History, dt: float, advance: bool
) -> tuple[Floats, Floats, dict[Key, Floats]]:
    """Force (n, 3), torque (n, 3) and new history of all contacts. advance False: set-up, histories do not grow.

    Raises ValueError where the contact point of two bodies does not exist or is not found."""
    force, torque, new = np.zeros_like(shaped.x), np.zeros_like(shaped.x), {}
    for touch, p in _touches(shaped, law, walls):
        act = action(touch, history.get(touch.key), dt, advance)
        new[touch.key] = act.memory
        pull = act.normal * touch.n + act.tangential
        for row, sign in ((touch.i, 1.0), (touch.partner, -1.0)):
            if row is not None and row != _WALL:
                force[row] += sign * pull
                torque[row] += sign * (np.cross(p - shaped.x[row], pull) + act.rolling)
    return force, torque, new


def step(
    scheme: str, shaped: Shaped, force: Floats, torque: Floats, law: ContactLaw, walls: tuple[Planes, ...], history: History, dt: float,
    gravity: Floats,
) -> tuple[Shaped, Floats, Floats, dict[Key, Floats]]:  # fmt: skip
    """One step by velocity Verlet and a rotation scheme. force, torque: (n, 3) of the last step, without gravity (3,)."""
    turn = rotation.scheme(scheme)
    v = shaped.v + 0.5 * dt * (force / shaped.mass[:, None] + gravity)
    first = [turn.first(*map(tuple, row), dt) for row in zip(shaped.quat, shaped.angmom, shaped.omega, torque, shaped.inertia, strict=True)]
    quat, angmom, omega = (np.array(part) for part in zip(*first, strict=True))
    half = replace(shaped, x=shaped.x + dt * v, v=v, quat=quat, angmom=angmom, omega=omega)
    force, torque, new = forces(half, law, walls, history, dt, True)
    second = [turn.second(*map(tuple, row), dt) for row in zip(quat, angmom, omega, torque, shaped.inertia, strict=True)]
    angmom, omega = (np.array(part) for part in zip(*second, strict=True))
    v = v + 0.5 * dt * (force / shaped.mass[:, None] + gravity)
    return replace(half, v=v, angmom=angmom, omega=omega), force, torque, new


def _touches(shaped: Shaped, law: ContactLaw, walls: tuple[Planes, ...]) -> Iterator[tuple[Touch, Floats]]:
    """Contacts and their points."""
    found, radius = shaped.bodies(), shaped.radius
    bounds = bounding_radius(shaped.shape, shaped.blockiness)
    for i in range(len(found)):
        for j in range(i + 1, len(found)):
            if np.linalg.norm(shaped.x[i] - shaped.x[j]) < bounds[i] + bounds[j]:
                yield from _pair(shaped, law, found, radius, i, j)
    for wall in walls:
        for i, one in enumerate(found):
            yield from _wall(shaped, wall, one, float(radius[i]), i)


def _pair(shaped: Shaped, law: ContactLaw, found: list[Body], radius: Floats, i: int, j: int) -> Iterator[tuple[Touch, Floats]]:
    point, there, _ = pairs.afresh(found[i], found[j], pairs.POTENTIAL)
    if not there:
        message = f"bodies {i} and {j} have no point of equal potentials: they overlap too deeply"
        raise ValueError(message)
    overlap, normal = pairs.chord(point, found[i], found[j])
    if overlap <= 0.0:
        return
    p, n, (ri, rj), (mi, mj) = np.array(point), np.array(normal), radius[[i, j]], shaped.mass[[i, j]]
    v, w = _surface(shaped, i, p) - _surface(shaped, j, p), shaped.omega[i] - shaped.omega[j]
    inertia = 1.0 / (1.0 / _about_point(shaped, i, p, w) + 1.0 / _about_point(shaped, j, p, w))
    reff, meff = float(ri * rj / (ri + rj)), float(mi * mj / (mi + mj))
    yield Touch(("pair", i, j), law, (0, 0), i, j, n, overlap, reff, meff, v, np.zeros(3), w, float(ri), float(rj), inertia), p


def _wall(shaped: Shaped, wall: Planes, one: Body, radius: float, i: int) -> Iterator[tuple[Touch, Floats]]:
    foot = shaped.x[i].copy()
    foot[wall.axis] = wall.place
    overlap, point, normal = planes.touch((foot[0], foot[1], foot[2]), one)
    if overlap <= 0.0:
        return
    p, w, mass = np.array(point), shaped.omega[i], float(shaped.mass[i])
    inertia = _about_point(shaped, i, p, w)
    v = _surface(shaped, i, p)
    yield Touch((wall.name, 0, i), wall.law, 0, i, _WALL, np.array(normal), overlap, radius, mass, v, np.zeros(3), w, radius, np.inf, inertia), p


def _surface(shaped: Shaped, i: int, p: Floats) -> Floats:
    """Velocity of body i at p."""
    return np.asarray(shaped.v[i] + np.cross(shaped.omega[i], p - shaped.x[i]))


def _about_point(shaped: Shaped, i: int, p: Floats, w: Floats) -> float:
    """Moment of inertia of body i about the direction of the spin w, and its mass at the distance of p."""
    size = sqrt(float(w @ w))
    along = to_body(shaped.quat[i : i + 1], w[None] / size)[0] if size > 0.0 else np.array([0.0, 0.0, 1.0])
    return float(along**2 @ shaped.inertia[i] + shaped.mass[i] * np.sum((p - shaped.x[i]) ** 2))

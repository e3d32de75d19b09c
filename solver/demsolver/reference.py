"""Contact forces of a scene in plain Python and numpy: every pair, every wall, no neighbour list, no compiler.

Written to be read next to the laws: geometry here, physics in `demsolver/contact`, each law called with what its signature names.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demsolver import contact
from demsolver.scene import Box, ContactLaw, Cylinder, Freeze, Scene, Slab, Wall

Floats = NDArray[np.float64]
Key = tuple[str, int, int]
History = Mapping[Key, Floats]
"""Tangential memory (3,) of each contact: ("pair", i, j), i < j, as felt by i; (wall name, its number, i). Rows from 0."""

TOUCHING = 1e-200  # overlap offered to the laws at exactly zero gap, so that secant stiffnesses have their limit


@dataclass(frozen=True)
class Touch:
    """One contact as particle i feels it. n: (3,) unit normal towards i. v: (3,) velocity against the partner's centre or the
    wall. spin: (3,) sum of arm times omega. partner: row of the other particle, or None."""

    key: Key
    law: ContactLaw
    row: int | tuple[int, int]
    i: int
    partner: int | None
    n: Floats
    overlap: float
    reff: float
    meff: float
    v: Floats
    spin: Floats


def forces(
    scene: Scene, x: Floats, v: Floats, omega: Floats, history: History, advance: bool
) -> tuple[Floats, Floats, dict[Key, Floats]]:
    """Force (n, 3), torque (n, 3) and the new history of all contacts at x, v, omega, each (n, 3).

    advance False is the set-up of a run: histories are read but do not grow. The history of a parted wall contact ends; that
    of a parted pair too, unless the scene says that history outlives the contact.
    """
    force, torque = np.zeros_like(x), np.zeros_like(x)
    kept = dict(history) if scene.history_outlives_contact else {}
    new = {key: s for key, s in kept.items() if key[0] == "pair"}
    radius = scene.particles.radius
    for touch in _touches(scene, x, v, omega):
        fn, ft, new[touch.key] = _contact(touch, history.get(touch.key, np.zeros(3)), scene.timestep, advance)
        pull = fn * touch.n + ft
        turn = -np.cross(touch.n, ft)
        force[touch.i] += pull
        torque[touch.i] += _arm(touch.law.torque_arm, radius[touch.i], touch.overlap) * turn
        if touch.partner is not None:
            force[touch.partner] -= pull
            torque[touch.partner] += _arm(touch.law.torque_arm, radius[touch.partner], touch.overlap) * turn
    return force, torque, new


def _arm(kind: str, radius: float, overlap: float) -> float:
    return radius - 0.5 * overlap if kind == "contact" else radius


def _touches(scene: Scene, x: Floats, v: Floats, omega: Floats) -> Iterator[Touch]:
    if scene.pair is not None:
        for i in range(len(x)):
            for j in range(i + 1, len(x)):
                yield from _pair_touch(scene, scene.pair, i, j, x, v, omega)
    for number, wall in enumerate(scene.walls):
        for i in range(len(x)):
            if (scene.particles.mask[i] >> wall.bit) & 1:
                yield from _wall_touch(scene, wall, number, i, x, v, omega)


def _pair_touch(scene: Scene, law: ContactLaw, i: int, j: int, x: Floats, v: Floats, omega: Floats) -> Iterator[Touch]:
    p = scene.particles
    ri, rj = p.radius[i], p.radius[j]
    d = _nearest(scene.box, x[i] - x[j])
    square = float(d @ d)
    if square >= (ri + rj) ** 2:
        return
    overlap = ri + rj - sqrt(square)
    spin = _arm(law.surface_arm, ri, overlap) * omega[i] + _arm(law.surface_arm, rj, overlap) * omega[j]
    row = (int(p.type[i]) - 1, int(p.type[j]) - 1)
    reff, meff = ri * rj / (ri + rj), _pair_mass(scene, i, j)
    yield Touch(("pair", i, j), law, row, i, j, d / sqrt(square), overlap, reff, meff, v[i] - v[j], spin)


def _nearest(box: Box, d: Floats) -> Floats:
    size = box.hi - box.lo
    return np.where(box.periodic, d - size * np.round(d / size), d)


def _pair_mass(scene: Scene, i: int, j: int) -> float:
    mass, bits = scene.particles.mass, [f.bit for f in scene.forces if isinstance(f, Freeze)]
    frozen_i, frozen_j = (any((scene.particles.mask[k] >> bit) & 1 for bit in bits) for k in (i, j))
    if frozen_i or frozen_j:
        return float(mass[j] if frozen_i else mass[i])
    return float(mass[i] * mass[j] / (mass[i] + mass[j]))


def _wall_touch(scene: Scene, wall: Wall, number: int, i: int, x: Floats, v: Floats, omega: Floats) -> Iterator[Touch]:
    radius = float(scene.particles.radius[i])
    away = _slab(wall.shape, x[i]) if isinstance(wall.shape, Slab) else _cylinder(wall.shape, x[i])
    distance = sqrt(float(away @ away))
    if distance > radius or distance == 0.0 or (distance == radius and not wall.touch_closed):
        return
    overlap = max(radius - distance, TOUCHING)
    spin = _arm(wall.law.surface_arm, radius, overlap) * omega[i]
    reff, mass = _wall_radius(wall.shape, x[i], radius), float(scene.particles.mass[i])
    row = int(scene.particles.type[i]) - 1
    yield Touch(
        (wall.name, number, i), wall.law, row, i, None, away / distance, overlap, reff, mass, v[i] - np.array(wall.velocity), spin
    )


def _slab(slab: Slab, x: Floats) -> Floats:
    """Vector from the nearer plane to x."""
    away = np.zeros(3)
    low, high = x[slab.axis] - slab.lo, slab.hi - x[slab.axis]
    away[slab.axis] = low if low < high else -high
    return away


def _across(cylinder: Cylinder, x: Floats) -> tuple[list[int], Floats]:
    axes = [(cylinder.axis + 1) % 3, (cylinder.axis + 2) % 3]
    return axes, x[axes] - np.array(cylinder.center)


def _cylinder(cylinder: Cylinder, x: Floats) -> Floats:
    """Vector from the nearest point of the surface to x; towards the axis from inside."""
    axes, d = _across(cylinder, x)
    off = sqrt(float(d @ d))
    away = np.zeros(3)
    away[axes] = d * ((off - cylinder.radius) / off) if off > 0.0 else 0.0
    return away


def _wall_radius(shape: Slab | Cylinder, x: Floats, radius: float) -> float:
    if isinstance(shape, Slab) or shape.effective_radius == "flat":
        return radius
    _, d = _across(shape, x)
    rw = 2.0 * shape.radius * (-1.0 if float(d @ d) < shape.radius**2 else 1.0)
    return radius * rw / (radius + rw)


def _contact(touch: Touch, s: Floats, dt: float, advance: bool) -> tuple[float, Floats, Floats]:
    """Normal force, tangential force (3,) on particle i, and the new history (3,)."""
    law, n = touch.law, touch.n
    vn = float(touch.v @ n)
    vt = touch.v - vn * n - np.cross(touch.spin, n)
    known: dict[str, Any] = {name: float(table[touch.row]) for name, table in law.coefficients.items()}
    known |= dict(zip(("nx", "ny", "nz", "vtx", "vty", "vtz", "sx", "sy", "sz"), map(float, (*n, *vt, *s)), strict=True))
    known |= {"overlap": touch.overlap, "reff": touch.reff, "meff": touch.meff, "vn": vn, "dt": dt, "advance": advance}
    known["contact_radius"] = sqrt(touch.reff * touch.overlap)
    known["normal_elastic"] = _call(_law("normal", law.normal).force, known)
    known["stiffness"] = known["normal_elastic"] / touch.overlap
    known["gn"] = _call(_law("damping", law.damping).coefficient, known)
    fn = known["normal_elastic"] - known["gn"] * vn
    known["normal_force"] = max(fn, 0.0) if law.limit_damping else fn
    if law.friction == "none":
        return known["normal_force"], np.zeros(3), s
    known["kt"] = _call(_law("tangential_stiffness", law.tangential_stiffness).stiffness, known)
    known["gt"] = _call(_law("tangential_damping", law.tangential_damping).coefficient, known)
    result = _call(_law("friction", law.friction).force, known)
    return known["normal_force"], np.array(result[:3]), np.array(result[3:])


def _call(law: Callable[..., Any], known: Mapping[str, Any]) -> Any:
    return law(*(known[name] for name in _parameters(law)))


@cache
def _parameters(law: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(inspect.signature(law).parameters)


_law = cache(contact.law)

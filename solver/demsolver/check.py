"""Is a scene made by hand one that can run? What is wrong is refused with its name, its value and what is allowed."""

from __future__ import annotations

from itertools import chain
from math import inf

import numpy as np

from demsolver import contact
from demsolver.bind_law import check_law, in_use, law_coefficients
from demsolver.check_bodies import check_bodies
from demsolver.expression import check_expression
from demsolver.scene import AddForce, ContactLaw, Cylinder, Plane, Scene, Slab
from demsolver.state import Floats

RANGES: dict[str, tuple[float, float]] = {"log_restitution": (-inf, 0.0), "restitution": (0.0, 1.0)}
"""Coefficient -> what is allowed, both ends included; any other must be at least 0. A law that differs from both says so in RANGES of its own."""


def check_scene(scene: Scene) -> None:
    """Raises ValueError for a scene that cannot run as it is meant: shapes, types, masses, laws and their coefficients, walls, the step."""
    _within("timestep", scene.timestep, 0.0, inf, open_below=True)
    _within("ntypes", scene.ntypes, 1, inf)
    if not (np.asarray(scene.box.hi) > np.asarray(scene.box.lo)).all():
        message = f"box hi must be above lo on every axis, got lo {list(scene.box.lo)} and hi {list(scene.box.hi)}"
        raise ValueError(message)
    _check_particles(scene)
    check_bodies(scene)
    if scene.pair is not None:
        check_coefficients(scene.pair, (scene.ntypes, scene.ntypes), "pair law")
    for wall in scene.walls:
        check_coefficients(wall.law, (scene.ntypes,), f"wall {wall.name}")
        _check_shape(wall.shape, f"wall {wall.name}")
    for field in scene.forces:
        for expression in field.force if isinstance(field, AddForce) else ():
            check_expression(expression)
    _within("skin", scene.neighbor.skin, 0.0, inf)


_PARTICLES = {
    "id": (1, inf, False), "type": (1, inf, False), "x": (-inf, inf, False), "v": (-inf, inf, False), "omega": (-inf, inf, False),
    "radius": (0.0, inf, False), "mass": (0.0, inf, True), "mask": (-inf, inf, False), "image": (-inf, inf, False),
}  # fmt: skip
"""Array -> lowest and highest value, and whether the lowest itself is too low."""
_VECTORS = ("x", "v", "omega", "image")


def _check_particles(scene: Scene) -> None:
    p = scene.particles
    n = len(p.id)
    for name, (low, high, open_below) in _PARTICLES.items():
        values = np.asarray(getattr(p, name))
        shape = (n, 3) if name in _VECTORS else (n,)
        if values.shape != shape:
            message = f"{name} must have the shape {shape}, as there are {n} ids, got {values.shape}"
            raise ValueError(message)
        high = scene.ntypes if name == "type" else high
        wrong = np.argwhere(_outside(values, low, high, open_below=open_below))
        if len(wrong):
            _refuse(f"{name} of particle {p.id[wrong[0][0]]}", float(values[tuple(wrong[0])]), low, high, open_below)
    ids, counts = np.unique(p.id, return_counts=True)
    if len(ids) < n:
        message = f"id {ids[counts > 1][0]} is given to {counts[counts > 1][0]} particles, expected one id each"
        raise ValueError(message)


def check_coefficients(law: ContactLaw, shape: tuple[int, ...], where: str) -> None:
    """Raises ValueError for an unknown law, laws that do not go together, and a coefficient that is missing, of another shape, not symmetric or
    out of its range. shape: (ntypes, ntypes) for a pair, (ntypes,) for a wall."""
    check_law(law)
    for name in law_coefficients(law):
        if name not in law.coefficients:
            message = f"{where}: coefficient {name!r} is missing; given: {', '.join(law.coefficients) or 'none'}"
            raise ValueError(message)
        table = np.asarray(law.coefficients[name], dtype=float)
        if table.shape != shape:
            message = f"{where}: coefficient {name!r} must have the shape {shape}, got {table.shape}"
            raise ValueError(message)
        low, high = _ranges(law).get(name, (0.0, inf))
        wrong = _outside(table, low, high)
        if wrong.any():
            _refuse(f"{where}: {name}", float(table[wrong][0]), low, high)
        if table.ndim == 2 and (table != table.T).any():
            i, j = np.argwhere(table != table.T)[0]
            message = f"{where}: {name} must be symmetric: {i + 1} {j + 1} has {table[i, j]:g}, {j + 1} {i + 1} has {table[j, i]:g}"
            raise ValueError(message)


def _ranges(law: ContactLaw) -> dict[str, tuple[float, float]]:
    own = (getattr(contact.law(family, getattr(law, family)), "RANGES", {}).items() for family in in_use(law))
    return {**RANGES, **dict(chain.from_iterable(own))}


def _check_shape(shape: Slab | Cylinder | Plane, where: str) -> None:
    if isinstance(shape, Plane):
        numbers = [*shape.normal, shape.offset, *shape.velocity, *shape.omega, *shape.pivot]
        if not any(shape.normal) or not np.isfinite(numbers).all():
            message = f"{where}: normal must not be zero and all numbers finite, got {shape}"
            raise ValueError(message)
        return
    _within(f"{where}: axis", shape.axis, 0, 2)
    if isinstance(shape, Cylinder):
        _within(f"{where}: radius", shape.radius, 0.0, inf, open_below=True)
        if shape.rotation:
            _within(f"{where}: rate", shape.rotation.rate, -inf, inf)
    elif not shape.lo < shape.hi:
        message = f"{where}: lo must be below hi, got {shape.lo:g} and {shape.hi:g}"
        raise ValueError(message)


def _outside(values: Floats, low: float, high: float, *, open_below: bool = False) -> np.ndarray:
    return np.asarray(~np.isfinite(values) | (values < low) | (values > high) | (open_below & (values == low)))


def _within(name: str, value: float, low: float, high: float, *, open_below: bool = False) -> None:
    if _outside(np.array(float(value)), low, high, open_below=open_below):
        _refuse(name, value, low, high, open_below)


def _refuse(name: str, value: float, low: float, high: float, open_below: bool = False) -> None:
    bounds = [f"{'above' if open_below else 'at least'} {low:g}"] * (low > -inf) + [f"at most {high:g}"] * (high < inf)
    message = f"{name} must be {' and '.join(bounds) or 'a finite number'}, got {value:g}"
    raise ValueError(message)

"""The columns a dump can ask for, made from the arrays of the native solver with the arithmetic of LAMMPS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import Box, Particles, Superquadrics
from demsolver.shapes import superquadric
from demverify.errors import InputError, Place
from demverify.frames import Frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

INTEGER_COLUMNS = frozenset({"id", "mol", "id_multisphere", "type", "ix", "iy", "iz"})


@dataclass(frozen=True)
class Snapshot:
    """Every particle at one step, as the native solver holds it. force, torque: (n, 3). molecule: (n,). dimension: 2 or 3."""

    step: int
    box: Box
    particles: Particles
    force: Floats
    torque: Floats
    molecule: Ints
    dimension: int = 3


def _vector(prefix: str, get: Callable[[Snapshot], NDArray[np.generic]]) -> dict[str, Callable[[Snapshot], NDArray[np.generic]]]:
    return {prefix + axis: (lambda s, i=i: get(s)[:, i]) for i, axis in enumerate("xyz")}  # type: ignore[misc]


def _scaled(i: int) -> Callable[[Snapshot], Floats]:
    return lambda s: (s.particles.x[:, i] - s.box.lo[i]) * (1.0 / (s.box.hi[i] - s.box.lo[i]))


def _unwrapped(i: int) -> Callable[[Snapshot], Floats]:
    return lambda s: s.particles.x[:, i] + s.particles.image[:, i] * (s.box.hi[i] - s.box.lo[i])


def volume(radius: Floats, dimension: int = 3) -> Floats:
    """Volume of a sphere, 4/3 pi R^3, or area of a disc, pi R^2, (n,); rounded as both engines round it."""
    return np.pi * radius * radius if dimension == 2 else 4.0 * np.pi / 3.0 * radius * radius * radius


def _volume(s: Snapshot) -> Floats:
    shapes, found = s.particles.superquadrics, volume(s.particles.radius, s.dimension)
    if shapes is not None:
        shaped = shapes.axes[:, 0] > 0.0
        found[shaped] = superquadric.volume(shapes.axes[shaped], shapes.blockiness[shaped])
    return found


def _shapes(s: Snapshot) -> Superquadrics:
    assert s.particles.superquadrics is not None
    return s.particles.superquadrics


SHAPE_COLUMNS: dict[str, Callable[[Snapshot], NDArray[np.generic]]] = {
    **_vector("shape", lambda s: _shapes(s).axes),
    **{f"quat{k + 1}": (lambda s, k=k: _shapes(s).quat[:, k]) for k in range(4)},  # type: ignore[misc]
    **{f"{word}{k + 1}": (lambda s, k=k: _shapes(s).blockiness[:, k]) for word in ("blockiness", "roundness") for k in range(2)},  # type: ignore[misc]
    **_vector("angmom", lambda s: _shapes(s).angmom),
    **_vector("inertia", lambda s: _shapes(s).inertia),
}
COLUMNS: dict[str, Callable[[Snapshot], NDArray[np.generic]]] = {
    "id": lambda s: s.particles.id,
    "mol": lambda s: s.molecule,
    "type": lambda s: s.particles.type,
    "mass": lambda s: s.particles.mass,
    "radius": lambda s: s.particles.radius,
    "diameter": lambda s: 2.0 * s.particles.radius,
    "density": lambda s: s.particles.mass / _volume(s),
    **_vector("", lambda s: s.particles.x),
    **{axis + "s": _scaled(i) for i, axis in enumerate("xyz")},
    **{axis + "u": _unwrapped(i) for i, axis in enumerate("xyz")},
    **_vector("i", lambda s: s.particles.image),
    **_vector("v", lambda s: s.particles.v),
    **_vector("f", lambda s: s.force),
    **_vector("omega", lambda s: s.particles.omega),
    **_vector("tq", lambda s: s.torque),
}
"""Column name -> (n,) array, of particles of any shape."""


CLUMP_COLUMNS: dict[str, Callable[[Snapshot], NDArray[np.generic]]] = {
    "id_multisphere": lambda s: np.where(s.particles.clumps.body >= 0, s.molecule, -1) if s.particles.clumps else np.full(len(s.molecule), -1),
}


def columns_of(*, superquadrics: bool, clumps: bool) -> dict[str, Callable[[Snapshot], NDArray[np.generic]]]:
    """Those that there are. Of shapes and of clumps where these are alone: spheres carry omega, and both engines refuse angmom for them too."""
    return COLUMNS | (SHAPE_COLUMNS if superquadrics else {}) | (CLUMP_COLUMNS if clumps else {})


def snapshot_frame(snapshot: Snapshot, names: Sequence[str], place: Place | None = None) -> Frame:
    """The named columns of a snapshot, float64, rows sorted by id. Raises InputError for a name that is none."""
    p = snapshot.particles
    known = columns_of(superquadrics=p.superquadrics is not None, clumps=p.clumps is not None)
    for name in names:
        if name not in known:
            message = f"dump column {name!r} is not one of {' '.join(known)}"
            raise InputError(message, place)
    order = np.argsort(snapshot.particles.id, kind="stable")
    columns = {name: known[name](snapshot)[order].astype(np.float64) for name in names}
    box = np.column_stack([snapshot.box.lo, snapshot.box.hi]).astype(np.float64)
    return Frame(snapshot.step, box, snapshot.box.boundary, columns)

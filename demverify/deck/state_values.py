"""Values of formulas that follow from the state of a deck alone: box, counts, masses, centres, one particle's columns."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from demverify.deck.particles import center, members, no_atoms, velocity_of_center
from demverify.deck.setup import Floats, Ints, Setup
from demverify.errors import InputError

_FUNCTION = re.compile(r"(\w+)\(([^()]*)\)")
_PARTICLE = re.compile(r"(\w+)\[(\d+)\]")
_STILL = ("step", "dt", "time", "atoms", "vol", "lx", "ly", "lz", "xlo", "xhi", "ylo", "yhi", "zlo", "zhi")
_GROUP_VALUES = ("count", "mass", "ke", "xcm", "vcm", "bound")
_FACES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")


def moves(keyword: str) -> bool:
    """Whether a run may change the value in a way that only the run knows."""
    return keyword not in _STILL and not re.match(r"(count|mass)\(|(mass|type|id)\[", keyword)


def of_particles(keyword: str) -> bool:
    """Whether the value is a particle's column or a group function, which the state tells after a run as before it."""
    found = _PARTICLE.fullmatch(keyword) or _FUNCTION.fullmatch(keyword)
    return bool(found) and found[1] in (*_COLUMNS, *_GROUP_VALUES)  # type: ignore[index]


def state_value(setup: Setup, keyword: str) -> float | None:
    """The value of a thermo keyword, a group function or a particle's column, or None when the state alone does not tell.

    Raises InputError for a group or a particle that does not exist, and when there is no box yet."""
    if setup.box is None and keyword != "dt":
        raise InputError(f"{keyword} has no value before there is a simulation box")
    if found := _FUNCTION.fullmatch(keyword):
        return _group_value(setup, found[1], found[2].split(","))
    if (found := _PARTICLE.fullmatch(keyword)) and found[1] in _COLUMNS:
        return _particle_value(setup, found[1], int(found[2]))
    return float(_KEYWORDS[keyword](setup)) if keyword in _KEYWORDS else None


def _length(axis: int) -> Callable[[Setup], float]:
    return lambda setup: setup.box.hi[axis] - setup.box.lo[axis] if setup.box else 0.0


def _face(axis: int, side: str) -> Callable[[Setup], float]:
    return lambda setup: float(getattr(setup.box, side)[axis])


def _volume(setup: Setup) -> float:
    edges = [_length(axis)(setup) for axis in range(setup.dimension)]
    return float(np.prod(edges))


_KEYWORDS: dict[str, Callable[[Setup], float]] = {
    "step": lambda setup: setup.step,
    "dt": lambda setup: setup.dt,
    "time": lambda setup: setup.time,
    "atoms": lambda setup: setup.atoms.n if setup.atoms else 0,
    "vol": _volume,
    **{f"l{axis}": _length(k) for k, axis in enumerate("xyz")},
    **{f"{axis}{side}": _face(k, side) for k, axis in enumerate("xyz") for side in ("lo", "hi")},
}

KEYWORDS = tuple(_KEYWORDS)
"""Thermo keywords whose value follows from the state of the deck."""

_COLUMNS: dict[str, Callable[[Setup], Floats | Ints]] = {
    "id": lambda setup: setup.atoms.id,  # type: ignore[union-attr]
    "type": lambda setup: setup.atoms.type,  # type: ignore[union-attr]
    "mass": lambda setup: setup.atoms.mass,  # type: ignore[union-attr]
    **{axis: (lambda setup, k=k: setup.atoms.x[:, k]) for k, axis in enumerate("xyz")},  # type: ignore[misc]
    **{f"v{axis}": (lambda setup, k=k: setup.atoms.v[:, k]) for k, axis in enumerate("xyz")},  # type: ignore[misc]
    **{f"omega{axis}": (lambda setup, k=k: setup.atoms.omega[:, k]) for k, axis in enumerate("xyz")},  # type: ignore[misc]
}


def _particle_value(setup: Setup, column: str, identity: int) -> float:
    rows = np.flatnonzero(setup.atoms.id == identity) if setup.atoms else np.zeros(0, dtype=np.int64)
    if not len(rows):
        raise InputError(f"{column}[{identity}]: there is no particle {identity}")
    return float(_COLUMNS[column](setup)[rows[0]])


def _group_value(setup: Setup, name: str, args: list[str]) -> float | None:
    group, *rest = args
    if group not in setup.groups:
        raise InputError(f"{name}({group}): group {group!r} is not one of {', '.join(setup.groups)}")
    atoms, rows = setup.atoms or no_atoms(), members(setup, group)
    if name in ("count", "mass", "ke") and not rest:
        if name == "count":
            return float(len(rows))
        mass = atoms.mass[rows]
        return float(mass.sum() if name == "mass" else 0.5 * (mass * (atoms.v[rows] ** 2).sum(axis=1)).sum())
    if name in ("xcm", "vcm") and len(rest) == 1 and rest[0] in "xyz":
        assert setup.box is not None
        vector = velocity_of_center(atoms, rows) if name == "vcm" else center(atoms, rows, setup.box)
        return float(vector["xyz".index(rest[0])])
    if name == "bound" and len(rest) == 1 and rest[0] in _FACES and len(rows):
        axis, side = divmod(_FACES.index(rest[0]), 2)
        return float(atoms.x[rows, axis].max() if side else atoms.x[rows, axis].min())
    return None

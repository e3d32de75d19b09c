"""Which densities the particles of a data file have: its section Atoms read line by line, whatever else the file holds."""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import IO

from demverify.errors import InputError, Place
from demverify.formats.reading import opened

_COLUMNS = {  # of the section Atoms, up to the last one that matters here
    "sphere": ("id", "type", "diameter", "density"),
    "granular": ("id", "type", "diameter", "density"),
    "bpm/sphere": ("id", "mol", "type", "diameter", "density"),
    "ellipsoid": ("id", "type", "diameter", "density"),  # a flag, 0 for points, stands where spheres have the diameter
    "superquadric": ("id", "type", "density"),
}
_HYBRID = {  # what a style adds behind id type x y z
    "sphere": ("diameter", "density"),
    "granular": ("diameter", "density"),
    "bpm/sphere": ("mol", "diameter", "density"),
    "ellipsoid": ("diameter", "density"),
    "molecular": ("mol",),
    "bond": ("mol",),
    "angle": ("mol",),
    "charge": ("q",),
    "full": ("mol", "q"),
    "atomic": (),
}
_ZEROS = (b"0", b"0.0", b"0.", b"0.000000")  # of points; as a density their column holds a mass
_MOST_KNOWN = 100_000  # pairs of type and density that are remembered, so that only new ones are looked at
_ENOUGH = 2  # densities of one type; more say no more


@dataclass
class DataDensities:
    """types: number of particle types, 0 if the header does not tell. values: type -> its densities, at most two of them."""

    types: int = 0
    values: dict[int, set[float]] = field(default_factory=dict)


def has_density(atom_style: Sequence[str]) -> bool:
    """Whether particles of an atom style (with its arguments) have a density of their own."""
    styles = atom_style[1:] if atom_style[:1] == ("hybrid",) else atom_style[:1]
    return any("density" in _COLUMNS.get(style, ()) for style in styles)


def data_densities(path: Path, atom_style: Sequence[str]) -> DataDensities:
    """The densities that a data file gives to particles of finite size. Packed files are read too.

    Raises InputError for a file that cannot be read, or whose columns are not known for this atom style.
    """
    try:
        with opened(path) as stream:
            return _read(stream, path, _columns(atom_style, Place(path)))
    except (OSError, EOFError, zlib.error) as error:
        message = f"cannot be read: {error}"
        raise InputError(message, Place(path)) from None


def _columns(atom_style: Sequence[str], place: Place) -> tuple[str, ...]:
    if atom_style[:1] != ("hybrid",):
        return _COLUMNS[atom_style[0]]
    names = ["id", "type", "x", "y", "z"]
    for style in atom_style[1:]:
        if style not in _HYBRID:
            message = f"the columns of atom_style {' '.join(atom_style)} are not known"
            raise InputError(message, place)
        names += [name for name in _HYBRID[style] if name not in names]
    return tuple(names)


def _read(stream: IO[bytes], path: Path, columns: tuple[str, ...]) -> DataDensities:
    found = DataDensities()
    type_, density, size = (columns.index(name) if name in columns else 0 for name in ("type", "density", "diameter"))
    known: set[tuple[bytes, bytes]] = set()
    inside = False
    next(stream, b"")
    for number, line in enumerate(stream, start=2):
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        if words[0][:1].isalpha():
            inside = words[0] == b"Atoms"
        elif not inside:
            header = re.match(rb"\s*(\d{1,9})\s+atom\s+types\b", line)
            found.types = int(header[1]) if header else found.types
        elif len(words) < len(columns):
            raise _row_error(words, columns, Place(path, number))
        elif (words[type_], words[density]) not in known and words[size] not in _ZEROS:
            if not _add(found, words[type_], words[density]):
                raise _row_error(words, columns, Place(path, number))
            if len(known) < _MOST_KNOWN:
                known.add((words[type_], words[density]))
    return found


def _add(found: DataDensities, type_: bytes, density: bytes) -> bool:
    """Notes the density of a type. False if one of the words is not what it should be."""
    try:
        kind, value = int(type_), float(density)
    except ValueError:
        return False
    values = found.values.setdefault(kind, set())
    if len(values) < _ENOUGH:
        values.add(value)
    return kind >= 1 and isfinite(value)


def _row_error(words: list[bytes], columns: tuple[str, ...], place: Place) -> InputError:
    return InputError(f"expected {' '.join(columns)}, got {b' '.join(words[:8]).decode('ascii', 'replace')!r}", place)

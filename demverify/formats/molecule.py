"""The spheres of a clump as LAMMPS' `molecule ID FILE scale X` reads them.

The first line is a title and is skipped. Header lines follow, numbers before their word: `N atoms`, `M mass`, `X Y Z com`,
`Ixx Iyy Izz Ixy Ixz Iyz inertia`, counts of bonds and the like. Then sections in any order: a line with the name, a blank line, one line an
atom, `ID values`, the IDs 1 to N in any order. `#` starts a comment. Coords and Types must be there; without Diameters every diameter is 1,
without Masses every density is 1 (not touched by `scale`: measured). Sections that a rigid clump of spheres does not need are passed over.

What LAMMPS does with it (measured): `create_atoms 0 single x y z mol ID SEED rotate angle ax ay az` puts atom i at (x y z) + Q (coords_i - mean
of coords), where the mean is that of the centres, not weighted by mass; `fix rigid/small` finds mass, centre of mass and inertia from the atoms
and ignores the header's. Source: LAMMPS doc/src/molecule.rst, src/molecule.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demverify.errors import InputError, Place
from demverify.formats.text import whole_text
from demverify.formats.words import number
from demverify.frames import Floats

_COUNTS = ("atoms", "bonds", "angles", "dihedrals", "impropers", "fragments")
_NUMBERS = {"mass": 1, "com": 3, "inertia": 6}
_ATOM_SECTIONS = {"Coords": "x y z", "Types": "type", "Molecules": "molecule", "Diameters": "diameter", "Masses": "mass"}
_PASSED = {
    "Charges": "atoms",
    "Dipoles": "atoms",
    "Bonds": "bonds",
    "Angles": "angles",
    "Dihedrals": "dihedrals",
    "Impropers": "impropers",
    "Fragments": "fragments",
    "Special Bond Counts": "atoms",
    "Special Bonds": "atoms",
    "Shake Flags": "atoms",
    "Shake Atoms": "atoms",
    "Shake Bond Types": "atoms",
}
"""Sections without a meaning for rigid spheres, and the count of the header that tells their lines."""


@dataclass(frozen=True)
class Molecule:
    """The spheres of a molecule file in the order of their IDs, and what its header states of the whole.

    centre: (k, 3). radius, mass, type, molecule: (k,); molecule None: not in the file. total, com (3,), inertia (3, 3) about the centre of mass,
    along the axes of the file: None where the header does not state it.
    """

    centre: Floats
    radius: Floats
    mass: Floats
    type: NDArray[np.int64]
    molecule: NDArray[np.int64] | None = None
    total: float | None = None
    com: Floats | None = None
    inertia: Floats | None = None


def read_molecule(path: Path, scale: float = 1.0) -> Molecule:
    """The molecule in a file, as the keyword `scale` makes it: lengths times scale, masses its cube, moments of inertia its fifth power.

    Raises InputError with file and line: no count of atoms, a section that is missing, there twice, too short, or of another name, a line that
    is not as its section wants it, an ID twice or not from 1 to N, a diameter or mass that is not above zero; and a line of comment between
    sections, where LAMMPS stops without a word (measured).
    """
    if not (scale > 0.0 and math.isfinite(scale)):
        message = f"expected a scale above zero, got {scale:g}"
        raise InputError(message, Place(path))
    file = _File(path)
    header = _header(file)
    k = int(header["atoms"][0])
    sections = _sections(file, header)
    for name in ("Coords", "Types"):
        if name not in sections:
            message = f"expected a section {name}, got {', '.join(sections) or 'no section'}"
            raise InputError(message, Place(path))
    radius = 0.5 * scale * sections["Diameters"][:, 0] if "Diameters" in sections else np.full(k, 0.5)
    mass = scale**3 * sections["Masses"][:, 0] if "Masses" in sections else 4.0 / 3.0 * np.pi * radius**3
    whole: dict[str, Any] = {}
    if "mass" in header:
        whole["total"] = scale**3 * header["mass"][0]
    if "com" in header:
        whole["com"] = scale * np.array(header["com"])
    if "inertia" in header:
        xx, yy, zz, xy, xz, yz = header["inertia"]
        whole["inertia"] = scale**5 * np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if "Molecules" in sections:
        whole["molecule"] = sections["Molecules"][:, 0].astype(np.int64)
    return Molecule(scale * sections["Coords"], radius, mass, sections["Types"][:, 0].astype(np.int64), **whole)


class _File:
    """The lines of a molecule file, without comments, one after the other."""

    def __init__(self, path: Path) -> None:
        self.path = path
        text = whole_text(path, "a molecule file, which is text")
        self.lines = [line.partition("#")[0].split() for line in text.splitlines()]
        self._comments = {at for at, line in enumerate(text.splitlines(), 1) if line.lstrip().startswith("#")}
        self.at = 1

    def next(self) -> list[str] | None:
        """The words of the next line, none in an empty one; None at the end."""
        if self.at >= len(self.lines):
            return None
        self.at += 1
        return self.lines[self.at - 1]

    def stops(self) -> bool:
        """Between sections LAMMPS takes a line of comment alone for the end of the file: is something lost?"""
        return self.at in self._comments and any(self.lines[self.at :])

    def place(self) -> Place:
        """Of the line that `next` gave last."""
        return Place(self.path, min(self.at, len(self.lines)))

    def error(self, message: str) -> InputError:
        """What is wrong with that line."""
        return InputError(message, self.place())


def _header(file: _File) -> dict[str, list[float]]:
    """Numbers by their word; the file stands before the name of the first section."""
    header: dict[str, list[float]] = {}
    while (words := file.next()) is not None:
        if not words:
            continue
        if not _is_number(words[0]):
            file.at -= 1
            break
        word, wanted = words[-1], 1 if words[-1] in _COUNTS else _NUMBERS.get(words[-1])
        shown = " ".join(words[:8])
        if wanted is None:
            raise file.error(f"expected a header line that ends with {', '.join((*_COUNTS, *_NUMBERS))}, or the name of a section, got {shown!r}")
        if len(words) != wanted + 1 or not all(map(_is_number, words[:-1])):
            raise file.error(f"expected {wanted} number{'s' * (wanted > 1)} before {word}, got {shown!r}")
        if word in _COUNTS and not _is_count(words[0]):
            raise file.error(f"expected a whole number before {word}, got {words[0]!r}")
        header[word] = [float(one) for one in words[:-1]]
    if header.get("atoms", [0.0])[0] < 1.0:
        message = "expected a header line `N atoms` with N of 1 or more after the first line, which is a title"
        raise InputError(message, Place(file.path))
    return header


def _sections(file: _File, header: dict[str, list[float]]) -> dict[str, Floats]:
    """The table of each section, in the order of the IDs."""
    found: dict[str, Floats] = {}
    passed: set[str] = set()
    while (words := file.next()) is not None:
        if (found or passed) and file.stops():
            raise file.error("a line of comment between sections: LAMMPS reads nothing after it; expected a blank line, or the name of a section")
        if not words:
            continue
        name = " ".join(words)
        if name in found or name in passed:
            raise file.error(f"a second section {name}")
        if name not in _ATOM_SECTIONS and name not in _PASSED:
            raise file.error(f"expected the name of a section ({', '.join(_ATOM_SECTIONS)} or another of LAMMPS), got {name[:60]!r}")
        start = file.place()
        if file.next():
            raise file.error(f"expected a blank line after {name}, which LAMMPS skips, got {' '.join(file.lines[file.at - 1][:8])!r}")
        if name in _ATOM_SECTIONS:
            found[name] = _table(file, name, int(header["atoms"][0]), start)
        else:
            passed.add(name)
            for _ in range(int(header.get(_PASSED[name], [0.0])[0])):
                if not file.next():
                    raise _short(file, name, int(header[_PASSED[name]][0]), start)
    return found


def _short(file: _File, name: str, count: int, start: Place) -> InputError:
    """After fewer lines than `count` an empty one came, or the end of the file."""
    got = "the end of the file" if file.at >= len(file.lines) else file.at - start.line - 2
    return InputError(f"expected {count} line{'s' * (count > 1)} of {name}, got {got}", start)


def _table(file: _File, name: str, k: int, start: Place) -> Floats:
    """`ID values` for every ID from 1 to k."""
    columns = _ATOM_SECTIONS[name].split()
    table = np.full((k, len(columns)), np.nan)
    for _ in range(k):
        words = file.next()
        if not words:
            raise _short(file, name, k, start)
        shown = " ".join(words[:8])
        if len(words) != len(columns) + 1 or not _is_count(words[0]) or not all(map(_is_number, words[1:])):
            raise file.error(f"expected ID {_ATOM_SECTIONS[name]} in {name}, got {shown!r}")
        row = int(words[0]) - 1
        if not 0 <= row < k:
            raise file.error(f"expected an ID from 1 to {k} in {name}, got {words[0]}")
        if not np.isnan(table[row, 0]):
            raise file.error(f"ID {words[0]} a second time in {name}")
        values = [float(word) for word in words[1:]]
        says, allowed = _RULES.get(name, ("", None))
        if allowed is not None and not allowed(values[0]):
            raise file.error(f"expected {says} in {name}, got {words[1]}")
        table[row] = values
    return table


def _is_number(word: str) -> bool:
    try:
        return math.isfinite(number(word.encode()))
    except ValueError:
        return False


def _is_count(word: str) -> bool:
    return word.isascii() and word.isdigit()


def _whole(least: int) -> Callable[[float], bool]:
    return lambda value: value >= least and value == int(value)


_RULES: dict[str, tuple[str, Callable[[float], bool]]] = {
    "Types": ("a whole number of 1 or more", _whole(1)),
    "Molecules": ("a whole number of 0 or more", _whole(0)),
    "Diameters": ("a diameter above zero", lambda value: value > 0.0),
    "Masses": ("a mass above zero", lambda value: value > 0.0),
}

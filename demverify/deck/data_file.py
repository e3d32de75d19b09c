"""Data files: `Atoms` of style sphere and `Velocities`, plain or gzipped, each complaint with its line."""

from __future__ import annotations

import gzip
import re
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from demverify.deck.lexer import decode
from demverify.deck.particles import density_mass, new_atoms, wrap
from demverify.deck.setup import Atoms, Floats, Setup
from demverify.errors import InputError, Place

_MOST = 2**31 - 1  # particles and ids of an engine built as both are here
_EDGE = 1e-6  # share of an open box by which LAMMPS lets particles of a data file stick out
_BOUNDS = re.compile(r"(\S+)\s+(\S+)\s+([xyz])lo\s+\3hi")
_COUNT = re.compile(r"(\S+)\s+(atoms|atom types|(?:bond|angle|dihedral|improper)(?:s| types)|ellipsoids|lines|triangles|bodies)")
_SECTION = re.compile(r"[A-Z][A-Za-z]*( Coeffs)?")
_ATOM_COLUMNS = "id type diameter density x y z [ix iy iz]"
_VELOCITY_COLUMNS = "id vx vy vz wx wy wz"


@dataclass
class DataFile:
    """What a data file says. rows: section -> (line number, words) of each row. lo, hi: (3,)."""

    path: Path
    atoms: int = 0
    ntypes: int = 0
    lo: Floats = field(default_factory=lambda: np.full(3, -0.5))  # LAMMPS' own defaults
    hi: Floats = field(default_factory=lambda: np.full(3, 0.5))
    rows: dict[str, list[tuple[int, list[str]]]] = field(default_factory=dict)


def read_data_file(path: Path) -> DataFile:
    """Header and rows of a data file. Raises InputError with file and line."""
    data = DataFile(path)
    section = None
    for number, line in enumerate(_lines(path), start=1):
        words = line.split()
        if number == 1 or not words:
            continue
        if words[0][0].isalpha():
            section = _section(data, line, Place(path, number))
        elif section is None:
            _header(data, " ".join(words), Place(path, number))
        else:
            data.rows[section].append((number, words))
    return data


def _lines(path: Path) -> list[str]:
    try:
        raw = path.read_bytes()
        text = decode(gzip.decompress(raw) if raw[:2] == b"\x1f\x8b" else raw, path)
    except (OSError, EOFError) as error:
        raise InputError(f"cannot read the data file: {error}", Place(path)) from None
    lines = text.splitlines()
    if len(lines) < 2:
        raise InputError("the data file is empty", Place(path))
    return [line if line.lstrip()[:1].isalpha() else line.partition("#")[0] for line in lines]


def _header(data: DataFile, line: str, place: Place) -> None:
    if found := _BOUNDS.fullmatch(line):
        axis = "xyz".index(found[3])
        data.lo[axis] = _number(found[1], f"{found[3]}lo", place)
        data.hi[axis] = _number(found[2], f"{found[3]}hi", place)
    elif found := _COUNT.fullmatch(line):
        count = _whole(found[1], f"the number of {found[2]}", place)
        if found[2] == "atoms":
            data.atoms = count
        elif found[2] == "atom types":
            data.ntypes = count
        elif count:
            raise InputError(f"{found[2]} are not supported: expected spheres only", place)
    else:
        raise InputError(f"expected a header line such as '10 atoms' or '0 1 xlo xhi', or a section, got {line!r}", place)


def _section(data: DataFile, line: str, place: Place) -> str:
    name, _, hint = (part.strip() for part in line.partition("#"))
    if name not in ("Atoms", "Velocities"):
        raise InputError(f"section {name!r} is not supported; supported: Atoms, Velocities", place)
    if name == "Atoms" and hint not in ("", "sphere", "granular"):
        raise InputError(f"expected Atoms of style sphere, got style {hint!r}", place)
    if name in data.rows:
        raise InputError(f"a second section {name}", place)
    data.rows[name] = []
    return name


def particles_of(data: DataFile, setup: Setup) -> Atoms:
    """The particles, wrapped into the periodic box, in the order of the file. Raises InputError with the line that is wrong."""
    rows = data.rows.get("Atoms", [])
    _check_count(data, "Atoms")
    _check_widths(data, rows, (7, 10), _ATOM_COLUMNS)
    table = _table(data, rows, _ATOM_COLUMNS)
    images = table[:, 7:] if table.shape[1] == 10 else np.zeros((len(rows), 3))
    _check_whole(data, rows, table[:, 0], "id", 1)
    _check_whole(data, rows, table[:, 1], "type", 1, setup.ntypes)
    _complain(data, rows, (images != np.floor(images)).any(axis=1), "ix iy iz must be whole numbers")
    _check_unique(data, rows, table[:, 0])
    _complain(data, rows, table[:, 2] < 0.0, "the diameter must not be negative")
    _complain(data, rows, table[:, 3] <= 0.0, "the density must be above zero")
    radius = 0.5 * table[:, 2]
    mass = np.where(radius > 0.0, density_mass(setup, radius, table[:, 3]), table[:, 3])  # a point's density column is its mass
    ids, types = (table[:, column].astype(np.int64) for column in (0, 1))
    atoms = new_atoms(ids, types, table[:, 4:7].copy(), radius, mass)
    atoms.image = images.astype(np.int64)
    _check_inside(data, rows, atoms, setup)
    _velocities(data, atoms)
    assert setup.box is not None
    return wrap(atoms, setup.box)


def _velocities(data: DataFile, atoms: Atoms) -> None:
    if "Velocities" not in data.rows:
        return
    rows = data.rows["Velocities"]
    _check_count(data, "Velocities")
    _check_widths(data, rows, (7,), _VELOCITY_COLUMNS)
    table = _table(data, rows, _VELOCITY_COLUMNS)
    row_of = {identity: row for row, identity in enumerate(atoms.id.tolist())}
    known = np.array([identity in row_of for identity in table[:, 0].tolist()], dtype=bool)
    _complain(data, rows, ~known, "the id is not in the section Atoms")
    _check_unique(data, rows, table[:, 0])
    at = np.array([row_of[int(identity)] for identity in table[:, 0]], dtype=np.int64)
    atoms.v[at], atoms.omega[at] = table[:, 1:4], table[:, 4:7]


def _check_count(data: DataFile, section: str) -> None:
    count = len(data.rows.get(section, []))
    if count != data.atoms:
        raise InputError(f"the header says {data.atoms} atoms, the section {section} holds {count}", Place(data.path))


def _check_widths(data: DataFile, rows: list[tuple[int, list[str]]], widths: tuple[int, ...], columns: str) -> None:
    for number, words in rows:
        if len(words) not in widths or len(words) != len(rows[0][1]):
            raise InputError(f"expected {columns}, the same in every line, got {len(words)} columns", Place(data.path, number))


def _table(data: DataFile, rows: list[tuple[int, list[str]]], columns: str) -> Floats:
    """(n, columns) numbers, all finite."""
    flat = [*chain.from_iterable(words for _, words in rows)]
    try:
        table = np.fromiter(map(float, flat), dtype=float, count=len(flat)).reshape(len(rows), len(rows[0][1]) if rows else 10)
        if np.isfinite(table).all() and "_" not in "".join(flat):  # Python reads 1_0
            return table
    except ValueError:
        pass  # one word is no number: found below, with its line
    for number, words in rows:
        for name, word in zip(re.sub(r"[][]", "", columns).split(), words, strict=False):
            _number(word, name, Place(data.path, number))
    raise AssertionError("numpy and float() read numbers differently")


def _check_whole(
    data: DataFile, rows: list[tuple[int, list[str]]], column: Floats, name: str, low: int, high: int | None = None
) -> None:
    bad = (column != np.floor(column)) | (column < low) | (column > (high or _MOST))
    _complain(data, rows, bad, f"the {name} must be a whole number from {low}" + (f" to {high}" if high else ""))


def _check_unique(data: DataFile, rows: list[tuple[int, list[str]]], column: Floats) -> None:
    _, first = np.unique(column, return_index=True)
    again = np.ones(len(column), dtype=bool)
    again[first] = False
    _complain(data, rows, again, "the id was given before")


def _check_inside(data: DataFile, rows: list[tuple[int, list[str]]], atoms: Atoms, setup: Setup) -> None:
    box = setup.box
    assert box is not None
    edge = _EDGE * (box.hi - box.lo)
    outside = ((atoms.x < box.lo - edge) | (atoms.x > box.hi + edge)) & ~np.array(box.periodic)
    _complain(data, rows, outside.any(axis=1), "the particle is outside the box, whose faces here are not periodic")


def _complain(
    data: DataFile, rows: list[tuple[int, list[str]]], bad: np.ndarray[tuple[int], np.dtype[np.bool_]], message: str
) -> None:
    """Raises InputError at the first row that is bad."""
    if bad.any():
        number, words = rows[int(np.argmax(bad))]
        raise InputError(f"{message}, got {' '.join(words)!r}", Place(data.path, number))


def _number(word: str, name: str, place: Place) -> float:
    try:
        value = np.nan if "_" in word else float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"expected a number for {name}, got {word!r}", place)
    return value


def _whole(word: str, name: str, place: Place) -> int:
    if not (word.isascii() and word.isdigit()) or int(word) > _MOST:
        raise InputError(f"expected a whole number for {name}, got {word!r}", place)
    return int(word)

"""From the arrays of a VTK file to the columns of a frame: what LIGGGHTS' `dump custom/vtk` and `dump local/gran/vtk` write.

Three columns that belong together are one array under their common name (v f omega angmom tq mu and i of ix iy iz; c_ID[1-3] of a
compute or fix); they become columns again. quat1 to quat4 are written as a rotation matrix TENSOR and come back as quat1 to quat4 with
quat1 >= 0. The array of xs ys zs, xu yu zu or xsu ysu zsu loses its name; its columns are called unknownx unknowny unknownz. A variable
v_NAME is called NAME.

By its source (DumpParticle::pack_tensor, LIGGGHTS-PUBLIC of 2024; not run) LIGGGHTS writes wrong TENSORs for a group other than all:
those of the first particles of the processor, not of the group.

Neither step, time, units nor boundary flags are in the file. The step is in its name. The box is in `*boundingBox_N` beside it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.cell import general
from demverify.formats.reading import Reading
from demverify.formats.rows import pick
from demverify.formats.words import is_number, shown
from demverify.frames import UNKNOWN_BOUNDARY, Floats, Frame

_NAME = re.compile(r"(?P<stem>.*?)(?P<digits>\d+)(?P<rest>\D*)", re.ASCII | re.DOTALL)
_ENDING = re.compile(r"\.p?vt[kpu]", re.IGNORECASE)
_RANGE = re.compile(r"(.*)\[(\d+)-(\d+)\]", re.DOTALL)
NO_NAME = "unknown"
"""What VTK's legacy writer calls an array without a name."""
Box = tuple[Floats, Floats | None]
"""Bounds and cell of a frame."""
NO_BOX: Box = (np.full((3, 2), np.nan), None)
"""Where the file does not say."""
BOX_ALONE = "a box without particles (a bounding box that LIGGGHTS writes beside its files); name the other file"
MESH = "cells that are no lines: a mesh, not contacts"
_WIDEST = 99
_CORNERS = [1, 3, 4]  # of a hexahedron: the ends of a, b and c


@dataclass(frozen=True)
class Array:
    """One array of a VTK file: values() is (n, width); it is called when the array is wanted."""

    name: str
    width: int
    values: Callable[[], Floats]

    @property
    def columns(self) -> list[str]:
        """What its columns are called."""
        name, span = self.name, _RANGE.fullmatch(self.name)
        if self.width == 1:
            return [name]
        if self._rotates:
            return ["quat1", "quat2", "quat3", "quat4"]
        if self.width == 3 and span and int(span[3]) == int(span[2]) + 2:
            return [f"{span[1]}[{int(span[2]) + i}]" for i in range(3)]
        return [name + axis for axis in "xyz"] if self.width == 3 else [f"{name}[{i}]" for i in range(1, self.width + 1)]

    @property
    def table(self) -> Floats:
        """(n, len(columns))."""
        return _quaternions(self.values().reshape(-1, 3, 3)) if self._rotates else self.values()

    @property
    def _rotates(self) -> bool:
        return self.name == "TENSOR" and self.width == 9


@dataclass(frozen=True)
class Content:
    """What a VTK file says. points: (n, 3) in float32. cells: number of cells."""

    points: Array
    n: int
    of_points: list[Array]
    cells: int
    of_cells: list[Array]
    dialect: Literal["lammps", "liggghts"] | None = None


def frame_of(path: Path, step: int, content: Content, reading: Reading, box_and_cell: Box) -> Frame:
    """Particles, or contacts (local) where only the cells have arrays. Raises InputError as `pick` does."""
    place = Place(path)
    local = bool(content.of_cells) and not content.of_points
    arrays = content.of_cells if local else [content.points, *content.of_points]
    found = [name for array in arrays for name in array.columns]
    if not content.n and not content.of_points and not local:
        found = list(reading.columns or found)  # a frame without particles has no arrays
    picked = pick(found, reading, place, local=local or not content.n)
    every = 3 if local and _drawn_as_triangles(content) else 1
    table = picked.joined([_table(arrays, picked.at)[:, ::every]] if content.n else [])
    dialect = "liggghts" if any(array.name == "TENSOR" for array in arrays) else content.dialect
    box, cell = box_and_cell
    return Frame(step, box, UNKNOWN_BOUNDARY, picked.columns(table, place), cell, dialect=dialect, local=local)


def _table(arrays: list[Array], wanted: list[int]) -> Floats:
    """The wanted columns (counted through all arrays), one a row; arrays without one are not decoded."""
    tables: list[Floats] = []
    first = 0
    for array in arrays:
        last = first + len(array.columns)
        mine = [j - first for j in wanted if first <= j < last]
        tables += [array.table[:, mine].T] if mine else []
        first = last
    return np.concatenate(tables) if tables else np.empty((0, 0))


def _drawn_as_triangles(content: Content) -> bool:
    """True when LIGGGHTS drew each contact as three lines between two centres and a contact point: three equal rows."""
    return content.cells == content.n and content.cells % 3 == 0


def step_and_boxes(path: Path, endings: tuple[str, ...]) -> tuple[int, list[Path]]:
    """The step, from the digits nearest the end of the file name, and the files beside it that hold its box, with one of the endings.

    In run210.vtk the step may be 10, of run2*.vtk: run2boundingBox_10.vtk beside it says so. Raises InputError for a name without digits.
    """
    parts = _NAME.fullmatch(path.name)
    if parts is None:
        message = "a VTK file does not say its step and the name has no digits before its ending, as in d10.vtk"
        raise InputError(message, Place(path))
    stem, digits, rest = parts["stem"], parts["digits"], parts["rest"]
    for i in range(len(digits)):
        names = [f"{stem}{digits[:i]}boundingBox_{digits[i:]}{_ENDING.sub(ending, rest)}" for ending in endings]
        boxes = [path.with_name(name) for name in names if path.with_name(name).is_file()]
        if boxes:
            return int(digits[i:]), boxes
    return int(digits), []


def cell_of_corners(corners: Floats, place: Place) -> Box:
    """Box and cell from the eight corners of a tilted box, in VTK's order for a hexahedron. Raises InputError for another number."""
    if len(corners) != 8:
        message = f"expected the eight corners of a box, got {len(corners)}"
        raise InputError(message, place)
    return general(corners[_CORNERS] - corners[0], corners[0], place)


def checked_width(name: str, width: int, place: Place) -> int:
    """The number of components of an array. Raises InputError for one that no array of particles has."""
    if not 1 <= width <= _WIDEST:
        message = f"expected an array {name[:40]} of 1 to {_WIDEST} components, got {width}"
        raise InputError(message, place)
    return width


def numbers(text: bytes, name: str, place: Place) -> Floats:
    """Words parted by white space, as float64 (n,). Raises InputError for the first that is no number."""
    words = text.split()
    try:
        if b"_" not in text:
            return np.fromiter(map(float, words), np.float64, len(words))
    except ValueError:
        pass
    wrong = next(word for word in words if not is_number(word))
    message = f"array {name} expects numbers, got {shown(wrong)!r}"
    raise InputError(message, place)


def _quaternions(matrices: Floats) -> Floats:
    """Unit quaternions (n, 4) w x y z with w >= 0 of rotation matrices (n, 3, 3), body to space.

    The largest component comes from the diagonal, the others from what it multiplies
    (Shepperd 1978, doi 10.2514/3.55767b).
    """
    diagonal = np.einsum("nii->ni", matrices)
    trace = diagonal.sum(axis=1, keepdims=True)
    products = np.empty((len(matrices), 4, 4))  # 4 q_i q_j
    products[:, range(4), range(4)] = np.hstack([1.0 + trace, 1.0 - trace + 2.0 * diagonal])
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        products[:, 0, i + 1] = products[:, i + 1, 0] = matrices[:, k, j] - matrices[:, j, k]
        products[:, i + 1, j + 1] = products[:, j + 1, i + 1] = matrices[:, i, j] + matrices[:, j, i]
    largest = np.argmax(np.einsum("nii->ni", products), axis=1)
    best = products[np.arange(len(matrices)), largest]
    quat = best / np.sqrt(np.einsum("ni,ni->n", best, best))[:, None]
    return np.asarray(np.where(quat[:, :1] < 0, -quat, quat))

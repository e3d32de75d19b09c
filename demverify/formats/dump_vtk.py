"""Legacy VTK files of particles and contacts (LIGGGHTS `dump custom/vtk`, `dump local/gran/vtk`), ASCII or BINARY (big-endian).

    # vtk DataFile Version 5.1 / title / ASCII or BINARY / DATASET POLYDATA
    POINTS n float, 3 n numbers; VERTICES or LINES; POINT_DATA n or CELL_DATA n
    FIELD FieldData k, then k times: name width n type, numbers; or SCALARS, VECTORS
(VTK file formats, https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html; what the columns are called: vtk_frame)

Positions are float32, in ASCII with 6 digits; other numbers of LIGGGHTS have 11 digits in ASCII and all in BINARY. A frame without
particles has no arrays, so only x y z are known of it. The companion `*boundingBox_N.vtk` gives Frame.box; without it bounds are NaN.
LAMMPS' `dump vtk` is of the same kind, but was not tried.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Literal
from urllib.parse import unquote

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.cell import orthogonal
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.formats.vtk_frame import (
    BOX_ALONE,
    MESH,
    NO_BOX,
    NO_NAME,
    Array,
    Content,
    cell_of_corners,
    checked_width,
    frame_of,
    numbers,
    step_and_boxes,
)
from demverify.frames import Floats, Frame

_MAGIC = b"# vtk DataFile Version "
_TYPES = {
    "unsigned_char": "u1", "char": "i1", "unsigned_short": "u2", "short": "i2", "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8",
    "long": "i8", "float": "f4", "double": "f8", "vtkIdType": "i4", "vtktypeint64": "i8", "vtktypeuint64": "u8",
}  # fmt: skip
_WORDS = "string"
_CELLS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS")
_BOXES = {"RECTILINEAR_GRID", "UNSTRUCTURED_GRID"}


class _Legacy:
    """The text and arrays of one file, taken from the front."""

    def __init__(self, path: Path) -> None:
        self.place = Place(path)
        with opened(path) as stream:
            self._data = stream.read()
        self._at = 0
        version = self._line().removeprefix(_MAGIC.decode())
        self.title = self._line()
        kind = self._line().strip()
        if kind not in ("ASCII", "BINARY"):
            raise self.error(f"expected ASCII or BINARY in line 3, got {kind[:40]!r}")
        self.binary = kind == "BINARY"
        self.offsets = version.startswith("5")

    def error(self, message: str) -> InputError:
        return InputError(message, self.place)

    def half(self, what: str) -> HalfWrittenError:
        return HalfWrittenError(f"the file ends inside {what}", self.place)

    def _line(self) -> str:
        end = self._data.find(b"\n", self._at)
        if end < 0:
            raise self.half("a line")
        line = self._data[self._at : end]
        self._at = end + 1
        return line.decode("utf-8", "backslashreplace")

    def words(self) -> list[str]:
        """The next line that is not blank; none at the end of the file."""
        while self._at < len(self._data):
            words = self._line().split()
            if words:
                return words
        return []

    def skip_block(self) -> None:
        """Lines up to a blank one."""
        while self._at < len(self._data) and self._line().strip():
            pass

    def count(self, word: str) -> int:
        if not word.isdecimal() or len(word) > 18:
            raise self.error(f"expected a count, got {word[:40]!r}")
        return int(word)

    def array(self, name: str, count: int, kind: str) -> Callable[[], Floats]:
        """What makes the next `count` numbers, (count,); now they are only passed over."""
        if kind not in _TYPES and not (kind == _WORDS and not self.binary):
            raise self.error(f"array {name} is of type {kind[:40]!r}; known: {' '.join(_TYPES)}")
        raw = self._take_bytes(name, count * np.dtype(_TYPES[kind]).itemsize) if self.binary else self._take_words(name, count)
        return partial(_decoded, raw, ">" + _TYPES[kind]) if self.binary else partial(numbers, raw, name, self.place)

    def _take_bytes(self, name: str, size: int) -> bytes:
        start, self._at = self._at, self._at + size
        if self._at > len(self._data):
            raise self.half(f"array {name}")
        return self._data[start : self._at]

    def _take_words(self, name: str, count: int) -> bytes:
        """`count` words and the white space after them: without it the last one may have lost digits."""
        if count == 0:
            return b""
        start, rest = self._at, len(self._data) - self._at
        parts = self._data[start:].split(None, min(count, rest))
        following = parts[count] if len(parts) == count + 1 else b""
        whole = len(parts) >= count and (bool(following) or self._data[-1:].isspace())
        if not whole:
            raise self.half(f"array {name}")
        self._at = len(self._data) - len(following)
        return self._data[start : self._at]


def _decoded(raw: bytes, dtype: str) -> Floats:
    return np.frombuffer(raw, dtype).astype(np.float64)


def _shaped(values: Callable[[], Floats], width: int) -> Floats:
    return values().reshape(-1, width)


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a legacy VTK file."""
    return head.startswith(_MAGIC)


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The one frame of a file, rows of particles sorted by id; contacts (cells with arrays) in the order of the file.

    Raises InputError for a file name without a step and for what is no file of particles or contacts, such as a bounding box alone.
    """
    return whole_frames(_read_frames(block.path, reading), reading)


def _read_frames(path: Path, reading: Reading) -> Iterator[Frame]:
    content = _Parser(_Legacy(path)).content()
    step, boxes = step_and_boxes(path, (".vtk",))
    yield frame_of(path, step, content, reading, _read_box(boxes[0]) if boxes else NO_BOX)


def _read_box(path: Path) -> tuple[Floats, Floats | None]:
    """Box and cell of a `*boundingBox_N.vtk`: a grid of two by two by two points, or the corners of a tilted box (float32)."""
    parser = _Parser(_Legacy(path))
    parser.sections()
    place = Place(path)
    if parser.dataset == "UNSTRUCTURED_GRID":
        return cell_of_corners(parser.points().reshape(-1, 3), place)
    bounds = [axis().tolist() for axis in parser.axes]
    if [len(axis) for axis in bounds] != [2, 2, 2]:
        message = "expected a box of 2 x 2 x 2 points"
        raise InputError(message, place)
    return orthogonal(np.array(bounds), place), None


class _Parser:
    """The sections of one file."""

    def __init__(self, legacy: _Legacy) -> None:
        self._legacy = legacy
        self.dataset = ""
        self.points: Callable[[], Floats] = partial(np.empty, 0)
        self.axes: list[Callable[[], Floats]] = []
        self._n: int | None = None
        self._counts = {"POINT_DATA": 0, "CELL_DATA": 0}
        self._arrays: dict[str, list[Array]] = {"POINT_DATA": [], "CELL_DATA": []}
        self._section = ""
        self._cells: set[str] = set()

    def content(self) -> Content:
        """All of a file of particles or contacts."""
        self.sections()
        if self.dataset in _BOXES and not any(self._arrays.values()):
            raise self._legacy.error(BOX_ALONE)
        if self._n is None:
            raise self._legacy.half("the header")
        if self._n and not any(self._arrays.values()):
            raise self._legacy.half("the points, or dumps positions alone, without an id")
        if self._arrays["POINT_DATA"] and self._counts["POINT_DATA"] != self._n:
            raise self._legacy.error(f"expected data of {self._n} points, got POINT_DATA {self._counts['POINT_DATA']}")
        if not self._arrays["POINT_DATA"] and self._cells - {"LINES", "CELLS"}:
            raise self._legacy.error(MESH)
        points, (of_points, of_cells) = Array("", 3, partial(_shaped, self.points, 3)), self._arrays.values()
        return Content(points, self._n, of_points, self._counts["CELL_DATA"], of_cells, self._dialect())

    def sections(self) -> None:
        """Reads to the end of the file."""
        while words := self._legacy.words():
            self._read_section(words[0], words[1:])

    def _dialect(self) -> Literal["lammps", "liggghts"] | None:
        title = self._legacy.title.strip()
        return "liggghts" if title == "Generated by LIGGGHTS" else "lammps" if title == "Generated by LAMMPS" else None

    def _read_section(self, word: str, rest: list[str]) -> None:
        legacy = self._legacy
        if word == "DATASET" and len(rest) == 1:
            self.dataset = rest[0]
            if self.dataset not in {"POLYDATA", *_BOXES}:
                raise legacy.error(f"a VTK file of {self.dataset[:40]} holds no particles; known: POLYDATA")
        elif word == "POINTS" and len(rest) == 2:
            self._n = legacy.count(rest[0])
            self.points = legacy.array("of points", 3 * self._n, rest[1])
        elif word in _CELLS and len(rest) == 2:
            self._cells.add(word)
            self._skip_cells([legacy.count(word) for word in rest])
        elif word == "CELL_TYPES" and len(rest) == 1:
            legacy.array("of cell types", legacy.count(rest[0]), "int")
        elif word == "DIMENSIONS" and len(rest) == 3:
            pass
        elif re.fullmatch("[XYZ]_COORDINATES", word) and len(rest) == 2:
            self.axes.append(legacy.array(word, legacy.count(rest[0]), rest[1]))
        elif word in self._counts and len(rest) == 1:
            self._section = word
            self._counts[word] = legacy.count(rest[0])
        elif word == "METADATA":
            legacy.skip_block()
        else:
            self._read_arrays(word, rest)

    def _skip_cells(self, counts: list[int]) -> None:
        """Version 5 has two named arrays of a and b numbers, earlier ones have b numbers for a cells."""
        for count in counts if self._legacy.offsets and counts[0] else counts[1:]:
            words = self._legacy.words() if self._legacy.offsets and counts[0] else ["", "int"]
            if len(words) != 2:
                raise self._unknown(words[0] if words else "nothing")
            self._legacy.array("of cells", count, words[1])

    def _read_arrays(self, word: str, rest: list[str]) -> None:
        if word == "FIELD" and len(rest) == 2:
            for _ in range(self._legacy.count(rest[1])):
                self._read_field(self._legacy.words())
        elif word == "SCALARS" and len(rest) in (2, 3) and self._section:
            lookup = self._legacy.words()
            if lookup[:1] != ["LOOKUP_TABLE"]:
                raise self._unknown(" ".join(lookup) or "nothing")
            self._add(rest[0], int(rest[2]) if rest[2:] in (["1"], ["2"], ["3"], ["4"]) else 1, self._counts[self._section], rest[1])
        elif word == "VECTORS" and len(rest) == 2 and self._section:
            self._add(rest[0], 3, self._counts[self._section], rest[1])
        else:
            raise self._unknown(" ".join([word, *rest]))

    def _read_field(self, words: list[str]) -> None:
        while words[:1] == ["METADATA"]:
            self._legacy.skip_block()
            words = self._legacy.words()
        if not words:
            raise self._legacy.half("a list of arrays")
        if len(words) != 4:
            raise self._unknown(" ".join(words))
        self._add(words[0], self._legacy.count(words[1]), self._legacy.count(words[2]), words[3])

    def _add(self, name: str, width: int, n: int, kind: str) -> None:
        checked_width(name, width, self._legacy.place)
        values = self._legacy.array(name, width * n, kind)
        if not self._section:
            return  # of the file as a whole
        if n != self._counts[self._section]:
            raise self._legacy.error(f"expected an array {name} of {self._counts[self._section]} rows, got {n}")
        self._arrays[self._section].append(Array(unquote(name) or NO_NAME, width, partial(_shaped, values, width)))

    def _unknown(self, line: str) -> InputError:
        known = f"{' '.join(_CELLS)} POINTS POINT_DATA CELL_DATA FIELD SCALARS VECTORS METADATA"
        return self._legacy.error(f"{line[:40]!r} is no part of a VTK file of particles; known: {known}")

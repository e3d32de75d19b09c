"""Dumps in YAML (LAMMPS `dump yaml`): one document a frame, from `---` to `...`, read line by line.

    timestep: 10; units: si; time: 1e-4; natoms: n; boundary: [ p, p, f, f, s, s, ]
    box: three rows [ lo, hi ], a fourth [ xy, xz, yz ] for a tilted cell
    keywords: [ id, type, ... ]; data: n rows [ 17 , 1 , 0.172465, ... ]

Other keys (creator, thermo, those of later versions) are passed over. For a dump in general triclinic axes (dump_modify triclinic/general)
LAMMPS writes the box turned into its own axes and the vectors not turned; the file does not show it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.cell import orthogonal, tilted
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.formats.rows import Picked, pick
from demverify.formats.words import number, shown
from demverify.frames import Floats, Frame

_ROWS = 4096  # rows kept as Python numbers before they become an array
_HALF = "the file ends inside a frame"


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a YAML document."""
    return head.startswith(b"---")


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of a YAML dump, rows sorted by id, float64 exactly as written.

    Raises InputError with file and line for what is not a whole frame of particles with distinct ids.
    """
    return whole_frames(_read_frames(block.path, reading), reading)


def _read_frames(path: Path, reading: Reading) -> Iterator[Frame]:
    document: _Document | None = None
    place = Place(path)
    with opened(path) as stream:
        for count, line in enumerate(stream, 1):
            text, place = line.strip(), Place(path, count)
            if text == b"..." and document is not None:
                yield document.frame(place)
                document = None
            elif not line.endswith(b"\n"):
                raise HalfWrittenError(_HALF, place)
            elif text == b"---" and document is None:
                document = _Document(reading)
            elif document is not None and text not in (b"---", b""):
                document.add(text, place)
            elif text:
                message = f"expected {'...' if document else '---'!r} between two frames, got {shown(text)!r}"
                raise InputError(message, place)
    if document is not None:
        raise HalfWrittenError(_HALF, place)


class _Document:
    """One frame while its lines come in."""

    def __init__(self, reading: Reading) -> None:
        self._reading = reading
        self._values: dict[str, str] = {}
        self._box: list[list[float]] = []
        self._key = ""
        self._n = 0
        self._width = 0
        self._picked: Picked | None = None
        self._rows: list[list[float]] = []
        self._tables: list[Floats] = []

    def add(self, text: bytes, place: Place) -> None:
        """Adds a line that is neither `---` nor `...`."""
        if not text.startswith(b"-"):
            self._add_key(text.decode("utf-8", "backslashreplace"), place)
        elif self._key == "data":
            self._add_row(text, place)
        elif self._key == "box":
            self._box.append([_number(word, "box", place) for word in _words(text, place)])

    def frame(self, place: Place) -> Frame:
        """The frame, when all its lines are there."""
        if self._picked is None:
            message = f"a frame without data; it has {', '.join(self._values) or 'nothing'}"
            raise InputError(message, place)
        self._flush()
        got = sum(table.shape[1] for table in self._tables)
        if got != self._n:
            message = f"expected {self._n} rows, got {got}"
            raise InputError(message, place)
        columns = self._picked.columns(self._picked.joined(self._tables), place)
        box, cell = self._bounds(place)
        time = _number(self._values["time"].encode(), "time", place) if "time" in self._values else None
        step = _count(self._values, "timestep", place)
        wrote: Literal["lammps"] | None = "lammps" if self._values.get("creator") == "LAMMPS" else None
        return Frame(step, box, self._boundary(place), columns, cell, time, self._values.get("units"), dialect=wrote)

    def _add_key(self, text: str, place: Place) -> None:
        key, colon, value = text.partition(":")
        if not colon:
            message = f"expected 'key: value', got {shown(text.encode())!r}"
            raise InputError(message, place)
        if key in self._values:
            message = f"expected one {key!r} a frame, got two"
            raise InputError(message, place)
        self._key = key
        self._values[key] = value.strip()
        if key == "data":
            self._start(place)

    def _start(self, place: Place) -> None:
        """Rows come next: which of their columns are wanted."""
        for key in ("timestep", "natoms", "keywords"):
            if key not in self._values:
                message = f"not a dump of particles: a yaml table of {', '.join(self._values)} without {key} (fix ave/time or thermo output)"
                raise InputError(message, place)
        found = [word.decode() for word in _words(self._values["keywords"].encode(), place)]
        self._n, self._width = _count(self._values, "natoms", place), len(found)
        self._picked = pick(found, self._reading, place)

    def _add_row(self, text: bytes, place: Place) -> None:
        assert self._picked is not None
        words = _words(text, place)
        if len(words) != self._width:
            message = f"expected {self._width} columns ({self._values['keywords']}), got {len(words)}: {shown(text)!r}"
            raise InputError(message, place)
        self._rows.append([_number(words[j], str(name or "id"), place) for j, name in zip(self._picked.at, self._picked.names, strict=True)])
        if len(self._rows) == _ROWS:
            self._flush()

    def _flush(self) -> None:
        if self._rows:
            self._tables.append(np.array(self._rows, dtype=np.float64).T)
            self._rows = []

    def _bounds(self, place: Place) -> tuple[Floats, Floats | None]:
        widths = [len(row) for row in self._box]
        if widths not in ([2, 2, 2], [2, 2, 2, 3]):
            message = f"expected a box of three rows [ lo, hi ], and [ xy, xz, yz ] when it is tilted, got rows of {widths[:8]} numbers"
            raise InputError(message, place)
        bounds = np.array(self._box[:3])
        return tilted(bounds, np.array(self._box[3]), place) if len(self._box) == 4 else (orthogonal(bounds, place), None)

    def _boundary(self, place: Place) -> tuple[str, str, str]:
        flags = b"".join(_words(self._values.get("boundary", "").encode(), place)).decode()
        if len(flags) != 6 or set(flags) - set("pfsm"):
            message = f"expected a boundary of six letters p f s m, got {self._values.get('boundary', 'none')!r}"
            raise InputError(message, place)
        return flags[:2], flags[2:4], flags[4:]


def _words(text: bytes, place: Place) -> list[bytes]:
    """The words of `[ a, b, ]`, also after a dash."""
    inner, bracket, rest = text.removeprefix(b"-").strip().removeprefix(b"[").rpartition(b"]")
    if not bracket or rest or b"[" not in text:
        message = f"expected '[ ..., ... ]', got {shown(text)!r}"
        raise InputError(message, place)
    words = [word.strip() for word in inner.split(b",")]
    return words if words[-1] else words[:-1]


def _number(word: bytes, what: str, place: Place) -> float:
    try:
        return number(word)
    except ValueError:
        message = f"{what} expects a number, got {shown(word)!r}"
        raise InputError(message, place) from None


def _count(values: dict[str, str], key: str, place: Place) -> int:
    if not values[key].isdecimal() or len(values[key]) > 18:
        message = f"{key} expects a count, got {shown(values[key].encode())!r}"
        raise InputError(message, place)
    return int(values[key])

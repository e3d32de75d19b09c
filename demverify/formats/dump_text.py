"""Text dumps of LAMMPS and LIGGGHTS (`dump custom`, `dump atom`): reading both, and writing the bytes that either would.

    ITEM: TIMESTEP, step; ITEM: NUMBER OF ATOMS, n; ITEM: BOX BOUNDS pp pp pp, three rows lo hi; ITEM: ATOMS id type ..., n rows

LAMMPS adds ITEM: UNITS and ITEM: TIME on request, LIGGGHTS ITEM: LABEL; LIGGGHTS ends every header and row with a blank.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from demverify.deck.setup import Dialect
from demverify.errors import InputError, Place
from demverify.formats.columns import INTEGER_COLUMNS
from demverify.formats.printf import column_formats, format_rows
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.frames import Frame

Floats = NDArray[np.float64]

_HALF_HEADER = "the file ends inside a frame's header"
_ONE_LINE_ITEMS = ("TIMESTEP", "NUMBER OF ATOMS", "TIME", "UNITS", "LABEL")


@dataclass(frozen=True)
class _Header:
    step: int
    n: int
    box: Floats
    boundary: tuple[str, str, str]
    names: list[str]


class _Lines:
    """The lines of a dump with their numbers."""

    def __init__(self, path: Path, stream: IO[bytes]) -> None:
        self.path = path
        self.number = 0
        self._stream = stream

    def here(self, back: int = 0) -> Place:
        return Place(self.path, self.number - back)

    def take(self, n: int) -> list[bytes]:
        """Up to n lines; fewer at the end of the file."""
        try:
            lines = list(islice(self._stream, n))
        except EOFError:
            message = "the gzip stream ends early"
            raise HalfWrittenError(message, self.here()) from None
        except (OSError, zlib.error) as error:
            message = f"cannot be unpacked: {error}"
            raise InputError(message, Place(self.path)) from None
        self.number += len(lines)
        return lines

    def whole(self, n: int, what: str) -> list[bytes]:
        """Exactly n lines, each with its newline: a number without one may have lost digits."""
        lines = self.take(n)
        if len(lines) < n or (lines and not lines[-1].endswith(b"\n")):
            got = len(lines) if len(lines) < n else n - 1
            message = f"the file ends inside a frame: {got} of {n} {what}"
            raise HalfWrittenError(message, self.here())
        return lines

    def item(self) -> str | None:
        """The next header line without `ITEM: `, or None at the end of the file."""
        lines = self.take(1)
        if not lines:
            return None
        if not lines[0].startswith(b"ITEM: "[: len(lines[0])]):
            message = f"expected 'ITEM: ...', got {_shown(lines[0])!r}"
            raise InputError(message, self.here())
        if not lines[0].endswith(b"\n"):
            raise HalfWrittenError(_HALF_HEADER, self.here())
        return lines[0].decode("utf-8", "backslashreplace").strip().removeprefix("ITEM: ")


def _shown(line: bytes) -> str:
    text = line.decode("utf-8", "backslashreplace").strip()
    return text if len(text) <= 60 else text[:57] + "..."


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a text dump."""
    return head.startswith(b"ITEM: ")


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of a text dump, plain or packed, rows sorted by id, float64 exactly as written.

    Raises InputError with file and line for anything else than whole frames of an orthogonal box with distinct ids.
    """
    return whole_frames(_read_frames(block.path), reading)


def _read_frames(path: Path) -> Iterator[Frame]:
    with opened(path) as stream:
        lines = _Lines(path, stream)
        while (frame := _read_frame(lines)) is not None:
            yield frame


def _read_frame(lines: _Lines) -> Frame | None:
    header = _read_header(lines)
    if header is None:
        return None
    rows = lines.whole(header.n, f"rows of step {header.step}")
    table = _table(rows, header.names, lines)
    order = _order(table, header.names, lines)
    columns = {name: np.ascontiguousarray(table[order, j]) for j, name in enumerate(header.names)}
    return Frame(header.step, header.box, header.boundary, columns)


def _read_header(lines: _Lines) -> _Header | None:
    values: dict[str, int] = {}
    box: tuple[Floats, tuple[str, str, str]] | None = None
    while (item := lines.item()) is not None:
        if item in _ONE_LINE_ITEMS:
            line = lines.whole(1, f"lines of {item}")[0]
            if item in ("TIMESTEP", "NUMBER OF ATOMS"):
                values[item] = _count(line, item, lines.here())
        elif item.startswith("BOX BOUNDS"):
            box = _read_box(item.split()[2:], lines)
        elif item.startswith("ATOMS"):
            return _complete(values, box, item.split()[1:], lines.here())
        else:
            known = ", ".join((*_ONE_LINE_ITEMS, "BOX BOUNDS", "ATOMS"))
            message = f"'ITEM: {item}' is no part of a particle dump; known: {known}"
            raise InputError(message, lines.here())
    if values or box:
        raise HalfWrittenError(_HALF_HEADER, lines.here())
    return None


def _complete(
    values: dict[str, int], box: tuple[Floats, tuple[str, str, str]] | None, names: list[str], place: Place
) -> _Header:
    if box is None or len(values) < 2:
        missing = [item for item in ("TIMESTEP", "NUMBER OF ATOMS") if item not in values] or ["BOX BOUNDS"]
        message = f"a frame without ITEM: {missing[0]}"
        raise InputError(message, place)
    if "id" not in names or len(set(names)) < len(names):
        message = f"expected distinct columns with an id among them, got: {' '.join(names)}"
        raise InputError(message, place)
    return _Header(values["TIMESTEP"], values["NUMBER OF ATOMS"], *box, names)


def _count(line: bytes, item: str, place: Place) -> int:
    try:
        value = int(line)
    except ValueError:
        value = -1
    if value < 0:
        message = f"ITEM: {item} expects a count, got {_shown(line)!r}"
        raise InputError(message, place)
    return value


def _read_box(flags: list[str], lines: _Lines) -> tuple[Floats, tuple[str, str, str]]:
    if len(flags) != 3 or any(len(flag) != 2 or set(flag) - set("pfsm") for flag in flags):
        message = f"expected an orthogonal box with three boundary flags such as 'pp ff fs', got {' '.join(flags)!r}"
        raise InputError(message, lines.here())
    rows = lines.whole(3, "rows of BOX BOUNDS")
    box = _table(rows, ["lo", "hi"], lines)
    if not (box[:, 0] <= box[:, 1]).all():
        message = "box bounds must be lo <= hi"
        raise InputError(message, lines.here())
    return box, (flags[0], flags[1], flags[2])


def _table(rows: list[bytes], names: Sequence[str], lines: _Lines) -> Floats:
    """(rows, columns); the rows are the last ones taken from `lines`."""
    if not rows:
        return np.empty((0, len(names)))
    try:
        table = np.loadtxt(rows, dtype=np.float64, comments=None, ndmin=2)
    except ValueError:
        table = np.empty((0, 0))
    if table.shape != (len(rows), len(names)):
        raise _bad_row(rows, names, lines)
    return table


def _bad_row(rows: list[bytes], names: Sequence[str], lines: _Lines) -> InputError:
    """What is wrong with the first row that is wrong."""
    for i, row in enumerate(rows):
        place = lines.here(len(rows) - 1 - i)
        words = row.split()
        if len(words) != len(names):
            return InputError(f"expected {len(names)} columns ({' '.join(names)}), got {len(words)}: {_shown(row)!r}", place)
        for name, word in zip(names, words, strict=True):
            if not _is_number(word):
                return InputError(f"column {name} expects a number, got {_shown(word)!r}", place)
    return InputError("rows that are not numbers", lines.here())


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return b"_" not in word


def _order(table: Floats, names: list[str], lines: _Lines) -> NDArray[np.intp]:
    ids = table[:, names.index("id")]
    order = np.argsort(ids, kind="stable")
    twice = np.flatnonzero(~(np.diff(ids[order]) > 0))  # also catches NaN
    if len(twice):
        message = f"id {ids[order][twice[0] + 1]:.17g} stands in two rows of the frame that ends here"
        raise InputError(message, lines.here())
    return order


def text_frame(
    frame: Frame,
    names: Sequence[str],
    dialect: Dialect,
    formats: Mapping[str, str] | None = None,
    place: Place | None = None,
) -> bytes:
    """One frame as the engine of `dialect` writes it, rows in the order of the frame's arrays.

    names: the columns, in order, all of them in frame.columns. formats: as dump_modify format (see printf.column_formats).
    LAMMPS joins by blanks and writes bounds with 17 digits, LIGGGHTS ends each with a blank and gives bounds 6 digits.
    NaN is `nan`: the sign that C's printf may show is lost.
    """
    integer = [name in INTEGER_COLUMNS for name in names]
    fmts = column_formats(names, integer, formats or {}, ("%d", "%g"), place)
    types = [np.int64 if whole else np.float64 for whole in integer]
    columns = [frame.columns[name].astype(kind).tolist() for name, kind in zip(names, types, strict=True)]
    end = " \n" if dialect == "liggghts" else "\n"
    bound = "%g %g\n" if dialect == "liggghts" else "%-1.16e %-1.16e\n"
    head = (
        f"ITEM: TIMESTEP\n{frame.step}\nITEM: NUMBER OF ATOMS\n{frame.n}\nITEM: BOX BOUNDS {' '.join(frame.boundary)}\n"
        + "".join(bound % (lo, hi) for lo, hi in frame.box.tolist())
        + f"ITEM: ATOMS {' '.join(names)}{end}"
    )
    return head.encode() + format_rows(" ".join(fmts) + end, columns)

"""Text dumps without any header (LAMMPS `dump_modify header no`): rows of numbers, nothing between the frames.

The reader must be told the names of the columns, an id among them. Where one frame ends and the next begins shows in the ids alone:
if none comes twice, all rows are one frame; if the same ids return again and again, each time all of them, those are the frames. Where
particles come or go the boundary cannot be told, and the file is refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import count, repeat
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.formats.rows import Picked, pick
from demverify.formats.words import is_number
from demverify.frames import UNKNOWN_BOUNDARY, Floats, Frame

if TYPE_CHECKING:
    from demverify.formats.text import Text

_ROWS = 1 << 14
_BOX = np.full((3, 2), np.nan)


def recognises(head: bytes) -> bool:
    """True when the first line of a file that starts so is all numbers."""
    words = head.split(b"\n", 1)[0].split()
    return bool(words) and all(map(is_number, words))


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of a dump without header, float64 exactly as written, rows sorted by id.

    The step of a single frame is what the digits nearest the end of the file name say, 0 without any; of several frames in one file the
    steps are not known: they are numbered 0, 1, 2 ... The box and its boundary are not known: NaN and "??".
    Raises InputError without names of columns, for what is not a row of numbers, and where the boundary between frames cannot be told.
    """
    return whole_frames(_read_frames(block.path, reading), reading)


def _read_frames(path: Path, reading: Reading) -> Iterator[Frame]:
    from demverify.formats.text import Text

    place = Place(path, 1)
    if reading.columns is None:
        message = "a dump without header: name its columns with --columns, in the order of the dump command"
        raise InputError(message, place)
    picked = pick(reading.columns, reading, place)
    with opened(path) as stream:
        yield from _frames(_Rows(Text(path, stream), reading.columns, picked), picked, path)


class _Rows:
    """The rows of a file in a table that is filled from the end and emptied from the front."""

    def __init__(self, text: Text, names: Sequence[str], picked: Picked) -> None:
        self._text, self._names, self._picked = text, names, picked
        self._table = np.empty((len(picked.at), _ROWS))
        self._start, self._end = 0, 0

    @property
    def held(self) -> Floats:
        """The rows read and not yet taken, (columns, rows)."""
        return self._table[:, self._start : self._end]

    def more(self) -> bool:
        """Reads on, as many rows as are held at least; False at the end of the file."""
        held = self.held
        self._table = np.concatenate([held, np.empty((len(held), max(_ROWS, held.shape[1])))], axis=1)
        self._start, before = 0, held.shape[1]
        self._end = self._text.rows(self._table, before, self._names, self._picked)
        return bool(self._end > before)

    def take(self, n: int) -> Floats:
        """The first n rows held, a copy; fewer where the file ends."""
        while self._end - self._start < n and self.more():
            pass
        taken = self.held[:, :n].copy()
        self._start += taken.shape[1]
        return taken

    def check_end(self) -> None:
        """Raises HalfWrittenError where the file ends inside a row."""
        if self._text.line():
            message = "the file ends inside a row"
            raise HalfWrittenError(message, self._text.place())


def _frames(rows: _Rows, picked: Picked, path: Path) -> Iterator[Frame]:
    ids = picked.ids
    assert ids is not None
    while rows.more() and not (rows.held[ids, 1:] == rows.held[ids, 0]).any():
        pass
    n = _first_repeat(rows.held[ids])
    steps: Iterator[int] = count()
    if n == rows.held.shape[1]:
        rows.check_end()  # half of the only frame would look like a whole one
        steps = repeat(_step_of(path))
    same: Floats | None = None
    end = 0
    while (table := rows.take(n)).shape[1] == n > 0:
        end += n
        place = Place(path, end)
        ids_here = np.sort(table[ids])
        if same is not None and not np.array_equal(same, ids_here):
            message = f"rows {end - n + 1} to {end} do not hold the ids of the first {n} rows: where a frame ends cannot be told"
            raise InputError(message, place)
        same = ids_here
        yield Frame(next(steps), _BOX, UNKNOWN_BOUNDARY, picked.columns(table, place))
    rows.check_end()
    if left := table.shape[1]:
        message = f"the file ends inside a frame: {left} of {n} rows"
        raise HalfWrittenError(message, Place(path, end + left))


def _first_repeat(ids: Floats) -> int:
    """Where the first id stands that has come before; the number of ids where none has."""
    order = np.argsort(ids, kind="stable")
    again = order[1:][np.diff(ids[order]) == 0]
    return int(again.min()) if len(again) else len(ids)


def _step_of(path: Path) -> int:
    digits = re.findall(r"\d+", path.name)
    return int(digits[-1]) if digits else 0

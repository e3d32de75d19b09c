"""A text file taken from the front: single lines, and blocks of rows of numbers that go straight into columns."""

from __future__ import annotations

from collections.abc import Sequence
from io import BufferedReader
from pathlib import Path

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.numbers import ODD_ROW, PADDING, parse_rows
from demverify.formats.reading import HalfWrittenError
from demverify.formats.rows import Picked
from demverify.formats.words import is_number, number, shown
from demverify.frames import Floats

_ROOM = 1 << 20  # bytes held at a time: stays in the processor's cache while it is parsed; no line is that long
_ODD_WORDS = 1024


def whole_text(path: Path, expected: str) -> str:
    """All of a small text file. Raises InputError where it cannot be read, or is not text: `expected` says what it should be."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        message = f"cannot be read: {error.strerror}"
        raise InputError(message, Place(path)) from None
    except UnicodeDecodeError:
        message = f"expected {expected}, got binary data"
        raise InputError(message, Place(path)) from None


class Text:
    """The lines of an open file with their numbers; a megabyte is held at a time."""

    def __init__(self, path: Path, stream: BufferedReader, start: int = 0) -> None:
        """start: the byte at which the stream stands; lines are counted from there."""
        self.path = path
        self._stream = stream
        self._buffer = bytearray(_ROOM + PADDING)
        self._bytes = np.frombuffer(self._buffer, np.uint8)
        self._origin, self._at, self._end = start, 0, 0  # what is held starts at byte _origin of the file; at and end count from there
        self._lines = 0
        self._early: HalfWrittenError | None = None

    @property
    def position(self) -> int:
        """The byte of the file that comes next."""
        return self._origin + self._at

    def place(self, back: int = 0) -> Place:
        """The line taken last, or one `back` lines before it."""
        return Place(self.path, self._lines - back)

    def line(self) -> bytes:
        """The next line with its newline; without one at the end of a file that stops inside a line, empty at its end.

        Raises HalfWrittenError at the end of a packed file that ends early.
        """
        while (newline := self._buffer.find(b"\n", self._at, self._end)) < 0:
            if not self._fill():
                newline = self._end - 1
                break
        line = bytes(self._buffer[self._at : newline + 1])
        if self._early and not line:
            raise self._early
        self._at = newline + 1
        self._lines += bool(line)
        return line

    def rows(self, table: Floats, row: int, found: Sequence[str], picked: Picked) -> int:
        """Fills table[:, row:] (picked columns, rows) with the lines that follow; gives the number of rows the table then has.

        That is less than its length only where the file ends; a last line without newline is not taken: it may have lost digits.
        found: the names of the file's columns. Raises InputError with line and column for what is not a row of numbers.
        """
        slots = np.full(len(found), -1)
        slots[picked.at] = np.arange(len(picked.at))
        odd = np.empty((max(_ODD_WORDS, len(found)), 4), np.int64)
        while row < table.shape[1]:
            stop = self._buffer.rfind(b"\n", self._at, self._end) + 1
            if stop <= self._at:
                if not self._fill():
                    break
                continue
            at, done, n_odd, status = parse_rows(self._bytes, self._at, stop, slots, table, row, table.shape[1], odd)
            for word_row, slot, start, length in odd[:n_odd].tolist():
                try:
                    table[slot, word_row] = number(bytes(self._buffer[start : start + length]))
                except ValueError:
                    raise self._bad_row(start, word_row - row, found, picked) from None
            if status == ODD_ROW:
                raise self._bad_row(at, done - row, found, picked)
            self._at, self._lines, row = at, self._lines + done - row, done
        return row

    def _fill(self) -> bool:
        """Moves what is left to the front and reads on; False at the end of the file."""
        left = self._end - self._at
        if left == _ROOM:
            message = f"a line of more than {_ROOM} bytes"
            raise InputError(message, self.place(-1))
        self._bytes[:left] = self._bytes[self._at : self._end]
        self._origin, self._at, self._end = self.position, 0, left
        try:
            self._end += self._stream.readinto1(memoryview(self._buffer)[left:_ROOM])
        except HalfWrittenError as error:
            self._early = error
        return self._end > left

    def _bad_row(self, at: int, ahead: int, found: Sequence[str], picked: Picked) -> InputError:
        """What is wrong with the row that has the byte `at`, `ahead` lines ahead."""
        start = max(self._at, self._buffer.rfind(b"\n", self._at, at) + 1)
        row = bytes(self._buffer[start : self._buffer.find(b"\n", at)])
        words = row.split()
        if len(words) != len(found):
            message = f"expected {len(found)} columns ({' '.join(found)}), got {len(words)}: {shown(row)!r}"
        else:
            column = next(j for j in picked.at if not is_number(words[j]))
            message = f"column {found[column]} expects a number, got {shown(words[column])!r}"
        return InputError(message, self.place(-1 - ahead))

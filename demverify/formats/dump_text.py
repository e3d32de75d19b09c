"""Text dumps of LAMMPS and LIGGGHTS (`dump custom`, `dump atom`, `dump local`), read as a stream.

    ITEM: TIMESTEP, step; ITEM: NUMBER OF ATOMS, n; ITEM: BOX BOUNDS pp pp pp, three rows lo hi; ITEM: ATOMS id type ..., n rows

`dump local` has ENTRIES, or the label of `dump_modify label`, for ATOMS. LAMMPS adds ITEM: UNITS (in the first frame) and ITEM: TIME on
request, LIGGGHTS ITEM: LABEL. Tilted boxes: BOX BOUNDS xy xz yz and rows lo hi tilt, around the tilted cell; general triclinic ones:
BOX BOUNDS abc origin and rows ax ay az originx, then b and c (https://docs.lammps.org/dump.html).
"""

from __future__ import annotations

from collections.abc import Iterator
from io import BufferedReader
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.dump_text_header import ITEM, Header, read_header, starts_frame
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.formats.rows import pick
from demverify.frames import Floats, Frame

if TYPE_CHECKING:
    from demverify.formats.text import Text

_WINDOW = 1 << 20  # bytes read at a time in search of a frame
_BEFORE = 1 << 12  # bytes that hold the four lines before a line of a header


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a text dump."""
    return head.startswith(ITEM)


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of a text dump, plain or packed, float64 exactly as written, rows of particles sorted by id.

    Units are those of the last frame that names them. Raises InputError with file and line for what is no whole frame, and for ids that
    are missing, not distinct or not whole numbers.
    """
    return whole_frames(_read_frames(block, reading), reading)


def split(path: Path, size: int) -> list[Block]:
    """Blocks of at least `size` bytes, cut where frames start; a packed file, which cannot be entered, is one block.

    Together the blocks hold the frames of the whole file. Only what lies between each place to cut at and the next frame is read.
    """
    with opened(path) as stream:
        if not stream.seekable():
            return [Block(path)]
        starts: list[int] = [0]
        while (start := _frame_start(stream, starts[-1] + max(1, size))) is not None:
            starts.append(start)
        units = _units(path, stream)
    return [Block(path, start, stop, units) for start, stop in pairwise([*starts, None]) if start is not None]


def _units(path: Path, stream: BufferedReader) -> str | None:
    """What the first header says; None also where it is faulty, which is left to the reader of the first block."""
    from demverify.formats.text import Text

    stream.seek(0)
    try:
        header = read_header(Text(path, stream))
    except InputError:
        return None
    return header.units if header else None


def _frame_start(stream: BufferedReader, at: int) -> int | None:
    """Where the first frame at byte `at` or after starts; None where none does."""
    origin = max(0, at - _BEFORE)
    stream.seek(origin)
    held = stream.read(at - origin)
    look = max(0, len(held) - 1)
    while piece := stream.read(_WINDOW):
        held += piece
        while (newline := held.find(b"\n" + ITEM, look)) >= 0:
            look = newline + 1
            if starts_frame(held[max(0, look - _BEFORE) : look]):
                return origin + look
        look = max(look, len(held) - len(ITEM))
        passed = max(0, look - _BEFORE)
        origin, look, held = origin + passed, look - passed, held[passed:]
    return None


def _read_frames(block: Block, reading: Reading) -> Iterator[Frame]:
    from demverify.formats.text import Text

    with opened(block.path) as stream:
        start = _frame_start(stream, block.start) if block.start else 0
        if start is None:
            return
        if block.start:
            stream.seek(start)
        text, units = Text(block.path, stream, start), block.units
        try:
            while (block.stop is None or text.position < block.stop) and (header := read_header(text)):
                units = header.units or units
                yield _read_frame(text, header, units, reading)
        except InputError as error:
            raise _in_whole_file(error, block.path, start) from None


def _in_whole_file(error: InputError, path: Path, start: int) -> InputError:
    """The error with its line counted from the start of the file instead of the block."""
    if not start or error.place is None:
        return error
    with path.open("rb") as stream:
        before = sum(stream.read(min(_WINDOW, start - at)).count(b"\n") for at in range(0, start, _WINDOW))
    return type(error)(error.message, Place(path, before + error.place.line))


def _read_frame(text: Text, header: Header, units: str | None, reading: Reading) -> Frame:
    picked = pick(header.names, reading, text.place(), local=header.local)
    table = _table(len(picked.at), header.n, text.place())
    rows = text.rows(table, 0, header.names, picked)
    if rows < header.n:
        message = f"the file ends inside a frame: {rows} of {header.n} rows of step {header.step}"
        raise HalfWrittenError(message, text.place())
    columns, box = picked.columns(table, text.place()), header.box
    return Frame(header.step, box.bounds, box.flags, columns, box.cell, header.time, units, header.dialect, header.local)


def _table(columns: int, rows: int, place: Place) -> Floats:
    """Room for the numbers of a frame. A count beyond all memory is an error of the file."""
    try:
        return np.empty((columns, rows))
    except (MemoryError, ValueError):
        message = f"{rows} rows of {columns} columns do not fit into memory"
        raise InputError(message, place) from None

"""Binary dumps of both layouts:

    LAMMPS, revision 2: i64 -len(magic), magic "DUMPCUSTOM" or "DUMPATOM", i32 endian = 1, i32 revision = 2, i64 step
    LIGGGHTS (and old LAMMPS): i64 step >= 0
    both: i64 n, i32 triclinic, i32[6] boundary, box, i32 ncol
    box: f64[6] bounds; triclinic 1: and f64[3] xy xz yz; triclinic 2 (dump_modify triclinic/general): f64[9] a b c and f64[3] origin
    LAMMPS: i32 length and units (the first frame alone), i8 flag (f64 time), i32 length and column names
    both: i32 nchunks, each i32 nvalues and f64[nvalues], rows in processor order

The LIGGGHTS layout has no column names: the reader must be told. Neither code writes `dump local` in binary: LAMMPS refuses, and
LIGGGHTS writes text whatever the file is called.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

import numpy as np

from demverify.deck.setup import Dialect
from demverify.errors import InputError, Place
from demverify.formats.cell import general, orthogonal, tilted
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.formats.rows import pick
from demverify.frames import Floats, Frame

MAGICS = (b"DUMPCUSTOM", b"DUMPATOM")
_FLAGS = "pfsm"
_ORDERS = {1: "<", 1 << 24: ">"}
_PIECE = 1 << 18  # bytes read at a time: a damaged count must not reserve memory for data that is not there
_LONGEST = 1 << 20  # bytes of text, and columns


class _Bytes:
    """The bytes of one file, taken from the front, a piece at a time."""

    def __init__(self, path: Path, stream: IO[bytes]) -> None:
        self.path = path
        self.frame = 1
        self.order = "<"
        self._stream = stream
        self._ahead = b""

    @property
    def exhausted(self) -> bool:
        self._ahead = self._ahead or self._stream.read(1)
        return not self._ahead

    def take(self, n: int) -> bytes:
        taken, self._ahead = self._ahead, b""
        while len(taken) < n:
            piece = self._stream.read(min(n - len(taken), _PIECE))
            if not piece:
                message = f"the file ends inside frame {self.frame}"
                raise HalfWrittenError(message, Place(self.path))
            taken += piece
        return taken

    def unpack(self, layout: str) -> tuple[int, ...]:
        return struct.unpack(self.order + layout, self.take(struct.calcsize("<" + layout)))

    def floats(self, n: int) -> Floats:
        return np.frombuffer(self.take(8 * n), self.order + "f8").astype(np.float64)

    def text(self) -> str:
        (length,) = self.unpack("i")
        if not 0 <= length <= _LONGEST:
            raise self.error(f"a text of {length} bytes")
        return self.take(length).decode("ascii", "backslashreplace")

    def rows(self, n: int, ncol: int, at: list[int]) -> Iterator[Floats]:
        """The columns `at` of n rows, (len(at), rows), some rows at a time."""
        most = max(1, _PIECE // (8 * ncol))
        for start in range(0, n, most):
            count = min(most, n - start)
            yield np.frombuffer(self.take(8 * count * ncol), self.order + "f8").reshape(count, ncol)[:, at].T

    def error(self, message: str) -> InputError:
        return InputError(f"frame {self.frame} is no binary dump of particles: {message}", Place(self.path))


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a binary dump: the old layout starts with a step, eight bytes, the upper ones zero."""
    return head[8:].startswith(MAGICS) or (len(head) >= 8 and head[4:8] == bytes(4)) or _old_and_big_endian(head)


def _old_and_big_endian(head: bytes) -> bool:
    """True for step and particle count with their zeros in front."""
    return len(head) >= 16 and head[:4] == head[8:12] == bytes(4) != head[12:16]


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of a binary dump of either layout, rows sorted by id, bits as written.

    Of a frame only the wanted columns are held. Raises InputError for what is not a whole frame with distinct ids.
    """
    return whole_frames(_read_frames(block, reading), reading)


def _read_frames(block: Block, reading: Reading) -> Iterator[Frame]:
    units = block.units
    with opened(block.path) as stream:
        data = _Bytes(block.path, stream)
        while not data.exhausted:
            frame = _read_frame(data, reading, units)
            units = frame.units
            yield frame
            data.frame += 1


def _read_frame(data: _Bytes, reading: Reading, units: str | None) -> Frame:
    first = data.take(8)
    data.order = "<"
    named = struct.unpack("<q", first)[0] < 0  # of either byte order: a small negative number ends and starts with large bytes
    step = _named_step(data, first) if named else struct.unpack("<q", first)[0]
    n, triclinic, *flags = data.unpack("qi6i")
    if not named and _old_and_big_endian(first + struct.pack("<q", n)):
        raise data.error("its bytes are in big-endian order; this layout is read in little-endian order alone")
    if step < 0 or n < 0 or triclinic not in (0, 1, 2) or set(flags) - {0, 1, 2, 3}:
        raise data.error(f"step {step}, {n} particles, triclinic {triclinic} (0 to 2), boundary flags {' '.join(map(str, flags))} (0 to 3)")
    box, cell = _read_box(data, triclinic)
    (ncol,) = data.unpack("i")
    units, time, names = _read_names(data, units) if named else (None, None, _no_names(data, reading, ncol))
    if len(names) != ncol or not names:
        raise data.error(f"expected names for {ncol} columns, got: {' '.join(names)}")
    picked = pick(names, reading, Place(data.path))
    columns = picked.columns(picked.joined(_read_chunks(data, n, ncol, picked.at)), Place(data.path))
    letters = [_FLAGS[flag] for flag in flags]
    boundary = (letters[0] + letters[1], letters[2] + letters[3], letters[4] + letters[5])
    return Frame(step, box, boundary, columns, cell, time, units, "lammps" if named else None)


def _named_step(data: _Bytes, first: bytes) -> int:
    """Step after the head of a LAMMPS frame; its endian word sets the byte order."""
    length = -min(struct.unpack("<q", first)[0], struct.unpack(">q", first)[0], key=abs)
    magic = data.take(length) if length <= max(map(len, MAGICS)) else b""
    if magic not in MAGICS:
        raise data.error(f"expected one of {' '.join(known.decode() for known in MAGICS)}")
    (endian,) = data.unpack("i")
    data.order = _ORDERS.get(endian, "<")
    (revision,) = data.unpack("i")
    if endian not in _ORDERS or revision != 2:
        raise data.error(f"expected byte order 1 and revision 2, got {endian} and {revision}")
    return data.unpack("q")[0]


def _read_box(data: _Bytes, triclinic: int) -> tuple[Floats, Floats | None]:
    place = Place(data.path)
    if triclinic == 2:
        return general(data.floats(9).reshape(3, 3), data.floats(3), place)
    bounds = data.floats(6).reshape(3, 2)
    return tilted(bounds, data.floats(3), place) if triclinic else (orthogonal(bounds, place), None)


def _read_names(data: _Bytes, units: str | None) -> tuple[str | None, float | None, list[str]]:
    """Units (those of an earlier frame where this one has none), time and column names."""
    units = data.text() or units
    time = float(data.floats(1)[0]) if data.unpack("b")[0] else None
    return units, time, data.text().split()


def _no_names(data: _Bytes, reading: Reading, ncol: int) -> list[str]:
    if not 0 < ncol <= _LONGEST:
        raise data.error(f"{ncol} columns")
    if reading.columns is None:
        message = f"a binary dump with no column names; name its {ncol} columns with --columns, in the order of the dump command"
        raise InputError(message, Place(data.path))
    return [""] * ncol


def _read_chunks(data: _Bytes, n: int, ncol: int, at: list[int]) -> list[Floats]:
    """The columns `at` of all particles, (len(at), some rows) a piece."""
    pieces: list[Floats] = []
    missing = n
    for _ in range(data.unpack("i")[0]):
        (values,) = data.unpack("i")
        missing -= values // ncol
        if values < 0 or values % ncol or missing < 0:
            raise data.error(f"expected {n} x {ncol} values, got {values} in one piece for the last {missing + values // ncol}")
        pieces += data.rows(values // ncol, ncol, at)
    if missing:
        raise data.error(f"expected {n} x {ncol} values, got {n - missing} x {ncol}")
    return pieces


def binary_frame(frame: Frame, names: Sequence[str], dialect: Dialect, magic: bytes = b"DUMPCUSTOM") -> bytes:
    """One frame as the engine of `dialect` writes it on one processor, rows in the order of the frame's arrays.

    names: the columns, in order. magic: b"DUMPATOM" for dump style atom (LAMMPS alone).
    """
    flags = [_FLAGS.index(letter) for letter in "".join(frame.boundary)]
    table = np.column_stack([frame.columns[name] for name in names]).astype("<f8")
    text = " ".join(names).encode()
    named = dialect == "lammps"
    parts = [
        struct.pack(f"<q{len(magic)}sii", -len(magic), magic, 1, 2) if named else b"",
        struct.pack("<qqi6i", frame.step, frame.n, 0, *flags),
        frame.box.astype("<f8").tobytes(),
        struct.pack("<i", len(names)),
        struct.pack(f"<ibi{len(text)}s", 0, 0, len(text), text) if named else b"",
        struct.pack("<ii", 1, table.size),
        table.tobytes(),
    ]
    return b"".join(parts)

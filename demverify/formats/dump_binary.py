"""Binary dumps, little-endian, of both layouts:

    LAMMPS, revision 2: i64 -len(magic), magic "DUMPCUSTOM" or "DUMPATOM", i32 endian = 1, i32 revision = 2, i64 step
    LIGGGHTS (and old LAMMPS): i64 step >= 0
    both: i64 n, i32 triclinic, i32[6] boundary, f64[6] bounds, i32 ncol
    LAMMPS: i32 length and units, i8 flag (f64 time), i32 length and column names
    both: i32 nchunks, each i32 nvalues and f64[nvalues], rows in processor order

The LIGGGHTS layout has no column names: the reader must be told.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from demverify.deck.setup import Dialect
from demverify.errors import InputError, Place
from demverify.formats.reading import Block, HalfWrittenError, Reading, whole_frames
from demverify.frames import Frame

Floats = NDArray[np.float64]

MAGICS = (b"DUMPCUSTOM", b"DUMPATOM")
_FLAGS = "pfsm"


class _Bytes:
    """The bytes of one file, taken from the front."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.frame = 1
        try:
            self._data = np.memmap(path, np.uint8, "r") if path.stat().st_size else np.empty(0, np.uint8)
        except OSError as error:
            message = f"cannot be read: {error.strerror}"
            raise InputError(message, Place(path)) from None
        self._at = 0

    @property
    def exhausted(self) -> bool:
        return self._at == len(self._data)

    def take(self, n: int) -> NDArray[np.uint8]:
        if n < 0:
            raise self.error(f"a length of {n} bytes")
        if self._at + n > len(self._data):
            message = f"the file ends inside frame {self.frame}"
            raise HalfWrittenError(message, Place(self.path))
        self._at += n
        return self._data[self._at - n : self._at]

    def unpack(self, layout: str) -> tuple[int, ...]:
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)).tobytes())

    def floats(self, n: int) -> Floats:
        return self.take(8 * n).view("<f8").astype(np.float64)

    def text(self) -> str:
        return self.take(self.unpack("i")[0]).tobytes().decode("ascii", "backslashreplace")

    def error(self, message: str) -> InputError:
        return InputError(f"frame {self.frame} is no binary dump of particles: {message}", Place(self.path))


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a binary dump: the old layout starts with a step, eight bytes, the upper ones zero."""
    return head[8:].startswith(MAGICS) or (len(head) >= 8 and head[4:8] == bytes(4))


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of a binary dump of either layout, rows sorted by id, bits as written.

    Raises InputError for anything else than whole frames of an orthogonal box with distinct ids.
    """
    return whole_frames(_read_frames(_Bytes(block.path), reading.columns), reading)


def _read_frames(data: _Bytes, columns: Sequence[str] | None) -> Iterator[Frame]:
    while not data.exhausted:
        yield _read_frame(data, columns)
        data.frame += 1


def _read_frame(data: _Bytes, columns: Sequence[str] | None) -> Frame:
    (first,) = data.unpack("q")
    named = first < 0
    if named:
        _check_magic(data, -first)
    step = data.unpack("q")[0] if named else first
    n, triclinic, *flags = data.unpack("qi6i")
    if triclinic:
        raise data.error("expected an orthogonal box, got a triclinic one")
    if n < 0 or set(flags) - {0, 1, 2, 3}:
        raise data.error(f"{n} particles, boundary flags {' '.join(map(str, flags))} (each 0 to 3)")
    box = data.floats(6).reshape(3, 2)
    (ncol,) = data.unpack("i")
    names = _read_names(data) if named else _given_names(data, columns, ncol)
    table = _read_chunks(data, n, ncol, names)
    order = np.argsort(table[:, names.index("id")], kind="stable")
    if not (np.diff(table[order, names.index("id")]) > 0).all():
        raise data.error("ids that are not distinct")
    letters = [_FLAGS[flag] for flag in flags]
    boundary = (letters[0] + letters[1], letters[2] + letters[3], letters[4] + letters[5])
    return Frame(step, box, boundary, {name: np.ascontiguousarray(table[order, j]) for j, name in enumerate(names)})


def _check_magic(data: _Bytes, length: int) -> None:
    magic = data.take(length).tobytes() if length <= max(map(len, MAGICS)) else b""
    if magic not in MAGICS:
        raise data.error(f"expected one of {' '.join(known.decode() for known in MAGICS)}")
    endian, revision = data.unpack("ii")
    if (endian, revision) != (1, 2):
        raise data.error(f"expected byte order 1 and revision 2, got {endian} and {revision}")


def _read_names(data: _Bytes) -> list[str]:
    data.text()  # units
    if data.unpack("b")[0]:
        data.floats(1)  # time
    return data.text().split()


def _given_names(data: _Bytes, columns: Sequence[str] | None, ncol: int) -> list[str]:
    if columns is None:
        raise data.error(f"this layout has no column names; pass the names of its {ncol} columns, as in the dump command")
    return list(columns)


def _read_chunks(data: _Bytes, n: int, ncol: int, names: list[str]) -> Floats:
    if len(names) != ncol or "id" not in names or len(set(names)) < ncol:
        raise data.error(f"expected names for {ncol} columns, an id among them, got: {' '.join(names)}")
    chunks: list[Floats] = []
    for _ in range(data.unpack("i")[0]):
        chunks.append(data.floats(data.unpack("i")[0]))
        if sum(map(len, chunks)) > n * ncol:
            break
    got = sum(map(len, chunks))
    if got != n * ncol:
        raise data.error(f"expected {n} x {ncol} values, got {got}")
    return np.concatenate(chunks or [np.empty(0)]).reshape(n, ncol)


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

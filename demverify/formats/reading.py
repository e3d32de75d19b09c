"""What every dump reader is given: a piece of a file, and what to make of its columns."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import BufferedReader, RawIOBase
from pathlib import Path
from typing import Any, Protocol

from demverify.errors import InputError, Place
from demverify.frames import Frame

GZIP_MAGIC = b"\x1f\x8b"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_PIECE = 1 << 14  # packed bytes at a time: even what shrinks a thousandfold stays small


@dataclass(frozen=True)
class Block:
    """The frames of a file whose first byte lies in start <= byte < stop; stop None: to the end of the file.

    Formats that cannot be entered in the middle only have blocks of a whole file. units: what the head of the file says
    (LAMMPS writes ITEM: UNITS in the first frame only).
    """

    path: Path
    start: int = 0
    stop: int | None = None
    units: str | None = None


@dataclass(frozen=True)
class Reading:
    """How dumps are read.

    columns: the names of all columns, in order, instead of those in the file (needed where a file has none).
    names: column in the file -> what it is called in the frame. keep: the names (after renaming) that are wanted; the others are not
    even looked at, so that columns of words do no harm. None: all, each of which must then hold numbers.
    half_written: told of a last frame that is not all there, which is then passed over; None: it is an error.
    """

    columns: tuple[str, ...] | None = None
    names: Mapping[str, str] = field(default_factory=dict)
    keep: frozenset[str] | None = None
    half_written: Callable[[InputError], object] | None = None

    def called(self, found: Sequence[str], place: Place) -> list[str | None]:
        """What the columns of a file are called in the frame, None for one that is not wanted, or a type that is there once more
        (`id type type x y z` is common with LIGGGHTS).

        Raises InputError when `columns` has another number of names, or when another wanted column is there twice.
        """
        if self.columns is not None and len(self.columns) != len(found):
            got = f"{len(found)} columns" + (f" ({' '.join(found)})" if any(found) else "")
            message = f"{len(self.columns)} names were given ({' '.join(self.columns)}) for {got}"
            raise InputError(message, place)
        given = [self.names.get(name, name) for name in self.columns or found]
        kept = self.wanted(given)
        names = [name if name in kept else None for name in given]
        again = [name is not None and name in names[:j] for j, name in enumerate(names)]
        if twice := [name for name, repeated in zip(names, again, strict=True) if repeated and (self.columns or name != "type")]:
            message = f"expected distinct columns, got {twice[0]} twice: {' '.join(given)}"
            raise InputError(message, place)
        return [None if repeated else name for name, repeated in zip(names, again, strict=True)]

    def wanted(self, names: Sequence[str]) -> Collection[str]:
        """Those of a file's names (after renaming) that are to be kept."""
        return names if self.keep is None else self.keep


AS_WRITTEN = Reading()
"""Every column under the name it has in the file; half a frame is an error."""


class HalfWrittenError(InputError):
    """The file ends inside a frame: a run that still goes on, or was killed."""


def whole_frames(frames: Iterator[Frame], reading: Reading) -> Iterator[Frame]:
    """The frames; of a half-written last one `reading.half_written` is told, or its HalfWrittenError goes on."""
    try:
        yield from frames
    except HalfWrittenError as error:
        if reading.half_written is None:
            raise
        reading.half_written(error)


def opened(path: Path) -> BufferedReader:
    """The bytes of a file, unpacked if it is gzip or zstd.

    Raises InputError when it cannot be read, now or, of a packed one, later; HalfWrittenError where a packed one ends early, after
    what it holds has been given.
    """
    try:
        stream = path.open("rb")
        magic = stream.read(4)
        stream.seek(0)
    except OSError as error:
        message = f"cannot be read: {error.strerror}"
        raise InputError(message, Place(path)) from None
    if magic.startswith(GZIP_MAGIC):
        return BufferedReader(_Unpacked(path, stream, lambda: zlib.decompressobj(16 + zlib.MAX_WBITS), zlib.error))
    if magic == ZSTD_MAGIC:
        import zstandard

        return BufferedReader(_Unpacked(path, stream, lambda: zstandard.ZstdDecompressor().decompressobj(), zstandard.ZstdError))
    return stream


class _Unpacker(Protocol):
    """One packed stream; a file may hold several, one after the other."""

    @property
    def eof(self) -> bool:
        """Whether it has come to its end."""

    @property
    def unused_data(self) -> bytes:
        """What came after its end."""

    def decompress(self, piece: bytes, /) -> bytes:
        """What a piece holds."""


class _Unpacked(RawIOBase):
    """The bytes of a packed file."""

    def __init__(self, path: Path, packed: BufferedReader, fresh: Callable[[], _Unpacker], damaged: type[Exception]) -> None:
        self._path, self._packed, self._fresh, self._damaged = path, packed, fresh, damaged
        self._unpacker: _Unpacker | None = None
        self._ahead = memoryview(b"")

    def readable(self) -> bool:
        return True

    def readinto(self, target: Any, /) -> int:
        """At least one byte, unless the file is at its end."""
        room = memoryview(target)
        while not self._ahead and (piece := self._piece()):
            try:
                self._unpacker = self._unpacker or self._fresh()
                self._ahead = memoryview(self._unpacker.decompress(piece))
            except self._damaged as error:
                message = f"cannot be unpacked: {error}"
                raise InputError(message, Place(self._path)) from None
        n = min(len(room), len(self._ahead))
        room[:n] = self._ahead[:n]
        self._ahead = self._ahead[n:]
        return n

    def _piece(self) -> bytes:
        """Packed bytes for `_unpacker`; none at the end of the file. Raises HalfWrittenError where that comes too early."""
        left = b""
        if self._unpacker is not None and self._unpacker.eof:
            left, self._unpacker = self._unpacker.unused_data, None
        piece = left or self._packed.read(_PIECE)
        if not piece and self._unpacker is not None:
            message = "the file ends inside its packed stream"
            raise HalfWrittenError(message, Place(self._path))
        return piece

    def close(self) -> None:
        self._packed.close()
        super().close()

"""What every dump reader is given: a piece of a file, and what to make of its columns."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, cast

from demverify.errors import InputError, Place
from demverify.frames import Frame

GZIP_MAGIC = b"\x1f\x8b"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


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
        """What the columns of a file are called in the frame, None for one that is not wanted.

        Raises InputError when `columns` has another number of names, or when two wanted columns get the same name.
        """
        if self.columns is not None and len(self.columns) != len(found):
            got = f"{len(found)} columns" + (f" ({' '.join(found)})" if any(found) else "")
            message = f"{len(self.columns)} names were given ({' '.join(self.columns)}) for {got}"
            raise InputError(message, place)
        given = [self.names.get(name, name) for name in self.columns or found]
        names = [name if self.keep is None or name in self.keep else None for name in given]
        wanted = [name for name in names if name is not None]
        if twice := {name for name in wanted if wanted.count(name) > 1}:
            message = f"expected distinct columns, got {min(twice)} twice: {' '.join(given)}"
            raise InputError(message, place)
        return names


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


def opened(path: Path) -> IO[bytes]:
    """The bytes of a file, unpacked if it is gzip or zstd. Raises InputError when it cannot be read."""
    try:
        with path.open("rb") as raw:
            magic = raw.read(4)
        if magic.startswith(GZIP_MAGIC):
            return cast("IO[bytes]", gzip.open(path))
        if magic == ZSTD_MAGIC:
            import zstandard

            return cast("IO[bytes]", zstandard.open(path, "rb"))
        return path.open("rb")
    except OSError as error:
        message = f"cannot be read: {error.strerror}"
        raise InputError(message, Place(path)) from None

"""Dumps, whatever their kind: the reader finds out by content, the writer by the file name in the deck."""

from __future__ import annotations

import glob
import gzip
import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import IO, Self, cast

import numpy as np

from demverify.deck.setup import Dialect, DumpSpec
from demverify.errors import InputError, Place
from demverify.formats.atomic import atomic_write
from demverify.formats.dump_binary import MAGICS, binary_frame, read_binary
from demverify.formats.dump_text import GZIP_MAGIC, read_text, text_frame
from demverify.frames import Frame


def read_dump(
    paths: str | Path | Sequence[str | Path], columns: Sequence[str] | None = None, *, partial_ok: bool = False
) -> Iterator[Frame]:
    """The frames of one dump file or of a series, text (also .gz) or binary, rows sorted by id, float64.

    paths: a file, a pattern such as "post/dump*.liggghts", or several of these; read in natural order (dump9 before dump10).
    columns: names of the columns of a LIGGGHTS binary dump, which has none. partial_ok: pass over a half-written last frame.
    Raises InputError where nothing matches, and for what the content is not.
    """
    for path in _expand([paths] if isinstance(paths, str | Path) else paths):
        if _is_binary(path):
            yield from read_binary(path, columns, partial_ok=partial_ok)
        else:
            yield from read_text(path, partial_ok=partial_ok)


def _expand(patterns: Sequence[str | Path]) -> list[Path]:
    found: set[Path] = set()
    for pattern in patterns:
        matches = [Path(pattern)] if Path(pattern).is_file() else [Path(name) for name in glob.glob(str(pattern))]
        if not matches:
            message = f"no dump file {pattern}; its folder has {_listing(Path(pattern).parent)}"
            raise InputError(message)
        found.update(matches)
    return sorted(found, key=_natural)


def _listing(folder: Path) -> str:
    names = sorted(entry.name for entry in folder.iterdir()) if folder.is_dir() else []
    return " ".join(names[:8] + ["..."] * (len(names) > 8)) or "nothing"


def _natural(path: Path) -> list[tuple[int, int | str]]:
    """Sort key that takes digits as numbers."""
    words = [word for word in re.split(r"(\d+)", str(path)) if word]
    return [(0, int(word)) if word.isdecimal() else (1, word) for word in words]


def _is_binary(path: Path) -> bool:
    """True for a binary dump, False for text or gzip. Raises InputError for what can be neither."""
    try:
        with path.open("rb") as stream:
            head = stream.read(64)
    except OSError as error:
        message = f"cannot be read: {error.strerror}"
        raise InputError(message, Place(path)) from None
    if head.startswith((GZIP_MAGIC, b"ITEM: ")):
        return False
    # The old layout starts with a step: eight bytes, the upper ones zero.
    if head[8:].startswith(MAGICS) or (len(head) >= 8 and head[4:8] == bytes(4)):
        return True
    what = "an empty file" if not head else f"it starts with {head[:16].decode('ascii', 'backslashreplace')!r}"
    message = f"not a dump of particles, text or binary: {what}"
    raise InputError(message, Place(path))


class DumpWriter:
    """The files of one `dump` command, written frame by frame as the engine of `dialect` would.

    A `*` in the file name makes one file a step (digits padded to spec.pad), `.bin` a binary and `.gz` a gzipped file. Folders
    are made under `folder`. A file appears when it is whole; one that takes many frames appears when the writer is closed, also
    after an interruption, with the frames that were written. Use it as a context manager.
    """

    def __init__(self, spec: DumpSpec, dialect: Dialect, folder: Path) -> None:
        """Raises InputError for a `%` in the file name (one file a processor), a sort key that is no column, a wrong format."""
        self._spec, self._dialect, self._folder = spec, dialect, folder
        if "%" in spec.file:
            message = f"dump {spec.id}: a '%' in the file name {spec.file!r} (one file a processor) is not supported"
            raise InputError(message, spec.place)
        self._sort = _sort_key(spec)
        self._files = ExitStack()
        self._stream: IO[bytes] | None = None
        self._encode(_empty(spec))

    def __enter__(self) -> Self:
        """The writer itself; nothing is opened before the first frame."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Closes the file and gives it its name."""
        self._files.__exit__(kind, error, trace)

    def write(self, frame: Frame) -> None:
        """Adds a frame; it must have the columns of the dump."""
        data = self._encode(self._sorted(frame))
        if "*" in self._spec.file:
            name = self._spec.file.replace("*", f"{frame.step:0{self._spec.pad}d}", 1)
            with ExitStack() as files:
                self._open(name, files).write(data)
        else:
            self._stream = self._stream or self._open(self._spec.file, self._files)
            self._stream.write(data)
            self._stream.flush()

    def _open(self, name: str, files: ExitStack) -> IO[bytes]:
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = files.enter_context(atomic_write(path, keep=files is self._files))
        if name.endswith(".gz"):
            return cast("IO[bytes]", files.enter_context(gzip.open(temporary, "wb", 6)))
        return files.enter_context(temporary.open("wb"))

    def _encode(self, frame: Frame) -> bytes:
        spec = self._spec
        if spec.file.endswith(".bin"):
            return binary_frame(frame, spec.columns, self._dialect, b"DUMPATOM" if spec.style == "atom" else b"DUMPCUSTOM")
        return text_frame(frame, spec.columns, self._dialect, spec.format, spec.place)

    def _sorted(self, frame: Frame) -> Frame:
        if self._sort is None:
            return frame
        name, sign = self._sort
        order = np.argsort(sign * frame.columns[name], kind="stable")
        return Frame(frame.step, frame.box, frame.boundary, {key: column[order] for key, column in frame.columns.items()})


def _sort_key(spec: DumpSpec) -> tuple[str, int] | None:
    """Column and sign of `dump_modify sort`: off, id, N or -N (descending) for the N-th column."""
    if spec.sort in (None, "off", "id"):  # frames come sorted by id
        return None
    digits = (spec.sort or "").removeprefix("-")
    if not digits.isdecimal() or not 1 <= int(digits) <= len(spec.columns):
        message = f"dump {spec.id}: sort key {spec.sort!r} is not off, id or a column from 1 to {len(spec.columns)}"
        raise InputError(message, spec.place)
    return spec.columns[int(digits) - 1], -1 if (spec.sort or "").startswith("-") else 1


def _empty(spec: DumpSpec) -> Frame:
    return Frame(0, np.zeros((3, 2)), ("pp", "pp", "pp"), {name: np.empty(0) for name in spec.columns})

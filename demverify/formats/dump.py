"""Dumps, whatever their kind: the reader finds out by content, the writer by the file name in the deck."""

from __future__ import annotations

import glob
import gzip
import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from types import ModuleType, TracebackType
from typing import IO, Self, cast

import numpy as np

from demverify.deck.setup import Dialect, DumpSpec
from demverify.errors import InputError, Place
from demverify.formats import dump_bare, dump_binary, dump_text, dump_vtk, dump_vtp, dump_yaml, h5md
from demverify.formats.atomic import atomic_write
from demverify.formats.dump_binary import binary_frame
from demverify.formats.dump_text_writer import text_frame
from demverify.formats.reading import AS_WRITTEN, Block, Reading, opened, whole_frames
from demverify.frames import Frame

_READERS = (dump_text, dump_yaml, dump_vtk, dump_vtp, h5md, dump_binary, dump_bare)
"""Each has recognises(head) and read(block, reading); the first that recognises reads."""
_BOX = "boundingBox_"  # LIGGGHTS writes one beside each vtk file
_OTHERS = {b"# Time-averaged": "output of fix ave/time", b"LAMMPS (": "a log of LAMMPS", b"LIGGGHTS (": "a log of LIGGGHTS"}
_HEAD = 4096
_BLOCK = 1 << 25  # bytes: a tenth of a second of reading
_STEP = re.compile(rb"ITEM: TIMESTEP\s+(-?\d+)\s")


def read_dump(paths: str | Path | Sequence[str | Path], reading: Reading = AS_WRITTEN) -> Iterator[Frame]:
    """The frames of one dump file or of a series, of any kind and packed or not, float64, rows of particles sorted by id.

    paths: a file, a pattern such as "post/dump*.liggghts", or several of these (see dump_files).
    Raises InputError where nothing matches, and for what the content is not.
    """
    for path in dump_files([paths] if isinstance(paths, str | Path) else paths):
        yield from read_block(Block(path), reading)


def blocks_of(files: Sequence[Path]) -> Iterator[Block]:
    """Pieces of files that can be read side by side, in order. Raises InputError for a file that is no dump."""
    for path in files:
        yield from split(path, _BLOCK)


def split(path: Path, size: int) -> list[Block]:
    """Blocks of a file, of at least `size` bytes, that together hold its frames; one block where it cannot be entered in the middle.

    Raises InputError for a file that is no dump.
    """
    return dump_text.split(path, size) if reader_of(path) is dump_text else [Block(path)]


def read_block(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of one block. Raises InputError for a file that is no dump."""
    return whole_frames(_read_block(block, reading), reading)


def _read_block(block: Block, reading: Reading) -> Iterator[Frame]:
    yield from reader_of(block.path).read(block, reading)


def reader_of(path: Path) -> ModuleType:
    """The reader for a file, by its content. Raises InputError."""
    try:
        with opened(path) as stream:
            head = stream.read1(_HEAD)  # what there is, also of a packed file that ends early
    except OSError as error:
        message = f"cannot be read: {error}"
        raise InputError(message, Place(path)) from None
    for reader in _READERS:
        if reader.recognises(head):
            return reader
    kind = next((kind for start, kind in _OTHERS.items() if head.startswith(start)), "an empty file" if not head else "")
    what = kind or f"it starts with {head[:16].decode('ascii', 'backslashreplace')!r}"
    message = f"not a dump of particles, text or binary: {what}"
    raise InputError(message, Place(path))


def has_names(path: Path) -> bool:
    """False for the kinds of dumps that do not name their columns. Raises InputError for a file that is no dump."""
    reader = reader_of(path)
    if reader is not dump_binary:
        return reader is not dump_bare
    with opened(path) as stream:
        return stream.read(_HEAD)[8:].startswith(dump_binary.MAGICS)


def dump_files(patterns: Sequence[str | Path]) -> list[Path]:
    """The files that names and patterns mean, in the order of their first steps; where a head does not tell the step, of their names,
    dump9 before dump10. Raises InputError where nothing matches."""
    found: set[Path] = set()
    for pattern in patterns:
        matches = [Path(pattern)] if Path(pattern).is_file() else [Path(name) for name in glob.glob(str(pattern))]
        if not matches:
            message = f"no dump file {pattern}; its folder has {_listing(Path(pattern).parent)}"
            raise InputError(message)
        found.update(matches)
    boxes = {path for path in found if _BOX in path.name}
    found -= boxes if boxes < found else set()
    steps = {path: _first_step(path) for path in found} if len(found) > 1 else {}
    return sorted(found, key=lambda path: (steps.get(path, 0) if None not in steps.values() else 0, _natural(path)))


def _first_step(path: Path) -> int | None:
    """What the head of a text dump says."""
    with suppress(OSError, InputError), opened(path) as stream:
        told = _STEP.search(stream.read1(_HEAD))
        return int(told[1]) if told else None
    return None


def _listing(folder: Path) -> str:
    names = sorted(entry.name for entry in folder.iterdir()) if folder.is_dir() else []
    return " ".join(names[:8] + ["..."] * (len(names) > 8)) or "nothing"


def _natural(path: Path) -> list[tuple[int, int | str]]:
    """Sort key that takes digits as numbers."""
    words = [word for word in re.split(r"(\d+)", str(path)) if word]
    return [(0, int(word)) if word.isdecimal() else (1, word) for word in words]


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
        return text_frame(frame, spec.columns, self._dialect, spec.format, spec.place, "ENTRIES" if spec.style == "local" else "ATOMS")

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

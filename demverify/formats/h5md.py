"""Trajectories in H5MD 1.1 (de Buyl, Colberg, Höfling 2014, doi 10.1016/j.cpc.2014.01.018; https://www.nongnu.org/h5md/h5md.html).

    /particles/all/box           attributes dimension, boundary (periodic | none), boundary_flags (LAMMPS letters: "pp" "fs" ...)
    /particles/all/box/edges     (frame, 3) lengths; also lower and upper, which H5MD lacks (and faces s and m move)
    /particles/all/position      x y z, (frame, row, 3); so velocity v, force f and, beyond H5MD, omega, torque tq, image i
    /particles/all/species       the type, (frame, row); any other column goes under its own name: id, radius, mass, ...; of
                                 superquadrics shapex shapey shapez (semi-axes) blockiness1 2 quat1..4 (w x y z), angmom, inertia
    /observables/all/count       (frame,) number of particles

Each of these is a group of value, step and time; step and time are one dataset, linked. Numbers are float64 or int64. Where
particles come and go, arrays are as wide as the largest frame: rows from count on have id 0 and NaN. No units are written, those
of the deck hold (MDAnalysis refuses "m": load with convert_units=False).
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from demverify.errors import InputError, Place
from demverify.formats.atomic import atomic_write
from demverify.formats.columns import INTEGER_COLUMNS
from demverify.formats.reading import AS_WRITTEN, Block, Reading
from demverify.formats.rows import pick
from demverify.frames import Frame

if TYPE_CHECKING:
    import h5py

    from demverify.deck.setup import Dialect

Floats = NDArray[np.float64]

_MAGIC = b"\x89HDF\r\n\x1a\n"
_CREATOR = "demverify"
_PREFIXES = {"position": "", "velocity": "v", "force": "f", "omega": "omega", "torque": "tq", "image": "i"}
_VECTORS = {element: (prefix + "x", prefix + "y", prefix + "z") for element, prefix in _PREFIXES.items()}
_GROUP = "particles/all"
_COUNT = "observables/all/count"
_SECONDS = 1.0  # a killed run loses no frame older than this
_PENDING_BYTES = 1 << 24
_CHUNK_BYTES = 1 << 16


@dataclass(frozen=True)
class _Element:
    """A dataset of /particles/all and the columns in it."""

    name: str
    columns: tuple[str, ...]

    @property
    def path(self) -> str:
        return f"{_GROUP}/{self.name}"

    @property
    def dtype(self) -> type[np.int64 | np.float64]:
        return np.int64 if INTEGER_COLUMNS.issuperset(self.columns) else np.float64

    @property
    def width(self) -> tuple[int, ...]:
        return (3,) if self.name in _VECTORS else ()

    def gather(self, frame: Frame) -> NDArray[Any]:
        """(n,) or (n, 3), a copy."""
        table = np.column_stack([frame.columns[name] for name in self.columns]).astype(self.dtype)
        return table if self.width else table[:, 0]


@dataclass(frozen=True)
class _Record:
    """A frame that waits to be written; `arrays` are those of the elements, in order."""

    step: int
    time: float
    n: int
    box: Floats
    arrays: list[NDArray[Any]]


def _elements(columns: Sequence[str]) -> list[_Element]:
    vectors = [_Element(name, axes) for name, axes in _VECTORS.items() if set(axes) <= set(columns)]
    taken = {column for vector in vectors for column in vector.columns}
    return vectors + [_Element("species" if name == "type" else name, (name,)) for name in columns if name not in taken]


class TrajectoryWriter:
    """Streams frames into an H5MD file; use it as a context manager.

    The file grows as `path.part` and becomes `path` when the writer is closed, also after an interruption, with every frame that
    was written. After SIGKILL `path.part` stays and read_h5md reads it, but for the last second (SWMR mode keeps it sound).
    No frame, no file. Nothing is compressed: the digits of a moving bed hardly shrink.
    """

    def __init__(self, path: Path) -> None:
        """Opens nothing: the first frame does, since it says which columns there are."""
        self._path = path
        self._files = ExitStack()
        self._file: h5py.File | None = None
        self._elements: list[_Element] = []
        self._columns: set[str] = set()
        self._pending: list[_Record] = []
        self._drained = 0.0

    def __enter__(self) -> Self:
        """The writer itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Writes what is pending, closes, and gives the file its name."""
        try:
            self._drain()
        finally:
            self._files.__exit__(kind, error, trace)

    def write(self, frame: Frame, time: float) -> None:
        """Adds a frame at `time`; its arrays are copied. Raises InputError when its columns are not those of the first frame."""
        if self._file is None:
            self._elements, self._columns = _elements(list(frame.columns)), set(frame.columns)
            self._file = self._create(frame)
        if set(frame.columns) != self._columns:
            message = f"step {frame.step} has columns {' '.join(frame.columns)}, not {' '.join(sorted(self._columns))} as before"
            raise InputError(message, Place(self._path))
        arrays = [element.gather(frame) for element in self._elements]
        self._pending.append(_Record(frame.step, time, frame.n, frame.box.copy(), arrays))
        waiting = len(self._pending) * sum(array.nbytes for array in arrays)
        if clock.monotonic() - self._drained > _SECONDS or waiting > _PENDING_BYTES:
            self._drain()

    def _create(self, frame: Frame) -> h5py.File:
        import h5py

        part = self._files.enter_context(atomic_write(self._path, keep=True))
        file = self._files.enter_context(h5py.File(part, "w", libver="latest"))
        _describe(file, frame)
        step, time = _series(file, "step", (), np.int64), _series(file, "time", (), np.float64)
        n = max(1, frame.n)
        shapes = {element.path: ((n, *element.width), element.dtype) for element in self._elements}
        shapes |= {f"{_GROUP}/box/{name}": ((3,), np.float64) for name in ("edges", "lower", "upper")}
        for path, (shape, dtype) in (shapes | {_COUNT: ((), np.int64)}).items():
            _series(file, f"{path}/value", shape, dtype)
            file[path]["step"], file[path]["time"] = step, time
        del file["step"], file["time"]  # the links in the groups keep them
        file.swmr_mode = True
        return file

    def _drain(self) -> None:
        """Appends the pending frames; the count comes last, so that a reader finds every frame it counts."""
        self._drained = clock.monotonic()
        if self._file is None or not self._pending:
            return
        for i, element in enumerate(self._elements):
            _append_padded(self._file[f"{element.path}/value"], [record.arrays[i] for record in self._pending])
        box = np.stack([record.box for record in self._pending])
        for name, value in {"edges": box[:, :, 1] - box[:, :, 0], "lower": box[:, :, 0], "upper": box[:, :, 1]}.items():
            _append(self._file[f"{_GROUP}/box/{name}/value"], value)
        _append(self._file[f"{_COUNT}/step"], np.array([record.step for record in self._pending]))
        _append(self._file[f"{_COUNT}/time"], np.array([record.time for record in self._pending]))
        _append(self._file[f"{_COUNT}/value"], np.array([record.n for record in self._pending]))
        self._file.flush()
        self._pending = []


def _describe(file: h5py.File, frame: Frame) -> None:
    file.create_group("h5md").attrs["version"] = np.array([1, 1])
    file.create_group("h5md/author").attrs["name"] = "demverify"
    creator = file.create_group("h5md/creator")
    creator.attrs["name"], creator.attrs["version"] = _CREATOR, version("demverify")
    box = file.create_group(f"{_GROUP}/box")
    box.attrs["dimension"] = 3
    box.attrs["boundary"] = ["periodic" if flags == "pp" else "none" for flags in frame.boundary]
    box.attrs["boundary_flags"] = list(frame.boundary)


def _series(file: h5py.File, path: str, shape: tuple[int, ...], dtype: type) -> h5py.Dataset:
    """A dataset (0, *shape) that can grow in frames and rows."""
    rows = min(256, max(1, _CHUNK_BYTES // (8 * int(np.prod(shape)))))
    fill = 0 if dtype is np.int64 else np.nan
    limits = (None, *(None if i == 0 and len(shape) > 0 else length for i, length in enumerate(shape)))
    return file.create_dataset(path, (0, *shape), dtype, maxshape=limits, chunks=(rows, *shape), fillvalue=fill)


def _append(dataset: h5py.Dataset, block: NDArray[Any]) -> None:
    frames = len(dataset)
    dataset.resize(frames + len(block), axis=0)
    dataset[frames:] = block


def _append_padded(dataset: h5py.Dataset, arrays: list[NDArray[Any]]) -> None:
    """Frames of (n,) or (n, 3) with n of their own; a frame with more rows than ever widens the dataset."""
    rows = max(dataset.shape[1], *(len(array) for array in arrays))
    dataset.resize(rows, axis=1)
    block = np.full((len(arrays), rows, *arrays[0].shape[1:]), dataset.fillvalue, dataset.dtype)
    for target, array in zip(block, arrays, strict=True):
        target[: len(array)] = array
    _append(dataset, block)


def recognises(head: bytes) -> bool:
    """True when a file that starts so is HDF5."""
    return head.startswith(_MAGIC)


def read_h5md(path: Path) -> Iterator[Frame]:
    """The frames of a trajectory written by TrajectoryWriter, also of the `.part` that a killed run left.

    Every number comes back as it was. Raises InputError for any other file.
    """
    return read(Block(path), AS_WRITTEN)


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The frames of such a trajectory, one at a time, with their time; datasets without a wanted column are not read.

    Raises InputError for any other file, H5MD of other programs too: they have no counts and boundary flags where these are.
    """
    place = Place(block.path)
    try:
        with _opened(block.path) as file:
            yield from _read_frames(file, reading, place)
    except InputError:
        raise
    except (LookupError, OSError, RuntimeError, TypeError, ValueError) as error:  # of h5py, for one damage or another
        why = " ".join(str(error).split())[:200].strip("'\"")
        message = f"not a trajectory of demverify, or damaged: {why}"
        raise InputError(message, place) from None


def _read_frames(file: h5py.File, reading: Reading, place: Place) -> Iterator[Frame]:
    _check_creator(file, place)
    group, count = file[_GROUP], file[_COUNT]
    owners = [(element, i) for element in map(_element, sorted(set(group) - {"box"})) for i in range(len(element.columns))]
    picked = pick([element.columns[i] for element, i in owners], reading, place)
    wanted = [owners[at] for at in picked.at]
    datasets = {element: file[f"{element.path}/value"] for element, _ in wanted}
    flags = cast("tuple[str, str, str]", tuple(str(flag) for flag in group["box"].attrs["boundary_flags"]))
    dialect: Dialect | None = "liggghts" if "shapex" in group else None  # shapes are semi-axes there
    for i, n in enumerate(count["value"]):
        tables = {element: _rows(dataset, i, int(n), place) for element, dataset in datasets.items()}
        table = np.array([tables[element][:, j] for element, j in wanted])
        box = np.column_stack([group[f"box/{end}/value"][i] for end in ("lower", "upper")])
        yield Frame(int(count["step"][i]), box, flags, picked.columns(table, place), dialect=dialect, time=float(count["time"][i]))


def _check_creator(file: h5py.File, place: Place) -> None:
    creator = file["h5md/creator"].attrs["name"] if "h5md/creator" in file else "no H5MD creator"
    if creator != _CREATOR:
        message = f"not a trajectory of demverify: an HDF5 file of {str(creator)[:40]!r}; other programs' H5MD lacks counts and boundary flags"
        raise InputError(message, place)


def _element(name: str) -> _Element:
    return _Element(name, _VECTORS.get(name, ("type" if name == "species" else name,)))


def _rows(dataset: h5py.Dataset, frame: int, n: int, place: Place) -> Floats:
    """(n, columns)."""
    if not 0 <= n <= dataset.shape[1]:
        message = f"frame {frame + 1} has {n} particles, {dataset.name} only {dataset.shape[1]}"
        raise InputError(message, place)
    return np.asarray(dataset[frame, :n], dtype=np.float64).reshape(n, -1 if n else int(np.prod(dataset.shape[2:])))


def _opened(path: Path) -> h5py.File:
    import h5py

    try:
        return h5py.File(path, "r")
    except OSError as error:
        why = str(error).splitlines()[0]
        if "already open" in why or "unable to lock" in why:  # a writer was killed, or is still at it
            return h5py.File(path, "r", libver="latest", swmr=True)
        message = f"not an HDF5 file (a packed one must be unpacked first), or damaged: {why}"
        raise InputError(message, Place(path)) from None

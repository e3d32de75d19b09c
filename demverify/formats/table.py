"""Tables of results, written chunk by chunk: text on a stream, CSV, JSON, HDF5. A file appears when it is whole.

A chunk maps column names to equally long sequences of numbers, words, or None for what is not known. CSV and JSON keep every digit; what
is not known or not finite is empty in CSV, null in JSON, NaN in HDF5 and `-` or `nan` in text.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Protocol

import numpy as np

from demverify.formats.atomic import atomic_write

if TYPE_CHECKING:
    import h5py

Chunk = Mapping[str, Sequence[Any]]


class Table(Protocol):
    """Where chunks go."""

    def write(self, chunk: Chunk) -> None:
        """Adds rows."""


def rows_of(chunk: Chunk) -> Iterator[tuple[Any, ...]]:
    """The rows of a chunk, as Python's own numbers and words."""
    columns = [values.tolist() if isinstance(values, np.ndarray) else values for values in chunk.values()]
    return zip(*columns, strict=True)


class TextTable:
    """Columns one below the other, as wide as their first rows need; numbers in full."""

    def __init__(self, stream: IO[str]) -> None:
        """Nothing is written before the first chunk."""
        self._stream = stream
        self._widths: list[int] | None = None

    def write(self, chunk: Chunk) -> None:
        """Adds rows; the first chunk also writes the names."""
        rows = [[_word(value) for value in row] for row in rows_of(chunk)]
        if self._widths is None:
            rows.insert(0, list(chunk))
            self._widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            print("  ".join(word.ljust(width) for word, width in zip(row, self._widths, strict=True)).rstrip(), file=self._stream)


def _word(value: object) -> str:
    if value is None:
        return "-"
    return repr(value) if isinstance(value, float) else str(value)


class _Csv:
    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._named = False

    def write(self, chunk: Chunk) -> None:
        if not self._named:
            self._stream.write(",".join(chunk) + "\n")
            self._named = True
        for row in rows_of(chunk):
            self._stream.write(",".join("" if _unknown(value) else _word(value) for value in row) + "\n")


class _Json:
    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._between = ""

    def write(self, chunk: Chunk) -> None:
        for row in rows_of(chunk):
            values = {name: None if _unknown(value) else value for name, value in zip(chunk, row, strict=True)}
            self._stream.write(self._between + json.dumps(values, allow_nan=False))
            self._between = ",\n "


class _H5:
    def __init__(self, file: h5py.File) -> None:
        self._file = file

    def write(self, chunk: Chunk) -> None:
        for name, values in chunk.items():
            column = _array(values)
            if name not in self._file:
                self._file.create_dataset(name, (0,), column.dtype, maxshape=(None,), chunks=(min(65536, max(1024, len(column))),))
            dataset = self._file[name]
            rows = len(dataset)
            dataset.resize(rows + len(column), axis=0)
            dataset[rows:] = column


def _array(values: Sequence[Any]) -> np.ndarray[Any, Any]:
    """int64, float64 (None: NaN) or words of at most 32 letters."""
    if any(isinstance(value, str) for value in values[:1]):
        return np.array(values, dtype="S32")
    return np.asarray(values) if isinstance(values, np.ndarray) else np.array([np.nan if v is None else v for v in values])


def _unknown(value: object) -> bool:
    return value is None or (isinstance(value, float) and not math.isfinite(value))


@contextmanager
def csv_table(path: Path) -> Iterator[Table]:
    """A CSV file with a line of names. Raises InputError when it cannot be written."""
    with atomic_write(path) as part, part.open("w", encoding="utf-8") as stream:
        yield _Csv(stream)


@contextmanager
def json_table(path: Path) -> Iterator[Table]:
    """A JSON list with an object a row. Raises InputError when it cannot be written."""
    with atomic_write(path) as part, part.open("w", encoding="utf-8") as stream:
        stream.write("[")
        yield _Json(stream)
        stream.write("]\n")


@contextmanager
def h5_table(path: Path, **attributes: str) -> Iterator[Table]:
    """An HDF5 file with a dataset a column. Raises InputError when it cannot be written."""
    import h5py

    with ExitStack() as files:
        part = files.enter_context(atomic_write(path))
        file = files.enter_context(h5py.File(part, "w"))
        file.attrs.update(attributes)
        yield _H5(file)

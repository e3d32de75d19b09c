"""Tables of results: what is written in pieces is read back whole, every digit, and half a file is never there."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats.table import Table, TextTable, csv_table, h5_table, json_table

finite = st.floats(allow_nan=False, allow_infinity=False)
chunks = st.lists(st.lists(st.tuples(st.integers(0, 2**53), st.none() | finite, finite), max_size=4), min_size=1, max_size=4)
Writer = Callable[[Path], AbstractContextManager[Table]]


def columns(rows: list[tuple[int, float | None, float]]) -> dict[str, list[Any]]:
    """Rows as a chunk."""
    return {name: [row[k] for row in rows] for k, name in enumerate(("step", "time", "erotate"))}


def write(writer: Writer, path: Path, pieces: list[list[tuple[int, float | None, float]]]) -> None:
    """All pieces into one file."""
    with writer(path) as table:
        for rows in pieces:
            table.write(columns(rows))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(pieces=chunks)
def test_csv_and_json_keep_every_digit(pieces: list[list[tuple[int, float | None, float]]], tmp_path: Path) -> None:
    """Law: what is read back is what was written, bit for bit, in however many pieces it came; unknown is empty and null."""
    rows = [row for piece in pieces for row in piece]
    write(csv_table, tmp_path / "t.csv", pieces)
    with (tmp_path / "t.csv").open() as stream:
        got = [(int(r["step"]), float(r["time"]) if r["time"] else None, float(r["erotate"])) for r in csv.DictReader(stream)]
    assert got == rows
    write(json_table, tmp_path / "t.json", pieces)
    assert [tuple(item.values()) for item in json.loads((tmp_path / "t.json").read_text())] == rows


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(pieces=chunks)
def test_hdf5_has_a_dataset_a_column(pieces: list[list[tuple[int, float | None, float]]], tmp_path: Path) -> None:
    """Law: datasets hold the rows of all pieces; unknown is NaN."""
    write(h5_table, tmp_path / "t.h5", pieces)
    with h5py.File(tmp_path / "t.h5") as file:
        for name, values in columns([row for piece in pieces for row in piece]).items():
            np.testing.assert_array_equal(file[name][:], np.array([np.nan if v is None else v for v in values], dtype=np.float64))


def test_not_finite_is_null_in_json() -> None:
    """Law: JSON has no NaN; text has."""
    stream = io.StringIO()
    TextTable(stream).write({"step": [1], "erotate": [float("nan")], "ke": [None]})
    assert stream.getvalue().split() == ["step", "erotate", "ke", "1", "nan", "-"]


@pytest.mark.parametrize("writer", [csv_table, json_table, h5_table])
def test_a_file_is_whole_or_not_there(writer: Writer, tmp_path: Path) -> None:
    """Law: an error while writing leaves no file, and a folder that does not exist is one clear line."""
    with pytest.raises(RuntimeError), writer(tmp_path / "t") as table:
        table.write(columns([(1, 0.5, 2.0)]))
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match="there is no folder"), writer(tmp_path / "no" / "t"):
        pass

"""Dumps without header: whose frames the ids part, and which are refused where they cannot."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats import dump_bare
from demverify.formats.dump import read_dump
from demverify.formats.reading import Block, HalfWrittenError, Reading
from demverify.frames import UNKNOWN_BOUNDARY, Frame
from tests.demverify.formats.samples import DATA

NAMED = Reading(columns=("id", "x"))


def read(path: Path, rows: list[tuple[float, float]], reading: Reading = NAMED, end: bytes = b"") -> list[Frame]:
    """The frames of a file with these rows."""
    path.write_bytes(b"".join(b"%.17g %.17g\n" % row for row in rows) + end)
    return list(dump_bare.read(Block(path), reading))


def test_a_real_file_of_three_frames() -> None:
    """Law: `dump_modify header no` of the run that wrote triclinic.txt: the same particles, with 15 digits for 6."""
    got = list(read_dump(DATA / "lammps" / "headless.txt", Reading(columns=("id", "type", "x", "y", "z", "radius"))))
    assert [f.step for f in got] == [0, 1, 2]
    for bare, full in zip(got, read_dump(DATA / "lammps" / "triclinic.txt"), strict=True):
        assert np.isnan(bare.box).all()
        assert (bare.boundary, bare.cell, bare.time, bare.units, bare.dialect) == (UNKNOWN_BOUNDARY, None, None, None, None)
        for name, values in bare.columns.items():
            np.testing.assert_allclose(values, full.columns[name], rtol=5e-6)  # six digits in triclinic.txt


@given(st.sets(st.integers(1, 10**6), min_size=1, max_size=9), st.integers(1, 5), st.integers(0, 2**32))
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_ids_part_the_frames(tmp_path: Path, ids: set[int], frames: int, seed: int) -> None:
    """Law: k times the same ids, each time in another order, are k frames; one time is one frame, of the step in its name."""
    rng = np.random.default_rng(seed)
    rows = [(i, 1000.0 * i + k) for k in range(frames) for i in rng.permutation(sorted(ids)).tolist()]
    got = read(tmp_path / "dump.2.70.txt", rows)
    assert [f.step for f in got] == (list(range(frames)) if frames > 1 else [70])
    for k, one in enumerate(got):
        assert one.columns["id"].tolist() == sorted(ids)
        assert one.columns["x"].tolist() == [1000.0 * i + k for i in sorted(ids)]


@pytest.mark.parametrize(("name", "step"), [("dump.100.txt", 100), ("d7_0012", 12), ("dump", 0), ("dump.5.txt.gz", 5)])
def test_the_step_is_in_the_name(tmp_path: Path, name: str, step: int) -> None:
    """Law: the digits nearest the end of the name, no matter how the file is packed."""
    content = b"2 0.5\n1 0.25\n"
    (tmp_path / name).write_bytes(gzip.compress(content) if name.endswith("gz") else content)
    (got,) = read_dump(tmp_path / name, NAMED)
    assert (got.step, got.columns["x"].tolist()) == (step, [0.25, 0.5])


def test_frames_larger_than_what_is_read_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: the number of rows read at a time shows nowhere."""
    rows = [(i, float(k)) for k in range(4) for i in range(1, 8)]
    for at_a_time in (1, 2, 5, 7, 8, 27, 28, 29):
        monkeypatch.setattr(dump_bare, "_ROWS", at_a_time)
        assert [f.columns["x"].tolist() for f in read(tmp_path / "d", rows)] == [[float(k)] * 7 for k in range(4)]


@pytest.mark.parametrize(
    ("ids", "message"),
    [
        ([1, 2, 3, 1, 2, 4], "d:6: rows 4 to 6 do not hold the ids of the first 3 rows: where a frame ends cannot be told"),
        ([1, 2, 3, 1, 2, 1, 2, 3], "d:6: rows 4 to 6 do not hold the ids"),
        ([1, 2, 3, 2, 3, 4], "d:6: rows 4 to 6 do not hold the ids"),
        ([1.5, 2], "d:2: id 1.5 in the frame that ends here: expected a whole number"),
        ([float("nan"), 2], "d:2: id nan in the frame"),
    ],
)
def test_a_boundary_that_cannot_be_told_is_refused(tmp_path: Path, ids: list[float], message: str) -> None:
    """Law: where particles come, go or have no id, the file is refused with the rows in question."""
    with pytest.raises(InputError, match=message):
        read(tmp_path / "d", [(i, 0.0) for i in ids])


def test_a_half_written_end(tmp_path: Path) -> None:
    """Law: fewer rows than a frame has, or half a row, are told; the frames before are kept."""
    rows = [(i, 0.5) for _ in range(3) for i in (1, 2, 3)]
    for cut, end in ((8, b""), (9, b"1 0."), (6, b"1"), (2, b"3 0.5"), (0, b"1")):
        told: list[InputError] = []
        got = read(tmp_path / "d", rows[:cut], Reading(columns=NAMED.columns, half_written=told.append), end)
        assert len(got) == cut // 3
        assert len(told) == 1
        with pytest.raises(HalfWrittenError, match="the file ends inside a"):
            read(tmp_path / "d", rows[:cut], end=end)


def test_a_packed_file_that_ends_early(tmp_path: Path) -> None:
    """Law: whole frames come first, then the end is told; a part of the first frame is not taken for a frame."""
    rng = np.random.default_rng(1)
    content = gzip.compress(b"".join(b"%d %.17g\n" % (i, rng.random()) for _ in range(3) for i in range(1, 51)))
    told: list[InputError] = []
    reading = Reading(columns=NAMED.columns, half_written=told.append)
    for cut in range(20, len(content), 11):
        told.clear()
        (tmp_path / "d.gz").write_bytes(content[:cut])
        got = [f.n for f in read_dump(tmp_path / "d.gz", reading)]
        assert got == [50] * min(len(got), 3)
        assert len(told) == 1
    assert got  # the last cut is in the last frame


@pytest.mark.parametrize(
    ("reading", "message"),
    [
        (Reading(), "d:1: a dump without header: name its columns with --columns"),
        (Reading(columns=("tag", "x")), "d:1: expected distinct columns with an id among them, got: tag x"),
        (Reading(columns=("id", "id")), "expected distinct columns, got id twice"),
        (Reading(columns=("id", "x", "y")), "d:1: expected 3 columns .id x y., got 2: '1 0.5'"),
    ],
)
def test_columns_must_be_named(tmp_path: Path, reading: Reading, message: str) -> None:
    """Law: without names, an id among them, nothing is read; names that do not fit the rows are refused."""
    with pytest.raises(InputError, match=message):
        read(tmp_path / "d", [(1, 0.5)], reading)


def test_what_is_recognised() -> None:
    """Law: a first line of numbers, and nothing else."""
    assert dump_bare.recognises(b"1 2 -3.5e-7\n4 five 6\n")
    assert dump_bare.recognises(b"7")
    assert not any(map(dump_bare.recognises, (b"", b"\n1 2\n", b"id x\n1 2\n", b"1,2,3\n", b"1_0 2\n", b"ITEM: TIMESTEP\n")))


def test_unwanted_columns_may_hold_words(tmp_path: Path) -> None:
    """Law: a column that is not kept is not looked at."""
    (tmp_path / "d").write_bytes(b"2 0.5 Cu\n1 0.25 ****\n")
    (got,) = dump_bare.read(Block(tmp_path / "d"), Reading(columns=("id", "x", "element"), keep=frozenset({"x"})))
    assert {name: values.tolist() for name, values in got.columns.items()} == {"x": [0.25, 0.5]}

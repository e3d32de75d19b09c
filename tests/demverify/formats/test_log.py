"""Logs of both engines: tables, what interrupts them, why a run stopped."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats.log import last_error, merge_runs, read_thermo, warnings_in
from demverify.frames import Thermo
from tests.demverify.formats.samples import DATA

HEAD = "Per MPI rank memory allocation (min/avg/max) = 9.9 | 9.9 | 9.9 Mbytes\n   Step         KinEng    \n"
TAIL = "Loop time of 0.1 on 1 procs for 20 steps with 3 atoms\n"


def log(tmp_path: Path, text: str) -> Path:
    """A log with this text."""
    path = tmp_path / "log.x"
    path.write_text(text)
    return path


def test_lammps_log_with_three_styles() -> None:
    """Law: custom, multi and one are read, one table a run, named as printed; multi has Step and CPU first."""
    custom, multi, one = read_thermo(DATA / "lammps" / "log.lammps")
    assert custom.columns == ("Step", "Atoms", "KinEng", "c_er", "Volume")
    assert custom["Step"].tolist() == [0, 100, 200]
    assert custom["KinEng"][0] == 0.0066442115
    assert multi.columns[:4] == ("Step", "CPU", "TotEng", "KinEng")
    assert multi["Step"].tolist() == [200, 300]
    assert one.columns[:3] == ("Step", "Temp", "E_pair")
    assert one["Step"].tolist() == [300, 400]


def test_liggghts_log() -> None:
    """Law: LIGGGHTS heads are bare compute names; the numbers are those printed."""
    (table,) = read_thermo(DATA / "liggghts" / "log.liggghts")
    assert table.columns == ("Step", "Atoms", "KinEng", "1", "Volume")
    assert table["1"].tolist() == [0, 1.7811709e-07, 1.2250278e-06]


def test_interrupted_table(tmp_path: Path) -> None:
    """Law: INFO, igrpu and WARNING lines, prints and stray numbers inside a table are no rows."""
    noise = "INFO: Particle insertion ins: inserted 4\nigrpu: all\nWARNING: Dangerous (src/a.cpp:1)\n3 balls\n1.5 2\n0 7\n\n"
    (table,) = read_thermo(log(tmp_path, HEAD + "  0  1.5\n" + noise + " 10 nan\n" + noise + TAIL + "5 6\n"))
    np.testing.assert_array_equal(table.values, [[0, 1.5], [10, np.nan]])


def test_interruption_before_the_header(tmp_path: Path) -> None:
    """Law: a line between the memory line and the header is no header."""
    lines = HEAD.splitlines()
    (table,) = read_thermo(log(tmp_path, f"{lines[0]}\nigrpu: all\nWARNING: x\n{lines[1]}\n0 1\n{TAIL}"))
    assert table.columns == ("Step", "KinEng")


def test_header_need_not_begin_with_step(tmp_path: Path) -> None:
    """Law: a thermo_style custom that starts with another keyword is read all the same."""
    (table,) = read_thermo(log(tmp_path, HEAD.replace("Step ", "c_er Step") + "0.5 0 1\n0.5 1 2\n" + TAIL))
    assert table["Step"].tolist() == [0, 1]


def test_run_pre_no_prints_no_memory_line(tmp_path: Path) -> None:
    """Law: a header that begins with Step starts a table by itself."""
    text = HEAD + "0 1\n" + TAIL + HEAD.splitlines()[1] + "\n0 1\n5 2\n" + TAIL
    assert [len(table.values) for table in read_thermo(log(tmp_path, text))] == [1, 2]


def test_log_of_a_killed_run(tmp_path: Path) -> None:
    """Law: whole rows count; a last line without newline may have lost digits and does not."""
    (table,) = read_thermo(log(tmp_path, HEAD + "0 1.25\n10 2.25\n20 3.2"))
    assert table["Step"].tolist() == [0, 10]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no thermo table"),
        ("hello\nworld\n", "no thermo table"),
        (HEAD + "%ld 0.1\n%ld 0.2\n" + TAIL, "log.x:4: a thermo table .* Step KinEng has no row of numbers, but '%ld 0.2'"),
        (HEAD.splitlines()[0] + "\n---\nkeywords: ['Step']\n", "log.x:2: a table of thermo_style yaml"),
    ],
)
def test_logs_without_numbers_are_refused(tmp_path: Path, text: str, message: str) -> None:
    """Law: no table, a table of garbage (LIGGGHTS' own under `format int`) and yaml are one-line errors."""
    with pytest.raises(InputError, match=message) as caught:
        read_thermo(log(tmp_path, text))
    assert "\n" not in str(caught.value)


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4))
def test_merging_undoes_cutting(lengths: list[int]) -> None:
    """Law: a run cut into pieces that repeat their boundary rows merges back to the uncut run."""
    whole = np.column_stack([np.arange(sum(lengths) + 1.0), np.random.default_rng(0).normal(size=sum(lengths) + 1)])
    ends = np.cumsum([0, *lengths])
    pieces = [Thermo(("Step", "KinEng"), whole[a : b + 1]) for a, b in itertools.pairwise(ends)]
    np.testing.assert_array_equal(merge_runs(pieces).values, whole)


def test_merging_keeps_common_columns_and_the_later_row() -> None:
    """Law: only columns that all tables have stay; of the doubled row the later stays."""
    first = Thermo(("Step", "A", "B"), np.array([[0.0, 1, 2], [1, 3, 4]]))
    second = Thermo(("B", "Step"), np.array([[40.0, 1], [50, 2]]))
    merged = merge_runs([first, second])
    assert merged.columns == ("Step", "B")
    assert merged.values.tolist() == [[0, 2], [1, 40], [2, 50]]


def test_merging_nothing_in_common_is_refused() -> None:
    """Law: tables without a common column, or no tables, cannot be merged."""
    with pytest.raises(InputError, match=r"no columns common to the tables: A \| B"):
        merge_runs([Thermo(("A",), np.zeros((1, 1))), Thermo(("B",), np.zeros((1, 1)))])
    with pytest.raises(InputError, match="no columns common"):
        merge_runs([])


def test_why_a_run_stopped(tmp_path: Path) -> None:
    """Law: the last ERROR line counts, with the input line that LAMMPS shows; a log without one gives None."""
    expected = "ERROR: Unrecognized pair style 'nonsense' (src/src/force.cpp:275) | Last input line: pair_style nonsense"
    assert last_error(DATA / "lammps" / "log.lammps") == expected
    assert last_error(DATA / "liggghts" / "log.liggghts") is None
    assert last_error(log(tmp_path, "ERROR: a\nERROR on proc 0: b (x.cpp:1)\n")) == "ERROR on proc 0: b (x.cpp:1)"


def test_warnings_are_listed_once(tmp_path: Path) -> None:
    """Law: warnings come in order, repeated ones once."""
    assert warnings_in(log(tmp_path, "WARNING: a\nx\nWARNING: b\nWARNING: a\n")) == ["WARNING: a", "WARNING: b"]


def test_missing_log_is_named(tmp_path: Path) -> None:
    """Law: a log that is not there is an input error."""
    with pytest.raises(InputError, match="nowhere: cannot be read"):
        read_thermo(tmp_path / "nowhere")

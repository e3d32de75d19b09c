"""Dumps by content, series by name, and the writer of a dump command."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from demsolver.scene import Box, Particles
from demverify.errors import InputError
from demverify.formats.columns import CLUMP_COLUMNS, COLUMNS, INTEGER_COLUMNS, Snapshot, snapshot_frame
from demverify.formats.dump import DumpWriter, read_dump
from tests.demverify.formats.samples import DATA, assert_same, frame, spec

EXACT_LINE = {"float": "%.17g"}


def test_kind_is_found_by_content(tmp_path: Path) -> None:
    """Law: text, gzip and binary dumps of one run, under any name, give the same positions."""
    tables = []
    for i, name in enumerate(("all.txt", "all.txt.gz", "all.bin")):
        copy = tmp_path / f"dump.chute{i}"
        copy.write_bytes((DATA / "lammps" / name).read_bytes())
        tables.append([f.vectors("x", "y", "z") for f in read_dump(copy)])
    np.testing.assert_array_equal(tables[0], tables[1])
    np.testing.assert_array_equal(tables[0], tables[2])


def test_series_comes_in_order_of_steps() -> None:
    """Law: one file a step is read in natural order: step 100 after step 0, whatever the alphabet says."""
    assert [f.step for f in read_dump(str(DATA / "lammps" / "step.*.txt"))] == [0, 100, 200, 300, 400]


def test_series_sorts_numbers_not_letters(tmp_path: Path) -> None:
    """Law: d9 comes before d10."""
    with DumpWriter(spec("post/d*.txt"), "liggghts", tmp_path) as writer:
        for step in (10, 9, 100):
            writer.write(frame(step=step))
    assert [f.step for f in read_dump(tmp_path / "post" / "d*.txt")] == [9, 10, 100]


@pytest.mark.parametrize("content", [b"", b"hello world\n", b"key: value\n", b"\x7fELF\x02\x01\x01\x00\x00\x00"])
def test_what_is_no_dump_is_refused(tmp_path: Path, content: bytes) -> None:
    """Law: an empty file, prose, loose yaml and other binaries are refused in one line that names the file."""
    (tmp_path / "x").write_bytes(content)
    with pytest.raises(InputError, match=r"x: not a dump of particles") as caught:
        list(read_dump(tmp_path / "x"))
    assert "\n" not in str(caught.value)


def test_pattern_without_a_match_says_what_is_there(tmp_path: Path) -> None:
    """Law: a pattern that matches nothing is an error that lists the folder."""
    (tmp_path / "other.txt").touch()
    with pytest.raises(InputError, match=r"no dump file .*dump\*; its folder has other.txt"):
        list(read_dump(tmp_path / "dump*"))


def test_writer_makes_one_file_of_many_frames(tmp_path: Path) -> None:
    """Law: without a star all frames go to one file, which appears when the writer closes."""
    with DumpWriter(spec("d.txt", format=EXACT_LINE), "lammps", tmp_path) as writer:
        for step in (0, 10):
            writer.write(frame(step=step))
        assert not (tmp_path / "d.txt").exists()
    for got, step in zip(read_dump(tmp_path / "d.txt"), (0, 10), strict=True):
        assert_same(got, frame(step=step))


def test_interrupted_writer_keeps_its_frames(tmp_path: Path) -> None:
    """Law: frames written before Ctrl-C are in the file."""
    with pytest.raises(KeyboardInterrupt), DumpWriter(spec("d.bin"), "lammps", tmp_path) as writer:
        writer.write(frame())
        raise KeyboardInterrupt
    assert len(list(read_dump(tmp_path / "d.bin"))) == 1
    assert len(list(tmp_path.iterdir())) == 1


def test_names_padding_and_gzip(tmp_path: Path) -> None:
    """Law: the star becomes the step padded with zeros; .gz is gzipped."""
    with DumpWriter(spec("d.*.txt.gz", pad=6), "lammps", tmp_path) as writer:
        writer.write(frame(step=42))
    assert gzip.decompress((tmp_path / "d.000042.txt.gz").read_bytes()).startswith(b"ITEM: TIMESTEP\n42\n")


@pytest.mark.parametrize(("sort", "order"), [(None, [1, 2, 3]), ("id", [1, 2, 3]), ("3", [2, 1, 3]), ("-3", [3, 1, 2])])
def test_rows_are_sorted_as_asked(tmp_path: Path, sort: str | None, order: list[int]) -> None:
    """Law: dump_modify sort N orders by the N-th column, -N downwards."""
    shuffled = frame()
    shuffled.columns["x"][:] = [2.0, 1.0, 3.0]
    with DumpWriter(spec("d.txt", sort=sort), "lammps", tmp_path) as writer:
        writer.write(shuffled)
    rows = (tmp_path / "d.txt").read_text().splitlines()[-3:]
    assert [int(row.split()[0]) for row in rows] == order


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (spec("d.%.txt"), "a '%' in the file name 'd.%.txt'"),
        (spec("d.txt", sort="9"), "sort key '9' is not off, id or a column from 1 to 6"),
        (spec("d.txt", sort="mass"), "sort key 'mass'"),
        (spec("d.txt", format={"float": "%d"}), "format '%d' of column x"),
    ],
)
def test_wrong_dump_commands_are_refused_before_the_run(tmp_path: Path, wrong: object, message: str) -> None:
    """Law: a faulty dump is refused at construction with the deck's line, and leaves no file."""
    with pytest.raises(InputError, match=r"in\.deck:7: .*" + message):
        DumpWriter(wrong, "lammps", tmp_path)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def snapshot() -> Snapshot:
    """Two particles, ids out of order, the second wrapped twice along x."""
    box = Box(np.array([-1.0, 0.0, 0.0]), np.array([1.0, 4.0, 2.0]))
    vectors = {"x": [[0.5, 1.0, 1.0], [-0.5, 3.0, 0.0]], "v": [[1, 2, 3], [4, 5, 6]], "omega": [[7, 8, 9], [0, 1, 2]]}
    arrays = {name: np.array(value, dtype=float) for name, value in vectors.items()}
    ints = {name: np.array(value) for name, value in {"id": [8, 3], "type": [1, 2], "mask": [1, 1]}.items()}
    image, radius, mass = np.array([[0, 0, 0], [2, -1, 0]]), np.array([1.0, 2.0]), np.array([np.pi, np.pi])
    particles = Particles(**arrays, **ints, image=image, radius=radius, mass=mass)
    return Snapshot(5, box, particles, np.arange(6.0).reshape(2, 3), -np.arange(6.0).reshape(2, 3), np.array([1, 1]))


def test_columns_of_a_snapshot() -> None:
    """Law: scaled is (x - lo)/L, unwrapped is x + image L, density is m/(4/3 pi R^3); rows go by id."""
    got = snapshot_frame(snapshot(), list(COLUMNS))
    expected: dict[str, list[float]] = {
        "id": [3, 8], "xs": [0.25, 0.75], "ys": [0.75, 0.25], "xu": [3.5, 0.5], "yu": [-1.0, 1.0], "ix": [2, 0],
        "diameter": [4, 2], "density": [3 / 32, 3 / 4], "fz": [5, 2], "tqx": [-3, 0], "omegay": [1, 8], "vz": [6, 3],
    }  # fmt: skip
    for name, values in expected.items():
        np.testing.assert_allclose(got.columns[name], values, rtol=1e-15, err_msg=name)


@pytest.mark.parametrize("name", ["c_1", "v_speed", "angmomx", "X", ""])
def test_unknown_column_lists_what_exists(name: str) -> None:
    """Law: a column that the solver has not is refused with the list of those it has."""
    with pytest.raises(InputError, match=r"in\.deck:7: dump column .* is not one of id mol type mass"):
        snapshot_frame(snapshot(), ["id", name], spec("d.txt").place)


def test_integer_columns_exist() -> None:
    """Law: what the writers print as whole numbers are columns that exist."""
    assert {*COLUMNS, *CLUMP_COLUMNS} >= INTEGER_COLUMNS

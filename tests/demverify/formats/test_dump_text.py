"""Text dumps: what is written is read, real files of both engines, and what is no dump is refused with its line."""

from __future__ import annotations

import gzip
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from demverify.errors import InputError
from demverify.formats import dump_text
from demverify.formats.dump import read_dump
from demverify.formats.dump_text_writer import text_frame
from demverify.formats.reading import AS_WRITTEN, Block, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import BOX, DATA, EXACT, NAMES, assert_same, frame, frames

GOOD = text_frame(frame(), NAMES, "lammps", EXACT) + text_frame(frame(4, 10), NAMES, "lammps", EXACT)


def read(tmp_path: Path, content: bytes, *, partial_ok: bool = False) -> list[Frame]:
    """The frames of a file with this content."""
    path = tmp_path / "d.txt"
    path.write_bytes(content)
    return list(dump_text.read(Block(path), Reading(half_written=bool if partial_ok else None)))


@given(expected=frames())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_double_survives_17_digits(tmp_path: Path, expected: Frame) -> None:
    """Law: write then read is the identity on doubles, NaN, infinities, subnormals and ids beyond 2**31 included."""
    (got,) = read(tmp_path, text_frame(expected, list(expected.columns), "lammps", EXACT))
    assert_same(got, expected)


def test_liggghts_layout_is_read_alike(tmp_path: Path) -> None:
    """Law: trailing blanks change nothing; bounds come back with six digits only."""
    content = text_frame(frame(), NAMES, "liggghts", {"line": "%d %d" + 4 * " %.17g"})
    assert b"ITEM: ATOMS id type x y z fx \n" in content
    (got,) = read(tmp_path, content)
    np.testing.assert_array_equal(got.columns["fx"], frame().columns["fx"])
    np.testing.assert_allclose(got.box, BOX, rtol=1e-5, atol=0)


def test_rows_come_sorted_by_id(tmp_path: Path) -> None:
    """Law: rows of any order are read in the order of ids, all columns together."""
    mixed = frame(5)
    order = np.array([3, 0, 4, 1, 2])
    content = text_frame(Frame(0, BOX, mixed.boundary, {k: v[order] for k, v in mixed.columns.items()}), NAMES, "lammps", EXACT)
    assert_same(read(tmp_path, content)[0], mixed)


def test_real_lammps_file_with_units_and_time() -> None:
    """Law: ITEM: UNITS (first frame) and ITEM: TIME are read over; numbers are those of the deck beside the file."""
    got = list(read_dump(DATA / "lammps" / "all.txt"))
    assert [f.step for f in got] == [0, 100, 200, 300, 400]
    assert got[0].boundary == ("pp", "fs", "mm")
    assert got[0].box[0].tolist() == [-0.1, 0.123456789012]
    assert got[0].columns["id"].tolist() == [1, 2, 3]
    assert got[0].columns["x"].tolist() == [0.12, 0.0195, 0.01]
    assert got[0].columns["ix"].tolist() == [2, 0, 0]
    np.testing.assert_allclose(got[0].columns["mass"][0], 4 / 3 * np.pi * 0.005**3 * 2500, rtol=1e-15)


def test_gzip_is_seen_by_content() -> None:
    """Law: a gzipped dump holds the same numbers as the plain one of the same run."""
    for zipped, plain in zip(read_dump(DATA / "lammps" / "all.txt.gz"), read_dump(DATA / "lammps" / "all.txt"), strict=True):
        np.testing.assert_array_equal(zipped.vectors("x", "y", "z"), plain.vectors("x", "y", "z"))


def test_frames_without_particles() -> None:
    """Law: an empty group gives frames with no rows and all columns."""
    got = list(read_dump(DATA / "lammps" / "none.txt"))
    assert [(f.step, f.n, list(f.columns)) for f in got] == [(s, 0, ["id", "type", "x"]) for s in (0, 200, 400)]


def test_real_liggghts_file() -> None:
    """Law: LIGGGHTS' own file is read: step, box, flags, sums of the internal contact forces."""
    got = list(read_dump(DATA / "liggghts" / "d.txt"))
    assert [f.step for f in got] == [0, 10, 20]
    assert got[0].boundary == ("ff", "ff", "ff")
    assert abs(got[0].columns["fx"].sum()) < 1e-4
    assert got[0].columns["radius"].tolist() == [0.005] * 3


def test_half_written_last_frame(tmp_path: Path) -> None:
    """Law: cut anywhere inside the last frame, the file is refused; partial_ok gives the whole frames and no other."""
    first = len(text_frame(frame(), NAMES, "lammps", EXACT))
    for cut in range(first + 1, len(GOOD), 3):
        with pytest.raises(InputError, match=r"d\.txt:\d+: the file ends inside a frame"):
            read(tmp_path, GOOD[:cut])
        assert len(read(tmp_path, GOOD[:cut], partial_ok=True)) == 1


def test_gzip_cut_short(tmp_path: Path) -> None:
    """Law: a .gz that ends early is half written too."""
    content = gzip.compress(GOOD)[:-20]
    with pytest.raises(InputError, match="gzip stream ends early"):
        read(tmp_path, content)
    assert len(read(tmp_path, content, partial_ok=True)) <= 2


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        (b"ATOMS\n3\n", b"ATOMS\n4\n", 13, "expected 6 columns .* got 2: 'ITEM: TIMESTEP'"),
        (b"ATOMS\n3\n", b"ATOMS\n2\n", 12, "expected 'ITEM: ...', got '3 1 "),
        (b"ATOMS\n3\n", b"ATOMS\n-3\n", 4, "NUMBER OF ATOMS expects a count, got '-3'"),
        (b"TIMESTEP\n0\n", b"TIMESTEP\n1.5\n", 2, "TIMESTEP expects a count, got '1.5'"),
        (b"\n2 2 ", b"\n2 2 2 ", 11, "expected 6 columns .id type x y z fx., got 7"),
        (b"\n2 2 ", b"\n2 2,5 ", 11, "column type expects a number, got '2,5'"),
        (b"\n2 2 ", b"\n2 ****** ", 11, r"column type expects a number, got '\*+'"),
        (b"\n2 2 ", b"\n2 1_0 ", 11, "column type expects a number, got '1_0'"),
        (b"\n2 2 ", b"\n1 2 ", 12, "id 1 stands in two rows"),
        (b"\n2 2 ", b"\nnan 2 ", 12, "two rows"),
        (b"ATOMS id type", b"ATOMS tag type", 9, "expected distinct columns with an id"),
        (b"id type x y", b"id type x x", 9, "expected distinct columns"),
        (b"BOUNDS pp fs mm", b"BOUNDS xy xz yz pp fs mm", 5, "expected an orthogonal box"),
        (b"BOUNDS pp fs mm", b"BOUNDS", 5, "three boundary flags"),
        (b"ITEM: TIMESTEP\n0\n", b"", 7, "a frame without ITEM: TIMESTEP"),
    ],
)
def test_wrong_text_is_refused_with_its_line(tmp_path: Path, old: bytes, new: bytes, line: int, message: str) -> None:
    """Law: every fault in the first of two frames is named with file and line, in one line, partial_ok or not."""
    assert old in GOOD
    for partial_ok in (False, True):
        with pytest.raises(InputError, match=rf"d\.txt:{line}: .*{message}") as caught:
            read(tmp_path, GOOD.replace(old, new, 1), partial_ok=partial_ok)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("triclinic.txt", "triclinic.txt:5: expected an orthogonal box"),
        ("headless.txt", "headless.txt:1: expected 'ITEM: ...'"),
        ("entries.local", "entries.local:3: 'ITEM: NUMBER OF ENTRIES' is no part of a particle dump"),
        ("missing.txt", "missing.txt: cannot be read: No such file"),
    ],
)
def test_other_dumps_are_refused(name: str, message: str) -> None:
    """Law: what cannot become a frame of particles is said, not guessed."""
    with pytest.raises(InputError, match=message):
        list(read_dump(DATA / "lammps" / name))


def test_a_large_frame_is_read_fast(tmp_path: Path) -> None:
    """Law: a hundred thousand rows of ten columns take well under a second (measured: 0.25 s)."""
    names = ("id", "type", "x", "y", "z", "vx", "vy", "vz", "fx", "fy")
    (tmp_path / "big.txt").write_bytes(text_frame(frame(100_000, names=names), names, "lammps"))
    start = time.process_time()
    (got,) = dump_text.read(Block(tmp_path / "big.txt"), AS_WRITTEN)
    assert time.process_time() - start < 1.0
    assert got.n == 100_000


@pytest.mark.parametrize(
    ("formats", "message"),
    [
        ({"float": "%d"}, "format '%d' of column x is not a printf format with one of %f %F %e %E %g %G"),
        ({"int": "%g"}, "format '%g' of column id"),
        ({"float": "%g %g"}, "'%g %g' of column x"),
        ({"float": "hello"}, "'hello' of column x"),
        ({"float": "%s"}, "'%s' of column x"),
        ({"float": "%*g"}, r"'%\*g' of column x"),
        ({"line": "%d %d %g"}, "has 3 formats for 6 columns"),
        ({"7": "%g"}, "format for column '7', but the columns are 1 to 6: id type"),
    ],
)
def test_wrong_formats_are_refused(formats: dict[str, str], message: str) -> None:
    """Law: a format that does not fit its column is refused, naming both."""
    with pytest.raises(InputError, match=message):
        text_frame(frame(), NAMES, "lammps", formats)


def test_column_format_beats_float_beats_line() -> None:
    """Law: LAMMPS' order of precedence: a column's own format, then int and float, then line, then %d and %g."""
    formats = {"line": "%d %d %.1f %.1f %.1f %.1f", "float": "%.2f", "3": "%.3f", "-1": "%.4f", "y": "%.5f"}
    one = Frame(0, BOX, ("pp", "pp", "pp"), {name: np.array([1.0]) for name in NAMES})
    assert text_frame(one, NAMES, "lammps", formats).endswith(b"\n1 1 1.000 1.00000 1.00 1.0000\n")

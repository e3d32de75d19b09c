"""Text dumps: what is written is read, real files of both engines, and what is no dump is refused with its line."""

from __future__ import annotations

import gzip
import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats import dump_text, dump_text_header
from demverify.formats.dump import read_dump
from demverify.formats.dump_text_writer import text_frame
from demverify.formats.reading import AS_WRITTEN, Block, HalfWrittenError, Reading
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
    """Law: ITEM: UNITS of the first frame holds for all, ITEM: TIME for its own; numbers are those of the deck beside the file."""
    got = list(read_dump(DATA / "lammps" / "all.txt"))
    assert [f.step for f in got] == [0, 100, 200, 300, 400]
    assert [f.time for f in got] == [f.step * 1e-5 for f in got]
    assert {(f.units, f.dialect, f.local, f.cell) for f in got} == {("si", "lammps", False, None)}
    assert got[0].boundary == ("pp", "fs", "mm")
    assert got[0].box[0].tolist() == [-0.1, 0.123456789012]
    assert got[0].columns["id"].tolist() == [1, 2, 3]
    assert got[0].columns["x"].tolist() == [0.12, 0.0195, 0.01]
    assert got[0].columns["ix"].tolist() == [2, 0, 0]
    np.testing.assert_allclose(got[0].columns["mass"][0], 4 / 3 * np.pi * 0.005**3 * 2500, rtol=1e-15)


def test_a_tilted_box() -> None:
    """Law: the bounds in the file are those around the cell; region prism 0 1 0 1 0 1 0.2 0.1 0.0 made it, and the binary dump says the same."""
    for got, binary in zip(read_dump(DATA / "lammps" / "triclinic.txt"), read_dump(DATA / "lammps" / "triclinic.bin"), strict=True):
        np.testing.assert_array_equal(got.box, [[0, 1], [0, 1], [0, 1]])
        np.testing.assert_array_equal(got.edges, [[1, 0, 0], [0.2, 1, 0], [0.1, 0, 1]])
        np.testing.assert_array_equal(got.box, binary.box)
        np.testing.assert_array_equal(got.edges, binary.edges)
        np.testing.assert_allclose(got.columns["x"], binary.columns["x"], rtol=5e-6)  # six digits in the text


def test_a_cell_in_any_direction() -> None:
    """Law: BOX BOUNDS abc origin gives the vectors of `lattice custom` in the deck, and with 17 digits all that the binary dump has."""
    for got, binary in zip(read_dump(DATA / "lammps" / "general.txt"), read_dump(DATA / "lammps" / "general.bin"), strict=True):
        np.testing.assert_allclose(got.edges, [[1, 0.2, 0.1], [-0.1, 1, 0.2], [0.1, -0.2, 1.1]], atol=1e-15)  # rotated to and fro by LAMMPS
        assert (got.time, got.units) == (binary.time, binary.units)
        np.testing.assert_array_equal(got.edges, binary.edges)
        assert_same(got, binary)


def test_local_rows() -> None:
    """Law: `dump local` gives its rows in the order of the file, without ids; forces on pairs are as the particles' own dump has them."""
    local, particles = (list(read_dump(DATA / "liggghts" / name)) for name in ("d.local", "d.txt"))
    assert [(f.step, f.n, f.local, f.dialect) for f in local] == [(step, 2, True, "liggghts") for step in (0, 10, 20)]
    assert [[f.columns[f"c_pg[{i}]"].tolist() for i in (7, 8)] for f in local] == [[[1, 2], [2, 3]]] * 3
    assert particles[0].columns["fx"][2] == -local[0].columns["c_pg[10]"][1]  # particle 3 has one contact


def test_a_label_of_its_own(tmp_path: Path) -> None:
    """Law: `dump_modify label` puts another word in both items of a local dump; LIGGGHTS' ITEM: LABEL is read over."""
    content = (DATA / "liggghts" / "d.local").read_bytes()
    (expected, *_) = read(tmp_path, content)
    for item in (b"ITEM: NUMBER OF PAIRS", b"ITEM: LABEL\ncontacts\nITEM: NUMBER OF PAIRS"):
        (got, *_) = read(tmp_path, content.replace(b"ITEM: NUMBER OF ENTRIES", item).replace(b"ITEM: ENTRIES", b"ITEM: PAIRS"))
        assert got.local
        assert_same(got, expected)


def test_which_engine_wrote_it(tmp_path: Path) -> None:
    """Law: bounds with 16 digits and an exponent are LAMMPS' own, of any age; else a blank at the end is LIGGGHTS'; else nothing is said."""
    liggghts = text_frame(frame(), NAMES, "liggghts")
    old_lammps = text_frame(frame(), NAMES, "lammps").replace(b" fx\n", b" fx \n")
    dialects = [read(tmp_path, content)[0].dialect for content in (GOOD, old_lammps, liggghts, liggghts.replace(b" fx \n", b" fx\n"))]
    assert dialects == ["lammps", "lammps", "liggghts", None]


def test_items_in_any_order(tmp_path: Path) -> None:
    """Law: the order of the items before that of the rows does not matter."""
    header, rows = GOOD.split(b"ITEM: ATOMS")[:2]
    items = [b"ITEM: " + item for item in header.split(b"ITEM: ")[1:]] + [b"ITEM: UNITS\nsi\n", b"ITEM: TIME\n0.5\n"]
    for order in ([0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [3, 2, 0, 4, 1]):
        (got,) = read(tmp_path, b"".join(items[i] for i in order) + b"ITEM: ATOMS" + rows[: rows.index(b"ITEM: ")])
        assert (got.units, got.time) == ("si", 0.5)
        assert_same(got, frame())


def test_columns_renamed_and_kept(tmp_path: Path) -> None:
    """Law: only wanted columns are parsed and given, under their new names; rows are sorted by an id that is not wanted too."""
    content = b"".join(line.replace(b" 1 ", b" Cu ", 1) if line[:1].isdigit() and line.count(b" ") == 5 else line
                       for line in GOOD.splitlines(keepends=True)).replace(b"ATOMS id type x", b"ATOMS tag element x")  # fmt: skip
    content = re.sub(rb"(?m)^(3 .*)\n(.*\n)", rb"\1\n\2", content)
    path = tmp_path / "d.txt"
    path.write_bytes(content)
    reading = Reading(names={"tag": "id", "x": "here"}, keep=frozenset({"here", "fx"}))
    got = list(dump_text.read(Block(path), reading))
    for frame_, expected in zip(got, (frame(), frame(4, 10)), strict=True):
        assert list(frame_.columns) == ["here", "fx"]
        np.testing.assert_array_equal(frame_.columns["here"], expected.columns["x"])
    with pytest.raises(InputError, match=r"column element expects a number, got 'Cu'"):
        list(dump_text.read(Block(path), Reading(names={"tag": "id"})))


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


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.ZstdCompressor().compress])
def test_packed_and_cut_short(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    """Law: a packed file that ends early is half written too, even where its last frame is whole; what it holds is given first."""
    content = pack(GOOD)
    for cut in range(20, len(content), 7):
        with pytest.raises(InputError, match="ends inside"):
            read(tmp_path, content[:cut])
        assert len(read(tmp_path, content[:cut], partial_ok=True)) <= 2
    flushed = zstandard.ZstdCompressor().compressobj()
    running = flushed.compress(GOOD) + flushed.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)
    assert len(read(tmp_path, running, partial_ok=True)) == 2
    with pytest.raises(HalfWrittenError, match="ends inside its packed stream"):
        read(tmp_path, running)


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
        (b"\n2 2 ", b"\nnan 2 ", 12, "id nan in the frame that ends here: expected a whole number"),
        (b"\n2 2 ", b"\n2.5 2 ", 12, "id 2.5 in the frame"),
        (b"\n2 2 ", b"\n1e17 2 ", 12, r"id 1\.?0*e\+17 in the frame"),
        (b"ATOMS\n3\n", b"ATOMS\n3_0\n", 4, "NUMBER OF ATOMS expects a count, got '3_0'"),
        (b"ATOMS\n3\n", b"ATOMS\n" + b"9" * 5000 + b"\n", 4, "expects a count, got '99999"),
        (b"ATOMS\n3\n", b"ATOMS\n999999999999999999\n", 9, "999999999999999999 rows of 6 columns do not fit into memory"),
        (b"ATOMS id type", b"ATOMS tag type", 9, "expected distinct columns with an id"),
        (b"id type x y", b"id type x x", 9, "expected distinct columns"),
        (b"BOUNDS pp fs mm", b"BOUNDS xy xz yz pp fs mm", 6, "expected 3 numbers in a row of BOX BOUNDS, got '-1.0"),
        (b"BOUNDS pp fs mm", b"BOUNDS abc origin pp fs mm", 6, "expected 4 numbers in a row of BOX BOUNDS"),
        (b"BOUNDS pp fs mm", b"BOUNDS xy pp fs mm", 5, "expected three boundary flags"),
        (b"BOUNDS pp fs mm", b"BOUNDS", 5, "three boundary flags"),
        (b"BOUNDS pp fs mm", b"BOUNDS pp fs mx", 5, "three boundary flags"),
        (b"1.2345678901200000e-01", b"-5", 8, "expected box bounds lo <= hi"),
        (b"1.2345678901200000e-01", b"inf", 6, "BOX BOUNDS expects a number, got 'inf'"),
        (b"1.2345678901200000e-01", b"1_2", 6, "BOX BOUNDS expects a number, got '1_2'"),
        (b"ITEM: TIMESTEP\n", b"ITEM: TIME\nnoon\nITEM: TIMESTEP\n", 2, "ITEM: TIME expects a number, got 'noon'"),
        (b"ITEM: NUMBER OF", b"ITEM: TIMESTEP\n0\nITEM: NUMBER OF", 3, "'ITEM: TIMESTEP' stands twice in the header"),
        (b"ITEM: BOX", b"ITEM: GRID SIZE nx ny nz\n1 1 1\nITEM: BOX", 5, "'ITEM: GRID SIZE nx ny nz' is no part of a dump"),
        (b"ITEM: ATOMS", b"ITEM: ENTRIES", 9, "a frame without ITEM: NUMBER OF ENTRIES"),
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


def test_what_is_not_there_is_refused(tmp_path: Path) -> None:
    """Law: a file that does not exist is named with the reason."""
    with pytest.raises(InputError, match=r"missing\.txt: cannot be read: No such file"):
        list(dump_text.read(Block(tmp_path / "missing.txt"), AS_WRITTEN))


def all_of(one: Frame) -> tuple[object, ...]:
    """All that a frame says, to compare."""
    return one.step, one.time, one.units, one.box.tobytes(), [(name, values.tobytes()) for name, values in one.columns.items()]


@pytest.mark.parametrize("name", ["lammps/units.txt", "liggghts/d.txt", "liggghts/d.local"])
def test_cut_at_every_byte(tmp_path: Path, name: str) -> None:
    """Law: of a file that ends anywhere the whole frames come as they are, and half a frame is told, unless it ends between frames."""
    content = (DATA / name).read_bytes()
    whole = [all_of(one) for one in dump_text.read(Block(DATA / name), AS_WRITTEN)]
    path, told = tmp_path / "d.txt", [InputError("")]
    starts = [found.start() for found in re.finditer(rb"ITEM: (UNITS|TIME\n(?!.*\nITEM: UNITS)|TIMESTEP)", content)]
    ends = {0, len(content)} | {at for at in starts if dump_text_header.starts_frame(content[:at])}
    for cut in range(len(content) + 1):
        path.write_bytes(content[:cut])
        told.clear()
        got = [all_of(one) for one in dump_text.read(Block(path), Reading(half_written=told.append))]
        assert (not told) == (cut in ends), cut
        assert got == whole[: sum(end <= cut for end in ends) - 1]


@given(data=st.data())
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_one_byte_changed(tmp_path: Path, data: st.DataObject) -> None:
    """Law: a byte changed, put in or taken out gives frames or one line of error: no traceback, and no number that float() does not read."""
    at = data.draw(st.integers(0, len(GOOD) - 1))
    new = data.draw(st.sampled_from([b"", b"\0", b" ", b"\n", b"-", b".", b"e", b"9", b"I", b"\xff", b"_", b"nan", b"\r\n", GOOD[at : at + 1] * 2]))
    content = GOOD[:at] + new + GOOD[at + 1 :]
    try:
        got = read(tmp_path, content)
    except InputError as error:
        assert "\n" not in str(error)
        return
    rows = [line.split() for line in content.split(b"\n") if len(line.split()) == 6 and not line.startswith(b"ITEM")]
    expected = [sorted([float(word) for word in row] for row in part) for part in (rows[: got[0].n], rows[got[0].n :])]
    for frame_, table in zip(got, expected, strict=True):
        np.testing.assert_array_equal(np.column_stack(list(frame_.columns.values())), table)


def test_a_large_frame_is_read_fast(tmp_path: Path) -> None:
    """Law: a hundred thousand rows of ten columns take well under a second (measured, once compiled: 0.03 s)."""
    names = ("id", "type", "x", "y", "z", "vx", "vy", "vz", "fx", "fy")
    read(tmp_path, GOOD)
    (tmp_path / "big.txt").write_bytes(text_frame(frame(100_000, names=names), names, "lammps"))
    start = time.process_time()
    (got,) = dump_text.read(Block(tmp_path / "big.txt"), AS_WRITTEN)
    assert time.process_time() - start < 0.3
    assert got.n == 100_000


def test_a_column_that_is_there_twice_counts_once(tmp_path: Path) -> None:
    """Law: LIGGGHTS decks often say `id type type x y z`: both columns hold the same; two columns named alike by --columns are refused."""
    path = tmp_path / "d.txt"
    path.write_bytes(GOOD.replace(b"id type x", b"id type type"))
    first = next(dump_text.read(Block(path), AS_WRITTEN))
    assert list(first.columns) == ["id", "type", *NAMES[3:]]
    with pytest.raises(InputError, match="expected distinct columns, got y twice"):
        next(dump_text.read(Block(path), Reading(columns=(*NAMES[:2], "y", *NAMES[3:]))))

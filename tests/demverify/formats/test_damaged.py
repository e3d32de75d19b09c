"""Damaged dumps of every kind that is not text: cut at any byte, or with one byte changed."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats.dump import read_dump
from demverify.formats.h5md import TrajectoryWriter
from demverify.formats.reading import AS_WRITTEN, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import DATA, frame

LIGGGHTS = DATA / "liggghts"
FILES = {  # the file, and how it is read; names end in a step for VTK
    "general.bin": (DATA / "lammps" / "general.bin", AS_WRITTEN),
    "old.bin": (LIGGGHTS / "d.bin", Reading(columns=("id", "type", "x", "y", "z", "radius"))),
    "words.yaml": (DATA / "lammps" / "words.yaml", Reading(keep=frozenset({"id", "x"}))),
    "ascii10.vtk": (LIGGGHTS / "vtk" / "ascii10.vtk", AS_WRITTEN),
    "binary10.vtk": (LIGGGHTS / "vtk" / "binary10.vtk", AS_WRITTEN),
    "contacts10.vtk": (LIGGGHTS / "vtk" / "triangles10.vtk", AS_WRITTEN),
    "ascii10.vtp": (LIGGGHTS / "vtk" / "ascii10.vtp", AS_WRITTEN),
    "inline10.vtp": (LIGGGHTS / "vtk" / "inline10.vtp", AS_WRITTEN),
    "zlib10.vtu": (LIGGGHTS / "vtk" / "zlib10.vtu", AS_WRITTEN),
}
PEAK = 20_000_000  # bytes; the files have a few thousand
FUZZ = settings(max_examples=250, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def read(path: Path, reading: Reading) -> tuple[list[Frame], InputError | None]:
    """The frames before the first error, and that error. Any other exception is a failure."""
    frames: list[Frame] = []
    try:
        frames.extend(read_dump(path, reading))
    except InputError as error:
        assert "\n" not in str(error)
        assert str(path) in str(error)
        return frames, error
    return frames, None


def same(a: Frame, b: Frame) -> bool:
    """True when both say the same of every particle."""
    told = [(f.step, f.boundary, f.time, f.units, f.local, list(f.columns)) for f in (a, b)]
    arrays = [[f.box, f.edges, *f.columns.values()] for f in (a, b)]
    return told[0] == told[1] and all(np.array_equal(x, y, equal_nan=True) for x, y in zip(*arrays, strict=True))


@pytest.mark.parametrize("name", FILES)
def test_cut_at_every_byte(tmp_path: Path, name: str) -> None:
    """Law: of a file cut anywhere come whole frames as they were and then an error, unless it is cut between frames or in white space."""
    source, reading = FILES[name]
    content = source.read_bytes()
    path = tmp_path / name
    path.write_bytes(content)
    whole, error = read(path, reading)
    assert error is None
    silent = []
    for cut in range(len(content.rstrip())):
        path.write_bytes(content[:cut])
        frames, error = read(path, reading)
        assert all(map(same, frames, whole)), cut
        silent += [len(frames)] if error is None else []
    assert set(silent) == set(range(1, len(whole)))
    assert len(silent) <= 2 * (len(whole) - 1)  # before and after the line end between two frames


@pytest.mark.parametrize("name", FILES)
@given(data=st.data())
@FUZZ
def test_one_byte_changed(tmp_path: Path, name: str, data: st.DataObject) -> None:
    """Law: any byte changed to any other gives frames or one line of error, without reserving memory for what is not there."""
    source, reading = FILES[name]
    content = bytearray(source.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / name
    path.write_bytes(content)
    tracemalloc.start()
    try:
        read(path, reading)
        assert tracemalloc.get_traced_memory()[1] < PEAK
    finally:
        tracemalloc.stop()


def test_h5md_cut_and_changed(tmp_path: Path) -> None:
    """Law: HDF5 checks its own structure, so a cut or changed file gives the frames, other numbers in them, or one line of error."""
    path = tmp_path / "t.h5"
    with TrajectoryWriter(path) as writer:
        for step in (0, 10):
            writer.write(frame(step=step), 0.0)
    content = path.read_bytes()
    rng = np.random.default_rng(3)
    for cut in range(0, len(content), 211):
        path.write_bytes(content[:cut])
        assert read(path, AS_WRITTEN)[1] is not None, cut
    for at in rng.integers(0, len(content), 400).tolist():
        changed = bytearray(content)
        changed[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(changed)
        read(path, AS_WRITTEN)

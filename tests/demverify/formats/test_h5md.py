"""H5MD trajectories: exact, open to MDAnalysis, alive after a kill."""

from __future__ import annotations

import gzip
import signal
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats.atomic import part_path
from demverify.formats.dump import read_dump
from demverify.formats.h5md import TrajectoryWriter, read_h5md
from demverify.formats.reading import Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import assert_same, frame, frames

_AXES = [prefix + axis for prefix in ("", "v", "f", "omega", "tq") for axis in "xyz"]
ALL = ("id", "type", *_AXES, "radius", "mass")


def write(path: Path, series: list[Frame]) -> None:
    """Writes frames at times 0.0, 0.5, 1.0, ..."""
    with TrajectoryWriter(path) as writer:
        for i, one in enumerate(series):
            writer.write(one, 0.5 * i)


@given(series=st.lists(frames(), min_size=1, max_size=4))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_round_trip_keeps_every_bit(tmp_path: Path, series: list[Frame]) -> None:
    """Law: write then read is the identity, with particles coming and going, NaN, infinities and large ids."""
    write(tmp_path / "t.h5", series)
    for got, expected in zip(read_h5md(tmp_path / "t.h5"), series, strict=True):
        assert_same(got, expected)


def test_time_units_and_dialect(tmp_path: Path) -> None:
    """Law: the time that was written comes back; H5MD tells neither units nor the engine."""
    write(tmp_path / "t.h5", [frame(step=0), frame(step=10)])
    assert [(f.time, f.units, f.dialect, f.local) for f in read_h5md(tmp_path / "t.h5")] == [(0.0, None, None, False), (0.5, None, None, False)]


def test_only_wanted_columns(tmp_path: Path) -> None:
    """Law: names rename, keep selects; a dump reader finds the file by its content; of a vector one axis may be wanted."""
    series = [frame(3, step, ALL) for step in (0, 10)]
    write(tmp_path / "t.bin", series)
    got = list(read_dump(tmp_path / "t.bin", Reading(names={"omegay": "spin"}, keep=frozenset({"spin", "type"}))))
    assert [(f.step, set(f.columns)) for f in got] == [(0, {"spin", "type"}), (10, {"spin", "type"})]
    for one, expected in zip(got, series, strict=True):
        np.testing.assert_array_equal(one.columns["spin"], expected.columns["omegay"])


def test_memory_does_not_grow_with_frames(tmp_path: Path) -> None:
    """Law: frames are read one at a time: forty need the memory of four."""

    def peak(count: int) -> int:
        write(tmp_path / "t.h5", [frame(4000, step) for step in range(count)])
        tracemalloc.start()
        assert sum(f.n for f in read_h5md(tmp_path / "t.h5")) == 4000 * count
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(1)
    assert peak(40) < 1.2 * peak(4)  # the old frame, still held by the loop, and the new one


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda file: file["observables/all/count/value"].write_direct(np.array([3, 9])), r"frame 2 has 9 particles, .* only 3"),
        (lambda file: file["observables/all/count/value"].write_direct(np.array([3, -1])), "frame 2 has -1 particles"),
        (lambda file: file["observables/all/count/value"].resize(7, axis=0), "damaged: .*out of range"),
        (lambda file: file["particles/all/id/value"].resize((2, 2)), "frame 1 has 3 particles, .* only 2"),
        (lambda file: file["particles/all/id/value"].write_direct(np.array([[1, 1, 2]] * 2)), "id 1 stands in two rows"),
        (lambda file: file["particles/all"].pop("id"), "an id among them"),
        (lambda file: file["particles/all/box"].attrs.pop("boundary_flags"), "damaged: .*boundary_flags"),
        (lambda file: file["h5md/creator"].attrs.modify("name", "other"), "an HDF5 file of 'other'"),
        (lambda file: file.pop("h5md"), "an HDF5 file of 'no H5MD creator'"),
        (lambda file: file.pop("particles"), "damaged: .*not found"),
    ],
)
def test_damaged_and_foreign_files_are_refused(tmp_path: Path, damage: Callable[[h5py.File], object], message: str) -> None:
    """Law: what a frame cannot be without is named in one line; other programs' H5MD is refused as such."""
    write(tmp_path / "t.h5", [frame(), frame(step=10)])
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        damage(file)
    with pytest.raises(InputError, match=message) as caught:
        list(read_h5md(tmp_path / "t.h5"))
    assert "\n" not in str(caught.value)


def test_packed_hdf5_is_refused_with_the_reason(tmp_path: Path) -> None:
    """Law: a gzipped trajectory is known for what it is, and must be unpacked."""
    write(tmp_path / "t.h5", [frame()])
    (tmp_path / "t.h5.gz").write_bytes(gzip.compress((tmp_path / "t.h5").read_bytes()))
    with pytest.raises(InputError, match="a packed one must be unpacked first"):
        list(read_dump(tmp_path / "t.h5.gz"))


def test_layout_is_h5md(tmp_path: Path) -> None:
    """Law: elements have value, step and time; vectors are (frame, row, 3) float64; no unit anywhere; periodicity is told."""
    write(tmp_path / "t.h5", [frame(3, step, ALL) for step in (0, 10)])
    with h5py.File(tmp_path / "t.h5") as file:
        group = file["particles/all"]
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert {*group} == {"box", "position", "velocity", "force", "omega", "torque", "species", "id", "radius", "mass"}
        assert group["box"].attrs["boundary"].tolist() == ["periodic", "none", "none"]
        assert (group["position/value"].shape, group["position/value"].dtype) == ((2, 3, 3), np.float64)
        assert group["torque/step"][:].tolist() == [0, 10]
        assert group["omega/time"][:].tolist() == [0.0, 0.5]
        np.testing.assert_allclose(group["box/edges/value"][0], [0.223456789012, 0.1, 1 / 3], rtol=1e-15)
        found: list[str] = []
        file.visititems(lambda name, item: found.append(name) if "unit" in item.attrs else None)
        assert not found


def test_absent_rows_are_marked(tmp_path: Path) -> None:
    """Law: arrays are as wide as the largest frame; rows past the count have id 0 and NaN."""
    write(tmp_path / "t.h5", [frame(2), frame(4, 10), frame(1, 20)])
    with h5py.File(tmp_path / "t.h5") as file:
        assert file["observables/all/count/value"][:].tolist() == [2, 4, 1]
        assert file["particles/all/id/value"][:].tolist() == [[1, 2, 0, 0], [1, 2, 3, 4], [1, 0, 0, 0]]
        position = file["particles/all/position/value"][:]
        assert np.isnan(position).all(axis=2).tolist() == [[False, False, True, True], [False] * 4, [False, True, True, True]]


def test_mdanalysis_opens_it(tmp_path: Path) -> None:
    """Law: MDAnalysis reads positions, velocities, forces (to its float32), box, step and time."""
    mda = pytest.importorskip("MDAnalysis")
    series = [frame(5, step, ALL) for step in (0, 10, 20)]
    write(tmp_path / "t.h5md", series)
    universe = mda.Universe.empty(5, trajectory=True, velocities=True, forces=True)
    universe.load_new(str(tmp_path / "t.h5md"), convert_units=False)
    assert len(universe.trajectory) == 3
    for ts, expected in zip(universe.trajectory, series, strict=True):
        np.testing.assert_allclose(ts.positions, expected.vectors("x", "y", "z"), rtol=1e-6)
        np.testing.assert_allclose(ts.velocities, expected.vectors("vx", "vy", "vz"), rtol=1e-6)
        np.testing.assert_allclose(ts.forces, expected.vectors("fx", "fy", "fz"), rtol=1e-6)
        np.testing.assert_allclose(ts.dimensions, [0.223456789012, 0.1, 1 / 3, 90, 90, 90], rtol=1e-6)
        assert (ts.data["step"], ts.time) == (expected.step, 0.05 * expected.step)


def test_arrays_may_be_reused_after_writing(tmp_path: Path) -> None:
    """Law: the writer copies: a solver that goes on in the same arrays does not change what was written."""
    with TrajectoryWriter(tmp_path / "t.h5") as writer:
        one = frame()
        for step in range(3):
            one.columns["x"][:] = step
            writer.write(Frame(step, one.box, one.boundary, one.columns), 0.0)
    assert [f.columns["x"][0] for f in read_h5md(tmp_path / "t.h5")] == [0, 1, 2]


def test_interrupted_run_keeps_its_frames(tmp_path: Path) -> None:
    """Law: Ctrl-C or an error in the run leaves a whole file with all frames written so far."""
    with pytest.raises(KeyboardInterrupt), TrajectoryWriter(tmp_path / "t.h5") as writer:
        for step in range(3):
            writer.write(frame(step=step), 0.0)
        raise KeyboardInterrupt
    assert [f.step for f in read_h5md(tmp_path / "t.h5")] == [0, 1, 2]
    assert [p.name for p in tmp_path.iterdir()] == ["t.h5"]


KILLED = """
import os, signal, sys, time
from pathlib import Path
from demverify.formats.h5md import TrajectoryWriter
from tests.demverify.formats.samples import frame
with TrajectoryWriter(Path(sys.argv[1])) as writer:
    for step in range(40):
        writer.write(frame(3 + step, step), 0.0)
    time.sleep(1.1)
    writer.write(frame(43, 40), 0.0)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_killed_writer_leaves_a_readable_part(tmp_path: Path) -> None:
    """Law: after SIGKILL the .part holds every frame older than a second, whole, and the final name does not exist."""
    path = tmp_path / "t.h5"
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], cwd=Path(__file__).parents[3], check=False)
    assert done.returncode == -signal.SIGKILL
    assert not path.exists()
    got = list(read_h5md(part_path(path)))
    assert [f.step for f in got] == list(range(41))
    assert_same(got[40], frame(43, 40))


def test_no_frame_no_file(tmp_path: Path) -> None:
    """Law: a run that fails before its first frame leaves nothing."""
    with pytest.raises(ZeroDivisionError), TrajectoryWriter(tmp_path / "t.h5"):
        raise ZeroDivisionError
    assert not list(tmp_path.iterdir())


def test_changed_columns_are_refused(tmp_path: Path) -> None:
    """Law: a frame with other columns than the first is refused."""
    with pytest.raises(InputError, match="step 1 has columns id type x, not fx id type x y z as before"):
        write(tmp_path / "t.h5", [frame(), frame(3, 1, ("id", "type", "x"))])


def test_other_files_are_refused(tmp_path: Path) -> None:
    """Law: text, a cut-off file, another HDF5 file and a missing one are one-line errors."""
    write(tmp_path / "t.h5", [frame(2000)])
    (tmp_path / "text.h5").write_text("hello\n")
    (tmp_path / "cut.h5").write_bytes((tmp_path / "t.h5").read_bytes()[:3000])
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["x"] = 1
    messages = {"text": "not an HDF5", "cut": "damaged", "other": "not a trajectory", "none": "not an HDF5"}
    for name, message in messages.items():
        with pytest.raises(InputError, match=message) as caught:
            list(read_h5md(tmp_path / f"{name}.h5"))
        assert "\n" not in str(caught.value)

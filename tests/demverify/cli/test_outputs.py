"""What a run leaves: the native engine writes the files that LAMMPS or LIGGGHTS would, with their columns and their numbers."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from demverify.formats.dump import read_dump
from demverify.formats.h5md import read_h5md
from demverify.formats.log import read_thermo
from tests.support.cli import Call, deck, files_in
from tests.support.engines import require_lammps, require_liggghts

Write = Callable[..., Path]
THREE = "create_atoms 1 single -0.0049 0.001 0.0{0}\ncreate_atoms 1 single 0.0049 0.0 0.0{0}\ncreate_atoms 2 single 0.0 0.0 0.02{0}\n"
OUTPUT = """set type * diameter 0.01 density 2500.0
set atom 1 vx 0.5
set atom 3 {spin}
group pair id 1 2
timestep 1.0e-6
fix move all nve/sphere
fix down all gravity 9.81 vector 0 0 -1
compute spin all erotate/sphere
compute motion pair ke
compute fast all reduce max vx
variable twice equal 2.0*ke
thermo_style custom step atoms ke c_spin c_motion c_fast v_twice vol time dt
thermo_modify norm no
thermo 10
dump one all custom 10 frames.dump id type x y z ix vx vy fz omegaz tqz radius mass
dump_modify one sort id
dump many pair custom 20 post/step.*.dump id xs yu vx diameter
dump_modify many sort id pad 6 first yes
print "half way at step $(step)"
run 45
undump one
unfix down
thermo 15
dump late all custom 20 late.dump id z vz
dump_modify late sort -2 format {format}
run 30
print "done"
"""
SAVED = {"frames.dump", "late.dump", "post", *(f"post/step.{step:06d}.dump" for step in (0, 20, 40, 60))}
BOX = "region box block -0.05 0.05 -0.05 0.05 -0.05 0.05{0}\ncreate_box 2 box\n"
LAMMPS = (
    "units si\natom_style sphere\nboundary f f f\nnewton off\ncomm_modify vel yes\n" + BOX.format("") + THREE.format("")
    + "pair_style gran/hooke/history 1.0e4 3.0e3 500.0 200.0 0.5 1\npair_coeff * *\nneighbor 0.002 bin\n"
    + OUTPUT.format(format="float %20.15g", spin="omega 0.0 3.0 0.0")
)  # fmt: skip
PROPERTIES = {"kn": 1e4, "kt": 3e3, "gamman": 500.0, "gammat": 200.0, "coefficientFriction": 0.5}
LIGGGHTS = (
    "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\n"
    + BOX.format(" units box") + THREE.format(" units box")
    + "".join(f"fix {name} all property/global {name} peratomtypepair 2 {' '.join([str(value)] * 4)}\n" for name, value in PROPERTIES.items())
    + "pair_style gran model hooke/stiffness tangential history\npair_coeff * *\nneighbor 0.002 bin\nneigh_modify delay 0\n"
    + OUTPUT.format(format='"%d %20.15g %20.15g"', spin="omegay 3.0")
)  # fmt: skip
ENGINES = {"lammps": (LAMMPS, require_lammps), "liggghts": (LIGGGHTS, require_liggghts)}


def table(path: Path) -> tuple[list[str], np.ndarray]:
    """Heads and numbers of a thermo.csv."""
    head, *rows = csv.reader(path.open())
    return head, np.array(rows, dtype=float)


@pytest.fixture
def both(request: pytest.FixtureRequest, demverify: Call, write: Write, tmp_path: Path) -> tuple[Path, Path]:
    """Folders of the native engine's run and of the other's, of one deck."""
    text, require = ENGINES[request.param]
    require()
    path = write(text, f"in.{request.param}")
    for engine in ("native", request.param):
        found = demverify("run", path, "--engine", engine, "--out", tmp_path / engine)
        assert (found.status, found.err) == (0, "")
    return tmp_path / "native", tmp_path / request.param


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize("both", ENGINES, indirect=True)
def test_the_same_files_with_the_same_numbers(both: tuple[Path, Path]) -> None:
    """Dumps of the same names, headers and columns, equal to the digits printed; a dump ended between runs is whole, a new one begins."""
    native, other = both
    assert files_in(native) == SAVED | {"log.native", "thermo.csv", "trajectory.h5"}
    assert files_in(other) >= SAVED | {"thermo.csv", "trajectory.h5"}
    assert not [name for name in files_in(other) if name.endswith((".part", ".bin"))]
    for name in sorted(SAVED - {"post"}):
        ours, theirs = (list(read_dump(folder / name)) for folder in both)
        assert [frame.step for frame in ours] == [frame.step for frame in theirs]
        for a, b in zip(ours, theirs, strict=True):
            assert (list(a.columns), a.boundary) == (list(b.columns), b.boundary)
            np.testing.assert_allclose(a.box, b.box, rtol=1e-5)
            digits = 1e-13 if name == "late.dump" else 2e-6
            for column, values in a.columns.items():
                size = np.abs(b.columns[column]).max()
                np.testing.assert_allclose(values, b.columns[column], rtol=digits, atol=1e-13 * size, err_msg=f"{name} {column}")
        first, second = ((folder / name).read_text().split("ITEM: ")[:5] for folder in both)
        assert [part.split("\n")[0] for part in first] == [part.split("\n")[0] for part in second]
    assert [frame.step for frame in read_dump(native / "frames.dump")] == [0, 10, 20, 30, 40]
    assert [frame.step for frame in read_dump(native / "late.dump")] == [60]


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize("both", ENGINES, indirect=True)
def test_the_same_thermo_and_trajectory(both: tuple[Path, Path]) -> None:
    """thermo.csv has the deck's columns, as the engine prints them, at the same steps; trajectory.h5 all there is to know of a particle."""
    (heads, ours), (their_heads, theirs) = (table(folder / "thermo.csv") for folder in both)
    assert heads == their_heads
    assert ours[:, 0].tolist() == [0, 10, 20, 30, 40, 45, 60, 75]
    np.testing.assert_allclose(ours, theirs, rtol=1e-7)
    ours_h5, theirs_h5 = (list(read_h5md(folder / "trajectory.h5")) for folder in both)
    steps = {frame.step: frame for frame in theirs_h5}
    assert set(steps) >= {0, 20, 40, 60}
    for frame in ours_h5:
        assert set(frame.columns) >= {"id", "type", "x", "vx", "fx", "omegax", "tqx", "radius", "mass", "ix"}
        if frame.step in steps:
            for column, values in frame.columns.items():
                other = steps[frame.step].columns[column]
                np.testing.assert_allclose(values, other, rtol=1e-10, atol=1e-12 * np.abs(other).max(), err_msg=column)


def test_what_the_deck_prints_goes_into_its_log(demverify: Call, write: Write, tmp_path: Path) -> None:
    """stdout stays for the result of the command; log.native has the prints between the tables, where the engine's log has them."""
    found = demverify("run", write(LAMMPS), "--out", tmp_path / "out")
    assert "half way" not in found.out
    log = (tmp_path / "out" / "log.native").read_text()
    assert log.startswith("half way at step 0\n")
    assert log.endswith("done\n")
    assert [len(run.values) for run in read_thermo(tmp_path / "out" / "log.native")] == [6, 3]


def test_formulas_in_thermo_keep_their_digits(demverify: Call, write: Write, tmp_path: Path) -> None:
    """A column v_name is the formula's value itself, not its text of 15 digits."""
    found = demverify("run", write(deck(columns="variable third equal 1.0/3.0\nthermo_style custom step v_third")), "--out", tmp_path)
    assert found.status == 0
    assert table(tmp_path / "thermo.csv")[1][0, 1] == 1.0 / 3.0


def test_press_may_come_and_go_between_runs(demverify: Call, write: Write, tmp_path: Path) -> None:
    """A later thermo_style may ask for the pressure; a formula only where the table shows it, as in LAMMPS."""
    more = "run 10\nthermo_style custom step press\nrun 10\nprint $(press)\n"
    assert demverify("run", write(deck(run=more)), "--out", tmp_path / "a").status == 0
    assert table(tmp_path / "a" / "thermo.csv")[0] == ["Step", "Press"]
    found = demverify("run", write(deck(run='run 10\nprint "$(press)"\n')), "--out", tmp_path / "b")
    assert found.status == 2
    assert "press only where thermo_style prints it" in found.err


def test_a_deck_without_output_leaves_a_trajectory_all_the_same(demverify: Call, write: Write, tmp_path: Path) -> None:
    """No dump, no thermo: first and last step are kept, in full."""
    assert demverify("run", write(deck(dump="", thermo="", columns="")), "--out", tmp_path / "out").status == 0
    assert files_in(tmp_path / "out") == {"log.native", "thermo.csv", "trajectory.h5"}
    first, last = read_h5md(tmp_path / "out" / "trajectory.h5")
    assert (first.step, last.step) == (0, 20)
    np.testing.assert_allclose(first.columns["mass"], 2500 * np.pi * 0.01**3 / 6)


def test_a_second_run_takes_the_place_of_the_first(demverify: Call, write: Write, tmp_path: Path) -> None:
    """The folder of an earlier run is used again; no frame of the old run stays in the files of the new one."""
    for steps in (40, 20):
        assert demverify("run", write(deck(run=f"run {steps}")), "--out", tmp_path / "out").status == 0
    assert [frame.step for frame in read_h5md(tmp_path / "out" / "trajectory.h5")] == [0, 10, 20]
    assert [frame.step for frame in read_dump(tmp_path / "out" / "frames.dump")] == [0, 10, 20]

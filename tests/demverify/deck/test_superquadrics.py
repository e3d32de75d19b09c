"""Decks with superquadrics: wrong lines, restart files, random commands, and what a run leaves of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demsolver.shapes import superquadric
from demverify.analysis.energies import Wanted, energies_of
from demverify.analysis.meanings import Meanings
from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.errors import InputError
from demverify.formats.dump import read_dump
from demverify.formats.h5md import read_h5md
from demverify.runs import plan
from tests.support.engines import require_lammps
from tests.support.superquadric_decks import RULES, WORDS, deck

PAIR = "pair_style gran model hertz tangential history surface superquadric"


@pytest.mark.parametrize(("old", "new", "said"), [
    ("blockiness 4 3", "blockiness 1.9 3", ":11: set type blockiness must be 2 or more"),
    ("blockiness 4 3", "blockiness nan 3", ":11: set type n1 must be a number, got 'nan'"),
    ("blockiness 4 3", "blockiness 1e300 3", "particle 1: radius is not a finite number"),
    ("shape 0.03", "shape 0", ":11: set type semi-axis a must be above zero, got 0"),
    ("quat 1 1 0 30", "quat_direct 0 0 0 0", ":12: set atom the quaternion must not be zero"),
    ("density 2500", "diameter 0.1", ":11: set type keyword 'diameter' is not one of type, shape, blockiness"),
    ("fix move all nve/superquadric integration_scheme 1", "fix move all nve/sphere", ":24: fix move nve/sphere moves spheres"),
    ("integration_scheme 1", "integration_scheme 1\nfix b all nve/superquadric integration_scheme 2", ":25: fix b nve/superquadric: fix move has"),
    ("integration_scheme 1", "integration_scheme 4", ":24: fix move nve/superquadric integration_scheme must be from 0 to 3, got 4"),
    ("atom_style superquadric", "atom_style granular", ":11: set type keyword 'shape' is not one of"),
    (PAIR, PAIR.removesuffix(" surface superquadric"), ":20: pair_style gran surface default does not go with atom_style superquadric"),
    (" surface superquadric primitive", " primitive", ":23: fix w0 wall/gran surface default does not go with atom_style superquadric"),
    (PAIR, f"{PAIR} meanCurvature yes", ":20: pair_style gran meanCurvature and gaussianCurvature need curvatureLimitFactor"),
    (PAIR, f"{PAIR} curvatureLimitFactor 4 meanCurvature yes gaussianCurvature yes", ":20: pair_style gran has meanCurvature and"),
    (PAIR, f"{PAIR} curvatureLimitFactor 4 meanCurvature yes contactPoint gauge", ":20: pair_style gran meanCurvature and gaussianCurvature go with"),
    (PAIR, f"{PAIR} contactPoint middle", "contactPoint 'middle' is not one of potential, gauge"),
    ("tangential history surface", "tangential history cohesion sjkr surface", "cohesion sjkr is known for spheres only"),
    ("zplane -0.033", "zcylinder 0.5 0 0", ":23: fix w0 wall/gran a cylinder is no wall for superquadrics yet"),
    ("thermo 20\n", "fix ts all check/timestep/gran 10 0.1 0.1\n", "check/timestep/gran is of spheres: not with atom_style superquadric"),
    ("thermo 20\n", "fix t all particletemplate/multisphere 7\n", ":28: fix t particletemplate/multisphere makes clumps of spheres: not"),
    ("erotate/superquadric", "erotate/sphere", ":25: compute erotate/sphere is of spheres: not with atom_style superquadric"),
    ("create_box 1 box", "read_data bodies.data", ":8: read_data reads spheres"),
    ("set atom 2 vz -0.5", "displace_atoms all rotate 0 0 0 0 0 1 30 units box", ":13: displace_atoms rotate does not turn superquadrics"),
])  # fmt: skip
def test_wrong_lines_are_named(old: str, new: str, said: str, tmp_path: Path) -> None:
    """Law: one line that names the deck's line and what is wrong with it."""
    (tmp_path / "in.liggghts").write_text(deck((old, new)))
    with pytest.raises(InputError) as error:
        plan(tmp_path / "in.liggghts", {})
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_surface_superquadric_needs_superquadrics(tmp_path: Path) -> None:
    """Law: spheres do not take surface superquadric, as superquadrics take no other; two dimensions are not for superquadrics."""
    spheres = deck(("atom_style superquadric", "atom_style granular"), ("nve/superquadric integration_scheme 1", "nve/sphere"))
    lines = [line for line in spheres.splitlines() if not line.startswith(("set", "compute", "thermo_style"))]
    flat = deck(("boundary f f f", "boundary f f p"), ("units si", "units si\ndimension 2"), ("0.01 0.005 0.06", "0.01 0.06 0"))
    for text, said in (("\n".join(lines), "surface superquadric does not go with atom_style granular"), (flat, "move in three dimensions only")):
        (tmp_path / "in.liggghts").write_text(text)
        with pytest.raises(InputError, match=said):
            plan(tmp_path / "in.liggghts", {})


def run(text: str, folder: Path, every: int = 20) -> Path:
    """Runs a deck in the native engine; returns the folder of the run."""
    folder.mkdir(exist_ok=True)
    (folder / "in.liggghts").write_text(text)
    outcome = ENGINE.run(Job(folder / "in.liggghts", folder / "out", every=every))
    assert outcome.status == "ok", outcome.reason
    return folder / "out"


def test_a_box_may_be_empty_yet(tmp_path: Path) -> None:
    """Law: a dump of shapes begins with a frame of none where there are no superquadrics yet, and goes on with those that come."""
    empty = "\n".join(line for line in deck(end="").splitlines() if not line.startswith(("create_atoms", "set")))
    later = "dump d all custom 1 d.dump id quat1 shapex\nrun 1\ncreate_atoms 1 single 0 0 0.5\nset atom 1 shape 0.03 0.02 0.01\nrun 1\n"
    frames = list(read_dump(run(f"{empty}\n{later}", tmp_path) / "d.dump"))
    assert [frame.columns["shapex"].tolist() for frame in frames] == [[], [], [0.03]]


def test_a_trajectory_has_shapes(tmp_path: Path) -> None:
    """Law: trajectory.h5 carries what erotate needs: the energy of its frames is the thermo column of compute erotate/superquadric; spheres
    around the bodies would have another."""
    out = run(deck(), tmp_path)
    frames = list(read_h5md(out / "trajectory.h5"))
    printed = np.genfromtxt(out / "thermo.csv", delimiter=",", names=True)["rot"]
    rows = [energies_of(frame, Wanted(Meanings())).row for frame in frames]
    assert len(rows) == len(printed) == 3
    assert [row.erotate for row in rows] == pytest.approx(printed, rel=1e-13)
    assert all(row.by_shape["superquadric"] == row.erotate for row in rows)
    sphere = 0.2 * frames[0].columns["mass"] * frames[0].columns["radius"] ** 2 * (frames[0].vectors("omegax", "omegay", "omegaz") ** 2).sum(axis=1)
    assert sphere.sum() > 1.1 * printed[0]


@pytest.mark.parametrize("size", ["1e200", "1e-200"])
def test_a_quaternion_of_any_length(size: str, tmp_path: Path) -> None:
    """Law: a quaternion is normalised whatever its length, whose square may be no number."""
    (tmp_path / "in.liggghts").write_text(deck(("quat 1 1 0 30", f"quat_direct {size} -{size} 0 0")))
    shapes = plan(tmp_path / "in.liggghts", {}).runs[0].scene.particles.superquadrics
    assert shapes
    assert shapes.quat[0] == pytest.approx([0.5**0.5, -(0.5**0.5), 0.0, 0.0], rel=1e-15)


RESTART = f"""dump a all custom 20 a.dump id x y z fx fy fz omegax omegay omegaz quat1 quat2 quat3 quat4 shapex blockiness1
dump_modify a format "%d{' %.17g' * 15}"
run 20
write_restart state.*
run 20
clear
read_restart state.20
{RULES}dump b all custom 20 b.dump id x y z fx fy fz omegax omegay omegaz quat1 quat2 quat3 quat4 shapex blockiness1
dump_modify b format "%d{' %.17g' * 15}"
run 20
"""


def test_restart_files_keep_shapes(tmp_path: Path) -> None:
    """Law: after write_restart, clear and read_restart superquadrics in contact go on as if nothing had been, to the last bit; the atom style comes
    back with the file."""
    out = run(deck(end=RESTART), tmp_path)
    first, second = (list(read_dump(out / f"{name}.dump"))[-1] for name in "ab")
    assert first.step == second.step == 40
    assert np.abs(first.columns["fx"]).max() > 1.0
    assert all(np.array_equal(first.columns[name], second.columns[name]) for name in first.columns)


@pytest.mark.lammps
def test_random_commands_keep_shapes(tmp_path: Path) -> None:
    """Law: commands that LAMMPS draws keep the shapes there are; new particles are balls of diameter 1 and density 1, as of create_atoms."""
    require_lammps()
    path = tmp_path / "in.liggghts"
    path.write_text(WORDS + "displace_atoms all random 0.001 0.001 0.001 77 units box\ncreate_atoms 1 random 3 77 box\n" + RULES + "run 0\n")
    p = plan(path, {}).runs[0].scene.particles
    assert p.superquadrics
    assert p.superquadrics.axes[:2].tolist() == [[0.03, 0.025, 0.035]] * 2
    assert p.superquadrics.axes[2:].tolist() == [[0.5, 0.5, 0.5]] * 3
    assert p.superquadrics.quat[0, 0] == pytest.approx(np.cos(np.pi / 12) / np.sqrt(1.0 + np.sin(np.pi / 12) ** 2))
    volume = superquadric.volume(p.superquadrics.axes, p.superquadrics.blockiness)
    assert p.mass == pytest.approx(np.where(np.arange(5) < 2, 2500.0, 1.0) * volume)
    assert volume[2] == pytest.approx(np.pi / 6)
    assert 0.0 < np.abs(p.x[0]).max() < 0.002

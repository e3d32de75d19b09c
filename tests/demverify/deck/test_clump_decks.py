"""Decks with clumps that are wrong, or say what is not supported: one clear line each, that names the place."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from demsolver.state import moved
from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.errors import InputError
from demverify.runs import plan
from tests.support.cli import program
from tests.support.clump_decks import INPUTS, ran

ORIENTATION, REGION = "orientation constant 0.28 0.0 0.96 0.0", "region          ata block 0.001 0.0010000000000000002"
ROTATE = "rotate 147.47959058337608 0.0 1.0 0.0"
MOVE = "fix             move all rigid/small molecule"
PLACE = "create_atoms    0 single 0.001630065668759054 -0.0021581361661033318 0.00613758474167069"
LIGGGHTS: list[tuple[str, str, str]] = [
    (ORIENTATION, "orientation random", "needs distributiontemplate, region, particles_in_region 1, and orientation constant"),
    (ORIENTATION, "orientation constant 1.0 0.5 0.0 0.0", "the quaternion w x y z must have length 1, got 1.118"),
    (REGION, "region          ata block 0.001 0.002", "is 0.001 wide, and LIGGGHTS draws the place in it at random"),
    ("particles_in_region 1", "particles_in_region 2", "needs distributiontemplate, region, particles_in_region 1"),
    ("discrete 32452867 1 clump 1.0", "discrete 32452867 2 clump 0.5 clump 0.5", "of 2 templates draws at random: supported is one"),
    ("discrete 32452867 1 clump 1.0", "discrete 32452867 1 klump 1.0", "'klump' is not a fix particletemplate/multisphere"),
    ("distributiontemplate parts", "distributiontemplate clump", "'clump' is not a fix particledistribution/discrete"),
    ("nspheres 4", "nspheres 3", "nspheres is 3, and clump.ms has 4 spheres"),
    ("nspheres 4", "nspheres 1", "nspheres"),
    ("mass 0.002710932660660192 ", "", "mass and inertia_tensor go together"),
    ("use_density inertia_tensor", "use_volume inertia_tensor", "needs use_density: with use_volume LIGGGHTS moves the centre of mass"),
    ("4.2735009588396914e-08 7.74", "-4.2735009588396914e-08 7.74", "inertia_tensor must have three moments above 0"),
    ("spheres file clump.ms", "spheres file none.ms", "none.ms"),
    ("vel constant 0.3", "vel uniform 0.3", "vel"),
    ("region ata ntry_mc", "region atb ntry_mc", "region 'atb' is not a region with bounds"),
    ("multisphere property quat", "multisphere property quats", "expects property id_multisphere | masstotal"),
    ("c_b_quat[4]", "c_b_quat[5]", "this compute has c_b_quat[1] to c_b_quat[4]"),
    ("c_b_masstotal", "c_b_masses", "column 'c_b_masses' is not of a compute"),
    ("c_b_masstotal", "c_kin", "column 'c_kin' is not of a compute"),
    ("run             1\n", "fix push all addforce 0.0 0.0 1.0\nrun             1\n", "fix push addforce acts within the step of insertion"),
    ("fix             move all multisphere", "fix             move all rigid/small", "rigid/small"),
    ("radius mass\ndump_modify members", "radius density\ndump_modify members", "density of members of clumps"),
    ("run             ${steps}", "run 1\nunfix move\nrun 1", "fix move multisphere holds the clumps, and LIGGGHTS does not let it go"),
]
LAMMPS: list[tuple[str, str, str]] = [
    (f" {ROTATE}", "", "mol needs rotate: without it LAMMPS draws the orientation at random"),
    (ROTATE, "rotate 30.0 0.0 0.0 0.0", "the axis of rotate must not be zero"),
    ("fix             mol all property/atom mol ghost yes\n", "", "mol needs fix property/atom mol before it"),
    ("mol clump 4321", "mol klump 4321", "molecule 'klump' does not exist; defined: clump"),
    ("molecule        clump clump.mol", "molecule        clump none.mol", "none.mol"),
    ("create_atoms    0 single", "create_atoms    1 single", "molecule clump has type 2, and there are 1"),
    (PLACE, "create_atoms    0 box", "mol is supported with single alone"),
    (MOVE, f"{MOVE}\nfix also all nve/sphere", "moves spheres that fix move"),
    (MOVE, "fix             move all rigid/small single", "single"),
    (MOVE, f"{MOVE}\nfix two all rigid molecule", "one fix for all is supported"),
    ("rigid/local move mol mass", "rigid/local move mol mas", "attribute 'mas' is not one of mol, mass"),
    (MOVE, f"{MOVE} infile f", "infile"),
    ("c_body[*]", "c_body[22]", "this compute has c_body[1] to c_body[21]"),
    ("c_body[*]", "c_bodies[*]", "column 'c_bodies[*]' is not of a compute"),
    (PLACE, "create_atoms    0 single 0.2 -0.002 0.006", "x = 0.2 is outside the box, -0.05 to 0.05"),
    ("ke/rigid move", "ke/rigid moves", "compute kin ke/rigid expects a fix of rigid bodies, got moves; there are: move"),
    ("rigid/local move", "rigid/local moves", "compute body rigid/local expects a fix of rigid bodies, got moves; there are: move"),
    (MOVE, f"group some id 1\n{MOVE.replace(' all ', ' some ')}", "molecule 1 has one sphere in group some; a body has two or more"),
    (MOVE, f"group some id 1 2 3\n{MOVE.replace(' all ', ' some ')}", "hides contacts of spheres 1 and 4 too, of molecule 1 but of no one clump"),
    (MOVE, f"create_atoms 1 single 0 0 0.02\ncreate_atoms 1 single 0 0 0.04\n{MOVE}", "spheres 5 and 6 too, of molecule 0 but of no one clump"),
    ("exclude molecule/intra all", "exclude molecule/intra a\ngroup a delete", "group 'a' is in use by neigh_modify exclude"),
]  # fmt: skip


def changed(dialect: str, old: str, new: str, folder: Path) -> Path:
    """The case deck with one thing changed, beside its files."""
    shutil.copytree(INPUTS / "clump-bounce", folder / "case")
    deck = folder / "case" / f"in.{dialect}"
    text = deck.read_text()
    assert text.count(old) >= 1, old
    deck.write_text(text.replace(old, new, 1))
    return deck


@pytest.mark.parametrize(("dialect", "old", "new", "says"), [*(("liggghts", *row) for row in LIGGGHTS), *(("lammps", *row) for row in LAMMPS)])
def test_what_is_wrong_is_said_in_one_line(dialect: str, old: str, new: str, says: str, tmp_path: Path) -> None:
    """Law: a deck with one thing wrong ends in one line that names it, and a line of the deck or the file that is wrong."""
    deck = changed(dialect, old, new, tmp_path)
    with pytest.raises(InputError, match=re.escape(says)) as error:
        plan(deck, {})
    assert "\n" not in str(error.value)
    assert re.search(r"(in\.\w+:\d+|none\.m\w+)", str(error.value))


def test_rigid_without_molecules(tmp_path: Path) -> None:
    """Law: fix rigid of spheres none of which has a molecule is refused."""
    deck = changed("lammps", MOVE, "set group all mol 0\nfix move all rigid/small molecule", tmp_path)
    with pytest.raises(InputError, match=r"(no particle of group all has a molecule|mol)"):
        plan(deck, {})


@pytest.mark.parametrize("dialect", ["lammps", "liggghts"])
def test_restart_files_keep_no_clumps(dialect: str, tmp_path: Path) -> None:
    """Law: write_restart with clumps is refused in one line, and leaves no file."""
    deck = changed(dialect, "run             ${steps}", "run 2\nwrite_restart state", tmp_path)
    with pytest.raises(InputError, match="write_restart keeps spheres and superquadrics, not clumps"):
        ENGINE.run(Job(deck, tmp_path / "out", {}, None, 60.0, 1, 1))
    assert not list((tmp_path / "out").glob("state*"))


def test_frozen_spheres_need_not_see_each_other(tmp_path: Path) -> None:
    """Law: exclude molecule/intra all is as good as of clumps alone where all loose spheres are frozen; one that moves would not see them."""
    loose = "create_atoms 1 single 0 0 0.02\ncreate_atoms 1 single 0 0 0.04\ngroup floor id 5 6\ngroup free id 6\n"
    deck = changed("lammps", MOVE, f"{loose}fix hold floor freeze\n{MOVE}", tmp_path)
    clumps = plan(deck, {}).runs[-1].scene.particles.clumps
    assert clumps is not None
    assert clumps.body.tolist() == [0, 0, 0, 0, -1, -1]
    deck.write_text(deck.read_text().replace("fix hold floor", "fix hold free"))
    with pytest.raises(InputError, match="hides contacts of spheres 5 and 6 too"):
        plan(deck, {})


def test_spheres_whose_fix_rigid_is_gone_are_loose(tmp_path: Path) -> None:
    """Law: after unfix of fix rigid its spheres are clumps no more: fix nve/sphere moves each on its own."""
    deck = changed("lammps", "exclude molecule/intra all", "", tmp_path)
    deck.write_text(deck.read_text().split("compute ")[0] + "run 1\nunfix move\nfix fly all nve/sphere\nrun 1\n")
    before, after = (run.scene for run in plan(deck, {}).runs)
    assert before.particles.clumps is not None
    assert after.particles.clumps is None
    assert moved(after).all()


COMMANDS = dict.fromkeys(("timestep", "stability"), "the limits of a step are known for spheres on their own, not for clumps")


@pytest.mark.parametrize("dialect", ["lammps", "liggghts"])
@pytest.mark.parametrize("command", [*COMMANDS, "convert", "run --sleep"])
def test_commands_that_know_no_clumps_say_so(dialect: str, command: str, tmp_path: Path) -> None:
    """Law: timestep, stability, convert and run --sleep end with exit status 2 and one line for a deck with clumps, and leave nothing."""
    deck, other = INPUTS / "clump-collision" / f"in.{dialect}", "liggghts" if dialect == "lammps" else "lammps"
    words = {"convert": ["convert", deck, "--to", other, "-o", "converted"], "run --sleep": ["run", deck, "--sleep", "1e-3", "--out", "run"]}
    process = program(*words.get(command, [command, deck]), cwd=tmp_path)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 2
    assert error.startswith("demverify: ")
    assert error.count("\n") == 1
    assert {"convert": "clumps, which are not converted", "run --sleep": "clumps do not sleep", **COMMANDS}[command] in error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("dialect", ["lammps", "liggghts"])
def test_energies_of_the_dumps_are_the_printed_ones(dialect: str, tmp_path: Path) -> None:
    """Law: `demverify erotate` of what a native run of clumps dumped, members and bodies, gives the thermo columns of rotational energy to 1e-12."""
    run = ran("clump-collision", f"native-{dialect}", tmp_path, every=500)
    process = program(
        "erotate", run.folder / "members.dump", "--bodies", run.folder / "bodies.dump", "--deck", INPUTS / "clump-collision" / f"in.{dialect}",
        "--csv", tmp_path / "energies.csv",
    )  # fmt: skip
    _, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    energies = np.genfromtxt(tmp_path / "energies.csv", delimiter=",", names=True)
    thermo = np.genfromtxt(run.folder / "thermo.csv", delimiter=",", names=True)
    prefix = "c_" if dialect == "lammps" else ""  # which LIGGGHTS leaves out
    rows = {int(step): k for k, step in enumerate(thermo["Step"])}
    printed = np.array([thermo[f"{prefix}rot"][rows[int(step)]] for step in energies["step"]])
    assert len(printed) == 4
    column = next(name for name in energies.dtype.names if "multisphere" in name or "clump" in name)
    assert np.abs(energies[column] / printed - 1.0).max() < 1e-12
    p = plan(INPUTS / "clump-collision" / f"in.{dialect}", {}).runs[-1].scene.particles.clumps
    assert p is not None
    assert printed[0] == pytest.approx(0.5 * float(np.sum(p.angmom * p.omega)), rel=1e-12)
    assert thermo[f"{prefix}kin"][rows[0]] == pytest.approx(0.5 * float(p.mass @ (p.v**2).sum(axis=1)), rel=1e-12)

"""Register entries on LIGGGHTS' rigid clumps: three spheres that do not overlap, so mass and inertia are sums of spheres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Floats
from tests.support.deviations import assert_deviates
from tests.support.engines import EngineRun, run_liggghts

pytestmark = pytest.mark.liggghts

DENSITY, TRIES = 2500.0, 5_000_000
SPHERES = np.array([[0.010, 0.0, 0.0, 0.003], [0.0, 0.008, 0.002, 0.003], [-0.004, -0.003, 0.009, 0.002]])
TEMPLATE = f"atom_type 1 density constant {DENSITY} nspheres 3 ntry {TRIES} spheres file clump scale 1.0 type 1"
INSERTION = "vel constant 0. 0. -1. omega constant 5. -3. 8. insert_every once overlapcheck yes region in ntry_mc 10000"
DECK = f"""atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
region box block -0.3 0.3 -0.3 0.3 -0.3 0.3 units box
create_box 1 box
neighbor 0.004 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 1.e7
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.5
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran model hertz tangential history
pair_coeff * *
timestep 0.00001
fix t all particletemplate/multisphere 15485863 {TEMPLATE}
fix p all particledistribution/discrete 32452867 1 t 1.0
region in block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box
fix i all insert/pack seed 32452843 distributiontemplate p {INSERTION} particles_in_region 1
fix n all multisphere
compute em all erotate/multisphere
compute es all erotate/sphere
compute bi all multisphere property inertia
compute bm all multisphere property masstotal
thermo_style custom step c_em c_es
thermo 1
run 1
dump d all custom 1 out.dump id radius mass density
dump b all local 1 bodies.local c_bm c_bi[1] c_bi[2] c_bi[3]
dump_modify b format "%.16g %.16g %.16g %.16g"
run 1
"""


@dataclass(frozen=True)
class Clump:
    """One run with one clump: the engine's mass and principal moments (ascending) of the body."""

    run: EngineRun
    mass: float
    moments: Floats


@pytest.fixture(scope="module")
def clump(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Clump]:
    """Runs the deck once for all tests."""
    folder = tmp_path_factory.mktemp("clump")
    np.savetxt(folder / "clump", SPHERES, fmt="%.17g")
    run = run_liggghts(DECK, folder)
    values = np.array((folder / "bodies.local").read_text().splitlines()[-1].split(), dtype=float)
    yield Clump(run, values[0], np.sort(values[1:]))


def sphere_masses() -> Floats:
    """Mass of each sphere."""
    masses: Floats = 4 / 3 * np.pi * SPHERES[:, 3] ** 3 * DENSITY
    return masses


def exact_tensor() -> Floats:
    """Sum of 2/5 m R^2 and Steiner's terms about the centre of mass."""
    masses = sphere_masses()
    arms = SPHERES[:, :3] - masses @ SPHERES[:, :3] / masses.sum()
    own = 0.4 * masses @ SPHERES[:, 3] ** 2 * np.eye(3)
    steiner = (m * (a @ a * np.eye(3) - np.outer(a, a)) for m, a in zip(masses, arms, strict=True))
    tensor: Floats = np.sum([own, *steiner], axis=0)
    return tensor


def test_inertia_of_an_asymmetric_clump_is_wrong(clump: Clump) -> None:
    """Law: principal moments are the eigenvalues of the inertia tensor. Here I_yz is the mean of itself and I_xz before they are
    taken. Tolerance: 5e6 random points, of which some two percent fall into the clump."""
    exact = exact_tensor()
    slip = exact.copy()
    slip[1, 2] = slip[2, 1] = 0.5 * (exact[1, 2] + exact[0, 2])
    moments, law = np.linalg.eigvalsh(slip), np.linalg.eigvalsh(exact)
    scaled = clump.moments * sphere_masses().sum() / clump.mass
    assert_deviates("liggghts-multisphere-inertia", scaled / law, engine_rule=moments / law, law=np.ones(3), rtol=0.007)


def test_mass_of_a_clump_is_a_random_estimate(clump: Clump) -> None:
    """Law: the mass is density times volume. Here it is a count of random points: off by a few standard errors, never exact."""
    exact = sphere_masses().sum()
    extent = np.prod((SPHERES[:, :3] + SPHERES[:, 3:]).max(0) - (SPHERES[:, :3] - SPHERES[:, 3:]).min(0))
    share = exact / DENSITY / extent
    standard_error = np.sqrt((1 - share) / share / TRIES)
    off = abs(clump.mass / exact - 1)
    assert 1e-6 < off < 5 * standard_error, "register entry liggghts-multisphere-mass is out of date"


def test_erotate_sphere_leaves_members_out(clump: Clump) -> None:
    """Law: a turning body has rotational energy. `erotate/sphere` counts no sphere of a clump, so it prints zero."""
    table = clump.run.thermo[0]
    energy = table.values[-1, 1]
    assert energy > 0
    assert_deviates("liggghts-erotate-sphere-members", table.values[-1, 2] / energy, engine_rule=0.0, law=1.0, rtol=1e-12)


def test_members_are_dumped_with_the_mass_of_their_clump(clump: Clump) -> None:
    """Law: the masses of a dump add up to the mass of the system. Here every sphere of a clump carries the mass of the whole."""
    masses = clump.run.frames[0].columns["mass"]
    assert_deviates("liggghts-multisphere-dump-mass", masses.sum() / clump.mass, engine_rule=3.0, law=1.0, rtol=1e-5)


def run_around(folder: Path, before: str = "", after: str = "", columns: str = "", *, may_fail: bool = False) -> EngineRun:
    """The deck with lines before and behind fix multisphere, and more columns of thermo output."""
    folder.mkdir(exist_ok=True)
    np.savetxt(folder / "clump", SPHERES, fmt="%.17g")
    deck = DECK.replace("fix n all multisphere", f"{before}\nfix n all multisphere\n{after}").replace("step c_em c_es", f"step c_em c_es {columns}")
    return run_liggghts(deck.replace(f"ntry {TRIES}", "ntry 100000"), folder, may_fail=may_fail)


def printed(run: EngineRun, name: str) -> float:
    """The last value of a column."""
    table = run.thermo[-1]
    return float(table.values[-1, table.columns.index(name)])


def test_other_integrators_move_members_once_more(tmp_path: Path) -> None:
    """Law: the spheres of a clump keep their places in it. fix nve/sphere takes each of them dt v further, after fix multisphere has put it
    in its place and before contacts are looked for; v is that of the next step, which turns by 1e-4 rad. Tolerance: that turn."""
    dump = 'dump x all custom 1 x.dump id x y z vx vy vz\ndump_modify x format "%d %.17g %.17g %.17g %.17g %.17g %.17g"'
    runs = (run_around(tmp_path / name, after=line + dump) for name, line in (("one", ""), ("two", "fix s all nve/sphere\n")))
    alone, twice = (run.frames[-1] for run in runs)
    ahead = twice.vectors("x", "y", "z") - alone.vectors("x", "y", "z")
    moving = 1e-5 * alone.vectors("vx", "vy", "vz")
    assert ahead.shape == (3, 3)
    assert_deviates("liggghts-multisphere-nve-sphere", ahead, engine_rule=moving, law=np.zeros((3, 3)), rtol=1e-4)


def test_whole_numbers_printed_as_floats_are_other_numbers(tmp_path: Path) -> None:
    """Law: %g prints a whole number as what it is. LIGGGHTS hands printf an int there, so that it prints the double it had before."""
    dump = 'dump x all custom 1 x.dump id density id_multisphere mol\ndump_modify x format "%d %g {} {}"'
    right, wrong = (run_around(tmp_path / name, after=dump.format(of, of)).frames[-1].columns for name, of in (("d", "%d"), ("g", "%.16g")))
    for column in ("id_multisphere", "mol"):
        assert right[column].tolist() == [1, 1, 1]
        assert_deviates("liggghts-dump-format-integers", wrong[column], engine_rule=[DENSITY] * 3, law=right[column], rtol=1e-12)


def test_erotate_before_fix_multisphere_leaves_clumps_out(tmp_path: Path) -> None:
    """Law: a compute gives the same wherever it stands. compute erotate looks for fix multisphere when it is made, and never again."""
    compute = "compute er all erotate"
    before, behind = run_around(tmp_path / "before", compute, columns="c_er"), run_around(tmp_path / "behind", after=compute, columns="c_er")
    assert printed(behind, "er") == printed(behind, "em") > 0
    assert_deviates("liggghts-erotate-before-multisphere", printed(before, "er"), engine_rule=0.0, law=printed(before, "em"), rtol=1e-12)


def test_a_second_erotate_is_refused(tmp_path: Path) -> None:
    """Law: a deck may have a compute twice, for two groups. Each compute erotate makes children under the same names."""
    run = run_around(tmp_path / "two", after="compute er all erotate\ncompute es2 all erotate", may_fail=True)
    assert run.code, "register entry liggghts-second-erotate is out of date: LIGGGHTS runs the deck"
    assert "Reuse of compute ID" in run.log


def test_energies_of_a_group_have_all_clumps(tmp_path: Path) -> None:
    """Law: a group without members has no energy. Computes ke, erotate and erotate/multisphere add those of all clumps to any group's."""
    lines = "group none id 99999\ncompute kn none ke\ncompute mn none erotate/multisphere\ncompute km all ke/multisphere\ncompute en none erotate"
    run = run_around(tmp_path / "none", after=lines, columns="c_kn c_mn c_km c_en")
    for of_none, of_all in (("kn", "km"), ("mn", "em"), ("en", "em")):
        scale = printed(run, of_all)
        assert_deviates("liggghts-clumps-in-any-group", printed(run, of_none) / scale, engine_rule=1.0, law=0.0, rtol=1e-12)

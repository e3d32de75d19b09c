"""`demverify.erotate` and `demverify erotate` on the files of LAMMPS, its deck as the dictionary, against the energies it prints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from demverify import erotate
from demverify.errors import InputError
from tests.demverify.analysis.printed import ROUNDING, Run, assert_printed, command, printed
from tests.support.engines import run_lammps

pytestmark = pytest.mark.lammps
FULL = "format float %.17g"


def simulate(folder: Path, deck: str) -> Run:
    """Runs a deck; some of its dumps go to a folder post."""
    (folder / "post").mkdir()
    return Run(folder, printed(run_lammps(deck, folder)))


OUTPUT = f"""compute e all erotate/sphere
compute k all ke
thermo_style custom step atoms c_e c_k
thermo_modify lost ignore norm no format float %.17g
thermo 100
compute s all property/atom radius omegax omegay omegaz
dump light all custom 100 light.txt id type radius vx vy vz omegax omegay omegaz
dump_modify light {FULL} units yes time yes
dump whole all custom 100 whole.txt id diameter mass vx vy vz omegax omegay omegaz
dump_modify whole {FULL} units yes time yes
dump packed all custom 100 packed.bin id omegaz omegay omegax vx vy vz mass radius
dump yaml all yaml 100 all.yaml id type radius vx vy vz omegax omegay omegaz
dump_modify yaml {FULL} time yes units yes
dump gz all custom 100 one.gz id type radius vx vy vz omegax omegay omegaz
dump_modify gz {FULL}
dump gzs all custom/gz 100 post/many.*.gz id type radius vx vy vz omegax omegay omegaz
dump_modify gzs {FULL}
dump bare all custom 100 post/bare.*.pour vx vy vz id type c_s[*]
dump_modify bare {FULL} header no pad 6
dump named all custom 100 named.txt id c_s[*] vx vy vz type
dump_modify named {FULL} colname c_s[1] R colname 3 spin
"""
SPACE = f"""units si
atom_style sphere
atom_modify map array
boundary p p f
newton off
comm_modify vel yes
region box block 0 0.07 0 0.07 0 0.07
create_box 2 box
region low block 0 0.07 0 0.07 0.005 0.04
region high block 0 0.07 0 0.07 0.04 0.066
lattice sc 0.0105
create_atoms 1 region low
create_atoms 2 region high
variable size atom 0.009+0.0015*sin(1000*x+300*y+70*z)
set group all diameter v_size
set type 1 density 2500 omega 20 10 -30
set type 2 density 1234.5 omega -5 3 8
velocity all create 1e19 4928459
pair_style gran/hooke/history 1e3 NULL 50 NULL 0.5 1
pair_coeff * *
neighbor 0.002 bin
timestep 2e-5
fix g all gravity 9.81 vector 0 0 -1
fix floor all wall/gran granular hooke 1e3 50 tangential linear_history 5e2 0 0.5 damping mass_velocity zplane 0 NULL
fix n all nve/sphere
{OUTPUT}run 500
"""
PLANE = f"""units si
dimension 2
atom_style sphere
atom_modify map array
boundary p f p
newton off
comm_modify vel yes
region box block 0 0.3 0 0.3 -0.02 0.02
create_box 2 box
region low block 0 0.3 0.005 0.14 -0.001 0.001
region slab block 0.05 0.25 0.2 0.29 -0.01 0.01
lattice sq 0.02
create_atoms 1 region low
set type 1 diameter 0.0205
set type 1 density 2500 omega 0 0 12.5
fix pour all pour 20 2 12345 region slab diam range 0.014 0.016 dens 900 900 vol 0.4 10
pair_style gran/hooke/history 1e3 NULL 5 NULL 0.5 1
pair_coeff * *
neighbor 0.002 bin
timestep 2e-5
fix g all gravity 9.81 vector 0 -1 0
fix floor all wall/gran granular hooke 1e3 5 tangential linear_history 5e2 0 0.5 damping mass_velocity yplane 0 NULL
fix n all nve/sphere disc
fix flat all enforce2d
{OUTPUT}run 500
"""


@pytest.fixture(scope="module", params=[SPACE, PLANE], ids=["space", "plane"])
def spheres(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Some hundred polydisperse spheres that collide and spin; in the plane, some are poured while it runs."""
    run = simulate(tmp_path_factory.mktemp("spheres"), request.param)
    assert abs(run.table[500]["e"] / run.table[0]["e"] - 1) > 0.01  # contacts have changed the spins
    return run


@pytest.mark.parametrize("files", ["light.txt", "all.yaml", "one.gz", "post/many.*.gz", "post/bare.*.pour", "named.txt"])
def test_spheres_with_densities_of_the_deck(spheres: Run, files: str) -> None:
    """Law: 1/5 m R^2 omega^2 over all spheres, m = 4/3 pi R^3 rho in the plane too, is what LAMMPS prints, from whatever file: rho by type from
    the deck, also of spheres that are poured, columns by the deck's computes, new names and order, steps by the name of a file without header."""
    found = erotate(str(spheres.folder / files), deck=spheres.deck)
    assert_printed(found, spheres.table, 6, erotate="e", sphere="e", ke="k")
    assert_allclose(found["time"], found["step"] * 2e-5, rtol=1e-15)
    assert_array_equal(found["n"], [spheres.table[row.step]["Atoms"] for row in found.rows])
    assert found.notes == ()


@pytest.mark.parametrize("files", ["whole.txt", "packed.bin"])
def test_spheres_with_mass_need_no_deck(spheres: Run, files: str) -> None:
    """Law: mass, radius or diameter and omega are enough; time is what the file says."""
    found = erotate(spheres.folder / files)
    assert_printed(found, spheres.table, 6, erotate="e", sphere="e", ke="k")
    if files == "whole.txt":
        assert_allclose(found["time"], found["step"] * 2e-5, rtol=1e-15)


def test_the_command_line(spheres: Run) -> None:
    """Law: the command finds what the library finds, in a file without header by the deck and by names of columns."""
    rows, said = command(spheres.folder, "post/bare.*.pour", "--deck", "in.deck")
    assert said == ""
    assert rows == [row.as_dict() for row in erotate(str(spheres.folder / "post/bare.*.pour"), deck=spheres.deck).rows]
    names = "vx vy vz id type radius omegax omegay omegaz"
    assert rows == command(spheres.folder, "post/bare.*.pour", "--columns", names, "--deck", "in.deck")[0]


def test_what_nobody_says_is_asked_for(spheres: Run) -> None:
    """Law: without the deck, names that a dump gives its columns mean nothing, nor do files without names: the error says what is missing."""
    with pytest.raises(InputError, match=r"named\.txt: step 0: .*radius or diameter and omegax omegay omegaz; the dump has id R spin .*--columns"):
        erotate(spheres.folder / "named.txt")
    with pytest.raises(InputError, match=r"bare\.\d+\.pour.*--columns"):
        erotate(str(spheres.folder / "post/bare.*.pour"))


def test_a_mass_that_no_density_gives(tmp_path: Path) -> None:
    """Law: with density/disc LAMMPS gives discs pi R^2 rho, which the sphere's density does not tell: without masses that is an error."""
    run = simulate(tmp_path, PLANE.replace("density 2500 omega", "density/disc 2500 omega").replace("run 500", "run 0"))
    assert_printed(erotate(run.folder / "whole.txt", deck=run.deck), run.table, 1, erotate="e")
    with pytest.raises(InputError, match=r"needs the columns mass|density of type 1"):
        erotate(run.folder / "light.txt", deck=run.deck)


ONE = f"""units {{units}}
atom_style sphere
boundary f f f
region box block 0 10 0 10 0 10
create_box 1 box
create_atoms 1 single 3 3 3
create_atoms 1 single 6 6 6
set type 1 diameter 1.3
set type 1 density 2.5 omega 0.1 0.2 0.3
velocity all set 0.1 0.2 0.5
pair_style none
fix n all nve/sphere
compute e all erotate/sphere
compute k all ke
thermo_style custom step c_e c_k
thermo_modify norm no {FULL}
thermo 1
dump light all custom 1 light.txt id type radius vx vy vz omegax omegay omegaz
dump_modify light {FULL}
dump whole all custom 1 whole.txt id radius mass vx vy vz omegax omegay omegaz
dump_modify whole {FULL} units yes
run 2
"""


@pytest.mark.parametrize("units", ["real", "metal", "electron", "si", "cgs", "micro", "nano", "lj"])
def test_units_of_energy(units: str, tmp_path: Path) -> None:
    """Law: compute erotate/sphere and compute ke give m v^2 in the units of energy, times mvv2e of units real, metal and electron; the deck
    says the units, or the dump itself (ITEM: UNITS)."""
    run = simulate(tmp_path, ONE.format(units=units))
    for found in (erotate(tmp_path / "light.txt", deck=run.deck), erotate(tmp_path / "whole.txt")):
        assert_printed(found, run.table, 3, erotate="e", ke="k")
    raw = 2 * 0.2 * (4 / 3 * np.pi * 0.65**3 * 2.5) * 0.65**2 * 0.14
    assert (run.table[0]["e"] == pytest.approx(raw, rel=ROUNDING)) == (units not in {"real", "metal", "electron"})


POINTS = """units si
atom_style sphere
boundary f f f
region box block 0 10 0 10 0 10
create_box 2 box
create_atoms 1 single 3 3 3
create_atoms 2 single 6 6 6
set type 1 diameter 1.3
set type 1 density 2.5 omega 0.1 0.2 0.3
set type 2 diameter 0
set type 2 density 7
velocity all set 0.1 0.2 0.5
pair_style none
fix n all nve
compute e all erotate/sphere
compute k all ke
thermo_style custom step c_e c_k
thermo_modify norm no format float %.17g
thermo 1
dump light all custom 1 light.txt id type radius vx vy vz omegax omegay omegaz
dump_modify light format float %.17g
dump whole all custom 1 whole.txt id radius mass vx vy vz omegax omegay omegaz
dump_modify whole format float %.17g
run 2
"""


def test_points_count_nothing(tmp_path: Path) -> None:
    """Law: a particle of radius 0 has no rotational energy; its mass does not follow from a density, so that the translational energy of a
    dump without masses is not known."""
    run = simulate(tmp_path, POINTS)
    assert_printed(erotate(tmp_path / "whole.txt"), run.table, 3, erotate="e", ke="k")
    found = erotate(tmp_path / "light.txt", deck=run.deck)
    assert_printed(found, run.table, 3, erotate="e")
    assert np.isnan(found["ke"]).all()

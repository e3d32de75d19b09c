"""`demverify.erotate` on rigid bodies and ellipsoids of LAMMPS, its deck as the dictionary, against the energies it prints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from demverify import erotate
from demverify.errors import InputError
from tests.demverify.analysis import test_lammps_asphere as asphere
from tests.demverify.analysis import test_lammps_rigid as rigid
from tests.demverify.analysis.printed import Run, assert_printed, printed
from tests.support.engines import run_lammps

pytestmark = pytest.mark.lammps
FULL = "format float %.17g"


def simulate(folder: Path, deck: str) -> Run:
    """Runs a deck; some of its dumps go to a folder post."""
    (folder / "post").mkdir()
    return Run(folder, printed(run_lammps(deck, folder)))


CLUMPS = rigid.DECK.replace("run 1000", "").replace("compute es free erotate/sphere", """compute es free erotate/sphere
compute kf free ke
variable all equal c_er+c_es
variable ke equal c_kr+c_kf""").replace("custom step c_er", "custom step v_all v_ke c_er") + f"""{{bodies}}
dump light all custom 100 light.txt id mol type xu yu zu vx vy vz radius
dump_modify light {FULL}
run {{steps}}
"""
BODIES = f"""compute b all rigid/local r mass vx vy vz omegax omegay omegaz quatw quati quatj quatk inertiax inertiay inertiaz mol
compute c all rigid/local r angmomz angmomy angmomx inertiaz inertiay inertiax quatw quati quatj quatk mass vz vy vx id
dump b all local 100 spins.bodies c_b[*]
dump_modify b {FULL}
dump c all local 100 post/momenta*.bodies index c_c[*]
dump_modify c {FULL}"""
PRINTED = {"erotate": "all", "multisphere": "er", "sphere": "es", "ke": "ke"}


def clumps(folder: Path, fix: str, units: str = "lj", steps: int = 1000) -> Run:
    """The clumps of test_lammps_rigid, some of which the faces of the box cut, and three free spheres."""
    rigid.write_data(folder)
    deck = CLUMPS.format(rigid=fix, bodies=BODIES if "small" in fix else "", steps=steps)
    return simulate(folder, deck.replace("units lj", f"units {units}"))


@pytest.fixture(scope="module", params=["rigid", "rigid/small", "rigid/nve/small"])
def bodies(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The run with one of the fixes."""
    return clumps(tmp_path_factory.mktemp("rigid"), request.param)


def test_clumps_by_their_molecules(bodies: Run) -> None:
    """Law: with a deck that has fix rigid molecule, the column mol numbers the bodies and what LAMMPS prints of bodies and of free spheres
    comes back; without a deck nobody knows whether molecules are rigid, which is an error."""
    found = erotate(bodies.folder / "out.dump", deck=bodies.deck)
    assert_printed(found, bodies.table, 11, **PRINTED)
    assert {row.n for row in found.rows} == {93}
    with pytest.raises(InputError, match="column mol may number rigid bodies or not: give --deck DECK"):
        erotate(bodies.folder / "out.dump")
    named = "id id_multisphere type x y z vx vy vz omegax omegay omegaz radius mass"
    apart = erotate(bodies.folder / "out.dump", columns=named.split(), inertia="spheres")
    assert_printed(apart, bodies.table, 11, **PRINTED)


@pytest.mark.parametrize("files", ["spins.bodies", "post/momenta*.bodies"])
@pytest.mark.parametrize("bodies", ["rigid/small", "rigid/nve/small"], indirect=True)
def test_clumps_from_rigid_local(bodies: Run, files: str) -> None:
    """Law: bodies that compute rigid/local lists, by omega or by angmom, in any order of columns, have the printed energy, with the free
    spheres of the particles' dump or alone."""
    found = erotate(bodies.folder / "out.dump", str(bodies.folder / files), deck=bodies.deck)
    assert_printed(found, bodies.table, 11, **PRINTED)
    alone = erotate(str(bodies.folder / files), deck=bodies.deck)
    assert_printed(alone, bodies.table, 11, erotate="er", multisphere="er", ke="kr")


def test_masses_that_the_deck_does_not_tell(bodies: Run) -> None:
    """Law: the data file gives one type two densities, so that a dump without mass is an error, and one with mass is none."""
    with pytest.raises(InputError, match=r"the density of type 1 is not known: 1.5 .*; 2.5 .*: give --density X or a dump with column mass"):
        erotate(bodies.folder / "light.txt", deck=bodies.deck)


def test_clumps_in_other_units(tmp_path: Path) -> None:
    """Law: erotate/rigid and ke/rigid are in the units of energy too."""
    run = clumps(tmp_path, "rigid/small", units="metal", steps=200)
    for known in ({}, {"bodies": tmp_path / "spins.bodies"}):
        assert_printed(erotate(tmp_path / "out.dump", deck=run.deck, **known), run.table, 3, **PRINTED)  # type: ignore[arg-type]


MIXED = ("ellipsoid", "hybrid ellipsoid sphere", "hybrid sphere ellipsoid")
MORE = """compute ke all ke
group balls type 5
fix spin balls nve/sphere
compute ball balls erotate/sphere
variable all equal c_rot+c_ball
"""


def mixed_deck(style: str) -> str:
    """The bodies of test_lammps_asphere in contact, and the fifth particle: a point, or in a hybrid style a sphere that spins."""
    hybrid = style != "ellipsoid"
    shapes = "\n".join(f"set type {number} shape {shape}" for number, shape in enumerate(asphere.SHAPES, 1))
    sphere = "set type 5 diameter 0.3\nset type 5 density 3 omega 1 2 3"
    attributes = "quatk quatj quati quatw angmomx angmomy angmomz shapez shapey shapex mass" + " radius omegax omegay omegaz" * hybrid
    dumps = f"""compute p all property/atom {attributes}
dump p all custom 50 computed.txt id vx vy vz c_p[*]
dump_modify p {FULL}
dump q all custom 50 computed.bin id vx vy vz c_p[*]
dump r all custom 50 light.txt id type vx vy vz angmomx angmomy angmomz c_form[*] {"radius omegax omegay omegaz" * hybrid}
dump_modify r {FULL}
dump t all custom 50 shapes.txt id mass angmomx angmomy angmomz c_form[*]
dump_modify t {FULL}
dump s all custom 50 named.txt id mass angmomx angmomy angmomz c_form[*] {"radius omegax omegay omegaz" * hybrid}
run 500"""
    deck = asphere.DECK.format(style=style, shapes=shapes, pair=asphere.TOUCHING, spins="", columns="").replace("run 500", dumps)
    deck = deck.replace("set type 5 mass 2", sphere if hybrid else "set type 5 density 2")
    more = MORE if hybrid else "compute ke all ke\n"
    return deck.replace("thermo_style custom step c_rot", f"{more}thermo_style custom step c_rot c_ke" + " c_ball v_all" * hybrid)


@pytest.fixture(scope="module", params=MIXED)
def mixed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Three ellipsoids, a sphere as an ellipsoid, and the fifth particle."""
    return simulate(tmp_path_factory.mktemp("mixed"), mixed_deck(request.param))


@pytest.mark.parametrize("files", ["computed.txt", "computed.bin"])
def test_ellipsoids_by_the_computes_of_the_deck(mixed: Run, files: str) -> None:
    """Law: c_p[1], c_p[2] ... are what the deck's compute property/atom lists, shapex is a diameter, and erotate/asphere comes back; spheres of
    a hybrid style have the energy of spheres, points none."""
    found = erotate(mixed.folder / files, deck=mixed.deck)
    assert_printed(found, mixed.table, 11, superquadric="rot", ke="ke")
    if "all" in mixed.table[0]:
        assert_printed(found, mixed.table, 11, sphere="ball", erotate="all")
    else:
        assert_array_equal(found["erotate"], found["superquadric"])
    assert np.ptp(found["superquadric"]) > 1e-2 * found["superquadric"][0]  # they have hit each other
    assert found.notes == ()


@pytest.mark.parametrize("mixed", ["ellipsoid"], indirect=True)
def test_ellipsoids_with_densities_of_the_deck(mixed: Run) -> None:
    """Law: without a column mass an ellipsoid weighs rho times 4/3 pi times its semi-axes; what a point weighs no density tells, so that the
    translational energy is not known."""
    found = erotate(mixed.folder / "light.txt", deck=mixed.deck)
    assert_printed(found, mixed.table, 11, erotate="rot", superquadric="rot")
    assert np.isnan(found["ke"]).all()


def test_ellipsoids_that_nobody_explains(mixed: Run) -> None:
    """Law: without the deck the columns of a compute mean nothing: an error, not the energy of spheres, also where mass, radius and omega have
    their names, for spheres have no angmom."""
    with pytest.raises(InputError, match=r"computed\.txt: step 0: .*what c_p\[1\] .* hold, --deck or --columns can say"):
        erotate(mixed.folder / "computed.txt")
    with pytest.raises(InputError, match=r"named\.txt: step 0: .*expected shapex shapey shapez too; the dump has id mass angmomx"):
        erotate(mixed.folder / "named.txt")


@pytest.mark.parametrize("mixed", MIXED[1:], indirect=True)
def test_spheres_among_ellipsoids_need_their_columns(mixed: Run) -> None:
    """Law: in a hybrid style what has no shape is a sphere, whose energy needs radius and omega: without them an error, not zero."""
    with pytest.raises(InputError, match="needs the columns radius or diameter and omegax omegay omegaz"):
        erotate(mixed.folder / "shapes.txt", deck=mixed.deck)


@pytest.mark.parametrize("mixed", MIXED[1:], indirect=True)
def test_densities_of_a_hybrid_style(mixed: Run) -> None:
    """Law: in a hybrid of ellipsoids and spheres `set density` gives an ellipsoid the mass of the sphere with its radius (0.5 unless set): what it
    weighs does not follow from its shape, so that a dump without mass is an error."""
    with pytest.raises(InputError, match="mass"):
        erotate(mixed.folder / "light.txt", deck=mixed.deck)


CHAIN = """units lj
atom_style hybrid ellipsoid bond
boundary p p p
newton off
region box block -5 5 -5 5 -5 5
create_box 1 box
create_atoms 1 single 0 0 0
create_atoms 1 single 0.6 0 0
create_atoms 1 single 0 0.5 0.3
set group all shape 1 0.6 0.5 density 1.5
set group all density 1.5 mol 1
set atom 1 vx 0.3
set atom 2 vy 0.5
pair_style zero 1.2
pair_coeff * *
neigh_modify exclude molecule/intra all
fix r all rigid/small molecule
compute er all erotate/rigid r
compute p all property/atom shapex shapey shapez quatw quati quatj quatk
compute b all rigid/local r id mass vx vy vz angmomx angmomy angmomz quatw quati quatj quatk inertiax inertiay inertiaz
thermo_style custom step c_er
thermo_modify norm no format float %.17g
thermo 100
dump d all custom 100 out.txt id mol x y z vx vy vz angmomx angmomy angmomz mass c_p[*]
dump b all local 100 out.bodies c_b[*]
dump_modify b format float %.17g
run 200
"""


def test_members_with_shapes_of_their_own(tmp_path: Path) -> None:
    """Law: formula (5) is for spheres: rigid bodies of ellipsoids are refused as particles, and come back from compute rigid/local."""
    run = simulate(tmp_path, CHAIN)
    with pytest.raises(InputError, match=r"out\.txt: step 0: members of rigid bodies have shapes of their own: .*compute rigid/local"):
        erotate(tmp_path / "out.txt", deck=run.deck)
    assert_printed(erotate(tmp_path / "out.bodies", deck=run.deck), run.table, 3, erotate="er")


INFILE = "1\n1 1.0 0 0 0 0.2 0.3 0.35 0.01 0.02 -0.01 0 0 0 0.05 0.06 0.07 0 0 0\n"  # id mass xcm inertia vcm angmom image


def test_bodies_whose_inertia_a_file_gives(tmp_path: Path) -> None:
    """Law: fix rigid with infile takes mass and inertia from a file, which no dump of particles shows: an error, and compute rigid/local has them."""
    (tmp_path / "given").write_text(INFILE)
    deck = CHAIN.replace("ellipsoid", "sphere").replace("shape 1 0.6 0.5", "diameter 1").replace("molecule\n", "molecule infile given\n")
    run = simulate(tmp_path, deck.replace("angmomx angmomy angmomz mass c_p[*]", "omegax omegay omegaz radius mass").replace("compute p", "#"))
    assert_printed(erotate(tmp_path / "out.bodies", deck=run.deck), run.table, 3, erotate="er")
    with pytest.raises(InputError, match="mol may number rigid bodies or not"):
        erotate(tmp_path / "out.txt", deck=run.deck)

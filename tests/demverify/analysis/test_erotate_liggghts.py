"""`demverify.erotate` and `demverify erotate` on the files of Debian's LIGGGHTS, its deck as the dictionary, against the energies it prints."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from numpy.testing import assert_allclose, assert_array_equal

from demsolver.shapes.union import union
from demverify import erotate
from demverify.errors import InputError
from demverify.formats.template import read_template
from tests.demverify.analysis.printed import Run, assert_printed, command, printed
from tests.demverify.analysis.test_liggghts_clumps import SIGMAS, standard_errors
from tests.support.engines import run_liggghts

pytestmark = pytest.mark.liggghts
DATA = Path(__file__).parents[2] / "data" / "clumps"
DEFECT = "register: liggghts-multisphere-inertia"


BODIES = "c_bi[3] c_bi[2] c_bi[1] c_bq[1] c_bq[2] c_bq[3] c_bq[4] c_bm c_bl[2] c_bl[3] c_bl[1] c_bv[3] c_bv[1] c_bv[2] c_bid"
MEANT = [
    *("inertia[3]", "inertia[2]", "inertia[1]", "quat[1]", "quat[2]", "quat[3]", "quat[4]", "masstotal"),
    *("angmom[2]", "angmom[3]", "angmom[1]", "vcm[3]", "vcm[1]", "vcm[2]", "id_multisphere"),
]


def clumps(folder: Path, template: str, spheres: int) -> Run:
    """20 clumps and 20 spheres that fall on a plane. Besides what in.clumps dumps: bodies in another order of columns, a file a step, and
    particles without mass, in a binary file."""
    deck = (DATA / "in.clumps").read_text().replace("nspheres 4", f"nspheres {spheres}").replace("tetra.ms", template)
    more = f"""dump c all local 1000 post*.bodies {BODIES}
dump_modify c format "{" ".join(["%.17g"] * len(MEANT))}"
dump e all custom 1000 light.bin id type mol x y z vx vy vz omegax omegay omegaz radius
run 12000 upto"""
    (folder / template).write_text((DATA / template).read_text())
    return Run(folder, printed(run_liggghts(deck.replace("run 12000 upto", more), folder)))


@pytest.fixture(scope="module")
def crooked(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Clumps without mirror symmetry."""
    return clumps(tmp_path_factory.mktemp("crooked"), "tetra.ms", 4)


@pytest.fixture(scope="module")
def mirrored(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Clumps with the plane of symmetry z = 0."""
    return clumps(tmp_path_factory.mktemp("mirrored"), "mirror.ms", 5)


@pytest.mark.parametrize("bodies", ["bodies.local", "post*.bodies"], ids=["one file", "other order, a file a step"])
@pytest.mark.parametrize("which", ["crooked", "mirrored"])
def test_clumps_from_particles_and_bodies(which: str, bodies: str, request: pytest.FixtureRequest) -> None:
    """Law: what LIGGGHTS prints comes back at every dumped step, whatever the order of the columns; the defect of its inertia is named
    where the bodies show it, and nothing else is."""
    clump: Run = request.getfixturevalue(which)
    found = erotate(clump.folder / "clumps.dump", str(clump.folder / bodies), deck=clump.deck)
    assert_printed(found, clump.table, 12, erotate="er", multisphere="em", sphere="es", ke="ke")
    assert [DEFECT in note for note in found.notes] == ([True] if which == "crooked" else [])
    assert found.rows[-1].time == pytest.approx(0.12, rel=1e-15)  # 12000 steps of 1e-5
    assert {row.n for row in found.rows} == {100 if which == "crooked" else 120}


@pytest.mark.parametrize("said", ["deck", "columns"])
def test_bodies_alone(crooked: Run, said: str) -> None:
    """Law: a dump of bodies is enough for the clumps' energy; the deck says what its columns are, or --columns does. n counts bodies."""
    known: dict[str, Any] = {"deck": crooked.deck} if said == "deck" else {"columns": MEANT}
    found = erotate(str(crooked.folder / "post*.bodies"), **known)
    assert_printed(found, crooked.table, 12, multisphere="em", erotate="em", ke="km")
    assert {row.n for row in found.rows} == {20}
    assert any(DEFECT in note for note in found.notes) == (said == "deck")  # without a template nobody knows


def test_bodies_whose_columns_nobody_explains(crooked: Run) -> None:
    """Law: without deck and names the error says which columns are wanted and which are there."""
    with pytest.raises(InputError, match=r"post1000\.bodies: .*expected the columns inertia\[1\.\.3\], .* got c_bi\[3\] .*--deck or --columns"):
        erotate(str(crooked.folder / "post*.bodies"))


@pytest.mark.parametrize("said", ["deck", "template", "nothing"])
def test_particles_alone(mirrored: Run, said: str) -> None:
    """Law: members tell omega and v of their body, and the inertia is that of the union of their spheres: of the template from the deck or
    from an option, else of the spheres as they lie. LIGGGHTS' own inertia is off by its random points, five standard errors at most in each
    element, and its energy by twice that (diagonal, and what turned axes mix in). Free spheres come back to rounding."""
    template = read_template(mirrored.folder / "mirror.ms")
    known: dict[str, Any] = {"deck": {"deck": mirrored.deck}, "template": {"templates": [mirrored.folder / "mirror.ms"]}, "nothing": {}}[said]
    found = erotate(mirrored.folder / "clumps.dump", **known)
    error = 2 * SIGMAS * standard_errors(template, union(template.centre, template.radius).inertia).max()
    assert_printed(found, mirrored.table, 12, sphere="es")
    assert_printed(found, mirrored.table, 12, rtol=error, erotate="er", multisphere="em", ke="ke")
    assert_array_equal(found["time"], found["step"] * 1e-5 if said == "deck" else np.full(12, np.nan))


def test_template_and_members_say_the_same(crooked: Run) -> None:
    """Law: a body is its template turned and shifted, so a template changes nothing, also where LIGGGHTS' own inertia is wrong."""
    dump, template = crooked.folder / "clumps.dump", crooked.folder / "tetra.ms"
    with_template, without = erotate(dump, templates=[template]), erotate(dump)
    for name in ("multisphere", "ke"):
        assert_allclose(with_template[name], without[name], rtol=1e-12)  # positions of 17 digits, arms a tenth of them


def test_densities_and_columns_of_a_binary_file_from_the_deck(mirrored: Run) -> None:
    """Law: a binary dump of LIGGGHTS names no columns and this one has no mass: the deck says what they are, that spheres have the density
    of their template, and clumps that of theirs times the volume of the union. LIGGGHTS' own mass is off by its random points."""
    template = read_template(mirrored.folder / "mirror.ms")
    found = erotate(mirrored.folder / "light.bin", deck=mirrored.deck)
    error = 2 * SIGMAS * standard_errors(template, union(template.centre, template.radius).inertia).max()
    assert_printed(found, mirrored.table, 12, sphere="es")
    assert_printed(found, mirrored.table, 12, rtol=2 * error, erotate="er", ke="ke")  # and as much again for the mass


def test_the_command_line_on_clumps(crooked: Run) -> None:
    """Law: the command finds what the library finds, and says the note on stderr."""
    rows, said = command(crooked.folder, "clumps.dump", "--bodies", "post*.bodies", "--deck", "in.deck")
    assert DEFECT in said
    assert rows == [row.as_dict() for row in erotate(crooked.folder / "clumps.dump", str(crooked.folder / "post*.bodies"), deck=crooked.deck).rows]


def test_the_defect_of_a_clump_that_is_symmetric_in_another_plane(tmp_path: Path) -> None:
    """Law: LIGGGHTS averages I_yz with I_xz, along the axes of the template's file: a plane of symmetry z = 0 spares a clump, x = 0 does not."""
    rows = "0 0 0 0.012\n0 0.012 0.008 0.010\n0 -0.010 0.006 0.009\n0.009 0 -0.004 0.008\n-0.009 0 -0.004 0.008\n"
    (tmp_path / "tetra.ms").write_text(rows)
    deck = (DATA / "in.clumps").read_text().replace("nspheres 4", "nspheres 5").replace("run 12000", "run 1000")
    run = run_liggghts(deck, tmp_path)
    found = erotate(tmp_path / "clumps.dump", tmp_path / "bodies.local", deck=tmp_path / "in.deck")
    assert_printed(found, printed(run), 1, erotate="er", multisphere="em", sphere="es", ke="ke")
    assert [DEFECT in note for note in found.notes] == [True]


def test_members_that_another_fix_moves(tmp_path: Path) -> None:
    """Law: with fix nve/sphere for all, members in contact do not move as their body does: from particles alone such a frame is refused with
    the reason, and the dump of bodies still gives what LIGGGHTS prints."""
    deck = (DATA / "in.clumps").read_text().replace("fix integs loose", "fix integs all")
    (tmp_path / "tetra.ms").write_text((DATA / "tetra.ms").read_text())
    run = run_liggghts(deck, tmp_path)
    found = erotate(tmp_path / "clumps.dump", tmp_path / "bodies.local", deck=tmp_path / "in.deck")
    assert_printed(found, printed(run), 12, erotate="er", multisphere="em", sphere="es", ke="ke")
    with pytest.raises(InputError, match=r"clumps\.dump: step \d+: the spheres of body \d+ .*fix nve/sphere for all"):
        erotate(tmp_path / "clumps.dump", deck=tmp_path / "in.deck")


MATERIAL = """fix m1 all property/global kn peratomtypepair 3 {kn}
fix m2 all property/global kt peratomtypepair 3 {kn}
fix m3 all property/global gamman peratomtypepair 3 {gamma}
fix m4 all property/global gammat peratomtypepair 3 {gamma}
fix m5 all property/global coefficientFriction peratomtypepair 3 {mu}
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
""".format(kn=" ".join(["1e3"] * 9), gamma=" ".join(["5"] * 9), mu=" ".join(["0.5"] * 9))
TAIL = """fix move all nve/sphere
compute e all erotate
compute h all erotate/sphere halfstep
compute k all ke
compute kh all ke halfstep
thermo_style custom step c_e c_h c_k c_kh
thermo_modify lost ignore norm no format float %.17g
thermo 100
{first}
dump full all custom 100 full.dump id type radius mass vx vy vz omegax omegay omegaz fx fy fz tqx tqy tqz
dump_modify full sort id format "%d %d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
dump light all custom 200 post/spheres*.chute id type radius vx vy vz omegax omegay omegaz
dump_modify light format "%d %d %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
dump dense all custom 200 dense.stream id density radius vx vy vz omegax omegay omegaz
dump_modify dense format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
dump packed all custom 200 packed.bin type omegax omegay omegaz radius vz vy vx id
run 1000 upto
"""
SPHERES = f"""atom_style sphere
atom_modify map array sort 0 0
boundary f f f
newton off
communicate single vel yes
units si
region box block -0.05 0.05 -0.05 0.05 0 0.12 units box
create_box 3 box
neighbor 0.002 bin
neigh_modify delay 0
{MATERIAL}timestep 2e-5
fix g all gravity 9.81 vector 0 0 -1
fix floor all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0
fix t1 all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.004
fix t2 all particletemplate/sphere 15485867 atom_type 2 density constant 1234.5 radius constant 0.003
fix t3 all particletemplate/sphere 49979687 atom_type 2 density constant 1234.5 radius constant 0.005
fix d all particledistribution/discrete 32452867 3 t1 0.4 t2 0.3 t3 0.3
region bed block -0.05 0.05 -0.05 0.05 0.01 0.11 units box
fix ins all insert/pack seed 32452843 distributiontemplate d vel constant 0.2 0 -1 omega constant 20 10 -30 &
    insert_every once overlapcheck yes region bed particles_in_region 300
create_atoms 3 single 0 0 0.006
set type 3 diameter 0.009
set type 3 density 7850
{TAIL.format(first="run 1")}"""
DISCS = f"""units si
dimension 2
atom_style sphere
atom_modify map array sort 0 0
boundary p f p
newton off
communicate single vel yes
region box block 0 0.3 0 0.3 -0.02 0.02 units box
create_box 3 box
lattice sq 0.02
region low block 0 0.3 0.005 0.14 -0.001 0.001 units box
region high block 0 0.3 0.15 0.28 -0.001 0.001 units box
create_atoms 1 region low
create_atoms 2 region high
set type 1 diameter 0.0205
set type 2 diameter 0.014
set type 1 density 2500
set type 2 density 900
set type 1 vx 0.4 omegaz 12.5
set type 2 vx -0.4 vy -0.3 omegaz -3
{MATERIAL}neighbor 0.002 bin
neigh_modify delay 0
timestep 2e-5
fix g all gravity 9.81 vector 0 -1 0
fix floor all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0
{TAIL.format(first="fix flat all enforce2d" + chr(10) + "run 1")}"""


def spheres(folder: Path, deck: str) -> Run:
    """Some hundred spheres that collide and spin."""
    (folder / "post").mkdir()
    run = run_liggghts(deck, folder)
    assert np.ptp(np.abs(run.frames[-1].columns["omegaz"])) > 1  # contacts have changed the spins
    return Run(folder, printed(run))


@pytest.fixture(scope="module", params=[SPHERES, DISCS], ids=["spheres", "discs"])
def loose(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Spheres in space, of three densities and four sizes, some of which leave the box; discs in the plane."""
    return spheres(tmp_path_factory.mktemp("loose"), request.param)


def test_mass_from_the_dump(loose: Run) -> None:
    """Law: 1/5 m R^2 omega^2 over all spheres, and over discs too: LIGGGHTS' computes know no discs."""
    found = erotate(loose.folder / "full.dump")
    assert_printed(found, loose.table, 10, erotate="e", sphere="e", ke="k")


@pytest.mark.parametrize("files", ["post/spheres*.chute", "dense.stream", "packed.bin"])
def test_mass_from_densities(loose: Run, files: str) -> None:
    """Law: in space a sphere weighs 4/3 pi R^3 rho, in the plane LIGGGHTS has a disc, pi R^2 rho; rho is a column, or the deck tells it by
    type, as it tells the columns of a binary file. One file a step, whatever it is called, or all in one."""
    found = erotate(str(loose.folder / files), deck=loose.deck)
    assert [row.step for row in found.rows] == [200, 400, 600, 800, 1000]
    assert_printed(found, loose.table, 5, erotate="e", sphere="e", ke="k")
    assert found.notes == ()


def test_half_a_step_later(loose: Run) -> None:
    """Law: LIGGGHTS' keyword takes omega + dt/2 torque / (2/5 m R^2) and v + dt/2 f / m; the deck or an option says dt."""
    for known in ({"deck": loose.deck}, {"timestep": 2e-5}):
        found = erotate(loose.folder / "full.dump", halfstep=True, **known)  # type: ignore[arg-type]
        assert_printed(found, loose.table, 10, erotate="h", ke="kh")
    plain = erotate(loose.folder / "full.dump")
    assert np.abs(found["erotate"] / plain["erotate"] - 1).max() > 1e-6  # that this is another number


def test_packed_files(loose: Run) -> None:
    """Law: gzip and zstd hold the same frames."""
    whole = (loose.folder / "full.dump").read_bytes()
    packers: dict[str, Callable[[bytes], bytes]] = {"full.gz": gzip.compress, "full.zst": zstandard.ZstdCompressor().compress}
    plain = erotate(loose.folder / "full.dump")
    for name, pack in packers.items():
        (loose.folder / name).write_bytes(pack(whole))
        assert erotate(loose.folder / name).rows == plain.rows


def test_the_command_line_on_spheres(loose: Run) -> None:
    """Law: a quoted pattern, the half step and names of columns do on the command line what they do in the library."""
    rows, said = command(loose.folder, "post/*.chute", "--deck", "in.deck")
    assert said == ""
    assert rows == [row.as_dict() for row in erotate(str(loose.folder / "post" / "*.chute"), deck=loose.deck).rows]
    names = "type omegax omegay omegaz radius vz vy vx id"
    assert rows == command(loose.folder, "packed.bin", "--columns", names, "--deck", "in.deck")[0]
    late, _ = command(loose.folder, "full.dump", "--halfstep", "--timestep", "2e-5")
    assert late == [row.as_dict() for row in erotate(loose.folder / "full.dump", halfstep=True, timestep=2e-5).rows]


def test_what_is_missing_is_named(loose: Run) -> None:
    """Law: without mass, density or deck, and without the step for half of it, the error says what would help."""
    with pytest.raises(InputError, match=r"\.chute: step \d+: erotate/sphere needs the columns mass or density \(or --density X, --deck DECK\)"):
        erotate(str(loose.folder / "post" / "*.chute"))
    with pytest.raises(InputError, match="needs the time step: give --deck DECK or --timestep DT"):
        erotate(loose.folder / "full.dump", halfstep=True)

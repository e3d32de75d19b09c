"""A deck said in the other engine's words is the same scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demsolver import Scene, Simulation
from demverify.deck.convert import convert
from demverify.errors import InputError
from demverify.runs import plan

INPUTS = Path(__file__).parents[2] / "inputs"
CASES = ("bed", "chute", "head-on-hertz", "slip-to-roll", "wall-normal", "wall-oblique")  # both decks written by hand, without variables
LAMMPS = """units lj
atom_style sphere
boundary p p f
region box block 0 10 0 10 0 10
create_box 2 box
create_atoms 1 single 3 5 5
create_atoms 2 single 4 5 5
set type 1*2 diameter 1.1
{pair}
{fix}
timestep 1e-4
run 10
"""


def scene(deck: Path) -> Scene:
    """The scene of a deck's first run."""
    return plan(deck, {}).runs[0].scene


def same_particles(a: Scene, b: Scene) -> None:
    """Positions, velocities, spins, sizes to the last bit; masses to one unit in the last place (they go over as densities)."""
    for name in ("id", "type", "x", "v", "omega", "radius"):
        assert np.array_equal(getattr(a.particles, name), getattr(b.particles, name)), name
    assert np.abs(a.particles.mass - b.particles.mass).max() <= np.spacing(a.particles.mass.max())


@pytest.mark.parametrize("name", CASES)
def test_a_lammps_deck_becomes_the_liggghts_deck_of_the_case(name: str, tmp_path: Path) -> None:
    """Law: converting in.lammps gives the scene that was written by hand in in.liggghts: particles, walls, fields, step, coefficients."""
    convert(plan(INPUTS / name / "in.lammps", {}), "liggghts", tmp_path / "in.liggghts")
    ours, theirs = scene(tmp_path / "in.liggghts"), scene(INPUTS / name / "in.liggghts")
    same_particles(ours, theirs)
    assert len(ours.walls) == len(theirs.walls)
    assert [type(f) for f in ours.forces] == [type(f) for f in theirs.forces]
    assert ours.timestep == theirs.timestep
    assert ours.neighbor == theirs.neighbor
    assert ours.pair is not None
    assert theirs.pair is not None
    idle = {"shear_stiffness"} if ours.pair.friction == "no_history" else set()  # no spring, whatever its stiffness
    for coefficient in (set(ours.pair.coefficients) & set(theirs.pair.coefficients)) - idle:
        a, b = ours.pair.coefficients[coefficient], theirs.pair.coefficients[coefficient]
        assert a[: len(b), : len(b)] == pytest.approx(b, rel=1e-15), coefficient


@pytest.mark.parametrize("name", CASES)
def test_a_liggghts_deck_in_lammps_words(name: str, tmp_path: Path) -> None:
    """Law: converting in.liggghts gives a LAMMPS deck that reads, with the same particles and as many walls and fields."""
    source = INPUTS / name / "in.liggghts"
    convert(plan(source, {}), "lammps", tmp_path / "in.lammps")
    ours, theirs = scene(tmp_path / "in.lammps"), scene(source)
    same_particles(ours, theirs)
    assert len(ours.walls) == len(theirs.walls)
    assert [type(f) for f in ours.forces] == [type(f) for f in theirs.forces]
    assert ours.neighbor == theirs.neighbor


def test_a_wall_with_a_law_of_its_own_becomes_a_type(tmp_path: Path) -> None:
    """Law: in LIGGGHTS a wall's law is that of a pair of types; a wall that differs from all gets one more type."""
    deck = tmp_path / "in.lammps"
    deck.write_text(
        LAMMPS.format(
            pair="pair_style gran/hooke/history 2e5 NULL 50 NULL 0.5 1\npair_coeff * *",
            fix="fix w all wall/gran granular hooke 1e5 30 tangential linear_history 3e4 0.5 0.2 damping mass_velocity zplane 0 NULL\n"
            "fix n all nve/sphere",
        )
    )
    found = convert(plan(deck, {}), "liggghts", tmp_path / "in.liggghts")
    assert found.ntypes == 3
    law = scene(tmp_path / "in.liggghts").walls[0].law.coefficients
    assert law["kn"][:2] == pytest.approx([1e5, 1e5])
    assert law["mu"][:2] == pytest.approx([0.2, 0.2])
    assert scene(tmp_path / "in.liggghts").pair.coefficients["kn"][:2, :2] == pytest.approx(np.full((2, 2), 2e5))  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("pair", "fragment"),
    [
        ("hertz/material 1e6 0.5 0.3 tangential mindlin NULL 1 0.3 damping coeff_restitution", "xt = 1: LIGGGHTS' model hertz has 0.907"),
        ("hertz/material 1e6 9.0 0.3 tangential mindlin NULL 1 0.3 damping velocity", "no law like normal hertz with damping velocity"),
        ("hertz 1e6 0.5 tangential mindlin 1e8 0 0.3 damping coeff_restitution", "no Young's moduli"),
        ("jkr 1e6 0.5 0.3 0.1 tangential mindlin NULL 1 0.3", "no law like normal jkr with damping viscoelastic"),
        ("dmt 1e6 0.5 0.3 0.1 tangential mindlin NULL 1 0.3 damping velocity", "no law like normal dmt with damping velocity"),
        ("hertz 1e6 0.5 tangential mindlin_rescale/force 1e8 0 0.3", "no law like friction mindlin_rescale_force"),
    ],
)
def test_what_cannot_be_said_is_an_error(pair: str, fragment: str, tmp_path: Path) -> None:
    """Law: a law the other engine does not have is refused in one line, and nothing is written."""
    deck = tmp_path / "in.lammps"
    deck.write_text(LAMMPS.format(pair=f"pair_style granular\npair_coeff * * {pair}", fix="fix n all nve/sphere"))
    with pytest.raises(InputError, match=fragment):
        convert(plan(deck, {}), "liggghts", tmp_path / "in.liggghts")
    assert [path.name for path in tmp_path.iterdir()] == ["in.lammps"]


def test_a_deck_of_that_dialect_already(tmp_path: Path) -> None:
    """Law: converting to its own dialect is an error, not a copy."""
    with pytest.raises(InputError, match="this is a lammps deck already"):
        convert(plan(INPUTS / "bed" / "in.lammps", {}), "lammps", tmp_path / "x")


LIGGGHTS = """units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region box block -0.1 0.1 -0.1 0.1 -0.1 0.1
create_box 1 box
create_atoms 1 single 0 0 0.0049
create_atoms 1 single 0.0098 0 0.0051
set type 1 diameter 0.01 density 2500
{size}
set atom 1 vx 0.3
set atom 2 vz -0.2
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.7
fix m4 all property/global coefficientFriction peratomtypepair 1 0.0
fix m5 all property/global characteristicVelocity scalar 0.5
{properties}
pair_style gran model {model}
pair_coeff * *
fix floor all wall/gran model {normal} primitive type 1 zplane 0 {switches}
fix n all nve/sphere
timestep 1e-6
run 1
"""
SPRINGS = "\n".join(
    f"fix s{k} all property/global {name} peratomtypepair 1 {value}"
    for k, (name, value) in enumerate({"kn": 1e4, "kt": 3e3, "gamman": 40.0, "gammat": 20.0, "gamman_abs": 0.3, "gammat_abs": 0.1}.items())
)


@pytest.mark.parametrize("model", ["hooke", "hertz", "hooke/stiffness absolute_damping on", "hertz/stiffness limitForce on"])
def test_every_liggghts_model_acts_alike_in_lammps_words(model: str, tmp_path: Path) -> None:
    """Law: without friction, where the rules are the same, both decks give the same forces of a pair and of the floor."""
    normal, _, switches = model.partition(" ")
    text = LIGGGHTS.format(model=model, normal=normal, switches=switches, size="", properties=SPRINGS)
    (tmp_path / "in.liggghts").write_text(text)
    convert(plan(tmp_path / "in.liggghts", {}), "lammps", tmp_path / "in.lammps")
    theirs, ours = (Simulation(scene(tmp_path / f"in.{dialect}")) for dialect in ("liggghts", "lammps"))
    theirs.setup()
    ours.setup()
    assert np.abs(theirs.bodies.force).max() > 1e-3
    assert np.abs(theirs.bodies.force - ours.bodies.force).max() < 1e-12 * np.abs(theirs.bodies.force).max()


def test_a_stiffness_for_each_size_cannot_be_said(tmp_path: Path) -> None:
    """Law: LIGGGHTS' hooke has a spring of its own for each pair of sizes; with two sizes there is no LAMMPS law for it."""
    text = LIGGGHTS.format(model="hooke", normal="hooke", switches="", size="set atom 2 diameter 0.008", properties="")
    (tmp_path / "in.liggghts").write_text(text)
    with pytest.raises(InputError, match="another stiffness for each pair of sizes"):
        convert(plan(tmp_path / "in.liggghts", {}), "lammps", tmp_path / "in.lammps")


@pytest.mark.parametrize(
    ("pair", "wall", "named"),
    [
        ("hertz rolling_friction cdt", "hertz", "rolling cdt"),
        ("hertz/stiffness tangential history rolling_friction epsd", "hertz/stiffness", "rolling epsd"),
        ("hooke cohesion sjkr rolling_friction epsd2", "hooke", "cohesion sjkr and rolling epsd2"),
        ("hertz", "hertz cohesion sjkr", "cohesion sjkr"),
    ],
)
def test_what_only_liggghts_has_is_named(pair: str, wall: str, named: str, tmp_path: Path) -> None:
    """Law: rolling friction and cohesion that LAMMPS has not are refused by name, of pairs and of walls, and nothing is written."""
    numbers = {"coefficientRollingFriction": 0.1, "coefficientRollingViscousDamping": 0.1, "cohesionEnergyDensity": 1e5}
    more = "\n".join(f"fix r{k} all property/global {name} peratomtypepair 1 {value}" for k, (name, value) in enumerate(numbers.items()))
    text = LIGGGHTS.format(model=pair, normal=wall, switches="", size="", properties=f"{SPRINGS}\n{more}")
    (tmp_path / "in.liggghts").write_text(text)
    with pytest.raises(InputError, match=f"LAMMPS has no law like {named}; write the LAMMPS deck by hand"):
        convert(plan(tmp_path / "in.liggghts", {}), "lammps", tmp_path / "in.lammps")
    assert [path.name for path in tmp_path.iterdir()] == ["in.liggghts"]


@pytest.mark.parametrize(("turning", "named"), [("rolling sds 1e3 0.1 0.1", "rolling sds"), ("twisting marshall", "twisting marshall")])
def test_what_only_lammps_has_is_named(turning: str, named: str, tmp_path: Path) -> None:
    """Law: so are rolling and twisting of LAMMPS, which LIGGGHTS has not."""
    deck = tmp_path / "in.lammps"
    pair = f"pair_style granular\npair_coeff * * hooke 1e5 50 tangential linear_history 1e4 0.5 0.2 damping mass_velocity {turning}"
    deck.write_text(LAMMPS.format(pair=pair, fix="fix n all nve/sphere"))
    with pytest.raises(InputError, match=f"LIGGGHTS has no law like {named}; write the LIGGGHTS deck by hand"):
        convert(plan(deck, {}), "liggghts", tmp_path / "in.liggghts")

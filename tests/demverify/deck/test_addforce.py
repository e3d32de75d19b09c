"""fix addforce: what the deck may say, what it becomes, and that the engines do the same."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demsolver.expression import Call, Column, Number, value
from demsolver.scene import AddForce, Scene
from demverify.cases import Case
from demverify.compare import TIER1, TIER2
from demverify.deck.convert import convert
from demverify.deck.dry import DryBackend
from demverify.deck.interpreter import Interpreter
from demverify.deck.scene_builder import scene_of
from demverify.errors import InputError
from demverify.runs import plan
from demverify.verify import Settings, compare_case
from tests.support.engines import require_lammps, require_liggghts

Run = Callable[..., Interpreter]
BOX = "units si\nboundary f f f\nregion b block 0 1 0 1 0 1 units box\ncreate_box 2 b\n"
GRAINS = BOX + "create_atoms 1 single 0.25 0.5 0.5 units box\ncreate_atoms 2 single 0.75 0.5 0.5 units box\ngroup two type 2\n"


def force(deck: Interpreter) -> AddForce:
    """The one force of the scene."""
    (found,) = scene_of(deck.setup).forces
    assert isinstance(found, AddForce)
    return found


def test_numbers_equal_style_and_atom_style(run_deck: Run) -> None:
    """Law: numbers stay, equal-style variables are computed with all digits, atom-style ones stay formulas in which what is constant is folded."""
    deck = run_deck(GRAINS + 'fix a two addforce 1.5 v_e v_f\nvariable e equal 1/3\nvariable f atom "-2*PI*vx+v_e*3"\n')
    x, y, z = force(deck).force
    assert (x, y) == (Number(1.5), Number(1 / 3))
    assert z == Call("+", (Call("*", (Number(-6.283185307179586), Column("vx"))), Number(0.333333333333333 * 3)))
    assert force(deck).bit == 1


def test_minus_binds_tighter_than_the_power(run_deck: Run) -> None:
    """Law: -vx^2 = (-vx)^2 and vx^2^3 = (vx^2)^3, as LAMMPS and LIGGGHTS have it (measured)."""
    deck = run_deck(GRAINS + 'variable f atom "-vx^2"\nvariable h atom "vx^2^3"\nfix a all addforce v_f v_h 0\n')
    first, second, _ = force(deck).force
    assert value(first, {"vx": 3.0}) == 9.0
    assert value(second, {"vx": 2.0}) == 64.0


@pytest.mark.parametrize(("dialect", "word", "other"), [("lammps", "radius", "r"), ("liggghts", "r", "radius")])
def test_each_dialect_has_its_word_for_the_radius(dialect: str, word: str, other: str, run_deck: Run) -> None:
    """Law: LAMMPS says radius, LIGGGHTS r; the other's word is refused by both engines (measured), and here."""
    assert force(run_deck(GRAINS + f'variable f atom "{word}"\nfix a all addforce v_f 0 0\n', dialect)).force[0] == Column("radius")
    with pytest.raises(InputError, match=f"{other} is not one of x, y, z, vx, vy, vz, mass, type, {word}, dt"):
        force(run_deck(GRAINS + f'variable f atom "{other}"\nfix a all addforce v_f 0 0\n', dialect))


REFUSED = [
    ('variable f atom "density*vx"\nfix a all addforce v_f 0 0', "density is not one of x, y, z"),
    ('variable f atom "step*vx"\nfix a all addforce v_f 0 0', "step is not one of x, y, z"),
    ('variable e equal step\nvariable f atom "v_e*vx"\nfix a all addforce v_f 0 0', "step is not one of x, y, z"),
    ("variable e equal time\nfix a all addforce v_e 0 0", "time is not one of x, y, z"),
    ('variable f atom "x[1]"\nfix a all addforce v_f 0 0', r"a value of one particle, as x\[3\]"),
    ('variable f atom "vx/0"\nfix a all addforce v_f 0 0', None),
    ('variable f atom "vx*(1/0)"\nfix a all addforce v_f 0 0', "division by zero"),
    ('variable f atom "sqrt(-1)*vx"\nfix a all addforce v_f 0 0', r"sqrt\(-1\) has no finite value"),
    ('variable f atom "ramp(0,1)*vx"\nfix a all addforce v_f 0 0', r"ramp\(\) depends on the steps of a run"),
    ('variable f atom "v_f+1"\nfix a all addforce v_f 0 0', "variable f is defined by itself: f -> f"),
    ('variable f atom "v_g+1"\nfix a all addforce v_f 0 0', "variable 'g' is not defined"),
    ("variable s string 1.0\nfix a all addforce v_s 0 0", "fix a addforce: variable s is of style string; expected equal or atom"),
    ("fix a all addforce v_none 0 0", "fix a addforce: variable 'none' is not defined"),
    ("fix a all addforce NULL 0 0", "fx must be a number, got 'NULL'"),
    ("fix a all addforce 1 2", "ends where fz was expected"),
    ("fix a all addforce 1 2 nan", "fz must be a number, got 'nan'"),
    ("fix a all addforce 1 2 3 every 2", "keyword 'every' .* is not supported"),
    ("fix a all addforce 1 2 3 region b", "keyword 'region' .* is not supported"),
    ("fix a all addforce 1 2 3 energy v_f", "keyword 'energy' .* is not supported"),
    ('variable f atom "vx"\nvariable g equal v_f\nprint "${g}"', "variable f is of style atom: it has a value for each particle"),
    ('variable f atom "vx"\nprint "${f}"', "variable f is of style atom"),
    ('variable f atom "vx"\nvariable f equal 2', "variable f is of style atom and cannot become equal"),
]


@pytest.mark.parametrize(("lines", "message"), REFUSED, ids=[lines.splitlines()[-1] + f" {k}" for k, (lines, _) in enumerate(REFUSED)])
def test_what_is_refused(lines: str, message: str | None, run_deck: Run) -> None:
    """Law: a word, a style or a constant that cannot be is refused in one line that names the place; a division by zero that is not constant is not,
    for it shows only as it runs."""
    if message is None:
        assert isinstance(force(run_deck(f"{GRAINS}{lines}\n")), AddForce)
        return
    with pytest.raises(InputError, match=message) as error:
        force(run_deck(f"{GRAINS}{lines}\n"))
    assert error.value.place
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("formula", ["ternary(vx>0,1,2)", "sign(vx)", "!vx", "vx |^ vy"])
def test_what_liggghts_does_not_know(formula: str, run_deck: Run) -> None:
    """Law: LIGGGHTS' formulas have no ternary, sign, ! and |^ (measured); LAMMPS' have."""
    deck = f'{GRAINS}variable f atom "{formula}"\nfix a all addforce v_f 0 0\n'
    assert isinstance(force(run_deck(deck)), AddForce)
    with pytest.raises(InputError, match="LIGGGHTS' formulas do not know"):
        force(run_deck(deck, "liggghts"))


def test_a_variable_counts_as_it_is_at_the_run() -> None:
    """Law: each run has the variable as the deck had it then."""
    backend = DryBackend()
    deck = Interpreter("lammps", None, backend)
    grain = "set type 1 diameter 0.01 density 2500\nset type 2 diameter 0.01 density 2500\n"
    deck.run_text(GRAINS + grain + "variable e equal 1\nfix a all addforce v_e 0 0\nrun 1\nvariable e equal 2\nrun 1\n")
    assert [run.scene.forces[0].force[0] for run in backend.runs] == [Number(1.0), Number(2.0)]  # type: ignore[union-attr]


numbers = st.floats(min_value=0.01, max_value=50.0).map(lambda x: f"{x:.6g}")
leaves = st.one_of(numbers, st.sampled_from(["vx", "y", "mass"]))
formulas = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/^%<>"), inner).map("".join),
        inner.map("({})".format),
        inner.map("-{}".format),
        st.tuples(st.sampled_from(["sqrt", "exp", "ln", "abs", "sin", "floor"]), inner).map(lambda pair: f"{pair[0]}({pair[1]})"),
    ),
    max_leaves=6,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(formula=formulas, vx=st.floats(0.1, 3.0), y=st.floats(0.1, 3.0), mass=st.floats(0.1, 3.0))
def test_a_formula_of_numbers_is_the_same_formula(formula: str, vx: float, y: float, mass: float, run_deck: Run) -> None:
    """Law: a formula of a particle's columns gives what the equal-style formula of their numbers gives; where that is refused it has no value."""
    known = {"vx": vx, "y": y, "mass": mass}
    written = formula
    for name, number in known.items():
        written = written.replace(name, f"({number!r})")
    deck = run_deck(BOX)
    place = deck._place
    try:
        expected = deck.variables.evaluate(written, place)
    except InputError:
        expected = None
    deck.variables.define("f", "atom", [formula], place)
    try:
        found = value(deck.variables.expression("f", deck.setup, place), known)
    except InputError:
        found = float("nan")
    assert found == pytest.approx(expected if expected is not None else float("nan"), rel=1e-14, nan_ok=True)


BODY = """units si
{style}
boundary f f f
newton off
{communicate} vel yes
region box block -1 1 -1 1 -1 1
create_box 2 box
create_atoms 1 single 0.0 0.0 0.0
create_atoms 2 single 0.0115 0.001 0.0
create_atoms 1 single -0.3 0.2 0.1
create_atoms 2 single 0.4 -0.2 0.3
set type 1 diameter 0.012 density 2500.0
set type 2 diameter 0.010 density 1200.0
set atom 1 vx 0.3 vy -0.2 vz 0.1
set atom 2 vx -0.4 vy 0.1 vz 0.2
set atom 3 vx 1.5 vy -0.7 vz 0.4
set atom 4 vx -0.2 vy 2.5 vz -1.4
group some id 2 4
{pair}
neighbor 0.01 bin
neigh_modify delay 0
timestep 1.0e-4
variable third equal 1/3
variable push equal 0.02/3
variable slip atom "sqrt((0.3-vx)^2+vy^2+vz^2)"
variable fx atom "0.004*(0.3-vx)*(1.0+v_third*v_slip^0.687)*{radius}/0.006"
variable fy atom "-vy*abs(vy)*0.002+sin(40.0*x)*mass*exp(-y)/(1.0+vz^2)"
variable fz atom "0.001*(vz<0.0)-atan2(z,0.3+vx^2)*mass*type+vx%0.3*1.0e-3"
fix grav all gravity 9.81 vector 0.0 0.0 -1.0
fix wind all addforce v_fx v_fy v_fz
fix more some addforce v_push 0.0 -0.01
fix move all nve/sphere
compute kin all ke
compute rot all erotate/sphere
thermo_style custom step atoms c_kin c_rot
thermo_modify norm no
thermo 50
run 200
"""
MATERIAL = {"kn": 1000.0, "kt": 2000 / 7, "gamman": 50.0, "gammat": 25.0, "coefficientFriction": 0.5}
PAIR = {
    "lammps": "pair_style gran/hooke/history 1000.0 NULL 50.0 NULL 0.5 1\npair_coeff * *",
    "liggghts": "\n".join(
        [
            *(
                f"fix m{k} all property/global {name} peratomtypepair 2 {' '.join([f'{number}'] * 4)}"
                for k, (name, number) in enumerate(MATERIAL.items())
            ),
            "pair_style gran model hooke/stiffness tangential history\npair_coeff * *",
        ]
    ),
}


def write_decks(folder: Path) -> dict[str, Path]:
    """The scene in both dialects: four spheres, two of which touch, in a wind."""
    words = {
        "lammps": {"style": "atom_style sphere", "communicate": "comm_modify", "radius": "radius"},
        "liggghts": {"style": "atom_style granular\natom_modify map array", "communicate": "communicate single", "radius": "r"},
    }
    decks = {}
    for dialect, own in words.items():
        decks[dialect] = folder / f"in.{dialect}"
        decks[dialect].write_text(BODY.format(**own, pair=PAIR[dialect]))
    return decks


@pytest.mark.lammps
@pytest.mark.liggghts
def test_the_engines_do_the_same(tmp_path: Path) -> None:
    """Law: native equals each engine in its dialect, to rounding: one state and 200 steps of four spheres under formulas of every column."""
    require_lammps()
    require_liggghts()
    case = Case("wind", write_decks(tmp_path), every=10, accept=("liggghts-contact-arm", "liggghts-pair-history-kept"))  # type: ignore[arg-type]
    found = compare_case(case, tmp_path / "out", Settings(), lambda _: None)
    twins = {("native", "lammps"), ("native-liggghts", "liggghts")}
    own = [check for check in found.checks if check.engines in twins and check.tier < 3]
    assert {check.engines for check in own} == twins
    assert all(check.outcome == "pass" and check.max_rel <= (TIER1 if check.tier == 1 else TIER2) for check in own), own


def test_a_converted_deck_says_the_same(tmp_path: Path) -> None:
    """Law: a deck converted to the other dialect has the same forces: the radius in the other's word, all else as it was."""
    decks = write_decks(tmp_path)
    scenes: dict[str, Scene] = {name: plan(deck, {}).runs[0].scene for name, deck in decks.items()}
    assert scenes["lammps"].forces == scenes["liggghts"].forces
    for source, target in (("lammps", "liggghts"), ("liggghts", "lammps")):
        output = tmp_path / f"in.converted-{target}"
        convert(plan(decks[source], {}), target, output)  # type: ignore[arg-type]
        assert plan(output, {}).runs[0].scene.forces == scenes[source].forces

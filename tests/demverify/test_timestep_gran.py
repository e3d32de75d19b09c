"""LIGGGHTS' fix check/timestep/gran: its numbers to the printed digits, when it computes them, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np
import pytest

from demverify.deck.convert import convert
from demverify.deck.interpreter import Interpreter
from demverify.deck.scene_builder import scene_of
from demverify.deck.timestep_gran import Material, check_of, liggghts_material, times_of
from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.errors import InputError
from demverify.formats.log import read_thermo
from demverify.runs import plan
from tests.support.engines import run_liggghts
from tests.support.scenes import spheres

HEAD = """units {units}
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region box block -0.1 0.1 -0.1 0.1 -0.1 0.1
create_box 2 box
create_atoms 1 single -0.0051 0.0 0.0
create_atoms 1 single 0.0051 0.0 0.0
create_atoms 2 single 0.0051 0.04 0.0
set type 1 diameter 0.01 density 2500.0
set type 2 diameter 0.02 density 1500.0
set atom 2 diameter 0.007
set atom 1 vx {speed}
set atom 3 vz 0.1
group two type 2
soft_particles yes
hard_particles yes
fix m1 all property/global youngsModulus peratomtype 5e6 6e7
fix m2 all property/global poissonsRatio peratomtype 0.3 0.22
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.6 0.5 0.5 0.8
fix m4 all property/global coefficientFriction peratomtypepair 2 0.6 0.5 0.5 0.8
pair_style gran model hertz tangential history
pair_coeff * *
neighbor 0.002 bin
neigh_modify delay 0
timestep 2.0e-5
fix move all nve/sphere
"""
COLUMNS = "thermo_style custom step atoms ke " + " ".join(f"f_{name}[{k}]" for name in ("ts", "tt") for k in (1, 2, 3))
BODIES = {
    "kept between its steps and from run to run": """fix ts all check/timestep/gran 10 0.01 0.01
fix tt two check/timestep/gran check_every_time 5 0.1 0.1 warn no vmax 3.0
{columns}
thermo 10
run 24
run 13
""",
    "new with its fix": """fix ts all check/timestep/gran 4 0.5 0.5
fix tt all check/timestep/gran 4 0.5 0.5 vmax 0.01
{columns}
thermo 8
run 11
unfix ts
fix ts all check/timestep/gran 4 0.5 0.5
timestep 1.0e-5
run 14
""",
    "per particle": """fix ts all check/timestep/gran 1 0.5 0.5
fix tt two check/timestep/gran 1 0.5 0.5
{columns}
thermo_modify norm yes
thermo 3
run 7
""",
    "through a variable": """fix ts all check/timestep/gran 1 0.5 0.5
fix tt all check/timestep/gran 1 0.5 0.5
variable part equal 100*f_ts[1]+f_tt[2]
thermo_style custom step v_part
thermo 3
run 6
""",
}

STIFF = "".join(f"fix n{k} all property/global {name} peratomtypepair 2 1 1 1 1\n" for k, name in enumerate(("kn", "kt", "gamman", "gammat")))
STIFF += "pair_style gran model hooke/stiffness\npair_coeff * *\n"


def deck(body: str, *, speed: float = 0.5, units: str = "si") -> str:
    """A deck of three spheres of two types."""
    return HEAD.format(speed=speed, units=units) + body.format(columns=COLUMNS)


def native(text: str, folder: Path) -> list[np.ndarray]:
    """Thermo tables of the native engine, as printed."""
    folder.mkdir()
    (folder / "in.deck").write_text(text)
    ENGINE.run(Job(folder / "in.deck", folder / "out", {}, None, 60.0))
    return [table.values for table in read_thermo(folder / "out" / "log.native")]


@pytest.mark.liggghts
@pytest.mark.parametrize("speed", [0.5, 0.0], ids=["moving", "slower"])
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_the_native_engine_prints_what_liggghts_prints(body: str, speed: float, tmp_path: Path) -> None:
    """Law: f_ID[1..3] of every row are the engine's, to the eight digits it prints: at set-up, between steps of the fix, after a new fix."""
    text = deck(body, speed=speed)
    theirs = [table.values for table in run_liggghts(text, tmp_path / "liggghts").thermo]
    ours = native(text, tmp_path / "native")
    assert len(ours) == len(theirs)
    for mine, their in zip(ours, theirs, strict=True):
        # eight printed digits; the last may be rounded the other way
        np.testing.assert_allclose(mine, their, rtol=2e-8)


@pytest.mark.liggghts
def test_rest_has_no_hertz_time(tmp_path: Path) -> None:
    """Law: where nothing moves the Hertz time is 1e6 and the skin is never crossed."""
    fixes = "fix ts all check/timestep/gran 1 1 1\nfix tt two check/timestep/gran 1 1 1\n"
    text = deck(f"set atom 3 vz 0.0\n{fixes}{{columns}}\nthermo 1\nrun 1\n", speed=0.0)
    theirs, ours = run_liggghts(text, tmp_path / "l").thermo[0].values, native(text, tmp_path / "n")[0]
    np.testing.assert_allclose(ours, theirs, rtol=2e-8)
    assert ours[-1][4] == pytest.approx(2e-5 / 1e6)


@pytest.mark.liggghts
def test_the_warnings_are_those_of_liggghts(tmp_path: Path) -> None:
    """Law: Times.complaints says what LIGGGHTS' log says, number for number."""
    text = deck("fix ts all check/timestep/gran 1 0.01 0.01\nrun 1\n", speed=-700.0)  # away from the others
    log = run_liggghts(text, tmp_path).log
    said = {line.removeprefix("WARNING: ").rpartition(" (")[0] for line in log.splitlines() if "time-step" in line or "time step" in line}
    (tmp_path / "in.deck").write_text(text)
    interpreter = Interpreter("liggghts", {})
    interpreter.run_deck(tmp_path / "in.deck")
    setup = interpreter.setup
    spec = setup.fixes["ts"]
    times = times_of(scene_of(setup).particles, liggghts_material(setup, spec))
    assert set(times.complaints(check_of(setup, spec), 2e-5, 0.002)) == said
    assert len(said) == 4


def test_rayleigh_and_hertz_times_are_their_formulas() -> None:
    """Law: pi R sqrt(rho/G)/(0.1631 nu + 0.8766), and 2.87 (m^2/(R/2 Ye^2 v))^(1/5), which is 2^(2/5) times the duration of a Hertz impact."""
    particles = spheres(np.zeros((2, 3)), np.array([0.01, 0.005]), v=np.array([[0.3, 0.0, 0.4], [0.0, 0.0, 0.0]]))
    young, nu, density = 1e7, 0.25, 2500.0
    times = times_of(particles, Material(np.array([young]), np.array([nu])))
    assert times.rayleigh == pytest.approx(pi * 0.005 * np.sqrt(density / (young / 2.5)) / (0.1631 * nu + 0.8766), rel=1e-14)
    assert (times.rayleigh_particle, times.hertz_particle, times.relative_speed, times.radius) == (1, 1, 1.0, 0.005)
    mass, effective = density * 4 / 3 * pi * 0.005**3, young / (2 * (1 - nu**2))
    duration = 2.94 * (15 / 16) ** 0.4 * ((mass / 2) ** 2 / (0.0025 * effective**2 * 1.0)) ** 0.2
    assert times.hertz / duration == pytest.approx(2**0.4, rel=2e-3)  # 2.87 for 2.94 (15/16)^(2/5) = 2.865


def test_only_the_group_and_what_has_a_material_count() -> None:
    """Law: particles outside of the group, of a type without a modulus, or without a radius have no time."""
    particles = spheres(np.zeros((3, 3)), np.array([0.01, 0.001, 0.0]))
    particles.mask[:] = [3, 1, 3]
    known, unknown = Material(np.array([1e7]), np.array([0.3])), Material(np.array([np.nan]), np.array([np.nan]))
    assert times_of(particles, known, bit=1).rayleigh_particle == 0
    assert times_of(particles, known).rayleigh_particle == 1
    assert times_of(particles, unknown).rayleigh == 1e20


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("0 0.1 0.1", "number of steps must be at least 1, got 0"),
        ("ten 0.1 0.1", "number of steps must be a whole number, got 'ten'"),
        ("10 0.1", "ends where fraction of the Hertz time was expected"),
        ("10 -0.1 0.1", "fraction of the Rayleigh time must be at least 0, got -0.1"),
        ("10 0.1 0.1 loud yes", "keyword 'loud' is not one of warn, error, vmax"),
        ("10 0.1 0.1 warn maybe", "warn 'maybe' is not one of yes, no"),
        ("10 0.1 0.1 vmax -1", "vmax must be at least 0, got -1"),
    ],
)
def test_wrong_words_are_refused_at_once(words: str, said: str, tmp_path: Path) -> None:
    """Law: one line with the place; LIGGGHTS hangs on an unknown keyword."""
    (tmp_path / "in.deck").write_text(deck(f"fix ts all check/timestep/gran {words}\n"))
    with pytest.raises(InputError) as caught:
        Interpreter("liggghts", {}).run_deck(tmp_path / "in.deck")
    assert str(caught.value).endswith(f"in.deck:30: fix ts check/timestep/gran {said}")


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("fix ts all check/timestep/gran 10 1 1\nthermo_style custom step f_ts[4]\nrun 1\n", "f_ts[4]: this fix has f_ts[1] to f_ts[3]"),
        ("fix ts all check/timestep/gran 10 1 1\nthermo_style custom step f_ts\nrun 1\n", "f_ts: this fix has f_ts[1] to f_ts[3]"),
        ("thermo_style custom step f_ts[1]\nrun 1\n", "f_ts: 'ts' is not one of the fixes check/timestep/gran: none"),
        (
            "fix ts all check/timestep/gran 10 1 1\nthermo_style custom step f_ts[1]\nthermo 15\nrun 30\n",
            "thermo prints f_ts every 15 steps, but fix ts is computed every 10",
        ),
        ("fix ts all check/timestep/gran 10 1 1\npair_style none\nrun 1\n", "fix ts check/timestep/gran needs pair_style gran"),
        (f"unfix m1\nunfix m2\n{STIFF}fix ts all check/timestep/gran 10 1 1\nrun 1\n", "check/timestep/gran needs the property youngsModulus"),
        ("fix ts all check/timestep/gran 10 0.01 1 error yes\nrun 40\n", "fix ts check/timestep/gran ends the run at step 10: time-step is"),
    ],
    ids=lambda text: text[-35:-20],
)
def test_what_liggghts_would_not_run_is_refused(body: str, said: str, tmp_path: Path) -> None:
    """Law: an index, a fix or a material that is not there, a rhythm that does not fit, a broken limit with `error yes`: one line."""
    (tmp_path / "in.deck").write_text(deck(body))
    job = Job(tmp_path / "in.deck", tmp_path / "out", {}, None, 60.0)
    with pytest.raises(InputError) as caught:
        plan(job.deck, {})
        ENGINE.run(job)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_column_of_a_fix_does_not_go_to_lammps(run_cli: Callable[..., str], tmp_path: Path) -> None:
    """Law: LAMMPS has no such fix: a converted deck leaves its columns out."""
    (tmp_path / "in.deck").write_text(deck(BODIES["per particle"]))
    assert "f_ts" not in run_cli(tmp_path / "in.deck", "lammps")


@pytest.fixture
def run_cli(tmp_path: Path) -> Callable[..., str]:
    """run_cli(deck, to): the text of the converted deck."""
    def run(path: Path, to: str) -> str:
        convert(plan(path, {}), to, tmp_path / "converted")  # type: ignore[arg-type]
        return (tmp_path / "converted").read_text()

    return run

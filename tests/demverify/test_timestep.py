"""`demverify timestep`, and the warning of `demverify run`: what they say, where, and when they refuse."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from math import pi, sqrt
from pathlib import Path

import pytest

from demverify import cli
from demverify.timestep import step_report
from tests.support.cli import Called, deck

INPUTS = Path(__file__).parents[2] / "inputs"
MASS = 4 / 3 * pi * 0.005**3 * 2500.0
KN, GAMMAN = 1e4, 500.0
SPRING = 2 * sqrt(0.5 * MASS / KN)
COMBINED = 4 * 0.5 * MASS / (GAMMAN * 0.5 * MASS + sqrt((GAMMAN * 0.5 * MASS) ** 2 + 4 * KN * 0.5 * MASS))
MATERIAL = {"pair": "pair_style granular", "coeff": "pair_coeff * * hertz/material 1e7 0 0.25 tangential linear_nohistory 1.0 0.5"}


@pytest.fixture
def demverify(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Iterator[Callable[..., Called]]:
    """demverify(*words): status, stdout and stderr of the command."""

    def call(*words: object) -> Called:
        monkeypatch.setattr("sys.argv", ["demverify", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        assert isinstance(ended.value.code, int)
        return Called(ended.value.code, *capsys.readouterr())

    monkeypatch.setattr("signal.signal", lambda *_: None)
    yield call


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """write(**changed): the small deck of tests.support.cli with other lines."""

    def put(**changed: str) -> Path:
        path = tmp_path / "in.lammps"
        path.write_text(deck(**changed))
        return path

    return put


def values(path: Path, **variables: list[str]) -> dict[str, float | None]:
    """Every limit by name."""
    return {row.name: row.value for row in step_report(path, variables).rows}


def test_the_limits_of_a_linear_deck_are_the_closed_forms(write: Callable[..., Path]) -> None:
    """Law: 2 sqrt(m*/k), 2 m*/eta, the smaller, and K + 2 H = 4, of two equal spheres; the longest of them is not the ruling one."""
    path = write(pair="pair_style gran/hooke 1.0e4 NULL 500.0 0.0 0.5 0")
    found = values(path)
    assert found["spring alone"] == pytest.approx(SPRING, rel=1e-9)
    assert found["damper alone"] == pytest.approx(2 / GAMMAN, rel=1e-9)
    assert found["the smaller of both"] == pytest.approx(min(SPRING, 2 / GAMMAN), rel=1e-9)
    assert found["spring and damper"] == pytest.approx(COMBINED, rel=1e-9)
    report = step_report(path, {})
    assert report.ruling.name == "spring and damper"
    assert report.ruling.where == "types 1 and 1, normal"
    assert not report.exceeded


def test_a_packing_in_contact_rules(write: Callable[..., Path]) -> None:
    """Law: where spheres touch, the packing's limit is below that of single contacts: the bed of the inputs."""
    report = step_report(INPUTS / "bed" / "in.lammps", {})
    assert report.ruling.name == "packing, damped"
    assert report.ruling.where == "the packing of 2681 contacts"
    assert report.ruling.value == pytest.approx(2.163e-4, rel=1e-3)


def test_lammps_material_gives_rayleigh_and_hertz_times(write: Callable[..., Path]) -> None:
    """Law: hertz/material has E and nu; two spheres, one of 0.5 m/s: v = 1."""
    found = values(write(**MATERIAL))
    young, nu = 1e7, 0.25
    assert found["Rayleigh time"] == pytest.approx(pi * 0.005 * sqrt(2500.0 / (young / 2.5)) / (0.1631 * nu + 0.8766), rel=1e-12)
    effective = young / (2 * (1 - nu**2))
    assert found["Hertz time"] == pytest.approx(2.87 * (MASS**2 / (0.0025 * effective**2)) ** 0.2, rel=1e-12)
    assert found["time to cross the skin"] == pytest.approx(0.002)


def test_without_material_the_rows_say_why(write: Callable[..., Path], demverify: Callable[..., Called]) -> None:
    """Law: what is not known is named absent, with the reason, in both dialects."""
    called = demverify("timestep", write())
    assert "absent" in called.out
    assert "pair_style gran/hooke/history gives no Young's modulus; granular hertz/material does" in called.out
    called = demverify("timestep", INPUTS / "bed" / "in.liggghts")
    assert "the deck has no property/global youngsModulus and no poissonsRatio" in called.out


def test_the_table_has_everything_and_the_json_too(write: Callable[..., Path], demverify: Callable[..., Called], tmp_path: Path) -> None:
    """Law: every limit with formula, value, fraction of it, and who rules; JSON without Infinity or NaN; nothing on stderr."""
    called = demverify("timestep", write(), "--json", tmp_path / "limits.json")
    assert called.status == 0
    assert called.err == ""
    for words in ("2 sqrt(m/k)", "primer (2.24)", "primer (2.30)", "primer (2.31)", "K + 2 H < 4", "rules", "semi-implicit Euler", "stable: "):
        assert words in called.out
    found = json.loads((tmp_path / "limits.json").read_text(), parse_constant=pytest.fail)
    assert found["step"] == 1e-6
    assert [row["name"] for row in found["limits"] if row["rules"]] == ["spring and damper"]
    assert all(row["fraction"] == pytest.approx(1e-6 / row["value"]) for row in found["limits"] if row["value"])
    assert {row["motion"] for row in found["contacts"]} == {"normal", "tangential"}
    assert found["exceeded"] is None


def test_variables_reach_the_deck(write: Callable[..., Path], demverify: Callable[..., Called]) -> None:
    """Law: --var sets a variable, as in run."""
    path = write(timestep="timestep ${dt}")
    assert demverify("timestep", path, "--var", "dt", "2e-6").out.startswith(f"{path}: step 2e-06, 2 particles, 0 contacts at the first run")


def test_a_step_above_the_limit_is_told_and_refused_when_strict(write: Callable[..., Path], demverify: Callable[..., Called], tmp_path: Path) -> None:
    """Law: timestep shows it with status 0, --strict ends with one line on stderr and status 2, the JSON all the same."""
    path = write(timestep="timestep 1.0e-3")
    shown = demverify("timestep", path)
    assert (shown.status, shown.err) == (0, "")
    assert "too long: the step 0.001 is above" in shown.out
    refused = demverify("timestep", path, "--strict", "--json", tmp_path / "limits.json")
    assert refused.status == 2
    assert refused.err.startswith(f"demverify: {path}: the step 0.001 is above ")
    assert refused.err.count("\n") == 1
    assert "(classic_history (constant + mass))" in refused.err
    assert json.loads((tmp_path / "limits.json").read_text())["exceeded"]
    assert demverify("timestep", write(), "--strict").status == 0


def test_run_warns_on_stderr_and_refuses_when_strict(write: Callable[..., Path], demverify: Callable[..., Called], tmp_path: Path) -> None:
    """Law: the native engine warns in one line, on stderr only, for all its runs once; --strict refuses before anything is written."""
    path = write(timestep="timestep 1.0e-3", run="run 1\nrun 1", dump="", speed="")
    warned = demverify("run", path, "--out", tmp_path / "out")
    assert warned.status == 0
    assert warned.err.count("\n") == 1
    assert warned.err.startswith(f"demverify: warning: {path}: the step 0.001 is above ")
    assert "warning" not in warned.out
    refused = demverify("run", path, "--out", tmp_path / "refused", "--strict")
    assert refused.status == 2
    assert refused.err.startswith(f"demverify: {path}: the step 0.001 is above ")
    assert not (tmp_path / "refused" / "log.native").exists()
    quiet = demverify("run", write(), "--out", tmp_path / "quiet", "--strict")
    assert (quiet.status, quiet.err) == (0, "")


def test_strict_is_for_the_native_engine(write: Callable[..., Path], demverify: Callable[..., Called], tmp_path: Path) -> None:
    """Law: a word that would do nothing is refused."""
    called = demverify("run", write(), "--engine", "lammps", "--strict", "--out", tmp_path / "out")
    assert called.status == 2
    assert "demverify timestep --strict" in called.err


def test_what_liggghts_would_say_is_said(demverify: Callable[..., Called], tmp_path: Path) -> None:
    """Law: the deck's own fix check/timestep/gran speaks, at the state of the first run."""
    text = (INPUTS / "head-on-hertz" / "in.liggghts").read_text()
    (tmp_path / "in.liggghts").write_text(text.replace("run ", "fix ts all check/timestep/gran 10 1e-4 0.5\nrun ", 1))
    called = demverify("timestep", tmp_path / "in.liggghts")
    assert "fix ts: f_ts[1..3] = " in called.out
    assert "% of rayleigh time" in called.out
    assert "% of hertz time" not in called.out


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"pair": "pair_style gran/hooke -1.0e4 NULL 500.0 NULL 0.5 1"}, "kn must be at least 0, got -10000"),
        ({"pair": "pair_style gran/hooke 1.0e4 NULL 500.0 NULL -0.5 1"}, "mu must be from 0 to 10000, got -0.5"),
        (
            {"pair": "pair_style granular", "coeff": "pair_coeff * * hooke 1e4 1.5 damping coeff_restitution tangential linear_nohistory 1 0.5"},
            "restitution of damping coeff_restitution must be",
        ),
        ({"pair": "pair_style granular", "coeff": "pair_coeff * * hooke 1e4 1.5 dumping velocity"}, "keyword 'dumping' is not one of"),
        ({"timestep": "timestep -1"}, "the time step must be above zero, got -1"),
    ],
    ids=["stiffness", "friction", "restitution", "keyword", "step"],
)
def test_a_wrong_parameter_is_refused(changed: dict[str, str], said: str, write: Callable[..., Path], demverify: Callable[..., Called]) -> None:
    """Law: name, value, allowed range and place in one line, for LAMMPS decks."""
    called = demverify("timestep", write(**changed))
    assert called.status == 2
    assert said in called.err
    assert called.err.count("\n") == 1


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (("coefficientRestitution peratomtypepair 1 .*", "coefficientRestitution peratomtypepair 1 1.5"), "must be > 0.05 and <= 1, got 1.5"),
        (("coefficientRestitution peratomtypepair 1 .*", "coefficientRestitution peratomtypepair 1 -0.5"), "must be > 0.05 and <= 1, got -0.5"),
        (("coefficientFriction peratomtypepair 1 .*", "coefficientFriction peratomtypepair 1 -0.5"), "must be >= 0, got -0.5"),
        (("youngsModulus peratomtype .*", "youngsModulus peratomtype -5e6"), "youngsModulus must be >= 5e+06"),
        (("model hertz", "model hertz tangential hystory"), "tangential model 'hystory' is not one of off, no_history, history"),
    ],
    ids=["e above 1", "e below 0", "friction", "stiffness", "keyword"],
)
def test_a_wrong_property_is_refused(changed: tuple[str, str], said: str, demverify: Callable[..., Called], tmp_path: Path) -> None:
    """Law: name, value and allowed range in one line, for LIGGGHTS decks."""
    import re

    text = (INPUTS / "wall-oblique" / "in.liggghts").read_text()
    wrong = re.sub(*changed, text)
    assert wrong != text
    (tmp_path / "in.liggghts").write_text(wrong)
    called = demverify("timestep", tmp_path / "in.liggghts")
    assert called.status == 2
    assert said in called.err
    assert called.err.count("\n") == 1

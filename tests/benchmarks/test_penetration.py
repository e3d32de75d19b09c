"""The penetration benchmark on the beads under the ball alone, until the ball has met them; and how it judges."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import penetration, penetration_decks
from benchmarks.penetration import CONTENDERS, Flight, judge
from benchmarks.penetration_decks import BALL, BEAD, GRAVITY
from demverify.chaos import FACTOR
from demverify.compare import TIER2
from tests.support.engines import require_lammps, require_liggghts

STEPS = 60  # the ball, 0.1 mm above at 5.2 m/s, meets the first bead at step 39


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """The beads within 12 mm of the ball."""
    require_lammps()
    require_liggghts()
    x, speed = penetration_decks.start()
    near = np.linalg.norm(x - x[-1], axis=1) < 0.012
    monkeypatch.setattr(penetration, "start", lambda: (x[near], speed))


def run(tmp_path: Path) -> tuple[int, dict]:
    code = penetration.main(["--steps", f"{STEPS}", "--repeats", "1", "--json", f"{tmp_path / 'out.json'}", "--picture", f"{tmp_path / 'out.svg'}"])
    return code, json.loads((tmp_path / "out.json").read_text())


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.usefixtures("few")
def test_both_engines_are_met(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Law: native's ball goes LAMMPS' way and LIGGGHTS' way; then there are rates. The two decks describe one scene: before rules matter,
    the first force of LAMMPS and of LIGGGHTS on the ball is the same."""
    code, found = run(tmp_path)
    assert code == 0
    assert all(rounds[0]["rate"] > 0 for rounds in found["rounds"].values())
    assert len(found["rounds"]) == 4
    assert "no figure" not in capsys.readouterr().out
    assert (tmp_path / "out.svg").read_text().startswith("<svg")
    forces = {label: np.array(path["fz"]) for label, path in found["paths"].items()}
    first = int(np.argmax(forces["LAMMPS"] > 0.0))
    assert 0 < first < len(forces["LAMMPS"]) - 1
    # at most ten steps after they touch: rules of friction matter a thousandth of the force by then
    np.testing.assert_allclose(forces["LAMMPS"][first], forces["LIGGGHTS"][first], rtol=1e-3)


@pytest.mark.lammps
@pytest.mark.parametrize("mutation", [("0.4 0.2 tangential", "0.400001 0.2 tangential"), ("timestep 5e-07", "timestep 5.000001e-07")], ids=str)
@pytest.mark.usefixtures("few")
def test_another_ball_has_no_figure(
    mutation: tuple[str, str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Law: where LAMMPS computes another scene there is no rate of it nor of native, and the exit status is 1."""
    made = penetration_decks.decks()
    wrong = made["lammps"].replace(*mutation)
    assert wrong != made["lammps"]
    monkeypatch.setattr(penetration, "decks", lambda: {**made, "wrong": wrong})
    monkeypatch.setattr(penetration, "CONTENDERS", (CONTENDERS[2], replace(CONTENDERS[3], deck="wrong")))
    code, found = run(tmp_path)
    assert code == 1
    assert found["rounds"] == {}
    assert "the ball's" in found["verdicts"]["LAMMPS"]["trouble"]
    assert "particle-steps/s" in (printed := capsys.readouterr().out)
    assert printed.count("no figure") == 2


def test_the_ball_starts_above_the_bed() -> None:
    """Law: the ball is 0.1 mm short of its first bead along its way, and has fallen freely from 0.06 m and 5 m/s: energy is kept."""
    x, speed = penetration_decks.start()
    beads, ball = x[:-1], x[-1]
    assert len(beads) == 25_000
    assert np.linalg.norm(beads - ball, axis=1).min() > BEAD + BALL
    down = np.linalg.norm(beads - (ball - [0.0, 0.0, 1e-4]), axis=1).min()
    assert down == pytest.approx(BEAD + BALL, abs=1e-12)
    assert 0.5 * speed**2 + GRAVITY * ball[2] == pytest.approx(0.5 * 25.0 + GRAVITY * 0.06, rel=1e-14)


def flight(offset: float = 0.0, at: int = 0) -> Flight:
    step = np.arange(0.0, 50.0, 10.0)
    z = np.zeros(5)
    z[at:] += offset * 2.0 * BALL
    return Flight(step, {"z": z, "vz": np.full(5, -5.0), "fz": np.full(5, 3.0)})


def test_the_limit_is_the_spread_of_the_engine() -> None:
    """Law: native may be 10 times the engine's own spread so far apart, never less than 1e-9, and not by a spread that comes later."""
    own = flight().spread([flight(1e-6, at=2), flight(1e-7)])
    assert own["z"] == pytest.approx([1e-7, 1e-7, 1e-6, 1e-6, 1e-6], rel=1e-9)
    nothing = flight().spread([flight()])
    assert judge(flight(0.9 * FACTOR * 1e-6, at=2), flight(), own, "X").trouble == ""
    assert "height differs from that of X by 1.1e-05 at step 20," in judge(flight(1.1 * FACTOR * 1e-6, at=2), flight(), own, "X").trouble
    assert "at step 10," in judge(flight(0.9 * FACTOR * 1e-6, at=1), flight(), own, "X").trouble
    assert judge(flight(0.9 * TIER2), flight(), nothing, "X").trouble == ""
    assert judge(flight(1.1 * TIER2), flight(), nothing, "X").trouble != ""
    assert judge(flight(np.nan), flight(), own, "X").trouble != ""


def test_other_steps_are_not_compared() -> None:
    """Law: paths with rows at other steps cannot be held against each other."""
    other = Flight(np.arange(4.0), flight().values)
    with pytest.raises(penetration.EngineFailed, match="4 and 5 rows"):
        other.apart(flight())

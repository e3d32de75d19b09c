"""Stress scenes, each by its name: the native solver stays within the stated error, refuses or warns; what the engines do is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.cases import Case
from demverify.engines.base import Outcome as EngineOutcome
from demverify.frames import Frame
from demverify.library import catalogue, stress_folder
from demverify.runs import Run
from demverify.stability import stress as study
from demverify.stability.stress_random import GROWN, LAWS, Draw, Ran, _judged, draws, scene_of, try_draw
from demverify.stability.stress_scenes import ENGINES, QUICK_STEPS, Found, judged, quick, scenes, try_scene
from tests.support.engines import require_lammps, require_liggghts

SCENES = {case.name: case for case in scenes()}
TOLD = {
    *(f"deep-pair:{name}" for name in ("d0.6", "d1.5", "one-point")), *(f"deep-wall:{name}" for name in ("d0.6", "d0.9", "d1")), "far:1e13",
    *(f"impact-pair:s{s}" for s in ("1", "3", "100", "1000")), *(f"impact-wall:s{s}" for s in ("0.6", "1", "3", "100", "1000")),
    *(f"periodic:{name}" for name in ("exactly", "too-small", "half", "tiny")), "restitution:e0", "step-limit:h1.01", "step-limit:h2",
    *(f"stiffness:kept-1e{k}" for k in ("2", "7", "7-loses", "8", "9", "10")),
}  # fmt: skip
"""Scenes that the native solver must refuse or warn of; in all others it must stay within the stated error."""
ONLY_LAMMPS = {f"restitution:e{e}" for e in ("0", "0.001", "0.01")}
"""LIGGGHTS, and so its dialect, has no restitution below 0.05."""
BY_ENGINE = [
    ("impact-pair:s0.01", "stayed", "stayed"), ("impact-pair:s100", "lied", "lied"), ("impact-wall:s3", "lied", "lied"),
    ("deep-pair:one-point", "lied", "lied"), ("step-limit:h1.01", "refused", "lied"), ("restitution:e0", "lied", "refused"),
    ("far:1e6", "stayed", "stayed"),
]  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_native(name: str) -> None:
    """Law: the closed form within its stated error, or a word."""
    found = try_scene(quick(SCENES[name]), "native")
    assert found.outcome in (("refused", "warned") if name in TOLD else ("stayed",)), found


@pytest.mark.slow
@pytest.mark.parametrize("engine", [engine for engine in ENGINES if engine.startswith("native")])
@pytest.mark.parametrize("name", SCENES)
def test_native_in_full(name: str, engine: str) -> None:
    """Law: the same on LIGGGHTS' decks, and in 10,000,000 steps of a resting contact."""
    found = try_scene(SCENES[name], engine)
    told = name in TOLD or (engine == "native-liggghts" and name in ONLY_LAMMPS)
    assert found.outcome in (("refused", "warned") if told else ("stayed",)), found


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize(("name", "lammps", "liggghts"), BY_ENGINE)
def test_engines(name: str, lammps: str, liggghts: str) -> None:
    """Law: none; what the engines do, so that docs/stress.md stays true."""
    require_lammps()
    require_liggghts()
    found = [try_scene(SCENES[name], engine) for engine in ("lammps", "liggghts")]
    assert [one.outcome for one in found] == [lammps, liggghts], found


def test_stress_scenes_are_not_of_the_library() -> None:
    """Law: `verify` takes them only where their own folder is named."""
    assert not [case for case in catalogue() if stress_folder() in case.folder.parents]
    assert not [case for case in catalogue([f"{stress_folder().parent}"]) if stress_folder() in case.folder.parents]
    assert len(catalogue([f"{stress_folder()}"])) == len(SCENES)


def test_a_scene_is_whole() -> None:
    """Law: both decks, at least one closed form with its reason, a title and what it is about; names are not twice there."""
    assert len(SCENES) == len(scenes())
    for case in SCENES.values():
        assert set(case.decks) == {"lammps", "liggghts"}
        assert case.laws
        assert case.title
        assert case.what
        assert case.source
    assert set(SCENES) >= TOLD | ONLY_LAMMPS


def test_quick_cuts_the_resting_contact_alone() -> None:
    """Law: where the case sets the steps, or the deck, they stay."""
    cut = [name for name, case in SCENES.items() if quick(case).variables.get("steps") == [f"{QUICK_STEPS}"]]
    assert cut == ["rest:floor", "rest:slope"]


def run_of(status: str = "ok", reason: str = "", vx: float = 1.0, count: int = 2) -> Run:
    """A head-on impact that ends with a relative speed of vx, or with fewer particles, after coming in with 1."""
    outcome = EngineOutcome("lammps", status, reason, "", 0.0, 0, 0, 0.0, Path(), None, None, (), None)  # type: ignore[arg-type]
    return Run("lammps", "lammps", outcome, [_frame(0, -1.0, 2), _frame(9, vx, count)])


def _frame(step: int, parting: float, count: int) -> Frame:
    columns = {name: np.zeros(count) for name in ("x", "y", "z", "vx", "vy", "vz")} | {"mass": np.ones(count), "radius": np.ones(count)}
    columns["x"], columns["vx"] = np.linspace(-2.0, 2.0, count), np.linspace(-0.5, 0.5, count) * parting
    return Frame(step, np.zeros((3, 2)), ("ff", "ff", "ff"), columns)


@pytest.mark.parametrize(("run", "said", "outcome"), [
    (run_of(), [], "stayed"), (run_of(vx=1.001), [], "stayed"), (run_of(), ["the step is long"], "stayed"), (run_of(vx=0.9), [], "lied"),
    (run_of(vx=-1.0), [], "lied"), (run_of(vx=np.nan), [], "lied"), (run_of(vx=np.inf), [], "lied"), (run_of(count=1), [], "lied"),
    (run_of(vx=-1.0), ["the step is long"], "warned"), (run_of(status="crashed", reason="in.lammps:3: ERROR: Lost atoms"), [], "refused"),
    (run_of(status="crashed", reason="killed by SIGSEGV"), [], "crashed"),
    (run_of(status="crashed", reason="stopped at its time limit"), [], "crashed"),
    (run_of(status="skipped", reason="not here"), [], "skipped"),
])  # fmt: skip
def test_outcomes(run: Run, said: list[str], outcome: str) -> None:
    """Law: silence and a wrong number is a lie, NaN and a missing particle too; a word makes it a warning; a stated error is a refusal."""
    assert judged(SCENES["impact-pair:s0.01"], "lammps", run, said).outcome == outcome


def test_what_raises_is_a_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: a traceback is an outcome, and ends nothing."""

    def fails(*_: object, **__: object) -> None:
        raise ZeroDivisionError("x")

    monkeypatch.setattr("demverify.stability.stress_scenes.execute", fails)
    assert try_scene(SCENES["far:1e6"], "native").outcome == "crashed"


numbers = st.floats
DRAWS = st.builds(
    Draw, seed=st.integers(0, 2**31 - 1), count=st.integers(2, 40), law=st.just("hooke"), periodic=st.booleans(), ratio=numbers(1.01, 30.0),
    heavier=numbers(1.0, 1e3), stiffness=numbers(-2.0, 8.0).map(lambda k: 10.0**k), damping=numbers(0.0, 2.0), friction=numbers(0.0, 100.0),
    speed=numbers(-6.0, 0.5).map(lambda k: 10.0**k), spin=numbers(0.0, 10.0), step=numbers(-2.5, 0.7).map(lambda k: 10.0**k),
    filling=numbers(0.5, 1.3),
)  # fmt: skip


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(DRAWS)
def test_random_scenes(draw: Draw) -> None:
    """Law: whatever is drawn ends finite, with energy and momentum within their bounds, or something was said."""
    assert try_draw(draw).outcome in study.GOOD


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_a_thousand_random_scenes(seed: int) -> None:
    """Law: the same for a hundred draws each of both laws."""
    assert not [ran for ran in (try_draw(draw) for draw in draws(100, seed)) if ran.outcome not in study.GOOD]


def test_draws_can_be_made_again_and_span_what_they_say() -> None:
    """Law: a seed is a list; a scene has the count, sizes and step of its draw."""
    some = draws(200, 3)
    assert some == draws(200, 3) != draws(200, 4)
    assert {draw.law for draw in some} == set(LAWS)
    assert {draw.law for draw in draws(20, 3, LAWS[:1])} == {"hooke"}
    scene = scene_of(replace(some[0], count=7, ratio=30.0))
    assert len(scene.particles.id) == 7
    assert 1.0 <= scene.particles.radius.max() / scene.particles.radius.min() <= 30.0
    assert {bool(scene_of(draw).walls) for draw in some} == {True, False}


@pytest.mark.parametrize(("grown", "gained", "said", "outcome"), [
    (0.9, 0.0, [], "stayed"), (1.1, 0.0, [], "lied"), (1.1, 0.0, ["told"], "warned"), (np.nan, 0.0, [], "lied"), (0.0, 1e-6, [], "lied"),
])  # fmt: skip
def test_energy_and_momentum_are_judged(grown: float, gained: float, said: list[str], outcome: str) -> None:
    """Law: more energy than GROWN of what there was, momentum beyond rounding, and NaN are lies where nothing was said."""
    draw = replace(draws(1, 1)[0], periodic=True)
    ran = _judged(draw, said, ((2.0, 0.0), (2.0 + 2.0 * GROWN * grown, 0.0)), ((np.zeros(3), 1.0), (np.array([gained, 0.0, 0.0]), 1.0)), 100)
    assert ran.outcome == outcome


def stub(outcomes: dict[str, str]) -> Callable[[Case, str], Found]:
    """try_scene with the outcome of each engine given."""
    return lambda case, engine: Found(case.name, engine, outcomes[engine], "" if outcomes[engine] == "stayed" else "why", 0.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(("native", "good"), [("stayed", True), ("refused", True), ("warned", True), ("lied", False), ("crashed", False)])
def test_the_finding(native: str, good: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: claims hold while native neither lies nor crashes, whatever the engines do; table and picture have every scene."""
    monkeypatch.setattr(study, "try_scene", stub({"native": native, "lammps": "lied", "liggghts": "crashed"}))
    shares: list[float] = []
    found = study.on_scenes(True, lambda _, share: shares.append(share))
    assert [claim.came_out for claim in found.claims] == [good, good]
    tally, listing = found.tables
    assert {row[0]: row[1:] for row in tally.rows}["lammps"] == ("0", "0", "0", f"{len(SCENES)}", "0")
    assert [row[0] for row in listing.rows] == list(SCENES)
    marks = ET.fromstring(found.figures[0].svg).iter("title")
    assert len(list(marks)) == 3 * len(SCENES) + 5
    assert all(0.0 <= share <= 1.0 for share in shares)


def test_the_finding_of_random_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: one lie of one scene makes the claim fail and names its seed; reasons are counted once each."""
    said = iter(["", "particle 1 moves 2 of its radius in step 0", "particles 1 and 2 overlap by 2", "the energy grew by 3", *[""] * 46])
    monkeypatch.setattr(study, "try_draw", lambda draw: Ran(draw, "refused" if (text := next(said)) else "stayed", text, 0.5, 0.1))
    found = study.at_random(True, lambda *_: None)
    assert all(claim.came_out for claim in found.claims)
    assert [row[1] for row in found.tables[0].rows] == ["47", "1", "1", "1", "0", "0", "0", "0"]
    monkeypatch.setattr(study, "try_draw", lambda draw: Ran(draw, "lied", "energy", 2.0, 0.1))
    broken = study.at_random(True, lambda *_: None).claims[0]
    assert not broken.came_out
    assert f"seed {draws(1, study.SEED, LAWS[:1])[0].seed}" in broken.found

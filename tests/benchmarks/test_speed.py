"""The speed benchmark: every scene goes through every engine and is compared; a wrong answer has no figure.

Scenes are a tenth in size and a fraction in length: what is tested is that the comparison happens and decides, not the figures.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import speed
from benchmarks.speed_run import STANDARD, Contender, Judge, Sample, compared, contenders_of, high_water_mb, judge_of, trouble
from benchmarks.speed_scenes import SCENES, Scene
from benchmarks.speed_states import State, data_file, scattered
from benchmarks.speed_turns import ONE, TWO, Turns, joined, turns_of
from demverify.frames import Thermo
from tests.support.engines import require_lammps, require_liggghts

pytestmark = [pytest.mark.lammps, pytest.mark.liggghts]
STEPS = {"chute": 100, "bed": 200, "gas": 200, "column": 40, "sphere": 2000}
FRICTION_AND_FIELD = "native, friction and a field of 0"
FEW = ("native", "LAMMPS", "native, LIGGGHTS' rules", "LIGGGHTS", "native, with friction", "LAMMPS, with friction")


@pytest.fixture(scope="module")
def states(tmp_path_factory: pytest.TempPathFactory) -> Path:
    require_lammps()
    require_liggghts()
    return tmp_path_factory.mktemp("states")


def short(name: str, states: Path) -> Scene:
    scene = SCENES[name](states, small=True)
    return replace(scene, steps=STEPS[name], every=STEPS[name] // 2)


def checked(scene: Scene, contenders: Sequence[Contender], folder: Path) -> Iterator[tuple[str, str]]:
    """(label, trouble) of all that are compared."""
    paths = scene.write(folder)
    for judging in (one for one in contenders if one.label == one.twin):
        judge = judge_of(judging, scene, paths, folder / "judge")
        for one in contenders:
            if one.twin == judging.label != one.label:
                yield one.label, trouble(compared(one, scene, paths, folder / "compared", judge))


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] if name in ("bed", "column") else []) for name in SCENES])
def test_every_scene_goes_through_the_engines(name: str, states: Path, tmp_path: Path) -> None:
    """Law: in every scene LAMMPS and LIGGGHTS do what native does on their decks, as `demverify compare` judges it; the gas with friction too."""
    scene = short(name, states)
    contenders = [one for one in contenders_of(scene) if one.label in FEW]
    found = dict(checked(scene, contenders, tmp_path))
    assert found == dict.fromkeys(["LAMMPS", "LIGGGHTS", "LAMMPS, with friction"][: len(contenders) // 2], "")


def test_threads_ranks_and_openmp_are_compared_too(states: Path, tmp_path: Path) -> None:
    """Law: two ranks and OpenMP styles do what one core does to the same limits, and two native threads give the bits of one."""
    contenders = [one for one in STANDARD if one.twin == "native"]
    found = dict(checked(short("chute", states), contenders, tmp_path))
    assert found == {one.label: "" for one in contenders[1:]}
    assert len(found) == 5


def test_a_field_of_nothing_changes_no_bit(states: Path, tmp_path: Path) -> None:
    """Law: the gas in which everybody is looked at in every step, for a field of 0, has the bits of the one in which only contacts are."""
    contenders = [one for one in contenders_of(short("gas", states)) if one.label in ("native, with friction", FRICTION_AND_FIELD)]
    found = dict(checked(short("gas", states), contenders, tmp_path))
    assert found == {FRICTION_AND_FIELD: ""}


MUTATIONS = {
    "gravity": ("gravity 1.0 vector", "gravity 1.000001 vector"),
    "stiffness": ("granular hooke 5000.0", "granular hooke 5000.001"),
}


@pytest.fixture
def mutated(monkeypatch: pytest.MonkeyPatch, states: Path, request: pytest.FixtureRequest) -> None:
    """The scene of one sphere, with contenders whose decks are another than they should be."""
    whom, mutation = request.param
    scene = short("sphere", states)
    old, new = MUTATIONS[mutation]
    wrong = scene.decks["lammps"].replace(old, new)
    assert wrong != scene.decks["lammps"]
    few = [one for one in STANDARD if one.label in ("native", "LAMMPS", "LAMMPS, 2 ranks")]
    contenders = tuple(replace(one, deck="wrong") if one.label == whom else one for one in few)
    monkeypatch.setitem(speed.SCENES, "sphere", lambda _states, *, small: replace(scene, decks={**scene.decks, "wrong": wrong}))
    monkeypatch.setattr(speed, "contenders_of", lambda _scene: contenders)


@pytest.mark.parametrize("mutated", [("LAMMPS", mutation) for mutation in MUTATIONS], indirect=True)
@pytest.mark.usefixtures("mutated")
def test_a_wrong_answer_has_no_figure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Law: where LAMMPS computes another scene, neither it nor native has a figure or a ratio, in print or in JSON; the exit status is 1."""
    code = speed.main(["sphere", "--quick", "--markdown", "--json", f"{tmp_path / 'out.json'}"])
    rows = json.loads((tmp_path / "out.json").read_text())["scenes"]["sphere"]
    assert code == 1
    assert [rows["contenders"][label]["figure"] for label in ("native", "LAMMPS")] == [None, None]
    assert "differs from that of native" in rows["contenders"]["LAMMPS"]["reason"]
    assert rows["ratios"] == {}
    printed = capsys.readouterr().out
    assert "| native | no figure |" in printed
    assert "| LAMMPS | no figure |" in printed


@pytest.mark.parametrize("mutated", [("LAMMPS, 2 ranks", "gravity")], indirect=True)
@pytest.mark.usefixtures("mutated")
def test_a_wrong_variant_takes_no_other_with_it(tmp_path: Path) -> None:
    """Law: where only the run with two ranks is wrong, the others have figures, with the memory and start of their processes; the status is 1."""
    assert speed.main(["sphere", "--quick", "--json", f"{tmp_path / 'out.json'}"]) == 1
    rows = json.loads((tmp_path / "out.json").read_text())["scenes"]["sphere"]["contenders"]
    assert rows["LAMMPS, 2 ranks"]["figure"] is None
    for label in ("native", "LAMMPS"):
        [round_] = rows[label]["rounds"]
        assert rows[label]["figure"] == round_["rate"] > 0
        assert 10 < round_["peak_mb"] < 2000
        assert round_["start_s"] > 0


def test_what_a_timed_run_printed_is_judged(states: Path, tmp_path: Path) -> None:
    """Law: energies that are a few per cent off, or bits that differ between native runs, fail; the same numbers pass."""
    scene = short("gas", states)
    found = judge_of(STANDARD[0], scene, scene.write(tmp_path), tmp_path / "judge")
    assert found.native.thermo is not None
    same, off = found.native.thermo, found.native.thermo.values.copy()
    off[-1, same.columns.index("c_kin")] *= 1.03
    last_bit = same.values.copy()
    last_bit[-1, same.columns.index("c_kin")] = np.nextafter(last_bit[-1, same.columns.index("c_kin")], 0.0)
    assert judged(found, "lammps", same, scene) == judged(found, "native", same, scene) == ""
    assert judged(found, "lammps", Thermo(same.columns, last_bit), scene) == ""
    assert judged(found, "native", Thermo(same.columns, last_bit), scene).startswith("ke differs")
    assert judged(found, "lammps", Thermo(same.columns, off), scene).startswith("ke differs")
    assert judged(found, "lammps", Thermo(same.columns, same.values[:-1]), scene).startswith("steps differs")


def judged(judge: Judge, engine: str, thermo: Thermo, scene: Scene) -> str:
    return trouble(judge.of_thermo("other", engine, thermo, scene.columns))


def test_a_ratio_is_the_median_of_rounds() -> None:
    """Law: ratios are taken within a round and then their median; a contender with trouble has none."""
    nothing = Thermo((), np.empty((0, 0)))
    rates = {"native": (2.0, 9.0, 4.0), "LAMMPS": (1.0, 3.0, 4.0)}
    rows = {
        one.label: speed.Row(one, [Sample(rate, 1.0, 1.0, 1.0, 0.0, nothing) for rate in rates[one.label]]) for one in STANDARD if one.label in rates
    }
    result = speed.Result(SCENES["sphere"](Path(), small=True), rows)
    assert result.ratio("native", "LAMMPS") == 2.0  # of 2, 3, 1; the ratio of medians is 4/3
    rows["LAMMPS"].trouble = "differs"
    assert result.ratio("native", "LAMMPS") is None
    assert result.ratio("native", "LIGGGHTS") is None


def test_threads_are_timed_by_turns(states: Path, tmp_path: Path) -> None:
    """Law: one and two threads run the same deck by turns and end at the same bits; turns of several rounds make one median, and one round of
    other bits makes all of them others."""
    scene = short("chute", states)
    one = STANDARD[0].job(scene.write(tmp_path), tmp_path, scene)
    found = turns_of(one.deck, one.variables)
    assert found.same
    assert len(found.ratios) == len(found.apart) >= 4
    assert min(*found.ratios, *found.apart) > 0.0
    both = joined([Turns((1.0, 2.0), (1.0, 1.0), 100, same=True), Turns((3.0, 4.0), (2.0, 2.0), 100, same=False)])
    assert str(both).endswith("2.50, half of 4 turns between 1.25 and 3.75; two processes of one thread together do 1.50 times the work of one")
    assert not both.same


@pytest.mark.parametrize("same", [True, False])
def test_turns_that_part_have_no_figure(same: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: two threads that end at other bits than one have neither a rate nor a ratio."""
    nothing = Thermo((), np.empty((0, 0)))
    rows = {one.label: speed.Row(one, [Sample(1.0, 1.0, 1.0, 1.0, 0.0, nothing)]) for one in STANDARD if one.label in (ONE, TWO)}
    result = speed.Result(SCENES["sphere"](Path(), small=True), rows)
    monkeypatch.setattr(speed, "turns_of", lambda *_: Turns((1.5, 1.7), (1.9, 1.9), 100, same=same))
    speed._turns(rows[TWO], result, dict.fromkeys(("lammps",), Path()), Path(), 0.0)
    assert (result.ratio(TWO, ONE) is None) == (not same)
    assert any("by turns in one process: 1.60, half of 2 turns" in line for line in speed.summed_up(result)) == same


def test_a_missing_engine_is_skipped_by_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: without LIGGGHTS its row says how to install it, native on its deck has no figure either, and the status stays 0."""
    monkeypatch.setattr(speed, "contenders_of", lambda _scene: STANDARD[-2:])
    monkeypatch.setattr(speed, "missing", lambda one: "install it" if one.engine == "liggghts" else "")
    scene = short("sphere", tmp_path)
    monkeypatch.setitem(speed.SCENES, "sphere", lambda _states, *, small: scene)
    assert speed.main(["sphere", "--quick", "--json", f"{tmp_path / 'out.json'}"]) == 0
    rows = json.loads((tmp_path / "out.json").read_text())["scenes"]["sphere"]["contenders"]
    assert [row["figure"] for row in rows.values()] == [None, None]
    assert rows["LIGGGHTS"]["reason"] == "install it"


def test_pairs_are_counted_over_periodic_faces() -> None:
    """Law: the counted pairs are those of a sum over all pairs and images, for spheres of different sizes."""
    rng = np.random.default_rng(3)
    size, periodic, skin = np.array([6.0, 5.0, 7.0]), np.array([True, False, True]), 0.3
    x, diameter = rng.uniform(0.0, 1.0, (60, 3)) * size, rng.uniform(0.5, 1.5, 60)
    apart = x[:, None] - x[None]
    apart -= np.where(periodic, size * np.round(apart / size), 0.0)
    gap = np.linalg.norm(apart, axis=2) - 0.5 * (diameter[:, None] + diameter[None])
    expected = tuple(int((np.triu(gap < limit, 1) & ~np.eye(60, dtype=bool)).sum()) for limit in (skin, 0.0))
    scene = replace(SCENES["sphere"](Path(), small=True), skin=skin, size=tuple(size), periodic=tuple(periodic))
    assert scene.pairs(x, diameter) == expected
    assert expected[1] > 0


def test_scattered_spheres_do_not_touch() -> None:
    """Law: no two are nearer than a diameter, over the faces too; the seed makes the state."""
    x = scattered(300, 9.0, np.random.default_rng(1))
    apart = x[:, None] - x[None]
    distance = np.linalg.norm(apart - 9.0 * np.round(apart / 9.0), axis=2) + 9.0 * np.eye(300)
    assert distance.min() > 1.0
    assert np.array_equal(x, scattered(300, 9.0, np.random.default_rng(1)))


def test_a_data_file_holds_every_bit() -> None:
    """Law: what a data file says is the state, to the last bit."""
    rng = np.random.default_rng(2)
    state = State(rng.uniform(0.5, 1.0, 5), *rng.normal(size=(3, 5, 3)))
    atoms, velocities = data_file(state, (1.0, 1.0, 1.0), "five").split("Atoms\n")[1].split("Velocities")
    rows = [np.array([line.split() for line in part.splitlines() if line.strip()], dtype=float) for part in (atoms, velocities)]
    assert np.array_equal(rows[0][:, 2], state.diameter)
    assert np.array_equal(rows[0][:, 4:7], state.x)
    assert np.array_equal(rows[1][:, 1:], np.hstack([state.v, state.omega]))


def test_memory_of_a_process_is_its_own() -> None:
    """Law: the high water mark of this process is at least what it holds now."""
    assert high_water_mb(os.getpid()) > 20.0
    assert high_water_mb(2**31 - 1) == 0.0

"""LIGGGHTS decks with rolling friction and cohesion -> laws -> forces, against LIGGGHTS 3.8.0: one state and a few steps of history."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from inspect import signature
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from demsolver import contact
from demsolver.reference import Key, forces
from demsolver.scene import Scene
from demverify.errors import InputError
from demverify.frames import Frame
from demverify.runs import plan
from tests.support.contact_cases import Case, change_pair, difference, run, scene_of
from tests.support.decks import Ball, Material, liggghts_deck
from tests.support.engines import EngineRun, run_liggghts

pytestmark = pytest.mark.liggghts
TOLERANCE = 1e-12  # of the largest force (torque) of a step: some 20 contacts, each rounded anew, and the same sums in another order

PROPERTIES = {
    "youngsModulus": "peratomtype 5e6 1.2e7",
    "poissonsRatio": "peratomtype 0.3 0.22",
    "coefficientRestitution": "peratomtypepair 2 0.6 0.5 0.5 0.8",
    "coefficientFriction": "peratomtypepair 2 0.5 0.3 0.3 0.2",
    "characteristicVelocity": "scalar 0.5",
    "kn": "peratomtypepair 2 1e4 2e4 2e4 1.5e4",
    "kt": "peratomtypepair 2 3e3 2e3 2e3 4e3",
    "gamman": "peratomtypepair 2 500 400 400 700",
    "gammat": "peratomtypepair 2 200 100 100 300",
    "gamman_abs": "peratomtypepair 2 0.5 0.4 0.4 0.7",
    "gammat_abs": "peratomtypepair 2 0.2 0.3 0.3 0.4",
    "FluidViscosity": "peratomtypepair 2 1e-3 2e-3 2e-3 3e-3",
    "MaximumRestitution": "peratomtypepair 2 0.9 0.8 0.8 0.7",
    "CriticalStokes": "peratomtypepair 2 10 12 12 14",
    "coefficientRollingViscousDamping": "peratomtypepair 2 0.05 0.02 0.02 0.5",
    "cohesionEnergyDensity": "peratomtypepair 2 2e5 1e5 1e5 3e5",
}
STIFFER = {  # for hertz/stiffness, where the contact radius multiplies
    "kn": "peratomtypepair 2 2e6 1e6 1e6 3e6",
    "kt": "peratomtypepair 2 5e5 6e5 6e5 7e5",
    "gamman": "peratomtypepair 2 5e5 4e5 4e5 7e5",
    "gammat": "peratomtypepair 2 2e5 1e5 1e5 3e5",
}
RESISTANCE = {  # such that within 12 steps some springs reach their limit and some do not, and no spin of cdt turns round
    "off": "0 0 0 0",
    "cdt": "0.3 0.1 0.1 0.2",
    "epsd": "20 12 12 0.3",
    "epsd2": "0.004 0.01 0.01 0.3",
}
NORMALS = ("hooke", "hertz", "hooke/stiffness", "hertz/stiffness")
ROLLING = ("cdt", "epsd", "epsd2")
WALLS = ("type 2 zplane 0.0", "type 1 zcylinder 0.06 0.0 0.0")


def properties(model: str, rolling: str) -> list[str]:
    """The fix property/global lines."""
    values = PROPERTIES | (STIFFER if model == "hertz/stiffness" else {})
    values |= {"coefficientRollingFriction": f"peratomtypepair 2 {RESISTANCE[rolling]}"}
    return [f"fix m{k} all property/global {name} {words}" for k, (name, words) in enumerate(values.items())]


def case(model: str, parts: str, rolling: str = "off", switches: str = "", walls: tuple[str, ...] = WALLS) -> Case:
    """Pairs and walls of one law. parts: the words between the normal model and rolling_friction."""
    words = f"model {model} {parts} rolling_friction {rolling}"
    fixes = [f"fix w{k} all wall/gran {words} primitive {wall} {switches}" for k, wall in enumerate(walls)]
    lines = (*properties(model, rolling), f"pair_style gran {words} {switches}", "pair_coeff * *", *fixes)
    return Case(f"{words} {switches} {walls[0] if len(walls) == 1 else ''}", lines)


def settings(**states: bool) -> str:
    """Switches as words."""
    return " ".join(f"{name} {'on' if on else 'off'}" for name, on in states.items())


def mixed() -> Case:
    """Pairs without rolling friction and cohesion, a floor with the one, a cylinder with both."""
    fixes = (
        "fix w0 all wall/gran model hertz tangential history rolling_friction epsd primitive type 2 zplane 0.0 torsionTorque on",
        "fix w1 all wall/gran model hertz cohesion sjkr rolling_friction cdt primitive type 1 zcylinder 0.06 0.0 0.0 tangential_reduce on",
    )
    lines = (*properties("hertz", "cdt"), "pair_style gran model hertz tangential history", "pair_coeff * *", *fixes)
    return Case("each with another law", lines)


CASES = [
    *(
        case(model, "tangential history", rolling, settings(torsionTorque=torsion, limitForce=torsion ^ (k % 2 == 0)))
        for k, model in enumerate(NORMALS)
        for rolling, torsion in product(ROLLING, (False, True))
    ),
    *(case("hertz", f"tangential {tangential}", rolling) for tangential, rolling in product(("off", "no_history"), ROLLING)),
    *(
        case(model, "tangential history cohesion sjkr", switches=settings(tangential_reduce=reduced, limitForce=limited))
        for model, reduced, limited in product(NORMALS, (False, True), (False, True))
    ),
    *(case("hertz", f"tangential {tangential} cohesion sjkr", switches="tangential_reduce on") for tangential in ("off", "no_history")),
    *(
        case("hertz", "tangential history cohesion sjkr", rolling, settings(tangential_reduce=reduced, limitForce=True, torsionTorque=True))
        for rolling, reduced in product(ROLLING, (False, True))
    ),
    *(case("hooke", f"tangential {tangential}", "epsd2", "ktToKnUser on") for tangential in ("off", "history")),
    case("hooke", "tangential history cohesion sjkr", "epsd", "viscous on"),
    case("hooke/stiffness", "tangential history", "epsd", "absolute_damping on tangential_damping off"),
    *(
        case("hertz", "tangential history", "epsd", walls=(wall,))
        for wall in ("type 2 xcylinder 0.03 0.005 0.04", "type 1 yplane -0.021 shear z 0.3")
    ),
    mixed(),
]
BY_NAME = {c.name: c for c in CASES}


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Frame]]:
    """Case name -> frames of all steps, all cases in one process of LIGGGHTS."""
    return dict(zip(BY_NAME, run(CASES, "liggghts", tmp_path_factory.mktemp("liggghts")), strict=True))


@pytest.mark.parametrize("name", BY_NAME)
def test_forces_equal_liggghts(name: str, frames: dict[str, list[Frame]]) -> None:
    """Law: forces and torques of set-up and of a few steps with history equal LIGGGHTS', to rounding."""
    assert difference(scene_of(BY_NAME[name], "liggghts"), frames[name]).worst < TOLERANCE


LIMITED = "model hertz tangential history cohesion sjkr rolling_friction {} tangential_reduce on limitForce on torsionTorque on "
PLAIN = "model hooke tangential history rolling_friction {} torsionTorque off limitForce on "
WRONG: dict[str, tuple[str, Callable[[Scene], Scene]]] = {
    "no rolling friction": (PLAIN.format("cdt"), change_pair(rolling="none")),
    "the other spring": (PLAIN.format("epsd"), change_pair(rolling="epsd2")),
    "torsion": (PLAIN.format("epsd2"), lambda s: with_coefficient(s, "torsion", 1.0)),
    "no dashpot": (PLAIN.format("epsd"), lambda s: with_coefficient(s, "rolling_damping_ratio", 0.0)),
    "no cohesion": (LIMITED.format("cdt"), change_pair(cohesion="none")),
    "limits without cohesion": (LIMITED.format("epsd"), change_pair(tangential_reduce=False)),
}


def with_coefficient(scene: Scene, name: str, value: float) -> Scene:
    """The scene with one coefficient of its pair law at `value`."""
    assert scene.pair
    return change_pair(coefficients={**scene.pair.coefficients, name: np.full((2, 2), value)})(scene)


@pytest.mark.parametrize(("name", "change"), WRONG.values(), ids=WRONG)
def test_a_wrong_setting_is_noticed(name: str, change: Callable[[Scene], Scene], frames: dict[str, list[Frame]]) -> None:
    """Law: the state is rich enough: exchanging one setting moves forces or torques by far more than the tolerance."""
    assert difference(change(scene_of(BY_NAME[name], "liggghts")), frames[name]).worst > 1e3 * TOLERANCE


ALTERED: dict[str, tuple[str, contact.Family, str, Callable[[dict[str, Any]], dict[str, Any]]]] = {
    "arm at walls": (PLAIN, "rolling", "epsd", lambda known: {"arm_ratio": 1.0}),
    "arm at walls, epsd2": (PLAIN, "rolling", "epsd2", lambda known: {"arm_ratio": 1.0}),
    "discs": (PLAIN, "rolling", "epsd", lambda known: {"rolling_inertia": 1.5 / 1.4 * known["rolling_inertia"]}),
    "no increment at set-up": (PLAIN, "rolling", "epsd2", lambda known: {"dt": known["dt"] * known["advance"]}),
    "history grows at set-up": (PLAIN, "rolling", "epsd", lambda known: {"advance": True}),
    "force with damping": (PLAIN, "rolling", "cdt", lambda known: {"normal_elastic": 1.01 * known["normal_elastic"]}),
    "flat partner": (LIMITED, "cohesion", "sjkr", lambda known: {"partner_curvature": 0.0}),
}


@pytest.mark.parametrize(("words", "family", "name", "change"), ALTERED.values(), ids=ALTERED)
def test_a_wrong_rule_is_noticed(
    words: str,
    family: contact.Family,
    name: str,
    change: Callable[[dict[str, Any]], dict[str, Any]],
    frames: dict[str, list[Frame]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Law: nor does one altered argument of a law stay unseen."""
    module = contact.law(family, name)
    right = getattr(module, contact.ENTRY[family])

    @wraps(right)
    def wrong(*given: Any) -> Any:
        known = dict(zip(signature(right).parameters, given, strict=True))
        return right(**(known | change(known)))

    monkeypatch.setattr(module, contact.ENTRY[family], wrong)
    deck = words.format(name if family == "rolling" else "epsd")
    assert difference(scene_of(BY_NAME[deck], "liggghts"), frames[deck]).worst > 1e3 * TOLERANCE


@pytest.mark.parametrize("name", ["epsd", "epsd2"])
def test_the_state_reaches_the_limit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: on the way some springs are cut at rolling_friction R* |F| and others are not, at the walls too."""
    module = contact.law("rolling", name)
    right, cut = module.torque, dict[tuple[bool, bool], int]()

    @wraps(right)
    def counted(*given: Any) -> Any:
        known = dict(zip(signature(right).parameters, given, strict=True))
        result = right(*given)
        limit = known["rolling_friction"] * known["reff"] * known["critical_force"]
        kind = (known["arm_ratio"] != 1.0, bool(np.linalg.norm(result[3:]) > (1.0 - 1e-12) * limit))
        cut[kind] = cut.get(kind, 0) + known["advance"]
        return result

    monkeypatch.setattr(module, "torque", counted)
    trajectory(scene_of(BY_NAME[PLAIN.format(name)], "liggghts"), (12,))
    assert min(cut.get((wall, limited), 0) for wall, limited in product((False, True), repeat=2)) >= 5


Floats = NDArray[np.float64]


def trajectory(scene: Scene, runs: tuple[int, ...]) -> list[tuple[Floats, Floats]]:
    """Force and torque of every step; runs: steps of each `run`, which begins with forces of the full-step velocities, histories as they are."""
    p = scene.particles
    x, v, omega, history = p.x.copy(), p.v.copy(), p.omega.copy(), dict[Key, Floats]()
    half = 0.5 * scene.timestep
    kick, spin = half / p.mass[:, None], half / (0.4 * p.mass * p.radius**2)[:, None]
    found: list[tuple[Floats, Floats]] = []
    for steps in runs:
        force, torque, history = forces(scene, x, v, omega, history, False)
        found += [] if found else [(force, torque)]
        for _ in range(steps):
            v, omega = v + kick * force, omega + spin * torque
            x = x + scene.timestep * v
            force, torque, history = forces(scene, x, v, omega, history, True)
            v, omega = v + kick * force, omega + spin * torque
            found.append((force, torque))
    return found


STEEL = {
    "kn": 1e4, "kt": 3e3, "gamman": 200.0, "gammat": 100.0, "coefficientFriction": 0.5, "coefficientRollingFriction": 0.3,
    "coefficientRollingViscousDamping": 0.2,
}  # fmt: skip
MODEL = "model hooke/stiffness tangential history rolling_friction"


def simulated(balls: list[Ball], body: str, folder: Path, dimension: int = 3) -> tuple[Scene, EngineRun]:
    """A deck read here and run there."""
    types = max(ball.type for ball in balls)
    text = liggghts_deck(balls, Material(types, STEEL), body, folder, dt=1e-5, dimension=dimension)
    done = run_liggghts(text, folder)
    return plan(folder / "in.deck", {}).runs[0].scene, done


def apart(found: list[tuple[Floats, Floats]], frames: tuple[Frame, ...]) -> float:
    """Largest difference of a torque at any step over the largest torque of all."""
    torques = [frame.vectors("tqx", "tqy", "tqz") for frame in frames]
    differences = [np.abs(ours - theirs).max() for (_, ours), theirs in zip(found, torques, strict=True)]
    return float(max(differences) / max(np.abs(torque).max() for torque in torques))


@pytest.mark.parametrize("rolling", ["epsd", "epsd2"])
def test_springs_outlive_a_pair_and_no_wall(rolling: str, tmp_path: Path) -> None:
    """Law: a ball between two heavy ones finds its old spring at each touch, before a rebuild; a ball between two planes finds none."""
    heavy = [Ball((x, 0.0, 0.0), omega=(0.0, 5.0, 9.0), density=1e6, type=2) for x in (0.0, 0.0301)]
    light = [Ball((x, 0.0, z), v=v, omega=(20.0, 40.0, -30.0), radius=0.005) for x, z, v in ((0.01502, 0.0, (0.2, 0, 0)), (0.1, 0.505, (0, 0, 0.2)))]
    walls = [f"fix w{k} all wall/gran {MODEL} {rolling} primitive type 1 zplane {z}" for k, z in enumerate((0.5, 0.5101))]
    body = "\n".join((f"pair_style gran {MODEL} {rolling}", "pair_coeff * *", *walls, "fix n all nve/sphere", "run 700"))
    scene, done = simulated([*heavy, *light], body, tmp_path)
    touching = np.array([np.abs(frame.vectors("fx", "fy", "fz")).max(axis=1) > 0.0 for frame in done.frames])
    assert ((np.diff(touching.astype(int), axis=0) == 1).sum(axis=0)[2:] >= 3).all()
    # 700 steps of a few smooth contacts: rounding of 1e-16 a step, tenfold for what the springs and the flight make of it
    assert apart(trajectory(scene, (700,)), done.frames) < 1e-12
    assert apart(trajectory(replace(scene, history_outlives_contact=False), (700,)), done.frames) > 1e-3


@pytest.mark.parametrize("rolling", ["cdt", "epsd", "epsd2"])
def test_a_second_run_does_not_advance_the_spring(rolling: str, tmp_path: Path) -> None:
    """Law: `run 8; run 8` takes the forces of step 8 anew, with the spin of the full step and the spring as it is; torsion of the spring included."""
    balls = [Ball((0.0, 0.0, 0.0), omega=(30.0, 10.0, 20.0)), Ball((0.0199, 0.0, 0.0), v=(-0.1, 0.0, 0.0))]
    body = f"pair_style gran {MODEL} {rolling} torsionTorque on\npair_coeff * *\nfix n all nve/sphere\nrun 8\nrun 8"
    scene, done = simulated(balls, body, tmp_path)
    assert apart(trajectory(scene, (8, 8)), done.frames) < 1e-13
    assert apart(trajectory(scene, (16,)), done.frames) > 1e-6


def test_in_two_dimensions_discs_roll(tmp_path: Path) -> None:
    """Law: in two dimensions the inertia of the dashpot of epsd is 3/2 m R^2 of each disc, not 7/5."""
    places = {0.0: 0.2, 0.00099: 0.0, -0.1: 0.3}
    balls = [Ball((x, 0.0, 0.0), omega=(0.0, 0.0, spin), radius=0.0005) for x, spin in places.items()]
    wall = f"fix w all wall/gran {MODEL} epsd primitive type 1 xplane -0.10049"
    body = f"neighbor 1e-4 bin\npair_style gran {MODEL} epsd\npair_coeff * *\n{wall}\nfix n all nve/sphere\nfix e all enforce2d\nrun 0"
    scene, done = simulated(balls, body, tmp_path, dimension=2)
    assert scene.dimension == 2
    assert apart(trajectory(scene, (0,)), done.frames) < 1e-14
    assert apart(trajectory(replace(scene, dimension=3), (0,)), done.frames) > 1e-3


@pytest.mark.parametrize(
    "words",
    [
        "model hertz rolling_friction cdt cohesion sjkr",
        "model hertz cohesion sjkr tangential history",
        "model hertz torsionTorque on rolling_friction cdt",
        "model hertz cohesion sjkr torsionTorque on",
        "model hertz rolling_friction off torsionTorque off",
        "model hertz surface default rolling_friction cdt",
    ],
)
def test_liggghts_refuses_what_is_refused_here(words: str, tmp_path: Path) -> None:
    """Law: another order of the parts, and a switch without its part, are errors of LIGGGHTS too."""
    material = Material(1, {"youngsModulus": 1e7, "poissonsRatio": 0.3, "coefficientRestitution": 0.5, "coefficientFriction": 0.5} | STEEL)
    deck = liggghts_deck([Ball((0.0, 0.0, 0.0))], material, f"pair_style gran {words}\npair_coeff * *\nrun 0", tmp_path)
    assert "wrong keyword order" in run_liggghts(deck, tmp_path, may_fail=True).log
    with pytest.raises(InputError, match=r"too late|whose switch it is"):
        plan(tmp_path / "in.deck", {})

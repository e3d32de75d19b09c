"""LIGGGHTS decks -> laws -> forces, against LIGGGHTS 3.8.0: one state and a few steps of history, every model and switch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import pytest

from demsolver.scene import Scene
from demverify.frames import Frame
from tests.support.contact_cases import Case, change_cylinder, change_pair, difference, run, scene_of

pytestmark = pytest.mark.liggghts
TOLERANCE = 1e-12

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
}
STIFFER = {  # for hertz/stiffness, where the contact radius multiplies
    "kn": "peratomtypepair 2 2e6 1e6 1e6 3e6",
    "kt": "peratomtypepair 2 5e5 6e5 6e5 7e5",
    "gamman": "peratomtypepair 2 5e5 4e5 4e5 7e5",
    "gammat": "peratomtypepair 2 2e5 1e5 1e5 3e5",
}
SWITCHES = {"hooke": ("viscous", "ktToKnUser"), "hertz": (), "hooke/stiffness": ("absolute_damping",), "hertz/stiffness": ()}


def properties(model: str) -> list[str]:
    """The fix property/global lines."""
    values = PROPERTIES | (STIFFER if model == "hertz/stiffness" else {})
    return [f"fix m{k} all property/global {name} {words}" for k, (name, words) in enumerate(values.items())]


def case(model: str, tangential: str, switches: str, walls: tuple[str, ...]) -> Case:
    """Pairs and walls of one model; `walls` are the words behind `primitive`."""
    words = f"model {model} tangential {tangential}"
    fixes = [f"fix w{k} all wall/gran {words} primitive {wall} {switches}" for k, wall in enumerate(walls)]
    lines = (*properties(model), f"pair_style gran {words} {switches}", "pair_coeff * *", *fixes)
    return Case(f"{words} {switches} {walls[0] if len(walls) == 1 else ''}", lines)


MODELS = [
    case(
        model,
        tangential,
        " ".join(f"{name} {state}" for name, state in zip(("tangential_damping", "limitForce", *extra), states, strict=True)),
        ("type 2 zplane 0.0", "type 1 zcylinder 0.06 0.0 0.0"),
    )
    for model, extra in SWITCHES.items()
    for tangential in ("off", "no_history", "history")
    for states in product(("on", "off"), repeat=2 + len(extra))
]
WALLS = [
    case("hertz", "history", "limitForce on", (f"type 2 {words}",))
    for words in (
        "xcylinder 0.03 0.005 0.04",
        "ycylinder 0.03 0.04 0.005",  # centre z x
        "zcylinder 0.05 0.011 0.007",
        "zcylinder 0.03 0.011 0.007 shear z 0.4",
        "xcylinder 0.03 0.005 0.04 shear x 0.3",
        "xplane 0.011 shear y 0.3",
        "yplane -0.021 shear z 0.3",
        "zplane 0.0 shear z 0.3",  # along its own normal: the wall stays, its velocity counts
    )
]
DEFAULTS = [case("hertz", "history", "", ("type 1 zplane 0.0",)), case("hooke/stiffness", "history", "", ("type 1 zplane 0.0",))]
CASES = {c.name: c for c in (*MODELS, *WALLS, *DEFAULTS)}
HISTORY = "model hertz tangential history tangential_damping on limitForce off "


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Frame]]:
    """Case name -> frames of all steps, all cases in one process of LIGGGHTS."""
    return dict(zip(CASES, run(list(CASES.values()), "liggghts", tmp_path_factory.mktemp("liggghts")), strict=True))


@pytest.mark.parametrize("name", CASES)
def test_forces_equal_liggghts(name: str, frames: dict[str, list[Frame]]) -> None:
    """Forces and torques of set-up and of a few steps with history equal LIGGGHTS', to rounding."""
    assert difference(scene_of(CASES[name], "liggghts"), frames[name]).worst < TOLERANCE


WRONG: dict[str, Callable[[Scene], Scene]] = {
    "friction of LAMMPS": change_pair(friction="classic_history"),
    "torque arm": change_pair(torque_arm="radius"),
    "surface arm": change_pair(surface_arm="radius"),
    "limitForce": change_pair(limit_damping=True),
    "curved cylinder": change_cylinder(effective_radius="curved"),
    "type of the wall": lambda s: replace(s, walls=(replace(s.walls[0], law=s.walls[1].law), s.walls[1])),
}


@pytest.mark.parametrize("change", WRONG.values(), ids=WRONG)
def test_a_wrong_rule_is_noticed(change: Callable[[Scene], Scene], frames: dict[str, list[Frame]]) -> None:
    """The state is rich enough: exchanging one rule moves forces or torques by far more than the tolerance."""
    found = difference(change(scene_of(CASES[HISTORY], "liggghts")), frames[HISTORY])
    assert found.worst > 1e3 * TOLERANCE

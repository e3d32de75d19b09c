"""The words of LAMMPS' cohesive, rolling and twisting models and of step laws: what they become, and what is refused in one line."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from math import pi
from pathlib import Path

import numpy as np
import pytest

from demsolver import contact
from demsolver.scene import ContactLaw
from demverify.deck import materials_lammps
from demverify.engines.base import Job
from demverify.errors import InputError
from demverify.runs import execute
from tests.support.contact_cases import setup_of

JKR = "jkr 1e7 50 0.3 2.0 tangential mindlin NULL 1.0 0.5"
HERTZ = "hertz 2e6 5e5 tangential linear_history 5e5 0.7 0.5"


def law(*lines: str, ntypes: int = 2) -> ContactLaw:
    """The pair law of these lines."""
    found = materials_lammps.pair_law(setup_of(["pair_style granular", *(f"pair_coeff {line}" for line in lines)], "lammps", ntypes))
    assert found is not None
    return found


def wall(words: str) -> ContactLaw:
    """The law of a granular wall."""
    return materials_lammps.walls(setup_of([f"fix w all wall/gran granular {words} zplane 0 NULL"], "lammps"))[0].law


def test_cohesive_materials() -> None:
    """Law: E* = E/(2 (1 - nu^2)) of two like materials, for walls too; dmt has kn = 4/3 E*; kt NULL is 8 G*; the fourth number is the surface
    energy; damping is viscoelastic by default."""
    young = 1e7 / 1.82
    for found in (law(f"* * {JKR}"), wall(JKR)):
        assert (found.normal, found.damping, found.friction) == ("jkr", "viscoelastic", "rotated_history")
        assert found.coefficients["yeff"] == pytest.approx(young, rel=1e-14)
        assert found.coefficients["surface_energy"] == pytest.approx(2.0)
        assert found.coefficients["gamman"] == pytest.approx(50.0)
        assert found.coefficients["shear_stiffness"] == pytest.approx(8e7 / 8.84, rel=1e-14)
    for found in (law(f"* * {JKR.replace('jkr', 'dmt')}"), wall(JKR.replace("jkr", "dmt"))):
        assert found.normal == "dmt"
        assert found.coefficients["kn"] == pytest.approx(4.0 / 3.0 * young, rel=1e-14)


def test_cohesive_materials_mix() -> None:
    """Law: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j; surface energy and damping by the geometric mean."""
    mixed = law(f"1 1 {JKR}", "2 2 jkr 4e7 200 0.2 8.0 tangential mindlin NULL 1.0 0.5").coefficients
    assert mixed["yeff"][0, 1] == pytest.approx(1.0 / (0.91 / 1e7 + 0.96 / 4e7), rel=1e-14)
    assert mixed["surface_energy"][0, 1] == pytest.approx(4.0)
    assert mixed["gamman"][0, 1] == pytest.approx(100.0)


SPRINGS = {
    "mindlin/force": "mindlin_force",
    "mindlin_rescale": "mindlin_rescale",
    "mindlin_rescale/force": "mindlin_rescale_force",
}


@pytest.mark.parametrize("word", SPRINGS)
def test_mindlin_variants(word: str) -> None:
    """Law: kt xt mu, with kt NULL behind a material; kt is multiplied by the contact radius."""
    found = law(f"* * hertz 2e6 5e5 tangential {word} 4e5 0.7 0.5")
    assert (found.tangential_stiffness, found.friction) == ("mindlin", SPRINGS[word])
    assert {c: float(found.coefficients[c][0, 0]) for c in ("shear_stiffness", "xt", "mu")} == {"shear_stiffness": 4e5, "xt": 0.7, "mu": 0.5}
    material = law(f"* * hertz/material 1e7 0.5 0.3 tangential {word} NULL 1.0 0.5")
    assert material.coefficients["shear_stiffness"] == pytest.approx(8e7 / 8.84, rel=1e-14)


def test_rolling_and_twisting() -> None:
    """Law: k gamma mu of rolling sds and of twisting sds, each mixed by the geometric mean; marshall takes those of the tangential model."""
    found = law(f"1 1 {HERTZ} rolling sds 1e3 0.1 0.2 twisting sds 4.0 0.5 1e-4", f"2 2 {HERTZ} rolling sds 9e3 0.9 0.8 twisting sds 1.0 2.0 4e-4")
    assert (found.rolling, found.twisting) == ("sds", "sds")
    mixed = {name: float(table[0, 1]) for name, table in found.coefficients.items() if name.startswith(("rolling", "twisting"))}
    assert mixed == pytest.approx(
        {
            "rolling_stiffness": 3e3, "rolling_damping": 0.3, "rolling_friction": 0.4,
            "twisting_stiffness": 2.0, "twisting_damping": 1.0, "twisting_friction": 2e-4,
        }
    )  # fmt: skip
    marshall = wall(f"{HERTZ} twisting marshall rolling none")
    assert (marshall.rolling, marshall.twisting) == ("none", "marshall")
    assert marshall.coefficients["shear_stiffness"] == pytest.approx(5e5)
    loose = law("* * hooke 1e4 50 tangential linear_nohistory 0.7 0.5 twisting marshall")
    assert not loose.coefficients["shear_stiffness"].any()


STEP_LAW = '''"""Spring whose loss is told with every step. Source: this test."""


def step(overlap: float, vn: float, meff: float, dt: float, kn: float, restitution: float) -> tuple[float, float, float]:
    """Mean force, shift, loss."""
    return kn * overlap, 0.0, 0.0


def energy(overlap: float, kn: float) -> float:
    """Elastic energy."""
    return 0.5 * kn * overlap * overlap
'''


@pytest.fixture
def stepping(tmp_path: Path) -> Iterator[None]:
    """The folder of contact laws with a step law in it, for the length of a test."""
    (tmp_path / "normal_stepping.py").write_text(STEP_LAW)
    contact.__path__.append(str(tmp_path))
    importlib.invalidate_caches()
    yield
    contact.__path__.remove(str(tmp_path))
    sys.modules.pop("demsolver.contact.normal_stepping", None)


@pytest.mark.usefixtures("stepping")
@pytest.mark.parametrize("damping", ["", "damping none"])
def test_a_step_law_has_no_damping_number(damping: str) -> None:
    """Law: the numbers of a step law are its coefficients and nothing else, mixed as all; its damping is none, and so is that of its friction."""
    rubbing = f"tangential linear_history 3e3 0.0 0.5 {damping}"
    found = law(f"1 1 stepping 1e4 0.9 {rubbing}", f"2 2 stepping 4e4 0.4 {rubbing}")
    assert (found.normal, found.damping, found.tangential_damping, found.friction) == ("stepping", "none", "none", "rotated_history")
    assert found.coefficients["kn"][0, 1] == pytest.approx(2e4)
    assert found.coefficients["restitution"][0, 1] == pytest.approx(0.6)
    assert wall(f"stepping 1e4 0.9 {rubbing}").coefficients["restitution"] == pytest.approx(0.9)


@pytest.mark.usefixtures("stepping")
def test_a_step_law_runs_from_a_deck(tmp_path: Path) -> None:
    """Law: two spheres meet on a step law of a linear spring and part after pi sqrt(m*/k) as fast as they met."""
    deck = tmp_path / "in.lammps"
    deck.write_text("""units si
atom_style sphere
boundary f f f
region box block -0.1 0.1 -0.1 0.1 -0.1 0.1
create_box 1 box
create_atoms 1 single -0.01 0 0
create_atoms 1 single 0.01 0 0
set type 1 diameter 0.02 density 2500
set atom 1 vx 0.1
set atom 2 vx -0.1
pair_style granular
pair_coeff * * stepping 1e4 1.0 tangential linear_nohistory 0 0
timestep 1e-6
fix n all nve/sphere
run 3000
""")
    run = execute("native", "native", Job(deck, tmp_path / "out", every=10), keep=True)
    x = np.array([frame.columns["x"] for frame in run.frames])
    v = np.array([frame.columns["vx"] for frame in run.frames])
    contact_time = pi * (0.5 * 2500 * 4 / 3 * pi * 0.01**3 / 1e4) ** 0.5
    apart = np.flatnonzero(x[1:, 1] - x[1:, 0] > 0.02)[0] + 1
    assert 1e-5 * apart == pytest.approx(contact_time, abs=2e-5)
    assert v[-1] == pytest.approx([-0.1, 0.1], rel=1e-3)  # the force jumps by k v dt in the steps of touching and parting


WRONG = {
    f"{JKR} limit_damping": r"^in.case:2: pair_coeff limit_damping does not go with the cohesive normal model jkr",
    f"{JKR} damping tsuji": "damping tsuji does not go with the cohesive normal model jkr",
    f"{JKR.replace('jkr', 'dmt')} damping coeff_restitution": "damping coeff_restitution does not go with the cohesive normal model dmt",
    "jkr 1e7 50 0.3 tangential mindlin NULL 1 0.5": "surface energy must be a number, got 'tangential'",
    "jkr 1e7 50 0.3 -1 tangential mindlin NULL 1 0.5": "surface energy must be at least 0, got -1",
    "jkr 0 50 0.3 1 tangential mindlin NULL 1 0.5": "Young's modulus must be positive, got 0",
    "dmt 1e7 50 0.7 1 tangential mindlin NULL 1 0.5": "Poisson's ratio must be from -0.99 to 0.5, got 0.7",
    "hertz 2e6 5e5 tangential mindlin_rescale NULL 1 0.5": "kt NULL needs a normal model with material constants: dmt, jkr, hertz/material",
    "hertz 2e6 5e5 tangential mindlin_rescaled 1 1 0.5": "tangential model 'mindlin_rescaled' is not one of .*mindlin_rescale/force",
    f"{HERTZ} rolling cdt 0.1": "rolling model 'cdt' is not one of none, sds",
    f"{HERTZ} rolling sds 1e3 0.1": "(ends where )?mu of rolling sds (was expected|must be a number, got 'zplane')",
    f"{HERTZ} rolling sds -1 0.1 0.1": "k of rolling sds must be at least 0, got -1",
    f"{HERTZ} twisting epsd 1": "twisting model 'epsd' is not one of none, marshall, sds",
    f"{HERTZ} twisting sds 1 NULL 1": "gamma of twisting sds must be a number, got 'NULL'",
    f"{HERTZ} twisting marshall 1": "keyword '1' is not one of damping, tangential, rolling, twisting, limit_damping, cutoff",
    f"{HERTZ} damping none": "damping none is for laws of this solver alone",
    "stepping 1e4 1.5 tangential linear_nohistory 0 0": "restitution must be from 0 to 1, got 1.5",
    "stepping 1e4 0 tangential linear_nohistory 0 0": "restitution must be positive, got 0",
    "stepping -1 0.5 tangential linear_nohistory 0 0": "kn must be at least 0, got -1",
    "stepping 1e4 0.5 400 tangential linear_nohistory 0 0": "keyword '400' is not one of damping",
    "stepping 1e4 0.5 tangential linear_nohistory 0 0 damping velocity": "normal model stepping holds all damping in its step: damping must be none",
    "stepping 1e4 0.5 tangential linear_nohistory 0 0 limit_damping": "so there is none for limit_damping",
    "stepping 1e4 0.5 tangential linear_history 3e3 0.5 0.2": "so there is none for xt = 0.5 of the tangential model",
}


@pytest.mark.usefixtures("stepping")
@pytest.mark.parametrize("words", WRONG)
def test_wrong_words(words: str) -> None:
    """Law: one line with the place, what is wrong, and what was expected; the same for a wall."""
    for build in (lambda: law(f"* * {words}"), lambda: wall(words)):
        with pytest.raises(InputError, match=WRONG[words].replace("^in.case:2: pair_coeff", "")) as caught:
            build()
        assert "\n" not in str(caught.value)


def test_unlike_models_do_not_mix() -> None:
    """Law: pairs without numbers of their own need equal models: the message names both."""
    with pytest.raises(InputError, match=r"pair_coeff 1 2 is missing and cannot be mixed: hertz .* sds none is not hertz .* none none"):
        law(f"1 1 {HERTZ} rolling sds 1 1 1", f"2 2 {HERTZ}")
    with pytest.raises(InputError, match=r"Poisson's ratios -0.2 and 0.3 have no geometric mean"):
        law("1 1 jkr 1e7 50 -0.2 2.0 tangential mindlin NULL 1.0 0.5", f"2 2 {JKR}")
    with pytest.raises(InputError, match="pair_coeff 1 2 has other models than pair_coeff 1 1"):
        law(f"1 1 {HERTZ} twisting marshall", f"2 2 {HERTZ} twisting marshall", f"1 2 {HERTZ}")

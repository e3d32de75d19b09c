"""The linear answer of every contact law there is: what its own functions say of it."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from demsolver import contact, stability_laws
from demsolver.stability_laws import MOTIONS, Encounter, LinearLaw
from tests.support.laws import EVERY, VALUES, contact_law, every_law

RADIUS, MASS, OVERLAP = 5e-3, 1.3e-3, 5e-5
PAIR = Encounter(0, OVERLAP, RADIUS, RADIUS, 0.5 * RADIUS, 0.5 * MASS, 0.7 * MASS * RADIUS**2)
WALL = Encounter(0, OVERLAP, RADIUS, inf, RADIUS, MASS, 1.4 * MASS * RADIUS**2)
STEPPING = [name for name in contact.listing("normal") if contact.is_step_law(name) or contact.is_implicit(name)]


@pytest.mark.parametrize("state", [PAIR, WALL], ids=["pair", "wall"])
@pytest.mark.parametrize(("family", "name"), EVERY)
def test_the_normal_stiffness_is_the_second_derivative_of_the_energy(family: contact.Family, name: str, state: Encounter) -> None:
    """Law: k = d2E/d(overlap)2, the force = dE/d(overlap), for every law; a step law has no spring."""
    law = LinearLaw(every_law(family, name), 1e-6)
    found = law.answers([state])
    h = 1e-2 * OVERLAP
    before, here, after = (law.energy(state, OVERLAP + d) for d in (-h, 0.0, h))
    if family == "normal" and name in STEPPING:
        assert found.stiffness[0, 0] == 0.0
        return
    # differences of order h^2 of laws like overlap^(5/2): 1e-4 times a number below 1
    assert found.force[0] == pytest.approx((after - before) / (2 * h), rel=1e-4)
    assert found.stiffness[0, 0] == pytest.approx((after - 2 * here + before) / h**2, rel=1e-4)


@pytest.mark.parametrize(("family", "name"), EVERY)
def test_springs_and_dashpots_never_push_on(family: contact.Family, name: str) -> None:
    """Law: no law drives a motion: every stiffness and every damping is at least 0 and finite (cohesion may soften a spring, not here)."""
    found = LinearLaw(every_law(family, name), 1e-6).answers([PAIR, WALL])
    assert np.isfinite(found.stiffness).all()
    assert (found.stiffness >= 0.0).all()
    assert (found.damping >= 0.0).all()


def test_what_the_laws_say_of_their_coefficients() -> None:
    """Law: the answers are the coefficients, where a formula is that simple: springs, dashpots, rolling and twisting ones too."""
    v = VALUES
    law = contact_law(
        damping="velocity", tangential_damping="absolute", rolling="sds", twisting="sds",
    )  # fmt: skip
    found = LinearLaw(law, 1e-6).answers([PAIR])
    reff = PAIR.reff
    assert found.stiffness[0] == pytest.approx([v["kn"], v["shear_stiffness"], v["rolling_stiffness"] * reff**2, v["twisting_stiffness"]], rel=1e-9)
    assert found.damping[0] == pytest.approx([v["gamman"], v["gammat"], v["rolling_damping"] * reff**2, v["twisting_damping"]], rel=1e-9)


@pytest.mark.parametrize(("rolling", "spring"), [("cdt", False), ("primer", False), ("epsd", True), ("epsd2", True), ("sds", True)])
def test_a_torque_of_constant_size_is_no_spring(rolling: str, spring: bool) -> None:
    """Law: constant directional torque jumps with the direction of the spin and has no linear answer; an elastic-plastic one has a spring."""
    found = LinearLaw(contact_law(rolling=rolling), 1e-6).answers([PAIR])
    assert (found.stiffness[0, MOTIONS.index("rolling")] > 0.0) == spring


@pytest.mark.parametrize("friction", contact.listing("friction"))
def test_without_friction_nothing_sticks(friction: str) -> None:
    """Law: at mu = 0 a tangential spring never carries, so it limits nothing; at any other mu a small shift does not slip."""
    names = {"friction": friction, "tangential_damping": "absolute"}
    for mu in (0.0, 1e-6, 0.4):
        found = LinearLaw(contact_law(values={"mu": mu}, **names), 1e-6).answers([PAIR])
        assert (found.stiffness[0, 1] + found.damping[0, 1] > 0.0) == (mu > 0.0)


def test_compiled_answers_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: from MANY states on the law is compiled; the answers stay to the rounding of a difference."""
    names = {"normal": "jkr", "damping": "viscoelastic", "tangential_stiffness": "mindlin", "tangential_damping": "scaled"}
    law = LinearLaw(contact_law(values={"gamman": 2e6}, **names, rolling="epsd", twisting="marshall"), 1e-6)
    plain = law.answers([PAIR, PAIR])
    assert (plain.stiffness > 0.0).all()
    monkeypatch.setattr(stability_laws, "MANY", 2)
    compiled = law.answers([PAIR, PAIR])
    for one, other in ((plain.force, compiled.force), (plain.stiffness, compiled.stiffness), (plain.damping, compiled.damping)):
        # rounding of a force of 0.5 over SMALL of its overlap
        assert other == pytest.approx(one, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("name", ["hooke", "hertz", "dmt", "jkr"])
def test_the_overlap_of_an_energy_has_that_energy(name: str) -> None:
    """Law: the energy at overlap_of(E) is E; an energy that is never reached has none."""
    law = LinearLaw(every_law("normal", name), 1e-6)
    for energy in (1e-9, 1e-6, 1e-3):
        assert law.energy(PAIR, law.overlap_of(PAIR, energy)) == pytest.approx(energy, rel=1e-9)
    soft = LinearLaw(contact_law(values={"kn": 0.0}, friction="none"), 1e-6)
    assert soft.overlap_of(PAIR, 1.0) == inf

"""The parts on limits: what they predict and measure, and that their claims are computed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver.stability_contacts import contacts_of
from demsolver.stability_packing import packing_limit
from demverify.stability import limits, limits_laws, limits_packing, limits_plane
from demverify.stability.held import INTEGRATORS, KN, MASS, OVERLAP, RADIUS, Longest
from demverify.stability.limits import Sweep, hertz_cases, linear_cases, predicted

CASES = {f"{case.name}, {case.where}": case for case in (*linear_cases(), *hertz_cases())}
FORMS = {form.name: form for form in limits_laws.FORMS}


@pytest.mark.parametrize("name", CASES)
def test_the_motion_that_is_disturbed_rules(name: str) -> None:
    """Law: in each case the motion that is disturbed has the shortest step, also in the packing's eigenvalue, where nothing else may rule unseen."""
    case = CASES[name]
    scene = case.make(1e-6)
    found = predicted(scene, case.motion, case.where)
    assert (found.stiffness > 0.0, found.damping > 0.0) == ("spring" in name, "damper" in name or "drag" in name)
    # a normal force that turns adds overlap/distance of its stiffness to the tangential one
    assert packing_limit(scene, contacts_of(scene)).combined == pytest.approx(found.combined, rel=2e-3)


def test_every_motion_and_kind_is_there() -> None:
    """Law: normal, tangential, rolling, twisting; spring, damper, both; wall and pair; drag; Hertz."""
    assert {case.motion for case in linear_cases()} == {"normal", "tangential", "rolling", "twisting", "drag"}
    assert len(linear_cases()) == 4 * 3 * 2 + 1
    assert len(hertz_cases()) == 4


@pytest.mark.parametrize("name", FORMS)
def test_the_other_laws_rule_their_motion(name: str) -> None:
    """Law: each law sets the limit of the motion that it is named for; raises if not. rolling epsd: kr = 9/4 kn mu^2 R^2 with mu = 2,
    over the arm to the middle of the overlap."""
    case = FORMS[name].case()
    found = predicted(case.make(1e-6), case.motion, case.where)
    stiffness = {"normal": KN, "tangential": 2.0 * KN, "rolling": 9.0 * KN * RADIUS**2 / (1.0 - 0.5 * OVERLAP / RADIUS)}[case.motion]
    assert found.stiffness == pytest.approx(stiffness, rel=1e-5)  # differences of forces


def test_another_motion_that_rules_is_refused() -> None:
    """Law: a case whose motion does not set the step would measure another limit than it says."""
    case = next(case for case in linear_cases() if case.name == "tangential spring")
    with pytest.raises(ValueError, match="the tangential motion rules, not the normal one"):
        predicted(case.make(1e-6), "normal", case.where)


def sweeps(ratio: float) -> list[Sweep]:
    """The spring at a wall, whose measured limits are so many times the predicted ones, of Euler; of Verlet as predicted."""
    case = linear_cases()[0]
    limit = predicted(case.make(1e-6), case.motion, case.where)
    found = [Longest(part * limit.combined, part * limit.combined, np.array([[limit.combined, 1.0]])) for part in (1.0, ratio)]
    return [Sweep(case, name, limit, one) for name, one in zip(INTEGRATORS, found, strict=True)]


@pytest.mark.parametrize(("ratio", "came_out"), [(1.0, True), (1.029, True), (0.971, True), (1.031, False), (0.969, False)])
def test_a_limit_that_is_off_turns_the_verdict(ratio: float, came_out: bool) -> None:
    """Law: within 3 % either way, of each integrator by itself, and of one against the other."""
    verlet, euler, same = limits.finding("title", sweeps(ratio), 1e-3, []).claims
    assert verlet.came_out
    assert (euler.came_out, same.came_out) == (came_out, came_out)
    assert not (euler.why or same.why)


def test_the_spring_limits_are_the_closed_forms() -> None:
    """Law: 2 sqrt(m/k) with m, m/2; 2/7 of them in the tangential motion at 2 k; 2/5 m R^2 for a spin."""
    step = {name: predicted(case.make(1e-6), case.motion, case.where).combined for name, case in CASES.items()}
    assert step["normal spring, wall"] == pytest.approx(2.0 * np.sqrt(MASS / KN))
    assert step["normal spring, pair"] == pytest.approx(2.0 * np.sqrt(0.5 * MASS / KN))
    assert step["tangential spring, wall"] == pytest.approx(2.0 * np.sqrt(2 / 7 * MASS / (2.0 * KN)))
    assert step["rolling spring, wall"] == pytest.approx(2.0 * np.sqrt(0.4 * MASS * RADIUS**2 / (4.0 * KN * RADIUS**2)))
    assert step["viscous drag, no contact"] == pytest.approx(2.0 * MASS / 5.0)


@pytest.mark.parametrize("law", limits_packing.LAWS)
def test_two_spheres_between_walls_have_their_closed_form(law: str) -> None:
    """Law: without friction the larger root of two masses on three springs, [[2 k/m1, -k/sqrt(m1 m2)], [., 2 k/m2]]; friction shortens the step."""
    scene = limits_packing.made(2, law)(1e-6)
    a, b = scene.particles.mass
    matrix = KN * np.array([[2.0 / a, -1.0 / np.sqrt(a * b)], [-1.0 / np.sqrt(a * b), 2.0 / b]])
    closed = 2.0 / np.sqrt(np.linalg.eigvalsh(matrix)[-1])
    found = packing_limit(scene, contacts_of(scene)).undamped
    # the normal force that turns adds overlap/distance, 1e-6, and nothing along the row
    assert found == pytest.approx(closed, rel=1e-5) if "friction" not in law else found <= closed * (1 + 1e-5)


def test_a_packing_that_is_off_turns_the_verdict() -> None:
    """Law: each size has its claim; one limit 4 % off spoils that of its size alone, as does an integrator that is missing."""
    kept = [limits_packing.sweep(n, "springs", name, 1e-2, 500) for n in (2, 10) for name in INTEGRATORS]
    assert all(claim.came_out for claim in limits_packing.finding(kept).claims)
    spoilt = [*kept[:3], replace(kept[3], predicted=1.04 * kept[3].predicted)]
    assert [claim.came_out for claim in limits_packing.finding(spoilt).claims] == [True, False, True]
    assert not limits_packing.agreement(2, kept[:1]).came_out


@pytest.mark.parametrize("quick", [True, False])
def test_no_point_of_the_plane_lies_on_the_boundary(quick: bool) -> None:
    """Law: points keep off K + 2 H = 4 and H = 2 by what 2,000 steps can tell apart, and lie on both sides."""
    K, H = limits_plane.points(quick)
    margin = limits_plane.inside(K, H)
    assert (np.abs(margin) > 0.04).all()
    assert 20 < (margin > 0.0).sum() < len(margin) - 20


def test_a_point_that_does_something_else_turns_the_verdict() -> None:
    """Law: claims of the plane are computed: one point on the wrong side, or a boundary that is off by 4 % in the step, each spoil theirs."""
    K, H = limits_plane.points(quick=True)
    edge = np.array([[4.0, 0.0], [2.0, 1.0]])
    good = limits_plane.Plane("velocity Verlet", K, H, limits_plane.inside(K, H) > 0.0, edge)
    assert [claim.came_out for claim in limits_plane.finding([good]).claims] == [True, True]
    flipped = replace(good, holds=good.holds ^ (np.arange(len(K)) == 3))
    assert [claim.came_out for claim in limits_plane.finding([flipped]).claims] == [False, True]
    far = replace(good, edge=edge * [1.04**2, 1.04])
    assert [claim.came_out for claim in limits_plane.finding([far]).claims] == [True, False]

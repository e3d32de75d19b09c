"""The study of the paper: closed forms derived anew, readings that decide, small runs, and verdicts that hang on the numbers."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from itertools import islice
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from demsolver import contact
from demverify.studies import Claim, _fujioka_sliding
from demverify.studies import _fujioka_models as models
from demverify.studies._fujioka_bounces import contacts, dropped, shot, steps_in_contact
from demverify.studies._fujioka_cost import COUNTS, HEIGHTS, STEPS, cost_claims, steps_claims
from demverify.studies._fujioka_hole import error, hole_claims, hole_finding, worst
from demverify.studies._fujioka_impacts import WANTED, fast_claims, fast_finding, slow_claims, slow_finding
from demverify.studies._fujioka_models import DIAMETER, MODELS, PAPER, STIFFNESS
from demverify.studies._fujioka_portraits import mode, portrait_claims, portrait_finding
from demverify.studies._fujioka_sliding import final_speed, height_at_parting, order, parting_time, slide, sliding_claims, sliding_findings

BY_NAME = {model.name: model for model in MODELS}


def rigid_sliding() -> tuple[float, float, float]:
    """(k, d', T0) of rigid spheres, by integrating Lagrange's equation to the moment where the force between vanishes; r0 = g = m = 1.

    The line of centres stands at theta over the horizontal: h = 2 sin, d = 2 cos of it; kinetic energy M theta'^2, M = 2 cos^2 + 4 sin^2,
    potential 2 sin. The lower sphere is pushed by the contact alone, so the force vanishes with d''."""

    def turning(theta: float, rate: float) -> float:
        return (-2.0 * cos(theta) - 4.0 * sin(theta) * cos(theta) * rate * rate) / (2.0 * (2.0 * cos(theta) ** 2 + 4.0 * sin(theta) ** 2))

    def push(_: float, y: np.ndarray) -> float:
        return float(-2.0 * (cos(y[0]) * y[1] ** 2 + sin(y[0]) * turning(y[0], y[1])))

    push.terminal, push.direction = True, -1.0  # type: ignore[attr-defined]
    motion = solve_ivp(lambda _, y: (y[1], turning(y[0], y[1])), (0.0, 5.0), (pi / 3.0, 0.0), events=push, rtol=1e-12, atol=1e-14, method="DOP853")
    theta, rate = motion.y_events[0][0]
    return sin(theta), -2.0 * sin(theta) * rate / sqrt(4.0), float(motion.t_events[0][0])


def test_the_closed_forms_of_sliding() -> None:
    """Law: k, d' and T0 in closed form are those of the equation of motion of rigid spheres, and the numbers known for them."""
    found = rigid_sliding()
    assert found == pytest.approx((height_at_parting(), final_speed(), parting_time()), rel=1e-9)  # the integrator is asked for 1e-12 a step
    assert height_at_parting() ** 3 + 3.0 * height_at_parting() == pytest.approx(sqrt(3.0), rel=1e-15)
    assert (height_at_parting(), final_speed()) == pytest.approx((0.5282222885931581, 0.2714626510124395), rel=1e-14)
    assert parting_time() * sqrt(0.02 / 9.8) == pytest.approx(0.1067368724695617, rel=1e-14)


def at_rest_with_gravity_behind(name: str, steps: int = 20_000) -> float:
    """Share of steps in contact, in the end, of a sphere over a floor, gravity being added behind the step of the model; unit mass, step, g."""
    law, kn = contact.law("normal", name), STIFFNESS
    x, v, touched = 30.0, 0.0, 0
    for k in range(steps):
        force, shift, _ = law.step(-x, v, 1.0, 1.0, kn, models.RESTITUTION) if x < 0.0 else (0.0, 0.0, 0.0)
        touched += x < 0.0 and k >= steps // 2
        v += force
        x += v + shift
        v -= 1.0
    return 2.0 * touched / steps


def test_why_the_paper_counts_fewer_contacts() -> None:
    """Law: with gravity behind the step of the model F and P never rest: they touch in 0.20 and 0.38 of the steps; 1.9 as the printed counts."""
    older, newer = (at_rest_with_gravity_behind(name) for name in ("fujioka2005", "fujioka2006_printed"))
    assert (older, newer) == pytest.approx((0.20, 0.38), abs=0.005)
    assert newer / older == pytest.approx(COUNTS["P"] / COUNTS["F"], rel=0.02)


def test_which_stiffness_of_t_figure_5_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: with 4.66, the other reading of table 2, T gains energy in the first fast impact; with the one taken it does not."""
    first = [next(iter(contacts(shot(BY_NAME["T"], 0.01 * DIAMETER, 1e5, 1e-3), 1000))).ratio]
    monkeypatch.setattr(models, "HERTZ_STIFFNESS", 4.66)
    first.append(next(iter(contacts(shot(BY_NAME["T"], 0.01 * DIAMETER, 1e5, 1e-3), 1000))).ratio)
    assert first[0] < 1.0
    assert first[1] > 5.0


def test_bounces_of_the_mended_model() -> None:
    """Law: the energy ratio of a fast bounce is e^2 to the work of gravity in the contact, g dt over the speed; rest is found; contacts add up."""
    found = list(islice(contacts(shot(BY_NAME["P mended"], 0.01 * DIAMETER, 1e5, 1e-3, 9.8e3), 100_000), 3))
    assert [c.ratio for c in found] == pytest.approx([WANTED] * 3, abs=10 * 9.8e3 * 1e-3 / 1e5)
    assert all(c.states[0, 1] >= c.states[0, 0] > 0.0 for c in found)
    slow = list(contacts(dropped(BY_NAME["P mended"], 0.01 * DIAMETER, 1e-3), 20_000))
    assert len(slow) == 13
    last = steps_in_contact(dropped(BY_NAME["P mended"], 0.01 * DIAMETER, 1e-3), 10_000)
    # Bouncing takes t0 (1 + e)/(1 - e), all the rest of the 10 s the sphere lies still; 0.1 s for contacts whose e is not 0.7 any more.
    rest = 10.0 - sqrt(2.0 * 0.0225 * 100.0 / 9.8) * 1.7 / 0.3
    assert last * 1e-3 == pytest.approx(rest, abs=0.1)


def test_errors_of_sliding_fall() -> None:
    """Law: P mended comes to the closed form with an order of more than 1 in d', and T0 within a few steps."""
    coarse, fine = (slide(BY_NAME["P mended"], dt) for dt in (4e-4, 1e-4))
    assert abs(fine[0] / final_speed() - 1.0) < 0.25 * abs(coarse[0] / final_speed() - 1.0)
    assert abs(fine[1] - parting_time()) < 5 * 1e-4 / sqrt(0.02 / 9.8)


def test_the_hole_in_closed_form() -> None:
    """Law: the printed model errs as the closed form says, the nearest of 400 phases; the mended one not at all."""
    for a in (0.1, 1.0, 10.0):
        assert error(BY_NAME["P"], a) == pytest.approx(float(worst(np.array(a))), rel=1e-3)
        assert error(BY_NAME["P mended"], a) < 1e-12


def test_modes() -> None:
    """Law: lines s = 1, 0 and -sqrt(1 - a) part the modes; above a = 1 there is no mode 3."""
    assert [mode(s, 0.19) for s in (1.0, 0.99, 0.0, -0.9, -0.91)] == [1, 2, 3, 3, 4]
    assert [mode(s, 1.1) for s in (0.5, 0.0, -0.1)] == [2, 4, 4]


def test_the_order_of_an_error() -> None:
    """Law: the order is the slope in the logarithms from 1e-4 s down."""
    steps = np.array([1e-3, 1e-4, 1e-5, 1e-6])
    assert order(np.array([7.0, 1e-2, 1e-4, 1e-6]), steps) == pytest.approx(2.0, rel=1e-12)


# Numbers made by hand, for which it is known what comes out; each change must turn the verdict of just the statement it is about.
Numbers = dict[str, Any]


def slow() -> Numbers:
    """Figure 4 as the paper has it: eight early bounces and three late ones."""
    near, far, late = [0.489] * 8, [0.47] * 8, {"C": 0.4, "T": 0.4, "F": 0.42, "P": 0.43, "P mended": 0.43}
    return {name: {"ratio": (near if name[0] in "FP" else far) + [last] * 3, "steps": [3] * 11} for name, last in late.items()}


def fast() -> Numbers:
    """Figures 5 to 7 as the paper has them, but for C."""
    alone, pair = np.array([[0.2, 0.4]]), np.array([[0.43, 0.44], [0.55, 0.2], [0.2, -0.3]])
    exact = {"ratio": [0.49] * 8, "deepest": [0.6] * 8, "crosses the plane": True}
    return {
        "C": {"ratio": [0.5, 0.47] * 4, "deepest": [1.2, 0.9] * 4, "states": [pair] * 8, "steps": [10] * 8, "crosses the plane": True},
        "T": {"ratio": [0.7, 0.4] * 4, "deepest": [0.4] * 8, "states": [pair] * 8, "steps": [3, 4] * 4, "crosses the plane": False},
        "F": exact | {"states": [pair, alone] * 4, "steps": [3, 1] * 4},
        "P": exact | {"states": [pair] * 8, "steps": [3] * 8},
        "P mended": exact | {"states": [pair] * 8, "steps": [3] * 8},
    }


def cost() -> Numbers:
    """Table 1 as the paper has it."""
    counts = {"C": 187, "T": 126, "F": 56, "P": 107, "P mended": 107}
    each = {"C": 1.88e-6, "T": 1.91e-6, "F": 1.95e-6, "P": 1.96e-6, "P mended": 1.96e-6}
    total = {name: counts[name] * each[name] / 0.065 for name in counts}
    return {"steps": 50, "dt": 1.0, "evaluations": dict.fromkeys(HEIGHTS, counts), "total": total, "each": each}


def table_2() -> Numbers:
    """Table 2 as the paper has it."""
    found = {name: [(low, float(low), low) for low in printed] for name, printed in STEPS.items()}
    return {said: found | {"F": [(1, 1.5, 4)] * 3, "C": [(9, 9.8, 10)] * 3, "P mended": [(3, 3.0, 3)] * 3} for said in HEIGHTS}


def sliding() -> Numbers:
    """Figures 10 and 11 as the paper has them."""
    steps = np.array([1e-3, 1e-4, 1e-5])
    sizes = {"C": [1.0, 1e-3, 1e-3], "T": [5e-2, 5e-3, 5e-4], "F": [1e-3, 1e-4, 1e-5], "P": [2e-3, 2e-4, 2e-5], "P mended": [2e-3, 2e-4, 2e-5]}
    errors = {name: {"d'": np.array(size), "T0": -np.array(size)} for name, size in sizes.items()}
    return {"steps": steps, "exact": {"k": 0.5, "d'": 0.27, "T0": 0.1}, "errors": errors}


def hole() -> Numbers:
    """What comes out of the hole."""
    a = np.array([0.1, 1.0, 10.0])
    rows = {f"{at:g}": {"P": float(worst(np.array(at))), "P mended": 1e-15} for at in a}
    return {"a": a, "closed form": worst(a), "P": worst(a), "P mended": np.full(3, 1e-15), "named": rows}


def put(*path: object) -> Callable[[Numbers], None]:
    """Sets numbers[path...] = the last word."""

    def change(numbers: Numbers) -> None:
        *into, key, value = path
        for step in into:
            numbers = numbers[step]  # type: ignore[index]
        numbers[key] = value  # type: ignore[index]

    return change


T_MINUS = {"d'": np.array([5e-2, 5e-3, 5e-3]), "T0": np.array([5e-2, 5e-3, 5e-3])}
C_FALLS = {"d'": np.array([1.0, 1e-3, 1e-5]), "T0": np.array([1.0, 1e-3, 1e-5])}
C_FLAT = {"d'": np.array([2e-3, 1e-3, 1e-3]), "T0": np.array([2e-3, 1e-3, 1e-3])}
F_LARGE = {"d'": np.array([3e-3, 3e-4, 3e-5]), "T0": np.array([3e-3, 3e-4, 3e-5])}
P_LARGE = {"d'": np.array([6e-2, 6e-3, 6e-4]), "T0": np.array([6e-2, 6e-3, 6e-4])}
CASES: list[tuple[Callable[[Numbers], tuple[Claim, ...]], Numbers, tuple[bool, ...], list[tuple[int, Callable[[Numbers], None]]]]] = [
    (slow_claims, slow(), (True, True, False), [
        (0, put("F", "ratio", [0.46] * 11)), (0, put("T", "ratio", [0.4901] * 8)), (1, put("P", "ratio", [0.489] * 8 + [0.4] * 3)),
        (2, put("P", "ratio", [0.489] * 11)),
    ]),
    (fast_claims, fast(), (False, True, True), [
        (0, put("C", "ratio", [0.5])), (1, put("T", "ratio", [0.48, 0.49] * 4)), (1, put("T", "ratio", [0.7])),
        (2, put("P", "ratio", [0.45] * 8)), (2, put("F", "ratio", [0.45] * 8)),
    ]),
    (portrait_claims, fast(), (True, True, True, True, True), [
        (0, put("C", "deepest", [0.9] * 8)), (1, put("T", "states", [np.array([[0.4, 0.3]])])),
        (2, put("P", "states", [np.array([[0.2, 0.4], [0.5, 0.4]])])), (3, put("F", "states", [np.array([[0.2, 0.4], [0.1, -0.2]])])),
        (4, put("T", "steps", [2, 6] * 4)), (4, put("F", "steps", [3] * 8)),
    ]),
    (cost_claims, cost(), (True, True, True, True, True, True, True), [
        (0, put("evaluations", {"0.01 d": {"C": 700}, "1 d": cost()["evaluations"]["1 d"]})),
        (1, put("evaluations", "1 d", {"C": 187, "T": 126, "F": 120, "P": 107})), (2, put("total", "F", 1.0)), (3, put("each", "C", 9e-7)),
        (4, put("each", "T", 1.8e-6)), (5, put("each", "P", 2.2e-6)), (6, put("each", "F", 1.5e-6)),
    ]),
    (steps_claims, table_2(), (True, True, True), [
        (0, put("1 d", "T", [(13, 13.5, 13), (23, 23.0, 23), (37, 37.0, 37)])),
        (1, put("1 d", "T", [(14, 14.0, 24), (23, 23.0, 24), (26, 26.0, 37)])),
        (1, put("1 d", "C", [(9, 9.8, 10), (10, 10.0, 10), (10, 12.0, 13)])), (2, put("1 d", "P", [(3, 1.4, 3)] * 3)),
    ]),
    (lambda n: sliding_claims(n, "d'"), sliding(), (True, True, True, True, True, True), [
        (0, put("errors", "T", T_MINUS)), (1, put("errors", "P", P_LARGE)), (2, put("errors", "C", C_FALLS)), (3, put("errors", "C", C_FLAT)),
        (4, put("errors", "F", F_LARGE)), (5, put("errors", "P", P_LARGE)),
    ]),
    (lambda n: sliding_claims(n, "T0"), sliding(), (True, True, True, True, True), [
        (0, put("errors", "T", T_MINUS)), (1, put("errors", "P", P_LARGE)), (2, put("errors", "C", C_FALLS)), (3, put("errors", "F", F_LARGE)),
        (4, put("errors", "P", P_LARGE)),
    ]),
    (hole_claims, hole(), (False, True, True), [
        (0, put("P", np.full(3, 1e-15))), (1, put("P mended", np.full(3, 1e-9))), (2, put("P", 2.0 * worst(np.array([0.1, 1.0, 10.0])))),
    ]),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=["figure 4", "figure 5", "figures 6 and 7", "table 1", "table 2", "figure 10", "figure 11", "hole"])
def test_verdicts_follow_the_numbers(case: Any) -> None:
    """Law: for known numbers every verdict is as it must be, and a number that is altered turns the verdict of its statement."""
    claims, numbers, expected, changes = case
    assert tuple(claim.came_out for claim in claims(numbers)) == expected
    for which, change in changes:
        altered = deepcopy(numbers)
        change(altered)
        assert claims(altered)[which].came_out is not expected[which], (which, claims(altered)[which])


def test_known_failures_have_a_reason() -> None:
    """Law: the statements that are known not to come out say why; those that always should are left bare, so that a failure is seen."""
    assert all(claim.why for claim in (slow_claims(slow())[2], fast_claims(fast())[0], hole_claims(hole())[0]))
    assert not any(claim.why for claim in (slow_claims(slow())[0], fast_claims(fast())[2], steps_claims(table_2())[0], hole_claims(hole())[1]))


def test_figures_tell_what_they_show() -> None:
    """Law: every figure is one svg with a label and a name of its own, no number of it is not a number, and every model is in the legend."""
    findings = (
        slow_finding(slow()), fast_finding(fast()), portrait_finding(fast()), hole_finding(hole()), *sliding_findings(sliding()),
    )  # fmt: skip
    figures = [figure for finding in findings for figure in finding.figures]
    assert len({figure.name for figure in figures}) == len(figures) == 9
    for figure in figures:
        assert figure.svg.startswith('<svg class="plot" role="img" aria-label="')
        assert "nan" not in figure.svg.partition(">")[2]
    assert all(f">{name}</text>" in figures[0].svg for name in PAPER)


def test_what_stops_c(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: the error of C in d' stays as the step is made finer; with dashpots that may not pull (limit_damping) it falls with dt^2."""
    steps = (4e-5, 1e-5)
    pulling = [abs(slide(BY_NAME["C"], dt)[0] / final_speed() - 1.0) for dt in steps]
    monkeypatch.setattr(_fujioka_sliding, "law", lambda *words: replace(models.law(*words), limit_damping=True))
    limited = [abs(slide(BY_NAME["C"], dt)[0] / final_speed() - 1.0) for dt in steps]
    assert pulling[1] == pytest.approx(pulling[0], rel=0.15)
    assert limited[0] / limited[1] == pytest.approx(16.0, rel=0.05)

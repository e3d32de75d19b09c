"""What a page claims is computed: made-up rows of known order and cost in, verdicts out; rings in the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demverify.bench._contenders import Contender, Measure, Point, Problem, Row
from demverify.bench._page import Judged, claims_of
from demverify.report.axes import logarithmic
from demverify.report.charts import Series, chart

STEPS = np.geomspace(0.2, 0.002, 10)


def judged(*rows: tuple[Contender, np.ndarray, float]) -> Judged:
    """Rows of (contender, errors at STEPS, seconds of a step), in a problem whose unit is one second."""
    measure = Measure("energy", "energy", lambda scene, states: 0.0, energy=True)
    problem = Problem("none", "made up", {}, 1.0, 1.0, "a second", tuple(STEPS), (measure,), tuple(one for one, _, _ in rows), "none")
    made = [
        Row(one, tuple(Point(float(h), round(1 / h), (float(e),), cost / h, 0.0, 0.0) for h, e in zip(STEPS, errors, strict=True)))
        for one, errors, cost in rows
    ]
    return Judged(problem, made, 0)


@pytest.mark.parametrize(("size", "came_out"), [(4.0, True), (6.0, False)])
def test_what_chance_does_is_told_from_what_it_does_not(size: float, came_out: bool) -> None:
    """Law: off by four scatters is chance, by six it is not; at steps that are longer than those it is said of anything may be."""
    of = judged((Contender("one", 0), np.where(STEPS > 0.05, 1.0, 0.01 * size), 1e-6))
    measure = Measure("height", "height", lambda scene, states: 0.0, scatter=lambda: (0.01, 0.05))
    of = replace(of, problem=replace(of.problem, measures=(measure,)))
    (claim,) = claims_of(of, of.orders())
    assert claim.came_out is came_out
    assert "of 1 % each" in claim.found


@pytest.mark.parametrize(("power", "came_out"), [(2.0, True), (1.9, True), (1.0, False), (3.0, False)])
def test_an_order_that_theory_does_not_give_is_told(power: float, came_out: bool) -> None:
    """Law: a claim of order two comes out for errors of order two, within the leeway, and for no other."""
    of = judged((Contender("one", 0, orders={"energy": 2.0}), 0.3 * STEPS**power, 1e-6))
    (claim,) = claims_of(of, of.orders())
    assert claim.came_out is came_out
    assert not claim.why


@pytest.mark.parametrize(("cost", "came_out"), [(1e-6, True), (1e-4, True), (1e-2, True)])
def test_exact_energy_at_large_steps_is_on_the_front_whatever_it_costs_unless_somebody_is_as_exact(cost: float, came_out: bool) -> None:
    """Law: errors of rounding that nobody else reaches are on the front at any price."""
    exact = (Contender("exact", 1, exact=True), np.full(10, 1e-15), cost)
    of = judged((Contender("one", 0), 0.3 * STEPS**2, 1e-6), exact)
    (claim,) = claims_of(of, of.orders())
    assert claim.came_out is came_out


def test_exact_energy_that_others_reach_for_less_is_not_on_the_front() -> None:
    """Law: where another is as exact and cheaper, the claim fails, and has no reason of its own."""
    of = judged((Contender("one", 0), np.full(10, 1e-15), 1e-6), (Contender("exact", 1, exact=True), np.full(10, 1e-15), 1e-2))
    (claim,) = claims_of(of, of.orders())
    assert not claim.came_out
    assert not claim.why


def test_what_broke_is_on_no_front_and_has_no_order() -> None:
    """Law: a contender whose runs all broke has no order, and its claim says so."""
    of = judged((Contender("broken", 0, orders={"energy": 2.0}), np.full(10, np.inf), np.nan), (Contender("one", 1), 0.3 * STEPS**2, 1e-6))
    assert of.orders()[0] is None
    (claim,) = claims_of(of, of.orders())
    assert not claim.came_out
    assert [int(on.sum()) for on in of.fronts([row.seconds for row in of.rows])] == [0, 10]


def test_rings_are_drawn_where_they_are_asked_for() -> None:
    """Law: as many rings as marked points, none for a series without; NaN has none."""
    x = np.array([1.0, 2.0, 4.0])
    series = [Series("a", x, np.array([1.0, np.nan, 3.0]), 0, "both", np.array([True, True, False])), Series("b", x, x, 1, "both")]
    svg = chart("t", "l", series, (logarithmic(1.0, 4.0), logarithmic(1.0, 4.0)), ("x", "y"))
    assert svg.count("a5.2 5.2 0 1 0 10.4 0") == 1

"""The fitted order: errors of known order in, that order out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demverify.bench._orders import LEAST, fit_order

STEPS = np.geomspace(0.2, 0.002, 10)


@pytest.mark.parametrize("order", [1.0, 2.0, 2.5, 4.0])
def test_a_power_is_found_exactly(order: float) -> None:
    """Law: errors that are a power of the step have that order, without doubt, down to the shortest step."""
    found = fit_order(STEPS, 0.3 * STEPS**order)
    assert found is not None
    assert found.value == pytest.approx(order, abs=1e-10)  # rounding of logarithms
    assert found.half < 1e-8
    assert found.points >= 5  # which row is the narrowest is a matter of rounding here
    assert found.shortest == 0.002


@settings(deadline=None)
@given(st.floats(0.5, 4.0), st.floats(1e-3, 0.3), st.permutations(range(10)))
def test_neither_factor_nor_order_of_the_points_matters(order: float, factor: float, places: list[int]) -> None:
    """Law: the slope of a line hangs neither on its height nor on how the points are listed."""
    h = STEPS[places]
    found = fit_order(h, factor * h**order)
    assert found is not None
    assert found.value == pytest.approx(order, abs=1e-8)


def test_large_steps_that_follow_another_power_are_left_out() -> None:
    """Law: where the error goes over from order 3 to order 1 the asymptotic range, at the short end, gives 1."""
    found = fit_order(STEPS, 1e-3 * STEPS + 3.0 * STEPS**3)
    assert found is not None
    assert found.value == pytest.approx(1.0, abs=0.25)  # the other term is a tenth of the whole at the end of the range
    assert found.longest < 0.05


def test_a_floor_of_rounding_is_left_out() -> None:
    """Law: errors that no longer fall with the step do not count."""
    found = fit_order(STEPS, np.maximum(0.1 * STEPS**4, 1e-10))
    assert found is not None
    assert found.value == pytest.approx(4.0, abs=0.2)  # the last point before the floor is part of it already
    assert found.shortest > 0.005


def test_scatter_widens_the_interval_and_it_holds_the_order() -> None:
    """Law: of noisy errors of order 2 nearly 95 % of the intervals hold 2, for the row is chosen; here 90 % at least of 1,000."""
    rng = np.random.default_rng(1)
    fits = [fit_order(STEPS, 0.5 * STEPS**2 * np.exp(rng.normal(0.0, 0.1, 10))) for _ in range(1000)]
    assert all(one is not None and one.half > 0.01 for one in fits)
    assert sum(one is not None and one.within(2.0, 0.0) for one in fits) >= 900


@pytest.mark.parametrize("errors", [np.full(10, np.inf), np.full(10, np.nan), np.zeros(10), np.full(10, 0.5), np.full(10, 1e-15)])
def test_what_has_no_order(errors: np.ndarray) -> None:
    """Law: no number, nothing, too large an error, or one that hangs on nothing: no order."""
    assert fit_order(STEPS, errors) is None


def test_too_few_points() -> None:
    """Law: fewer than LEAST points give no order, LEAST do."""
    assert fit_order(STEPS[: LEAST - 1], 0.1 * STEPS[: LEAST - 1]) is None
    assert fit_order(STEPS[:LEAST], 0.1 * STEPS[:LEAST]) is not None

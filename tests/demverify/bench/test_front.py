"""The Pareto front and the cheapest way, by their definitions."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from demverify.bench._front import cheapest, front

POINTS = st.lists(st.tuples(st.sampled_from([1.0, 2.0, 3.0, 5.0, np.inf, np.nan]), st.sampled_from([1e-6, 1e-4, 1e-2, np.inf, np.nan])), max_size=12)


def columns(points: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Costs and errors."""
    table = np.array(points, dtype=float).reshape(-1, 2)
    return table[:, 0], table[:, 1]


@given(POINTS)
def test_the_front_is_who_nobody_beats(points: list[tuple[float, float]]) -> None:
    """Law: no point on the front is beaten; each finite point off it is beaten by one on it; what is not finite is never on it."""
    cost, error = columns(points)
    on = front(cost, error)
    known = np.isfinite(cost) & np.isfinite(error)
    assert not (on & ~known).any()

    def beats(a: int, b: int) -> bool:
        return bool(cost[a] <= cost[b] and error[a] <= error[b] and (cost[a] < cost[b] or error[a] < error[b]))

    indices = np.flatnonzero(known)
    for b in indices:
        assert on[b] != any(beats(a, b) for a in indices)
        assert on[b] or any(on[a] and beats(a, b) for a in indices)


@given(POINTS, st.sampled_from([1e-7, 1e-5, 1e-3, 1.0]))
def test_the_cheapest_is_good_enough_and_on_the_front_of_those(points: list[tuple[float, float]], target: float) -> None:
    """Law: the cheapest is within the target and nobody within it costs less; none only where nobody is within it."""
    cost, error = columns(points)
    good = [k for k in range(len(points)) if np.isfinite(cost[k]) and error[k] <= target]
    found = cheapest(cost, error, target)
    assert (found is None) == (not good)
    if found is not None:
        assert found in good
        assert cost[found] == min(cost[k] for k in good)

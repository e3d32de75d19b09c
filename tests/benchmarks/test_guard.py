"""The benchmark of the guard: its figures are of the same motion, and it judges them by its limit."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.guard import LIMIT, Cost, cost_of
from demverify.stability.held import linear, on_floor

COST = Cost("ball", 1, 1000, (1.01, 1.0, 1.02, 1.01), (1.0, 1.0, 1.0, 1.0), same=True)


def test_a_ball_on_a_floor() -> None:
    """Law: with and without a guard the bits are the same; there is a ratio of each turn."""
    found = cost_of("ball", on_floor(1e-5, linear((1,), mu=0.0), pull=9.81), 2, 1e-3)
    assert found.same
    assert len(found.guarded) == len(found.twin) == 2
    assert min(*found.guarded, *found.twin) > 0.0
    assert "the same bits" in found.line


def test_what_is_too_much() -> None:
    """Law: the median counts, above the limit and beyond what the machine can tell."""
    assert not COST.too_much
    dear = replace(COST, guarded=(1.0 + 2.0 * LIMIT,) * 4)
    assert dear.too_much
    assert not replace(dear, twin=(1.0 - 2.0 * LIMIT,) * 4).too_much
    assert "guard +4.00%" in dear.line

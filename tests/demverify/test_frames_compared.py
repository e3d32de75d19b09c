"""Which steps a comparison looks at."""

from __future__ import annotations

import pytest

from demverify.runs import frame_interval


@pytest.mark.parametrize(("steps", "particles"), [(1000, 32_000), (100, 32_000), (300_000, 3), (1_000_000, 2), (10_000, 10_000)])
def test_the_last_step_is_compared(steps: int, particles: int) -> None:
    """A dump holds multiples of its interval only: the interval divides the run, or its end would never be compared."""
    assert steps % frame_interval(steps, particles) == 0


@pytest.mark.parametrize(("steps", "particles"), [(1009, 32_000), (0, 5), (1, 5), (7919, 1)])
def test_any_number_of_steps_has_an_interval(steps: int, particles: int) -> None:
    """A prime number of steps has no such divisor: the interval is a whole number of one or more, and frames stay few."""
    every = frame_interval(steps, particles)
    assert every >= 1
    assert steps // every <= 200


@pytest.mark.parametrize(("steps", "particles"), [(5000, 32_000), (100_000, 1000), (200_000, 2)])
def test_longer_runs_have_frames_within_tier_two(steps: int, particles: int) -> None:
    """Law: of a run that fits into memory so, some frames fall within the first 200 steps."""
    assert frame_interval(steps, particles) <= 200

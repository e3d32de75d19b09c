"""A motion that comes a second time."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.motion_repeated import measure
from tests.support.law_frames import frame, off


def motion(steps: list[int], wrong: float = 0.0):
    """Frames of steps; where the steps have gone back, spins are off by `wrong`."""
    frames, back = [], False
    for before, k in zip([-1, *steps], steps, strict=False):
        back |= k < before
        x = np.array([[0.1 * k, 0.0, 0.0], [0.0, 1.0, 0.2 * k]])
        frames.append(frame(k, x, 0.1 * x, (1.0 + wrong * back) * (1.0 + x)))
    return frames


def test_the_second_time_is_compared_with_the_first():
    """Law: same state, same motion; what differs the second time is found, relative to the largest of its kind."""
    steps = [0, 1, 2, 3, 1, 2, 3]
    assert max(off(measure(motion(steps))).values()) == 0.0
    missed = off(measure(motion(steps, 1e-3)))
    assert missed["spin the second time"] == pytest.approx(1e-3)
    assert missed["position the second time"] == 0.0


@pytest.mark.parametrize("steps", [[0, 1, 2, 3], [0], [0, 2, 2, 4]])
def test_a_motion_without_a_way_back_is_refused(steps):
    """Law: nothing repeated, nothing shown."""
    with pytest.raises(LookupError, match="never go back"):
        measure(motion(steps))


def test_steps_that_meet_no_other_show_nothing():
    """Law: the same."""
    with pytest.raises(LookupError, match="no step comes twice"):
        measure(motion([0, 2, 4, 1, 3]))

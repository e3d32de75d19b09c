"""Newton's cradle."""

from __future__ import annotations

import pytest

from demverify.laws.cradle import measure
from tests.support.law_frames import frame, off

ROW = [[k, 0, 0] for k in range(4)]


def rows(after):
    return [frame(0, ROW, [[2.0, 0, 0], [1.0, 0, 0], [0, 0, 0], [0, 0, 0]]), frame(9, ROW, [[v, 0, 0] for v in after])]


def test_the_fastest_ends_in_front():
    """Law: velocities are swapped until they are sorted."""
    assert max(off(measure(rows([0.0, 0.0, 1.0, 2.0]))).values()) == 0.0


def test_momentum_that_is_shared_is_seen():
    """Law: 0.1 left behind of 2 is 5 %."""
    assert off(measure(rows([-0.1, 0.1, 1.0, 2.0])))["velocities passed on"] == pytest.approx(0.05)

"""Motion that runs back."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.motion_reversed import measure
from tests.support.law_frames import frame, off


def there_and_back(miss: float = 0.0):
    x, v = np.array([[0.0, 1.0, 2.0]]), np.array([[1.0, -2.0, 0.5]])
    return [frame(0, x, v), frame(1, x + v, v), frame(2, x + miss, -v)]


def test_the_way_back():
    """Law: x(end) = x(0), v(end) = -v(0)."""
    assert max(off(measure(there_and_back())).values()) < 1e-15


def test_a_miss_is_seen():
    """Law: a miss of 0.1 on a way of 2 is 5 %."""
    assert off(measure(there_and_back(0.1)))["positions after the return"] == pytest.approx(0.05)

"""Impacts before and after their turning point."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.time_symmetry import measure
from tests.support.law_frames import frame, off


def bounce(slow: float = 1.0):
    """Distance 1 + t^4/4 + t^2 about t = 0; `slow` takes from the speed afterwards."""
    frames = []
    for k, t in enumerate(np.arange(-0.51, 0.53, 0.02)):
        s = t * (slow if t > 0 else 1.0)
        frames.append(frame(k, [[0, 0, 0], [1 + s * s + s**4 / 4, 0, 0]], [[0, 0, 0], [(2 * s + s**3) * (slow if t > 0 else 1.0), 0, 0]]))
    return frames


def test_an_even_path_is_symmetric():
    """Law: d(T + s) = d(T - s), d'(T + s) = -d'(T - s)."""
    assert max(off(measure(bounce(), 0.02)).values()) < 1e-5


def test_a_slower_return_is_seen():
    """Law: with s' = 0.9 s the return is 1 - 0.9^2 shorter in s^2."""
    assert off(measure(bounce(0.9), 0.02))["distance before and after"] == pytest.approx(0.19, rel=0.1)

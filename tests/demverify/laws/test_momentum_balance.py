"""Momentum and gravity."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.momentum_balance import measure
from tests.support.law_frames import frame, off

X, V, M = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 0.0]]), np.array([[1.0, 0.0, 0.5], [-2.0, 1.0, 0.0]]), np.array([1.0, 3.0])
G = 6.0 * np.array([1.0, -2.0, -2.0]) / 3.0


def fall(extra: float = 0.0):
    times = 0.1 * np.arange(5)
    return [frame(k, X + V * t + 0.5 * G * t * t, V + (1.0 + extra) * G * t, mass=M) for k, t in enumerate(times)]


def test_free_fall_keeps_the_balance():
    """Law: P = P0 + M g t and R = R0 + V0 t + g t^2/2."""
    assert max(off(measure(fall(), 0.1, 6.0, 1.0, -2.0, -2.0)).values()) < 1e-14


def test_gravity_that_is_too_strong_is_seen():
    """Law: of momenta 1 % of M g t more are 1 % of M g t more."""
    found = measure(fall(0.01), 0.1, 6.0, 1.0, -2.0, -2.0)[0]
    assert found.measured == pytest.approx(0.01 * 4.0 * 4.0 * 0.4, rel=1e-12)

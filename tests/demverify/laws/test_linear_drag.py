"""Falling under linear drag."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.linear_drag import measure
from tests.support.law_frames import frame, off


def falling(drag: float):
    c, m, g = drag, 2.0, np.array([0.0, 0.0, -9.81])
    v0 = np.array([1.0, -0.5, 2.0])
    frames = []
    for k in range(50):
        t = 0.05 * k
        left, final = np.exp(-c * t / m), m * g / c
        frames.append(frame(k, final * t + (v0 - final) * (m / c) * (1 - left), final + (v0 - final) * left, mass=m))
    return frames


def test_it_nears_its_terminal_velocity():
    """Law: v = v_t + (v0 - v_t) exp(-c t/m)."""
    assert max(off(measure(falling(3.0), 0.05, 3.0, 1.0, 9.81, 0.0, 0.0, -1.0)).values()) < 1e-14


def test_another_drag_is_seen():
    """Law: 10 % more drag give a terminal velocity 9 % lower."""
    assert off(measure(falling(3.3), 0.05, 3.0, 1.0, 9.81, 0.0, 0.0, -1.0))["velocity"] == pytest.approx(0.09, abs=0.02)

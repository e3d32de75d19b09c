"""Bounces in a box."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from demverify.laws.bounces_between_walls import measure
from tests.support.law_frames import frame, off

K, M, R = 1e4, 1.0, 0.5


def known(x: float, v: float, gamma: float, t_eval, stiffness: float = K):
    """One coordinate between walls at -1 and 1, integrated leg by leg with events at the touch."""

    def slope(t, s):
        low, high = max(-1.0 + R - s[0], 0.0), max(s[0] - 1.0 + R, 0.0)
        touching = (low > 0.0) + (high > 0.0)
        return [s[1], (stiffness * (low - high) - gamma * M * s[1] * touching) / M]

    return solve_ivp(slope, (0.0, t_eval[-1]), [x, v], t_eval=t_eval, rtol=1e-9, atol=1e-12, max_step=2e-4).y


@pytest.mark.parametrize("gamma", [0.0, 5.0])
def test_flights_and_contacts(gamma):
    """Law: flight, half a period of spring and dashpot, flight; as the equation of motion integrated gives it."""
    t = 0.02 * np.arange(101)
    paths = [known(x, v, gamma, t) for x, v in ((0.1, 1.3), (-0.2, -0.7), (0.0, 0.9))]
    frames = [frame(k, [p[0, k] for p in paths], [p[1, k] for p in paths], mass=M) for k in range(len(t))]
    assert max(off(measure(frames, 0.02, K, gamma, -1.0, 1.0)).values()) < 2e-5


def test_another_stiffness_is_seen():
    """Law: a tenth of the stiffness makes contacts three times longer."""
    t = 0.02 * np.arange(101)
    paths = [known(x, v, 0.0, t, 1e3) for x, v in ((0.1, 1.3), (-0.2, -0.7), (0.0, 0.9))]
    frames = [frame(k, [p[0, k] for p in paths], [p[1, k] for p in paths], mass=M) for k in range(len(t))]
    assert off(measure(frames, 0.02, K, 0.0, -1.0, 1.0))["path"] > 0.02

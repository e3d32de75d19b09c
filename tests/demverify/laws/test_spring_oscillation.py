"""Oscillations of a sphere held by walls."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from demverify.laws.spring_oscillation import measure
from tests.support.law_frames import frame, off

K, DT, M, R, LO, HI = 100.0, 0.01, 2.0, 0.5, 0.2, 1.1


def swinging(count: int, gamma: float, gravity: float, stiffer: float = 1.0):
    rest = (LO + R if count == 1 else 0.5 * (LO + HI)) - M * gravity / (count * K)
    k, c = stiffer * count * K / M, count * gamma
    known = solve_ivp(lambda _, s: [s[1], -k * s[0] - c * s[1]], (0, 1), [0.03, -0.1], t_eval=DT * np.arange(100), rtol=1e-12, atol=1e-14)
    return [frame(i, [0, rest + x, 0], [0, v, 0], mass=M) for i, (x, v) in enumerate(known.y.T)]


@pytest.mark.parametrize(("count", "gamma"), [(1, 0.0), (1, 3.0), (2, 1.0), (2, 10.0), (2, 40.0)])
def test_swings_and_creeps(count, gamma):
    """Law: m x'' = -K x - C x' below, at and above critical damping (two walls: 2 k = 2 m w0^2, critical at gamma = 10)."""
    found = measure(swinging(count, gamma, 9.81), DT, K, gamma, 9.81, LO, HI, "one" if count == 1 else "two", "y")
    assert max(off(found).values()) < 1e-9


def test_a_stiffer_spring_is_seen():
    """Law: 2 % more stiffness are 1 % more frequency, 5 % of the amplitude after 5 radians or so."""
    assert off(measure(swinging(1, 0.0, 0.0, 1.02), DT, K, 0.0, 0.0, LO, HI, "one", "y"))["position"] > 0.03

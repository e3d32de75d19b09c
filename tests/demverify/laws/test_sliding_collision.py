"""Sliding collisions."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.sliding_collision import measure
from tests.support.law_frames import frame, off


def collide(inertia: float, friction: float, wrong: float = 1.0):
    """Impulses worked out along fixed axes: line of centres x, slip along y. Masses 1 and 2, radii 0.5 and 1."""
    m, r, e = np.array([1.0, 2.0]), np.array([0.5, 1.0]), 0.8
    v, w = np.array([[2.0, 3.0, 0.0], [-1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 4.0], [0.0, 0.0, 1.0]])
    x = np.array([[-1.5, 0.0, 0.0], [0.0, 0.0, 0.0]]) - 0.2 * v  # touch at t = 0.2, the second at the origin
    push = (2.0 / 3.0) * (1 + e) * 3.0
    slip = (v[0, 1] + r[0] * w[0, 2]) - (v[1, 1] - r[1] * w[1, 2])  # of the touching points: w x r with r = +-R ex
    rub = -friction * push * np.sign(slip) * wrong
    impulse = np.array([-push, rub, 0.0])
    after_w = w.copy()
    after_w[0, 2] += r[0] * rub / (inertia * m[0] * r[0] ** 2)
    after_w[1, 2] += r[1] * rub / (inertia * m[1] * r[1] ** 2)
    after_v = v + np.outer([1.0, -1.0], impulse) / m[:, None]
    return [frame(0, x, v, w, mass=m, radius=r), frame(9, x, after_v, after_w, mass=m, radius=r)]


@pytest.mark.parametrize("inertia", [0.4, 0.5])
def test_impulses(inertia):
    """Law: P_n = m* (1 + e) v_n, P_t = mu P_n, both turned into spins by their radii."""
    assert max(off(measure(collide(inertia, 0.1), 0.8, 0.1, inertia)).values()) < 1e-14


def test_wrong_sign_and_inertia_are_seen():
    """Law: friction along the slip, or the inertia of the other body, miss."""
    assert min(off(measure(collide(0.5, 0.1, wrong=-1.0), 0.8, 0.1, 0.5)).values()) > 0.05
    assert off(measure(collide(0.4, 0.1), 0.8, 0.1, 0.5))["spins"] > 0.02

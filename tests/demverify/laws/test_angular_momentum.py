"""Angular momentum, its parts and gravity."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.angular_momentum import measure
from tests.support.law_frames import frame, off

M = np.array([1.0, 3.0])


def spinning(twist: float = 0.0):
    """Two spheres that fall, the second one's spin handed over to the first by a torque pair; twist: one that has no partner."""
    g, x, v = np.array([0.0, 0.0, -2.0]), np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 1.0]]), np.array([[0.0, 1.0, 0.0], [0.5, 0.0, -1.0]])
    frames = []
    for k in range(6):
        t = 0.1 * k
        handed = np.array([[0.0, 0.0, t + twist * t], [0.0, 0.0, -t]]) / (0.4 * M[:, None] * 0.25)
        frames.append(frame(k, x + v * t + 0.5 * g * t * t, v + g * t, handed, mass=M))
    return frames


def test_falling_spheres_keep_what_is_theirs():
    """Law: L about the origin grows by M (R0 x g t + V0 x g t^2/2), about the centre not at all."""
    assert max(off(measure(spinning(), 0.1, 2.0, 0.0, 0.0, -1.0, 0.4)).values()) < 1e-14


def test_a_torque_without_partner_is_seen():
    """Law: the missing part is the integral of the torque."""
    for found in measure(spinning(0.1), 0.1, 2.0, 0.0, 0.0, -1.0, 0.4):
        assert found.measured == pytest.approx(0.1 * 0.5, rel=1e-12)

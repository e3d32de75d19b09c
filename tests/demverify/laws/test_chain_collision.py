"""Rows of spheres."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.chain_collision import measure
from tests.support.law_frames import frame, off


def two(stiffness: float):
    """Two unit spheres 0.1 apart at first, elastic: the closed form of their overlap. m* = 1/2."""
    w, frames = np.sqrt(2.0 * stiffness), []
    for k in range(100):
        s = 0.01 * k - 0.1
        d, rate = (s, 1.0) if s < 0 else (np.sin(w * s) / w, np.cos(w * s)) if s < np.pi / w else (-(s - np.pi / w), -1.0)
        frames.append(frame(k, [[-0.5 + 0.5 * (d + s), 0, 0], [0.5 + 0.5 * (s - d), 0, 0]], [[0.5 * (1 + rate), 0, 0], [0.5 * (1 - rate), 0, 0]]))
    return frames


def test_two_spheres_have_a_closed_form():
    """Law: the integration agrees with d = sin(w s)/w of two elastic spheres."""
    assert max(off(measure(two(50.0), 0.01, "hooke", 50.0, 0.0)).values()) < 1e-5


def test_another_stiffness_is_seen():
    """Law: 10 % less stiffness make the contact 5 % longer."""
    assert off(measure(two(45.0), 0.01, "hooke", 50.0, 0.0))["velocities"] > 0.02


def test_hertz_rebound():
    """Law: an elastic Hertz impact hands the velocity on."""
    frames = [frame(k, [[-0.6 + 0.1 * k, 0, 0], [0.5, 0, 0]], [[1.0, 0, 0], [0, 0, 0]]) for k in range(1)]
    frames += [frame(80, [[-0.5, 0, 0], [8.0, 0, 0]], [[0, 0, 0], [1.0, 0, 0]])]
    assert off(measure(frames, 0.1, "hertz", 1e3, 0.0))["velocities at the end"] == pytest.approx(0.0, abs=1e-6)

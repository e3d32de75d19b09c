"""Copies of a motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from demverify.laws.copy_moves_alike import measure
from tests.support.law_frames import frame, off

TURN = Rotation.from_rotvec(np.radians(40.0) * np.array([2.0, -1.0, 2.0]) / 3.0).as_matrix()


def copies(mirror: str = "none", wrong: float = 0.0, edge: float = 0.0):
    rng = np.random.default_rng(3)
    x, v, w, a = rng.normal(size=(4, 2, 3))
    reverse = np.diag([-1.0 if mirror == name else 1.0 for name in "xyz"])
    turn, shift, boost = reverse @ TURN, np.array([3.0, 1.0, -2.0]), np.array([0.5, -1.0, 2.0])
    frames = []
    for k in range(5):
        t = 0.1 * k
        place, speed = x + v * t + 0.5 * a * t * t, v + a * t
        spin = w * (1.0 + t)
        other = place @ turn.T + shift + boost * t
        other = other - edge * np.round(other / edge) if edge else other
        frames.append(
            frame(
                k,
                np.vstack([place, other]),
                np.vstack([speed, speed @ turn.T + boost]),
                np.vstack([spin, (1.0 + wrong) * np.linalg.det(turn) * spin @ turn.T]),
                edge=edge,
            )
        )
    return frames


@pytest.mark.parametrize(("mirror", "edge"), [("none", 0.0), ("x", 0.0), ("z", 0.0), ("none", 8.0)])
def test_copies_move_alike(mirror, edge):
    """Law: x' = S x + D + V t, v' = S v + V, w' = det(S) S w; images count."""
    assert max(off(measure(copies(mirror, edge=edge), 0.1, mirror, 40.0, 2.0, -1.0, 2.0)).values()) < 1e-13


def test_spins_are_axial():
    """Law: in a mirror a spin that is taken for a polar vector is wrong by twice itself."""
    assert off(measure(copies("y", wrong=-2.0), 0.1, "y", 40.0, 2.0, -1.0, 2.0))["spin of the copy"] > 1.0
    assert off(measure(copies("y"), 0.1, "none", 40.0, 2.0, -1.0, 2.0))["position of the copy"] > 0.1

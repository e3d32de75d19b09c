"""A sphere on a wall that slides."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.moving_wall import measure
from tests.support.law_frames import frame, off

MU, G, R, DT = 0.3, 9.81, 0.5, 0.01
N, WALL = np.array([0.0, 0.0, 1.0]), np.array([2.0, 0.0, 0.0])


def dragged(lever: float = 1.0, mu: float = MU):
    """Euler steps of the spin and velocity under mu g, exact for a constant force, until it rolls."""
    u, w, frames = np.array([-0.5, 0.3, 0.0]), np.array([0.0, 1.0, 0.0]), []
    slip0 = WALL - (u - R * np.cross(w, N))
    gain = 2.0 / 7.0 * slip0
    end = np.linalg.norm(gain) / (MU * G)
    for k in range(60):
        share = min(k * DT * mu / (MU * end), 1.0)
        frames.append(frame(k, [0, 0, R], u + share * gain, w + lever * share * 2.5 / R * np.cross(gain, N)))
    return frames


def law(frames):
    return off(measure(frames, DT, MU, G, *WALL, *N))


def test_it_slips_then_rolls():
    """Law: J = (2/7) s0 in the end, mu g t before; then the touching point has the velocity of the wall."""
    frames = dragged()
    assert max(law(frames).values()) < 1e-14
    last = frames[-1]
    touching = last.vectors("vx", "vy", "vz")[0] - R * np.cross(last.vectors("omegax", "omegay", "omegaz")[0], N)
    assert touching == pytest.approx(WALL)


def test_wrong_lever_and_friction_are_seen():
    """Law: 2 % of the torque are 2 % of the change of the spin; 10 % of the friction are up to 10 % of J."""
    assert law(dragged(lever=1.02))["spin of rolling"] > 0.01
    assert law(dragged(mu=1.1 * MU))["velocity while it slips"] > 0.05

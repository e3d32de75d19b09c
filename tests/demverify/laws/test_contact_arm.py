"""Arms of a contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demverify.laws.contact_arm import measure
from tests.support.law_frames import frame, off

FORCE, OVERLAP, DT = np.array([5.0, 2.0, 0.0]), 0.1, 0.01


def turning(arm: float):
    """Unit spheres held by nothing but the force of their contact for ten steps, friction 2 along y; arms of both: `arm`."""
    frames = []
    x, inertia = np.array([[0.45, 0, 0], [-0.45, 0, 0]]), 0.4 * 0.25
    v, w = np.zeros((2, 3)), np.zeros((2, 3))
    for k in range(11):
        one = frame(k, x, v + k * DT * np.array([FORCE, -FORCE]), w + k * DT * np.array([[0, 0, -arm * 2.0 / inertia]] * 2))
        force = {name: np.array([FORCE[j], -FORCE[j]]) for j, name in enumerate(("fx", "fy", "fz"))}
        frames.append(replace(one, columns=one.columns | force))
    return frames


def test_full_radius_leaves_overlap_times_friction():
    """Law: dL/dt = -overlap n x F for arms R, nothing for arms to the contact point."""
    assert max(off(measure(turning(0.5), DT, "radius")).values()) < 1e-14
    assert max(off(measure(turning(0.45), DT, "contact")).values()) < 1e-14


def test_the_other_arm_is_seen():
    """Law: arms R against arms to the contact point differ by overlap times friction times the time."""
    assert measure(turning(0.5), DT, "contact")[1].measured == pytest.approx(OVERLAP * 2.0 * 0.1)

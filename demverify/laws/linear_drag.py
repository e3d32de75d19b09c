"""A sphere under gravity and linear drag -c v (fix viscous) nears its terminal velocity v_t = m g/c exponentially (Stokes 1851):

v(t) = v_t + (v0 - v_t) exp(-c t/m),   x(t) = x0 + v_t t + (v0 - v_t) (m/c) (1 - exp(-c t/m)),   spin untouched
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured
from demverify.mechanics import largest_misses_of_paths, velocities


def measure(frames: Sequence[Frame], dt: float, drag: float, ratio: float, gravity: float, x: float, y: float, z: float) -> list[Measured]:
    """Every particle: largest misses over all frames, relative to the largest speed and the largest path. drag: c of type 1; ratio: c of
    type 2 over that of type 1. gravity along (x, y, z)."""
    first, along = frames[0], np.array([x, y, z])
    mass = first.columns["mass"][:, None]
    rate = drag * np.where(first.columns["type"] == 2, ratio, 1.0)[:, None] / mass
    final = gravity * along / np.linalg.norm(along) / rate
    start = velocities(first)

    def expected(t: float) -> tuple[Floats, Floats]:
        left = np.exp(-rate * t)
        return final + (start - final) * left, final * t + (start - final) * (1.0 - left) / rate

    return largest_misses_of_paths(frames, dt, expected)

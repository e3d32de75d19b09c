"""A sphere under gravity and linear drag -c v (fix viscous) nears its terminal velocity v_t = m g/c exponentially (Stokes 1851):

v(t) = v_t + (v0 - v_t) exp(-c t/m),   x(t) = x0 + v_t t + (v0 - v_t) (m/c) (1 - exp(-c t/m)),   spin untouched
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import positions, spins, times, velocities


def measure(frames: Sequence[Frame], dt: float, drag: float, ratio: float, gravity: float, x: float, y: float, z: float) -> list[Measured]:
    """Every particle: largest misses over all frames, relative to the largest speed and the largest path. drag: c of type 1; ratio: c of
    type 2 over that of type 1. gravity along (x, y, z)."""
    first, along = frames[0], np.array([x, y, z])
    mass = first.columns["mass"][:, None]
    rate = drag * np.where(first.columns["type"] == 2, ratio, 1.0)[:, None] / mass
    final = gravity * along / np.linalg.norm(along) / rate
    start, where = velocities(first), positions(first)
    found = []
    for frame, t in zip(frames, times(frames, dt), strict=True):
        left = np.exp(-rate * t)
        speed = final + (start - final) * left
        place = where + final * t + (start - final) * (1.0 - left) / rate
        found.append((np.abs(velocities(frame) - speed).max(), np.abs(positions(frame) - place).max(), np.abs(spins(frame) - spins(first)).max()))
    missed = np.array(found)
    size = max(float(np.abs(velocities(frame)).max()) for frame in frames)
    path = max(float(np.abs(positions(frame) - where).max()) for frame in frames)
    at = missed.argmax(axis=0)
    return [
        Measured("velocity", frames[at[0]].step, float(missed[at[0], 0]), 0.0, size),
        Measured("path", frames[at[1]].step, float(missed[at[1], 1]), 0.0, path),
        Measured("spin", frames[at[2]].step, float(missed[at[2], 2]), 0.0, max(1.0, float(np.abs(spins(first)).max()))),
    ]

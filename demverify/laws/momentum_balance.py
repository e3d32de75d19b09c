"""Contacts are pairs of opposite forces, so only gravity changes the total momentum: P(t) = P(0) + M g t, and the centre of mass
R(t) = R(0) + V(0) t + g t^2/2 (primer, appendix A: d(M V)/dt = sum of outer forces; Goldstein, Classical Mechanics, eq. 1-22)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import center, momentum, times, velocities


def measure(frames: Sequence[Frame], dt: float, gravity: float, x: float, y: float, z: float) -> list[Measured]:
    """Largest misses over all frames. gravity along (x, y, z), of any length but zero. Relative to sum of m |v| at its largest."""
    first, along = frames[0], np.array([x, y, z])
    g = gravity * along / np.linalg.norm(along)
    mass = first.columns["mass"]
    size = max(float(mass @ np.linalg.norm(velocities(frame), axis=1)) for frame in frames)
    start, where, speed = momentum(first), *center(first)
    found = []
    for frame, t in zip(frames, times(frames, dt), strict=True):
        missed = float(np.abs(momentum(frame) - start - mass.sum() * g * t).max())
        off = float(np.abs(center(frame)[0] - where - speed * t - 0.5 * g * t * t).max())
        found.append((frame.step, missed, off))
    worst, furthest = max(found, key=lambda row: row[1]), max(found, key=lambda row: row[2])
    reach = size / float(mass.sum()) * float(times(frames, dt)[-1])
    return [
        Measured("total momentum", worst[0], worst[1], 0.0, size),
        Measured("path of the centre of mass", furthest[0], furthest[2], 0.0, reach),
    ]

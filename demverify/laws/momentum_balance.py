"""Contacts are pairs of opposite forces, so only gravity changes the total momentum: P(t) = P(0) + M g t, and the centre of mass
R(t) = R(0) + V(0) t + g t^2/2 (primer, appendix A: d(M V)/dt = sum of outer forces; Goldstein, Classical Mechanics, eq. 1-22)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import center, momentum, times, velocities


def measure(frames: Sequence[Frame], dt: float, gravity: float, x: float, y: float, z: float) -> list[Measured]:
    """Largest misses over all frames. gravity along (x, y, z), of any length but zero. Relative to sum of m |v| at its largest."""
    first, along = frames[0], np.array([x, y, z])
    g = gravity * along / np.linalg.norm(along)
    mass = first.columns["mass"]
    size = max(float(mass @ np.linalg.norm(velocities(frame), axis=1)) for frame in frames)
    start, where, speed = momentum(first), *center(first)
    timed = list(zip(frames, times(frames, dt), strict=True))
    missed = [np.abs(momentum(frame) - start - mass.sum() * g * t).max() for frame, t in timed]
    off = [np.abs(center(frame)[0] - where - speed * t - 0.5 * g * t * t).max() for frame, t in timed]
    reach = size / float(mass.sum()) * float(timed[-1][1])
    return [largest_miss("total momentum", frames, missed, size), largest_miss("path of the centre of mass", frames, off, reach)]

"""Undamped contacts, velocities reversed half-way: everything runs back, x(end) = x(start), v(end) = -v(start) (Loschmidt; Landau & Lifshitz,
Mechanics, par. 5). Velocity Verlet is reversible step by step, so only rounding is left, grown by the instability of the collisions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import positions, velocities


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Last frame against the first; relative to the furthest that a particle has gone, and to the largest speed."""
    first, last = frames[0], frames[-1]
    gone = max(float(np.abs(positions(frame) - positions(first)).max()) for frame in frames)
    size = float(np.abs(velocities(first)).max())
    return [
        Measured("positions after the return", last.step, float(np.abs(positions(last) - positions(first)).max()), 0.0, gone),
        Measured("velocities after the return", last.step, float(np.abs(velocities(last) + velocities(first)).max()), 0.0, size),
    ]

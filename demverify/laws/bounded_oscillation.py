"""A sphere let go from rest, off its place of rest on a linear spring, swings no farther than where it started.

Of the motion in time, and of velocity Verlet for every step up to 2/w: it keeps v^2 + w^2 (1 - (w dt)^2/4) x^2 (Hairer, Lubich & Wanner 2006, ch. I).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import positions


def measure(frames: Sequence[Frame], rest: float) -> list[Measured]:
    """Largest distance of the first particle from its place of rest, z = rest, over all frames, against that of the first."""
    off = np.array([abs(float(positions(frame)[0, 2]) - rest) for frame in frames])
    worst = int(np.argmax(off))  # the first NaN, where there is one
    return [Measured("amplitude", frames[worst].step, float(off[worst]), float(off[0]))]

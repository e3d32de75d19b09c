"""Two spheres, or one and the plane z = 0, pressed together and let go from rest, elastic and linear: they part with v = w x.

x: overlap at the start, w = sqrt(k/m*); 1/2 k x^2 = 1/2 m* v^2 (Landau & Lifshitz, Mechanics, par. 21).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import momentum, positions, velocities


def measure(frames: Sequence[Frame], theta: float, timestep: float) -> list[Measured]:
    """Speed of parting along the line of the start (up from the plane), and what momentum two spheres gain. theta: w times the step."""
    first, last = frames[0], frames[-1]
    radius, x, v = first.columns["radius"], positions(first), velocities(last)
    if first.n == 1:
        return [Measured("speed of parting", last.step, float(v[0, 2]), theta / timestep * float(radius[0] - x[0, 2]))]
    line = x[1] - x[0]
    apart = float(np.linalg.norm(line))
    expected = theta / timestep * (float(radius[:2].sum()) - apart)
    speed = float((v[1] - v[0]) @ line / apart) if apart else float(np.linalg.norm(v[1] - v[0]))
    gained = float(np.abs(momentum(last)).max())
    return [
        Measured("speed of parting", last.step, speed, expected),
        Measured("momentum", last.step, gained, 0.0, float(first.columns["mass"].min()) * expected),
    ]

"""A straight impact on a linear spring and dashpot that pulls at the end (MFIX-DEM V&V, DEM-02; Schwager & Poeschel 2007,
doi:10.1007/s10035-007-0065-z).

    b = -ln e / sqrt(pi^2 + ln^2 e);  w = sqrt(k/m*);  contact time pi / (w sqrt(1 - b^2))
    greatest overlap v/w exp(-b/sqrt(1 - b^2) arccos b)
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, exp, pi, sqrt

from demverify.frames import Frame
from demverify.impact import Impact, damping_ratio, peak
from demverify.laws import Measured


def measure(frames: Sequence[Frame], stiffness: float, restitution: float, timestep: float) -> list[Measured]:
    """Contact time and greatest overlap of two spheres, or of one and the plane z = 0. stiffness [force/length], restitution: of the law."""
    impact = Impact.of(frames)
    damping = damping_ratio(restitution)
    root = sqrt(1.0 - damping**2)
    frequency = sqrt(stiffness / impact.mass)
    deepest = impact.speed / frequency * exp(-damping / root * acos(damping))
    return [
        Measured("contact time", frames[-1].step, impact.duration(timestep), pi / (frequency * root)),
        Measured("peak overlap", frames[impact.deepest].step, peak(impact.overlap), deepest),
    ]

"""Head on with a dashpot that may not pull (LAMMPS limit_damping, LIGGGHTS limitForce): the contact ends where the force has gone down to
zero, before the overlap has (Schwager & Poeschel 2007, doi:10.1007/s10035-007-0065-z).

    e' = exp(-b/w [pi - atan2(2 b w, 1 - 2 b^2)]),  w = sqrt(1 - b^2),  b = -ln e / sqrt(pi^2 + ln^2 e)

For a linear contact, and for a Hertz contact with Tsuji's dashpot, which is linear in d^(5/4).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, exp, pi, sqrt

from demverify.frames import Frame
from demverify.impact import Impact, damping_ratio
from demverify.laws import Measured


def measure(frames: Sequence[Frame], nominal: float) -> list[Measured]:
    """Restitution of two spheres, or of one and the plane z = 0. nominal: that of the dashpot with its pull."""
    b = damping_ratio(nominal)
    w = sqrt(1.0 - b**2)
    expected = exp(-b / w * (pi - atan2(2.0 * b * w, 1.0 - 2.0 * b**2)))
    return [Measured("restitution", frames[-1].step, Impact.of(frames).restitution, expected)]

"""The restitution that LAMMPS' damping tsuji really gives to a head-on pair (register: lammps-tsuji-restitution).

The dashpot is alpha sqrt(m* K) d^(1/4), alpha the polynomial in the nominal restitution of Marshall 2009 (J. Comput. Phys. 228:1541, eq. 53).
Of a Hertz contact follows e = exp(-pi b/sqrt(1 - b^2)), b = alpha/sqrt(5) (Antypov & Elliott 2011, doi:10.1209/0295-5075/94/50004).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, pi, sqrt

from demverify.frames import Frame
from demverify.impact import Impact
from demverify.laws import Measured

POLYNOMIAL = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)


def measure(frames: Sequence[Frame], nominal: float) -> list[Measured]:
    """Restitution of two spheres. nominal: the number in the deck."""
    damping = sum(factor * nominal**power for power, factor in enumerate(POLYNOMIAL)) / sqrt(5.0)
    expected = exp(-pi * damping / sqrt(1.0 - damping**2))
    return [Measured("restitution", frames[-1].step, Impact.of(frames).restitution, expected)]

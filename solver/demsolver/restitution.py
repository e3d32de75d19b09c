"""Restitution that the damping law `fraction` brings about on a linear or a Hertz spring, and the fraction for a wanted restitution.

With the damping ratio b the impact is that of a linear oscillator, on a Hertz spring in the variable overlap^(5/4):

    hooke  gn = 2 b sqrt(meff kn)                    damping_fraction = 2 b
    hertz  gn = sqrt(5) b sqrt(meff F/overlap)       damping_fraction = sqrt(5) b, often called alpha

    with its pulling tail, the contact ends at zero overlap     e = exp(-pi b/sqrt(1 - b^2)), 0 for b >= 1
    limit_damping, the contact ends where the force is zero     e = exp(-2 b arccos(b)/sqrt(1 - b^2)), with arcosh(b)/sqrt(b^2 - 1) for b > 1

For head-on contact of two bodies alone, no other forces; whatever the impact speed. Source: the first line Y. Tsuji et al., Powder Technol. 71
(1992) 239, doi:10.1016/0032-5910(92)88030-L (where alpha(e) is a drawn curve), and for the linear spring any textbook; the second
T. Schwager, T. Poeschel, Granular Matter 9 (2007) 465, doi:10.1007/s10035-007-0065-z, which holds for the Hertz spring too, by the same variable.
"""

from __future__ import annotations

from math import acos, acosh, exp, log, pi, sqrt
from typing import Literal

Spring = Literal["hooke", "hertz"]
PER_RATIO: dict[Spring, float] = {"hooke": 2.0, "hertz": sqrt(5.0)}


def of_fraction(damping_fraction: float, spring: Spring, *, limit_damping: bool = False) -> float:
    """Restitution e, 0 to 1, of a damping_fraction >= 0. Raises ValueError for a negative one, or an unknown spring."""
    if not damping_fraction >= 0.0:
        message = f"damping_fraction {damping_fraction} must not be negative"
        raise ValueError(message)
    return exp(-_decrement(damping_fraction / _per_ratio(spring), limit_damping))


def fraction_for(restitution: float, spring: Spring, *, limit_damping: bool = False) -> float:
    """The damping_fraction that brings about a restitution, above 0 and up to 1. Raises ValueError outside, or for an unknown spring."""
    if not 0.0 < restitution <= 1.0:
        message = f"restitution {restitution} must be above 0, and at most 1"
        raise ValueError(message)
    wanted = 0.0 - log(restitution)
    ratio = _limited_ratio(wanted) if limit_damping else wanted / sqrt(pi * pi + wanted * wanted)
    return ratio * _per_ratio(spring)


def _per_ratio(spring: Spring) -> float:
    if spring not in PER_RATIO:
        message = f"spring {spring!r} is not one of {', '.join(PER_RATIO)}"
        raise ValueError(message)
    return PER_RATIO[spring]


def _decrement(b: float, limit_damping: bool) -> float:
    """-ln e of the damping ratio b."""
    if not limit_damping:
        return pi * b / sqrt((1.0 - b) * (1.0 + b)) if b < 1.0 else float("inf")
    if b == 1.0:
        return 2.0
    if b > 1.0:
        return 2.0 * b * acosh(b) / sqrt((b - 1.0) * (b + 1.0))
    return 2.0 * b * acos(b) / sqrt((1.0 - b) * (1.0 + b))


def _limited_ratio(wanted: float) -> float:
    """b of a decrement without the tail, by bisection to the last place: the decrement grows with b, from pi b to 2 ln 2b."""
    low, high = wanted / 4.0, exp(0.5 * wanted)
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if _decrement(middle, True) < wanted else (low, middle)
    return middle

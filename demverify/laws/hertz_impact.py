"""A straight Hertz impact, with Tsuji's dashpot where the restitution is below 1.

    F = K d^(3/2) + 2 sqrt(5) / 2 b sqrt(m* K) d^(1/4) d',  K = 4/3 E* sqrt(R*),  b = -ln e / sqrt(pi^2 + ln^2 e)

In s = d^(5/4) that is a linear oscillator of frequency W = sqrt(4 K / (5 m*)) and damping ratio b (Antypov & Elliott 2011,
doi:10.1209/0295-5075/94/50004), from which follow

    greatest overlap  [v/W exp(-b/sqrt(1 - b^2) arccos b)]^(4/5),  elastic: [5 m* v^2 / (4 K)]^(2/5)
    contact time      4/(5 w) (v/w)^(-1/5) int_0^pi exp(b q / (5 sqrt(1 - b^2))) sin(q)^(-1/5) dq,  w = W sqrt(1 - b^2); elastic: 2.943275 d/v

(Elastic: K. L. Johnson, Contact Mechanics, 1985, ch. 11.4; Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, tests 1 and 2.)
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, exp, pi, sqrt
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.impact import Impact, damping_ratio, peak
from demverify.laws import Measured


def measure(
    frames: Sequence[Frame], young: float, poisson: float, against: Literal["alike", "rigid"], restitution: float, timestep: float
) -> list[Measured]:
    """Contact time, greatest overlap and greatest force of two spheres, or of one and the plane z = 0. young [pressure], poisson: of the
    first sphere. against: what it hits, of the same material or rigid."""
    impact = Impact.of(frames)
    effective = young / (1.0 - poisson**2) / (2.0 if against == "alike" else 1.0)
    stiffness = 4.0 / 3.0 * effective * sqrt(impact.radius)
    damping = damping_ratio(restitution)
    root = sqrt(1.0 - damping**2)
    frequency = sqrt(0.8 * stiffness / impact.mass)
    deepest = (impact.speed / frequency * exp(-damping / root * acos(damping))) ** 0.8
    return [
        Measured("contact time", frames[-1].step, impact.duration(timestep), _duration(impact.speed, frequency * root, damping / root)),
        Measured("peak overlap", frames[impact.deepest].step, peak(impact.overlap), deepest),
        Measured("peak force", frames[impact.deepest].step, peak(impact.force), _greatest(impact, frequency, damping)),
    ]


def _duration(speed: float, frequency: float, loss: float) -> float:
    """frequency: of the damped oscillator. loss: b/sqrt(1 - b^2). The singular ends q^(-1/5) go into the weight of the quadrature."""
    from scipy.integrate import quad

    def smooth(q: float) -> float:
        ends = q * (pi - q)
        return float(exp(loss * q / 5.0) * ((np.sin(q) / ends) if ends > 0.0 else 1.0 / pi) ** -0.2)

    integral = quad(smooth, 0.0, pi, weight="alg", wvar=(-0.2, -0.2))[0]
    return float(0.8 / frequency * (speed / frequency) ** -0.2 * integral)


def _greatest(impact: Impact, frequency: float, damping: float) -> float:
    """The largest force: m* 5/4 s^(1/5) (W^2 s + 2 b W s'), over the time of the oscillator."""
    root = sqrt(1.0 - damping**2)
    q = np.linspace(0.0, pi, 20001)
    decay = np.exp(-damping / root * q)
    s = impact.speed / (frequency * root) * decay * np.sin(q)
    rate = impact.speed * decay * (np.cos(q) - damping / root * np.sin(q))
    return peak(impact.mass * 1.25 * np.abs(s) ** 0.2 * (frequency**2 * s + 2.0 * damping * frequency * rate))

"""Adhesive contact of two spheres of one material, or of a sphere and the plane z = 0, undamped: force over overlap.

    DMT (Derjaguin et al. 1975, doi:10.1016/0021-9797(75)90018-1)  F = 4/3 E* sqrt(R*) d^(3/2) - 4 pi g R*
    JKR (Johnson et al. 1971, doi:10.1098/rspa.1971.0141)           F = 4 E* a^3/(3 R*) - 4 sqrt(pi g E* a^3),  d = a^2/R* - 2 sqrt(pi g a/E*)

g: surface energy of one sphere, the work of adhesion is 2 g. At zero overlap F = -4 pi g R* and -8/3 pi g R*. A DMT contact ends there; JKR
holds on up to its greatest pull 3 pi g R*, at the gap a^2/(3 R*), a^3 = 9 pi g R*^2/(4 E*).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.impact import Impact
from demverify.laws import Measured


def measure(frames: Sequence[Frame], model: Literal["dmt", "jkr"], young: float, poisson: float, surface_energy: float) -> list[Measured]:
    """The force where it is farthest from the law, over all frames from contact to parting, relative to the greatest pull of the model; and
    the force of the first frame, which is to be that of touch. young [pressure], poisson: of both; surface_energy: g."""
    impact = Impact.of(frames)
    effective = young / (2.0 * (1.0 - poisson**2))
    greatest = (4.0 if model == "dmt" else 3.0) * pi * surface_energy * impact.radius
    at_touch = -(4.0 if model == "dmt" else 8.0 / 3.0) * pi * surface_energy * impact.radius
    law = _dmt if model == "dmt" else _jkr
    expected = np.array([law(float(overlap), effective, impact.radius, surface_energy) for overlap in impact.overlap])
    worst = int(np.abs(impact.force - expected).argmax())
    return [
        Measured("force at touch", frames[0].step, float(impact.force[0]), at_touch),
        Measured("force over overlap", frames[worst].step, float(impact.force[worst]), float(expected[worst]), greatest),
    ]


def _dmt(overlap: float, effective: float, radius: float, energy: float) -> float:
    return 4.0 / 3.0 * effective * sqrt(radius) * overlap**1.5 - 4.0 * pi * energy * radius if overlap > 0.0 else 0.0


def _jkr(overlap: float, effective: float, radius: float, energy: float) -> float:
    """Contact that has been closed before: it is lost beyond the gap of the greatest pull."""
    from scipy.optimize import brentq

    edge = float(np.cbrt(9.0 * pi * energy * radius**2 / (4.0 * effective)))
    if overlap < -(edge**2) / (3.0 * radius):
        return 0.0

    def short(a: float) -> float:
        return a**2 / radius - 2.0 * sqrt(pi * energy * a / effective) - overlap

    high = 2.0 * edge
    while short(high) <= 0.0:
        high *= 2.0
    a = float(brentq(short, edge, high, xtol=1e-18, rtol=1e-14)) if short(edge) < 0.0 else edge
    return 4.0 * effective * a**3 / (3.0 * radius) - 4.0 * sqrt(pi * energy * effective * a**3)

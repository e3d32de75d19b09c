"""LIGGGHTS' simplified JKR: an elastic Hertz contact less the cohesion energy density times the contact area (LIGGGHTS manual, cohesion sjkr).

    F = 4/3 E* sqrt(R*) d^(3/2) - k A,  A = pi/4 [(R1 + R2)^2 - r^2] [r^2 - (R1 - R2)^2] / r^2 (circle of the lens), plane: pi (R^2 - r^2)

Elastic: the dashpot is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt

import numpy as np

from demverify.frames import Frame
from demverify.impact import Impact
from demverify.laws import Measured


def measure(frames: Sequence[Frame], young: float, poisson: float, energy_density: float) -> list[Measured]:
    """The force where it is farthest from the law, over all frames, relative to the largest; and the greatest pull among the frames.
    young [pressure], poisson: of both; energy_density: k."""
    impact = Impact.of(frames)
    stiffness = 4.0 / 3.0 * young / (2.0 * (1.0 - poisson**2)) * sqrt(impact.radius)
    overlap = np.maximum(impact.overlap, 0.0)
    expected = stiffness * overlap**1.5 - energy_density * _area(overlap, frames[0].columns["radius"])
    pull = float(-expected.min())
    worst, deepest = int(np.abs(impact.force - expected).argmax()), int(impact.force.argmin())
    return [
        Measured("force over overlap", frames[worst].step, float(impact.force[worst]), float(expected[worst]), float(np.abs(expected).max())),
        Measured("greatest pull", frames[deepest].step, -float(impact.force[deepest]), pull),
    ]


def _area(overlap: np.ndarray, radius: np.ndarray) -> np.ndarray:
    if len(radius) == 1:
        return np.asarray(pi * (radius[0] ** 2 - (radius[0] - overlap) ** 2))
    r1, r2 = radius[:2]
    square = (r1 + r2 - overlap) ** 2
    return np.asarray(pi / 4.0 * ((r1 + r2) ** 2 - square) * (square - (r1 - r2) ** 2) / square)

"""Elastic Hertz impact: overlap_max = (5 m* v^2 / (4 K))^(2/5), F_max = K overlap_max^(3/2), K = 4/3 E* sqrt(R*)  (K. L. Johnson, Contact
Mechanics, 1985, ch. 11.4; Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, tests 1 and 2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], young: float, poisson: float) -> list[Measured]:
    """Largest overlap and force of two like spheres head on, over all frames. young [pressure], poisson: of both."""
    first = frames[0]
    (r1, r2), (m1, m2) = first.columns["radius"][:2], first.columns["mass"][:2]
    v = first.vectors("vx", "vy", "vz")
    speed = float(np.linalg.norm(v[0] - v[1]))
    stiffness = 4.0 / 3.0 * young / (2.0 * (1.0 - poisson**2)) * np.sqrt(r1 * r2 / (r1 + r2))
    deepest = float((1.25 * m1 * m2 / (m1 + m2) * speed**2 / stiffness) ** 0.4)
    overlaps = [r1 + r2 - float(np.linalg.norm(np.subtract(*frame.vectors("x", "y", "z")[:2]))) for frame in frames]
    forces = [float(np.linalg.norm(frame.vectors("fx", "fy", "fz")[0])) for frame in frames]
    at = int(np.argmax(overlaps))
    return [
        Measured("peak overlap", frames[at].step, overlaps[at], deepest),
        Measured("peak force", frames[at].step, max(forces), float(stiffness * deepest**1.5)),
    ]

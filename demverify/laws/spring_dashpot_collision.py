"""Two spheres head on, linear spring and dashpot: m d'' + c d' + k d = 0 from d = 0, d' = v on, until d = 0 again:

    d(s) = (v/w) exp(-b s) sin(w s),   b = c/(2 m), w = sqrt(k/m - b^2),   contact lasts pi/w,   then v' = -v exp(-pi b/w)

(Schaefer, Dippel & Wolf 1996, doi:10.1051/jp1:1996129, eq. 5-8; Cundall & Strack 1979). m: reduced mass of free partners; the mass of the
moving sphere where the other is frozen, which is then a wall (m and c with it), or held in place by other means (m alone)."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, pi, sqrt
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, times, velocities


def measure(
    frames: Sequence[Frame], dt: float, stiffness: float, damping: float, partner: Literal["free", "frozen", "held"]
) -> list[Measured]:
    """The first two particles: overlap over time, relative to the deepest; restitution. damping: c over the mass that the contact law takes
    (the reduced one, or with a frozen partner that of the first sphere) [1/time]."""
    first = frames[0]
    (m1, m2), size = first.columns["mass"][:2], float(first.columns["radius"][:2].sum())
    reduced = m1 * m2 / (m1 + m2)
    mass = reduced if partner == "free" else m1
    b = damping * (m1 if partner == "frozen" else reduced) / (2.0 * mass)
    w = sqrt(stiffness / mass - b * b)
    overlap = np.array([size - float(np.linalg.norm(positions(f)[0] - positions(f)[1])) for f in frames])
    line = positions(first)[1] - positions(first)[0]
    line /= np.linalg.norm(line)
    v = float((velocities(first)[0] - velocities(first)[1]) @ line)
    s = times(frames, dt) + overlap[0] / v  # since the touch
    rebound = exp(-pi * b / w)
    contact = v / w * np.exp(-b * s) * np.sin(w * s)
    expected = np.where(s < 0.0, v * s, np.where(s < pi / w, contact, -rebound * v * (s - pi / w)))
    after = float((velocities(frames[-1])[0] - velocities(frames[-1])[1]) @ line)
    return [
        largest_miss("overlap", frames, np.abs(overlap - expected), float(expected.max())),
        Measured("restitution", frames[-1].step, -after / v, rebound),
    ]

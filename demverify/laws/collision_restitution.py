"""Two spheres head on: the relative velocity along their line turns into -e times itself, and momentum stays.

(v1 - v2)' = -e (v1 - v2). For the linear dashpot with a pulling tail, e = exp(-pi gn / sqrt(4 k m* - gn^2)) (MFIX-DEM V&V, DEM-02).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], restitution: float) -> list[Measured]:
    """Restitution along the line of centres of the first two particles, and their momentum. restitution: that of the closed form."""
    first, last = frames[0], frames[-1]
    along = (first.vectors("x", "y", "z")[0] - first.vectors("x", "y", "z")[1])[:, None]
    before, after = (_relative(frame) @ along for frame in (first, last))
    mass, size = first.columns["mass"], np.abs(first.vectors("vx", "vy", "vz")).max()
    drift = mass @ last.vectors("vx", "vy", "vz") - mass @ first.vectors("vx", "vy", "vz")
    return [
        Measured("restitution", last.step, float(-after[0] / before[0]), restitution),
        Measured("momentum", last.step, float(np.abs(drift).max()), 0.0, float(mass.sum() * size)),
    ]


def _relative(frame: Frame) -> np.ndarray:
    v = frame.vectors("vx", "vy", "vz")
    return np.asarray(v[0] - v[1])

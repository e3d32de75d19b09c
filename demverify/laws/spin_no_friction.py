"""Spheres that meet without slip at the contact point, or without friction: spins stay, and no sideways velocity arises.

omega' = omega, v_t' = v_t (Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, test 7: opposite spins, w1 = -w2 normal to the line of centres).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Greatest change of a spin, and greatest sideways velocity over the surface speed, of the first two particles."""
    first, last = frames[0], frames[-1]
    before, after = (frame.vectors("omegax", "omegay", "omegaz")[:2] for frame in (first, last))
    line = np.subtract(*first.vectors("x", "y", "z")[:2])
    line /= np.linalg.norm(line)
    dv = (last.vectors("vx", "vy", "vz") - first.vectors("vx", "vy", "vz"))[:2]
    sideways = dv - np.outer(dv @ line, line)
    surface = float((np.linalg.norm(before, axis=1) * first.columns["radius"][:2]).max())
    return [
        Measured("spin change", last.step, float(np.abs(after - before).max()), 0.0, float(np.abs(before).max())),
        Measured("sideways velocity", last.step, float(np.abs(sideways).max()), 0.0, surface),
    ]

"""A sphere without spin hits a plane obliquely and slides throughout: rigid-body impulse with P_t = mu P_n.

    v_n' = e v_n;  v_t' = v_t - mu (1 + e) v_n;  R w' = 5/2 mu (1 + e) v_n       (v_n impact speed)

Exact for gross sliding, i.e. tan(angle) >= mu (1 + e)/2 (7 - 1/kappa), kappa = 2 (1 - nu)/(2 - nu) (Maw et al.; Chung & Ooi 2011,
doi:10.1007/s10035-011-0277-0, tests 4 and 5), as long as the friction follows the whole normal force, its damping included.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], restitution: float, friction: float) -> list[Measured]:
    """Rebound of the first particle from a plane z = const, moving along x: e_n, tangential speed and spin about y."""
    first, last = frames[0], frames[-1]
    vn, vt = -float(first.columns["vz"][0]), float(first.columns["vx"][0])
    impulse = friction * (1.0 + restitution) * vn
    radius = float(first.columns["radius"][0])
    return [
        Measured("normal velocity", last.step, float(last.columns["vz"][0]), restitution * vn),
        Measured("tangential velocity", last.step, float(last.columns["vx"][0]), vt - float(np.sign(vt)) * impulse),
        Measured("spin", last.step, float(last.columns["omegay"][0]), float(np.sign(vt)) * 2.5 * impulse / radius),
    ]

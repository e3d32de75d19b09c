"""Two like spheres without spin meet obliquely, mirror images of one another, and slide throughout: impulse with P_t = mu P_n.

Each, along and across the line of centres: v_n' = e v_n; v_t' = v_t - mu (1 + e) v_n; R |w'| = 5/2 mu (1 + e) v_n (Chung & Ooi 2011,
doi:10.1007/s10035-011-0277-0, test 4 with a mirror for the wall). The line is that of the deepest overlap, about which the contact turns alike.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], restitution: float, friction: float) -> list[Measured]:
    """Outcome for the first sphere, that for the second as its mirror image, moving in the plane y = const."""
    first, last = frames[0], frames[-1]
    lines = [np.subtract(*frame.vectors("x", "y", "z")[:2]) for frame in frames]
    line = min(lines, key=lambda one: float(one @ one))
    line = line / np.linalg.norm(line)
    before, after = first.vectors("vx", "vy", "vz"), last.vectors("vx", "vy", "vz")
    vn = -float(before[0] @ line)
    sideways = before[0] + vn * line
    vt = float(np.linalg.norm(sideways))
    impulse, radius = friction * (1.0 + restitution) * vn, float(first.columns["radius"][0])
    spins = last.vectors("omegax", "omegay", "omegaz")
    return [
        Measured("normal velocity", last.step, float(after[0] @ line), restitution * vn),
        Measured("tangential velocity", last.step, float(after[0] @ sideways) / vt, vt - impulse),
        Measured("spin", last.step, float(np.linalg.norm(spins[0])), 2.5 * impulse / radius),
        Measured("mirror, velocity", last.step, float(np.abs(after[0] + after[1]).max()), 0.0, vt),
        Measured("mirror, spin", last.step, float(np.abs(spins[0] - spins[1]).max()), 0.0, 2.5 * impulse / radius),
    ]

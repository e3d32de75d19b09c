"""A ball on a slope, from rest. gravity g, slope s from the horizontal, friction mu, rolling resistance M = mu_r R N.

Rolls:  a = 5/7 g (sin s - mu_r cos s), R omega = v, if mu >= 2/7 tan s + 5/7 mu_r;  stays where mu_r >= tan s.
Slides: a = g (sin s - mu cos s), R omega' = 5/2 (mu - mu_r) g cos s, where mu is less.

(Coulomb's rolling friction; e.g. Y. C. Zhou et al., Physica A 269 (1999) 536, model A; rigid-body mechanics.)
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin

from demverify.frames import Frame
from demverify.laws import Measured


def measure(
    frames: Sequence[Frame], slope: float, friction: float, rolling: float, gravity: float, timestep: float
) -> list[Measured]:
    """Speed along x, way and spin about y of the first particle at the end, on a plane z = const. slope in degrees."""
    first, last = frames[0], frames[-1]
    t, radius = (last.step - first.step) * timestep, float(first.columns["radius"][0])
    along, normal = gravity * sin(radians(slope)), gravity * cos(radians(slope))
    a = alpha = 0.0
    if rolling * normal < along:
        if friction * normal >= 2.0 / 7.0 * along + 5.0 / 7.0 * rolling * normal:
            a = alpha = 5.0 / 7.0 * (along - rolling * normal)
        else:
            a, alpha = along - friction * normal, 2.5 * (friction - rolling) * normal
    scale = along * t
    return [
        Measured("speed", last.step, float(last.columns["vx"][0]), a * t, a * t or scale),
        Measured("way", last.step, float(last.columns["x"][0] - first.columns["x"][0]), 0.5 * a * t * t, 0.5 * t * (a * t or scale)),
        Measured("surface speed", last.step, float(last.columns["omegay"][0]) * radius, alpha * t, alpha * t or scale),
    ]

"""A sphere without friction and weight in a box of six walls: each coordinate for itself flies, meets a wall for half a period of its spring
and dashpot, and flies back with e times the speed (Schaefer, Dippel & Wolf 1996, doi:10.1051/jp1:1996129):

    flight (hi - lo - 2 R)/|v|;  contact d = (v/w) exp(-b s) sin(w s) for pi/w, b = c/(2m), w = sqrt(k/m - b^2);  e = exp(-pi b/w)

Each bounce hands (1 + e) m |v| to the wall."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, pi, sin, sqrt

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import positions, times, velocities


def measure(frames: Sequence[Frame], dt: float, stiffness: float, damping: float, lo: float, hi: float) -> list[Measured]:
    """First particle, all three coordinates, all frames: largest miss relative to the room it has, and the speeds at the end.

    damping: c/m [1/time]; lo, hi: the walls along x, y and z."""
    first, last = frames[0], frames[-1]
    mass, radius = float(first.columns["mass"][0]), float(first.columns["radius"][0])
    b = 0.5 * damping
    w = sqrt(stiffness / mass - b * b)
    worst, bounces = (0.0, first.step), 0
    speeds = []
    for axis in range(3):
        x0, v0 = float(positions(first)[0, axis]), float(velocities(first)[0, axis])
        legs = _legs(x0, v0, lo + radius, hi - radius, b, w, float(times(frames, dt)[-1]))
        for frame, t in zip(frames, times(frames, dt), strict=True):
            start, x, v, side = next(leg for leg in reversed(legs) if leg[0] <= t)
            s = t - start
            place = x + v * s if side == 0.0 else x + v / w * exp(-b * s) * sin(w * s)
            worst = max(worst, (abs(float(positions(frame)[0, axis]) - place), frame.step))
        bounces += sum(leg[3] != 0.0 for leg in legs)
        speeds.append(abs(legs[-1][2]) if legs[-1][3] == 0.0 else np.nan)
    fine = [axis for axis in range(3) if np.isfinite(speeds[axis])]
    if not bounces or not fine:
        message = "no bounce, or the last frame lies within one along every axis"
        raise LookupError(message)
    found = [Measured("path", worst[1], worst[0], 0.0, hi - lo - 2.0 * radius)]
    found += [Measured(f"speed along {'xyz'[axis]}", last.step, abs(float(velocities(last)[0, axis])), speeds[axis]) for axis in fine]
    return found


def _legs(x: float, v: float, low: float, high: float, b: float, w: float, end: float) -> list[tuple[float, float, float, float]]:
    """Of one coordinate: (start, position, velocity, side) by turns of flight (side 0) and contact (-1 at low, 1 at high)."""
    t, legs, e = 0.0, [], exp(-pi * b / w)
    while t <= end:
        legs.append((t, x, v, 0.0))
        if v == 0.0:
            break
        wall = high if v > 0.0 else low
        t, x = t + (wall - x) / v, wall
        legs.append((t, x, v, 1.0 if v > 0.0 else -1.0))
        t, v = t + pi / w, -e * v
    return [leg for leg in legs if leg[0] <= end]

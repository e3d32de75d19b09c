"""Undamped contacts do not know the direction of time: before and after the turning point T of an impact the distance runs through the same
values, d(T + s) = d(T - s) and d'(T + s) = -d'(T - s) (Landau & Lifshitz, Mechanics, par. 5; velocity Verlet is symmetric too)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import positions, times, velocities


def measure(frames: Sequence[Frame], dt: float) -> list[Measured]:
    """Of the distance of the first two particles that meet head on: largest asymmetry over the frames, relative to the largest change of
    distance and to the speed. T: where the approach speed goes through zero."""
    from scipy.interpolate import CubicHermiteSpline  # positions and velocities are both known

    t = times(frames, dt)
    apart = np.array([positions(frame)[1] - positions(frame)[0] for frame in frames])
    moving = np.array([velocities(frame)[1] - velocities(frame)[0] for frame in frames])
    distance = np.linalg.norm(apart, axis=1)
    speed = (apart * moving).sum(axis=1) / distance
    turn = int(np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))[0])
    path = CubicHermiteSpline(t, distance, speed)
    middle = t[turn] - speed[turn] * (t[turn + 1] - t[turn]) / (speed[turn + 1] - speed[turn])
    reach = min(middle - t[0], t[-1] - middle)
    before = np.array([middle - s for s in np.linspace(0.0, reach, 400)])
    after = 2.0 * middle - before
    worst = float(np.abs(path(after) - path(before)).max())
    slope = path.derivative()
    fastest = float(np.abs(slope(after) + slope(before)).max())
    return [
        Measured("distance before and after", frames[turn].step, worst, 0.0, float(np.ptp(distance))),
        Measured("speed before and after", frames[turn].step, fastest, 0.0, float(np.abs(speed).max())),
    ]

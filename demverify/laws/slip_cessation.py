"""A ball thrown along a plane without spin slips, then rolls: u = 5/7 u0, omega = u/R, reached at t = 2 u0 / (7 mu g).

Whatever the friction, for angular momentum about the line of contact stays (MFIX-DEM V&V, DEM-04; Coriolis).
"""

from __future__ import annotations

from collections.abc import Sequence

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Speed along x and spin about y of the first particle at the end, on a plane z = const."""
    first, last = frames[0], frames[-1]
    rolling = 5.0 / 7.0 * float(first.columns["vx"][0])
    radius = float(first.columns["radius"][0])
    return [
        Measured("rolling velocity", last.step, float(last.columns["vx"][0]), rolling),
        Measured("rolling spin", last.step, float(last.columns["omegay"][0]), rolling / radius),
    ]

"""Clumps whose mass and inertia are the sums over their spheres, as if none overlapped: by contacts among them neither the total momentum nor the
angular momentum about the common centre of mass changes, and gravity changes the former alone, by M g t  (Goldstein, Classical Mechanics, eqs. 1-22
and 1-28; compute-erotate, eq. 5). LIGGGHTS writes the mass of the whole clump beside every sphere; here a sphere has that of its density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi

from demverify.frames import Frame, by_step
from demverify.laws import Measured, angular_momentum, momentum_balance

INERTIA = 0.4
"""I/(m R^2) of spheres."""


def measure(frames: Sequence[Frame], dt: float, density: float, gravity: float, until: float) -> list[Measured]:
    """Largest misses over the frames up to step `until`, after which something else may act. gravity: along -z."""
    series = list(by_step(frames).values())  # LIGGGHTS inserts in a step of its own, and counts from 0 again
    kept = [_weighed(frame, density) for frame in series if frame.step - series[0].step <= until]
    return [
        *momentum_balance.measure(kept, dt, gravity, 0.0, 0.0, -1.0),
        *angular_momentum.measure(kept, dt, gravity, 0.0, 0.0, -1.0, INERTIA),
    ]


def _weighed(frame: Frame, density: float) -> Frame:
    return replace(frame, columns={**frame.columns, "mass": density * 4.0 / 3.0 * pi * frame.columns["radius"] ** 3})

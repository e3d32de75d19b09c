"""A sphere on a wall that slides along itself with velocity V slips, then rolls. With s0 = V - (u0 - R w0 x n), the slip at the start, friction
mu g speeds it up by J = (2/7) s0, for the slip falls by (1/m + R^2/I) times the impulse, 7/(2 m):

    u(t) = u0 + mu g t J/|J| while it slips;   in the end u = u0 + J, w = w0 + (5/2) J x n/R, rolling from t = 2 |s0|/(7 mu g) on

From rest: u = 2/7 V, |w| = 5/7 V/R. Angular momentum about the line of contact stays (Coriolis 1835; MFIX-DEM V&V, DEM-04, in the frame of
the wall)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import spins, times, velocities


def measure(
    frames: Sequence[Frame], dt: float, friction: float, gravity: float, vx: float, vy: float, vz: float, nx: float, ny: float, nz: float
) -> list[Measured]:
    """Velocity and spin of the first particle: the largest misses while it slips, relative to |J|, and the end. v: of the wall; n: from the
    wall to the sphere, against gravity."""
    normal = np.array([nx, ny, nz]) / np.linalg.norm([nx, ny, nz])
    radius = float(frames[0].columns["radius"][0])
    u0, w0 = velocities(frames[0])[0], spins(frames[0])[0]
    slip = np.array([vx, vy, vz]) - (u0 - radius * np.cross(w0, normal))
    slip -= (slip @ normal) * normal
    gain = 2.0 / 7.0 * slip
    size = float(np.linalg.norm(gain))
    worst = (0.0, frames[0].step)
    for frame, t in zip(frames, times(frames, dt), strict=True):
        share = friction * gravity * t / size
        if share < 1.0:
            worst = max(worst, (float(np.abs(velocities(frame)[0] - u0 - share * gain).max()), frame.step))
    last = frames[-1]
    turned = w0 + 2.5 / radius * np.cross(gain, normal)  # friction J at -R n: torque -R n x J
    missed, spin = velocities(last)[0] - u0 - gain, spins(last)[0] - turned
    return [
        Measured("velocity while it slips", worst[1], worst[0], 0.0, size),
        Measured("velocity of rolling", last.step, float(np.abs(missed).max()), 0.0, size),
        Measured("spin of rolling", last.step, float(np.abs(spin).max()), 0.0, 2.5 * size / radius),
    ]

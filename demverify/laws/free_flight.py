"""Free flight: r = r0 + v0 t - g t^2/2, v = v0 - g t (Galilei). Velocity Verlet is exact for a constant force, so only rounding remains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], gravity: float, timestep: float) -> list[Measured]:
    """Position and velocity of every particle over all frames, gravity along -z: the largest deviation, relative to the largest distance
    travelled and the largest speed; and the force over the weight."""
    first, down = frames[0], np.array([0.0, 0.0, -gravity])
    times = np.array([frame.step - first.step for frame in frames])[:, None, None] * timestep
    x, v, f = (
        np.array([frame.vectors(*names) for frame in frames]) for names in (("x", "y", "z"), ("vx", "vy", "vz"), ("fx", "fy", "fz"))
    )
    path, speed = v[0] * times + 0.5 * down * times**2, v[0] + down * times
    weight = first.columns["mass"][:, None] * down
    return [
        _worst("position", frames, x - x[0], path),
        _worst("velocity", frames, v, speed),
        _worst("force", frames, f, np.broadcast_to(weight, f.shape)),
    ]


def _worst(name: str, frames: Sequence[Frame], measured: np.ndarray, expected: np.ndarray) -> Measured:
    at = np.unravel_index(int(np.abs(measured - expected).argmax()), measured.shape)
    return Measured(name, frames[int(at[0])].step, float(measured[at]), float(expected[at]), float(np.abs(expected).max()))

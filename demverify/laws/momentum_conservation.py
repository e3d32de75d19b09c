"""Without outer forces momentum and angular momentum stay: sum m v, sum (m x * v + 2/5 m R^2 omega)  (Newton's third law, spheres)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import angular_momentum, momentum, positions, spins, velocities

INERTIA = 0.4
"""I/(m R^2) of spheres."""


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Greatest drift over all frames, relative to the sums of the sizes at first."""
    linear = np.array([momentum(frame) for frame in frames])
    angular = np.array([sum(angular_momentum(frame, INERTIA)) for frame in frames])
    sizes = _sizes(frames[0])
    drifts = [np.abs(total - total[0]).max(axis=1) for total in (linear, angular)]
    columns = zip(("momentum", "angular momentum"), drifts, sizes, strict=True)
    return [largest_miss(name, frames, drift, size) for name, drift, size in columns]


def _sizes(frame: Frame) -> tuple[float, float]:
    """Sums of the sizes of the momenta, and of the angular momenta about the origin, of the spin, and of R times the momenta."""
    mass, radius = frame.columns["mass"][:, None], frame.columns["radius"][:, None]
    p = mass * velocities(frame)
    turning = np.vstack([np.cross(positions(frame), p), INERTIA * mass * radius**2 * spins(frame), radius * p])
    return float(np.linalg.norm(p, axis=1).sum()), float(np.linalg.norm(turning, axis=1).sum())

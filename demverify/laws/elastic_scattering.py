"""Elastic spheres that touch nothing in the first and the last frame: momentum and kinetic energy are what they were (Newton, Huygens).

Positions are not asked for: it holds in a periodic box too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import kinetic_energy, momentum, velocities

INERTIA = 0.4
"""I/(m R^2) of spheres."""


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Of all particles, at the end: momentum relative to the sum of its sizes at the start, kinetic energy."""
    first, last = frames[0], frames[-1]
    size = float((first.columns["mass"] * np.linalg.norm(velocities(first), axis=1)).sum())
    drift = float(np.abs(momentum(last) - momentum(first)).max())
    return [
        Measured("momentum", last.step, drift, 0.0, size),
        Measured("kinetic energy", last.step, kinetic_energy(last, INERTIA), kinetic_energy(first, INERTIA)),
    ]

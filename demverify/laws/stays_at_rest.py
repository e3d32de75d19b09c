"""What rests, held by friction and rolling resistance, stays where it is: no drift, no creep, no spin-up (statics).

The first tenth of the frames is left for springs to be wound and damped.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, spins, velocities

WINDS = 0.1


def measure(frames: Sequence[Frame], gravity: float) -> list[Measured]:
    """All particles: the way since a tenth of the run, over the smallest radius; the largest speed, over that of a radius' fall; the spin in
    the same measure, R omega."""
    later = frames[int(WINDS * len(frames)) :]
    first = later[0]
    radius = first.columns["radius"]
    fall = float(np.sqrt(2.0 * gravity * radius.min()))
    ways = [float(np.abs(positions(frame) - positions(first)).max()) for frame in later]
    speeds = [float(np.abs(velocities(frame)).max()) for frame in later]
    turns = [float(np.abs(radius[:, None] * spins(frame)).max()) for frame in later]
    return [
        largest_miss("drift", later, ways, float(radius.min())),
        largest_miss("speed", later, speeds, fall),
        largest_miss("spin", later, turns, fall),
    ]

"""What the arms of a contact do to the angular momentum: torques -c_i n x F and -c_j n x F beside forces +-F at the distance d leave

    dL/dt = (d - c_i - c_j) n x F          n from the second sphere to the first, F on the first

c = R ("radius"): minus overlap times friction (LAMMPS' pairs gran/*); arms to the contact point ("contact"), c_i + c_j = d: nothing.
Follows from L = sum m x x v + I w (Goldstein, Classical Mechanics, eq. 1-26); velocity Verlet takes the mean torque of two steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import angular_momentum, positions, times


def measure(frames: Sequence[Frame], dt: float, arm: Literal["radius", "contact"]) -> list[Measured]:
    """Two spheres alone, a frame at every step: change of the angular momentum against the sum over the steps, its largest miss relative to
    the angular momentum about the centre that there is; and what was left over in the end, against that sum."""
    left = np.array([_left(frame, arm) for frame in frames])
    steps = np.diff(times(frames, dt))[:, None]
    expected = np.vstack([np.zeros(3), np.cumsum(0.5 * steps * (left[1:] + left[:-1]), axis=0)])
    parts = [angular_momentum(frame, 0.4) for frame in frames]
    total = np.array([sum(three) for three in parts])
    changed = total - total[0]
    size = max(float(np.linalg.norm(orbital) + np.linalg.norm(spin)) for _, orbital, spin in parts)
    off = np.abs(changed - expected).max(axis=1)
    return [
        largest_miss("change of the angular momentum", frames, off, size),
        Measured("angular momentum left over", frames[-1].step, float(np.linalg.norm(changed[-1])), float(np.linalg.norm(expected[-1])), size),
    ]


def _left(frame: Frame, arm: str) -> np.ndarray:
    apart = positions(frame)[0] - positions(frame)[1]
    distance = float(np.linalg.norm(apart))
    overlap = float(frame.columns["radius"][:2].sum()) - distance
    if arm == "contact" or overlap <= 0.0:
        return np.zeros(3)
    return np.asarray(-overlap * np.cross(apart / distance, frame.vectors("fx", "fy", "fz")[0]))

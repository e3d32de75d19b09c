"""Angular momentum about the origin, L = M R x V + sum m r' x v' + sum I w: contacts whose torques fit their forces leave
orbital + spin about the centre of mass alone, and uniform gravity acts on M R x V only:

    L(t) = L(0) + M (R0 x g) t + M (V0 x g) t^2/2 (+ 0, as g x g = 0)      about the centre: constant

(primer, appendix A; Goldstein, Classical Mechanics, eq. 1-28). A contact at distance c_i and c_j from the centres leaves
(d - c_i - c_j) n x F_t over, nothing where the arms add up to the distance d."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import angular_momentum, center, times


def measure(frames: Sequence[Frame], dt: float, gravity: float, x: float, y: float, z: float, inertia: float) -> list[Measured]:
    """Largest misses over all frames, relative to the largest |spin| + |orbital| + |centre|. inertia: I/(m r^2), 0.4 of spheres."""
    along = np.array([x, y, z])
    g = gravity * along / np.linalg.norm(along)
    mass = float(frames[0].columns["mass"].sum())
    where, speed = center(frames[0])
    parts = [angular_momentum(frame, inertia) for frame in frames]
    size = max(sum(float(np.linalg.norm(part)) for part in three) for three in parts)
    about = max(float(np.linalg.norm(orbital) + np.linalg.norm(spin)) for _, orbital, spin in parts)
    start, inner = sum(parts[0]), parts[0][1] + parts[0][2]
    expected = [start + mass * (np.cross(where, g) * t + 0.5 * np.cross(speed, g) * t * t) for t in times(frames, dt)]
    missed = [np.abs(sum(three) - total).max() for three, total in zip(parts, expected, strict=True)]
    own = [np.abs(orbital + spin - inner).max() for _, orbital, spin in parts]
    return [
        largest_miss("angular momentum about the origin", frames, missed, size),
        largest_miss("orbital + spin about the centre", frames, own, about),
    ]

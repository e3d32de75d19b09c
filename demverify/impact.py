"""A straight impact as the frames of a run show it: two spheres along the line of their centres, or one sphere and the plane z = 0.

Before and after the contact nothing acts (no gravity), so the moments of touch and of parting follow from single frames, exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log, pi, sqrt

import numpy as np

from demverify.frames import Floats, Frame


@dataclass(frozen=True)
class Impact:
    """Frame by frame, arrays over the frames. overlap: negative while apart. rate: its time derivative. force: on the first sphere.

    radius, mass: the reduced ones, R* and m*; of a plane, those of the sphere."""

    steps: Floats
    overlap: Floats
    rate: Floats
    force: Floats
    radius: float
    mass: float

    @classmethod
    def of(cls, frames: Sequence[Frame]) -> Impact:
        """Reads a run of two spheres, or of one and the plane z = 0."""
        radius, mass = (frames[0].columns[name][:2] for name in ("radius", "mass"))
        seen = np.array([_seen(frame) for frame in frames])
        return cls(np.array([float(f.step) for f in frames]), *seen.T, *(float(1.0 / (1.0 / column).sum()) for column in (radius, mass)))

    @property
    def speed(self) -> float:
        """Of approach, at the start."""
        return float(self.rate[0])

    @property
    def restitution(self) -> float:
        """Speed of parting over speed of approach."""
        return float(-self.rate[-1] / self.rate[0])

    def duration(self, timestep: float) -> float:
        """Time of contact, from free flight before and after it."""
        touch = self.steps[0] * timestep - self.overlap[0] / self.rate[0]
        part = self.steps[-1] * timestep - self.overlap[-1] / self.rate[-1]
        return float(part - touch)

    @property
    def deepest(self) -> int:
        """The frame of the largest overlap."""
        return int(np.argmax(self.overlap))


def damping_ratio(restitution: float) -> float:
    """b = -ln e / sqrt(pi^2 + ln^2 e): of the linear oscillator that leaves with e times its speed after half a swing; on a Hertz spring too, in the
    variable overlap^(5/4) (Antypov & Elliott 2011, doi:10.1209/0295-5075/94/50004). restitution: e, above 0 and up to 1."""
    lost = 0.0 - log(restitution)
    return lost / sqrt(pi**2 + lost**2)


def peak(values: Floats) -> float:
    """The top of a curve, by the parabola through its highest point and the neighbours."""
    at = int(np.argmax(values))
    if not 0 < at < len(values) - 1:
        return float(values[at])
    left, top, right = values[at - 1 : at + 2]
    bend = left - 2.0 * top + right
    return float(top - (right - left) ** 2 / (8.0 * bend)) if bend else float(top)


def _seen(frame: Frame) -> tuple[float, float, float]:
    """Overlap, its rate, and the force on the first sphere."""
    x, v, f = (frame.vectors(*names) for names in (("x", "y", "z"), ("vx", "vy", "vz"), ("fx", "fy", "fz")))
    radius = frame.columns["radius"]
    if frame.n == 1:
        return float(radius[0] - x[0, 2]), float(-v[0, 2]), float(f[0, 2])
    line = x[0] - x[1]
    distance = float(np.linalg.norm(line))
    return float(radius[:2].sum()) - distance, float(-(v[0] - v[1]) @ line / distance), float(f[0] @ line / distance)

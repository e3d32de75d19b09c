"""Without outer forces momentum and angular momentum stay: sum m v, sum (m x * v + 2/5 m R^2 omega)  (Newton's third law, spheres)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Greatest drift over all frames, relative to the sums of the sizes at first."""
    (p0, l0, p_size, l_size), last = _sums(frames[0]), frames[-1].step
    drift_p = max(float(np.abs(_sums(frame)[0] - p0).max()) for frame in frames)
    drift_l = max(float(np.abs(_sums(frame)[1] - l0).max()) for frame in frames)
    return [Measured("momentum", last, drift_p, 0.0, p_size), Measured("angular momentum", last, drift_l, 0.0, l_size)]


def _sums(frame: Frame) -> tuple[Floats, Floats, float, float]:
    """Momentum, angular momentum about the origin, and the sums of their parts' sizes."""
    mass, radius = frame.columns["mass"][:, None], frame.columns["radius"][:, None]
    p = mass * frame.vectors("vx", "vy", "vz")
    parts = np.vstack([np.cross(frame.vectors("x", "y", "z"), p), 0.4 * mass * radius**2 * frame.vectors("omegax", "omegay", "omegaz")])
    size = float(np.linalg.norm(p, axis=1) @ frame.columns["radius"] + np.linalg.norm(parts, axis=1).sum())
    return p.sum(axis=0), parts.sum(axis=0), float(np.linalg.norm(p, axis=1).sum()), size

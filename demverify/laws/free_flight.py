"""Spheres that touch nothing: v = v0 + g t, x = x0 + v0 t + g t^2/2, spins stay (Galilei). Velocity Verlet is exact here.

Directions of g: vector (a, b, c), normalised; chute: tilted by a degrees from -z towards +x; spherical: a = phi, b = theta in degrees,
(sin theta cos phi, sin theta sin phi, cos theta) (LAMMPS and LIGGGHTS manuals, fix gravity)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured
from demverify.mechanics import positions, spins, times, velocities


def measure(
    frames: Sequence[Frame], dt: float, gravity: float, style: Literal["vector", "chute", "spherical"], a: float, b: float, c: float
) -> list[Measured]:
    """All particles: largest misses over all frames, relative to the largest speed, path and spin."""
    g, first = gravity * _direction(style, a, b, c), frames[0]
    where, start, turning = positions(first), velocities(first), spins(first)
    found = np.array(
        [
            [
                np.abs(velocities(frame) - start - g * t).max(),
                np.abs(positions(frame) - where - start * t - 0.5 * g * t * t).max(),
                np.abs(spins(frame) - turning).max(),
            ]
            for frame, t in zip(frames, times(frames, dt), strict=True)
        ]
    )
    at = found.argmax(axis=0)
    speed = max(float(np.abs(velocities(frame)).max()) for frame in frames)
    path = max(float(np.abs(positions(frame) - where).max()) for frame in frames)
    scales = (speed, path, max(float(np.abs(turning).max()), 1.0))
    names = ("velocity", "path", "spin")
    return [Measured(name, frames[at[k]].step, float(found[at[k], k]), 0.0, scales[k]) for k, name in enumerate(names)]


def _direction(style: str, a: float, b: float, c: float) -> Floats:
    if style == "vector":
        return np.asarray(np.array([a, b, c]) / np.linalg.norm([a, b, c]))
    phi, theta = np.radians([a, b]) if style == "spherical" else (0.0, np.pi - np.radians(a))
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])

"""Spheres that touch nothing: v = v0 + g t, x = x0 + v0 t + g t^2/2, spins stay (Galilei). Velocity Verlet is exact here.

Semi-implicit Euler (v += dt g, then x += dt v) is ahead of the parabola by g t dt/2, exactly: x_n = x_0 + v_0 n dt + g dt^2 n (n + 1)/2.

Directions of g: vector (a, b, c), normalised; chute: tilted by a degrees from -z towards +x; spherical: a = phi, b = theta in degrees,
(sin theta cos phi, sin theta sin phi, cos theta) (LAMMPS and LIGGGHTS manuals, fix gravity)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured
from demverify.mechanics import largest_misses_of_paths, velocities


def measure(
    frames: Sequence[Frame], dt: float, gravity: float, style: Literal["vector", "chute", "spherical"], a: float, b: float, c: float,
    integrator: Literal["verlet", "euler"],
) -> list[Measured]:  # fmt: skip
    """All particles: largest misses over all frames, relative to the largest speed, path and spin. integrator: whose path it is."""
    g, start = gravity * _direction(style, a, b, c), velocities(frames[0])
    ahead = 0.5 * dt if integrator == "euler" else 0.0
    return largest_misses_of_paths(frames, dt, lambda t: (start + g * t, start * t + 0.5 * g * t * t + g * t * ahead))


def _direction(style: str, a: float, b: float, c: float) -> Floats:
    if style == "vector":
        return np.asarray(np.array([a, b, c]) / np.linalg.norm([a, b, c]))
    phi, theta = np.radians([a, b]) if style == "spherical" else (0.0, np.pi - np.radians(a))
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])

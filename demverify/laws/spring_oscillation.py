"""A sphere that never leaves one or two walls is a damped oscillator about x_eq (linear spring and dashpot; Landau & Lifshitz, Mechanics,
par. 25): m x'' = -K (x - x_eq) - C x', K and C summed over the walls, x_eq = lo + R - m g/k on a floor, halfway plus -m g/(2 k) between two.

    b = C/(2m), w0^2 = K/m:  b < w0 swings with w = sqrt(w0^2 - b^2),  b = w0 creeps back as (1 + b t) exp(-b t),  b > w0 slower still"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, times, velocities


def measure(
    frames: Sequence[Frame], dt: float, stiffness: float, damping: float, gravity: float, lo: float, hi: float,
    walls: Literal["one", "two"], axis: Literal["x", "y", "z"],
) -> list[Measured]:  # fmt: skip
    """First particle along `axis`: position and velocity over time, relative to the amplitude and to w0 times it. stiffness, damping
    [1/time]: of one wall, k and c/m. gravity points down the axis. lo, hi: of the walls; hi is not used with one."""
    first, along, count = frames[0], "xyz".index(axis), 1.0 if walls == "one" else 2.0
    mass, radius = float(first.columns["mass"][0]), float(first.columns["radius"][0])
    rest = (lo + radius if walls == "one" else 0.5 * (lo + hi)) - mass * gravity / (count * stiffness)
    b, w0 = 0.5 * count * damping, sqrt(count * stiffness / mass)
    x0, v0 = float(positions(first)[0, along]) - rest, float(velocities(first)[0, along])
    t = times(frames, dt)
    w = np.emath.sqrt(w0 * w0 - b * b)  # imaginary when overdamped
    swing, lag = np.cos(w * t), (np.sin(w * t) / w if abs(w) > 1e-6 * w0 else t)
    x = np.real(np.exp(-b * t) * (x0 * swing + (v0 + b * x0) * lag))
    v = np.real(np.exp(-b * t) * (v0 * swing - (b * v0 + w0 * w0 * x0) * lag))
    off = np.abs(np.array([positions(frame)[0, along] for frame in frames]) - rest - x)
    slip = np.abs(np.array([velocities(frame)[0, along] for frame in frames]) - v)
    size = max(abs(x0), abs(v0) / w0)
    return [largest_miss("position", frames, off, size), largest_miss("velocity", frames, slip, size * w0)]

"""Spheres in a row along x, linear or Hertz contacts between neighbours: the equations of motion m_i x_i'' = F_(i-1,i) - F_(i,i+1), integrated
here to 1e-12, F = k d + c m* d' or sqrt(R*) (k d^(3/2) + c m* d^(1/2) d') (Herrmann & Seitz 1982, doi:10.1119/1.12936: why a touching row of
springs does not hand on all of its momentum, as hard spheres do)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, times, velocities


def measure(frames: Sequence[Frame], dt: float, normal: Literal["hooke", "hertz"], stiffness: float, damping: float) -> list[Measured]:
    """All particles, ids in the order of the row: paths and velocities, relative to the largest path and speed. stiffness: k; damping: c."""
    from scipy.integrate import solve_ivp

    first = frames[0]
    mass, radius, n = first.columns["mass"], first.columns["radius"], first.n
    touch = radius[:-1] + radius[1:]
    reduced = mass[:-1] * mass[1:] / (mass[:-1] + mass[1:])
    curvature = np.sqrt(radius[:-1] * radius[1:] / touch)

    def slope(_: float, state: Floats) -> Floats:
        x, v = state[:n], state[n:]
        overlap, rate = touch - np.diff(x), -np.diff(v)
        d = np.maximum(overlap, 0.0)
        if normal == "hooke":
            force = stiffness * d + damping * reduced * rate * (overlap > 0.0)
        else:
            force = curvature * np.sqrt(d) * (stiffness * d + damping * reduced * rate)
        return np.concatenate([v, (np.append(0.0, force) - np.append(force, 0.0)) / mass])

    t = times(frames, dt)
    start = np.concatenate([positions(first)[:, 0], velocities(first)[:, 0]])
    longest = float(t[-1]) / 2000.0
    known = solve_ivp(slope, (0.0, float(t[-1])), start, t_eval=t, rtol=1e-10, atol=1e-14, max_step=longest, method="DOP853").y.T
    x = np.array([positions(frame)[:, 0] for frame in frames])
    v = np.array([velocities(frame)[:, 0] for frame in frames])
    off, slip = np.abs(x - known[:, :n]).max(axis=1), np.abs(v - known[:, n:]).max(axis=1)
    path, speed = float(np.abs(x - x[0]).max()), float(np.abs(v).max())
    return [
        largest_miss("positions", frames, off, path),
        largest_miss("velocities", frames, slip, speed),
        Measured("velocities at the end", frames[-1].step, float(slip[-1]), 0.0, speed),
    ]

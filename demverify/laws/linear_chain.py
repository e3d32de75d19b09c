"""Spheres one on the other, pressed between the floor z = 0 and a ceiling, all contacts linear springs and dashpots that never open
(two spheres: MFIX-DEM V&V, DEM-03).

    m_i z_i'' = -m_i g + f_i - f_(i+1),  f_i = k d_i - c_i (rate of opening),  c_i = 2 b sqrt(k m*_i),  b = -ln e / sqrt(pi^2 + ln^2 e)

with d_i the overlap below sphere i; m* is m at floor and ceiling. Linear, so its solution is a matrix exponential.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Floats, Frame
from demverify.impact import damping_ratio
from demverify.laws import Measured


def measure(frames: Sequence[Frame], stiffness: float, restitution: float, gravity: float, ceiling: float, timestep: float) -> list[Measured]:
    """Height and velocity of every sphere, where it is farthest from the law; relative to the largest displacement and velocity."""
    from scipy.linalg import expm

    matrix, constant = _system(frames[0], stiffness, restitution, gravity, ceiling)
    n = frames[0].n
    start = np.concatenate([frames[0].columns["z"], frames[0].columns["vz"]])
    rest = np.linalg.solve(matrix, -constant)
    measured = np.array([np.concatenate([frame.columns["z"], frame.columns["vz"]]) for frame in frames])
    times = np.array([frame.step - frames[0].step for frame in frames]) * timestep
    expected = np.array([rest + expm(matrix * time) @ (start - rest) for time in times])
    scales = np.abs(expected[:, :n] - rest[:n]).max(), np.abs(expected[:, n:]).max()
    worst = np.abs(measured - expected).argmax(axis=0)
    return [
        Measured(f"{name} {i + 1}", frames[at].step, float(measured[at, column]), float(expected[at, column]), float(scale))
        for k, (name, scale) in enumerate(zip(("height", "velocity"), scales, strict=True))
        for i, (column, at) in enumerate((k * n + i, worst[k * n + i]) for i in range(n))
    ]


def _system(frame: Frame, stiffness: float, restitution: float, gravity: float, ceiling: float) -> tuple[Floats, Floats]:
    """A and c of y' = A y + c, y = heights and velocities."""
    radius, mass, n = frame.columns["radius"], frame.columns["mass"], frame.n
    ratio = damping_ratio(restitution)
    pairs = mass[1:] * mass[:-1] / (mass[1:] + mass[:-1])
    dashpots = 2.0 * ratio * np.sqrt(stiffness * np.concatenate([mass[:1], pairs, mass[-1:]]))
    opening = np.zeros((n + 1, n))  # contact x sphere: what the gap grows by
    opening[np.arange(n), np.arange(n)] = 1.0
    opening[np.arange(1, n + 1), np.arange(n)] = -1.0
    closed = np.concatenate([radius[:1], radius[1:] + radius[:-1], [radius[-1] - ceiling]])  # overlap with all heights at 0
    push = opening.T  # what a contact's force does to the spheres
    matrix, constant = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -(push @ (stiffness * opening)) / mass[:, None]
    matrix[n:, n:] = -(push @ (dashpots[:, None] * opening)) / mass[:, None]
    constant[n:] = push @ (stiffness * closed) / mass - gravity
    return matrix, constant

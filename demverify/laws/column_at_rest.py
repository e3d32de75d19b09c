"""Spheres one on the other on the floor z = 0, at rest: each contact carries the weight above it (hydrostatics of a column, statics).

    N_i = g sum_(j >= i) m_j;  overlap N/k (linear), (N / (k sqrt(R*)))^(2/3) (Hertz); R* = R at the floor

N_i: force in the contact below sphere i.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], normal: Literal["hooke", "hertz"], stiffness: float, gravity: float) -> list[Measured]:
    """The force in each contact, from its overlap, and what the forces on each sphere leave over, at the end; particles from below.

    stiffness: hooke [force/length], hertz 4/3 E* [pressure]."""
    last = frames[-1]
    radius, mass, z = (last.columns[name] for name in ("radius", "mass", "z"))
    overlap = np.concatenate([[radius[0] - z[0]], radius[1:] + radius[:-1] - np.diff(z)])
    reduced = np.concatenate([radius[:1], radius[1:] * radius[:-1] / (radius[1:] + radius[:-1])])
    force = stiffness * overlap if normal == "hooke" else stiffness * np.sqrt(reduced) * np.maximum(overlap, 0.0) ** 1.5
    weight = gravity * np.cumsum(mass[::-1])[::-1]
    names = ["floor", *(f"contact {i}" for i in range(1, len(mass)))]
    left = float(np.abs(last.columns["fz"]).max())
    return [
        *(Measured(f"force at {name}", last.step, float(n), float(w)) for name, n, w in zip(names, force, weight, strict=True)),
        Measured("force left over", last.step, left, 0.0, float(gravity * mass.max())),
    ]

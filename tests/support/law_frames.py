"""Frames made by hand, for closed forms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from demverify.frames import Frame
from demverify.laws import Measured


def frame(
    step: int,
    x: ArrayLike,
    v: ArrayLike,
    w: ArrayLike | None = None,
    mass: ArrayLike = 1.0,
    radius: ArrayLike = 0.5,
    edge: float = 0.0,
) -> Frame:
    """Spheres at x (n, 3) with velocities v and spins w. edge: of a periodic cube about the origin, if there is one."""
    x, v = np.array(x, dtype=float).reshape(-1, 3), np.array(v, dtype=float).reshape(-1, 3)
    n = len(x)
    w = np.zeros((n, 3)) if w is None else np.array(w, dtype=float).reshape(-1, 3)
    columns = {"id": np.arange(1.0, n + 1), "type": np.ones(n), "mass": np.ones(n) * mass, "radius": np.ones(n) * radius}
    for names, values in (("x y z", x), ("vx vy vz", v), ("omegax omegay omegaz", w)):
        columns |= {name: values[:, k] for k, name in enumerate(names.split())}
    half = edge / 2.0 if edge else 100.0
    return Frame(step, np.array([[-half, half]] * 3), ("pp",) * 3 if edge else ("ff",) * 3, columns)  # type: ignore[arg-type]


def off(found: Sequence[Measured]) -> dict[str, float]:
    """Relative difference of each quantity, as the comparison judges it."""
    return {one.quantity: abs(one.measured - one.expected) / (one.scale if one.scale is not None else abs(one.expected)) for one in found}

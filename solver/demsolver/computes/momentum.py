"""Linear and angular momentum: what no internal force may change (DEM primer, appendix A)."""

from __future__ import annotations

import numpy as np

from demsolver.state import Floats


def momentum(mass: Floats, v: Floats) -> Floats:
    """mass (n,), v (n, 3) -> sum of m v, (3,)."""
    return np.asarray(mass @ v)


def angular_momentum(mass: Floats, x: Floats, v: Floats, inertia: Floats, omega: Floats) -> Floats:
    """Orbit and spin about the origin: sum of m x × v + I omega, (3,). x must be unwrapped; inertia (n,)."""
    return np.asarray(mass @ np.cross(x, v) + inertia @ omega)

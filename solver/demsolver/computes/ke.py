"""Translational kinetic energy, as LAMMPS' and LIGGGHTS' `compute ke`: sum of m v^2 / 2."""

from __future__ import annotations

import numpy as np

from demsolver.state import Floats


def ke(mass: Floats, v: Floats) -> float:
    """mass (n,), v (n, 3) -> energy."""
    return 0.5 * float(np.einsum("i,ij,ij->", mass, v, v))

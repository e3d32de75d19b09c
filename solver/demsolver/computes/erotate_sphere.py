"""Rotational energy of free spheres, as `compute erotate/sphere`: sum of I omega^2 / 2 with I = 2/5 m R^2.

Both engines use 2/5 here also for discs in two dimensions. Point particles (R = 0) count nothing. Source: seed compute-erotate, eq. (4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import Particles
from demsolver.state import Floats

INERTIA = 0.4


def erotate_sphere(mass: Floats, radius: Floats, omega: Floats) -> float:
    """mass, radius (n,), omega (n, 3) [rad/time] -> energy."""
    return 0.5 * INERTIA * float(np.einsum("i,ij,ij->", mass * radius**2, omega, omega))


def owned(particles: Particles) -> NDArray[np.bool_]:
    """Particles this compute counts: every one that no other shape claims."""
    return np.ones(len(particles.id), dtype=bool)


def energy(particles: Particles, mine: NDArray[np.bool_]) -> float:
    """Rotational energy of the particles marked in `mine`."""
    return erotate_sphere(particles.mass[mine], particles.radius[mine], particles.omega[mine])

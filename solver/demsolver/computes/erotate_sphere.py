"""Rotational energy of free spheres, as `compute erotate/sphere`: sum of I omega^2 / 2 with I = 2/5 m R^2.

Both engines use 2/5 here also for discs in two dimensions. Point particles (R = 0) count nothing. Source: seed compute-erotate, eq. (4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.population import Energies, Population
from demsolver.state import Floats

INERTIA = 0.4
NEEDS = (("mass", "radius", "omega"),)


def erotate_sphere(mass: Floats, radius: Floats, omega: Floats) -> Floats:
    """mass, radius (n,), omega (n, 3) [rad/time] -> energy of each, (n,)."""
    return np.asarray(0.5 * INERTIA * (mass * radius**2) * np.einsum("ij,ij->i", omega, omega))


def owned(population: Population) -> NDArray[np.bool_]:
    """Particles this compute counts: every one that no other shape claims."""
    return np.ones(len(population.id), dtype=bool)


def energies(population: Population, mine: NDArray[np.bool_]) -> Energies:
    """Rotational energies of the particles marked in `mine`."""
    mass, radius, omega = population.of("mass", mine), population.of("radius", mine), population.of("omega", mine)
    return Energies(population.id[mine], erotate_sphere(mass, radius, omega))

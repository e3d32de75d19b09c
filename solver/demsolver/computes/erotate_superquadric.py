"""Rotational energy of free superquadrics and ellipsoids: E = omega . I omega / 2, by what is known of a particle, in this order.

1. angmom, quat, shape and mass: sum of L_k^2 / (2 I_k) along the body axes, as LAMMPS' `compute erotate/asphere`.
2. omega and angmom: L . omega / 2, as LIGGGHTS' `compute erotate/superquadric`; it needs no mass, shape or orientation.
3. omega, quat, shape and mass: sum of I_k omega_k^2 / 2 along the body axes, seed compute-erotate, eq. (8).

All three agree to rounding where omega = I^-1 L, which LIGGGHTS' integration schemes 0, 1 and 2 see to at the end of every step. (1) comes
first because two kinds of dump do not have that omega:
- LAMMPS, `atom_style hybrid ellipsoid sphere`: fix nve/asphere never touches the omega of an ellipsoid; (2) and (3) would be of stale numbers.
- LIGGGHTS, scheme 3: omega is I^-1 L in the orientation of one step ago, so (3), and with it (2), is the energy of L in that orientation,
  and (1) in today's. They are apart by what this scheme's energy drifts in one step: 3e-7 where a step turns a body by 4e-3 rad.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.population import Energies, Population
from demsolver.shapes.rotation import to_body
from demsolver.shapes.superquadric import inertia_per_mass
from demsolver.state import Floats

Mask = NDArray[np.bool_]


def owned(population: Population) -> Mask:
    """Particles with semi-axes; a row of zeros is a point or a sphere."""
    if population.shape is None:
        return np.zeros(len(population.id), dtype=bool)
    return np.asarray((population.shape != 0).any(axis=1))


def energies(population: Population, mine: Mask) -> Energies:
    """Rotational energies of the particles marked in `mine`.

    Raises LookupError when no alternative of NEEDS is there, ValueError for a semi-axis, mass, exponent or quaternion out of range.
    """
    for needs, way in _WAYS.items():
        if all(getattr(population, name) is not None for name in needs):
            return Energies(population.id[mine], way(population, mine))
    message = f"the rotational energy of superquadrics needs {' or '.join(' '.join(needs) for needs in NEEDS)}"
    raise LookupError(message)


def inertia(population: Population, mine: Mask) -> Floats:
    """Principal moments (k, 3) along the body axes, of homogeneous bodies."""
    mass = population.of("mass", mine)
    if not np.all(mass > 0):
        message = f"expected masses above zero, got {mass[~(mass > 0)][0]:g}"
        raise ValueError(message)
    blockiness = None if population.blockiness is None else population.blockiness[mine]
    return mass[:, None] * inertia_per_mass(population.of("shape", mine), blockiness)


def _from_angmom(population: Population, mine: Mask) -> Floats:
    along = to_body(population.of("quat", mine), population.of("angmom", mine))
    return np.asarray(0.5 * (along**2 / inertia(population, mine)).sum(axis=1))


def _from_both(population: Population, mine: Mask) -> Floats:
    return np.asarray(0.5 * np.einsum("ij,ij->i", population.of("angmom", mine), population.of("omega", mine)))


def _from_omega(population: Population, mine: Mask) -> Floats:
    along = to_body(population.of("quat", mine), population.of("omega", mine))
    return np.asarray(0.5 * (inertia(population, mine) * along**2).sum(axis=1))


_WAYS: dict[tuple[str, ...], Callable[[Population, Mask], Floats]] = {
    ("mass", "shape", "quat", "angmom"): _from_angmom,
    ("omega", "angmom"): _from_both,
    ("mass", "shape", "quat", "omega"): _from_omega,
}
NEEDS = tuple(_WAYS)

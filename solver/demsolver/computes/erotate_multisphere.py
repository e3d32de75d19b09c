"""Rotational energy of rigid bodies, as LIGGGHTS' `compute erotate/multisphere` and LAMMPS' `compute erotate/rigid`.

From the angular momentum, where it is known: sum of L_k^2 / (2 I_k) along the principal axes; an axis without moment of inertia counts
nothing (LIGGGHTS multisphere.cpp, extract_rke; LAMMPS fix_rigid.cpp, extract_erotational). Else from the angular velocity: sum of
I_k w_k^2 / 2, seed compute-erotate, eq. (6).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.population import Energies, Population, RigidBodies
from demsolver.shapes.rotation import to_body
from demsolver.state import Floats

NEEDS = (("bodies",),)


def owned(population: Population) -> NDArray[np.bool_]:
    """Members of bodies, whatever their own shape."""
    if population.body is None:
        return np.zeros(len(population.id), dtype=bool)
    return np.asarray(population.body > 0)


def energies(population: Population, mine: NDArray[np.bool_]) -> Energies:
    """Rotational energy of every body of the population, once each, whether its members are listed or not.

    Raises LookupError when a member marked in `mine` belongs to a body that is not known.
    """
    known = np.empty(0, dtype=np.int64) if population.bodies is None else population.bodies.id
    if mine.any() and population.body is not None:
        unknown = np.setdiff1d(population.body[mine], known)
        if len(unknown):
            message = f"the population has no body {unknown[0]}, of which some particles are members"
            raise LookupError(message)
    if population.bodies is None:
        return Energies(known, np.empty(0))
    return Energies(known, erotate_multisphere(population.bodies))


def erotate_multisphere(bodies: RigidBodies) -> Floats:
    """Energy of each body, (m,).

    Raises LookupError when neither angular momentum nor angular velocity is known, ValueError for a negative moment of inertia.
    """
    if (bodies.inertia < 0.0).any():
        i, k = np.argwhere(bodies.inertia < 0.0)[0]
        message = f"expected principal moments of inertia, got {bodies.inertia[i, k]:g} for body {bodies.id[i]}"
        raise ValueError(message)
    if bodies.angmom is not None:
        along = to_body(bodies.quat, bodies.angmom)
        turning = bodies.inertia != 0.0
        return np.asarray(0.5 * np.divide(along**2, bodies.inertia, out=np.zeros_like(along), where=turning).sum(axis=1))
    if bodies.omega is not None:
        along = to_body(bodies.quat, bodies.omega)
        return np.asarray(0.5 * (bodies.inertia * along**2).sum(axis=1))
    message = "the bodies have neither angmom nor omega"
    raise LookupError(message)

"""What the energy computes are given: particles of any shape, and the rigid bodies that some of them belong to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class RigidBodies:
    """m rigid bodies. None: not known.

    id: (m,). mass: (m,). inertia: (m, 3) principal moments. quat: (m, 4) w x y z, principal axes to space.
    v: (m, 3) of the centre of mass. omega, angmom: (m, 3) in space; at least one of them.
    """

    id: Ints
    inertia: Floats
    quat: Floats
    mass: Floats | None = None
    v: Floats | None = None
    omega: Floats | None = None
    angmom: Floats | None = None


@dataclass(frozen=True)
class Population:
    """n particles at one instant. None: the scene or dump has no such thing.

    id: (n,). mass, radius: (n,). x, v, omega: (n, 3). angmom: (n, 3), in space. quat: (n, 4) w x y z, body to space.
    shape: (n, 3) semi-axes; a row of zeros is a particle without a shape of its own. blockiness: (n, 2) n1 n2, None: 2 2, an ellipsoid.
    body: (n,) the rigid body a particle is a member of; 0 or less: it is free. bodies: those bodies.
    """

    id: Ints
    mass: Floats | None = None
    radius: Floats | None = None
    omega: Floats | None = None
    x: Floats | None = None
    v: Floats | None = None
    angmom: Floats | None = None
    quat: Floats | None = None
    shape: Floats | None = None
    blockiness: Floats | None = None
    body: Ints | None = None
    bodies: RigidBodies | None = None

    def of(self, what: str, mine: NDArray[np.bool_]) -> Floats:
        """The rows of a field that `mine` marks. Raises LookupError when the population has no such field."""
        values: Floats | None = getattr(self, what)
        if values is None:
            message = f"the population has no {what}"
            raise LookupError(message)
        return values if mine.all() else values[mine]


@dataclass(frozen=True)
class Energies:
    """One energy a particle or body. id: (k,). value: (k,)."""

    id: Ints
    value: Floats

    @property
    def total(self) -> float:
        """Their sum."""
        return float(self.value.sum())

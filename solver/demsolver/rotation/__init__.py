"""Rotation of bodies with three principal moments of inertia: integrators, one a file, read off the folder.

A scheme has, for one body (tuples; q: orientation w x y z; angmom, omega, torque: in space; inertia: principal moments; h: the step),

    first(q, angmom, omega, torque, inertia, h) -> q, angmom, omega     before the forces of the next step, which see that q and that omega
    second(q, angmom, omega, torque, inertia, h) -> angmom, omega       after them

A module whose name starts with an underscore is no scheme.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Turning(NamedTuple):
    """Orientations (n, 4) w x y z, angular momenta and spins (n, 3) in space."""

    quat: Floats
    angmom: Floats
    omega: Floats


def schemes() -> tuple[str, ...]:
    """Names, read off the folder."""
    return tuple(sorted(module.name for module in iter_modules(__path__) if not module.name.startswith("_")))


def scheme(name: str) -> ModuleType:
    """The module of that name. Raises ValueError for one that is not there."""
    if name not in schemes():
        message = f"rotation scheme {name!r} is not one of {', '.join(schemes())}"
        raise ValueError(message)
    return import_module(f"{__name__}.{name}")


def turning(quat: Floats, omega: Floats, inertia: Floats) -> Turning:
    """The state with these orientations (n, 4), of any length, and spins (n, 3) in space. inertia: (n, 3)."""
    from demsolver.shapes.rotation import to_body, to_space

    q = quat / np.linalg.norm(quat, axis=1)[:, None]
    return Turning(q, to_space(q, inertia * to_body(q, omega)), np.array(omega, dtype=np.float64))


def freely(name: str, state: Turning, inertia: Floats, dt: float, steps: int) -> Turning:
    """The state so many steps later, no torques acting. inertia: (n, 3) principal moments. Raises ValueError for an unknown scheme."""
    later = Turning(*(np.array(part, dtype=np.float64, order="C") for part in state))
    _loop(name)(*later, np.ascontiguousarray(inertia, dtype=np.float64), dt, steps)
    return later


@cache
def _loop(name: str) -> Any:
    from demsolver.algebra import compiled

    first, second = scheme(name).first, scheme(name).second

    @compiled
    def loop(quat: Floats, angmom: Floats, omega: Floats, inertia: Floats, dt: float, steps: int) -> None:
        none = (0.0, 0.0, 0.0)
        for i in range(len(quat)):
            q = quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3]
            momentum = angmom[i, 0], angmom[i, 1], angmom[i, 2]
            spin = omega[i, 0], omega[i, 1], omega[i, 2]
            moments = inertia[i, 0], inertia[i, 1], inertia[i, 2]
            for _ in range(steps):
                q, momentum, spin = first(q, momentum, spin, none, moments, dt)
                momentum, spin = second(q, momentum, spin, none, moments, dt)
            quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3] = q
            for c in range(3):
                angmom[i, c], omega[i, c] = momentum[c], spin[c]

    return loop

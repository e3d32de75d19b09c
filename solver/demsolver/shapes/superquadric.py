"""Superquadrics in LIGGGHTS' convention: (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1; n1 = n2 = 2 is an ellipsoid.

Volume and moments in closed form: A. Jaklič, A. Leonardis, F. Solina, Segmentation and Recovery of Superquadrics (2000), ch. 2,
doi 10.1007/978-94-015-9456-1, whose beta functions are written out as gamma functions of 1 + k/n. These lie between 1 and 3.4 for
every n from 2 to infinity: nothing cancels and nothing overflows. Each factor depends on one exponent only.

Semi-axes are lengths above zero. Exponents are at least 2, as both engines demand; infinity is the cylinder (n1), the box (n1 and n2).
"""

from __future__ import annotations

from collections.abc import Callable
from math import gamma

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LEAST_EXPONENT = 2.0


def volume(shape: Floats, blockiness: Floats | None = None) -> Floats:
    """shape (n, 3) semi-axes a b c, blockiness (n, 2) n1 n2, None: ellipsoids -> (n,). Raises ValueError, see `checked`."""
    n1, n2 = checked(shape, blockiness)
    return np.asarray(_each(_height, n1) * _each(_area, n2) * shape.prod(axis=1))


def equivalent_radius(shape: Floats, blockiness: Floats | None = None) -> Floats:
    """(n,) radius of spheres of the same volume. Arguments and errors as `volume`."""
    return np.asarray(np.cbrt(3.0 * volume(shape, blockiness) / (4.0 * np.pi)))


def inertia_per_mass(shape: Floats, blockiness: Floats | None = None) -> Floats:
    """Principal moments of inertia about the body axes, divided by the mass: (n, 3), length^2. Arguments and errors as `volume`."""
    n1, n2 = checked(shape, blockiness)
    across = _each(_across_height, n1) * _each(_across_area, n2)
    x2, y2, z2 = (shape**2 * np.column_stack([across, across, _each(_along, n1)])).T
    return np.column_stack([y2 + z2, x2 + z2, x2 + y2])


def checked(shape: Floats, blockiness: Floats | None) -> tuple[Floats, Floats]:
    """The exponents n1 and n2, (n,) each. Raises ValueError for a semi-axis or an exponent out of range or not a number."""
    if bad := _first(~((shape > 0) & np.isfinite(shape)), shape):
        message = f"expected three semi-axes above zero, got {bad}"
        raise ValueError(message)
    if blockiness is None:
        blockiness = np.full((len(shape), 2), LEAST_EXPONENT)
    if bad := _first(~(blockiness >= LEAST_EXPONENT), blockiness):
        message = f"expected a blockiness of {LEAST_EXPONENT:g} or more, got {bad}"
        raise ValueError(message)
    return blockiness[:, 0], blockiness[:, 1]


def _first(wrong: NDArray[np.bool_], rows: Floats) -> str:
    """The first row with something wrong, as text; empty when there is none."""
    found = np.flatnonzero(wrong.any(axis=1))
    return " ".join(f"{value:.9g}" for value in rows[found[0]]) if len(found) else ""


def _each(factor: Callable[[float], float], exponents: Floats) -> Floats:
    """A factor for every particle, evaluated once for each exponent that occurs."""
    values, which = np.unique(exponents, return_inverse=True)
    return np.array([factor(1 / n) for n in values])[which]


def _area(e: float) -> float:
    """Area of the cross section |x|^n + |y|^n = 1, e = 1/n: from pi to 4."""
    return 4 * gamma(1 + e) ** 2 / gamma(1 + 2 * e)


def _height(e: float) -> float:
    """Volume over the area of the cross section at z = 0, c = 1, e = 1/n1: from 4/3 to 2."""
    return 2 * gamma(1 + e) * gamma(1 + 2 * e) / gamma(1 + 3 * e)


def _along(e: float) -> float:
    """Mean of z^2, c = 1, e = 1/n1: from 1/5 to 1/3."""
    return gamma(1 + 3 * e) ** 2 / (3 * gamma(1 + 5 * e) * gamma(1 + e))


def _across_area(e: float) -> float:
    """Mean of x^2 over the cross section, a = 1, e = 1/n2: from 1/4 to 1/3."""
    return gamma(1 + 3 * e) * gamma(1 + 2 * e) / (3 * gamma(1 + 4 * e) * gamma(1 + e))


def _across_height(e: float) -> float:
    """Mean of x^2 over the body divided by that over the cross section at z = 0, e = 1/n1: from 4/5 to 1."""
    return gamma(1 + 4 * e) * gamma(1 + 3 * e) / (gamma(1 + 5 * e) * gamma(1 + 2 * e))

"""Contact geometry of superquadrics (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1, n1, n2 >= 2: LIGGGHTS' convention.

    surface     the function, its gradient and second derivatives; where a line leaves the body
    planes      contact with a plane, in closed form
    pairs       contact of two bodies: as LIGGGHTS defines it, and one whose force derives from an energy
    reference   a plain engine in Python

Geometry is for one body or pair, as tuples, compiled; bodies as `Body`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from demsolver.shapes import superquadric

Floats = NDArray[np.float64]
BOUND = 1.0001
"""Bounding spheres are so much larger than they need to be, as LIGGGHTS has them."""


class Body(NamedTuple):
    """Place x, y, z; orientation w x y z, body to space; semi-axes; exponents n1, n2; scale k = 2^(2 - max(n1, n2)) of the function."""

    x: tuple[float, float, float]
    q: tuple[float, float, float, float]
    axes: tuple[float, float, float]
    n1: float
    n2: float
    scale: float


def body(x: Floats, quat: Floats, shape: Floats, blockiness: Floats) -> Body:
    """Of numbers: x (3,), quat (4,) of length 1, shape (3,) semi-axes, blockiness (2,). Raises ValueError for a shape that is none."""
    superquadric.checked(shape[None], blockiness[None])
    n1, n2 = (float(n) for n in blockiness)
    place, q, axes = (tuple(float(part) for part in row) for row in (x, quat, shape))
    return Body(place, q, axes, n1, n2, 2.0 ** (2.0 - max(n1, n2)))  # type: ignore[arg-type]


@np.errstate(over="ignore", invalid="ignore")
def bounding_radius(shape: Floats, blockiness: Floats) -> Floats:
    """shape (n, 3), blockiness (n, 2) -> (n,) radius of a sphere that holds the body, LIGGGHTS' own: never less than BOUND times the smallest.
    Exponents too large for the formula give no finite number."""
    n1, n2 = superquadric.checked(shape, blockiness)
    big, small, c = shape[:, :2].max(axis=1), shape[:, :2].min(axis=1), shape[:, 2]
    most, across = np.maximum(n1, 2.1), np.maximum(n2, 2.1)
    al = (small / big) ** (2.0 / (across - 2.0))
    grown = (1.0 + al**across) ** (most / across - 1.0)
    be = (c**2 * grown / big**2) ** (1.0 / (most - 2.0))
    at = ((1.0 + al**across) ** (most / across) + be**most) ** (-1.0 / most)
    found = at * np.sqrt(big**2 + al**2 * small**2 + be**2 * c**2)
    found = np.where((n2 == 2.0) & (n1 != 2.0), np.sqrt(big**2 + c**2), found)
    return np.asarray(BOUND * np.where((n1 == 2.0) & (n2 == 2.0), np.maximum(big, c), found))

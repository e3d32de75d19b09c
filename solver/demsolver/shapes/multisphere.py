"""Clumps: rigid bodies made of spheres, which may overlap."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from demsolver.shapes.union import Solid, union

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Template:
    """The spheres of a clump in coordinates of its own, and what it is made of.

    centre: (k, 3). radius: (k,). density: of the material; None: not known. kind: the number that LIGGGHTS calls `type` (clumptype).
    """

    centre: Floats
    radius: Floats
    density: float | None = None
    kind: int = 1


def solid_of(template: Template) -> Solid:
    """The union of a clump's spheres, in the template's coordinates; computed once for each clump. Raises ValueError as `union` does."""
    return _union_of(template.centre.tobytes(), template.radius.tobytes())


@lru_cache(maxsize=64)
def _union_of(centre: bytes, radius: bytes) -> Solid:
    return union(np.frombuffer(centre).reshape(-1, 3), np.frombuffer(radius))

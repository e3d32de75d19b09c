"""Clumps: rigid bodies made of spheres, which may overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

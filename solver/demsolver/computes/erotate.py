"""Rotational energy of everything, as LIGGGHTS' `compute erotate`: finds out which shapes are there and sums over its children.

A child is a file `erotate_<shape>.py` here with `owned(particles) -> (n,) bool` and `energy(particles, mine) -> float`. A child never
counts what another owns: more special shapes choose first, spheres take what is left. Source: seed compute-erotate, eq. (1).
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np

from demsolver.scene import Particles

LAST = "sphere"


def children() -> Iterator[tuple[str, ModuleType]]:
    """(shape, module) of every child, spheres last."""
    names = [m.name for m in pkgutil.iter_modules([str(Path(__file__).parent)]) if m.name.startswith("erotate_")]
    for name in sorted(names, key=lambda n: (n.endswith(LAST), n)):
        yield name.removeprefix("erotate_"), importlib.import_module(f"demsolver.computes.{name}")


def erotate_by_shape(particles: Particles) -> dict[str, float]:
    """Rotational energy per shape that is present."""
    free = np.ones(len(particles.id), dtype=bool)
    energies = {}
    for shape, child in children():
        mine = child.owned(particles) & free
        if mine.any():
            energies[shape] = child.energy(particles, mine)
            free &= ~mine
    return energies


def erotate(particles: Particles) -> float:
    """Total rotational energy."""
    return sum(erotate_by_shape(particles).values())

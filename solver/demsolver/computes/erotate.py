"""Rotational energy of everything, as LIGGGHTS' `compute erotate`: finds out which shapes are there and sums over its children.

A child is a file `erotate_<shape>.py` here with

    owned(population) -> (n,) bool                  the particles that are its business
    energies(population, mine) -> Energies          their rotational energies; `mine` marks them, (n,) bool
    NEEDS                                           what a particle of this shape must have: alternatives, each a tuple of fields

A child never counts what another owns: more special shapes choose first, spheres take what is left. Source: seed compute-erotate, eq. (1).
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from demsolver.computes.population import Energies, Population

BODIES = "multisphere"
"""The shape that may be there without its particles: a dump of bodies does not list their members."""
ORDER = (BODIES, "superquadric")
LAST = "sphere"


@cache
def children() -> tuple[tuple[str, ModuleType], ...]:
    """(shape, module) of every child, clumps first (their members may have shapes), spheres last."""
    names = [m.name.removeprefix("erotate_") for m in pkgutil.iter_modules([str(Path(__file__).parent)]) if m.name.startswith("erotate_")]
    rank = {shape: i for i, shape in enumerate(ORDER)}
    names.sort(key=lambda shape: (shape == LAST, rank.get(shape, len(rank)), shape))
    return tuple((shape, importlib.import_module(f"demsolver.computes.erotate_{shape}")) for shape in names)


def erotate_by_shape(population: Population) -> Iterator[tuple[str, Energies]]:
    """(shape, energies) of every shape that is present."""
    free = np.ones(len(population.id), dtype=bool)
    for shape, child in children():
        mine = child.owned(population) & free
        if mine.any() or (shape == BODIES and population.bodies is not None):
            yield shape, child.energies(population, mine)
            free &= ~mine


def erotate(population: Population) -> float:
    """Total rotational energy."""
    return sum(energies.total for _, energies in erotate_by_shape(population))

"""Computes: arrays in, numbers out. One a file; none keeps state.

`erotate` finds its children, `erotate_*`, by reading this folder: see erotate.py.
"""

from demsolver.computes.erotate import erotate
from demsolver.computes.erotate_sphere import erotate_sphere
from demsolver.computes.ke import ke
from demsolver.computes.momentum import angular_momentum, momentum
from demsolver.computes.population import Energies, Population, RigidBodies

__all__ = ["Energies", "Population", "RigidBodies", "angular_momentum", "erotate", "erotate_sphere", "ke", "momentum"]

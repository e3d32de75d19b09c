"""demsolver: a native DEM solver. Arrays in, arrays out; knows nothing of decks or engines.

from demsolver import Scene, Simulation
simulation = Simulation(scene)
simulation.setup()
simulation.advance(1000)
simulation.bodies.force
"""

from demsolver.energy_budget import EnergyBudget
from demsolver.scene import (
    AddForce,
    Box,
    Clumps,
    ContactLaw,
    Cylinder,
    Enforce2D,
    EulerSphere,
    Freeze,
    Gravity,
    Neighbor,
    NveClumps,
    NveSphere,
    NveSuperquadric,
    Particles,
    Plane,
    Rotation,
    Scene,
    SetForce,
    Slab,
    Superquadrics,
    Viscous,
    Wall,
)  # fmt: skip
from demsolver.simulate import Simulation
from demsolver.sleep import Sleep
from demsolver.trouble import LostParticles, Unstable

__all__ = [
    "AddForce", "Box", "Clumps", "ContactLaw", "Cylinder", "EnergyBudget", "Enforce2D", "EulerSphere", "Freeze", "Gravity", "LostParticles",
    "Neighbor", "NveClumps", "NveSphere", "NveSuperquadric", "Particles", "Plane", "Rotation", "Scene", "SetForce", "Simulation", "Slab", "Sleep",
    "Superquadrics", "Unstable", "Viscous", "Wall",
]  # fmt: skip

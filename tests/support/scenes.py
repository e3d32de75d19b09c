"""Scenes for the solver's tests: the bed of inputs/bed, and small random clusters."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from demsolver import Box, ContactLaw, Gravity, Neighbor, NveSphere, Particles, Scene, Slab, Wall
from demverify.stability.held import spheres

INPUTS = Path(__file__).parents[2] / "inputs"
KN, GAMMAN, MU = 1e4, 400.0, 0.3


def law(shape: tuple[int, ...], *, gamman: float = GAMMAN, mu: float = MU, friction: str = "classic_history", kn: float = KN) -> ContactLaw:
    """The law of LAMMPS gran/hooke/history with kt = 2/7 kn, gammat = gamman/2."""
    one = np.ones(shape)
    values = {"kn": kn * one, "gamman": gamman * one, "shear_stiffness": 2 / 7 * kn * one, "xt": 0.5 * one, "mu": mu * one}
    return ContactLaw("hooke", "mass_velocity", "constant", "scaled", friction, values)


@cache
def bed_particles() -> Particles:
    """The 1,000 spheres of inputs/bed/bed.data."""
    lines = (INPUTS / "bed" / "bed.data").read_text().split("\n")
    n = int(lines[2].split()[0])
    atoms, motion = (np.array([line.split() for line in lines[lines.index(s) + 2 :][:n]], float) for s in ("Atoms", "Velocities"))
    radius = atoms[:, 2] / 2
    mass = atoms[:, 3] * 4 / 3 * np.pi * radius**3
    kinds = atoms[:, 0].astype(int), atoms[:, 1].astype(int)
    return Particles(*kinds, atoms[:, 4:7], motion[:, 1:4], motion[:, 4:7], radius, mass, np.ones(n, dtype=int), np.zeros((n, 3), int))


def bed(dt: float, *, gamman: float = GAMMAN, mu: float = MU, friction: str = "classic_history") -> Scene:
    """The bed under gravity on its floor, periodic sideways. SI units."""
    return Scene(
        Box(np.zeros(3), np.array([0.1, 0.1, 0.4]), ("pp", "pp", "ff")), bed_particles(), 2, dt,
        pair=law((2, 2), gamman=gamman, mu=mu, friction=friction),
        walls=(Wall("floor", Slab(2, lo=0.0), law((2,), gamman=gamman, mu=mu, friction=friction)),),
        forces=(Gravity((0.0, 0.0, -9.81)),), integrate=(NveSphere(),), neighbor=Neighbor(0.001),
    )  # fmt: skip


def cluster(rng: np.random.Generator, n: int = 24, *, size: float = 0.05, periodic: bool = True) -> Scene:
    """Overlapping spheres at random in a small box, moving and spinning, with a floor, gravity and friction."""
    radius = rng.uniform(0.004, 0.008, n)
    p = spheres(rng.uniform(0, size, (n, 3)), radius, v=rng.normal(0, 0.3, (n, 3)), omega=rng.normal(0, 40, (n, 3)))
    faces = ("pp", "pp", "ff") if periodic else ("ff", "ff", "ff")
    lo, hi = (np.zeros(3), np.full(3, size)) if periodic else (np.full(3, -size), np.full(3, 2 * size))
    return Scene(
        Box(lo, hi, faces), p, 1, 1e-5, pair=law((1, 1)),
        walls=(Wall("slab", Slab(2, lo=0.0, hi=size), law((1,))),), forces=(Gravity((0.0, 0.0, -9.81)),), integrate=(NveSphere(),),
        neighbor=Neighbor(0.002),
    )  # fmt: skip

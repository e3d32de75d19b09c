"""Building and changing the arrays of particles."""

from __future__ import annotations

from dataclasses import fields, replace
from math import pi

import numpy as np

from demsolver.scene import Box
from demverify.deck.setup import Atoms, Floats, Ints, Setup


def no_atoms() -> Atoms:
    """Atoms with no rows."""
    whole = np.zeros(0, dtype=np.int64)
    return new_atoms(whole, whole, np.zeros((0, 3)), np.zeros(0), np.zeros(0))


def new_atoms(ids: Ints, types: Ints, x: Floats, radius: Floats, mass: Floats) -> Atoms:
    """Particles at rest at the (n, 3) positions, members of group all alone."""
    n = len(ids)
    return Atoms(
        id=ids.astype(np.int64),
        type=types.astype(np.int64),
        x=x,
        v=np.zeros((n, 3)),
        omega=np.zeros((n, 3)),
        radius=radius,
        mass=mass,
        mask=np.ones(n, dtype=np.int64),
        image=np.zeros((n, 3), dtype=np.int64),
        molecule=np.zeros(n, dtype=np.int64),
    )


def joined(first: Atoms, second: Atoms) -> Atoms:
    """The rows of both."""
    return Atoms(**{f.name: np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(Atoms)})


def selected(atoms: Atoms, rows: Ints) -> Atoms:
    """A copy of some rows, in the order of `rows`."""
    return Atoms(**{f.name: getattr(atoms, f.name)[rows] for f in fields(Atoms)})


def add_particles(setup: Setup, types: Ints, x: Floats) -> None:
    """Appends particles of diameter 1 and density 1, as create_atoms does; ids go on after the largest."""
    atoms = setup.atoms or no_atoms()
    n = len(types)
    ids = (atoms.id.max() if atoms.n else 0) + np.arange(1, n + 1)
    radius = np.full(n, 0.5)
    setup.atoms = joined(atoms, new_atoms(ids, types, x, radius, density_mass(setup, radius, np.ones(n))))


def density_mass(setup: Setup, radius: Floats, density: Floats | float) -> Floats:
    """Mass of spheres; in two dimensions LIGGGHTS means discs of thickness 1, LAMMPS still spheres (measured on both)."""
    if setup.dialect == "liggghts" and setup.dimension == 2:
        return np.asarray(pi * radius * radius * density)
    return np.asarray(4.0 * pi / 3.0 * radius * radius * radius * density)


def wrap(atoms: Atoms, box: Box) -> Atoms:
    """Brings particles back through the periodic faces and counts that in their images, as LAMMPS does."""
    x, image = atoms.x.copy(), atoms.image.copy()
    for axis in np.flatnonzero(box.periodic):
        lo, hi = box.lo[axis], box.hi[axis]
        turns = np.floor((x[:, axis] - lo) / (hi - lo)).astype(np.int64)
        x[:, axis] = np.where(turns != 0, np.maximum(x[:, axis] - turns * (hi - lo), lo), x[:, axis])
        image[:, axis] += turns
    return replace(atoms, x=x, image=image)


def members(setup: Setup, group: str) -> Ints:
    """Rows of the particles of a group that exists."""
    atoms = setup.atoms or no_atoms()
    return np.flatnonzero(atoms.mask >> setup.groups[group] & 1)


def velocity_of_center(atoms: Atoms, rows: Ints) -> Floats:
    """(3,) velocity of the centre of mass of some rows; zero for none."""
    mass = atoms.mass[rows]
    return np.asarray(mass @ atoms.v[rows] / mass.sum()) if len(rows) else np.zeros(3)


def center(atoms: Atoms, rows: Ints, box: Box) -> Floats:
    """(3,) centre of mass of some rows, images unfolded; zero for none."""
    mass = atoms.mass[rows]
    return np.asarray(mass @ unfolded(atoms, rows, box) / mass.sum()) if len(rows) else np.zeros(3)


def unfolded(atoms: Atoms, rows: Ints, box: Box) -> Floats:
    """(n, 3) positions with the periodic wraps taken back."""
    return np.asarray(atoms.x[rows] + atoms.image[rows] * (box.hi - box.lo))

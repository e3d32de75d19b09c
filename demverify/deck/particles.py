"""Building and changing the arrays of particles."""

from __future__ import annotations

from dataclasses import fields, replace
from math import pi

import numpy as np

from demsolver.scene import Box, Clumps, Superquadrics
from demsolver.shapes import rotation, superquadric
from demsolver.superquadric import bounding_radius
from demverify.deck.setup import Atoms, Floats, Ints, Setup

ARRAYS = tuple(f.name for f in fields(Atoms) if f.name not in ("superquadrics", "clumps"))


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
    """The rows of both, which are of one style."""
    rows = {name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in ARRAYS}
    a, b = first.superquadrics, second.superquadrics
    shapes = b if not first.n else a
    if a is not None and b is not None:
        shapes = Superquadrics(*(np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(Superquadrics)))
    return Atoms(**rows, superquadrics=shapes, clumps=clumps_joined(first, second))


def clumps_joined(first: Atoms, second: Atoms) -> Clumps | None:
    """The clumps of both."""
    a, b = first.clumps, second.clumps
    if a is None and b is None:
        return None
    a, b = a or no_clumps(first.n), b or no_clumps(second.n)
    rows = {f.name: np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(Clumps) if f.name not in ("members_weigh", "body")}
    body = np.concatenate([a.body, np.where(b.body >= 0, b.body + len(a.id), -1)])
    return Clumps(**rows, body=body, members_weigh=b.members_weigh if len(b.id) else a.members_weigh)


def no_clumps(n: int) -> Clumps:
    """Of n particles, all free."""
    none = np.zeros(0, dtype=np.int64)
    three = np.zeros((0, 3))
    return Clumps(np.full(n, -1), np.zeros((n, 3)), none, three, three, np.zeros((0, 4)), three, three, np.zeros(0), three, none)


def selected(atoms: Atoms, rows: Ints) -> Atoms:
    """A copy of some rows, in the order of `rows`; all clumps stay."""
    kept = atoms.clumps.rows(rows) if atoms.clumps else None
    shapes = atoms.superquadrics.rows(rows) if atoms.superquadrics else None
    return Atoms(**{name: getattr(atoms, name)[rows] for name in ARRAYS}, superquadrics=shapes, clumps=kept)


def next_ids(atoms: Atoms, n: int) -> Ints:
    """(n,) ids that go on after the largest."""
    return np.asarray((atoms.id.max() if atoms.n else 0) + np.arange(1, n + 1))


def next_molecule(atoms: Atoms) -> int:
    """The number that goes on after the largest, from 1."""
    return int(max(atoms.molecule.max(initial=0), 0)) + 1


def add_particles(setup: Setup, types: Ints, x: Floats) -> None:
    """Appends particles of diameter 1 and density 1, as create_atoms does; ids go on after the largest."""
    atoms = setup.atoms or no_atoms()
    n = len(types)
    ids = next_ids(atoms, n)
    radius = np.full(n, 0.5)
    new = new_atoms(ids, types, x, radius, density_mass(setup, radius, np.ones(n)))
    if setup.atom_style == "superquadric":
        new.superquadrics = no_shapes(n)
        reshape(new, np.arange(n), 1.0)
    setup.atoms = joined(atoms, new)


def no_shapes(n: int) -> Superquadrics:
    """Balls of diameter 1, not turned; without mass yet."""
    quat = np.zeros((n, 4))
    quat[:, 0] = 1.0
    return Superquadrics(np.full((n, 3), 0.5), np.full((n, 2), 2.0), quat, np.zeros((n, 3)), np.zeros((n, 3)))


def reshape(atoms: Atoms, rows: Ints, density: Floats | float) -> None:
    """What follows from axes, blockiness and density of some superquadrics: bounding radius, mass and moments, in place."""
    shapes = atoms.superquadrics
    assert shapes is not None
    axes, blockiness = shapes.axes[rows], shapes.blockiness[rows]
    atoms.radius[rows] = bounding_radius(axes, blockiness)
    atoms.mass[rows] = density * superquadric.volume(axes, blockiness)
    shapes.inertia[rows] = atoms.mass[rows, None] * superquadric.inertia_per_mass(axes, blockiness)


def turn_with(atoms: Atoms, rows: Ints) -> None:
    """The angular momentum of some superquadrics follows from their spins, in place."""
    shapes = atoms.superquadrics
    assert shapes is not None
    along = rotation.to_body(shapes.quat[rows], atoms.omega[rows])
    shapes.angmom[rows] = rotation.to_space(shapes.quat[rows], shapes.inertia[rows] * along)


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

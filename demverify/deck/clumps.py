"""Clumps of a deck: made of spheres that are there (LAMMPS), or placed whole (LIGGGHTS)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from demsolver.scene import Box, Clumps
from demsolver.shapes.principal import first_quaternion, principal
from demsolver.shapes.rotation import matrix
from demsolver.shapes.union import steiner
from demverify.deck.particles import joined, new_atoms, next_ids, next_molecule, no_atoms, unfolded
from demverify.deck.setup import Atoms, Floats, Ints, Setup


@dataclass(frozen=True)
class Kind:
    """What clumps of a template are like. centre: (k, 3) from the centre of mass, along the axes of the file; radius: (k,). mass and inertia (3, 3)
    of the whole. type: of the particles."""

    centre: Floats
    radius: Floats
    mass: float
    inertia: Floats
    type: int


def place(setup: Setup, kind: Kind, x: Floats, quat: Floats, v: Floats, omega: Floats, mask: int = 1) -> None:
    """Adds one clump with its centre of mass at x (3,), turned by quat (4,) w x y z from the axes of its file, with v and omega (3,) in space: as
    LIGGGHTS inserts it, whose members carry the mass of the whole."""
    atoms = setup.atoms or no_atoms()
    moments, axes = principal(kind.inertia, ascending=False)
    offset, turned = kind.centre @ axes, matrix(quat[None])[0] @ axes
    k = len(kind.radius)
    arms = offset @ turned.T
    new = new_atoms(next_ids(atoms, k), np.full(k, kind.type), x + arms, kind.radius.copy(), np.full(k, kind.mass))
    number = next_molecule(atoms)
    new.v[:], new.omega[:] = v + np.cross(omega, arms), omega
    new.molecule[:], new.mask[:] = number, mask
    angmom = turned @ (moments * (turned.T @ omega))
    new.clumps = Clumps(
        np.zeros(k, dtype=np.int64), offset, np.array([number]), x[None].copy(), v[None].copy(), first_quaternion(turned)[None], angmom[None],
        omega[None].copy(), np.array([kind.mass]), moments[None], np.array([mask]), members_weigh=False,
    )  # fmt: skip
    setup.atoms = joined(atoms, new)


def gathered(atoms: Atoms, box: Box, member: Ints, molecule: Ints) -> Clumps:
    """Clumps of the spheres in the rows `member` (k,), one for each number in `molecule` (k,): mass, centre, inertia and motion are theirs, as if
    none overlapped.

    Source: LAMMPS fix rigid/small, measured; seed compute-erotate, eq. (5)."""
    numbers = np.unique(molecule)
    body, offset = np.full(atoms.n, -1), np.zeros((atoms.n, 3))
    rows: dict[str, Any] = {name: [] for name in ("x", "v", "quat", "angmom", "omega", "mass", "inertia")}
    mask = []
    for m, number in enumerate(numbers):
        own = member[molecule == number]
        mass, radius, v, omega = atoms.mass[own], atoms.radius[own], atoms.v[own], atoms.omega[own]
        whole = unfolded(atoms, own, box)
        total, middle, tensor = steiner(mass, whole, radius)
        moments, axes = principal(tensor, ascending=True)
        arms = whole - middle
        angmom = (mass[:, None] * np.cross(arms, v)).sum(axis=0) + ((0.4 * mass * radius**2)[:, None] * omega).sum(axis=0)
        found = middle, mass @ v / total, first_quaternion(axes), angmom, axes @ ((axes.T @ angmom) / moments), total, moments
        for name, value in zip(rows, found, strict=True):
            rows[name].append(np.asarray(value))
        body[own], offset[own] = m, arms @ axes
        mask.append(int(np.bitwise_and.reduce(atoms.mask[own])))
    rows = {name: np.array(values) for name, values in rows.items()}
    return Clumps(body=body, offset=offset, id=numbers, mask=np.array(mask, dtype=np.int64), **rows)

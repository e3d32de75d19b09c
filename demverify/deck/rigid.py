"""LAMMPS' rigid bodies: which spheres are one, for a run."""

from __future__ import annotations

import numpy as np

from demsolver.scene import Clumps
from demsolver.state import selected
from demverify.deck.clumps import gathered
from demverify.deck.forces import RIGID
from demverify.deck.setup import Atoms, Ints, Setup, Spec
from demverify.errors import InputError

_OF_BODIES = ("erotate/rigid", "ke/rigid", "rigid/local")


def rigid_bodies(setup: Setup, atoms: Atoms) -> Clumps | None:
    """The bodies of fix rigid, made of the spheres as they are now: LAMMPS makes them anew for every run, too. None: no fix makes any.

    Raises InputError for what LAMMPS refuses, and for what native cannot do."""
    specs = [spec for spec in setup.fixes.values() if spec.style in RIGID]
    _check_computes(setup, specs)
    if not specs:
        _check_intra(setup, atoms, np.full(atoms.n, -1))
        return None
    if len(specs) > 1:
        message = f"fix {specs[1].id} {specs[1].style}: fix {specs[0].id} moves rigid bodies already; one fix for all is supported"
        raise InputError(message, specs[1].place)
    spec = specs[0]
    member = np.flatnonzero(selected(atoms.mask, setup.groups[spec.group]) & (atoms.molecule > 0))
    if not len(member):
        raise InputError(f"fix {spec.id} {spec.style}: no particle of group {spec.group} has a molecule", spec.place)
    numbers, count = np.unique(atoms.molecule[member], return_counts=True)
    if (count == 1).any():
        message = f"fix {spec.id} {spec.style}: molecule {numbers[count == 1][0]} has one sphere in group {spec.group}; a body has two or more"
        raise InputError(message, spec.place)
    movers = [fix for fix in setup.fixes.values() if fix.style == "nve/sphere" and selected(atoms.mask[member], setup.groups[fix.group]).any()]
    if movers:
        message = f"fix {movers[0].id} {movers[0].style}: moves spheres that fix {spec.id} {spec.style} moves as bodies: give each a group of its own"
        raise InputError(message, movers[0].place)
    assert setup.box is not None
    clumps = gathered(atoms, setup.box, member, atoms.molecule[member])
    _check_intra(setup, atoms, clumps.body)
    return clumps


def _check_computes(setup: Setup, fixes: list[Spec]) -> None:
    """Raises InputError for a compute of bodies whose fix is not there."""
    for spec in (one for one in setup.computes.values() if one.style in _OF_BODIES):
        if spec.args[:1] not in [(fix.id,) for fix in fixes]:
            there = ", ".join(fix.id for fix in fixes) or "none"
            message = f"compute {spec.id} {spec.style} expects a fix of rigid bodies, got {' '.join(spec.args[:1]) or 'nothing'}; there are: {there}"
            raise InputError(message, spec.place)


def _check_intra(setup: Setup, atoms: Atoms, body: Ints) -> None:
    """Raises InputError where neigh_modify exclude molecule/intra hides other contacts than those within a clump: in LAMMPS it hides those of all
    spheres of one molecule, and molecule 0 is that of every loose sphere (measured). body: (n,) clump of each, -1 of loose ones."""
    frozen = np.zeros(atoms.n, dtype=bool)
    for fix in (one for one in setup.fixes.values() if one.style == "freeze"):
        frozen |= selected(atoms.mask, setup.groups[fix.group])
    part = np.where(body >= 0, body, np.where(frozen, -1, -2 - np.arange(atoms.n)))  # within one of which no contact counts
    for group, place in setup.neighbor.exclude_intra:
        rows = np.flatnonzero(selected(atoms.mask, setup.groups[group]))
        order = rows[np.lexsort((part[rows], atoms.molecule[rows]))]
        number = atoms.molecule[order]
        hidden = np.flatnonzero((number[1:] == number[:-1]) & (part[order[1:]] != part[order[:-1]]))
        if len(hidden):
            a, b = sorted(atoms.id[order[hidden[0] : hidden[0] + 2]].tolist())
            whose = f"of molecule {number[hidden[0]]} but of no one clump"
            message = f"neigh_modify exclude molecule/intra {group}: hides contacts of spheres {a} and {b} too, {whose}: name a group of clumps alone"
            raise InputError(message, place)

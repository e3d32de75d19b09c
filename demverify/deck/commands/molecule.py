"""molecule, and create_atoms with one: clumps of LAMMPS."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from demsolver.scene import Box
from demsolver.shapes.rotation import matrix
from demverify.deck.command import Command, command
from demverify.deck.commands.space import check_inside
from demverify.deck.interpreter import Interpreter
from demverify.deck.particles import joined, new_atoms, next_ids, next_molecule, no_atoms, wrap
from demverify.deck.regions import region_scale
from demverify.formats.molecule import read_molecule


@command("molecule")
def molecule(deck: Interpreter, cmd: Command) -> None:
    """molecule ID FILE [scale X]"""
    name, file = cmd.take("an ID"), cmd.take("a file")
    if name in deck.setup.molecules:
        raise cmd.error(f"{name!r} exists already")
    scale = 1.0
    while cmd:
        cmd.choice("keyword", ("scale",))
        scale = cmd.positive("scale")
    deck.setup.molecules[name] = read_molecule(deck.find_file(file), scale)


def create_molecule(deck: Interpreter, cmd: Command, box: Box, offset: int, style: str) -> None:
    """create_atoms 0 single x y z mol ID SEED rotate ANGLE ax ay az: atom i at (x y z) + Q (coords_i - mean of coords), in degrees about that axis,
    brought back through periodic faces at once; molecules of the file count on from the largest there is (measured)."""
    if style != "single":
        raise cmd.error("mol is supported with single alone")
    setup = deck.setup
    x = np.array(cmd.vector("x", "y", "z")) * region_scale(setup, cmd)
    check_inside(cmd, box, x)
    cmd.choice("keyword", ("mol",))
    name = cmd.take("a molecule")
    if name not in setup.molecules:
        raise cmd.error(f"molecule {name!r} does not exist; defined: {', '.join(setup.molecules) or 'none'}")
    cmd.integer("seed", 1)
    turned = None
    while cmd:
        if cmd.choice("keyword", ("rotate", "units")) == "units":
            cmd.choice("units", ("box", "lattice"))
            continue
        angle, axis = cmd.number("angle") * pi / 360.0, np.array(cmd.vector("ax", "ay", "az"))
        if not axis.any():
            raise cmd.error("the axis of rotate must not be zero")
        turned = matrix(np.array([[cos(angle), *(sin(angle) * axis / np.linalg.norm(axis))]]))[0]
    if turned is None:
        raise cmd.error("mol needs rotate: without it LAMMPS draws the orientation at random")
    if not any(fix.style == "property/atom" for fix in setup.fixes.values()):
        raise cmd.error("mol needs fix property/atom mol before it, so that spheres have a molecule")
    found, atoms = setup.molecules[name], setup.atoms or no_atoms()
    types = found.type + offset
    if types.max() > setup.ntypes:
        raise cmd.error(f"molecule {name} has type {types.max()}, and there are {setup.ntypes}")
    ids = next_ids(atoms, len(types))
    new = new_atoms(ids, types, x + (found.centre - found.centre.mean(axis=0)) @ turned.T, found.radius.copy(), found.mass.copy())
    new.molecule[:] = next_molecule(atoms) if found.molecule is None else next_molecule(atoms) - 1 + found.molecule
    setup.atoms = joined(atoms, wrap(new, box))

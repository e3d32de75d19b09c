"""Commands that set up units, the box and regions."""

from __future__ import annotations

import numpy as np

from demsolver.scene import Box
from demverify.deck.command import Command, command
from demverify.deck.interpreter import Interpreter
from demverify.deck.lattice import read_lattice
from demverify.deck.particles import no_atoms, no_shapes
from demverify.deck.regions import find_region, read_region
from demverify.deck.setup import Floats

_MOST_TYPES = 1000  # the contact laws keep a table of all pairs of types
_SHRINK_MARGIN = 1e-4  # both engines widen a new box by this share at each shrink-wrapped face (measured)
_UNITS = ("lj", "si", "cgs", "micro")


def before_box(deck: Interpreter, cmd: Command) -> None:
    """Raises InputError when there is a box already."""
    if deck.setup.box is not None:
        raise cmd.error("must come before the simulation box is made")


def need_box(deck: Interpreter, cmd: Command) -> Box:
    """The box. Raises InputError when there is none yet."""
    if deck.setup.box is None:
        raise cmd.error("needs a simulation box: create_box or read_data must come first")
    return deck.setup.box


def check_inside(cmd: Command, box: Box, x: Floats) -> None:
    """Raises InputError when the place x (3,) is outside the box."""
    outside = ~((x >= box.lo) & (x < box.hi))
    if outside.any():
        axis = int(np.argmax(outside))
        raise cmd.error(f"{'xyz'[axis]} = {x[axis]:g} is outside the box, {box.lo[axis]:g} to {box.hi[axis]:g}")


@command("units")
def units(deck: Interpreter, cmd: Command) -> None:
    """units lj|si|cgs|micro: also resets time step and skin to the defaults of the units."""
    before_box(deck, cmd)
    deck.setup.units = cmd.choice("style", _UNITS)
    deck.setup.timestep = None
    deck.setup.neighbor.skin = None
    cmd.end()


@command("dimension")
def dimension(deck: Interpreter, cmd: Command) -> None:
    """dimension 2|3"""
    before_box(deck, cmd)
    deck.setup.dimension = cmd.integer("number", 2, 3)
    cmd.end()


@command("newton")
def newton(deck: Interpreter, cmd: Command) -> None:
    """newton on|off [on|off]: how pairs are shared between processors."""
    deck.setup.newton = cmd.yes("pair flag")
    if cmd:
        cmd.yes("bond flag")
    deck.ignore(cmd)


@command("boundary")
def boundary(deck: Interpreter, cmd: Command) -> None:
    """boundary x y z, each one or two of p f s m."""
    before_box(deck, cmd)
    x, y, z = (_faces(cmd, axis) for axis in "xyz")
    deck.setup.boundary = (x, y, z)
    cmd.end()


def _faces(cmd: Command, axis: str) -> str:
    word = cmd.take(axis)
    faces = word * 2 if len(word) == 1 else word
    if len(faces) != 2 or set(faces) - set("pfsm"):
        raise cmd.error(f"{axis} must be one or two letters of p f s m, got {word!r}")
    if "p" in faces and faces != "pp":
        raise cmd.error(f"{axis}: both faces of an axis are periodic or none, got {word!r}")
    return faces


@command("atom_style")
def atom_style(deck: Interpreter, cmd: Command) -> None:
    """atom_style sphere|granular|superquadric [0|1]"""
    before_box(deck, cmd)
    deck.setup.atom_style = cmd.choice("style", ("sphere", "granular", "superquadric") if deck.setup.dialect == "liggghts" else ("sphere",))
    if cmd and cmd.integer("radius flag", 0, 1) == 1:
        deck.ignore(cmd)  # the radius may vary in time, which nothing here does
    cmd.end()


@command("lattice")
def lattice(deck: Interpreter, cmd: Command) -> None:
    """lattice style scale [origin x y z] [orient dim i j k] [spacing dx dy dz]"""
    deck.setup.lattice = read_lattice(deck.setup, cmd)


@command("region")
def region(deck: Interpreter, cmd: Command) -> None:
    """region ID style args..."""
    name = cmd.take("an ID")
    if cmd.peek() == "delete":
        find_region(deck.setup, cmd, name)
        del deck.setup.regions[name]
    elif name in deck.setup.regions:
        raise cmd.error(f"{name!r} exists already")
    else:
        deck.setup.regions[name] = read_region(deck.setup, cmd)


@command("create_box")
def create_box(deck: Interpreter, cmd: Command) -> None:
    """create_box NTYPES REGION"""
    before_box(deck, cmd)
    ntypes = cmd.integer("number of types", 1)
    found = find_region(deck.setup, cmd, cmd.take("a region ID"))
    cmd.end()
    if found.lo is None or found.hi is None:
        raise cmd.error("the region has no bounds to make a box of")
    make_box(deck, cmd, found.lo, found.hi, ntypes)


def make_box(deck: Interpreter, cmd: Command, lo: object, hi: object, ntypes: int) -> None:
    """Sets box, types and an empty set of particles. lo, hi: (3,). Raises InputError for an empty box."""
    if deck.setup.cleared:
        raise cmd.error("is not supported after clear: a deck describes one system, which read_restart brings back")
    if ntypes > _MOST_TYPES:
        raise cmd.error(f"number of types must be at most {_MOST_TYPES}, got {ntypes}")
    low, high = np.array(lo, dtype=float), np.array(hi, dtype=float)
    if not np.isfinite(np.prod(high - low)):
        raise cmd.error(f"the box is too large for numbers: {low.tolist()} to {high.tolist()}")
    if np.any(low >= high):
        axis = "xyz"[int(np.argmax(low >= high))]
        raise cmd.error(f"the box is empty: {axis}lo must be below {axis}hi")
    if deck.setup.dimension == 2 and deck.setup.boundary[2] != "pp":
        raise cmd.error("a two-dimensional box must be periodic in z")
    faces = deck.setup.boundary
    shrinking = np.array([[face == "s" for face in pair] for pair in faces])
    margin = _SHRINK_MARGIN * (high - low)
    deck.setup.box = Box(low - margin * shrinking[:, 0], high + margin * shrinking[:, 1], faces, margin)
    deck.setup.ntypes = ntypes
    deck.setup.atoms = no_atoms()
    if deck.setup.atom_style == "superquadric":
        deck.setup.atoms.superquadrics = no_shapes(0)

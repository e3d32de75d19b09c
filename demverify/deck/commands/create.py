"""create_atoms and read_data: where particles come from."""

from __future__ import annotations

import numpy as np

from demsolver.scene import Box
from demverify.deck.command import Command, command
from demverify.deck.commands.molecule import create_molecule
from demverify.deck.commands.space import before_box, check_inside, make_box, need_box
from demverify.deck.data_file import particles_of, read_data_file
from demverify.deck.delegate import delegated
from demverify.deck.interpreter import Interpreter
from demverify.deck.lattice import lattice_points
from demverify.deck.particles import add_particles
from demverify.deck.regions import find_region, region_scale
from demverify.deck.setup import Ints

_DRAWN = ("ratio", "subset")  # keywords that draw random numbers


@command("create_atoms")
def create_atoms(deck: Interpreter, cmd: Command) -> None:
    """create_atoms TYPE box | region ID | single x y z | random N seed ID [basis M type] [remap yes|no] [units box|lattice] [mol ID seed rotate
    ...]"""
    box = need_box(deck, cmd)
    particle_type = cmd.integer("type", 0 if "mol" in cmd.args else 1, deck.setup.ntypes)
    style = cmd.choice("style", ("box", "region", "single", "random"))
    cmd.what = f"create_atoms {style}"
    if "mol" in cmd.args:
        create_molecule(deck, cmd, box, particle_type, style)
    elif style == "random" or set(_DRAWN) & set(cmd.args):
        deck.setup.atoms = delegated(deck, cmd)
    elif style == "single":
        _single(deck, cmd, box, particle_type)
    else:
        _lattice(deck, cmd, particle_type, style)


def _single(deck: Interpreter, cmd: Command, box: Box, particle_type: int) -> None:
    x = np.array([cmd.vector("x", "y", "z")]) * region_scale(deck.setup, cmd)
    remap = _options(cmd, ("remap", "units")).get("remap") == ["yes"]
    if remap:
        edge = box.hi - box.lo
        x = np.where(box.periodic, x - np.floor((x - box.lo) / edge) * edge, x)
    check_inside(cmd, box, x[0])
    if deck.setup.dimension == 2 and x[0, 2] != 0.0:
        raise cmd.error("z must be 0 in two dimensions")
    add_particles(deck.setup, np.array([particle_type]), x)


def _lattice(deck: Interpreter, cmd: Command, particle_type: int, style: str) -> None:
    if deck.setup.lattice is None or deck.setup.lattice.style == "none":
        raise cmd.error("needs a lattice command before it")
    region = find_region(deck.setup, cmd, cmd.take("a region ID")) if style == "region" else None
    types = np.full(len(deck.setup.lattice.basis), particle_type)
    for keyword, values in _options(cmd, ("basis", "remap", "units"), repeated=types, ntypes=deck.setup.ntypes).items():
        if keyword == "remap" and values != ["no"]:
            raise cmd.error("remap works with style single only")
    x, site = lattice_points(deck.setup)
    if region is not None:
        kept = region.contains(x)
        x, site = x[kept], site[kept]
    add_particles(deck.setup, types[site], x)


def _options(cmd: Command, known: tuple[str, ...], repeated: Ints | None = None, ntypes: int = 0) -> dict[str, list[str]]:
    """The keywords that are left; `basis M type` goes into `repeated`."""
    found: dict[str, list[str]] = {}
    while cmd:
        keyword = cmd.choice("keyword", known)
        if keyword == "basis" and repeated is not None:
            repeated[cmd.integer("basis", 1, len(repeated)) - 1] = cmd.integer("basis type", 1, ntypes)
        else:
            found[keyword] = [cmd.choice(keyword, {"remap": ("yes", "no"), "units": ("box", "lattice")}[keyword])]
    return found


@command("read_data")
def read_data(deck: Interpreter, cmd: Command) -> None:
    """read_data FILE [extra/atom/types N] [nocoeff]"""
    before_box(deck, cmd)
    if deck.setup.atom_style == "superquadric":
        raise cmd.error("reads spheres: superquadrics are made by create_atoms and set")
    name = cmd.take("a file")
    extra = 0
    while cmd:
        if cmd.choice("keyword", ("extra/atom/types", "nocoeff")) == "extra/atom/types":
            extra = cmd.integer("extra/atom/types", 0)
    path = deck.find_file(name)
    if not path.is_file():
        packed = path.with_name(f"{path.name}.gz")
        hint = f"; {packed.name} does: unpack it (gunzip -k)" if packed.is_file() else ""  # LAMMPS does not look for it either
        raise cmd.error(f"the file {name!r} does not exist (looked for {path}){hint}")
    data = read_data_file(path)
    ntypes = data.ntypes + extra
    if ntypes < 1:
        raise cmd.error(f"{name} names no atom types")
    make_box(deck, cmd, data.lo, data.hi, ntypes)
    deck.setup.atoms = particles_of(data, deck.setup)

"""fix, compute and pair commands: recorded as written, with what can be checked at once."""

from __future__ import annotations

from demverify.deck import insertion
from demverify.deck.command import Command, command
from demverify.deck.commands.group import known_group
from demverify.deck.commands.space import need_box
from demverify.deck.forces import CHECKS, RIGID
from demverify.deck.interpreter import Interpreter
from demverify.deck.setup import Spec
from demverify.deck.timestep_gran import STYLE as CHECK_TIMESTEP
from demverify.deck.timestep_gran import check_of
from demverify.formats import bodies

_BOTH = ("gravity", "nve/sphere", "freeze", "wall/gran", "setforce", "enforce2d", "viscous", "addforce", "print")
_FIXES = {
    "lammps": (*_BOTH, *RIGID, "property/atom", "euler/sphere", "wall/gran/region"),
    "liggghts": (*_BOTH, "nve/superquadric", "multisphere", "property/global", CHECK_TIMESTEP, *insertion.CHECKS),
}
_OUTPUT_FIXES = ("ave/time", "ave/atom", "ave/histo", "ave/spatial", "ave/chunk", "ave/euler", "balance")  # they only watch: noted and left out
_COMPUTES = {
    "lammps": ("erotate/sphere", "ke", "reduce", "erotate/rigid", "ke/rigid", "rigid/local"),
    "liggghts": ("erotate/sphere", "erotate/superquadric", "erotate/multisphere", "erotate", "ke", "ke/multisphere", "multisphere", "reduce"),
}
_BUILT_IN = ("thermo_temp", "thermo_press", "thermo_pe")


@command("fix")
def fix(deck: Interpreter, cmd: Command) -> None:
    """fix ID GROUP style args..."""
    name, group = cmd.take("an ID"), known_group(deck.setup, cmd)
    if cmd.peek() in _OUTPUT_FIXES:
        deck.ignore(cmd)
        return
    style = cmd.choice("style", _FIXES[deck.setup.dialect])
    need_box(deck, cmd)
    spec = Spec(name, group, style, cmd.rest(), cmd.place)
    old = deck.setup.fixes.get(name)
    if old and old.style != style:
        raise cmd.error(f"{name!r} is a fix {old.style} already and cannot become {style}")
    if style in CHECKS:
        CHECKS[style](deck.setup, spec)
    if style in insertion.CHECKS:
        insertion.CHECKS[style](deck.setup, spec)
    if style == CHECK_TIMESTEP:
        _only_spheres(deck, cmd, style)
        check_of(deck.setup, spec)
    deck.setup.fixes[name] = spec


@command("unfix")
def unfix(deck: Interpreter, cmd: Command) -> None:
    """unfix ID"""
    if (spec := deck.setup.fixes.get(cmd.peek())) and spec.style == "multisphere":
        raise cmd.error(f"fix {spec.id} multisphere holds the clumps, and LIGGGHTS does not let it go")
    if any(line.words[:2] == ("fix", *cmd.args) for line in deck.ignored):
        deck.ignore(cmd)
    else:
        deck.setup.inserted.discard(cmd.peek())
        remove(deck.setup.fixes, cmd, "fix")


@command("compute")
def compute(deck: Interpreter, cmd: Command) -> None:
    """compute ID GROUP style args..."""
    need_box(deck, cmd)
    name, group = cmd.take("an ID"), known_group(deck.setup, cmd)
    style = cmd.choice("style", _COMPUTES[deck.setup.dialect])
    if name in deck.setup.computes:
        raise cmd.error(f"{name!r} exists already")
    if style == "erotate/sphere":
        _only_spheres(deck, cmd, style)
    spec = Spec(name, group, style, cmd.rest(), cmd.place)
    if style in bodies.STYLES:
        bodies.check_compute(spec)
    deck.setup.computes[name] = spec


def _only_spheres(deck: Interpreter, cmd: Command, style: str) -> None:
    """Raises InputError where particles are superquadrics, whose radius is that of a sphere around them."""
    if deck.setup.atom_style == "superquadric":
        raise cmd.error(f"{style} is of spheres: not with atom_style superquadric")


@command("uncompute")
def uncompute(deck: Interpreter, cmd: Command) -> None:
    """uncompute ID"""
    remove(deck.setup.computes, cmd, "compute")


@command("fix_modify", "compute_modify")
def modify(deck: Interpreter, cmd: Command) -> None:
    """fix_modify and compute_modify change what is reported, not the physics: checked for the ID, then noted."""
    kind = cmd.name.split("_")[0]
    table = deck.setup.fixes if kind == "fix" else deck.setup.computes
    name = cmd.take("an ID")
    if name not in table and name not in _BUILT_IN and not any(name in line.words for line in deck.ignored):
        raise cmd.error(f"{kind} {name!r} does not exist; defined: {', '.join(table) or 'none'}")
    deck.ignore(cmd)


@command("pair_style")
def pair_style(deck: Interpreter, cmd: Command) -> None:
    """pair_style style args...: read when a run needs it, by materials_lammps or materials_liggghts."""
    cmd.take("a style")
    deck.setup.pair_style = cmd.args
    deck.setup.pair_place = cmd.place
    deck.setup.pair_coeffs.clear()


@command("pair_coeff")
def pair_coeff(deck: Interpreter, cmd: Command) -> None:
    """pair_coeff I J args..."""
    need_box(deck, cmd)
    if deck.setup.pair_style is None:
        raise cmd.error("needs a pair_style before it")
    deck.setup.pair_coeffs.append((cmd.args, cmd.place))


@command("soft_particles", "hard_particles")
def stiffness(deck: Interpreter, cmd: Command) -> None:
    """soft_particles yes, hard_particles yes: lift LIGGGHTS' bounds on Young's modulus."""
    setattr(deck.setup, cmd.name, cmd.yes("flag"))
    cmd.end()


def remove(table: dict[str, Spec], cmd: Command, kind: str) -> None:
    """Takes an ID and deletes it. Raises InputError listing those there are."""
    name = cmd.take("an ID")
    cmd.end()
    if name not in table:
        raise cmd.error(f"{kind} {name!r} does not exist; defined: {', '.join(table) or 'none'}")
    del table[name]

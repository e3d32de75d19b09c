"""Commands that change particles: set, velocity, displace_atoms."""

from __future__ import annotations

import re

import numpy as np

from demsolver.expression import COLUMNS
from demsolver.expression import value as evaluated
from demverify.deck.command import Command, command
from demverify.deck.commands.group import known_group
from demverify.deck.commands.space import need_box
from demverify.deck.delegate import delegated
from demverify.deck.interpreter import Interpreter
from demverify.deck.particles import center, density_mass, members, no_atoms, unfolded, velocity_of_center, wrap
from demverify.deck.regions import find_region, region_scale
from demverify.deck.set_shape import SHAPES, set_shape
from demverify.deck.setup import Atoms, Floats, Ints

_SELECT = ("atom", "type", "group", "region")
_VELOCITIES = {"vx": 0, "vy": 1, "vz": 2}
_POSITIONS = {"x": 0, "y": 1, "z": 2}
_SPINS = {"omegax": 0, "omegay": 1, "omegaz": 2}


def value(deck: Interpreter, cmd: Command, wanted: str) -> float:
    """The next word as a number, or as v_name of a variable."""
    if cmd.peek().startswith("v_"):
        return deck.variables.exact(cmd.take(wanted)[2:], cmd.place)
    return cmd.number(wanted)


def values(deck: Interpreter, cmd: Command, wanted: str, rows: Ints) -> float | Floats:
    """The same, or of an atom-style variable a number for each of the rows."""
    atoms, word = deck.setup.atoms or no_atoms(), cmd.peek()
    if not word.startswith("v_") or not deck.variables.is_of_particles(word[2:], cmd.place):
        return value(deck, cmd, wanted)
    formula = deck.variables.expression(cmd.take(wanted)[2:], deck.setup, cmd.place)
    columns = zip(*atoms.x[rows].T, *atoms.v[rows].T, atoms.mass[rows], atoms.radius[rows], atoms.type[rows], strict=True)
    return np.array([evaluated(formula, dict(zip(COLUMNS, row, strict=True))) for row in columns])


@command("mass")
def mass(deck: Interpreter, cmd: Command) -> None:
    """mass: both engines refuse it for spheres, whose masses follow from diameter and density."""
    raise cmd.error("does not work with spheres: use `set type N density RHO` or `set type N mass M`")


@command("set")
def set_(deck: Interpreter, cmd: Command) -> None:
    """set atom|type|group|region WHICH keyword value ..."""
    need_box(deck, cmd)
    atoms = deck.setup.atoms or no_atoms()
    if not atoms.n:
        raise cmd.error("there are no particles yet")
    rows = _selected(deck, cmd, atoms)
    if not cmd:
        raise cmd.error(f"expects a keyword: {', '.join(_keywords(deck))}")
    if "type/fraction" in cmd.args:
        deck.setup.atoms = delegated(deck, cmd)
        return
    while cmd:
        _set_one(deck, cmd, atoms, rows)


def _selected(deck: Interpreter, cmd: Command, atoms: Atoms) -> Ints:
    style = cmd.choice("style", _SELECT)
    cmd.what = f"set {style}"
    if style == "group":
        return members(deck.setup, known_group(deck.setup, cmd))
    if style == "region":
        return np.flatnonzero(find_region(deck.setup, cmd, cmd.take("a region ID")).contains(atoms.x))
    column = atoms.id if style == "atom" else atoms.type
    low, high = _bounds(cmd, int(column.max()) if style == "atom" else deck.setup.ntypes)
    return np.flatnonzero((column >= low) & (column <= high))


def _bounds(cmd: Command, largest: int) -> tuple[int, int]:
    """N, *, N*, *M, N*M as a range."""
    word = cmd.take("a number or a range with *")
    found = re.fullmatch(r"(\d*)(\*?)(\d*)", word, re.ASCII)
    if not found or not word or (found[3] and not found[2]):
        raise cmd.error(f"expects a number or a range such as 2*5, got {word!r}")
    low = int(found[1] or 1)
    high = int(found[3] or largest) if found[2] else low
    if not 1 <= low <= high <= largest:
        raise cmd.error(f"{word!r} is not within 1 to {largest}")
    return low, high


def _keywords(deck: Interpreter) -> tuple[str, ...]:
    spins = tuple(_SPINS) if deck.setup.dialect == "liggghts" else ("omega", "density/disc")
    if deck.setup.atom_style == "superquadric":
        return ("type", *SHAPES, "density", "mass", *_POSITIONS, *_VELOCITIES, *spins, "image")
    return ("type", "diameter", "density", "mass", *_POSITIONS, *_VELOCITIES, *spins, "image", "type/fraction")


def _set_one(deck: Interpreter, cmd: Command, atoms: Atoms, rows: Ints) -> None:
    keyword = cmd.choice("keyword", _keywords(deck))
    if keyword == "type":
        atoms.type[rows] = cmd.integer("type", 1, deck.setup.ntypes)
    elif deck.setup.atom_style == "superquadric" and keyword in (*SHAPES, "density", "mass", *_SPINS):
        set_shape(cmd, atoms, rows, keyword)
    elif keyword in ("diameter", "density", "density/disc", "mass"):
        _set_size(deck, cmd, atoms, rows, keyword)
    elif keyword == "omega":
        atoms.omega[rows] = cmd.vector("omega x", "omega y", "omega z")
    elif keyword == "image":
        for axis in range(3):
            if cmd.peek() == "NULL":
                cmd.take("NULL")
            else:
                atoms.image[rows, axis] = cmd.integer("image")
    else:
        table = {**_POSITIONS, **_VELOCITIES, **_SPINS}
        column = atoms.x if keyword in _POSITIONS else atoms.v if keyword in _VELOCITIES else atoms.omega
        column[rows, table[keyword]] = cmd.number(keyword)


def _set_size(deck: Interpreter, cmd: Command, atoms: Atoms, rows: Ints, keyword: str) -> None:
    number = cmd.positive(keyword)
    radius = atoms.radius[rows]
    if keyword == "mass":
        atoms.mass[rows] = number
    elif keyword == "diameter":
        if deck.setup.dialect == "liggghts":  # keeps the density; LAMMPS keeps the mass (both measured)
            density = atoms.mass[rows] / density_mass(deck.setup, radius, 1.0)
            atoms.mass[rows] = density_mass(deck.setup, np.full(len(rows), 0.5 * number), density)
        atoms.radius[rows] = 0.5 * number
    elif keyword == "density/disc" and deck.setup.dimension == 2:
        atoms.mass[rows] = np.pi * radius * radius * number
    else:
        atoms.mass[rows] = np.where(radius > 0.0, density_mass(deck.setup, radius, number), number)


@command("velocity")
def velocity(deck: Interpreter, cmd: Command) -> None:
    """velocity GROUP set|zero|ramp|create args..."""
    need_box(deck, cmd)
    name = known_group(deck.setup, cmd)
    styles = ("set", "zero", "ramp") if deck.setup.dialect == "liggghts" else ("set", "zero", "ramp", "create")
    style = cmd.choice("style", styles)
    cmd.what = f"velocity {style}"
    if style == "create":
        deck.setup.atoms = delegated(deck, cmd)
        return
    rows = members(deck.setup, name)
    {"set": _velocity_set, "zero": _velocity_zero, "ramp": _velocity_ramp}[style](deck, cmd, deck.setup.atoms or no_atoms(), rows)


def _velocity_set(deck: Interpreter, cmd: Command, atoms: Atoms, rows: Ints) -> None:
    scale = region_scale(deck.setup, cmd)
    wanted: list[float | Floats | None] = []
    for axis, name in enumerate("xyz"):
        variable = cmd.peek().startswith("v_")  # LAMMPS does not scale the value of a variable
        none = cmd.peek() == "NULL" and bool(cmd.take("NULL"))
        wanted.append(None if none else values(deck, cmd, f"v{name}", rows) * (1.0 if variable else float(scale[axis])))
    if deck.setup.dimension == 2 and wanted[2] is not None and np.any(wanted[2]):
        raise cmd.error("vz must be 0 in two dimensions")
    add = _sum_option(cmd)
    for axis, number in enumerate(wanted):
        if number is not None:
            atoms.v[rows, axis] = atoms.v[rows, axis] + number if add else number


def _velocity_ramp(deck: Interpreter, cmd: Command, atoms: Atoms, rows: Ints) -> None:
    scale = region_scale(deck.setup, cmd)
    axis = "xyz".index(cmd.choice("velocity component", ("vx", "vy", "vz"))[1])
    low, high = (number * scale[axis] for number in cmd.vector("vlo", "vhi"))
    along = "xyz".index(cmd.choice("coordinate", "xyz"))
    start, end = (number * scale[along] for number in cmd.vector("clo", "chi"))
    if start == end:
        raise cmd.error("clo and chi must differ")
    add = _sum_option(cmd)
    ramp = low + np.clip((atoms.x[rows, along] - start) / (end - start), 0.0, 1.0) * (high - low)
    atoms.v[rows, axis] = atoms.v[rows, axis] + ramp if add else ramp


def _sum_option(cmd: Command) -> bool:
    add = False
    while cmd:
        if cmd.choice("keyword", ("sum", "units")) == "sum":
            add = cmd.yes("sum")
        else:
            cmd.choice("units", ("box", "lattice"))
    return add


def _velocity_zero(deck: Interpreter, cmd: Command, atoms: Atoms, rows: Ints) -> None:
    what = cmd.choice("what", ("linear", "angular"))
    cmd.end()
    if not len(rows):
        raise cmd.error("the group holds no particles")
    if what == "linear":
        atoms.v[rows] -= velocity_of_center(atoms, rows)
    else:
        box = need_box(deck, cmd)
        arm = unfolded(atoms, rows, box) - center(atoms, rows, box)
        atoms.v[rows] -= np.cross(_spin(arm, atoms.mass[rows], atoms.v[rows]), arm)


def _spin(arm: Floats, mass: Floats, v: Floats) -> Floats:
    """(3,) angular velocity of points as one rigid body: inertia tensor against angular momentum."""
    momentum = (mass[:, None] * np.cross(arm, v)).sum(axis=0)
    inertia = (mass * (arm * arm).sum(axis=1)).sum() * np.eye(3) - (mass[:, None] * arm).T @ arm
    return np.asarray(np.linalg.lstsq(inertia, momentum, rcond=None)[0])


@command("displace_atoms")
def displace_atoms(deck: Interpreter, cmd: Command) -> None:
    """displace_atoms GROUP move dx dy dz | random ... | rotate ... [units box|lattice]"""
    box = need_box(deck, cmd)
    rows = members(deck.setup, known_group(deck.setup, cmd))
    style = cmd.choice("style", ("move", "random", "rotate"))
    cmd.what = f"displace_atoms {style}"
    if style != "move":
        deck.setup.atoms = delegated(deck, cmd)
        return
    scale = region_scale(deck.setup, cmd)
    by = np.array([value(deck, cmd, f"d{axis}") for axis in "xyz"]) * scale
    if cmd:
        cmd.choice("keyword", ("units",))
        cmd.choice("units", ("box", "lattice"))
    cmd.end()
    atoms = deck.setup.atoms or no_atoms()
    with np.errstate(over="ignore"):  # an overflow is named, with its particle, when the scene is built
        atoms.x[rows] += by
    deck.setup.atoms = wrap(atoms, box)

"""thermo and dump commands."""

from __future__ import annotations

from pathlib import PurePosixPath

from demverify.deck.command import Command, command
from demverify.deck.commands.group import known_group
from demverify.deck.commands.space import need_box
from demverify.deck.interpreter import Interpreter
from demverify.deck.setup import DumpSpec, ThermoSpec
from demverify.formats import bodies
from demverify.formats.columns import columns_of

_THERMO = ("norm", "lost", "flush", "format", "line", "warn", "colname", "temp", "press")
_OTHER_DUMPS = (  # of either engine; they cannot change the physics
    *("local", "image", "movie", "xyz", "cfg", "dcd", "xtc", "vtk", "yaml", "netcdf", "h5md", "grid", "atom/gz", "custom/gz"),
    *("atom/vtk", "custom/vtk", "local/gran", "local/gran/vtk", "mesh/stl", "mesh/vtk", "stl", "decomposition/vtk", "euler/vtk"),
)
_ATOM_COLUMNS = ("id", "type", "xs", "ys", "zs")


@command("thermo")
def thermo(deck: Interpreter, cmd: Command) -> None:
    """thermo N"""
    deck.setup.thermo.every = cmd.integer("number of steps", 0)
    cmd.end()


@command("thermo_style")
def thermo_style(deck: Interpreter, cmd: Command) -> None:
    """thermo_style one|multi|custom keywords...: forgets thermo_modify settings made before."""
    style = cmd.choice("style", ("one", "multi", "custom"))
    columns = cmd.rest()
    if (style == "custom") != bool(columns):
        raise cmd.error(f"{style} expects {'keywords' if style == 'custom' else 'no keywords'}, got {' '.join(columns)!r}")
    deck.setup.thermo = ThermoSpec(deck.setup.thermo.every, style, columns, place=cmd.place)


@command("thermo_modify")
def thermo_modify(deck: Interpreter, cmd: Command) -> None:
    """thermo_modify norm yes|no, lost error|warn|ignore, format ..., flush ..."""
    settings = deck.setup.thermo.modify
    while cmd:
        keyword = cmd.choice("keyword", _THERMO)
        if keyword == "format":
            which = cmd.take("line, int, float, none or a column")
            settings["format" if which == "none" else f"format {which}"] = "" if which == "none" else cmd.take("a format")
        elif keyword == "norm":
            settings[keyword] = "yes" if cmd.yes("norm") else "no"
        elif keyword == "lost":
            settings[keyword] = cmd.choice("lost", ("error", "warn", "ignore"))
        elif keyword == "colname":
            cmd.take("a column")
            cmd.take("a name")
        else:
            cmd.take(f"a value for {keyword}")


@command("dump")
def dump(deck: Interpreter, cmd: Command) -> None:
    """dump ID GROUP custom|atom N FILE columns..."""
    need_box(deck, cmd)
    name, group = cmd.take("an ID"), known_group(deck.setup, cmd)
    if name in deck.setup.dumps:
        raise cmd.error(f"{name!r} exists already")
    if cmd.peek() == "local" and any(spec.style in bodies.STYLES for spec in deck.setup.computes.values()):
        _dump_bodies(deck, cmd, name, group)
        return
    if cmd.peek() in _OTHER_DUMPS:
        deck.ignore(cmd)
        deck.printed.append(f"WARNING: dump {name} of style {cmd.peek()} is left out: custom and atom are written ({cmd.place})")
        return
    style = cmd.choice("style", ("custom", "atom"))
    every, file = cmd.integer("number of steps", 1), cmd.take("a file")
    columns = cmd.rest() or (_ATOM_COLUMNS if style == "atom" else ())
    if not columns:
        raise cmd.error("custom expects the columns to write")
    clumps = any(spec.style == "multisphere" for spec in deck.setup.fixes.values())
    there = columns_of(superquadrics=deck.setup.atom_style == "superquadric", clumps=clumps)
    known = [column for column in there if (deck.setup.dialect, column) != ("lammps", "density")]
    for column in columns:
        if column not in known:
            raise cmd.error(f"custom column {column!r} is not one of {', '.join(known)}")
    _check_file(cmd, file)
    deck.setup.dumps[name] = DumpSpec(name, group, style, every, file, columns, cmd.place)


def _dump_bodies(deck: Interpreter, cmd: Command, name: str, group: str) -> None:
    """dump ID GROUP local N FILE c_ID[k]...: a row a clump."""
    style = cmd.choice("style", ("local",))
    every, file = cmd.integer("number of steps", 1), cmd.take("a file")
    columns = bodies.expanded(cmd.rest(), deck.setup.computes, cmd.place)
    _check_file(cmd, file)
    deck.setup.dumps[name] = DumpSpec(name, group, style, every, file, columns, cmd.place)


def _check_file(cmd: Command, file: str) -> None:
    if (path := PurePosixPath(file)).is_absolute() or ".." in path.parts or not path.name or "%" in file:
        raise cmd.error(f"file {file!r} is not a relative path inside the run's folder, for all ranks (no %)")


@command("undump")
def undump(deck: Interpreter, cmd: Command) -> None:
    """undump ID"""
    if _left_out(deck, cmd):
        return
    _dump(deck, cmd)
    del deck.setup.dumps[cmd.args[0]]


def _left_out(deck: Interpreter, cmd: Command) -> bool:
    """Whether the command is about a dump that was left out: it is noted as well."""
    found = bool(cmd) and cmd.peek() not in deck.setup.dumps and any(line.words[:2] == ("dump", cmd.peek()) for line in deck.ignored)
    if found:
        deck.ignore(cmd)
    return found


def _dump(deck: Interpreter, cmd: Command) -> DumpSpec:
    name = cmd.take("an ID")
    if name not in deck.setup.dumps:
        raise cmd.error(f"dump {name!r} does not exist; defined: {', '.join(deck.setup.dumps) or 'none'}")
    return deck.setup.dumps[name]


@command("dump_modify")
def dump_modify(deck: Interpreter, cmd: Command) -> None:
    """dump_modify ID sort|format|every|first|pad|element|flush ..."""
    if _left_out(deck, cmd):
        return
    spec = _dump(deck, cmd)
    spec.place = cmd.place
    while cmd:
        keyword = cmd.choice("keyword", ("sort", "format", "every", "first", "pad", "element", "flush", "precision"))
        if keyword == "sort":
            spec.sort = cmd.take("id, off or a column")
        elif keyword == "every":
            spec.every = cmd.integer("every", 1)
        elif keyword == "first":
            spec.first = cmd.yes("first")
        elif keyword == "pad":
            spec.pad = cmd.integer("pad", 0)
        elif keyword == "format":
            _format(deck, cmd, spec)
        elif keyword == "element":
            for _ in range(deck.setup.ntypes):
                cmd.take("an element for each type")
        else:
            cmd.take(f"a value for {keyword}")


def _format(deck: Interpreter, cmd: Command, spec: DumpSpec) -> None:
    """LAMMPS: line|float|int|N FORMAT, or none. LIGGGHTS: the whole line's format, or none."""
    word = cmd.take("a format")
    if word == "none":
        spec.format.clear()
    elif deck.setup.dialect == "liggghts" or "%" in word:
        spec.format["line"] = word
    elif word in ("line", "float", "int") or (word.isdecimal() and 1 <= int(word) <= len(spec.columns)):
        spec.format[word] = cmd.take("a format")
    else:
        raise cmd.error(f"format expects line, float, int, none or a column from 1 to {len(spec.columns)}, got {word!r}")

"""group: names for sets of particles, kept as bits of the particles' masks."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demverify.deck.command import Command, command
from demverify.deck.commands.space import need_box
from demverify.deck.interpreter import Interpreter
from demverify.deck.particles import no_atoms
from demverify.deck.regions import find_region
from demverify.deck.setup import Atoms, DumpSpec, Ints, Setup, Spec

_MOST_GROUPS = 32
_STYLES = ("type", "id", "molecule", "region", "subtract", "union", "intersect", "empty", "clear", "delete")
_COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
Bools = NDArray[np.bool_]


def known_group(setup: Setup, cmd: Command) -> str:
    """The next word as the name of a group that exists. Raises InputError listing those there are."""
    name = cmd.take("a group")
    if name not in setup.groups:
        raise cmd.error(f"group {name!r} does not exist; defined: {', '.join(setup.groups)}")
    return name


@command("group")
def group(deck: Interpreter, cmd: Command) -> None:
    """group ID type|id|molecule values | region ID | subtract|union|intersect ID... | empty | clear | delete"""
    need_box(deck, cmd)
    name = cmd.take("an ID")
    style = cmd.choice("style", _STYLES)
    cmd.what = f"group {style}"
    atoms = deck.setup.atoms or no_atoms()
    if style in ("clear", "delete"):
        _remove(deck.setup, cmd, name, style, atoms)
    else:
        member = _members(deck.setup, cmd, style, atoms)
        atoms.mask |= member.astype(np.int64) << _bit(deck.setup, cmd, name)
    cmd.end()


def _members(setup: Setup, cmd: Command, style: str, atoms: Atoms) -> Bools:
    if style == "region":
        return find_region(setup, cmd, cmd.take("a region ID")).contains(atoms.x)
    if style in ("type", "id", "molecule"):
        return _by_value(cmd, getattr(atoms, style))
    if style == "empty":
        return np.zeros(atoms.n, dtype=bool)
    return _combined(setup, cmd, style, atoms)


def _combined(setup: Setup, cmd: Command, style: str, atoms: Atoms) -> Bools:
    sets = [(atoms.mask >> setup.groups[known_group(setup, cmd)] & 1).astype(bool)]
    while cmd:
        sets.append((atoms.mask >> setup.groups[known_group(setup, cmd)] & 1).astype(bool))
    if style == "union":
        return np.asarray(np.logical_or.reduce(sets))
    if len(sets) < 2:
        raise cmd.error("expects at least two groups")
    if style == "intersect":
        return np.asarray(np.logical_and.reduce(sets))
    return np.asarray(sets[0] & ~np.logical_or.reduce(sets[1:]))


def _by_value(cmd: Command, column: Ints) -> Bools:
    if cmd.peek() == "<>":
        cmd.take("<>")
        low, high = cmd.integer("lower bound"), cmd.integer("upper bound")
        return np.asarray((column >= low) & (column <= high))
    if cmd.peek() in _COMPARE:
        compare = _COMPARE[cmd.take("a comparison")]
        return np.asarray(compare(column, cmd.integer("bound")))
    member = _range(cmd, column)
    while cmd:
        member |= _range(cmd, column)
    return member


def _range(cmd: Command, column: Ints) -> Bools:
    """One value, or first:last, or first:last:step."""
    word = cmd.take("a value")
    parts = word.split(":")
    if len(parts) > 3 or not all(part.lstrip("-").isdecimal() for part in parts):
        raise cmd.error(f"expects a value, first:last or first:last:step, got {word!r}")
    first, last, step = int(parts[0]), int(parts[min(1, len(parts) - 1)]), int(parts[2]) if len(parts) == 3 else 1
    if first > last or step < 1:
        raise cmd.error(f"the range {word!r} is empty")
    return np.asarray((column >= first) & (column <= last) & ((column - first) % step == 0))


def _bit(setup: Setup, cmd: Command, name: str) -> int:
    """The bit of a group, a free one if it is new."""
    if name not in setup.groups:
        free = [bit for bit in range(_MOST_GROUPS) if bit not in setup.groups.values()]
        if not free:
            raise cmd.error(f"no more than {_MOST_GROUPS} groups can exist")
        setup.groups[name] = free[0]
    return setup.groups[name]


def _remove(setup: Setup, cmd: Command, name: str, style: str, atoms: Atoms) -> None:
    if name not in setup.groups or name == "all":
        others = ", ".join(other for other in setup.groups if other != "all") or "none"
        raise cmd.error(f"cannot {style} {name!r}; groups of this deck: {others}")
    specs: list[Spec | DumpSpec] = [*setup.fixes.values(), *setup.computes.values(), *setup.dumps.values()]
    users = [spec.id for spec in specs if spec.group == name]
    hidden = [*(pair for what, *pair in setup.neighbor.exclude if what == "group"), *([group] for group, _ in setup.neighbor.exclude_intra)]
    users += ["neigh_modify exclude"] if any(name in groups for groups in hidden) else []
    if style == "delete" and users:
        raise cmd.error(f"group {name!r} is in use by {', '.join(users)}")
    atoms.mask &= ~(1 << setup.groups[name])
    if style == "delete":
        del setup.groups[name]

"""Cases: a folder with in.lammps, in.liggghts and case.toml, which says what is measured and against what.

title = "..."                            what = "one or two sentences for the report"
accept = ["entry-id", ...]               known differences between the engines (register) that the case lives with
every = N                                steps between the frames that are compared; by default some 200 frames
[[law]]  name = "slip_cessation"  tolerance = 1e-3  reason = "why this tolerance"  parameters = {...}
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any

from demverify import laws
from demverify.deck.setup import Dialect
from demverify.errors import InputError, Place

_TEXT, _LIST = ("a text", str), ("a list", list)
_KEYS = {"title": _TEXT, "what": _TEXT, "accept": _LIST, "every": ("a whole number", int), "law": ("[[law]] tables", list)}
_LAW_KEYS = {"name": _TEXT, "tolerance": ("a number", int | float), "reason": _TEXT, "parameters": ("a table", dict)}
DECKS: dict[Dialect, str] = {"lammps": "in.lammps", "liggghts": "in.liggghts"}


@dataclass(frozen=True)
class Law:
    """A closed form to hold a case against; `tolerance` is of engine against law, and `reason` says why it is what it is."""

    name: str
    tolerance: float
    reason: str
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Case:
    """What a comparison works on. decks: dialect -> deck, one or both. accept: ids of the register."""

    title: str
    decks: Mapping[Dialect, Path]
    what: str = ""
    accept: tuple[str, ...] = ()
    laws: tuple[Law, ...] = ()
    every: int | None = None


def load_case(folder: Path) -> Case:
    """Reads a case folder. Raises InputError: no decks, a key that is not known, a missing tolerance or reason."""
    decks = {dialect: folder / name for dialect, name in DECKS.items() if (folder / name).is_file()}
    if not decks:
        message = f"no {' or '.join(DECKS.values())} in this folder"
        raise InputError(message, Place(folder))
    file = folder / "case.toml"
    table = _table(file) if file.is_file() else {}
    _known(table, _KEYS, "key", file)
    return Case(
        title=table.get("title", folder.resolve().name),
        decks=decks,
        what=table.get("what", ""),
        accept=tuple(table.get("accept", ())),
        laws=tuple(_law(entry, file) for entry in table.get("law", ())),
        every=_every(table, file),
    )


def _table(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        line = re.search(r"at line (\d+)", str(error))
        message = f"not a readable case.toml: {error}"
        raise InputError(message, Place(file, int(line[1]) if line else 0)) from None


def _every(table: Mapping[str, Any], file: Path) -> int | None:
    every = table.get("every")
    if every is not None and every < 1:
        message = f"every must be a whole number of steps from 1, got {every!r}"
        raise InputError(message, Place(file))
    return every


def _law(entry: Mapping[str, Any], file: Path) -> Law:
    _known(entry, _LAW_KEYS, "law key", file)
    missing = [key for key in ("name", "tolerance", "reason") if key not in entry]
    if missing:
        message = f"a [[law]] needs name, tolerance and reason; {missing[0]} is missing"
        raise InputError(message, Place(file))
    law = Law(entry["name"], float(entry["tolerance"]), entry["reason"], entry.get("parameters", {}))
    if not (isfinite(law.tolerance) and law.tolerance > 0):
        message = f"the tolerance of law {law.name} must be a number above zero, got {law.tolerance:g}"
        raise InputError(message, Place(file))
    laws.check(law.name, law.parameters, Place(file))
    return law


def _known(table: Any, kinds: Mapping[str, tuple[str, Any]], what: str, file: Path) -> None:
    """Raises InputError for a key that is not in `kinds`, or whose value is not of the kind that is said there."""
    for key, value in table.items() if isinstance(table, dict) else [("", table)]:
        if key not in kinds:
            message = f"{what} {key or value!r} is not one of {', '.join(kinds)}"
            raise InputError(message, Place(file))
        wanted, kind = kinds[key]
        if not isinstance(value, kind) or isinstance(value, bool):
            message = f"{what} {key!r} must be {wanted}, got {value!r}"
            raise InputError(message, Place(file))

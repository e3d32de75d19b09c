"""Cases: a folder with in.lammps, in.liggghts and case.toml, which says what is measured and against what.

title = "..."                            what = "one or two sentences for the report"
scenario = "oblique impact"              what physics; cases of one scenario stand together in the catalogue
source = "DOI, or document and equation" where parameters and closed form come from
accept = ["entry-id", ...]               known differences between the engines (register) that every variant lives with; one that explains none fails
without = { liggghts = "why" }           an engine that this case cannot have; a deck in its dialect is for native alone
every = N                                steps between the frames that are compared; by default some 200 frames
[[variant]]  name = "e0.8"  variables = { e = 0.8 }        the decks with these variables; title, accept, without: its own
[[law]]  name = "slip_cessation"  tolerance = 1e-3  reason = "why this tolerance"  parameters = { restitution = "${e}" }
         only = ["e0.8", ...]                              the variants it holds for, all by default
         deviates = { liggghts = "entry-id" }              runs of this dialect (engine) must miss it, for what the register says
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any

from demverify import laws
from demverify.deck.setup import Dialect
from demverify.errors import InputError, Place

FILE = "case.toml"
DECKS: dict[Dialect, str] = {"lammps": "in.lammps", "liggghts": "in.liggghts"}
_TEXT, _LIST, _TABLE = ("a text", str), ("a list of texts", list), ("a table", dict)
_KEYS = {
    "title": _TEXT, "what": _TEXT, "scenario": _TEXT, "source": _TEXT, "accept": _LIST, "without": _TABLE,
    "every": ("a whole number", int), "variant": ("[[variant]] tables", list), "law": ("[[law]] tables", list),
}  # fmt: skip
_VARIANT_KEYS = {"name": _TEXT, "variables": _TABLE, "title": _TEXT, "accept": _LIST, "without": _TABLE}
_LAW_KEYS = {"name": _TEXT, "tolerance": ("a number", int | float), "reason": _TEXT, "parameters": _TABLE, "only": _LIST, "deviates": _TABLE}
_REFERENCE = re.compile(r"\$\{(\w+)\}")
_NAME = re.compile(r"[\w.+-]+")


@dataclass(frozen=True)
class Law:
    """A closed form to hold a case against; `tolerance` is of engine against law, and `reason` says why it is what it is.

    deviates: engine -> id of the register: runs of this engine's dialect must miss the law, and do so for this reason."""

    name: str
    tolerance: float
    reason: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    deviates: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Case:
    """What a comparison works on. decks: dialect -> deck, one or both. accept: ids of the register. variables: of the decks.

    name: that of the folder, and of the variant behind a colon. without: engine -> why the case cannot have it; a deck in its dialect is native's
    alone."""

    title: str
    decks: Mapping[Dialect, Path]
    what: str = ""
    accept: tuple[str, ...] = ()
    laws: tuple[Law, ...] = ()
    every: int | None = None
    name: str = ""
    scenario: str = ""
    source: str = ""
    variables: Mapping[str, list[str]] = field(default_factory=dict)
    without: Mapping[str, str] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Where its decks are."""
        return next(iter(self.decks.values())).parent


def load_cases(folder: Path) -> tuple[Case, ...]:
    """Reads a case folder: a case for each variant, or the one there is. Raises InputError: no decks, a key that is not known, a missing
    tolerance or reason."""
    decks = {dialect: folder / name for dialect, name in DECKS.items() if (folder / name).is_file()}
    if not decks:
        message = f"no {' or '.join(DECKS.values())} in this folder"
        raise InputError(message, Place(folder))
    file = folder / FILE
    table = _table(file) if file.is_file() else {}
    _known(table, _KEYS, "key", file)
    variants = table.get("variant") or [{}]
    for variant in table.get("variant", ()):
        _check_variant(variant, file)
    names = [variant.get("name", "") for variant in variants]
    if twice := [name for name in names if names.count(name) > 1]:
        message = f"variant {twice[0]!r} is there twice"
        raise InputError(message, Place(file))
    return tuple(_case(folder, decks, table, variant, names, file) for variant in variants)


def find_cases(root: Path) -> tuple[Path, ...]:
    """Folders with a case.toml: `root`, or those below it. Sorted by name."""
    return tuple(sorted(file.parent for file in ([root / FILE] if (root / FILE).is_file() else root.rglob(FILE))))


def split_variant(target: Path) -> tuple[Path, str] | None:
    """FOLDER:VARIANT as the two, or a folder and no variant; None where there is no such folder."""
    if target.is_dir():
        return target, ""
    folder, colon, variant = f"{target}".rpartition(":")
    return (Path(folder), variant) if variant and colon and Path(folder).is_dir() else None


def load_case(folder: Path, variant: str = "") -> Case:
    """One case: the only one of a folder, or the variant of this name. Raises InputError as load_cases does, and where there are several or
    none of this name."""
    cases = load_cases(folder)
    wanted = f"{folder.resolve().name}:{variant}" if variant else ""
    found = [case for case in cases if not wanted or case.name == wanted]
    if len(found) != 1:
        names = ", ".join(case.name.partition(":")[2] or "no variants" for case in cases)
        message = f"there is no variant {variant!r}; there are {names}" if wanted else f"which variant? {folder}:NAME, of {names}"
        raise InputError(message, Place(folder / FILE))
    return found[0]


def _case(
    folder: Path, decks: Mapping[Dialect, Path], table: Mapping[str, Any], variant: Mapping[str, Any], names: Sequence[str], file: Path
) -> Case:
    name, own = folder.resolve().name, variant.get("name", "")
    values = variant.get("variables", {})
    title = table.get("title", name)
    return Case(
        title=variant.get("title", f"{title}, {own}" if own else title),
        decks=decks,
        what=table.get("what", ""),
        accept=(*_texts(table, "accept", file), *_texts(variant, "accept", file)),
        laws=tuple(law for entry in table.get("law", ()) if (law := _law(entry, own, names, values, file))),
        every=_every(table, file),
        name=f"{name}:{own}" if own else name,
        scenario=table.get("scenario", ""),
        source=table.get("source", ""),
        variables={key: [f"{value}"] for key, value in values.items()},
        without=_engines(table, "without", file) | _engines(variant, "without", file),
    )


def _check_variant(variant: Any, file: Path) -> None:
    _known(variant, _VARIANT_KEYS, "variant key", file)
    if not _NAME.fullmatch(variant.get("name", "")):
        message = f"a [[variant]] needs a name of letters, digits and _ . + -, got {variant.get('name', '')!r}"
        raise InputError(message, Place(file))
    for key, value in variant.get("variables", {}).items():
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            message = f"variant {variant['name']}: variable {key} must be a number or a text, got {value!r}"
            raise InputError(message, Place(file))


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


def _law(entry: Any, variant: str, names: Sequence[str], values: Mapping[str, Any], file: Path) -> Law | None:
    """A [[law]] table with the variant's values put in; None where it is not for this variant."""
    _known(entry, _LAW_KEYS, "law key", file)
    missing = [key for key in ("name", "tolerance", "reason") if key not in entry]
    if missing:
        message = f"a [[law]] needs name, tolerance and reason; {missing[0]} is missing"
        raise InputError(message, Place(file))
    only = _texts(entry, "only", file)
    if unknown := [name for name in only if name not in names]:
        message = f"law {entry['name']} is only for variant {unknown[0]!r}, which is not one of {', '.join(names)}"
        raise InputError(message, Place(file))
    if only and variant not in only:
        return None
    parameters = {key: _value(value, values, key, file) for key, value in entry.get("parameters", {}).items()}
    law = Law(entry["name"], float(entry["tolerance"]), entry["reason"], parameters, _engines(entry, "deviates", file))
    if not (isfinite(law.tolerance) and law.tolerance > 0):
        message = f"the tolerance of law {law.name} must be a number above zero, got {law.tolerance:g}"
        raise InputError(message, Place(file))
    laws.check(law.name, law.parameters, Place(file))
    return law


def _value(value: Any, values: Mapping[str, Any], key: str, file: Path) -> Any:
    """A parameter as it stands, or the variable of the variant that "${name}" names."""
    found = _REFERENCE.fullmatch(value) if isinstance(value, str) else None
    if not found:
        return value
    if found[1] not in values:
        message = f"law parameter {key}: no variable {found[1]!r} in this variant; it has {', '.join(values) or 'none'}"
        raise InputError(message, Place(file))
    return values[found[1]]


def _texts(table: Mapping[str, Any], key: str, file: Path) -> tuple[str, ...]:
    found = table.get(key, [])
    if wrong := [one for one in found if not isinstance(one, str)]:
        message = f"{key!r} must be a list of texts, got {wrong[0]!r} in it"
        raise InputError(message, Place(file))
    return tuple(found)


def _engines(table: Mapping[str, Any], key: str, file: Path) -> dict[str, str]:
    """What a table has under `key`: engine -> text."""
    found = table.get(key, {})
    for engine, text in found.items():
        if engine not in DECKS or not isinstance(text, str):
            message = f"{key}: expected {' or '.join(DECKS)} = a text, got {engine} = {text!r}"
            raise InputError(message, Place(file))
    return dict(found)


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

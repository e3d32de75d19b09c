"""Studies: what a document states, computed again through the native solver. One study a file, read off the folder; its name is the file's.

A study module has

    TITLE                 what is studied, as on the page
    SOURCE                the document: authors, year, title, where it appeared
    run(quick, progress)  -> Study

quick: a smaller run of at most 20 seconds that still shows every finding (continuous integration); False: the whole, a few minutes on two cores.
progress(what, share): to be called now and then with what is being done and the share of the study that is done, 0 to 1.

A Study is a row of findings. A Finding is one figure, table or section of the document: its claims, and the figures, tables and numbers behind them.
A Claim is one statement, what came out, and whether it came out; `came_out` is to be computed from the numbers, never written down. Where it did
not, `why` says why; a claim that did not come out and has no `why` makes `demverify reproduce` end with status 1.

`demverify reproduce` writes all of it: DIR/<study>/report.html, a file <figure name>.svg for each figure, and numbers.json.
A module whose name starts with an underscore is not a study, but what studies share.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, Literal

from demverify.errors import InputError

Progress = Callable[[str, float], object]


@dataclass(frozen=True)
class Claim:
    """One statement and what came out.

    states: the statement, in words and numbers. found: what came out, in words and numbers. came_out: whether the two are the same.
    why: the reason where they are known not to be; told only where they are not. whose: "document", or "ours" for what the document does not
    state and this study adds.
    """

    states: str
    found: str
    came_out: bool
    why: str = ""
    whose: Literal["document", "ours"] = "document"


@dataclass(frozen=True)
class Figure:
    """One picture. name: stem of its file. caption: what is seen, a sentence. svg: as `demverify.report.charts.chart` draws it."""

    name: str
    caption: str
    svg: str


@dataclass(frozen=True)
class Table:
    """One table. title: a heading. head: names of the columns. rows: texts, or numbers (printed with three digits); first column names the row."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]


@dataclass(frozen=True)
class Finding:
    """One figure, table or section of the document.

    title: which, and what it is about. claims: at least one. set_up: how it was computed, where that needs words. numbers: everything behind
    the claims, for the JSON file: numbers, texts, sequences, arrays and mappings of these.
    """

    title: str
    claims: tuple[Claim, ...]
    set_up: str = ""
    figures: tuple[Figure, ...] = ()
    tables: tuple[Table, ...] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Study:
    """What came out of one study. readings: where the document does not say, what was taken instead, and why; a sentence each.

    states: who makes the statements, a document or, for a study of our own, theory.
    """

    title: str
    source: str
    findings: tuple[Finding, ...]
    readings: tuple[str, ...] = ()
    states: Literal["document", "theory"] = "document"


def listing() -> tuple[str, ...]:
    """Names of the studies, read off the folder."""
    return tuple(sorted(module.name for module in iter_modules(__path__) if not module.name.startswith("_")))


def run(name: str, quick: bool, progress: Progress) -> Study:
    """Runs one study. Raises InputError for an unknown name."""
    check((name,))
    found: Study = import_module(f"{__name__}.{name}").run(quick, progress)
    return found


def check(names: Sequence[str]) -> None:
    """Raises InputError for a name that is no study."""
    for name in names:
        if name not in listing():
            message = f"study {name!r} is not one of {', '.join(listing()) or '(none)'}"
            raise InputError(message)


def unexplained(study: Study) -> list[Claim]:
    """The claims that did not come out, and nobody says why."""
    return [claim for finding in study.findings for claim in finding.claims if not claim.came_out and not claim.why]

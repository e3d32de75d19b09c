"""The library on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from demverify.cases import Case
    from demverify.library import Verified

MARK = {"pass": "[green]pass[/]", "deviation": "[yellow]deviation[/]", "skipped": "[dim]skipped[/]", "fail": "[red]FAIL[/]"}
LETTERS = {"native": "N", "lammps": "L", "liggghts": "G"}


def print_catalogue(cases: Sequence[Case]) -> None:
    """A line for each case; which engines: N native, L LAMMPS, G LIGGGHTS."""
    table = Table("scenario", "case", "engines", "closed form", "source", box=None, pad_edge=False)
    before = ""
    for case in cases:
        letters = "".join(LETTERS[engine] for engine in ("native", *case.decks))
        laws = ", ".join(dict.fromkeys(law.name for law in case.laws)) or "engine against engine"
        table.add_row(case.scenario if case.scenario != before else "", case.name, letters, laws, case.source)
        before = case.scenario
    console = _console()
    console.print(table)
    scenarios, forms = {case.scenario for case in cases}, {law.name for case in cases for law in case.laws}
    console.print(f"{len(cases)} cases in {len(scenarios)} scenarios, {len(forms)} closed forms; N native, L LAMMPS, G LIGGGHTS")


def print_verified(found: Sequence[Verified], columns: Sequence[str], page: Path) -> None:
    """Counts by scenario and engine, what failed, and where the page is."""
    console = _console()
    table = Table("scenario", "cases", *columns, box=None, pad_edge=False)
    for scenario in dict.fromkeys(one.case.scenario for one in found):
        own = [one for one in found if one.case.scenario == scenario]
        table.add_row(scenario or "-", f"{len(own)}", *(_counted([one.cell(engine).status for one in own]) for engine in columns))
    console.print(table)
    for one in found:
        for engine in columns:
            cell = one.cell(engine)
            if cell.status == "fail":
                console.print(f"FAIL {one.case.name} [{engine}]: {' '.join(cell.reason.split())[:400]}", markup=False, style="red")
    statuses = [one.cell(engine).status for one in found for engine in columns]
    told = ", ".join(f"{statuses.count(status)} {status}" for status in MARK if status in statuses)
    console.print(f"{len(found)} cases: {told}", markup=False)
    console.print(f"report: {page}", markup=False)


def _counted(statuses: Sequence[str]) -> str:
    return ", ".join(f"{statuses.count(status)} {mark}" for status, mark in MARK.items() if status in statuses)


def _console() -> Console:
    """Of the terminal's width; 160 columns where the output goes elsewhere."""
    console = Console(highlight=False, soft_wrap=True)
    return console if console.is_terminal else Console(highlight=False, soft_wrap=True, width=160)

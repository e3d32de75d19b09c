"""A study on the terminal: statement by statement, what came out."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from demverify.report.study import outcome, summary
from demverify.studies import Study

_COLOURS = {"came out": "green", "did not come out": "yellow", "unexplained": "red"}


def print_study(name: str, study: Study, page: Path) -> None:
    """Every finding with its claims, the summary, and where the page is."""
    console = Console(highlight=False)
    console = console if console.is_terminal else Console(highlight=False, width=120)
    console.print(f"[bold]{escape(study.title)}[/]")
    for finding in study.findings:
        table = Table("statement", "what came out", "outcome", box=None, pad_edge=False, padding=(0, 3, 0, 0))
        table.columns[2].no_wrap = True
        for claim in finding.claims:
            found = escape(claim.found) + (f" [dim]{escape(claim.why)}[/]" if claim.why and not claim.came_out else "")
            table.add_row(escape(claim.states), found, f"[{_COLOURS[outcome(claim)]}]{outcome(claim)}[/]")
        console.print(f"\n[bold]{escape(finding.title)}[/]")
        console.print(table)
    console.print()
    console.print(f"{name}: {summary(study)}")
    console.print(f"report: {page}", soft_wrap=True)

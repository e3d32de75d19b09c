"""The result on the terminal: the table a person looks at first."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from demverify.compare import Check, summary
from demverify.report.content import EngineInfo, Report

if TYPE_CHECKING:
    from demverify.runs import Run

MARK = {"pass": "[green]pass[/]", "fail": "[red]fail[/]", "skipped": "[yellow]skipped[/]", "crashed": "[red]crashed[/]"}


COLUMNS = {
    "force": "force", "torque": "torque", "position": "motion", "velocity": "motion", "omega": "motion", "ke": "energies", "erotate": "energies",
}  # fmt: skip
TIERS = {1: "one state", 2: "200 steps", 3: "long run"}


def print_comparison(report: Report, page: Path) -> None:
    """Engines; for each pair and tier the largest difference of each kind; closed forms; the verdict, and where the report is."""
    console = _console()
    console.print(_engine_table(report.engines))
    console.print()
    console.print("largest difference, relative to the largest value (in brackets: not judged)")
    console.print(_pair_table([check for check in report.checks if check.kind == "engine"]))
    laws = [check for check in report.checks if check.kind == "law"]
    if laws:
        console.print()
        console.print(_law_table(laws))
    console.print()
    _print_first_failure(console, report.checks)
    for reason in dict.fromkeys(c.reason for c in report.checks if (c.outcome, c.quantity) == ("skipped", "all")):
        console.print(f"  {reason}", markup=False)
    console.print(f"verdict: {'[green]pass[/]' if report.verdict == 'pass' else '[red]fail[/]'}. {summary(report.checks)}")
    console.print(f"report: {page}")


def _print_first_failure(console: Console, checks: Sequence[Check]) -> None:
    """What went wrong first, and all that is known of it, a line each."""
    wrong = [check for check in checks if check.outcome in ("fail", "crashed")]
    if wrong:
        first = min(wrong, key=lambda check: (check.outcome != "crashed", check.step, check.tier))
        size = f": {first.max_rel:.1e}, tolerance {first.tolerance:.0e}" if first.max_rel == first.max_rel else ""
        console.print(f"first off: {first.quantity} of {' - '.join(first.engines)} at step {first.step}{size}", markup=False)
        for part in filter(None, re.split(r"; (?=explained by |under the same |not chaos)", first.reason)):
            console.print(f"  {part}", markup=False)
        console.print()


def _console() -> Console:
    """Of the terminal's width; 120 columns where the output goes elsewhere."""
    console = Console(highlight=False, soft_wrap=True)
    return console if console.is_terminal else Console(highlight=False, soft_wrap=True, width=120)


def print_run(run: Run) -> None:
    """What a run that went well did, and where its files are."""
    console, outcome = _console(), run.outcome
    console.print(f"{outcome.engine} {outcome.version}: {outcome.steps} steps of {outcome.n} particles in {outcome.wall_s:.1f} s")
    console.print(f"files: {outcome.folder}", soft_wrap=True)


def print_doctor(rows: Sequence[Mapping[str, str]]) -> None:
    """What is here and what is not."""
    table = Table("what", "status", "version", "detail", "how to get it", box=None, pad_edge=False)
    for row in rows:
        status = f"[green]{row['status']}[/]" if row["status"] == "ok" else f"[red]{row['status']}[/]"
        table.add_row(row["what"], status, row["version"], row["detail"], row["how"])
    _console().print(table)


def _engine_table(engines: Mapping[str, EngineInfo]) -> Table:
    table = Table("engine", "version", "status", "wall [s]", "particle-steps/s", box=None, pad_edge=False)
    for name, info in engines.items():
        wall = f"{info.wall_s:.1f}" if info.wall_s is not None else "-"
        rate = f"{info.particle_steps_per_s:.3g}" if info.particle_steps_per_s is not None else "-"
        status = info.status if not info.reason else f"{info.status}: {info.reason.splitlines()[0]}"
        table.add_row(name, info.version, status, wall, rate)
    return table


def _pair_table(checks: Sequence[Check]) -> Table:
    heads = list(dict.fromkeys(COLUMNS.values()))
    table = Table("engines", "", *heads, "bulk", "outcome", box=None, pad_edge=False)
    rows: dict[tuple[tuple[str, str], int], list[Check]] = {}
    for check in checks:
        rows.setdefault((check.engines, check.tier), []).append(check)
    for (pair, tier), found in rows.items():
        cells = [_cell([c for c in found if COLUMNS.get(c.quantity, "bulk") == head]) for head in (*heads, "bulk")]
        outcomes = [c.outcome for c in found]
        table.add_row(" - ".join(pair), TIERS[tier], *cells, ", ".join(f"{outcomes.count(o)} {MARK[o]}" for o in MARK if o in outcomes))
    return table


def _cell(checks: Sequence[Check]) -> str:
    """The largest difference that was judged; in brackets where all of it was skipped."""
    judged = [c.max_rel for c in checks if c.outcome in ("pass", "fail") and c.max_rel == c.max_rel]
    if judged:
        colour = "red" if any(c.outcome == "fail" for c in checks) else "default"
        return f"[{colour}]{max(judged):.0e}[/]"
    skipped = [c.max_rel for c in checks if c.max_rel == c.max_rel]
    return f"({max(skipped):.0e})" if skipped else "-"


def _law_table(checks: Sequence[Check]) -> Table:
    table = Table("against the closed form", "", "relative error", "tolerance", "outcome", box=None, pad_edge=False)
    for check in checks:
        error = f"{check.max_rel:.1e}" if check.max_rel == check.max_rel else "-"
        table.add_row(check.quantity, check.engines[0], error, f"{check.tolerance:.0e}", MARK[check.outcome])
    return table

"""The result on the terminal: the table a person looks at first."""

from __future__ import annotations

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


def print_comparison(report: Report, page: Path) -> None:
    """Engines, one row for each pair, tier and quantity, the verdict, and where the report is."""
    console = Console(highlight=False)
    console.print(_engine_table(report.engines))
    table = Table(
        "engines",
        "quantity",
        "tier",
        "largest difference",
        "tolerance",
        "checks",
        "outcome",
        box=None,
        pad_edge=False,
        title_justify="left",
    )
    for (pair, kind, tier, quantity), checks in _grouped(report.checks).items():
        worst = _worst(checks)
        size = f"{worst.max_rel:.1e} at step {worst.step}" if worst.max_rel == worst.max_rel else "-"
        tolerance = f"{worst.tolerance:.0e}" if worst.tolerance == worst.tolerance else "-"
        label = "law" if kind == "law" else str(tier)
        table.add_row(" - ".join(pair), quantity, label, size, tolerance, str(len(checks)), MARK[worst.outcome])
    console.print(table)
    for reason in dict.fromkeys(c.reason for c in report.checks if c.outcome in ("fail", "crashed") and c.reason):
        console.print(f"  {reason}", markup=False)
        break
    console.print(f"verdict: {'[green]pass[/]' if report.verdict == 'pass' else '[red]fail[/]'}. {summary(report.checks)}")
    console.print(f"report: {page}", soft_wrap=True)


def print_run(run: Run) -> None:
    """One engine's run and its files."""
    console, outcome = Console(highlight=False), run.outcome
    if outcome.status == "ok":
        console.print(
            f"{outcome.engine} {outcome.version}: {outcome.steps} steps of {outcome.n} particles in {outcome.wall_s:.1f} s"
        )
        console.print(f"files: {outcome.folder}", soft_wrap=True)
    else:
        console.print(f"{outcome.engine} {outcome.status}: {outcome.reason}", markup=False, soft_wrap=True)


def print_doctor(rows: Sequence[Mapping[str, str]]) -> None:
    """What is here and what is not."""
    table = Table("what", "status", "version", "detail", "how to get it", box=None, pad_edge=False)
    for row in rows:
        status = f"[green]{row['status']}[/]" if row["status"] == "ok" else f"[red]{row['status']}[/]"
        table.add_row(row["what"], status, row["version"], row["detail"], row["how"])
    Console(highlight=False).print(table)


def _engine_table(engines: Mapping[str, EngineInfo]) -> Table:
    table = Table("engine", "version", "status", "wall [s]", "particle-steps/s", box=None, pad_edge=False)
    for name, info in engines.items():
        wall = f"{info.wall_s:.1f}" if info.wall_s is not None else "-"
        rate = f"{info.particle_steps_per_s:.3g}" if info.particle_steps_per_s is not None else "-"
        status = info.status if not info.reason else f"{info.status}: {info.reason.splitlines()[0]}"
        table.add_row(name, info.version, status, wall, rate)
    return table


def _grouped(checks: Sequence[Check]) -> dict[tuple[tuple[str, str], str, int, str], list[Check]]:
    groups: dict[tuple[tuple[str, str], str, int, str], list[Check]] = {}
    for check in checks:
        groups.setdefault((check.engines, check.kind, check.tier, check.quantity), []).append(check)
    return groups


def _worst(checks: Sequence[Check]) -> Check:
    """The check that decides a row: a crash, else a failure, else the largest difference that was judged, else what was skipped."""
    for outcome in ("crashed", "fail", "pass", "skipped"):
        chosen = [check for check in checks if check.outcome == outcome]
        if chosen:
            return max(chosen, key=lambda c: c.max_rel if c.max_rel == c.max_rel else -1.0)
    raise ValueError("no checks")

"""The limits of a deck's step, as a table for the terminal and as an object for machines."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from demverify.timestep import NOTES, StepReport

if TYPE_CHECKING:
    from demsolver.stability import ContactLimit

OF_CONTACTS = ("between", "motion", "law", "mass", "stiffness", "damping", "overlap", "at", "spring", "damper", "apart", "combined")


def print_timestep(report: StepReport) -> None:
    """Every limit with what sets it, the contacts they come from, what LIGGGHTS would say, and which limit rules."""
    console = Console(highlight=False, soft_wrap=True, width=None if Console().is_terminal else 240)
    counts = f"{_count(report.particles, 'particle')}, {_count(report.packing.contacts, 'contact')} at the first run"
    console.print(f"{report.deck}: step {report.step:.6g}, {counts}", markup=False)
    console.print()
    console.print(_limits(report))
    console.print()
    console.print(_contacts(report.contacts, report.step))
    console.print()
    for line in (*report.said, *NOTES):
        console.print(line, markup=False)
    console.print()
    console.print(_verdict(report), markup=False)


def as_dict(report: StepReport) -> dict[str, Any]:
    """All of it; null for what is not known and for what limits nothing."""
    return {
        "deck": str(report.deck),
        "step": report.step,
        "particles": report.particles,
        "contacts_now": report.packing.contacts,
        "limits": [
            {"name": r.name, "formula": r.formula, "source": r.source, "value": _finite(r.value), "fraction": _fraction(report.step, r.value),
             "where": r.where, "law": r.law or None, "stability": r.stable, "rules": r is report.ruling and _finite(r.value) is not None}
            for r in report.rows
        ],
        "contacts": [{name: _finite(getattr(limit, name)) for name in OF_CONTACTS} for limit in report.contacts],
        "said": list(report.said),
        "exceeded": report.exceeded or None,
    }  # fmt: skip


def _limits(report: StepReport) -> Table:
    table = Table("limit", "formula", "source", "value", "step/value", "", "of", box=None, pad_edge=False)
    for row in report.rows:
        rules = "rules" if row is report.ruling and _finite(row.value) is not None else ""
        table.add_row(row.name, row.formula, row.source, _number(row.value), _share(report.step, row.value), rules, row.where)
    return table


def _contacts(limits: Sequence[ContactLimit], step: float) -> Table:
    heads = ("contact", "motion", "law", "mass", "stiffness", "damping", "at", "spring", "damper", "both", "step/both")
    table = Table(*heads, box=None, pad_edge=False)
    for c in limits:
        at = c.at if c.overlap is None else f"{c.overlap:.4g}, {c.at}" if c.overlap else c.at
        numbers = (_number(c.spring), _number(c.damper), _number(c.combined), _share(step, c.combined))
        table.add_row(c.between, c.motion, c.law, f"{c.mass:.4g}", f"{c.stiffness:.4g}", f"{c.damping:.4g}", at, *numbers)
    return table


def _verdict(report: StepReport) -> str:
    if report.exceeded:
        return f"too long: {report.exceeded}"
    value = _finite(report.ruling.value)
    if value is None:
        return "nothing limits the step now"
    return f"stable: the step is {_share(report.step, report.ruling.value)} of {value:.6g}, the limit of {report.ruling.what}"


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'s' * (n != 1)}"


def _number(value: float | None) -> str:
    return "absent" if value is None else f"{value:.6g}" if isfinite(value) else "none"


def _share(step: float, value: float | None) -> str:
    share = _fraction(step, value)
    return "-" if share is None else f"{share:.3g}"


def _fraction(step: float, value: float | None) -> float | None:
    return None if value is None or not isfinite(value) else step / value


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value

"""A scene as a page: diagrams of work and precision, orders, the cheapest ways, and what should hold of them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demverify.bench._contenders import Contender, Measure, Problem, Row, measured
from demverify.bench._front import cheapest, front
from demverify.bench._orders import Order, fit_order
from demverify.frames import Floats
from demverify.report.axes import DASH, logarithmic, scientific
from demverify.report.charts import Series, chart
from demverify.studies import Claim, Figure, Finding, Progress, Study, Table

TARGETS = (1e-2, 1e-4, 1e-6)
LARGE = 0.1  # of the unit of the step: what counts as a large step
LEEWAY = 0.2  # of an order: what the phases of the steps leave after a mean over few of them
BY_CHANCE = 5.0  # scatters, known from eight runs: by Student's t one of eighty draws goes beyond in a study of twenty
LOWEST, HIGHEST = 1e-17, 1.0  # errors as they are drawn
SOURCE = "Of this project: closed forms and computed solutions, as each section says; docs/accuracy.md."


@dataclass(frozen=True)
class Judged:
    """A problem with its rows and one of its measures, the k-th."""

    problem: Problem
    rows: Sequence[Row]
    k: int

    @property
    def measure(self) -> Measure:
        """Which."""
        return self.problem.measures[self.k]

    def fronts(self, cost: Sequence[Floats]) -> list[NDArray[np.bool_]]:
        """Row by row, which points are on the front of all. cost: (p,) a row."""
        if not self.rows:
            return []
        on = front(np.concatenate(list(cost)), np.concatenate([row.errors(self.k) for row in self.rows]))
        return np.split(on, np.cumsum([len(one) for one in cost])[:-1])

    def orders(self) -> list[Order | None]:
        """Row by row."""
        return [fit_order(row.steps, row.errors(self.k)) for row in self.rows]


def study_of(name: str, module: ModuleType, quick: bool, progress: Progress) -> Study:
    """Runs all problems of a scene."""
    problems: tuple[Problem, ...] = module.problems(quick)
    told = _Told(progress, sum(len(problem.contenders) + 1 for problem in problems))
    findings: list[Finding] = []
    readings = [*_READINGS, _machine(), *getattr(module, "READINGS", ())]
    for problem in problems:
        rows, absent = measured(problem, told, 2 if quick else 5)
        readings += absent
        findings += [_finding(Judged(problem, rows, k)) for k in range(len(problem.measures))]
    if hasattr(module, "findings"):
        findings += module.findings(quick, progress)
    progress("done", 1.0)
    return Study(f"Work and precision: {module.TITLE}", SOURCE, tuple(findings), tuple(dict.fromkeys(readings)), "theory")


_READINGS = (
    ("Wall time: of the step loop alone, in an engine its own `Loop time`; the median of repeats in which all contenders and steps take turns. "
    "Reading, neighbour lists of the set-up, compilation and the start of a process are in a table of their own."),
    "Each step evaluates all forces once; the discrete gradient sweeps over its contacts until they agree, and its steps count once all the same.",
    ("Orders: slope of log error over log step. Of rows of steps that end with the shortest above a floor of rounding, hold half of all, and "
    "along which a line fits within 40 % (rms), as phases of steps scatter, the one with the narrowest 95 % interval; over all, if none does. As the "
    "row is chosen, its interval holds the order of made-up errors in 91 of 100 cases."),
    ("The native solver runs with its guard on, which is told to go on whatever it finds. A run that ends in no numbers, or off by more than the "
    "whole, has no point."),
)


def _machine() -> str:
    return f"One thread each where nothing else is said, on a machine of {os.cpu_count()} cores; times of other machines differ, errors do not."


class _Told:
    """Counts contenders for `progress`."""

    def __init__(self, progress: Progress, parts: int) -> None:
        self._progress, self._parts, self._done = progress, parts, 0

    def __call__(self, what: str) -> None:
        self._progress(what, 0.95 * self._done / self._parts)
        self._done += 1


def _finding(judged: Judged) -> Finding:
    problem, measure = judged.problem, judged.measure
    orders = judged.orders()
    title = f"{problem.name}: {measure.short}"
    tables = [_cheapest(judged), _orders(judged, orders), *_converged(problem)]
    if judged.k == 0:
        tables.append(_starts(judged))
    set_up = (
        f"Error: {measure.name}. Reference: {problem.reference} Steps of {problem.shares[0]:.2g} to {problem.shares[-1]:.2g} of {problem.unit_name}, "
        f"{scientific(problem.unit)} s; {problem.duration:g} s are simulated."
    )
    return Finding(title, claims_of(judged, orders), set_up, _figures(judged), tuple(tables), _numbers(judged, orders))


def claims_of(judged: Judged, orders: Sequence[Order | None]) -> tuple[Claim, ...]:
    """Orders that theory gives, and that what keeps the energy is worth its cost at large steps."""
    short = judged.measure.short
    claims = [
        _order_claim(row.contender, short, order, judged.problem)
        for row, order in zip(judged.rows, orders, strict=True) if short in row.contender.orders
    ]  # fmt: skip
    if judged.measure.scatter:
        claims += [_scatter_claim(judged, row, *judged.measure.scatter()) for row in judged.rows]
    if judged.measure.energy:
        claims += [_front_claim(judged, row) for row in judged.rows if row.contender.exact]
    return tuple(claims)


def _order_claim(contender: Contender, short: str, order: Order | None, problem: Problem) -> Claim:
    expected = contender.orders[short]
    states = f"{contender.name}: order {expected:g}."
    why = contender.why.get(short, "")
    if order is None:
        return Claim(states, "Too few steps with an error that is small and not yet rounding.", False, why)
    return Claim(states, f"Order {order_text(order)}, over steps of {range_text(order, problem)}.", order.within(expected, LEEWAY), why)


def _scatter_claim(judged: Judged, row: Row, scatter: float, share: float) -> Claim:
    errors = row.errors(judged.k)[row.steps <= share * judged.problem.unit * 1.001]
    unit = judged.problem.unit_name
    states = f"{row.contender.name}: at steps of {share:.2g} of {unit} and less it is off by chance alone, by {BY_CHANCE:g} scatters at most."
    most = float(errors.max()) / scatter
    return Claim(states, f"By {most:.2g} at most, of {100.0 * scatter:.2g} % each.", bool(most <= BY_CHANCE))


def order_text(order: Order) -> str:
    """Value and interval."""
    return f"{order.value:.2f} ± {order.half:.2f}"


def range_text(order: Order, problem: Problem) -> str:
    """The range of the fit, in units."""
    return f"{order.longest / problem.unit:.2g} to {order.shortest / problem.unit:.2g} of {problem.unit_name} ({order.points} steps)"


def _front_claim(judged: Judged, row: Row) -> Claim:
    """Its large steps against all steps of those that do not keep the energy. (Among its own, with errors of rounding, chance decides.)"""
    large = row.steps >= LARGE * judged.problem.unit * 0.999
    others = [one for one in judged.rows if not one.contender.exact]
    cost, error = row.seconds[large], row.errors(judged.k)[large]
    kept = np.array([
        front(np.append(c, [one.seconds for one in others]), np.append(e, [one.errors(judged.k) for one in others]))[0]
        for c, e in zip(cost, error, strict=True)
    ], dtype=bool)  # fmt: skip
    found = "It is at none of them."
    if kept.any():
        best = int(np.flatnonzero(kept)[np.argmin(cost[kept])])
        found = (
            f"It is at {int(kept.sum())} of {len(kept)}; the cheapest has an error of {scientific(error[best])} for {scientific(cost[best])} s a "
            f"simulated "
            f"second, at a step of {row.steps[large][best] / judged.problem.unit:.2g}."
        )
    return Claim(
        f"{row.contender.name}, which keeps the energy by construction, is on the front of error and wall time at steps of {LARGE:g} of "
        f"{judged.problem.unit_name} and more, against those that do not.", found, bool(kept.any()), row.contender.why.get("front", ""),
    )  # fmt: skip


def _figures(judged: Judged) -> tuple[Figure, ...]:
    seconds = [row.seconds for row in judged.rows]
    steps = [1.0 / row.steps for row in judged.rows]
    stem = f"{judged.problem.scene}-{judged.problem.name}-{judged.measure.short}".replace(",", "").replace(" ", "-").lower()
    return (
        Figure(f"{stem}-time", "Error over wall time for a simulated second. A ring: nobody is as good for less time.",
               _picture(judged, seconds, "wall time [s] per simulated second")),
        Figure(f"{stem}-steps", "Error over steps, each an evaluation of all forces. A ring: nobody is as good with fewer steps.",
               _picture(judged, steps, "steps per simulated second")),
    )  # fmt: skip


def _picture(judged: Judged, cost: Sequence[Floats], name: str) -> str:
    rows = [(row, cost_of, on) for row, cost_of, on in zip(judged.rows, cost, judged.fronts(cost), strict=True)]
    series = [_series(row.contender, cost_of, row.errors(judged.k), on) for row, cost_of, on in rows]
    x = np.concatenate([one.x[np.isfinite(one.y)] for one in series] or [np.ones(1)])
    y = np.concatenate([one.y[np.isfinite(one.y)] for one in series] or [np.ones(1)])
    x, y = (known if len(known := part[np.isfinite(part) & (part > 0.0)]) else np.array([0.1, 1.0]) for part in (x, y))
    axes = logarithmic(0.8 * float(x.min()), 1.25 * float(x.max())), logarithmic(0.5 * float(y.min()), 2.0 * float(y.max()))
    told = f"{judged.measure.name} over {name}, {judged.problem.name}, for {', '.join(row.contender.name for row in judged.rows)}"
    return chart(judged.measure.short, told, series, axes, (name, "relative error"))


def _series(contender: Contender, cost: Floats, errors: Floats, on: NDArray[np.bool_]) -> Series:
    shown = np.where(np.isfinite(errors) & (errors <= HIGHEST), np.maximum(errors, LOWEST), np.nan)
    return Series(contender.name, cost, shown, contender.style, "both", on & np.isfinite(shown))


def _cheapest(judged: Judged) -> Table:
    rows = judged.rows
    seconds, errors = (np.concatenate(parts) for parts in ([row.seconds for row in rows], [row.errors(judged.k) for row in rows]))
    owner = [(row, j) for row in rows for j in range(len(row.points))]

    def row_of(target: float) -> tuple[str | float, ...]:
        at = cheapest(seconds, errors, target)
        if at is None:
            return scientific(target), "nobody", DASH, DASH, DASH
        row, j = owner[at]
        return scientific(target), row.contender.name, row.steps[j] / judged.problem.unit, float(seconds[at]), float(errors[at])

    head = ("Error at most", "cheapest", "step", "wall time", "its error")
    title = f"The cheapest way to an error; step in units of {judged.problem.unit_name}, wall time [s] per simulated second"
    return Table(title, head, tuple(row_of(target) for target in TARGETS))


def _orders(judged: Judged, orders: Sequence[Order | None]) -> Table:
    def row_of(row: Row, order: Order | None) -> tuple[str | float, ...]:
        errors = row.errors(judged.k)
        smallest = float(np.min(errors)) if np.isfinite(errors).any() else np.nan
        told = (order_text(order), range_text(order, judged.problem)) if order else (DASH, DASH)
        return row.contender.name, *told, smallest, 1e6 * float(np.nanmedian(row.seconds * row.steps)) if np.isfinite(row.seconds).any() else DASH

    head = ("Contender", "observed order", "over steps of", "smallest error", "a step [µs]")
    return Table("Observed orders", head, tuple(row_of(row, order) for row, order in zip(judged.rows, orders, strict=True)))


def _converged(problem: Problem) -> list[Table]:
    found = problem.convergence()
    return [Table("How well the reference is known, relative", ("computed with", "difference"), found)] if found else []


def _starts(judged: Judged) -> Table:
    def row_of(row: Row) -> tuple[str | float, ...]:
        starts = [point.start for point in row.points if np.isfinite(point.start)]
        spread = [point.spread for point in row.points if np.isfinite(point.spread)]
        compiled = row.compiled if np.isfinite(row.compiled) else DASH
        return row.contender.name, compiled, float(np.median(starts)) if starts else DASH, 100.0 * float(np.median(spread)) if spread else DASH

    head = ("Contender", "first run [s]", "start [s]", "quartiles, ± %")
    title = "Apart from the loop: the first run, which compiles or loads what was compiled; the start of every run; quartiles of times"
    return Table(title, head, tuple(map(row_of, judged.rows)))


def _numbers(judged: Judged, orders: Sequence[Order | None]) -> dict[str, Any]:
    on = judged.fronts([row.seconds for row in judged.rows])
    return {
        row.contender.name: {
            "step": row.steps, "error": row.errors(judged.k), "wall time per simulated second": row.seconds, "front": on_row,
            "spread": [point.spread for point in row.points], "start": [point.start for point in row.points], "first run": row.compiled,
            "order": [order.value, order.half, order.longest, order.shortest] if order else [],
        }
        for row, order, on_row in zip(judged.rows, orders, on, strict=True)
    }  # fmt: skip

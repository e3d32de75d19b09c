"""Figures 6 and 7: the states that contacts pass through, and the modes they lie in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any

import numpy as np

from demverify.report.axes import linear
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Table
from demverify.studies._fujioka_models import MODELS, PAPER, RESTITUTION, STIFFNESS, Model

SHOWN = 8  # contacts
Numbers = Mapping[str, Any]


def mode(s: float, a: float = STIFFNESS) -> int:
    """The paper's mode of a state of slope s = u/d."""
    if s >= 1.0:
        return 1
    if s > 0.0:
        return 2
    return 3 if a <= 1.0 and s >= -sqrt(1.0 - a) else 4


def modes(states: Sequence[Sequence[float]]) -> tuple[int, ...]:
    """The modes that a contact of states (d, u) passes through."""
    return tuple(mode(u / d) for d, u in states)


def portrait_claims(numbers: Numbers) -> tuple[Claim, ...]:
    """What section 5.3 states of figures 6 and 7. numbers: those of figure 5."""
    ways = {name: [modes(states) for states in numbers[name]["states"]] for name in PAPER}
    begun = [way[0] for found in ways.values() for way in found]
    of_p = sorted(set(ways["P"]))
    alone = [(states[0][1] / states[0][0] >= 1.0 / RESTITUTION, len(states) == 1) for states in numbers["F"]["states"]]
    steps = {name: (int(min(numbers[name]["steps"][:SHOWN])), int(max(numbers[name]["steps"][:SHOWN]))) for name in PAPER}
    counted = ", ".join(f"{name} {low} to {high}" if low < high else f"{name} {low}" for name, (low, high) in steps.items())
    vary = {name: high / low for name, (low, high) in steps.items()}
    deepest = {name: float(numbers[name]["deepest"][0]) for name in PAPER}
    return (
        Claim(
            "With C, d exceeds 1 during the contact: the sphere is wholly inside the wall.",
            f"Deepest overlap of the first impact, in diameters: {', '.join(f'{name} {value:.2f}' for name, value in deepest.items())}.",
            deepest["C"] > 1.0 > max(deepest["T"], deepest["F"], deepest["P"]),
        ),
        Claim(
            "The first state of a contact always lies in mode 1.",
            f"{begun.count(1)} of {len(begun)} contacts of all models begin with s ≥ 1.",
            set(begun) == {1},
        ),
        Claim(
            "States of P go from mode 1 to mode 2 and on to mode 4, the last.",
            f"P passes through the modes {' and '.join('-'.join(map(str, way)) for way in of_p)}.",
            of_p == [(1, 2, 4)],
            "A contact that comes to mode 2 with a² + (1 + a) s² ≥ 1 ends there: the hole of the flow chart. One more step at the end, in the "
            "slowest contacts, is gravity's.",
        ),
        Claim(
            "F: a contact that begins beyond the line s = 1/e is over in one step, its state alone.",
            f"{sum(one for _, one in alone)} of {len(alone)} contacts of F take one step; {sum(line == one for line, one in alone)} do as stated.",
            all(line == one for line, one in alone),
            "In the slowest contacts gravity pulls the sphere back before it is off.",
        ),
        Claim(
            "The steps in contact of F vary with how the contact begins; those of the other models vary little in this case.",
            f"Steps of the first {SHOWN} contacts: {counted}.",
            vary["F"] > 2.0 >= max(vary["C"], vary["T"], vary["P"]),
            "F, C and P do as stated. T takes more steps the slower the impact, as any Hertz contact: its duration goes with the power −1/5 of the "
            "speed.",
        ),
    )


def _portrait(numbers: Numbers, models: Sequence[Model], figure: tuple[str, str, str], high: float, rules: Sequence[Rule] = ()) -> Figure:
    """Overlap over approach, a line a contact: the contacts of one model are one series, broken by NaN. figure: name, title, caption."""
    name, title, caption = figure
    series = []
    for model in models:
        rows = [np.vstack([states, [[np.nan, np.nan]]]) for states in numbers[model.name]["states"][:SHOWN]]
        d, u = np.vstack(rows).T
        series.append(Series(model.name, u, d, model.style, "both"))
    label = f"{title}: overlap {', '.join(f'of {one.name} up to {np.nanmax(one.y):.2f}' for one in series)} diameters"
    axes = linear(-0.45, 0.5), linear(0.0, high)
    return Figure(name, caption, chart(title, label, series, axes, ("approach u in a step, over the diameter", "overlap / diameter"), rules))


def portrait_finding(numbers: Numbers) -> Finding:
    """Figures 6 and 7, of the contacts of figure 5."""
    slopes = {"s = 1": 1.0, "s = 0": 0.0, "s = −√(1 − a)": -sqrt(1.0 - STIFFNESS)}
    figures = [_portrait(numbers, MODELS[:4], ("figure-6", "all models", "States during the first eight contacts of each model."), 1.3)]
    for model, high in zip(MODELS[1:4], (0.5, 0.7, 0.7), strict=True):
        lines = slopes | ({"s = 1/e": 1.0 / RESTITUTION} if model.name == "F" else {})
        rules = [Rule(name, np.array([0.0, s * high]), np.array([0.0, high])) for name, s in lines.items()]
        caption = f"States of {model.name}, and the lines that part the modes. States joined by a line belong to one contact."
        figures.append(_portrait(numbers, [model], (f"figure-7-{model.name}", f"model {model.name}", caption), high, rules))
    rows = tuple((name, *(str(len(states)) for states in numbers[name]["states"][:SHOWN])) for name in PAPER)
    return Finding(
        "Figures 6 and 7: states in phase space", portrait_claims(numbers),
        "The contacts of figure 5. d is the overlap, u the approach in a step, s = u/d. A contact begins at the right and ends at the left.",
        tuple(figures), (Table("Steps in contact, impact by impact", ("Model", *(str(k + 1) for k in range(SHOWN))), rows),),
        {name: {"states": numbers[name]["states"][:SHOWN], "steps": numbers[name]["steps"][:SHOWN]} for name in PAPER},
    )  # fmt: skip

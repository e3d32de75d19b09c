"""Figures 4 and 5: energy after over energy before each bounce on a wall, slow and fast."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from demverify.frames import Floats
from demverify.report.axes import linear, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Progress
from demverify.studies._fujioka_bounces import Contact, contacts, crosses_the_plane, dropped, shot
from demverify.studies._fujioka_models import DIAMETER, GRAVITY, MODELS, PAPER, RESTITUTION, Model

STEP = 1e-3
HEIGHT = 0.01 * DIAMETER
SPEED = 1e5
WANTED = RESTITUTION**2
FIRST = 8  # contacts that every model makes before it lies still
Numbers = Mapping[str, Any]


def _record(found: Sequence[Contact]) -> dict[str, Any]:
    return {"ratio": np.array([c.ratio for c in found]), "steps": np.array([c.steps for c in found]), "states": [c.states for c in found]}


def slow_numbers(progress: Progress) -> dict[str, Any]:
    """Every bounce from a drop of 0.01 diameters until the sphere lies still; model -> ratios of energy, steps in contact, states."""
    numbers = {}
    for k, model in enumerate(MODELS):
        progress(f"slow bounces, {model.name}", 0.02 * k)
        numbers[model.name] = _record(list(contacts(dropped(model, HEIGHT, STEP), 100_000)))
    return numbers


def fast_numbers(quick: bool, progress: Progress) -> dict[str, Any]:
    """The same for 1e5 m/s. Under more gravity, ten times and quick a thousand times, for flights of 1e6 and 1e4 steps instead of 1e7."""
    gravity, numbers = GRAVITY * (1000.0 if quick else 10.0), {}
    for k, model in enumerate(MODELS):
        progress(f"fast impacts, {model.name}", 0.1 + 0.06 * k)
        found = list(islice(contacts(shot(model, HEIGHT, SPEED, STEP, gravity), 100_000_000), 15 if quick else 40))
        numbers[model.name] = _record(found) | {"deepest": np.array([c.states[:, 0].max() for c in found])}
        numbers[model.name]["crosses the plane"] = crosses_the_plane(model, HEIGHT, SPEED, STEP)
    return numbers


def off(ratios: Sequence[float] | Floats, many: int | None = None) -> float:
    """Mean distance of the energy ratios of the first contacts from e^2."""
    return float(np.mean(np.abs(np.array(ratios)[:many] - WANTED)))


def _said(numbers: Numbers, many: int | None = None) -> str:
    return ", ".join(f"{name} {scientific(off(numbers[name]['ratio'], many))}" for name in PAPER)


def slow_claims(numbers: Numbers) -> tuple[Claim, ...]:
    """What section 5.2 states of figure 4."""
    distance = {name: off(numbers[name]["ratio"], FIRST) for name in PAPER}
    nearer = [abs(p - WANTED) < abs(f - WANTED) for p, f in zip(*(numbers[name]["ratio"][FIRST:] for name in ("P", "F")), strict=False)]
    p = numbers["P"]["ratio"]
    return (
        Claim(
            "The energy ratios of F and P lie in a narrower band about 0.49 than those of C and T.",
            f"Mean distance from 0.49 over the first {FIRST} bounces: {_said(numbers, FIRST)}.",
            max(distance["F"], distance["P"]) < min(distance["C"], distance["T"]),
        ),
        Claim(
            "After many bounces, when contacts are slow, P is more accurate than F.",
            f"P is nearer to 0.49 in {sum(nearer)} of the {len(nearer)} bounces from number {FIRST + 1} on.",
            sum(nearer) > len(nearer) / 2,
        ),
        Claim(
            "Even very slow contacts are treated accurately by P.",
            f"The ratio of P falls from {p[0]:.3f} at the first bounce to {p[-1]:.3f} at the last, number {len(p)}. Mean distance over all bounces: "
            f"{_said(numbers)}.",
            bool(np.abs(np.array(p) - WANTED).max() < 0.05),
            "The restitution of P is exact for the contact force alone. Gravity acts during the three steps of a contact as well: once g dt is no "
            "longer small beside the impact speed the ratio falls, with every model. P still is the nearest.",
        ),
    )


def fast_claims(numbers: Numbers) -> tuple[Claim, ...]:
    """What section 5.3 states of figure 5."""
    ratios = {name: np.array(numbers[name]["ratio"][:FIRST]) for name in PAPER}
    spread = {name: float(np.ptp(ratio)) for name, ratio in ratios.items()}
    first, second = numbers["C"]["deepest"][:2] if len(numbers["C"]["deepest"]) > 1 else (numbers["C"]["deepest"][0], np.nan)
    crossing = [name for name in PAPER if numbers[name]["crosses the plane"]]
    return (
        Claim(
            "C passes through the wall on the second impact.",
            f"At a half-space C never passes: it goes {first:.2f} diameters deep on the first impact, {second:.2f} on the second, and comes back. "
            f"The native plane, which is felt from both sides, is crossed on the very first impact by {', '.join(crossing) or 'none'}.",
            len(ratios["C"]) == 1,
            "A linear contact knows no scale: slower is less deep. No thickness of the wall lets C through on the second impact and not on the "
            "first; what the paper's program does with a sphere that is wholly inside the wall is not said.",
        ),
        Claim(
            "T goes on after the first impact, but its ratio is not constant.",
            f"Ratios of the first {FIRST} impacts spread over {', '.join(f'{scientific(value)} ({name})' for name, value in spread.items())}.",
            len(ratios["T"]) > 1 and spread["T"] > max(0.1, 10.0 * spread["F"], 10.0 * spread["P"]),
        ),
        Claim(
            "F and P stay near the theoretical ratio.",
            f"Mean distance from 0.49 over the first {FIRST} impacts: {_said(numbers, FIRST)}.",
            max(off(ratios[name]) for name in ("F", "P")) < 0.01,
        ),
    )


def _ratio_figure(name: str, title: str, numbers: Numbers, caption: str, models: Sequence[Model] = MODELS[:4]) -> Figure:
    series = [
        Series(model.name, np.arange(1.0, len(numbers[model.name]["ratio"]) + 1), np.asarray(numbers[model.name]["ratio"]), model.style, "marks")
        for model in models
    ]
    end = max(len(one.x) for one in series) + 1.0
    rule = Rule("e² = 0.49", np.array([0.0, end]), np.array([WANTED, WANTED]))
    label = f"{title}: {'; '.join(f'{one.name} from {one.y[0]:.3f} to {one.y[-1]:.3f}' for one in series)}"
    axes = linear(0.0, end), linear(min(one.y.min() for one in series) - 0.04, max(one.y.max() for one in series) + 0.04)
    return Figure(name, caption, chart(title, label, series, axes, ("number of the impact", "energy after / before"), [rule]))


def slow_finding(numbers: Numbers) -> Finding:
    """Figure 4."""
    caption = "Energy after over energy before each bounce, from a drop of 0.01 diameters until the sphere lies still. P mended lies on P."
    return Finding(
        "Figure 4: slow bounces", slow_claims(numbers),
        f"A sphere of {DIAMETER:g} m falls from {HEIGHT:g} m on the native plane wall, step 10⁻³ s; every bounce until it lies still.",
        (_ratio_figure("figure-4", "slow bounces", numbers, caption),),
        numbers={name: {key: found[key] for key in ("ratio", "steps")} for name, found in numbers.items()},
    )  # fmt: skip


def fast_finding(numbers: Numbers) -> Finding:
    """Figure 5."""
    caption = "Energy after over energy before each impact, the first at 10⁵ m/s, 0.44 diameters a step."
    return Finding(
        "Figure 5: fast impacts", fast_claims(numbers),
        f"The sphere starts {HEIGHT:g} m over the wall with 10⁵ m/s. The wall is a half-space: a frozen sphere ten times as large. Gravity, "
        "which only brings the sphere back, is ten times the paper's (--quick: a thousand), to shorten flights of ten million steps.",
        (_ratio_figure("figure-5", "fast impacts", numbers, caption),),
        numbers={name: {key: value for key, value in found.items() if key != "states"} for name, found in numbers.items()},
    )  # fmt: skip

"""Tables 1 and 2: how often contact forces are evaluated, what that costs, and how many steps a contact takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt
from time import perf_counter
from typing import Any

import numpy as np

from demsolver import Simulation
from demverify.frames import Floats
from demverify.report.axes import scientific
from demverify.studies import Claim, Finding, Progress, Table
from demverify.studies._fujioka_bounces import Contact, contacts, dropped, steps_in_contact
from demverify.studies._fujioka_models import DIAMETER, FROZEN, GRAVITY, MODELS, PAPER, Model, over_floor

SPHERES = 16
HEIGHTS = {"0.01 d": 0.01 * DIAMETER, "1 d": DIAMETER}
DURATION = 50.0  # 5e6 steps of 1e-5 s
ALL = 16 * 5e6  # sphere-steps of the paper's runs
COUNTS = {"C": 1.87e7, "T": 1.26e7, "F": 5.62e6, "P": 1.07e7}  # of the paper's table 1
TOTALS = {"C": 423.0, "T": 341.0, "F": 269.0, "P": 306.0}  # [s]
EACH = {"C": 1.88e-6, "T": 1.91e-6, "F": 1.95e-6, "P": 1.96e-6}  # [s]
STEPS = {"T": (14, 23, 37), "F": (2, 1, 1), "C": (9, 10, 10), "P": (3, 3, 3)}  # of the paper's table 2
DTS = (1e-3, 1e-4, 1e-5)
PHASES = 41
Numbers = Mapping[str, Any]


def cost_numbers(quick: bool, progress: Progress) -> dict[str, Any]:
    """Evaluations, total time [s] and time of one evaluation [s] of each model. quick: steps of 1e-4 s, a tenth as many."""
    dt = 1e-4 if quick else 1e-5
    steps = round(DURATION / dt)
    counts: dict[str, dict[str, int]] = {}
    for k, (said, height) in enumerate(HEIGHTS.items()):
        progress(f"evaluations, drop of {said}", 0.42 + 0.05 * k)
        models = MODELS if said == "1 d" else MODELS[:1]
        counts[said] = {model.name: SPHERES * steps_in_contact(dropped(model, height, dt), steps) for model in models}
    progress("times", 0.55)
    totals = _totals(steps, dt)
    return {"dt": dt, "steps": steps, "evaluations": counts, "total": totals, "each": _each(5 if quick else 15)}


def _totals(steps: int, dt: float, slices: int = 20) -> dict[str, float]:
    """Seconds for the whole run of 16 spheres. The models take turns, so that whatever else the machine does meets all of them."""
    running = {model.name: over_floor(model, np.full(SPHERES, DIAMETER), 0.0, dt) for model in MODELS}
    spent = dict.fromkeys(running, 0.0)
    for _ in range(slices):
        for name, simulation in running.items():
            spent[name] += _time(simulation, steps // slices)
    return spent


def _time(simulation: Simulation, steps: int) -> float:
    start = perf_counter()
    simulation.advance(steps)
    return perf_counter() - start


def _each(rounds: int, spheres: int = 500, steps: int = 1000) -> dict[str, float]:
    """Seconds for one evaluation: spheres held still in the states of the model's own contacts, less the same spheres held above the floor.

    The median over rounds in which the models take turns."""
    held = {model.name: (_held(model, spheres, 0.0), _held(model, spheres, DIAMETER)) for model in MODELS}
    found: dict[str, list[float]] = {name: [] for name in held}
    for _ in range(rounds):
        for name, (touching, apart) in held.items():
            found[name].append((_time(touching, steps) - _time(apart, steps)) / steps / spheres)
    return {name: float(np.median(times)) for name, times in found.items()}


def _held(model: Model, n: int, lift: float, dt: float = 1e-3) -> Simulation:
    """n spheres that no integrator moves, in the states of bounces from 0.01 diameters, lifted by `lift`."""
    states = np.vstack([contact.states for contact in first_contacts(model)])[np.arange(n) % _many(model)] * DIAMETER
    return over_floor(model, lift - states[:, 0], states[:, 1] / dt, dt, moved=FROZEN)


def _many(model: Model) -> int:
    return sum(contact.steps for contact in first_contacts(model))


def first_contacts(model: Model, many: int = 5) -> Sequence[Contact]:
    """The first bounces from a drop of 0.01 diameters at a step of 1e-3 s."""
    found = contacts(dropped(model, HEIGHTS["0.01 d"], 1e-3), 100_000)
    return [contact for contact, _ in zip(found, range(many), strict=False)]


def _falling(values: Mapping[str, float]) -> str:
    return " > ".join(sorted(PAPER, key=lambda name: -values[name]))


def _ratios(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {values[name] / values['C']:.2f}" for name in PAPER)


def cost_claims(numbers: Numbers) -> tuple[Claim, ...]:
    """What section 5.4 states of table 1."""
    whole = SPHERES * numbers["steps"]
    low, high = (numbers["evaluations"][said] for said in HEIGHTS)
    total, each = numbers["total"], numbers["each"]
    share = {name: high[name] * each[name] / total[name] for name in PAPER}
    return (
        Claim(
            "From a drop of 0.01 diameters C takes 1.87 × 10⁷ evaluations, 0.23 of all sphere-steps.",
            f"C touches in {low['C'] / whole:.3f} of all from a drop of 0.01 diameters, in {high['C'] / whole:.3f} from one diameter.",
            abs(low["C"] / whole / (COUNTS["C"] / ALL) - 1.0) < 0.1,
            "From 0.01 diameters the bouncing is over after t0 (1 + e)/(1 − e) = 3.8 of 50 s, t0 = √(2 h/g), and a sphere at rest touches in "
            "every step. From one diameter it takes 38 s, which gives the printed count: the drop was one diameter.",
        ),
        Claim(
            "C takes most evaluations, then T, P and F: 1.87, 1.26, 1.07 and 0.562 times 10⁷.",
            f"{_falling(high)}, from one diameter: {', '.join(f'{name} {scientific(high[name], 3)}' for name in PAPER)}.",
            _falling(high) == "C > T > P > F" and high["F"] < 0.5 * high["C"],
            "Here spheres at rest stay in contact with every model; only the bouncing differs. With F and P that hangs on the integrator: where "
            "gravity is added to the velocity behind the step of the model, and not within it, they never come to rest and touch in 0.20 (F) and "
            "0.38 (P) of the steps. The ratio of these two, 1.9, is that of the printed counts.",
        ),
        Claim(
            "The more evaluations, the longer the run: of the time of C, T takes 0.81, P 0.72, F 0.64.",
            f"{_falling(total)}; of C: {_ratios(total)}.",
            _falling(total) == "C > T > P > F",
            "The counts hardly differ here, and the rest of a step costs the same whether a sphere touches or not.",
        ),
        Claim(
            "Evaluating contact forces takes 6 to 8 % of the run.",
            f"Evaluations times the time of one: {', '.join(f'{name} {100 * value:.0f} %' for name, value in share.items())}.",
            all(0.055 <= value <= 0.085 for value in share.values()),
            "It depends on the program and the machine: one evaluation took the paper's 1.9 µs.",
        ),
        Claim(
            "The more complex the model, the longer one evaluation: C, T, then F and P.",
            f"{', '.join(f'{name} {each[name] * 1e9:.0f} ns' for name in PAPER)}.",
            each["C"] < each["T"] < min(each["F"], each["P"]),
            "The times of this run are too close to each other, or too unsteady.",
        ),
        Claim(
            "One evaluation of P takes only 4 % longer than one of C.",
            f"Times as ratios to C: {_ratios(each)}.",
            each["P"] / each["C"] < 1.1,
            "F and P take more roots, divisions and cases. Where an evaluation takes nanoseconds and not microseconds these are a large part of it.",
        ),
        Claim(
            "F and P differ little in the time of one evaluation.",
            f"P takes {each['P'] / each['F']:.2f} times what F takes.",
            0.8 < each["P"] / each["F"] < 1.25,
            "Both are of the same few operations. What the compiler makes of them, and which of their cases the processor foresees, decides.",
        ),
    )


def _row(values: Mapping[str, float], paper: Mapping[str, float], name: str, unit: float) -> tuple[str | float, ...]:
    """A value, its ratio to C's, and the same ratio of the paper."""
    return values[name] / unit, values[name] / values["C"], paper[name] / paper["C"] if name in paper else ""


def cost_finding(numbers: Numbers) -> Finding:
    """Table 1."""
    counts, times = numbers["evaluations"]["1 d"], (numbers["total"], numbers["each"])
    rows = tuple(
        (m.name, *_row(counts, COUNTS, m.name, 1e6), *_row(times[0], TOTALS, m.name, 1.0), *_row(times[1], EACH, m.name, 1e-9)) for m in MODELS
    )
    head = ("Model", "evaluations [10⁶]", "of C", "paper's", "run [s]", "of C", "paper's", "one evaluation [ns]", "of C", "paper's")
    return Finding(
        "Table 1: cost of 16 spheres", cost_claims(numbers),
        f"4 by 4 spheres that do not meet, {scientific(numbers['steps'])} steps of {scientific(numbers['dt'])} s, falling from one diameter "
        "(see the first statement). Times are of this machine, the models taking turns in one run; only ratios to C say something.",
        tables=(Table("Evaluations and times, as ratios to C with the paper's beside them", head, rows),), numbers=numbers,
    )  # fmt: skip


def steps_numbers(progress: Progress) -> dict[str, Any]:
    """Steps in contact at the first bounce: drop -> model -> for each step size the smallest, mean and largest over the phases of the contact."""
    found: dict[str, Any] = {}
    for k, (said, height) in enumerate(HEIGHTS.items()):
        progress(f"steps in contact, drop of {said}", 0.62 + 0.02 * k)
        found[said] = {model.name: [_steps(model, height, dt) for dt in DTS] for model in MODELS}
    return found


def _steps(model: Model, height: float, dt: float) -> tuple[int, float, int]:
    """The smallest, mean and largest number of steps. Spheres start within a step of the floor, with the speed of the fall."""
    speed = sqrt(2.0 * GRAVITY * height)
    running = over_floor(model, np.linspace(0.001, 0.999, PHASES) * speed * dt, speed, dt)
    touched: Floats = np.zeros(PHASES)
    for _ in range(100):
        running.advance(1)
        touched += running.bodies.x[:, 2] < DIAMETER / 2
    return int(touched.min()), float(touched.mean()), int(touched.max())


def steps_claims(numbers: Numbers) -> tuple[Claim, ...]:
    """What section 5.5 states of table 2."""
    found = numbers["1 d"]
    missed = [
        f"{name} at {scientific(dt)} s" for name in PAPER for dt, printed, (low, _, high) in zip(DTS, STEPS[name], found[name], strict=True)
        if not low <= printed <= high
    ]  # fmt: skip
    change = {name: found[name][-1][1] / found[name][0][1] for name in PAPER}
    most = {name: max(mean for _, mean, _ in found[name]) for name in PAPER}
    return (
        Claim(
            "T takes 14, 23, 37 steps, F 2, 1, 1, C 9, 10, 10 and P 3, 3, 3 at steps of 10⁻³, 10⁻⁴ and 10⁻⁵ s.",
            f"{12 - len(missed)} of the 12 numbers lie within what the phases of the contact give{''.join(f'; not {one}' for one in missed)}.",
            not missed,
        ),
        Claim(
            "With all models but T the number of steps hardly depends on the step size.",
            f"Mean at 10⁻⁵ over mean at 10⁻³ s: {', '.join(f'{name} {value:.2f}' for name, value in change.items())}.",
            change["T"] > 2.0 and max(abs(change[name] - 1.0) for name in ("C", "F", "P")) < 0.1,
        ),
        Claim(
            "F takes the fewest steps.",
            f"Largest of the three means: {', '.join(f'{name} {most[name]:.1f}' for name in PAPER)}.",
            min(PAPER, key=lambda name: most[name]) == "F",
        ),
    )


def steps_finding(numbers: Numbers) -> Finding:
    """Table 2."""
    tables = []
    for said in HEIGHTS:
        rows = tuple(
            (model.name, *(f"{low} to {high}, mean {mean:.1f}" for low, mean, high in numbers[said][model.name]),
             ", ".join(map(str, STEPS[model.name])) if model.name in PAPER else "")
            for model in MODELS
        )  # fmt: skip
        tables.append(Table(f"Steps in contact, impact speed of a drop of {said}", ("Model", *(f"{scientific(dt)} s" for dt in DTS), "paper"), rows))
    return Finding(
        "Table 2: steps in contact", steps_claims(numbers),
        f"The first impact, at {PHASES} phases of the step. Stiffnesses go with dt⁻², else C's numbers would grow tenfold each time. "
        "T's stiffness is read off its first number, for a drop of one diameter; the two others follow. Only T depends on the drop.",
        tables=tuple(tables), numbers=numbers,
    )  # fmt: skip

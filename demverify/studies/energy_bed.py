"""Energy of an elastic bed over many steps: which way of stepping keeps it, and at which step.

200 equal spheres thrown into a walled box under gravity, without friction or damping, so that only the step can change their energy. Four ways:
velocity Verlet and semi-implicit Euler with a linear spring, model P mended (Fujioka & Ushijima 2006, e = 1) under Euler, the discrete gradient.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.report.axes import Axis, decades, linear, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Progress, Study, Table

if TYPE_CHECKING:
    from demsolver import ContactLaw, EnergyBudget, Scene
    from demverify.frames import Floats

TITLE = "Energy of an elastic bed"
SOURCE = "Of this project; the laws are those of S. Fujioka, S. Ushijima (2006), of D. Greenspan, A. Labudde (1974) and of O. Gonzalez (1996)."
KN, RADIUS, DENSITY, SPEED = 1e4, 0.005, 2500.0, 0.2
STEPS = (0.02, 0.1, 0.3, 1.0)  # in contact times
EXACT = 1e-9  # the drift of the total, relative, that an exact way may show: rounding of 1e5 steps, with room
BROKEN = 10.0  # energies beyond so many times the first are no longer followed


@dataclass(frozen=True)
class Way:
    """A way of stepping. law: normal law; euler: the integrator; style: of its line."""

    name: str
    law: str
    euler: bool
    style: int


WAYS = (
    Way("velocity Verlet", "hooke", euler=False, style=0),
    Way("semi-implicit Euler", "hooke", euler=True, style=1),
    Way("P mended", "fujioka2006", euler=True, style=3),
    Way("discrete gradient", "discrete_gradient", euler=False, style=2),
)


@dataclass(frozen=True)
class Course:
    """Energy over one run. steps: (k,) step numbers. change: (k,) of the mechanical energy, over that of the start; NaN once it is lost."""

    way: Way
    step: float
    steps: Floats
    change: Floats

    @property
    def worst(self) -> float:
        """Largest change; infinite where the run broke."""
        return float(np.abs(self.change).max()) if np.isfinite(self.change).all() else float("inf")


def run(quick: bool, progress: Progress) -> Study:
    """100,000 steps of 200 spheres each way; quick: 1,000 steps of 60."""
    count, steps = (60, 1_000) if quick else (200, 100_000)
    told = Told(progress, len(STEPS) * len(WAYS) + len(CASES))
    courses = [follow(way, h, bed(count), steps, told) for h in STEPS for way in WAYS]
    return Study(TITLE, SOURCE, (over_time(courses, count, steps), limits_of_p(told, 200 if quick else 5_000)))


class Told:
    """Counts runs for `progress`."""

    def __init__(self, progress: Progress, runs: int) -> None:
        self._progress, self._runs, self._done = progress, runs, 0

    def __call__(self, what: str) -> None:
        """One run begins."""
        self._progress(what, self._done / self._runs)
        self._done += 1


def over_time(courses: list[Course], count: int, steps: int) -> Finding:
    """The plot, the table, and what an exact way has to show."""
    exact = [one for one in courses if one.way.law == "discrete_gradient"]
    mended = [one for one in courses if one.way.law == "fujioka2006"]
    worst, p_worst = max(one.worst for one in exact), max(one.worst for one in mended)
    claims = (
        Claim(
            f"The discrete gradient shows no drift beyond {scientific(EXACT)} at any of the steps.",
            f"At most {scientific(worst)} of the energy, in {steps:,} steps.", worst < EXACT, whose="ours",
        ),
        Claim(
            f"Model P mended shows no drift beyond {scientific(EXACT)} at any of the steps.", _drift(mended), p_worst < EXACT,
            "It keeps the energy of one straight contact alone: see the next finding for each of the things that a bed has besides.", whose="ours",
        ),
    )  # fmt: skip
    return Finding(
        f"{count} elastic spheres, {steps:,} steps", claims,
        f"Spheres of {2e3 * RADIUS:g} mm with {SPEED} m/s each way in a walled box open above, gravity, spring {KN:g} N/m; steps in units of the "
        "contact time of a pair, pi sqrt(m*/k). The energy is that of motion, gravity and springs, over the first; Euler's velocities belong half a "
        "step before its positions, so its energy swings within a contact. Broken: off by more than ten times the first, or flown apart.",
        (Figure("energy", "Change of the energy over time; one line each way and step.", picture(courses)),),
        (_table(courses),),
        {one.way.name: {f"{c.step:g}": {"steps": c.steps, "change": c.change} for c in courses if c.way is one.way} for one in courses},
    )  # fmt: skip


def _drift(courses: list[Course]) -> str:
    kept = [one.worst for one in courses if np.isfinite(one.worst)]
    broken = ", ".join(f"{one.step:g}" for one in courses if not np.isfinite(one.worst))
    return f"Up to {scientific(max(kept, default=0.0))}{f'; it breaks at {broken} contact times' if broken else ''}."


def _table(courses: list[Course]) -> Table:
    def worst(way: Way, step: float) -> str:
        value = next(one.worst for one in courses if one.way is way and one.step == step)
        return scientific(value) if np.isfinite(value) else "broken"

    rows = tuple((way.name, *(worst(way, step) for step in STEPS)) for way in WAYS)
    return Table("Largest change of the energy, relative; step in contact times", ("way", *(f"step {step:g}" for step in STEPS)), rows)


def picture(courses: list[Course]) -> str:
    """|change| over steps, all ways and steps in one picture."""
    last = max(float(one.steps[-1]) for one in courses)
    axes: tuple[Axis, Axis] = (linear(0.0, last), decades(-16, 2))
    series, named = [], set()
    for one in courses:
        series.append(Series("" if one.way in named else one.way.name, one.steps[1:], np.abs(one.change[1:]), one.way.style))
        named.add(one.way)
    labels = [_label(one, f"{one.step:g}", 1.0) for one in courses if one.way.law == "hooke" and not one.way.euler]
    mended = [one for one in courses if one.way.law == "fujioka2006"]
    labels += [_label(one, f"{one.step:g}", 0.5 + 0.15 * k) for k, one in enumerate(mended)]  # side by side, for the lines are close
    exact = [one for one in courses if one.way.law == "discrete_gradient"]
    labels.append(_label(max(exact, key=lambda one: one.worst), "all four steps", 1.0))
    return chart(
        "energy off by", "Relative change of the energy over steps, for four ways of stepping at four steps each", series, axes,
        ("steps; at the lines: the step in contact times", "relative to the first"), [label for label in labels if label],
    )  # fmt: skip


def _label(one: Course, name: str, share: float) -> Rule | None:
    """A name at a line, at a share of the way to its end, or to where it breaks."""
    known = np.flatnonzero(np.isfinite(one.change[1:])) + 1
    if not len(known):
        return None
    k = known[int(share * (len(known) - 1))]
    return Rule(name, one.steps[[k, k]], np.abs(one.change[[k, k]]))


def follow(way: Way, step: float, scene_of: Callable[[Way], Scene], steps: int, told: Told) -> Course:
    """Runs a scene and looks at its energy a hundred times; a run that breaks has NaN from there on."""
    from demsolver import LostParticles, Simulation, Unstable

    told(f"{way.name}, step {step:g}")
    simulation = Simulation(replace(scene_of(way), timestep=step * contact_time()), budget=True, on_instability="off")
    simulation.setup()
    first, every = simulation.energy_budget(), max(1, steps // 100)
    marks = np.arange(0, steps + 1, every, dtype=float)
    change = np.full(len(marks), np.nan)
    change[0] = 0.0
    for k in range(1, len(marks)):
        try:
            simulation.advance(every)
        except (Unstable, LostParticles):
            break
        change[k] = _change(first, simulation.energy_budget())
        if not abs(change[k]) < BROKEN:
            change[k] = np.nan
            break
    return Course(way, step, marks, change)


def _change(first: EnergyBudget, now: EnergyBudget) -> float:
    return (now.mechanical - first.mechanical) / first.mechanical


def contact_time() -> float:
    """Of a pair: pi sqrt(m*/k)."""
    return pi * sqrt(0.5 * DENSITY * 4.0 / 3.0 * pi * RADIUS**3 / KN)


def law(way: Way, shape: tuple[int, ...]) -> ContactLaw:
    """The way's normal law and nothing else."""
    from demsolver import ContactLaw

    one = np.ones(shape)
    return ContactLaw(way.law, "none", "none", "none", "none", {"kn": KN * one, "restitution": one})


def scene(way: Way, x: Floats, v: Floats, size: tuple[float, float, float], gravity: float) -> Scene:
    """Spheres at x (n, 3) with v (n, 3) between walls at 0 and `size` on all three axes; inf: open."""
    from demsolver import Box, EulerSphere, Gravity, Neighbor, NveSphere, Particles, Scene, Slab, Wall

    n = len(x)
    mass = np.full(n, DENSITY * 4.0 / 3.0 * pi * RADIUS**3)
    p = Particles(np.arange(1, n + 1), np.ones(n, int), x, v, np.zeros((n, 3)), np.full(n, RADIUS), mass, np.ones(n, int), np.zeros((n, 3), int))
    walls = tuple(Wall(f"{'xyz'[a]} walls", Slab(a, 0.0, size[a]), law(way, (1,))) for a in range(3))
    return Scene(
        Box(np.full(3, -100.0), np.full(3, 100.0), ("ff",) * 3), p, 1, 1.0, pair=law(way, (1, 1)), walls=walls,
        forces=(Gravity((0.0, 0.0, -gravity)),), integrate=(EulerSphere(),) if way.euler else (NveSphere(),), neighbor=Neighbor(0.6 * RADIUS),
    )  # fmt: skip


def bed(count: int) -> Callable[[Way], Scene]:
    """`count` spheres near a grid, six by six wide."""
    rng = np.random.default_rng(1)
    pitch = 2.1 * RADIUS
    grid = np.array([(i, j, k) for k in range(1 + count // 36) for j in range(6) for i in range(6)], float)[:count]
    x = (grid + 0.5) * pitch + rng.uniform(-0.02, 0.02, (count, 3)) * RADIUS
    v = rng.normal(0.0, SPEED, (count, 3))
    return lambda way: scene(way, x, v, (6 * pitch, 6 * pitch, np.inf), 9.81)


def lane(gravity: float) -> Callable[[Way], Scene]:
    """One sphere between two walls that it meets straight on."""
    x, v = np.array([[0.02, 0.02, 0.0061]]), np.array([[0.0, 0.0, -SPEED]])
    return lambda way: scene(way, x, v, (0.04, 0.04, 0.0124), gravity)


def lanes_of_pairs(oblique: float) -> Callable[[Way], Scene]:
    """20 pairs far apart that meet once between walls far away; oblique: their offset across, in radii."""
    rng = np.random.default_rng(2)
    middle = np.stack([np.arange(20.0), np.zeros(20), np.zeros(20)], axis=1) * 0.1 + 1.0
    off = np.stack([np.full(20, 1.02 * RADIUS), np.zeros(20), 0.5 * oblique * RADIUS * np.ones(20)], axis=1)
    off[:, 0] = np.sqrt(RADIUS**2 - off[:, 2] ** 2) * (1.0 + 0.05 * rng.uniform(0.1, 1.0, 20))
    x = np.concatenate([middle + off, middle - off])
    v = np.concatenate([np.tile([-SPEED, 0.0, 0.0], (20, 1)), np.tile([SPEED, 0.0, 0.0], (20, 1))])
    return lambda way: scene(way, x, v, (np.inf, np.inf, np.inf), 0.0)


CASES: tuple[tuple[str, Callable[[], Callable[[Way], Scene]], bool], ...] = (
    ("one sphere between two walls", partial(lane, 0.0), True),
    ("the same under gravity", partial(lane, 9.81), False),
    ("pairs that meet straight on", partial(lanes_of_pairs, 0.0), True),
    ("pairs that meet askew", partial(lanes_of_pairs, 1.0), False),
)


def limits_of_p(told: Told, steps: int) -> Finding:
    """What a bed has that one straight contact has not, one at a time, at a tenth of a contact time."""
    mended = WAYS[2]
    found = {name: follow(mended, 0.1, make(), steps, told).worst for name, make, _ in CASES}
    claims = tuple(
        Claim(
            f"Model P mended {'keeps' if exact else 'does not keep'} the energy of {name}.",
            f"Off by {scientific(found[name])} after {steps:,} steps.", (found[name] < EXACT) == exact, whose="ours",
        )
        for name, _, exact in CASES
    )  # fmt: skip
    return Finding(
        "What limits model P mended", claims,
        "The law maps the approach and overlap of one contact to those of the next step. That is exact where nothing else changes them: gravity, a "
        "second contact, or a normal that turns during the contact (two spheres that meet askew) each do. Step: a tenth of a contact time.",
        tables=(Table("Largest change of the energy, relative", ("scene", "change"), tuple((n, scientific(c)) for n, c in found.items())),),
        numbers=found,
    )  # fmt: skip

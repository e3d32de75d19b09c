"""Contenders of a scene: the same deck under different laws, integrators, precisions and engines; their errors, and their times by turns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from demverify.frames import Floats

if TYPE_CHECKING:
    from demsolver import Scene, Simulation
    from demsolver.simulate import Precision
    from demverify.engines.base import Outcome
    from demverify.runs import Run

Told = Callable[[str], object]
LONG_ENOUGH_S = 0.02  # a native run that is shorter is timed as the mean of several


@dataclass(frozen=True)
class State:
    """Positions, velocities and spins (n, 3) at one moment, as the solver gives them."""

    x: Floats
    v: Floats
    omega: Floats


Error = Callable[[Any, Sequence[State]], float]
"""(scene at the start, None where what moves is no scene; states at the moments that are looked at) -> error, relative."""
Solve = Callable[[int], tuple[list[State], float]]
"""So many steps -> states at the moments that are looked at, and the seconds that the steps took."""


@dataclass(frozen=True)
class Measure:
    """One error. name: what it is of. short: for axes. energy: whether it is that of the energy. scatter: () -> by how much it differs from run to
    run by chance, relative, and the longest step, in units, from which on nothing else is expected; None where chance has no part."""

    name: str
    short: str
    error: Error
    energy: bool = False
    scatter: Callable[[], tuple[float, float]] | None = None


@dataclass(frozen=True)
class Contender:
    """One way of solving. style: of its line, 0 to 5. change: what is made of the deck's scene (native only). solve: instead of a scene, where what
    moves is none (native only). words: of the deck's variables, its own. exact: keeps the energy by construction. orders: short name of a measure ->
    the order that theory gives it. why: short name -> why theory does not hold here, where that is known."""

    name: str
    style: int
    engine: Literal["native", "lammps", "liggghts"] = "native"
    change: Callable[[Scene], Scene] = lambda scene: scene
    solve: Solve | None = None
    words: Mapping[str, str] = field(default_factory=dict)
    precision: Precision = "double"
    threads: int = 1
    exact: bool = False
    orders: Mapping[str, float] = field(default_factory=dict)
    why: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Problem:
    """One solution, and who looks for it.

    scene: folder of inputs/bench. name: of the law. variables: of the decks. duration [s] simulated. unit [s]: what steps are stated in;
    unit_name: in
    words. shares: the steps, in units. instants: how many moments are looked at, equally far apart, the last at the end. reference: in words.
    convergence: () -> (computed with, how far from the finest or from each other, relative), of a reference that is itself computed.
    """

    scene: str
    name: str
    variables: Mapping[str, str]
    duration: float
    unit: float
    unit_name: str
    shares: tuple[float, ...]
    measures: tuple[Measure, ...]
    contenders: tuple[Contender, ...]
    reference: str
    convergence: Callable[[], tuple[tuple[str, float], ...]] = tuple
    instants: int = 1

    @cached_property
    def start(self) -> Scene | None:
        """The scene at the start; None where what moves is none."""
        if any(one.solve for one in self.contenders):
            return None
        return scene_of(self, self.steps(self.shares[0]))

    def steps(self, share: float) -> int:
        """Of the whole run, so that every moment falls on one; the step is duration/steps."""
        return self.instants * max(1, round(self.duration / (share * self.unit * self.instants)))

    def deck(self, engine: str) -> Path:
        """The deck that an engine reads; native reads that of LAMMPS."""
        from demverify.library import library

        return library() / "bench" / self.scene / f"in.{'liggghts' if engine == 'liggghts' else 'lammps'}"

    def words(self, steps: int, own: Mapping[str, str] | None = None) -> dict[str, list[str]]:
        """Variables of a run with so many steps. own: of the contender."""
        words = {**self.variables, **(own or {}), "dt": repr(self.duration / steps), "steps": str(steps)}
        return {name: [value] for name, value in words.items()}


@dataclass(frozen=True)
class Point:
    """A contender at one step. step [s]. errors: one a measure, inf where the run broke. seconds: wall time per simulated second, median; spread:
    half
    of the way between the quartiles, over the median. start [s]: what an engine's process took besides its loop."""

    step: float
    steps: int
    errors: tuple[float, ...]
    seconds: float = np.nan
    spread: float = np.nan
    start: float = np.nan


@dataclass(frozen=True)
class Row:
    """A contender at all steps; compiled [s]: what the first run took to compile, or to load what was compiled before."""

    contender: Contender
    points: tuple[Point, ...]
    compiled: float = np.nan

    def errors(self, k: int) -> Floats:
        """(p,) of the k-th measure."""
        return np.array([point.errors[k] for point in self.points])

    @property
    def steps(self) -> Floats:
        """(p,) [s]."""
        return np.array([point.step for point in self.points])

    @property
    def seconds(self) -> Floats:
        """(p,) wall time per simulated second."""
        return np.array([point.seconds for point in self.points])


def scene_of(problem: Problem, steps: int, contender: Contender | None = None) -> Scene:
    """The deck's scene with this many steps, as the contender changes it."""
    from demverify.runs import plan

    scene = plan(problem.deck("native"), problem.words(steps)).runs[0].scene
    return contender.change(scene) if contender else scene


def measured(problem: Problem, told: Told, rounds: int) -> tuple[list[Row], list[str]]:
    """Rows of all contenders that can run, and a line on each that cannot. Errors first, then times, in which contenders and steps take turns."""
    present, absent = _present(problem.contenders)
    rows = []
    for contender in present:
        told(f"{problem.name}: {contender.name}")
        compiled = _warm(problem, contender) if contender.engine == "native" else np.nan
        points = [_errors(problem, contender, share) for share in problem.shares]
        rows.append(Row(contender, tuple(points), compiled))
    told(f"{problem.name}: times")
    return _timed(problem, rows, rounds), absent


def _present(contenders: Sequence[Contender]) -> tuple[list[Contender], list[str]]:
    from demverify.engines import ENGINES
    from demverify.engines.base import Missing

    missing = {name: found for name in ("lammps", "liggghts") if isinstance(found := ENGINES[name].find(), Missing)}
    present = [one for one in contenders if one.engine not in missing]
    return present, [f"{one.name} did not run: {missing[one.engine]}." for one in contenders if one.engine in missing]


def _simulation(problem: Problem, contender: Contender, steps: int) -> Simulation:
    from demsolver import Simulation

    return Simulation(
        scene_of(problem, steps, contender), threads=contender.threads, precision=contender.precision, on_instability="warn", tell=lambda _: None
    )


def _warm(problem: Problem, contender: Contender) -> float:
    """Runs a few hundred steps, so that all is compiled; the seconds that this took."""
    from demsolver import LostParticles, Unstable

    steps, began = problem.steps(problem.shares[-1]), perf_counter()
    if contender.solve:
        contender.solve(problem.steps(problem.shares[0]))
        return perf_counter() - began
    simulation = _simulation(problem, contender, steps)
    try:
        simulation.setup()
        simulation.advance(min(steps, 500))
        simulation.elastic_energy()  # which the guard asks for now and then
    except (Unstable, LostParticles):
        pass
    return perf_counter() - began


def _errors(problem: Problem, contender: Contender, share: float) -> Point:
    steps = problem.steps(share)
    states = (_native_states if contender.engine == "native" else _engine_states)(problem, contender, steps)
    found = tuple(_error(measure, problem.start, states) for measure in problem.measures)
    return Point(problem.duration / steps, steps, found)


def _error(measure: Measure, start: Scene | None, states: Sequence[State] | None) -> float:
    error = measure.error(start, states) if states is not None else np.inf
    return error if np.isfinite(error) else np.inf


def _native_states(problem: Problem, contender: Contender, steps: int) -> list[State] | None:
    """States at the moments that are looked at; None where they became no numbers, or are lost."""
    from demsolver import LostParticles, Unstable

    if contender.solve:
        return contender.solve(steps)[0]
    simulation, states = _simulation(problem, contender, steps), []
    try:
        simulation.setup()
        for _ in range(problem.instants):
            simulation.advance(steps // problem.instants)
            bodies = simulation.bodies
            states.append(State(bodies.x, bodies.v, bodies.omega))
    except (Unstable, LostParticles):
        return None
    return states


def _engine_states(problem: Problem, contender: Contender, steps: int) -> list[State] | None:
    with TemporaryDirectory(prefix="demverify-bench-") as folder:
        run = _run(problem, contender, steps, Path(folder), steps // problem.instants)
        if run.outcome.status != "ok":
            return None
        columns = (("x", "y", "z"), ("vx", "vy", "vz"), ("omegax", "omegay", "omegaz"))
        return [State(*(frame.vectors(*axes) for axes in columns)) for frame in run.frames[1:]]


def _run(problem: Problem, contender: Contender, steps: int, folder: Path, every: int | None) -> Run:
    from demverify.engines.base import Job
    from demverify.runs import execute

    job = Job(problem.deck(contender.engine), folder / "run", problem.words(steps, contender.words), every, timeout_s=600.0)
    return execute(contender.engine, contender.name, job, keep=True)


def _timed(problem: Problem, rows: Sequence[Row], rounds: int) -> list[Row]:
    """The rows with their times. In each round every contender takes each of its steps once; where it broke there is nothing to time."""
    times: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for _ in range(rounds):
        for i, row in enumerate(rows):
            for j, point in enumerate(row.points):
                if np.isfinite(point.errors).any():
                    times.setdefault((i, j), []).append(_time(problem, row.contender, point.steps))
    return [
        replace(row, points=tuple(_with_times(problem, point, times.get((i, j), [])) for j, point in enumerate(row.points)))
        for i, row in enumerate(rows)
    ]  # fmt: skip


def _with_times(problem: Problem, point: Point, found: Sequence[tuple[float, float]]) -> Point:
    if not found:
        return point
    loops = np.array([loop for loop, _ in found]) / problem.duration
    low, high = np.quantile(loops, [0.25, 0.75])
    middle = float(np.median(loops))
    return replace(point, seconds=middle, spread=float(0.5 * (high - low) / middle) if middle else np.nan, start=median(start for _, start in found))


def _time(problem: Problem, contender: Contender, steps: int) -> tuple[float, float]:
    """Seconds of the step loop, and of what came before it: reading the deck and listing neighbours, in an engine also the start of its process."""
    if contender.engine != "native":
        with TemporaryDirectory(prefix="demverify-bench-") as folder:
            outcome = _run(problem, contender, steps, Path(folder), None).outcome
        loop = _loop(outcome)
        return loop, outcome.wall_s - loop
    spent: list[float] = []
    starts: list[float] = []
    while not spent or (sum(spent) < LONG_ENOUGH_S and len(spent) < 5):
        if contender.solve:
            spent.append(contender.solve(steps)[1])
            starts.append(0.0)
            continue
        began = perf_counter()
        simulation = _simulation(problem, contender, steps)
        simulation.setup()
        ready = perf_counter()
        simulation.advance(steps)
        spent.append(perf_counter() - ready)
        starts.append(ready - began)
    return sum(spent) / len(spent), median(starts)


def _loop(outcome: Outcome) -> float:
    """Loop time as the engine's log tells it."""
    rate = outcome.particle_steps_per_s
    return outcome.n * outcome.steps / rate if rate > 0.0 else np.nan

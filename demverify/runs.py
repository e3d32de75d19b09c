"""One run of one engine, and the files every run leaves: trajectory.h5 and thermo.csv, whichever engine made them."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from demverify.compare import TIER2_STEPS
from demverify.deck.dialects import detect_dialect
from demverify.deck.dry import DryBackend, DryRun, NeedsRun
from demverify.deck.interpreter import Interpreter
from demverify.deck.lexer import read_text
from demverify.deck.setup import Dialect, Setup
from demverify.engines import ENGINES
from demverify.engines.base import Job, Outcome, Progress
from demverify.errors import InputError, Place
from demverify.frames import Frame, Thermo

if TYPE_CHECKING:
    from demsolver import EnergyBudget

MOST_FRAMES, MOST_ROWS = 200, 500_000  # kept in memory by one comparison
LEAST_FRAMES = 10


@dataclass(frozen=True)
class Plan:
    """What a deck asks for, found by reading it without running it.

    runs: its `run` commands. whole: False when the deck needs results of its own runs to go on, so that more may follow.
    """

    deck: Path
    dialect: Dialect
    setup: Setup
    runs: Sequence[DryRun]
    interpreter: Interpreter
    whole: bool = True

    @property
    def steps(self) -> int:
        """Steps of all runs."""
        return sum(run.steps for run in self.runs)

    @property
    def particles(self) -> int:
        """Particles at the first run."""
        atoms = self.runs[0].setup.atoms if self.runs else self.setup.atoms
        return atoms.n if atoms else 0


@dataclass(frozen=True)
class Run:
    """An engine's run of a deck. label: how it is called in checks. budgets: (step, time, budget), native runs only."""

    label: str
    dialect: Dialect
    outcome: Outcome
    frames: Sequence[Frame] = ()
    thermo: Thermo | None = None
    budgets: Sequence[tuple[int, float, EnergyBudget]] = field(default=())


def native_label(dialect: Dialect, dialects: Collection[Dialect]) -> str:
    """What a native run is called: native, and native-liggghts where a case has decks of both dialects."""
    return "native" if dialect == "lammps" or "lammps" not in dialects else f"native-{dialect}"


def engine_of(label: str) -> str:
    """The engine of a run's label: `native-liggghts` is native."""
    return "native" if label.startswith("native") else label


class _Checking(DryBackend):
    """Also builds the scene of a run and looks at what it would write, with the variables as they are at that run."""

    def run(self, setup: Setup, steps: int) -> None:
        """Notes the run. Raises InputError."""
        from demverify.engines._outputs import check_outputs

        check_outputs(setup)
        super().run(setup, steps)
        self.runs[-1].scene  # noqa: B018  (building it checks it)

    def value(self, setup: Setup, keyword: str) -> float:
        """As DryBackend; NeedsRun only for what a run of the native engine will know."""
        from demverify.engines._outputs import check_keyword

        try:
            return super().value(setup, keyword)
        except NeedsRun:
            check_keyword(setup, keyword)
            raise


def plan(deck: Path, variables: Mapping[str, Sequence[str]]) -> Plan:
    """Reads a deck and checks it whole, scenes of its runs included. Raises InputError for a deck that is wrong or not supported."""
    if not deck.is_file():
        message = f"{deck} is a folder, expected a deck" if deck.is_dir() else f"there is no deck {deck}"
        raise InputError(message)
    dialect, backend, whole = detect_dialect(deck), _Checking(), True
    interpreter = Interpreter(dialect, variables, backend)
    try:
        interpreter.run_deck(deck)
    except NeedsRun:
        if not backend.runs:
            raise
        whole = False
    if not backend.runs:
        message = "the deck has no run command, so nothing would happen"
        raise InputError(message, Place(deck))
    return Plan(deck, dialect, interpreter.setup, backend.runs, interpreter, whole)


def frame_interval(steps: int, particles: int) -> int:
    """Steps between frames of a comparison: at most 200 frames and 500,000 rows, at least 5 frames, the last step among them if any
    such interval divides the steps. Longer runs get more frames, up to 1,000 and 2,000,000 rows, so that some fall within tier 2."""
    frames = min(MOST_FRAMES, max(LEAST_FRAMES, MOST_ROWS // max(1, particles)))
    least = max(1, -(-steps // frames))
    if least > TIER2_STEPS and steps <= 1000 * TIER2_STEPS and steps // TIER2_STEPS * particles <= 4 * MOST_ROWS:
        return next((every for every in range(TIER2_STEPS, TIER2_STEPS // 2, -1) if steps % every == 0), TIER2_STEPS)
    return next((every for every in range(least, 2 * least + 1) if steps % every == 0), least)


def output_interval(deck: Path, variables: Mapping[str, Sequence[str]], engine: str) -> int:
    """Steps between frames of trajectory.h5 in a plain run: those of the deck's first dump, else of its thermo, else of its runs.

    Raises InputError for a deck that the native engine is to run and cannot: before anything is written."""
    try:
        known = plan(deck, variables)
    except InputError:
        if engine == "native":
            raise
        found = re.search(r"^\s*thermo\s+(\d+)", read_text(deck), re.MULTILINE)
        return max(1, int(found[1])) if found else 1000
    setup = known.runs[-1].setup
    rhythms = [dump.every for dump in setup.dumps.values()] + [setup.thermo.every, known.steps]
    return next((every for every in rhythms if every > 0), 1)


def execute(engine: str, label: str, job: Job, progress: Progress | None = None, *, keep: bool = False, **settings: Any) -> Run:
    """Runs a deck in an engine and leaves trajectory.h5 and thermo.csv in its folder. keep: keep the frames in memory.

    settings: of the native engine only (budget, nudge). Raises InputError.
    """
    dialect = detect_dialect(job.deck)
    if engine == "native":
        from demverify.engines.native import ENGINE

        outcome, outputs = ENGINE.run_with(job, progress, keep=keep, **settings)
        return Run(label, dialect, outcome, outputs.frames, _thermo(outcome), outputs.budgets)
    outcome = ENGINES[engine].run(job, progress)
    frames, trajectory = _convert(outcome, keep=keep)
    run = Run(label, dialect, replace(outcome, trajectory=trajectory), frames, _thermo(outcome))
    if run.thermo is not None:
        from demverify.formats.thermo import write_thermo_csv

        write_thermo_csv(job.folder / "thermo.csv", run.thermo)
    return run


def _convert(outcome: Outcome, *, keep: bool) -> tuple[list[Frame], Path | None]:
    """The engine's own frames as trajectory.h5; the raw dump goes."""
    from demverify.formats.dump import read_dump
    from demverify.formats.h5md import TrajectoryWriter
    from demverify.formats.reading import Reading

    if outcome.trajectory is None or not outcome.trajectory.is_file():
        return [], None
    frames, path, dt = [], outcome.folder / "trajectory.h5", _timestep(outcome)
    reading = Reading(columns=outcome.columns and tuple(outcome.columns), half_written=None if outcome.status == "ok" else bool)
    with TrajectoryWriter(path) as writer:
        for frame in read_dump([outcome.trajectory], reading):
            writer.write(frame, frame.step * dt)
            if keep:
                frames.append(frame)
    outcome.trajectory.unlink()
    return frames, path


def _timestep(outcome: Outcome) -> float:
    """The time step as the engine's own log tells it; 1 when it does not."""
    log = outcome.log.read_text(errors="replace") if outcome.log and outcome.log.is_file() else ""
    found = re.findall(r"(?:Time step\s*:|^timestep)\s*([-+0-9.eE]+)", log, re.MULTILINE)
    return float(found[-1]) if found else 1.0


def _thermo(outcome: Outcome) -> Thermo | None:
    from demverify.formats.log import merge_runs, read_thermo

    if outcome.thermo_log is None or not outcome.thermo_log.is_file():
        return None
    try:
        tables = read_thermo(outcome.thermo_log)
    except InputError:  # it died before its first run
        return None
    try:
        return merge_runs(tables)
    except InputError:  # the columns changed
        return tables[-1]

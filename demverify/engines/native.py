"""The native engine: reads the deck itself and runs it in demsolver, leaving the files LAMMPS or LIGGGHTS would."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from demverify.engines._native_run import TRAJECTORY, OpenDump, Run, normalised
from demverify.engines.base import Found, Job, Missing, Outcome, Progress
from demverify.errors import InputError

if TYPE_CHECKING:
    from demsolver import EnergyBudget, Scene, Simulation, Sleep
    from demsolver.guard import OnInstability
    from demsolver.memories import Memories
    from demverify.deck.restart import Restart
    from demverify.deck.setup import Setup
    from demverify.frames import Frame

PATIENCE_S = 0.5  # between two signs of life


@dataclass
class Outputs:
    """What a native run leaves in its folder, and keeps for the caller: the frames of the trajectory file and the energy budgets."""

    frames: list[Frame] = field(default_factory=list)
    budgets: list[tuple[int, float, EnergyBudget]] = field(default_factory=list)
    steps: int = 0
    particle_steps: int = 0
    loop_s: float = 0.0


class NativeBackend:
    """Runs what the interpreter hands over.

    nudge: moves the positions of the first run, for the chaos envelope. rules: changes the scene of every run. most: stop after so many
    steps. keep: keep frames in memory. budget: keep the energy account. unstable: told, in one line, of a step above a stability limit.
    on_instability: as Simulation has it; what "warn" says goes to log.native and to `warn`.
    modes: `precision` of Simulation, and `sleep`, a speed or None.
    """

    def __init__(
        self,
        folder: Path,
        *,
        every: int | None,
        threads: int = 1,
        budget: bool = False,
        nudge: Callable[[Any], Any] | None = None,
        rules: Callable[[Scene], Scene] | None = None,
        most: int | None = None,
        keep: bool = False,
        progress: Progress | None = None,
        unstable: Callable[[str], object] | None = None,
        on_instability: OnInstability = "stop",
        warn: Callable[[str], object] | None = None,
        modes: Mapping[str, Any] | None = None,
    ) -> None:
        from demsolver.stability_watch import StepWatch
        from demverify.engines._checks import StepChecks
        from demverify.engines._restarts import RestartFiles

        self.outputs = Outputs()
        self.printed: Sequence[str] = ()  # by the deck; the caller hands over the interpreter's list, which grows
        self._said = 0
        self._nudged = False
        self._restarts = RestartFiles(folder)
        self._folder, self._every, self._threads, self._budget = folder, every, threads, budget
        self._nudge, self._keep, self._progress = nudge, keep, progress
        self._rules, self._most, self._modes = rules, most, dict(modes or {})
        self._simulation: Simulation | None = None
        self._setup: Setup | None = None
        self._files = ExitStack()
        self._dumps: dict[str, OpenDump] = {}
        self._log: Any = None
        self._thermo: list[tuple[tuple[str, ...], list[list[float]]]] = []
        self._checks = StepChecks()
        self._watch = StepWatch(unstable) if unstable else None
        self._on_instability: OnInstability = on_instability
        self._warn = warn
        self._trajectory: Any = None
        self._last_frame = -1

    def __enter__(self) -> Self:
        """Nothing is written before there are first values: a deck that is wrong leaves no file."""
        return self

    def __exit__(self, *error: object) -> None:
        """Closes every file; what was written stays readable."""
        from demverify.formats.thermo import write_thermo_csv
        from demverify.frames import Thermo

        try:
            if filled := [table for table in self._thermo if table[1]]:
                titles, rows = filled[-1]
                write_thermo_csv(self._folder / "thermo.csv", Thermo(titles, np.array(rows, dtype=float).reshape(-1, len(titles))))
        finally:
            self._files.__exit__(*error)  # type: ignore[arg-type]

    def say(self, text: str) -> None:
        """Writes to log.native: what the deck prints, and the thermo tables."""
        if self._log is None:
            self._open()
        for line in self.printed[self._said :]:
            self._log.write(f"{line}\n")
        self._said = len(self.printed)
        self._log.write(text)

    def _tell(self, line: str) -> None:
        self.say(f"WARNING: {line}\n")
        if self._warn:
            self._warn(line)

    def save_last_good(self) -> str:
        """Writes the last state in which all was well, for a run that has gone wrong. Returns what to tell of it."""
        from demverify.engines._last_good import save_last_good

        return save_last_good(self._folder, self._setup, self._simulation) if self._setup and self._simulation else ""

    def _open(self) -> None:
        from demverify.formats.atomic import atomic_write
        from demverify.formats.h5md import TrajectoryWriter

        self._folder.mkdir(parents=True, exist_ok=True)
        part = self._files.enter_context(atomic_write(self._folder / "log.native", keep=True))
        self._log = self._files.enter_context(part.open("w", buffering=1, encoding="utf-8"))
        self._trajectory = self._files.enter_context(TrajectoryWriter(self._folder / "trajectory.h5"))

    def run(self, setup: Setup, steps: int) -> None:
        """One `run` command."""
        steps = steps if self._most is None else min(steps, self._most - self.outputs.steps)
        simulation, self._setup = self._prepare(setup), setup
        run = Run(self, setup, simulation, steps)
        simulation.setup()  # compiles the loop too, the first time
        if self._watch:
            self._watch.look(simulation)
        began = perf_counter()
        run.output()
        while simulation.step < run.end:
            self._advance(simulation, run)
            run.output()
        simulation.look()
        self.outputs.loop_s += perf_counter() - began
        self.outputs.steps += steps
        self.outputs.particle_steps += steps * len(simulation.id)
        if self.outputs.steps == self._most:
            from demverify.deck.interpreter import Quit

            raise Quit

    def value(self, setup: Setup, keyword: str) -> float:
        """A value for a formula: from the running simulation, else from the state of the deck."""
        from demverify.deck.state_values import state_value
        from demverify.engines._thermo import Meter

        if (known := state_value(setup, keyword)) is not None:
            return known
        if self._simulation is None:
            message = f"the formula needs {keyword}, which only a run gives"
            raise InputError(message)
        return Meter(setup, self._simulation, self._simulation.step, 0.0, self._checks).value(keyword, normalise=normalised(setup))

    def memories(self, setup: Setup) -> Memories | None:
        """Of the running simulation; before a run those of a file, which no run has taken up yet."""
        return setup.memories if self._simulation is None else self._simulation.memories()

    def keep(self, state: Restart, name: str) -> None:
        """Writes a restart file into the folder of the run. Raises InputError for a name that leads out of it or is taken by an output."""
        self._restarts.keep(state, name)

    def kept(self, name: str, folder: Path) -> Restart:
        """What this run wrote, else what stands beside the deck. Raises InputError."""
        return self._restarts.kept(name, folder)

    def cleared(self) -> None:
        """The next run starts a simulation of its own, and shows its first state as a run of its own would."""
        self._simulation, self._checks, self._last_frame = None, type(self._checks)(), -1

    def _prepare(self, setup: Setup) -> Simulation:
        from demsolver import Simulation
        from demverify.deck.scene_builder import scene_of
        from demverify.engines._outputs import keywords_of
        from demverify.engines._restarts import recalled

        scene = scene_of(setup)
        scene = self._rules(scene) if self._rules else scene
        virial = "press" in keywords_of(setup)
        sleep = self._sleep(scene, virial=virial)
        if self._simulation is None:
            if self._nudge is not None and not self._nudged:
                scene.particles.x[:] = self._nudge(scene.particles.x)
                self._nudged = True
            precision = self._modes.get("precision", "double")
            self._simulation = Simulation(
                scene, threads=self._threads, budget=self._budget, virial=virial, precision=precision, sleep=sleep,
                on_instability=self._on_instability, tell=self._tell,
            )  # fmt: skip
        else:
            self._simulation = self._simulation.continue_with(scene, virial=virial)
        if notes := recalled(self._simulation, setup):
            self.say(notes)
        self._simulation.step = setup.step
        return self._simulation

    def _sleep(self, scene: Scene, *, virial: bool) -> Sleep | None:
        """What --sleep asks for. Raises InputError where a scene cannot have it."""
        from demsolver import Sleep
        from demsolver.sleep import check_sleep

        if (speed := self._modes.get("sleep")) is None:
            return None
        try:
            check_sleep(Sleep(speed), scene, books=self._budget or virial)
        except ValueError as error:
            message = f"--sleep {speed:g}: {error}"
            raise InputError(message) from error
        return Sleep(speed)

    def _advance(self, simulation: Simulation, run: Run) -> None:
        """To the next output, in portions short enough to show progress."""
        goal = run.next_output()
        while simulation.step < goal:
            began, steps = perf_counter(), min(run.portion, goal - simulation.step)
            simulation.advance(steps)
            spent = perf_counter() - began
            run.portion = max(1, run.portion if steps < run.portion and spent < PATIENCE_S else int(steps * min(8.0, PATIENCE_S / max(spent, 1e-6))))
            if self._progress:
                self._progress(simulation.step - run.start, run.steps)


class Native:
    """The engine that is always there."""

    name = "native"

    def find(self) -> Found | Missing:
        """Our own version and folder."""
        from importlib.metadata import version

        import demsolver

        return Found(version("demverify"), Path(demsolver.__file__).parent)

    def run(self, job: Job, progress: Progress | None = None) -> Outcome:
        """Runs the deck. Raises InputError for a deck that is wrong or not supported."""
        return self.run_with(job, progress)[0]

    def run_with(self, job: Job, progress: Progress | None = None, **settings: Any) -> tuple[Outcome, Outputs]:
        """Runs the deck; also returns the frames and budgets that NativeBackend was asked to keep by `settings`."""
        from demsolver import LostParticles, Unstable
        from demverify.deck.dialects import detect_dialect
        from demverify.deck.interpreter import Interpreter

        began, reason = perf_counter(), ""
        backend = NativeBackend(job.folder, every=job.every, threads=job.threads, progress=progress, **settings)
        with backend:
            try:
                interpreter = Interpreter(detect_dialect(job.deck), job.variables, backend)
                backend.printed = interpreter.printed
                interpreter.run_deck(job.deck)
                backend.say("")
            except (LostParticles, Unstable) as error:
                reason = str(error) + backend.save_last_good()
        out, found = backend.outputs, self.find()
        rate = out.particle_steps / out.loop_s if out.loop_s > 0 else 0.0
        n = len(backend._simulation.id) if backend._simulation else 0
        log = job.folder / "log.native"
        outcome = Outcome(
            self.name, "crashed" if reason else "ok", reason, found.version if isinstance(found, Found) else "", perf_counter() - began,
            out.steps, n, rate, job.folder, log, job.folder / "trajectory.h5", tuple(TRAJECTORY), log,
        )  # fmt: skip
        return outcome, out


ENGINE = Native()

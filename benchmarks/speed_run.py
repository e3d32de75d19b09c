"""What `speed.py` measures and how it judges: one run of one engine in a process of its own, and the comparison that lets its figure stand.

Called as a program, it is such a process for the native engine: a job in JSON on its command line, what came of it in JSON on stdout.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from benchmarks.read_speed import busy, wait_for_quiet
from benchmarks.speed_scenes import Scene
from demverify.chaos import Envelope, nudge
from demverify.compare import Check, Tolerances, compare_scalars, compare_series, not_judged, summary, verdict
from demverify.differences import REST
from demverify.engines import ENGINES
from demverify.engines.base import Job
from demverify.frames import Thermo
from demverify.runs import Run, execute

SAME_BITS = Tolerances(0.0, 0.0, 0.0, chaos_factor=0.0, bulk_factor=0.0)
PROGRAMS = ("lmp", "liggghts")
POLL_S = 0.02


@dataclass(frozen=True)
class Contender:
    """Who runs what. deck: a name of `Scene.write`. twin: label of the native contender that runs the same deck with the same rules: they
    are compared, and their rates make the ratio."""

    label: str
    engine: str
    deck: str
    twin: str = "native"
    ranks: int = 1
    threads: int = 1

    def job(self, paths: Mapping[str, Path], folder: Path, scene: Scene, every: int | None = None) -> Job:
        """A run of this contender."""
        variables = {"steps": [f"{scene.steps}"], "rows": [f"{scene.steps // 4}"]}
        return Job(paths[self.deck], folder, variables, every, 600.0, self.ranks, self.threads)


STANDARD = (
    Contender("native", "native", "lammps"),
    Contender("LAMMPS", "lammps", "lammps"),
    Contender("native, 2 threads", "native", "lammps", threads=2),
    Contender("LAMMPS, 2 ranks", "lammps", "lammps", ranks=2),
    Contender("LAMMPS, omp, 1 thread", "lammps", "lammps-omp1"),
    Contender("LAMMPS, omp, 2 threads", "lammps", "lammps-omp2"),
    Contender("native, LIGGGHTS' rules", "native", "liggghts", "native, LIGGGHTS' rules"),
    Contender("LIGGGHTS", "liggghts", "liggghts", "native, LIGGGHTS' rules"),
)
FRICTION = (
    Contender("native, with friction", "native", "lammps-friction", "native, with friction"),
    Contender("LAMMPS, with friction", "lammps", "lammps-friction", "native, with friction"),
    Contender("native, friction and a field of 0", "native", "lammps-friction-field", "native, with friction"),
)
"""The field does nothing, but for it every particle is looked at in every step: kicked and turned too."""


def contenders_of(scene: Scene) -> tuple[Contender, ...]:
    """All that run in a scene."""
    return STANDARD + (FRICTION if "lammps-friction" in scene.decks else ())


@dataclass(frozen=True)
class Sample:
    """One timed run. loop_s: as the engine prints it. start_s: all else of the process' life. peak_mb: the most memory it held, of all its
    ranks together. others: cores that other programs used meanwhile. thermo: what it printed."""

    rate: float
    loop_s: float
    start_s: float
    peak_mb: float
    others: float
    thermo: Thermo


class EngineFailed(Exception):
    """An engine is missing, crashed or ran out of time: why, in words."""


def measure(contender: Contender, job: Job, patience: float = 0.0) -> Sample:
    """Runs a contender once, after waiting up to so many seconds for others to be quiet. Raises EngineFailed."""
    wait_for_quiet(patience)
    run = _native if contender.engine == "native" else _program
    before, own, began = busy(), _own_seconds(), time.perf_counter()
    rate, loop_s, peak_mb, thermo = run(contender, job)
    wall = time.perf_counter() - began
    others = max(0.0, (busy() - before - (_own_seconds() - own)) / wall)
    return Sample(rate, loop_s, wall - loop_s, peak_mb, others, thermo)


def _own_seconds() -> float:
    """Processor time of this process and of the children it has waited for."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


def _program(contender: Contender, job: Job) -> tuple[float, float, float, Thermo]:
    with PeakMemory() as peak:
        run = execute(contender.engine, contender.label, job)
    return (*_figures(run), peak.mb, _rows(run))


def _native(contender: Contender, job: Job) -> tuple[float, float, float, Thermo]:
    words = {"deck": f"{job.deck}", "folder": f"{job.folder}", "variables": job.variables, "threads": job.threads}
    try:
        done = subprocess.run([sys.executable, __file__, json.dumps(words)], capture_output=True, text=True, check=False, timeout=job.timeout_s)
    except subprocess.TimeoutExpired as error:
        raise EngineFailed(f"{contender.label}: stopped at its time limit of {job.timeout_s:g} s") from error
    if done.returncode:
        raise EngineFailed(f"{contender.label}: {(done.stderr.strip().splitlines() or ['killed'])[-1]}")
    found = json.loads(done.stdout.splitlines()[-1])
    return found["rate"], found["loop_s"], found["peak_mb"], Thermo(tuple(found["columns"]), np.array(found["rows"]))


def child(words: Mapping[str, Any]) -> dict[str, Any]:
    """The native engine's run, in the process that is measured."""
    job = Job(Path(words["deck"]), Path(words["folder"]), words["variables"], threads=words["threads"])
    run = execute("native", "native", job)
    rate, loop_s = _figures(run)
    thermo = _rows(run)
    return {"rate": rate, "loop_s": loop_s, "peak_mb": high_water_mb(os.getpid()), "columns": thermo.columns, "rows": thermo.values.tolist()}


def _figures(run: Run) -> tuple[float, float]:
    """Particle steps per second, and the loop time behind them."""
    found = run.outcome
    if found.status != "ok":
        raise EngineFailed(f"{run.label} {found.status}: {found.reason.splitlines()[0] if found.reason else ''}")
    if not found.particle_steps_per_s:
        raise EngineFailed(f"{run.label} printed no loop time")
    return found.particle_steps_per_s, found.n * found.steps / found.particle_steps_per_s


def _rows(run: Run) -> Thermo:
    if run.thermo is None:
        raise EngineFailed(f"{run.label} printed no thermo table")
    return run.thermo


class PeakMemory:
    """The largest memory of the engine processes under this one, looked at every 20 ms (VmHWM of Linux, which is the largest since their start)."""

    def __init__(self) -> None:
        self._found: dict[int, float] = {}
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._end.set()
        self._thread.join()

    @property
    def mb(self) -> float:
        """All ranks together."""
        return sum(self._found.values())

    def _watch(self) -> None:
        while not self._end.wait(POLL_S):
            for pid in descendants(os.getpid()):
                if _text(f"/proc/{pid}/comm").strip() in PROGRAMS:
                    self._found[pid] = max(self._found.get(pid, 0.0), high_water_mb(pid))


def descendants(pid: int) -> Iterator[int]:
    """Processes under a process; any may be gone by the time it is looked at."""
    try:
        tasks = list(Path(f"/proc/{pid}/task").iterdir())
    except OSError:
        return
    for task in tasks:
        for child_pid in map(int, _text(f"{task}/children").split()):
            yield child_pid
            yield from descendants(child_pid)


def high_water_mb(pid: int) -> float:
    """The most memory that a process has held so far; 0 where the system does not tell."""
    lines = (line.split() for line in _text(f"/proc/{pid}/status").splitlines())
    return next((int(words[1]) / 1024 for words in lines if words[:1] == ["VmHWM:"]), 0.0)


def _text(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError:
        return ""


@dataclass(frozen=True)
class Judge:
    """What the runs of a deck are held against: a native run with frames, and how far the same run parts when it starts one ulp away."""

    native: Run
    envelope: Envelope

    def of_frames(self, run: Run) -> list[Check]:
        """Every particle at every frame, energies, and what was printed."""
        engines = self.native.label, run.label
        if run.outcome.status != "ok":
            return [not_judged("all", engines, "skipped" if run.outcome.status == "skipped" else "crashed", run.outcome.reason)]
        return compare_series(self.native.frames, run.frames, engines, self.envelope, _limits(run.outcome.engine))

    def of_thermo(self, label: str, engine: str, thermo: Thermo, columns: Mapping[str, str]) -> list[Check]:
        """What a timed run printed."""
        assert self.native.thermo is not None
        printed = self.native.thermo.columns  # LIGGGHTS prints the bare name of a compute
        names = {name: column if column in printed else column.removeprefix("c_") for name, column in columns.items()}
        rest = REST * float(self.native.thermo[names["ke"]].max())
        pairs = {name: (column, column) for name, column in names.items()}
        floors = {"ke": rest, "erotate": rest}
        return compare_scalars(self.native.thermo, thermo, (self.native.label, label), pairs, floors, self.envelope, _limits(engine))


def _limits(engine: str) -> Tolerances:
    """Of native against native: bit for bit, whatever the number of threads."""
    return SAME_BITS if engine == "native" else Tolerances()


def judge_of(contender: Contender, scene: Scene, paths: Mapping[str, Path], folder: Path) -> Judge:
    """The judge of all whose twin this native contender is. Raises EngineFailed."""
    job = contender.job(paths, folder, scene, scene.every)
    run, nudged = (execute("native", contender.label, job, keep=True, nudge=how) for how in (None, nudge))
    _figures(run)
    _figures(nudged)
    return Judge(run, Envelope.from_frames(run.frames, nudged.frames))


def compared(contender: Contender, scene: Scene, paths: Mapping[str, Path], folder: Path, judge: Judge) -> list[Check]:
    """A run with frames against the judge's, over all the steps that are timed. A judge is not held against itself."""
    if contender.label == contender.twin:
        return []
    run = execute(contender.engine, contender.label, contender.job(paths, folder, scene, scene.every), keep=True)
    return judge.of_frames(run)


def trouble(checks: Sequence[Check]) -> str:
    """Why a figure must not be printed: the first check that failed. Empty when all is well."""
    if not checks or verdict(checks) == "pass":
        return ""
    first = next((check for check in checks if check.outcome in ("fail", "crashed")), checks[0])
    if first.outcome != "fail":
        return first.reason or summary(checks)
    size = f"{first.max_rel:.1e} at step {first.step}, limit {first.tolerance:.0e}"
    return f"{first.quantity} differs from that of {first.engines[0]} by {size} ({first.reason})"


def apart(checks: Sequence[Check], judge: Judge) -> str:
    """How far positions were apart at the last step that was compared, beside what one unit in the last place has grown to."""
    found = [check for check in checks if check.quantity == "position"]
    if not found:
        return ""
    last = max(found, key=lambda check: check.step)
    grown = judge.envelope.at("position", last.step)
    return f"positions {last.max_rel:.0e} of a radius apart at step {last.step}, where one ulp has grown to {grown:.0e}"


def missing(contender: Contender) -> str:
    """Why an engine cannot run, empty when it can."""
    from demverify.engines.base import Missing

    found = ENGINES[contender.engine].find()
    return str(found) if isinstance(found, Missing) else ""


if __name__ == "__main__":
    try:
        print(json.dumps(child(json.loads(sys.argv[1]))))
    except EngineFailed as error:
        sys.exit(str(error))

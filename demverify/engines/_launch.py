"""Runs an engine that is a program: a process group of its own, in the run folder, with a time limit."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from demverify.engines import _screen, instrument
from demverify.engines.base import Found, Job, Outcome, Progress

_POLL_S = 0.1
_GRACE_S = 3.0
_MPI_PREFIXES = ("PMI_", "PMIX_", "HYDI_", "HYDRA_", "OMPI_COMM_", "MPI_LOCALNRANKS", "MPI_LOCALRANKID")


@dataclass(frozen=True)
class Program:
    """How to start an engine. command: the words up to its own options."""

    engine: str
    found: Found
    command: tuple[str, ...]
    environment: Mapping[str, str]


def clean_environment() -> dict[str, str]:
    """The user's environment without what another MPI run left in it, and one OpenMP thread a rank."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(_MPI_PREFIXES)}
    return {**kept, "OMP_NUM_THREADS": "1"}


def launch(program: Program, job: Job, progress: Progress | None) -> Outcome:
    """Prepare the deck, run it, and say what came of it. Raises InputError as `instrument.prepare` does."""
    name = program.engine
    prepared = instrument.prepare(job.deck, job.folder, name, job.variables, job.every)
    instrument.clear_trajectory(job.folder)
    screen, errors = job.folder / f"screen.{name}", job.folder / f"stderr.{name}"
    options = ["-in", prepared.deck.name, "-log", f"log.{name}", "-echo", "both", "-nocite", *_variable_options(job)]
    tracker = _screen.Tracker(progress, prepared.total) if progress else None
    started = time.perf_counter()
    with screen.open("wb") as out, errors.open("wb") as err:
        process = subprocess.Popen(
            [*program.command, *options],
            cwd=job.folder,
            env=dict(program.environment),
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            start_new_session=True,
        )
        code = _watch(process, started + job.timeout_s, screen, tracker)
    wall = time.perf_counter() - started
    said = screen.read_text(errors="replace")
    sums = _screen.loops(said)
    trouble = _trouble(code, job.timeout_s)
    why = _screen.why(said, errors.read_text(errors="replace"), prepared.places)
    trajectory = instrument.join_segments(job.folder)
    return Outcome(
        engine=name,
        status="crashed" if trouble else "ok",
        reason=_reason(trouble, why) if trouble else "",
        version=program.found.version,
        wall_s=wall,
        steps=sums.steps,
        n=sums.n,
        particle_steps_per_s=sums.rate,
        folder=job.folder,
        log=screen,
        trajectory=trajectory,
        columns=prepared.columns if trajectory else (),
        thermo_log=screen,
    )


def _variable_options(job: Job) -> list[str]:
    return [word for name, values in job.variables.items() for word in ("-var", name, *values)]


def _watch(process: subprocess.Popen[bytes], deadline: float, screen: Path, tracker: _screen.Tracker | None) -> int | None:
    """Exit code of the process; None when time ran out. Whatever ends the waiting, no process of the group outlives it."""
    try:
        with screen.open(errors="replace") as shown:
            while (code := _wait(process, deadline)) is None and time.perf_counter() < deadline:
                if tracker:
                    tracker.feed(shown.read())
            if tracker:
                tracker.feed(shown.read())
            return code
    finally:
        _end_group(process)


def _wait(process: subprocess.Popen[bytes], deadline: float) -> int | None:
    with suppress(subprocess.TimeoutExpired):
        return process.wait(timeout=max(0.0, min(_POLL_S, deadline - time.perf_counter())))
    return None


def _end_group(process: subprocess.Popen[bytes]) -> None:
    """Ask the group to end, which lets mpiexec end its ranks; then make it, and what it started elsewhere: ranks have sessions of their own."""
    if process.poll() is not None:
        return
    family = _descendants(process.pid)
    for number in (signal.SIGTERM, signal.SIGKILL):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with suppress(subprocess.TimeoutExpired):
            process.wait(timeout=_GRACE_S)
            break
    for pid, born in family.items():
        if _born(pid) == born:  # a number may have been given to another process since
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def _descendants(root: int) -> dict[int, str]:
    """Process number -> time of birth, of all that descend from `root`."""
    stats = {int(path.name): _stat(int(path.name)) for path in Path("/proc").iterdir() if path.name.isdigit()}
    found: dict[int, str] = {}
    parents = {root}
    while parents:
        parents = {pid for pid, fields in stats.items() if fields and int(fields[1]) in parents and pid not in found}
        found |= {pid: stats[pid][19] for pid in parents}
    return found


def _born(pid: int) -> str:
    return fields[19] if (fields := _stat(pid)) else ""


def _stat(pid: int) -> list[str]:
    """Fields of /proc/PID/stat from the third on (state, parent, ...); empty when it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def _trouble(code: int | None, timeout_s: float) -> str:
    """In words, what the exit code says; empty for success."""
    if code is None:
        return f"stopped at its time limit of {timeout_s:g} s"
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    return f"exit status {code}" if code else ""


def _reason(trouble: str, why: str) -> str:
    """The ERROR line first where there is one, else what became of the process."""
    first, _, rest = why.partition("\n")
    return f"{first} [{trouble}]\n{rest}".rstrip() if "ERROR" in first else f"{trouble}\n{why}".rstrip()

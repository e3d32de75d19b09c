"""The one contract of the engines: a job goes in, an outcome comes out, and neither a missing nor a crashed engine raises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

Status = Literal["ok", "skipped", "crashed"]
Progress = Callable[[int, int], None]  # (steps done, steps planned)


@dataclass(frozen=True)
class Found:
    """An engine that starts: its version as it prints it, and its executable."""

    version: str
    path: Path


@dataclass(frozen=True)
class Missing:
    """An engine that is not here: why, and the command that installs it."""

    reason: str
    install_command: str

    def __str__(self) -> str:
        """One line: the reason and the command."""
        return f"{self.reason}; install it with: {self.install_command}"


@dataclass(frozen=True)
class Job:
    """A deck to run.

    deck: as the user wrote it; never changed. folder: where everything the run writes goes; made when it is not there.
    variables: as on the command line of LAMMPS, name -> values. every: frames of all particles every so many steps; None: none.
    timeout_s: time limit of the whole run, in seconds. ranks: MPI ranks (LAMMPS, LIGGGHTS). threads: of the native engine;
    LAMMPS and LIGGGHTS run one thread a rank, for their OpenMP styles are other code than the styles the deck names.
    """

    deck: Path
    folder: Path
    variables: dict[str, list[str]] = field(default_factory=dict)
    every: int | None = None
    timeout_s: float = 3600.0
    ranks: int = 1
    threads: int = 1


@dataclass(frozen=True)
class Outcome:
    """What became of a job.

    reason: empty when ok; why skipped, with the command that installs the engine; or the ERROR line with the deck's file and line
    and the last lines of the log. wall_s: the whole process, in seconds. steps, n: steps of all runs, particles in the last.
    particle_steps_per_s: particles times steps by the loop times that the engine prints, 0 when it printed none. log: all that
    the engine wrote to the screen. trajectory: frames of `columns`, a binary dump. thermo_log: the text with the thermo tables.
    """

    engine: str
    status: Status
    reason: str
    version: str
    wall_s: float
    steps: int
    n: int
    particle_steps_per_s: float
    folder: Path
    log: Path | None
    trajectory: Path | None
    columns: tuple[str, ...]
    thermo_log: Path | None


class Engine(Protocol):
    """One engine. A module of this folder that exposes `ENGINE` is one."""

    name: str

    def find(self) -> Found | Missing:
        """Whether the engine is here and starts."""
        ...

    def run(self, job: Job, progress: Progress | None = None) -> Outcome:
        """Run the job. Raises InputError for a deck or folder that no engine could run."""
        ...


def skipped(engine: str, missing: Missing, job: Job) -> Outcome:
    """The outcome of a job whose engine is not here."""
    return Outcome(engine, "skipped", str(missing), "", 0.0, 0, 0, 0.0, job.folder, None, None, (), None)

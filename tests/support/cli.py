"""The command line in tests: a small deck whose lines have names, and calls of `demverify` inside and outside of this process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

LINES = {
    "units": "units si",
    "atom_style": "atom_style sphere",
    "boundary": "boundary f f f",
    "newton": "newton off",
    "ghosts": "comm_modify vel yes",
    "region": "region box block -0.05 0.05 -0.05 0.05 -0.05 0.05",
    "box": "create_box 1 box",
    "first": "create_atoms 1 single -0.0051 0.0 0.0",
    "second": "create_atoms 1 single 0.0051 0.0 0.0",
    "set": "set type 1 diameter 0.01 density 2500.0",
    "speed": "set atom 1 vx 0.5",
    "pair": "pair_style gran/hooke/history 1.0e4 3.0e3 500.0 200.0 0.5 1",
    "coeff": "pair_coeff * *",
    "skin": "neighbor 0.002 bin",
    "timestep": "timestep 1.0e-6",
    "nve": "fix move all nve/sphere",
    "compute": "compute rot all erotate/sphere",
    "columns": "thermo_style custom step atoms ke c_rot",
    "thermo": "thermo 10",
    "dump": "dump frames all custom 10 frames.dump id x y z vx omegaz radius mass",
    "run": "run 20",
}
"""A whole LAMMPS deck, a line a name: two spheres that meet head on, wrong nowhere."""


def deck(**changed: str) -> str:
    """The text of the deck with the named lines replaced; an empty text leaves the line blank, so that the others keep their numbers."""
    assert set(changed) <= set(LINES)
    return "\n".join({**LINES, **changed}.values()) + "\n"


def line_of(name: str) -> int:
    """The number of a line of the deck, from 1."""
    return list(LINES).index(name) + 1


class Called(NamedTuple):
    """What a call of the command line gave back."""

    status: int
    out: str
    err: str


Call = Callable[..., Called]


def program(*words: object, **options: object) -> subprocess.Popen[str]:
    """`demverify` started as a process of its own, as from a terminal: a shell's background jobs inherit a SIGINT that is ignored."""
    command = [sys.executable, "-m", "demverify.cli", *map(str, words)]
    process: subprocess.Popen[str] = subprocess.Popen(  # type: ignore[call-overload]
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=_heed_interrupts, **options
    )
    STARTED.append(process)
    return process


STARTED: list[subprocess.Popen[str]] = []
"""What `program` started in this test; a test that fails leaves none of it running (`end_started`)."""


def children(process: subprocess.Popen[str]) -> list[int]:
    """Process ids of the processes that a process has started."""
    return [int(word) for word in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]


def end_started() -> None:
    """Kills every program still running, and the engines it started."""
    for process in STARTED:
        if process.poll() is None:
            for pid in [*children(process), process.pid]:
                os.kill(pid, signal.SIGKILL)
            process.wait()
    STARTED.clear()


def _heed_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def files_in(folder: Path) -> set[str]:
    """Every file and folder below a folder, by its relative path."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}

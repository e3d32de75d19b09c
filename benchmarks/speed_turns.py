"""One thread and two by turns in one process: the ratio `speed.py` prints for threads.

Whole runs of two contenders are tens of seconds apart; on a machine that others use as well, what one run takes changes meanwhile by more than
the ratio is to tell. Here two simulations of one deck advance by turns, a tenth of a second each, neighbour lists included, and the ratio is the
median of the turns'.

Called as a program, it measures what JSON on its command line names, and prints what it found in JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles
from typing import Any

import numpy as np

from benchmarks.read_speed import wait_for_quiet
from benchmarks.speed_run import EngineFailed

ONE, TWO = "native", "native, 2 threads"
TURNS = 16
TURN_S = 0.1
LEAST = 100  # steps of a turn, so that each has its share of neighbour lists
TIMEOUT_S = 600.0
MOST_STEPS = 10  # times the steps of the scene


@dataclass(frozen=True)
class Turns:
    """Rates of two threads over those of one, turn by turn. steps: of a turn. same: whether both ended at the same bits."""

    ratios: tuple[float, ...]
    steps: int
    same: bool

    @property
    def middle(self) -> float:
        """The median."""
        return median(self.ratios)

    @property
    def half(self) -> tuple[float, float]:
        """Between which half of the turns are."""
        low, _, high = quantiles(self.ratios, n=4)
        return low, high


def joined(rounds: Sequence[Turns]) -> Turns:
    """All turns of several rounds."""
    return Turns(tuple(ratio for turns in rounds for ratio in turns.ratios), rounds[0].steps, all(turns.same for turns in rounds))


def turns_of(deck: Path, variables: Mapping[str, Sequence[str]], patience: float = 0.0) -> Turns:
    """Measures in a process of its own, after waiting up to so many seconds for others to be quiet. Raises EngineFailed."""
    wait_for_quiet(patience)
    words = json.dumps({"deck": f"{deck}", "variables": variables})
    try:
        done = subprocess.run([sys.executable, __file__, words], capture_output=True, text=True, check=False, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired as error:
        raise EngineFailed(f"turns of one and two threads: stopped at the time limit of {TIMEOUT_S:g} s") from error
    if done.returncode:
        raise EngineFailed(f"turns of one and two threads: {(done.stderr.strip().splitlines() or ['killed'])[-1]}")
    found = json.loads(done.stdout.splitlines()[-1])
    return Turns(tuple(found["ratios"]), found["steps"], found["same"])


def measured(deck: Path, variables: Mapping[str, Sequence[str]]) -> Turns:
    """Measures in this process: no more than MOST_STEPS times as far as the deck runs."""
    from demsolver import Simulation
    from demverify.runs import plan

    run = plan(deck, variables).runs[0]
    one, two = (Simulation(run.scene, threads=threads) for threads in (1, 2))
    steps = LEAST
    for simulation in (one, two):  # compiles, and warms up
        simulation.setup()
        steps = max(LEAST, int(LEAST * TURN_S / _seconds(simulation, LEAST)))
    turns = max(4, min(TURNS, MOST_STEPS * run.steps // steps))
    ratios = [_seconds(one, steps) / _seconds(two, steps) for _ in range(turns)]
    a, b = one.bodies, two.bodies
    return Turns(tuple(ratios), steps, all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("x", "v", "omega", "force")))


def _seconds(simulation: Any, steps: int) -> float:
    """How long so many steps take."""
    began = time.perf_counter()
    simulation.advance(steps)
    return time.perf_counter() - began


if __name__ == "__main__":
    asked = json.loads(sys.argv[1])
    found = measured(Path(asked["deck"]), asked["variables"])
    print(json.dumps({"ratios": found.ratios, "steps": found.steps, "same": found.same}))

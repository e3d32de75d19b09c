"""One thread, two threads, and two processes of one thread each, by turns: what a second thread brings, beside what a second core can bring.

Whole runs of two contenders are tens of seconds apart; on a machine that others use as well, what one run takes changes meanwhile by more than
the ratio is to tell. Here simulations of one deck advance by turns, a tenth of a second each, neighbour lists included, and a ratio is the median
of the turns'. Two processes that share nothing do at best twice the work of one; where the cores share caches, memory or a host, less.

Called as a program, it measures what JSON on its command line names, and prints what it found in JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
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
MOST_STEPS = 10  # times the steps of the scene
TIMEOUT_S = 600.0


@dataclass(frozen=True)
class Turns:
    """Turn by turn, over the rate of one thread: ratios, of two threads; apart, of two processes together. steps: of a turn. same: whether one and
    two threads ended at the same bits."""

    ratios: tuple[float, ...]
    apart: tuple[float, ...]
    steps: int
    same: bool

    @property
    def half(self) -> tuple[float, float]:
        """Between which the half of the turns of two threads are."""
        low, _, high = quantiles(self.ratios, n=4)
        return low, high

    def __str__(self) -> str:
        low, high = self.half
        spread = f"half of {len(self.ratios)} turns between {low:.2f} and {high:.2f}"
        threads = f"{TWO} / {ONE} by turns in one process: {median(self.ratios):.2f}, {spread}"
        return f"{threads}; two processes of one thread together do {median(self.apart):.2f} times the work of one"


def joined(rounds: Sequence[Turns]) -> Turns:
    """All turns of several rounds."""
    ratios, apart = (tuple(one for turns in rounds for one in getattr(turns, name)) for name in ("ratios", "apart"))
    return Turns(ratios, apart, rounds[0].steps, all(turns.same for turns in rounds))


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
    return Turns(tuple(found["ratios"]), tuple(found["apart"]), found["steps"], found["same"])


def measured(deck: Path, variables: Mapping[str, Sequence[str]]) -> Turns:
    """Measures in this process and one beside it: no more than MOST_STEPS times as far as the deck runs."""
    scene, whole = _scene(deck, variables)
    one, two = (_ready(scene, threads) for threads in (1, 2))
    steps = max(LEAST, int(LEAST * TURN_S / _seconds(lambda: [simulation.advance(LEAST) for simulation in (one, two)])))
    turns = max(4, min(TURNS, MOST_STEPS * whole // steps))
    ratios, apart = [], []
    words = json.dumps({"deck": f"{deck}", "variables": variables, "steps": steps})
    with subprocess.Popen([sys.executable, __file__, words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdin
        assert other.stdout
        other.stdout.readline()
        third = _ready(scene, 1)

        def both() -> None:
            assert other.stdin
            assert other.stdout
            other.stdin.write("go\n")
            other.stdin.flush()
            third.advance(steps)
            other.stdout.readline()

        for _ in range(turns):
            alone = _seconds(lambda: one.advance(steps))
            ratios.append(alone / _seconds(lambda: two.advance(steps)))
            apart.append(2.0 * alone / _seconds(both))
        other.stdin.close()
    a, b = one.bodies, two.bodies
    return Turns(tuple(ratios), tuple(apart), steps, all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("x", "v", "omega", "force")))


def beside(deck: Path, variables: Mapping[str, Sequence[str]], steps: int) -> None:
    """The process beside: for every line on stdin it advances as far, and says so."""
    simulation = _ready(_scene(deck, variables)[0], 1)
    print("ready", flush=True)
    for _ in sys.stdin:
        simulation.advance(steps)
        print("done", flush=True)


def _scene(deck: Path, variables: Mapping[str, Sequence[str]]) -> tuple[Any, int]:
    """The scene of a deck's first run, and its steps."""
    from demverify.runs import plan

    run = plan(deck, variables).runs[0]
    return run.scene, run.steps


def _ready(scene: Any, threads: int) -> Any:
    """A simulation that has compiled and warmed up."""
    from demsolver import Simulation

    simulation = Simulation(scene, threads=threads)
    simulation.setup()
    simulation.advance(LEAST)
    return simulation


def _seconds(work: Callable[[], object]) -> float:
    """How long something takes."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


if __name__ == "__main__":
    asked = json.loads(sys.argv[1])
    if "steps" in asked:
        beside(Path(asked["deck"]), asked["variables"], asked["steps"])
    else:
        found = measured(Path(asked["deck"]), asked["variables"])
        print(json.dumps({"ratios": found.ratios, "apart": found.apart, "steps": found.steps, "same": found.same}))

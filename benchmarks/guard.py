"""What the guard costs: the same scene with and without it, by turns in one process, on the bed, the chute and a single bouncing sphere.

    python benchmarks/guard.py [--turns 40] [--seconds 0.5] [--json FILE]

A turn is two stretches of steps of each, there and back: without, with, another without, that once more, with, without; what drifts
slowly hits all alike. The figure is the median over the turns of the ratio with/without, with its quartiles. Beside it stands that of the
second simulation without a guard: what it is off one by is what this machine cannot tell. Ends with status 1 where a figure is above the
limit of 2 % and the machine could have told.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median, quantiles
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from demsolver import Scene, Simulation

INPUTS = Path(__file__).parents[1] / "inputs"
DECKS = ("bed", "chute", "bouncing-sphere")
LIMIT = 0.02
LOOKS = 2  # of the guard's energy look, that a stretch holds at least


@dataclass(frozen=True)
class Cost:
    """Of one scene. steps: of a stretch. guarded, twin: ratios of times, turn by turn, of the guarded and of the other unguarded simulation over the
    unguarded one. same: whether all three ended at the same bits."""

    scene: str
    particles: int
    steps: int
    guarded: tuple[float, ...]
    twin: tuple[float, ...]
    same: bool

    @property
    def line(self) -> str:
        """As it is printed."""
        (low, _, high), noise = quantiles(self.guarded, n=4), median(self.twin) - 1.0
        bits = "the same bits" if self.same else "OTHER BITS"
        return (
            f"{self.scene:16s} {self.particles:6d} particles, {self.steps} steps a turn: guard {median(self.guarded) - 1.0:+.2%} "
            f"({low - 1.0:+.2%} to {high - 1.0:+.2%}), no guard twice {noise:+.2%}, {bits}"
        )

    @property
    def too_much(self) -> bool:
        """Above the limit by more than the machine's own difference."""
        return median(self.guarded) - 1.0 > LIMIT + abs(median(self.twin) - 1.0)


def cost_of(name: str, scene: Scene, turns: int, seconds: float) -> Cost:
    """Measures one scene. seconds: of a stretch."""
    from demsolver.guard import Guard

    plain, twin, guarded = (ready(scene, guard=guard) for guard in (False, False, True))
    every = Guard(scene, stops=True, tell=print).every
    for one in (plain, twin, guarded):  # until the guard looks as seldom as it ever will
        one.advance(2 * every)
    pace = max(seconds_of(one, every) for one in (plain, twin, guarded)) / every
    steps = max(LOOKS * every, int(seconds / pace))
    ratios: dict[bool, list[float]] = {True: [], False: []}
    for _ in range(turns):
        first, second, third, fourth, fifth, sixth = (seconds_of(one, steps) for one in (plain, guarded, twin, twin, guarded, plain))
        ratios[True].append((second + fifth) / (first + sixth))
        ratios[False].append((third + fourth) / (first + sixth))
    a, b = plain.bodies, guarded.bodies
    same = all(np.array_equal(getattr(a, field), getattr(b, field)) for field in ("x", "v", "force"))
    return Cost(name, len(scene.particles.id), steps, tuple(ratios[True]), tuple(ratios[False]), same)


def ready(scene: Scene, *, guard: bool = True) -> Simulation:
    """Set up, its loop compiled for this much."""
    from demsolver import Simulation

    simulation = Simulation(scene, on_instability="stop" if guard else "off")
    simulation.setup()
    return simulation


def seconds_of(simulation: Simulation, steps: int) -> float:
    """Wall time of so many steps."""
    began = time.perf_counter()
    simulation.advance(steps)
    return time.perf_counter() - began


def main(words: Sequence[str] | None = None) -> int:
    """Measures, prints, and returns the exit status."""
    from demverify.runs import plan

    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--turns", type=int, default=40)
    parser.add_argument("--seconds", type=float, default=0.5)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args(words)
    found = []
    for name in DECKS:
        found.append(cost_of(name, plan(INPUTS / name / "in.lammps", {}).runs[0].scene, max(2, asked.turns), asked.seconds))
        print(found[-1].line, flush=True)
    if asked.json:
        asked.json.write_text(json.dumps([asdict(one) for one in found]))
    return int(any(one.too_much or not one.same for one in found))


if __name__ == "__main__":
    sys.exit(main())

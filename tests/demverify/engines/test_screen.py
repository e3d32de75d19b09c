"""Reading what the engines print: rates, progress, and the place of an error."""

from __future__ import annotations

from pathlib import Path

import pytest

from demverify.engines._screen import Tracker, loops, why
from demverify.errors import Place

SCREEN = """run 100
   Step        Atoms        KinEng
         0           3   654.49847
INFO: something in between
        50           3   646.2918
       100           3   578.35152
Loop time of 0.5 on 2 procs for 100 steps with 3 atoms
run 150 upto
   Step        Atoms        KinEng
       100           3   578.35152
       150           2   5.0
Loop time of 1.5 on 1 procs for 50 steps with 2 atoms, finish time Sun Nov 22 03:54:36 2026
"""


def test_rate_is_work_over_loop_time():
    """Particle steps of all runs over the loop time of all runs: (100*3 + 50*2) / 2 s."""
    sums = loops(SCREEN)
    assert (sums.steps, sums.n, sums.rate) == (150, 2, 200.0)


def test_no_loop_no_rate():
    """A deck without a run, or a run of no time, has rate 0, not a division by zero."""
    assert loops("").rate == 0.0
    assert loops("Loop time of 0 on 1 procs for 0 steps with 2 atoms\n").rate == 0.0


@pytest.mark.parametrize("size", [1, 7, 10_000])
@pytest.mark.parametrize("total", [None, 150])
def test_progress_counts_over_runs_however_it_is_cut(size, total):
    """Steps done never fall, end at all steps, and the plan is the deck's or else the end of the present run."""
    calls: list[tuple[int, int]] = []
    tracker = Tracker(lambda done, planned: calls.append((done, planned)), total)
    for at in range(0, len(SCREEN), size):
        tracker.feed(SCREEN[at : at + size])
    done = [call[0] for call in calls]
    assert done == sorted(done)
    assert calls[-1] == (150, 150)
    if size == 1:
        assert calls[1] == (50, total or 100)


def test_an_error_is_told_with_the_last_echoed_command():
    """Of two equal lines the second echo is the second line in the deck."""
    places = {"run 5": [Place(Path("in.x"), 3), Place(Path("in.x"), 9)]}
    said = why("run 5\nLoop\nrun   5\nsetup\nERROR: bad (a.cpp:1)\nLast input line: run 5\n", "", places)
    assert said.splitlines()[0] == "in.x:9: ERROR: bad (a.cpp:1)"
    assert said.splitlines()[-1] == "Last input line: run 5"


def test_without_an_error_the_last_lines_speak():
    """No ERROR line: the tails of screen and stderr."""
    assert why("a\n\nb\n", "c\n", {}) == "a\nb\nc"

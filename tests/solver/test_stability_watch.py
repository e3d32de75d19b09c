"""Who is told of a step above its limit, how often, and at what cost."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest

from demsolver import Scene, Simulation, stability_watch
from demsolver.stability_watch import StepWatch
from tests.support.scenes import bed

SINGLE, PACKING = 3.439e-4, 2.163e-4
"""Limits of the bed: of a contact of two spheres (tangential), of the packing (test_stability_packing.py has how such numbers come about)."""


def told(*scenes: Scene) -> list[str]:
    """What a watch says when it looks at simulations, one after another."""
    said: list[str] = []
    watch = StepWatch(said.append)
    for scene in scenes:
        simulation = Simulation(scene, on_instability="off")
        simulation.setup()
        watch.look(simulation)
    return said


def test_a_step_below_both_limits_says_nothing() -> None:
    """Law: no word below the limits, far below or near."""
    assert told(bed(1e-5), bed(0.99 * PACKING)) == []


def test_a_step_above_the_packings_limit_is_told() -> None:
    """Law: one line with the step, the limit and the law."""
    (line,) = told(bed(1.01 * PACKING))
    assert line.startswith("the step 0.00021846")
    assert "is above 0.00021" in line
    assert line.endswith("the stability limit of the packing of 2681 contacts (hooke)")


def test_a_step_above_a_single_contacts_limit_is_told_first() -> None:
    """Law: then the packing need not be looked at: one line, naming contact, motion and laws."""
    (line,) = told(bed(1.01 * SINGLE))
    assert "types 1 and 1, tangential (classic_history (constant + scaled))" in line


def test_everything_is_told_once() -> None:
    """Law: a deck of many runs gets one line for each limit, not one for each run."""
    assert len(told(bed(1.01 * PACKING), bed(1.01 * PACKING), bed(1.01 * SINGLE), bed(1.01 * SINGLE))) == 2


def test_an_unchanged_packing_is_not_looked_at_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: eigenvalues are computed again for another step, or with a tenth more contacts."""
    asked = []
    monkeypatch.setattr(stability_watch, "packing_limit", lambda scene, contacts: asked.append(len(contacts)) or _fine())
    near, nearer = bed(0.9 * PACKING), bed(0.95 * PACKING)
    few = replace(near, walls=())
    told(near, near, few, nearer, nearer)
    assert asked == [2681, 2681]
    asked.clear()
    told(_part(near, 400), near)
    assert len(asked) == 2


def _fine() -> object:
    return type("Limit", (), {"combined": np.inf})


def _part(scene: Scene, n: int) -> Scene:
    p = scene.particles
    return replace(scene, particles=p.rows(np.arange(n)))


def test_large_packings_are_told_of_by_their_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: above MOST_CONTACTS only single contacts count."""
    monkeypatch.setattr(stability_watch, "MOST_CONTACTS", 1000)
    assert told(bed(1.01 * PACKING)) == []
    assert len(told(bed(1.01 * SINGLE))) == 1


def test_a_step_far_below_costs_little() -> None:
    """Law: a look at 1,000 spheres at a tenth of the limit takes less than a second (some 10 ms measured)."""
    simulation = Simulation(bed(0.1 * PACKING), on_instability="off")
    simulation.setup()
    watch = StepWatch(print)
    watch.look(simulation)
    began = perf_counter()
    watch.look(simulation)
    assert perf_counter() - began < 1.0

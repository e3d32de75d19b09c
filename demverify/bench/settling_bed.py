"""Bulk figures of a bed that falls together: how high its centre of mass comes to lie, and how many contacts a sphere has."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State, scene_of
from demverify.bench._ways import EULER, GRADIENT, VERLET, engines, euler, gradient
from demverify.frames import Floats

if TYPE_CHECKING:
    from demsolver import Scene

TITLE = "a settling bed"
KN, DURATION = 1e4, 0.4
MASS = 2500.0 * 4.0 / 3.0 * pi * 0.005**3
CONTACT = pi * sqrt(0.5 * MASS / KN)
REFERENCES = (80, 84, 88, 92, 96, 100, 104, 108)
"""Steps a contact of the runs whose mean is the reference."""
READINGS = (
    "225 spheres of 9 to 11 mm, periodic sideways, fall some 20 mm and come to rest with dashpots and friction.",
    (
        "Where each sphere ends depends on every rounding: what can be compared are figures of the bulk, and those scatter from run to run. No step "
        "is better than that scatter, so no order is to be seen: the longest step that holds is as good as any."
    ),
    (
        "The reference is the mean of eight runs by velocity Verlet at 80 to 108 steps a contact; their scatter is in its table, and the mean of "
        "eight is known to a third of it."
    ),
)


def bulk(x: Floats, scene: Scene) -> tuple[float, float]:
    """Height of the centre of mass, and contacts a sphere, the floor's counted once."""
    from scipy.spatial import cKDTree

    p, length = scene.particles, (scene.box.hi - scene.box.lo)[:2]
    apart = np.column_stack([np.mod(x[:, :2] - scene.box.lo[:2], length), x[:, 2]])
    pairs = cKDTree(apart, boxsize=(*length, 0.0)).query_pairs(2.0 * float(p.radius.max()), output_type="ndarray")
    d = apart[pairs[:, 0]] - apart[pairs[:, 1]]
    d[:, :2] -= length * np.round(d[:, :2] / length)
    touch = np.linalg.norm(d, axis=1) < p.radius[pairs].sum(axis=1)
    return float(p.mass @ x[:, 2] / p.mass.sum()), float(2.0 * touch.sum() + (x[:, 2] < p.radius).sum()) / len(x)


@cache
def reference(quick: bool) -> Floats:
    """(runs, 2) bulk figures."""
    from demsolver import Simulation

    found = []
    for each in REFERENCES[:3] if quick else REFERENCES:
        steps = round(DURATION / CONTACT * each)
        scene = scene_of(_problem((), (), quick), steps)
        simulation = Simulation(scene)
        simulation.setup()
        simulation.advance(steps)
        found.append(bulk(simulation.bodies.x, scene))
    return np.array(found)


def error(scene: Scene, states: Sequence[State], figure: int, quick: bool) -> float:
    """Off the mean of the reference, relative."""
    mean = reference(quick).mean(axis=0)[figure]
    return abs(bulk(states[-1].x, scene)[figure] / float(mean) - 1.0)


def problems(quick: bool) -> tuple[Problem, ...]:
    """One bed."""
    contacts = (3, 6, 12, 24, 48) if quick else (2, 3, 4, 6, 9, 13, 19, 28, 41, 60)
    own = (Contender(VERLET, 0), Contender(EULER, 1, change=euler), Contender(GRADIENT, 2, change=gradient))
    return (_problem(own[:1] if quick else (*own, *engines({})), tuple(1.0 / (n + 0.5) for n in contacts), quick),)


def _problem(contenders: tuple[Contender, ...], shares: tuple[float, ...], quick: bool) -> Problem:
    names = (("height of the centre of mass, relative", "height"), ("contacts a sphere, relative", "contacts"))
    measures = tuple(
        Measure(name, short, partial(error, figure=k, quick=quick), scatter=None if quick else partial(by_chance, k))
        for k, (name, short) in enumerate(names)
    )  # fmt: skip
    return Problem(
        "settling-bed", "Linear spring, dashpot and friction", {"kn": repr(KN)}, DURATION, CONTACT, "a contact time", shares, measures, contenders,
        "the mean of runs at 80 and more steps a contact, which scatter.", convergence=partial(scatter, quick),
    )  # fmt: skip


def by_chance(figure: int) -> tuple[float, float]:
    """Of a figure: standard deviation of a run from the mean of those of the reference, relative; and the longest step that leaves it at that."""
    found = reference(False)[:, figure]
    return float(found.std(ddof=1) / found.mean() * sqrt(1.0 + 1.0 / len(found))), 1.0 / 4.5


def scatter(quick: bool) -> tuple[tuple[str, float], ...]:
    """Standard deviations between the runs of the reference, relative."""
    found = reference(quick)
    height, contacts = found.std(axis=0, ddof=1) / found.mean(axis=0)
    return (("runs at 80 and more steps a contact: scatter of the height", float(height)), ("scatter of the contacts", float(contacts)))

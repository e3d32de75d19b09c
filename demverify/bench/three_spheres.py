"""A smooth elastic sphere slides down between two others and pushes them apart: several lasting contacts at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State, scene_of
from demverify.bench._ode import Spheres, solved
from demverify.bench._ways import EULER, GRADIENT, MENDED, VERLET, engines, euler, gradient, mended
from demverify.frames import Floats

if TYPE_CHECKING:
    from demsolver import Scene

TITLE = "a sphere slides between two others"
GRAVITY, DURATION = 9.80665, 0.1
STIFFNESS = {"hooke": 1e5, "hertz": 2e7}
FINENESS = ((1e-8, 2_000), (1e-10, 3_000), (1e-12, 5_000), (3e-14, 8_000))  # tolerance, and steps at least
READINGS = (
    "Euler starts from rest as if half a step later, which the speed at the end, that stays as it is, does not show: it is of order two here.",
)
NAMES = {"hooke": "Linear spring", "hertz": "Hertz"}


@lru_cache(maxsize=16)
def velocities(model: str, fineness: tuple[float, int]) -> Floats:
    """(3, 3) at the end."""
    scene = scene_of(_bare(model), 1)
    return solved(Spheres.of(scene, GRAVITY), scene.particles.x, scene.particles.v, DURATION, *fineness)[1]


def error(scene: Scene, states: Sequence[State], model: str, fineness: tuple[float, int]) -> float:
    """Root mean square over the lower spheres of the last speed along x, relative to the speed."""
    expected = velocities(model, fineness)[:2, 0]
    return float(np.sqrt(np.mean((states[-1].v[:2, 0] / expected - 1.0) ** 2)))


def _bare(model: str) -> Problem:
    words = {"model": model, "kn": repr(STIFFNESS[model])}
    return Problem("three-spheres", NAMES[model], words, DURATION, 1.0, "", (1.0,), (), (), "")


def problems(quick: bool) -> tuple[Problem, ...]:
    """Linear spring, and Hertz."""
    return tuple(_problem(model, quick) for model in (("hooke",) if quick else STIFFNESS))


def _problem(model: str, quick: bool) -> Problem:
    steps = (6, 15, 40, 80, 160) if quick else (4, 6, 10, 16, 25, 40, 63, 100, 160, 250, 400, 630)
    mass = 2500.0 * 4.0 / 3.0 * pi * 0.02**3
    own: tuple[Contender, ...] = (
        Contender(VERLET, 0, orders={"speed": 2.0}),
        Contender(EULER, 1, change=euler, orders={"speed": 2.0}),
    )
    if model == "hooke":
        own += (Contender(GRADIENT, 2, change=gradient), Contender(MENDED, 3, change=mended))
    finest, others = FINENESS[1 if quick else -1], FINENESS[: 1 if quick else -1]
    return Problem(
        "three-spheres", NAMES[model], {"model": model, "kn": repr(STIFFNESS[model])}, DURATION, pi * sqrt(mass / 1e5), "a contact time",
        tuple(1.0 / (n + 0.5) for n in steps),
        (Measure("speed of the lower spheres at the end, relative", "speed", partial(error, model=model, fineness=finest)),),
        own[::2] if quick else (*own, *engines({"speed": 2.0})),
        "the equations of motion by DOP853, from one change of contact to the next.", partial(convergence, model, finest, others),
    )  # fmt: skip


def convergence(model: str, finest: tuple[float, int], others: Sequence[tuple[float, int]]) -> tuple[tuple[str, float], ...]:
    """Of the reference, with its tolerance."""
    last = velocities(model, finest)
    off = [float(np.abs(velocities(model, one) - last).max() / np.abs(last).max()) for one in others]
    return tuple((f"tolerance {tolerance:g}, {least:,} steps and more", one) for (tolerance, least), one in zip(others, off, strict=True))

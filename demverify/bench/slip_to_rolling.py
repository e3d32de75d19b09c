"""Balls slip along a plane until they roll: an elastic tangential spring that is wound up, slips, and lets go."""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, cos, pi, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State
from demverify.bench._ways import EULER, GRADIENT, MENDED, VERLET, engines, euler, gradient, mended

if TYPE_CHECKING:
    from demsolver import Scene

TITLE = "balls slip until they roll"
KN, KT, FRICTION, GRAVITY = 1e6, 1e6 / 3.5, 0.3, 9.81
SWING = 1.1365e-4  # [s] half a swing of the tangential spring, pi sqrt(2 m/(7 kt)): what steps are stated in
DURATION = 9.775e-3  # all have begun to roll, 0.2 to 0.8 of half a swing before
READINGS = (
    "Ten balls of 10 mm at 0.1 m/s and up to 0.2 % more, each by itself; they end their slip at ten phases of a step.",
    (
        "No dashpots: LIGGGHTS counts the tangential one outside the friction limit, LAMMPS inside. The floor is so stiff that LIGGGHTS' lever "
        "R - overlap/2 is 1.3e-6 short."
    ),
    (
        "The spring winds up in 1.3e-7 s, less than an eighth of the shortest step: to every step here friction begins with a jump, which takes "
        "Verlet one order."
    ),
)


def slip_at(time: float, slip: float, mass: float) -> float:
    """Slip of the contact point: the spring winds up, u = u0 cos(W t), W^2 = 7 kt/(2 m), until kt u0/W sin(W t) = mu m g; slides, u' = -7/2 mu g,
    until u = 0; lets go, u = -W s cos's derivative, s = mu m g/kt cos(W t), for half a swing at most."""
    own, stretch = sqrt(3.5 * KT / mass), FRICTION * mass * GRAVITY / KT
    wound = asin(stretch * own / slip) / own
    if time < wound:
        return slip * cos(own * time)
    left = slip * cos(own * wound)
    stops = wound + left / (3.5 * FRICTION * GRAVITY)
    if time < stops:
        return left - 3.5 * FRICTION * GRAVITY * (time - wound)
    return -stretch * own * sin(own * min(time - stops, pi / own))


def error(scene: Scene, states: Sequence[State]) -> float:
    """Root mean square over the balls of the last (vx, R omega_y), relative to the speed at first."""
    p, last = scene.particles, states[-1]
    gained = np.array([slip_at(DURATION, float(v), float(m)) - float(v) for v, m in zip(p.v[:, 0], p.mass, strict=True)])
    off = [last.v[:, 0] - (p.v[:, 0] + gained / 3.5), p.radius * last.omega[:, 1] + gained / 1.4]
    return float(np.sqrt(np.mean(np.sum(np.square(off), axis=0) / p.v[:, 0] ** 2)))


def problems(quick: bool) -> tuple[Problem, ...]:
    """Linear springs."""
    swings = (4, 10, 25, 50, 100) if quick else (2, 3, 4, 6, 10, 16, 25, 40, 63, 100)
    own = (
        Contender(VERLET, 0, orders={"motion": 1.0}), Contender(EULER, 1, change=euler, orders={"motion": 1.0}),
        Contender(GRADIENT, 2, change=gradient), Contender(MENDED, 3, change=mended),
    )  # fmt: skip
    return (Problem(
        "slip-to-roll", "Linear springs", {"kn": repr(KN), "kt": repr(KT), "mu": repr(FRICTION)}, DURATION, SWING, "half a tangential swing",
        tuple(1.0 / (n + 0.5) for n in swings),
        (Measure("velocity and spin as rolling begins, relative to the first speed", "motion", error),),
        own[:1] if quick else (*own, *engines({"motion": 1.0})),
        "winding, sliding and letting go, each in closed form.",
    ),)  # fmt: skip

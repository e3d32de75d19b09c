"""Five spheres that just touch sag under their weight: springs and dashpots in smooth, lasting contact."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State
from demverify.bench._ways import EULER, GRADIENT, VERLET, engines, euler, gradient
from demverify.frames import Floats

if TYPE_CHECKING:
    from demsolver import Scene

TITLE = "a damped stack of five"
KN, GAMMA, GRAVITY, DURATION = 1e4, 4000.0, 9.81, 0.02
MASS = 2500.0 * 4.0 / 3.0 * pi * 0.005**3
READINGS = (
    "No contact opens or closes: only the dashpot takes an order from Verlet here, for it sees the velocity of half a step before.",
    "Linear only: with Hertz the engines damp by other formulas, and model P has a restitution in place of a dashpot.",
)
_KICKS = (
    "Its springs are of order two; dashpots act in a kick before and one after them, each with the velocity from before it, which is of order one."
)


def sag(n: int, time: float) -> tuple[Floats, Floats]:
    """Displacements and velocities (n,) along z: m z'' = -g m - K z - C z', from rest at z = 0. K, C: of the chain that hangs on the floor; the
    dashpot is
    gamma m* of each contact, m* = m/2 of a pair and m of the floor."""
    from scipy.linalg import expm

    links = np.eye(n) - np.eye(n, k=-1)  # how each contact is stretched; the first is that with the floor
    share = np.array([1.0, *([0.5] * (n - 1))])
    stiffness, damping = KN * links.T @ links / MASS, GAMMA * links.T @ np.diag(share) @ links
    rate = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])
    rest = np.concatenate([np.linalg.solve(stiffness, np.full(n, -GRAVITY)), np.zeros(n)])
    y = rest - expm(time * rate) @ rest
    return y[:n], y[n:]


def error(scene: Scene, states: Sequence[State]) -> float:
    """Root mean square over the spheres and four moments of the displacement, relative to the sag of the topmost at rest."""
    n = len(scene.particles.id)
    final = KN / (MASS * GRAVITY * n * (n + 1) / 2)
    off = [
        state.x[:, 2] - scene.particles.x[:, 2] - sag(n, DURATION * (k + 1) / len(states))[0] for k, state in enumerate(states)
    ]
    return float(np.sqrt(np.mean(np.square(off))) * final)


def problems(quick: bool) -> tuple[Problem, ...]:
    """Linear."""
    contacts = (5, 10, 20, 50, 100) if quick else (4, 6, 10, 16, 25, 40, 63, 100, 160, 250, 400, 630)
    own = (
        Contender(VERLET, 0, orders={"sag": 1.0}), Contender(EULER, 1, change=euler, orders={"sag": 1.0}),
        Contender(GRADIENT, 2, change=gradient, orders={"sag": 2.0}, why={"sag": _KICKS}),
    )  # fmt: skip
    return (Problem(
        "damped-stack", "Linear spring and dashpot", {"kn": repr(KN), "gamma": repr(GAMMA)}, DURATION, pi * sqrt(MASS / KN), "a contact time",
        tuple(1.0 / n for n in contacts), (Measure("displacement at four moments, relative to the sag at rest", "sag", error),),
        own[:1] if quick else (*own, *engines({"sag": 1.0})),
        "the exponential of the matrix of the chain.", instants=4,
    ),)  # fmt: skip

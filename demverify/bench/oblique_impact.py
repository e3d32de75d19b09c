"""Spheres hit a wall obliquely: slide, stick and slide again, on elastic linear springs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from math import cos, pi, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State
from demverify.bench._ways import EULER, GRADIENT, VERLET, engines, euler, gradient

if TYPE_CHECKING:
    from demsolver import Scene

TITLE = "oblique impact on a wall"
KN, KT, FRICTION = 1e6, 8e5, 0.3
CONTACT = 1.1365e-4  # [s] of the spheres of the deck, pi sqrt(m/kn): what steps are stated in
DURATION = 100.0 * CONTACT
READINGS = (
    ("Ten spheres of 10 mm with 4 mm/s, 30 degrees from the normal, no gravity, each by itself and at a phase of its own. The equations without "
    "damping "
    "are linear in the speed: a slow impact keeps the overlap at 2e-5 of the radius, and with it what LIGGGHTS' lever, shorter by half of it, "
    "changes."),
    "Without model P: its contacts take some three steps, however short, so that the shorter the step the less friction has time to do.",
    "Linear springs only: with Mindlin's tangential stiffness the two engines and the native laws solve different equations.",
)


def rebound(mass: float, vn: float, slip: float) -> float:
    """Slip of the contact point after the impact. Normal: d = vn/w sin(w t), w^2 = kn/m. Along: m u' = 7/2 F, with F = -kt s, s' = u while |F| <=
    mu kn d,
    else F = -mu kn d against the stretch and s = mu kn d/kt. Piece by piece in closed form; slip, vn > 0."""
    w, own = sqrt(KN / mass), sqrt(3.5 * KT / mass)
    limit = FRICTION * KN / KT * vn / w  # of the stretch, times sin(w t)
    t, s, u, sliding, sign, end = 0.0, 0.0, slip, slip > limit * w, 1.0, pi / w
    while t < end:
        if sliding:
            stop = _first(partial(_faster, t=t, u=u, sign=sign, vn=vn, w=w, least=limit * w), t, end)
            u, s, sliding = _slid(stop, t, u, sign, vn, w), sign * limit * sin(w * stop), False
        else:
            stop = _first(partial(_held, t=t, s=s, u=u, own=own, w=w, limit=limit), t, end)
            s, u = _stuck(stop - t, s, u, own)
            sign, sliding = (1.0 if s > 0.0 else -1.0), True
        t = stop
    return u


def _slid(x: float, t: float, u: float, sign: float, vn: float, w: float) -> float:
    """Slip at x, sliding since t with u then."""
    return u - sign * 3.5 * FRICTION * vn * (cos(w * t) - cos(w * x))


def _faster(x: float, t: float, u: float, sign: float, vn: float, w: float, least: float) -> float:
    """By how much the slip is faster than the stretch at the limit grows: positive while it slides."""
    return sign * _slid(x, t, u, sign, vn, w) - least * cos(w * x)


def _held(x: float, t: float, s: float, u: float, own: float, w: float, limit: float) -> float:
    """By how much the stretch is below the limit: positive while it sticks."""
    return limit * sin(w * x) - abs(_stuck(x - t, s, u, own)[0])


def _stuck(x: float, s: float, u: float, own: float) -> tuple[float, float]:
    """Stretch and slip after x of sticking."""
    return s * cos(own * x) + u / own * sin(own * x), u * cos(own * x) - s * own * sin(own * x)


def _first(positive: Callable[[float], float], t: float, end: float) -> float:
    """The first moment after t at which the function stops being positive; `end` if none. (Where a piece begins it is zero.)"""
    from scipy.optimize import brentq

    x = t + (end - t) * np.linspace(0.0, 1.0, 4001)[1:]
    below = np.flatnonzero(np.array([positive(one) for one in x]) < 0.0)
    if not len(below) or x[below[0]] >= end * (1.0 - 1e-12):
        return end
    k = int(below[0])
    return t if k == 0 else float(brentq(positive, x[k - 1], x[k], xtol=1e-300, rtol=1e-15))


@lru_cache(maxsize=8)
def _rebound(mass: float, vn: float, slip: float) -> float:
    return rebound(mass, vn, slip)


def error(scene: Scene, states: Sequence[State]) -> float:
    """Root mean square over the spheres of the last (vx, vz, R omega_y), relative to the speed of impact."""
    p, last = scene.particles, states[-1]
    mass, radius = float(p.mass[0]), float(p.radius[0])
    vx, vn = float(p.v[0, 0]), -float(p.v[0, 2])
    gained = _rebound(mass, vn, vx) - vx
    off = [last.v[:, 0] - (vx + gained / 3.5), last.v[:, 2] - vn, radius * last.omega[:, 1] + gained / 1.4]
    return float(np.sqrt(np.mean(np.sum(np.square(off), axis=0))) / np.hypot(vx, vn))


def problems(quick: bool) -> tuple[Problem, ...]:
    """Linear springs."""
    contacts = (4, 10, 25, 50, 100) if quick else (2, 4, 6, 10, 16, 25, 40, 63, 100, 160, 250, 400)
    own = (
        Contender(VERLET, 0, orders={"motion": 2.0}), Contender(EULER, 1, change=euler, orders={"motion": 2.0}),
        Contender(GRADIENT, 2, change=gradient, orders={"motion": 2.0}),
    )  # fmt: skip
    return (Problem(
        "oblique-impact", "Linear springs", {"kn": repr(KN), "kt": repr(KT), "mu": repr(FRICTION)}, DURATION, CONTACT, "a contact time",
        tuple(1.0 / (n + 0.5) for n in contacts),
        (Measure("velocity and spin after the impact, relative to its speed", "motion", error),),
        own[:1] if quick else (*own, *engines({"motion": 2.0})),
        "sliding and sticking in turn, each in closed form, the moments between them to rounding.",
    ),)  # fmt: skip

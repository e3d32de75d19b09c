"""Smooth spheres on a floor as an ordinary differential equation: springs of one law, dashpots, gravity; solved to a tolerance, contact by contact.

Pieces between changes of contact are smooth, and DOP853 of scipy keeps its order; each change is an event at which the next piece starts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from demverify.frames import Floats

if TYPE_CHECKING:
    from demsolver import Scene

MOST_PIECES = 10_000
SLACK = 1e-15  # a contact ends at this gap and begins at this overlap, a hundred times the rounding of either


@dataclass(frozen=True)
class Spheres:
    """radius, mass: (n,). Force kn d^power sqrt(R*)^(2 (power - 1)) + gamma m* d': of a pair with reduced mass and radius, of the floor z = 0
    with the sphere's."""

    radius: Floats
    mass: Floats
    kn: float
    gamma: float
    power: float
    gravity: float

    @classmethod
    def of(cls, scene: Scene, gravity: float) -> Spheres:
        """Of a scene with a pair law and a floor of the same law, hooke or hertz."""
        assert scene.pair is not None
        p, law = scene.particles, scene.pair
        damping = float(law.coefficients["gamman"][0, 0]) if "gamman" in law.coefficients else 0.0
        return cls(p.radius, p.mass, float(law.coefficients["kn"][0, 0]), damping, 1.5 if law.normal == "hertz" else 1.0, gravity)

    @property
    def contacts(self) -> list[tuple[int, int]]:
        """(i, j) of all pairs; (i, -1) with the floor."""
        return [*combinations(range(len(self.mass)), 2), *((i, -1) for i in range(len(self.mass)))]

    def overlap(self, contact: tuple[int, int], y: Floats) -> float:
        """Negative: a gap. y: positions and velocities, (2, n, 3) as one row."""
        i, j = contact
        x = y[: y.size // 2].reshape(-1, 3)
        if j < 0:
            return float(self.radius[i] - x[i, 2])
        return float(self.radius[i] + self.radius[j] - np.linalg.norm(x[i] - x[j]))

    def rate(self, y: Floats, touching: list[tuple[int, int]]) -> Floats:
        """y' with these contacts in touch."""
        x, v = y.reshape(2, -1, 3)
        force = np.zeros_like(x)
        force[:, 2] -= self.mass * self.gravity
        for i, j in touching:
            if j < 0:
                n, d, closing, m, r = np.array([0.0, 0.0, 1.0]), self.radius[i] - x[i, 2], -v[i, 2], self.mass[i], self.radius[i]
            else:
                apart = x[i] - x[j]
                distance = float(np.linalg.norm(apart))
                n, d = apart / distance, self.radius[i] + self.radius[j] - distance
                closing = -float((v[i] - v[j]) @ n)
                m = self.mass[i] * self.mass[j] / (self.mass[i] + self.mass[j])
                r = self.radius[i] * self.radius[j] / (self.radius[i] + self.radius[j])
            depth = max(float(d), 0.0) if self.power != 1.0 else float(d)
            push = (self.kn * depth**self.power * r ** (self.power - 1.0) + self.gamma * m * closing) * n
            force[i] += push
            if j >= 0:
                force[j] -= push
        return np.concatenate([v.ravel(), (force / self.mass[:, None]).ravel()])


def solved(spheres: Spheres, x: Floats, v: Floats, duration: float, tolerance: float, least: int) -> tuple[Floats, Floats]:
    """Positions and velocities (n, 3) at the end. tolerance: relative, of a step of the integrator. least: as many steps as it takes at
    least, so that no contact opens and closes again within one. Raises ArithmeticError if contacts do not stop changing."""
    from scipy.integrate import solve_ivp

    y, t = np.concatenate([x.ravel(), v.ravel()]).astype(float), 0.0
    touching = [one for one in spheres.contacts if spheres.overlap(one, y) >= -SLACK / 2]
    for _ in range(MOST_PIECES):
        events = [_event(spheres, one, opens=one in touching) for one in spheres.contacts]
        piece = solve_ivp(
            lambda _, y, touching=touching: spheres.rate(y, touching), (t, duration), y,
            method="DOP853", rtol=tolerance, atol=tolerance * 1e-3, events=events, max_step=duration / least,
        )  # fmt: skip
        y, t = piece.y[:, -1], float(piece.t[-1])
        if piece.status == 0:
            x, v = y.reshape(2, -1, 3)
            return x, v
        changed = next(one for one, times in zip(spheres.contacts, piece.t_events, strict=True) if len(times))
        touching = _after(spheres, y, touching, changed)
    message = f"contacts changed more than {MOST_PIECES} times"
    raise ArithmeticError(message)


def _after(spheres: Spheres, y: Floats, touching: list[tuple[int, int]], changed: tuple[int, int]) -> list[tuple[int, int]]:
    """Who touches after a change: in a symmetric scene several change at one moment, and those that are there but for rounding change too."""
    found = []
    for one in spheres.contacts:
        overlap = spheres.overlap(one, y)
        before = one in touching
        found += [one] if (before ^ (one == changed or (overlap < -0.9 * SLACK if before else overlap > 0.9 * SLACK))) else []
    return found


def _event(spheres: Spheres, contact: tuple[int, int], *, opens: bool) -> Callable[[float, Floats], float]:
    """As `solve_ivp` asks for it: a function with attributes."""

    def event(_: float, y: Floats) -> float:
        return spheres.overlap(contact, y) + (SLACK if opens else -SLACK)

    event.terminal, event.direction = True, -1.0 if opens else 1.0  # type: ignore[attr-defined]
    return event

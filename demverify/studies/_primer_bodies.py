"""Appendix A of the primer: momentum, angular momentum and energy of a crowd that collides in the native solver, split at its centre."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from demverify.report.axes import decades, linear, scientific
from demverify.report.charts import Series, chart
from demverify.studies import Claim, Figure, Finding
from demverify.studies._primer_scenes import DENSITY, RADIUS, G, spheres, stage, started

if TYPE_CHECKING:
    from demsolver import Particles, Simulation
    from demverify.frames import Floats

EXACT = 1e-10  # of the scale: 50 m off the origin places are rounded to 7e-15 m, of overlaps of 1e-5 m


@dataclass(frozen=True)
class Whole:
    """A crowd as one: its mass, the place and velocity of its centre (A.1), (A.3), and the sums of A.2 and A.3.

    momentum: P. orbit: sum of x cross m v, (A.17). spin: sum of I w. about_centre: L' of (A.20), of the orbits alone. kinetic: (A.10).
    relative: sum of m v'^2/2.
    """

    mass: float
    place: Floats
    velocity: Floats
    momentum: Floats
    orbit: Floats
    spin: Floats
    about_centre: Floats
    kinetic: float
    relative: float
    rest: float

    @property
    def of_centre(self) -> Floats:
        """L_G, (A.19)."""
        return np.asarray(np.cross(self.place, self.mass * self.velocity))


def whole(mass: Floats, radius: Floats, x: Floats, v: Floats, omega: Floats) -> Whole:
    """The sums over n particles: mass, radius (n,), x, v, omega (n, 3). rest: size of sum m v', zero by (A.14)."""
    m = mass[:, None]
    total = float(mass.sum())
    place, velocity = (m * x).sum(axis=0) / total, (m * v).sum(axis=0) / total
    relative = v - velocity
    return Whole(
        total, place, velocity, (m * v).sum(axis=0), np.cross(x, m * v).sum(axis=0), (0.4 * m * radius[:, None] ** 2 * omega).sum(axis=0),
        np.cross(x - place, m * relative).sum(axis=0), 0.5 * float((m * v**2).sum()), 0.5 * float((m * relative**2).sum()),
        float(np.linalg.norm((m * relative).sum(axis=0))),
    )  # fmt: skip


def crowd(seed: int) -> Particles:
    """27 spheres of unlike sizes on a grid, drifting, spinning, and falling in upon one another."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) - 1.0
    v = rng.normal(0.0, 0.3, (27, 3)) - 0.3 * grid + np.array([0.4, -0.2, 0.1])
    return spheres(50.0 + 2.4 * RADIUS * grid, rng.uniform(0.7, 1.0, 27) * RADIUS, v=v, omega=rng.normal(0.0, 60.0, (27, 3)))


def bodies(quick: bool) -> Finding:
    """(A.8)-(A.29), with friction and gravity."""
    dt, samples = 1e-5, 40 if quick else 200
    simulation = started(stage(crowd(1), dt, gravity=G, pair={"gamman": 0.5, "gammat": 0.2, "mu": 0.4}))
    rows, times = [_whole(simulation)], [0.0]
    for _ in range(samples):
        simulation.advance(25)
        rows.append(_whole(simulation))
        times.append(dt * simulation.step)
    first, g = rows[0], np.array([0.0, 0.0, -G])
    t = np.array(times)
    push = float(np.sqrt(2.0 * first.mass * first.relative))  # scale of the momentum inside
    turn = push * 5.0 * RADIUS
    fall = np.array([np.linalg.norm(r.momentum - first.momentum - first.mass * g * s) for r, s in zip(rows, t, strict=True)]) / push
    inner = np.array([np.linalg.norm(r.about_centre + r.spin - first.about_centre - first.spin) for r in rows]) / turn
    orbit = np.array([np.linalg.norm(r.about_centre - first.about_centre) for r in rows]) / turn
    split = max(float(np.linalg.norm(r.orbit - r.of_centre - r.about_centre)) / turn for r in rows)
    energy = max(abs(r.kinetic - 0.5 * r.mass * float(r.velocity @ r.velocity) - r.relative) / r.kinetic for r in rows)
    printed = abs(first.kinetic - 0.5 * first.mass * float(np.linalg.norm(first.velocity)) - first.relative) / first.kinetic
    rest = max(r.rest for r in rows) / push
    carried = _carried(rows, t, g)
    claims = (
        Claim("dP/dt is the sum of the outer forces (A.9): M g.", f"P - P(0) - M g t stays below {scientific(float(fall.max()))}.",
              float(fall.max()) < EXACT),
        Claim("The momentum about the centre is nothing (A.14).", f"At most {scientific(rest)}.", rest < EXACT),
        Claim("L = L_G + L' (A.18).", f"To {scientific(split)}.", split < EXACT),
        Claim("K = (1/2) M V_G + sum (1/2) m v'^2 (A.13).", f"Off by {printed:.2f} of K; with V_G^2, by at most {scientific(energy)}.",
              printed < EXACT, "Slip: the first term is (1/2) M V_G^2."),
        Claim("Uniform gravity turns nothing about the centre, L' does not feel it (A.28).",
              f"L', spins counted in, stays to {scientific(float(inner.max()))}.", float(inner.max()) < EXACT),
        Claim("Inner forces cannot turn the whole: dL/dt is the moment of the outer forces (A.23), (A.24).",
              f"L' of the orbits alone, (A.20), changes by up to {float(orbit.max()):.3f} of sqrt(2 M K') times the size of the crowd.",
              float(orbit.max()) < EXACT,
              "(A.23) takes F_ij along x_ij, which friction is not. What the orbits lose the spins gain: with the sum of I w counted in, which the "
              "appendix leaves out for its points, it holds (if the levers end at the contact point, see (1.19))."),
        Claim("dL/dt = X_G x M g (A.29), spins counted in.", f"L less the sum of X_G x M g dt stays to {scientific(carried)} of L.", carried < 1e-9),
        Claim("I = 2/5 m r^2 (1.3), (A.38).", f"By adding up discs, {_inertia():.8f} m r^2.", abs(_inertia() - 0.4) < 1e-6),
    )  # fmt: skip
    svg = chart(
        "what should stay", "Change of momentum and angular momentum of a colliding crowd over time",
        [Series("P - M g t", t * 1e3, fall, 0), Series("L' with spins", t * 1e3, inner, 1), Series("L' of the orbits alone", t * 1e3, orbit, 2)],
        (linear(0.0, float(t[-1]) * 1e3), decades(-16, 0)), ("time in ms", "relative"),
    )  # fmt: skip
    return Finding(
        "Appendix A: a crowd and its centre", claims,
        f"{len(simulation.id)} spheres of unlike sizes that collide under gravity, with damping, the primer's friction and levers to the contact "
        "point; velocity Verlet. The count of equations left over in A.1 should be 3n - 6, not n - 6.",
        (Figure("crowd", "Change of P - M g t, of L' with the spins, and of L' of the orbits alone.", svg),), (),
        {"time": t, "P - M g t": fall, "L' with spins": inner, "L' of the orbits": orbit},
    )  # fmt: skip


def _whole(simulation: Simulation) -> Whole:
    b = simulation.bodies
    return whole(b.mass, b.radius, b.x, b.v, b.omega)


def _carried(rows: list[Whole], t: Floats, g: Floats) -> float:
    """Largest |L - L(0) - sum of X_G x M g dt| over |L|; X_G is a parabola, so Simpson's rule between samples is exact but for Verlet's dt^2."""
    worst, gone, dt = 0.0, np.zeros(3), float(t[1] - t[0])
    first = rows[0].orbit + rows[0].spin
    for a, b in pairwise(rows):
        middle = a.place + 0.5 * dt * a.velocity + 0.125 * dt**2 * g
        gone = gone + np.cross((a.place + 4.0 * middle + b.place) / 6.0, a.mass * g) * dt
        worst = max(worst, float(np.linalg.norm(b.orbit + b.spin - first - gone) / np.linalg.norm(first)))
    return worst


def _inertia() -> float:
    """(A.38): the integral of rho r^2 2 pi r dr over discs, over m r^2; by the midpoint rule."""
    z = (np.arange(20000) + 0.5) / 10000.0 - 1.0
    return float((DENSITY * 0.5 * pi * (1.0 - z**2) ** 2).sum() * 1e-4 / (DENSITY * 4.0 / 3.0 * pi))

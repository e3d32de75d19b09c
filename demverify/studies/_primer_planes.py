"""Section 3 of the primer: planes a x + b y + c z + d = 0 that stand, move and turn."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from demverify.report.axes import linear, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.report.pictures import BOTTOM, LEFT, RIGHT, TOP
from demverify.studies import Claim, Figure, Finding
from demverify.studies._primer_scenes import KN, MASS, RADIUS, G, law, scene, spheres, started

if TYPE_CHECKING:
    from demsolver import Particles, Plane, Simulation
    from demverify.frames import Floats



def planes(quick: bool) -> Finding:
    """(3.1)-(3.3), "mind the velocity and the rotation of the wall"."""
    distance, offset = _distances(20 if quick else 200)
    thrown, driven = _thrown()
    table = 5.0
    t, x, v = _turntable(table, 40 if quick else 160)
    rate = float(np.polyfit(t, np.unwrap(np.arctan2(v[:, 1], v[:, 0])), 1)[0])
    after = _after()
    claims = (
        Claim("delta = {|a x + b y + c z + d|/sqrt(a^2 + b^2 + c^2) - r} n (3.1).",
              f"Forces on spheres at random planes, from both sides, are kn times that to {scientific(distance)} of kn r.", distance < 1e-11),
        Claim("d = a x0 + b y0 + c z0 for the plane through x0 (3.3).",
              f"Of spheres laid on such planes {offset[0]:.0%} feel them with that d, {offset[1]:.0%} with d = -(a x0 + b y0 + c z0).",
              offset[0] == 1.0, "Slip: (3.5), where -a X - b Y - c Z = d, has the right sign."),
        Claim("A wall that moves with V: vn is relative to it.",
              f"An elastic sphere at rest is thrown off with {thrown:.6f} V, and the wall's work is {driven:.6f} of 2 m V^2 (`driven` of the energy "
              "budget).", abs(thrown - 2.0) < 1e-4 and abs(driven - 1.0) < 1e-4),
        Claim("A wall that turns: vt is relative to V + w x r at the contact point. A ball rolling on a turntable goes round with 2/7 of its rate.",
              f"{rate / table:.5f}; 2/7 = {2.0 / 7.0:.5f}.", abs(rate / table * 3.5 - 1.0) < 3e-3, whose="ours"),
        Claim("A plane that turns about a point that moves is after N steps where it should be.",
              f"The force on a sphere laid on it there is off by {scientific(after)} of kn r after 20,000 steps and 3.3 turns.", after < 1e-8,
              whose="ours"),
    )  # fmt: skip
    low, high = -0.02, 1.05 * float(x[:, 1].max())
    half = 0.5 * (high - low) * (RIGHT - LEFT) / (BOTTOM - TOP)  # so that a circle looks like one
    svg = chart(
        "a ball on a turntable", "Track of a ball that rolls on a turntable: a circle",
        [Series("track", x[:, 0], x[:, 1], 0), Series("start", x[:1, 0], x[:1, 1], 1, "marks")], (linear(-half, half), linear(low, high)),
        ("x in m", "y in m"), [Rule("axis of the table", np.zeros(2), np.array([-0.01, 0.01]))],
    )  # fmt: skip
    return Finding(
        "Section 3: walls", claims,
        "In decks of the native engine: fix wall/gran ... plane A B C D [velocity VX VY VZ] [rotate PX PY PZ WX WY WZ]. The ball on the turntable is "
        "held by a stiff tangential spring (that of LAMMPS), for the primer's creeps.",
        (Figure("turntable", "Track of a ball on a table turning with 5 1/s; it goes round with 2/7 of that.", svg),), (),
        {"rate over the table's": rate / table, "track": x},
    )  # fmt: skip


def _met(plane: Plane, ball: Particles, dt: float = 1e-5, *, held: bool = False, gravity: float = 0.0, **given: Any) -> Simulation:
    """A ball, held at its place or free, and a plane that moves: one form of scene, so one compiled loop for all of this."""
    one = scene(ball, dt, walls=[(plane, law((1,), friction="rotated_history", **given))], gravity=(0.0, 0.0, -gravity))
    return started(replace(one, integrate=()) if held else one, budget=True)


def _distances(count: int) -> tuple[float, tuple[float, float]]:
    """Largest error of the force, over kn r; and the shares of spheres that feel a plane with the printed and the mended d."""
    from demsolver import Plane

    rng, worst, felt = np.random.default_rng(2), 0.0, np.zeros(2)
    for _ in range(count):
        normal, point = rng.normal(size=3) * 10.0 ** rng.uniform(-3, 3), rng.uniform(-0.5, 0.5, 3)
        unit, side = normal / np.linalg.norm(normal), float(rng.choice([-1.0, 1.0]))
        at = point + side * rng.uniform(0.5, 0.99) * RADIUS * unit
        a, b, c = (float(part) for part in normal)
        for k, d in enumerate((float(normal @ point), -float(normal @ point))):
            force = _met(Plane((a, b, c), d, (0.0, 0.0, 1.0)), spheres(at), held=True).bodies.force[0]  # its motion is not felt before it moves
            felt[k] += bool(force.any())
        gap = abs(float(at @ normal) - float(normal @ point)) / float(np.linalg.norm(normal))
        worst = max(worst, float(np.abs(force - KN * (RADIUS - gap) * side * unit).max()) / (KN * RADIUS))
    return worst, (float(felt[0] / count), float(felt[1] / count))


def _thrown() -> tuple[float, float]:
    """Speed over that of the plane, and its work over 2 m V^2, of a sphere hit by a plane."""
    from demsolver import Plane

    speed, dt = 0.2, 1e-3 * pi * float(np.sqrt(MASS / KN))
    plane = Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, 0.0, speed))
    simulation = _met(plane, spheres([0.0, 0.0, (1.0 + 1e-6) * RADIUS]), dt)
    simulation.advance(1500)
    return float(simulation.bodies.v[0, 2]) / speed, simulation.energy_budget().driven / (2.0 * MASS * speed**2)


def _turntable(rate: float, samples: int) -> tuple[Floats, Floats, Floats]:
    """Times (k,), places and velocities (k, 2) of a ball that rolls on a plane turning about z, over a round of its own."""
    from demsolver import Plane

    table = Plane((0.0, 0.0, 1.0), 0.0, omega=(0.0, 0.0, rate))
    start, v = np.array([0.1, 0.05, RADIUS - MASS * G / KN]), np.array([0.15, 0.0, 0.0])
    spin = np.cross([0.0, 0.0, 1.0], v - np.cross([0.0, 0.0, rate], start)) / RADIUS
    ball = spheres(start, v=v, omega=spin)
    simulation = _met(table, ball, 2e-5, gravity=G, mu=10.0, shear_stiffness=KN, gammat=1.0, gamman=1.0)
    round_, x, speeds = 2.0 * pi / (2.0 / 7.0 * rate), [], []
    every = round(round_ / 2e-5 / samples)
    for _ in range(samples + 1):
        x.append(simulation.bodies.x[0, :2].copy())
        speeds.append(simulation.bodies.v[0, :2].copy())
        simulation.advance(every)
    return np.arange(0.0, samples + 1.0) * (2e-5 * every), np.array(x), np.array(speeds)


def _after() -> float:
    """Error of the force on a sphere laid on a plane that has moved and turned, over kn r."""
    from demsolver import Plane
    from demsolver.shapes.rotation import matrix

    dt, steps = 1e-4, 20_000
    normal, point, pivot = np.array([0.3, -0.5, 1.0]), np.array([0.01, 0.03, 0.02]), np.array([0.05, 0.02, -0.01])
    velocity, omega = np.array([0.1, 0.05, -0.02]), np.array([4.0, -8.0, 5.0])
    speed, time = float(np.linalg.norm(omega)), steps * dt
    turn = matrix(np.array([[np.cos(0.5 * speed * time), *(np.sin(0.5 * speed * time) * omega / speed)]]))[0]
    later, unit = pivot + time * velocity + turn @ (point - pivot), turn @ normal / np.linalg.norm(normal)

    def three(values: Floats) -> tuple[float, float, float]:
        x, y, z = (float(value) for value in values)
        return x, y, z

    plane = Plane(three(normal), -float(normal @ point), three(velocity), three(omega), three(pivot))
    simulation = _met(plane, spheres(later + 0.7 * RADIUS * unit), dt, held=True)
    simulation.advance(steps)
    force = simulation.bodies.force[0]
    return float(np.abs(force - 0.3 * KN * RADIUS * unit).max()) / (KN * RADIUS)

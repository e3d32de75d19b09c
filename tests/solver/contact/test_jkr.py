"""JKR: exact points of its curve, its limits, and contacts that go on beyond touch and snap off."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import Box, Neighbor, NveSphere, Particles, Scene, Simulation, Slab, Wall
from demsolver.contact import normal_hertz, normal_jkr
from demsolver.reference import forces
from tests.support.laws import contact_law
from tests.support.scenes import spheres

RADIUS, YEFF, GAMMA = 0.005, 1e7, 1.0
REFF = RADIUS / 2
GAP = normal_jkr.reach(REFF, YEFF, GAMMA)
PULL = 3.0 * pi * GAMMA * REFF
LAW = contact_law(normal="jkr", friction="none", values={"yeff": YEFF, "surface_energy": GAMMA})
OPEN = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff",) * 3)

strong = st.tuples(st.floats(1e-4, 1e-1), st.floats(1e5, 1e11), st.floats(-0.999, 1e3)).map(
    lambda x: (x[0], x[1], 1e-6 * x[0] * x[1], x[2])  # reff, yeff, surface energy; overlap in gaps
)


def force(overlap: float, reff: float = REFF, yeff: float = YEFF, gamma: float = GAMMA) -> float:
    """Normal force at an overlap."""
    return normal_jkr.force(normal_jkr.contact_radius(overlap, reff, yeff, gamma), reff, yeff, gamma)


def energy(overlap: float) -> float:
    """Stored energy at an overlap."""
    return normal_jkr.energy(normal_jkr.contact_radius(overlap, REFF, YEFF, GAMMA), REFF, YEFF, GAMMA)


@given(strong)
def test_the_contact_radius_solves_its_equation(numbers: tuple[float, float, float, float]) -> None:
    """Law: overlap = a^2/R - 2 sqrt(pi g a/E*), on the branch where the overlap grows with a."""
    reff, yeff, gamma, gaps = numbers
    overlap = gaps * normal_jkr.reach(reff, yeff, gamma)
    a = normal_jkr.contact_radius(overlap, reff, yeff, gamma)
    half = sqrt(pi * gamma * a / yeff)
    # the closed form loses digits where adhesion is weak: 1e-11 of the overlap at a thousandth of it
    assert a * a / reff - 2.0 * half == pytest.approx(overlap, rel=1e-11, abs=1e-11 * a * a / reff)
    assert 2.0 * a / reff > half / a


@given(strong)
def test_the_pull_is_greatest_where_the_contact_ends(numbers: tuple[float, float, float, float]) -> None:
    """Law: F = -3 pi g R at the gap a^2/(3 R), a^3 = 9 pi g R^2/(4 E*); nowhere is the pull greater."""
    reff, yeff, gamma, gaps = numbers
    gap = normal_jkr.reach(reff, yeff, gamma)
    greatest = -3.0 * pi * gamma * reff
    assert force(-gap, reff, yeff, gamma) == pytest.approx(greatest, rel=1e-12)
    assert force(gaps * gap, reff, yeff, gamma) >= greatest * (1.0 + 1e-12)
    end = normal_jkr.contact_radius(-gap, reff, yeff, gamma)
    # at the end of its range the root is not double: a is as exact as the gap
    assert end == pytest.approx((2.25 * pi * gamma * reff**2 / yeff) ** (1 / 3), rel=1e-12)
    assert gap == pytest.approx(end**2 / (3.0 * reff), rel=1e-12)


def test_first_touch() -> None:
    """Law: at overlap 0 the pull is 8/9 of the greatest, a^3 = 4 pi g R^2/E*, and nothing is stored."""
    first = (4.0 * pi * GAMMA * REFF**2 / YEFF) ** (1 / 3)
    assert normal_jkr.contact_radius(0.0, REFF, YEFF, GAMMA) == pytest.approx(first, rel=1e-14)
    assert force(0.0) == pytest.approx(-8.0 / 3.0 * pi * GAMMA * REFF, rel=1e-14)
    assert energy(0.0) == pytest.approx(0.0, abs=1e-15 * PULL * GAP)


def test_energy_to_snap_off() -> None:
    """Law: from touch to the end the pull takes pi g a0^2 [6/5 - 64/45 (9/16)^(5/3)], which is the integral of the force."""
    first = (4.0 * pi * GAMMA * REFF**2 / YEFF) ** (2 / 3)
    expected = pi * GAMMA * first * (1.2 - 64.0 / 45.0 * (9.0 / 16.0) ** (5 / 3))
    assert energy(-GAP) == pytest.approx(expected, rel=1e-12)
    nodes, weights = np.polynomial.legendre.leggauss(40)  # the force is smooth here, F' = 0 at the end
    work = -0.5 * GAP * sum(w * force(0.5 * GAP * (x - 1.0)) for x, w in zip(nodes, weights, strict=True))
    assert work == pytest.approx(expected, rel=1e-12)


def test_without_adhesion_it_is_hertz() -> None:
    """Law: the difference to Hertz falls with g, and is nothing at g = 0, whatever the overlap."""
    overlap = 5e-5
    hertz = normal_hertz.force(overlap, sqrt(REFF * overlap), 4.0 / 3.0 * YEFF)
    off = [abs(force(overlap, gamma=g) / hertz - 1.0) for g in (1e-2, 1e-3, 1e-4)]
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.1)
    assert off[1] / off[2] == pytest.approx(10.0, rel=0.1)
    assert force(overlap, gamma=0.0) == pytest.approx(hertz, rel=1e-14)
    assert normal_jkr.reach(REFF, YEFF, 0.0) == 0.0
    assert force(0.0, gamma=0.0) == 0.0


def test_friction_feels_the_pull() -> None:
    """Law: friction's limit is mu |F + 2 (3 pi g R)|, F without damping: at the end of the contact mu 3 pi g R is left."""
    for overlap in (-GAP, 0.0, 5e-5):
        f = force(overlap)
        assert normal_jkr.critical_force(f, REFF, GAMMA) == pytest.approx(abs(f + 2.0 * PULL), rel=1e-14)
    assert normal_jkr.critical_force(force(-GAP), REFF, GAMMA) == pytest.approx(PULL, rel=1e-12)


def pair(overlap: float, speed: float, dt: float, *, at: float = 0.0, box: Box = OPEN) -> Scene:
    """Two spheres on the x axis that approach each other with `speed`."""
    x = np.array([[at, 0.0, 0.0], [at + 2 * RADIUS - overlap, 0.0, 0.0]])
    p = spheres(x, np.full(2, RADIUS), v=np.array([[speed / 2, 0.0, 0.0], [-speed / 2, 0.0, 0.0]]))
    return Scene(box, p, 1, dt, pair=LAW, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


def started(scene: Scene, *, budget: bool = False) -> Simulation:
    """A simulation that is set up."""
    simulation = Simulation(scene, budget=budget)
    simulation.setup()
    return simulation


def against_wall(speed: float, dt: float) -> Scene:
    """A sphere about to touch a wall at x = 0."""
    p = spheres(np.array([[RADIUS + 1e-9, 0.0, 0.0]]), np.array([RADIUS]), v=np.array([[-speed, 0.0, 0.0]]))
    law = contact_law((1,), normal="jkr", friction="none", values={"yeff": YEFF, "surface_energy": GAMMA})
    return Scene(OPEN, p, 1, dt, walls=(Wall("wall", Slab(0, lo=0.0), law),), integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


@pytest.mark.parametrize("partner", ["sphere", "wall"])
def test_a_bounce_loses_what_it_takes_to_snap_off(partner: str) -> None:
    """Law: undamped, they part with the energy they had, less that of the snap; the budget counts it as damped, once."""
    mass = float(spheres(np.zeros((1, 3)), np.array([RADIUS])).mass[0])
    reff, meff = (REFF, mass / 2) if partner == "sphere" else (RADIUS, mass)
    gap = normal_jkr.reach(reff, YEFF, GAMMA)
    snap = normal_jkr.energy(normal_jkr.contact_radius(-gap, reff, YEFF, GAMMA), reff, YEFF, GAMMA)
    speed = sqrt(8.0 * snap / meff)  # four times what it takes
    dt = gap / speed / 200
    simulation = started(pair(-1e-9, speed, dt) if partner == "sphere" else against_wall(speed, dt), budget=True)
    start = simulation.energy_budget()
    simulation.advance(40_000)
    end = simulation.energy_budget()
    assert end.elastic_normal == 0.0
    # the force jumps at touch and at the end: each costs at most F v dt/2, here a 400th of F gap
    jumps = 3.0 * pi * GAMMA * reff * gap / 200
    assert end.damped == pytest.approx(snap, rel=1e-12)
    assert end.kinetic == pytest.approx(start.kinetic - snap, abs=jumps)
    assert end.total == pytest.approx(start.total, abs=jumps)


def test_slow_spheres_stick() -> None:
    """Law: spheres that bring less energy than the snap takes never part, though they swing far beyond touch."""
    snap, meff = energy(-GAP), spheres(np.zeros((1, 3)), np.array([RADIUS])).mass[0] / 2
    speed = sqrt(2.0 * 0.8 * snap / meff)
    simulation = started(pair(-1e-9, speed, GAP / speed / 200))
    least = 0.0
    for _ in range(200):
        simulation.advance(100)
        least = min(least, 2 * RADIUS - float(simulation.bodies.x[1, 0] - simulation.bodies.x[0, 0]))
        assert simulation.pairs.touching.tolist() == [1]
    assert -GAP < least < -0.5 * GAP


def test_no_pull_before_touch() -> None:
    """Law: spheres nearer than the gap that have not touched feel nothing; those that have, do."""
    fresh = started(pair(-0.5 * GAP, -0.1, 1e-7))
    assert not fresh.bodies.force.any()
    parting = started(pair(1e-9, -0.1, 0.5 * GAP / 0.1 / 10))
    parting.advance(10)
    assert parting.bodies.force[0, 0] > 0.5 * PULL


@pytest.mark.parametrize("boundary", ["ff", "pp"])
def test_a_stretched_contact_outlives_the_list(boundary: str) -> None:
    """Law: a contact just before its end stands in a list that is renewed every step with hardly any skin, also across a periodic face,
    and pulls as one in a list that never is."""
    box = replace(OPEN, boundary=(boundary, "ff", "ff"))
    forces_of = []
    for neighbor, at in ((Neighbor(1e-9, check=False), 0.1 - RADIUS), (Neighbor(5e-3, every=10**6, check=False), 0.0)):
        scene = pair(1e-9, -0.1, 0.097 * GAP / 0.1, at=at if boundary == "pp" else 0.0, box=box)
        simulation = started(replace(scene, neighbor=neighbor))
        simulation.advance(10)
        forces_of.append(simulation.bodies.force.copy())
    assert forces_of[0][0, 0] > 0.99 * PULL
    # positions near the face have an error of 1e-17 m, of a gap of 1e-6 m
    assert np.abs(forces_of[0] - forces_of[1]).max() < 1e-9 * PULL


def test_the_compiled_loop_is_the_plain_sum() -> None:
    """Law: a sticky heap on a sticky floor, coming apart in part, moves as the plain sum has it, gaps and all."""
    rng = np.random.default_rng(3)
    law = {
        "normal": "jkr", "damping": "viscoelastic", "tangential_stiffness": "mindlin", "tangential_damping": "scaled",
        "friction": "mindlin_rescale_force", "rolling": "sds", "twisting": "marshall",
    }  # fmt: skip
    numbers = {"yeff": YEFF, "surface_energy": 5.0, "gamman": 1e5}
    x = np.array([(i, j, k) for i in range(3) for j in range(3) for k in range(2)], float) * 0.01 + rng.uniform(-2e-5, 2e-5, (18, 3))
    x[:, 2] += RADIUS - 1e-5
    p = spheres(x, np.full(18, RADIUS), v=rng.normal(0.0, 0.3, (18, 3)), omega=rng.normal(0.0, 40.0, (18, 3)))
    sticky = {shape: contact_law(shape, values=numbers, **law) for shape in ((1, 1), (1,))}
    wall = Wall("floor", Slab(2, lo=0.0), sticky[1,])
    scene = Scene(OPEN, p, 1, 2e-6, pair=sticky[1, 1], walls=(wall,), integrate=(NveSphere(),), neighbor=Neighbor(1e-3))
    simulation = started(scene)
    simulation.advance(40)
    x, v, omega, torn = by_hand(scene, p, 40)
    assert torn > 3
    # rounding grows over 40 steps; a wrong rule is off by 1e-6 and more
    assert np.abs(simulation.bodies.x - x).max() < 1e-12 * 0.05
    assert np.abs(simulation.bodies.v - v).max() < 1e-10
    assert np.abs(simulation.bodies.omega - omega).max() < 1e-8


def by_hand(scene: Scene, p: Particles, steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Velocity Verlet with the plain sum: x, v, omega (n, 3), and how many contacts have ended on the way."""
    x, v, w, history, torn, dt = p.x.copy(), p.v.copy(), p.omega.copy(), {}, 0, scene.timestep
    kick, spin = dt / 2 / p.mass[:, None], dt / 2 / (0.4 * p.mass * p.radius**2)[:, None]
    f, t, history = forces(scene, x, v, w, history, False)
    for _ in range(steps):
        v, w = v + kick * f, w + spin * t
        x = x + dt * v
        before = set(history)
        f, t, history = forces(scene, x, v, w, history, True)
        torn += len(before - set(history))
        v, w = v + kick * f, w + spin * t
    return x, v, w, torn

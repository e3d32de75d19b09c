"""For every contact law of the folder the loop is the plain sum, and the account of energy closes, on 20 random scenes each."""

from __future__ import annotations

from dataclasses import replace
from math import log, pi, sqrt

import numpy as np
import pytest

from demsolver import Box, ContactLaw, EnergyBudget, EulerSphere, Gravity, Neighbor, NveSphere, Scene, Simulation, Slab, Wall, contact
from demsolver.reference import forces
from tests.support.laws import EVERY, STEP_LAWS, contact_law, every_law
from tests.support.scenes import spheres

CONTACT_TIME = pi * sqrt(6.5e-4 / 1e4)  # of two 5 mm spheres with 1e4 N/m
SEEDS = range(20)
INTEGRATED = [(family, name) for family, name in EVERY if name not in (*STEP_LAWS, "discrete_gradient")]


def cluster(law: ContactLaw, seed: int, per_contact: int) -> Scene:
    """Eight spheres thrown together under gravity, some overlapping; a contact lasts `per_contact` steps."""
    rng = np.random.default_rng(seed)
    x = np.array([(i, j, k) for i in range(2) for j in range(2) for k in range(2)], float) * 0.01 + rng.uniform(-2e-4, 2e-4, (8, 3))
    p = spheres(x, rng.uniform(0.0045, 0.0055, 8), v=rng.normal(0.0, 0.1, (8, 3)), omega=rng.normal(0.0, 20.0, (8, 3)))
    return Scene(
        Box(np.full(3, -1.0), np.full(3, 1.0), ("ff",) * 3), p, 1, CONTACT_TIME / per_contact, pair=law, forces=(Gravity((0.0, 0.0, -9.81)),),
        integrate=(NveSphere(),), neighbor=Neighbor(0.02),
    )  # fmt: skip


def account(scene: Scene, steps: int) -> tuple[float, EnergyBudget]:
    """Drift of the total over the energy in motion and contacts at the start; the last account."""
    simulation = Simulation(scene, budget=True, on_instability="off")
    simulation.setup()
    first = simulation.energy_budget()
    simulation.advance(steps)
    last = simulation.energy_budget()
    return (last.total - first.total) / (first.kinetic + first.rotational + first.elastic), last


@pytest.mark.parametrize(("family", "name"), INTEGRATED)
def test_the_account_closes_with_the_square_of_the_step(family: contact.Family, name: str) -> None:
    """Law: over four contact times total plus dissipated drifts as dt^2: order 1.6 or more between 50 and 200 steps a contact (rms of 20 scenes)."""
    law = every_law(family, name)
    coarse, fine = (np.sqrt(np.mean([account(cluster(law, seed, n), 4 * n)[0] ** 2 for seed in SEEDS])) for n in (50, 200))
    assert fine < 2e-4  # a parabola for each arc of the contact: (pi/200)^2 = 2.5e-4, of which a part
    assert log(coarse / fine, 4) > 1.6


@pytest.mark.parametrize(("family", "name"), INTEGRATED)
def test_nothing_is_dissipated_that_was_not_there(family: contact.Family, name: str) -> None:
    """Law: what damping, friction and rolling took in a random scene is not negative; of a law that stores nothing but the spring, zero."""
    _, last = account(cluster(every_law(family, name), 1, 200), 800)
    size = last.kinetic + last.rotational
    for taken in (last.damped, last.rubbed, last.rolled):
        assert taken > -1e-4 * size  # as the account closes
    if name in ("hertz", "hooke", "impact_hooke", "dmt"):
        assert last.damped == last.rubbed == last.rolled == 0.0


@pytest.mark.parametrize(("family", "name"), INTEGRATED)
def test_the_loop_is_the_plain_sum(family: contact.Family, name: str) -> None:
    """Law: force and torque of the compiled loop are the plain reference's to 1e-13 of the largest, at set-up and over three steps that remember."""
    scene = cluster(every_law(family, name), 3, 50)
    simulation = Simulation(scene, budget=True, on_instability="off")
    simulation.setup()
    p, dt, history = scene.particles, scene.timestep, {}
    x, v, w, mass = p.x.copy(), p.v.copy(), p.omega.copy(), p.mass[:, None]
    inertia = 0.4 * mass * p.radius[:, None] ** 2
    f = t = np.zeros_like(x)
    for step in range(4):
        if step:
            v, w = v + dt / 2 * f / mass, w + dt / 2 * t / inertia
            x = x + dt * v
            simulation.advance(1)
        f, t, history = forces(scene, x, v, w, history, step > 0)
        f = f + mass * np.array([0.0, 0.0, -9.81])
        found, size = simulation.bodies, np.abs(f).max()
        assert np.abs(found.force - f).max() <= 1e-13 * size
        assert np.abs(found.torque - t).max() <= 1e-13 * size * 0.005
        if step:
            v, w = v + dt / 2 * f / mass, w + dt / 2 * t / inertia


def test_the_implicit_spring_is_exact() -> None:
    """Law: the discrete gradient drifts by less than 1e-12 a step in every one of 20 scenes of many contacts, at 50, 5 and 1 steps a contact."""
    law = every_law("normal", "discrete_gradient")
    for per_contact in (50, 5, 1):
        assert max(abs(account(cluster(law, seed, per_contact), 50)[0]) for seed in SEEDS) < 50 * 1e-12


def bounces(law: ContactLaw, wall: ContactLaw, seed: int, per_contact: float) -> Scene:
    """Spheres in separate lanes: some between two walls, some in pairs that meet head on. One contact at a time, no gravity; Euler."""
    rng = np.random.default_rng(seed)
    r = rng.uniform(0.003, 0.006, 8)
    lane = 0.02 * np.arange(8.0)
    x = np.stack([lane, np.zeros(8), rng.uniform(0.011, 0.018, 8)], axis=1)
    x[6:, 0] = 0.5, 0.515
    v = np.zeros((8, 3))
    v[:6, 2], v[6:, 0] = rng.uniform(0.3, 1.0, 6) * rng.choice([-1.0, 1.0], 6), (0.6, -0.4)
    x[6:, 2] = 0.0145
    r[6:] = rng.uniform(0.003, 0.0065, 2)
    return Scene(
        Box(np.full(3, -1.0), np.full(3, 1.0), ("ff",) * 3), spheres(x, r, v=v), 1, CONTACT_TIME / per_contact, pair=law,
        walls=(Wall("slit", Slab(2, 0.0, 0.03), wall),), integrate=(EulerSphere(),), neighbor=Neighbor(0.004),
    )  # fmt: skip


@pytest.mark.parametrize("name", STEP_LAWS)
@pytest.mark.parametrize("per_contact", [50.0, 10.0, 1.0])
def test_step_laws_are_exact_in_their_own_sense(name: str, per_contact: float) -> None:
    """Law: one contact at a time, semi-implicit Euler: what a step law says it took is what is gone, to less than 1e-12 a step in 20 scenes."""
    law, wall = (contact_law(shape, normal=name, friction="none") for shape in ((1, 1), (1,)))
    steps = int(20 * per_contact) + 20
    for seed in SEEDS:
        drift, last = account(bounces(law, wall, seed, per_contact), steps)
        assert abs(drift) < steps * 1e-12
        assert last.damped > 0.0


def test_the_printed_law_loses_what_the_mended_keeps() -> None:
    """Law: with e = 1 the mended model P takes nothing; as printed it takes energy from some contacts: the hole of its flow chart."""
    taken = {}
    for name in ("fujioka2006", "fujioka2006_printed"):
        law, wall = (contact_law(shape, normal=name, friction="none", values={"restitution": 1.0}) for shape in ((1, 1), (1,)))
        accounts = [account(bounces(law, wall, seed, 3.0), 80)[1] for seed in SEEDS]
        taken[name] = np.array([last.damped / last.total for last in accounts])
    assert np.abs(taken["fujioka2006"]).max() < 1e-12
    assert taken["fujioka2006_printed"].max() > 1e-3


@pytest.mark.parametrize("name", STEP_LAWS)
def test_several_contacts_at_once_are_not_exact(name: str) -> None:
    """Law: step laws see one contact at a time; where there are several the account stays finite and closes as the step gets shorter."""
    law = contact_law(normal=name, friction="none")
    scenes = [replace(cluster(law, seed, 1), integrate=(EulerSphere(),), forces=()) for seed in SEEDS]
    drifts = [[account(replace(s, timestep=CONTACT_TIME / n), 4 * n)[0] for s in scenes] for n in (20, 320)]
    coarse, fine = (float(np.sqrt(np.mean(np.square(d)))) for d in drifts)
    assert coarse > 1e-6
    assert fine < coarse / 3.0

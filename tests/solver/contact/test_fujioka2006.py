"""The model of Fujioka & Ushijima (2006), as mended and as printed: restitution, the hole of the flow chart, momentum, many contacts."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from demsolver import EulerSphere, NveSphere, Simulation
from demsolver.reference import forces
from tests.solver.contact.fujioka import STEPS, collide, head_on, law_of, on_walls, particles, scene, totals

MENDED, PRINTED, OLDER = "fujioka2006", "fujioka2006_printed", "fujioka2005"
ALL = (MENDED, PRINTED, OLDER)

stiffnesses = st.floats(-3.0, 2.0).map(lambda power: 10.0**power)
restitutions = st.floats(0.05, 1.0)
phases = st.floats(1e-6, 1.0)
EXACT = 1e-12  # a few hundred roundings; at a = 100, e = 0.05 the corrected overlap is 1/200 of the impact's, and its rounding weighs that much more


def lost_by_the_hole(a: float, s: float) -> float:
    """Share of u^2 + a d^2 that (21) loses where it ends the contact: a d'^2, d' = [d - sqrt(a^2 d^2 + (1 + a) u^2)]/(1 + a)."""
    return a * (1.0 - sqrt(a * a + (1.0 + a) * s * s)) ** 2 / ((1.0 + a) ** 2 * (s * s + a))


@settings(max_examples=300, deadline=None)
@given(a=stiffnesses, e=restitutions, phase=phases)
def test_restitution_is_exact(a: float, e: float, phase: float) -> None:
    """Law: the mended model gives back e of the approach speed, to rounding, whatever the stiffness and the phase of the contact."""
    assert collide(MENDED, a, e, phase).restitution == pytest.approx(e, rel=EXACT)


@pytest.mark.parametrize("name", ALL)
@settings(max_examples=200, deadline=None)
@given(a=stiffnesses, e=restitutions, phase=phases)
def test_the_account_of_one_contact_closes(name: str, a: float, e: float, phase: float) -> None:
    """Law: kinetic energy + energy() + what was taken so far is the same after every step of a contact, and the taken part is never negative."""
    account = collide(name, a, e, phase).account
    assert np.abs(np.array(account) - 0.5).max() <= EXACT
    law = law_of(name)
    assert all(law.step(d, -u, 1.0, 1.0, a, e)[2] >= 0.0 for d in (1e-3, phase, 1.0) for u in (-1.0, 0.0, 0.3, 1.0, 5.0))


def test_a_contact_takes_three_steps() -> None:
    """Law: at a = (pi/10)^2, where a linear contact lasts ten steps, the model's lasts two or three, and states pass modes 1, 2 and 4 or 3."""
    for phase in np.linspace(1e-6, 1.0, 101):
        found = collide(MENDED, (np.pi / 10) ** 2, 0.7, float(phase))
        assert found.steps in (2, 3)
        assert found.states[0] >= 1.0 > found.states[1] > 0.0
        assert all(s < 0.0 for s in found.states[2:])


@settings(max_examples=300, deadline=None)
@given(a=stiffnesses, e=restitutions, phase=phases)
def test_the_printed_model_loses_energy_in_the_hole_and_nowhere_else(a: float, e: float, phase: float) -> None:
    """Law: printed, restitution is e but where a state of 0 < s < 1 has a^2 + (1 + a) s^2 >= 1; there the share of lost_by_the_hole is gone."""
    found = collide(PRINTED, a, e, phase)
    s = found.states[1]
    assume(abs(a * a + (1.0 + a) * s * s - 1.0) > 1e-9)  # at the border either root ends the contact with nothing lost
    lost = lost_by_the_hole(a, s) if a * a + (1.0 + a) * s * s > 1.0 else 0.0
    # What is left may be little of what there was: its relative rounding grows by 1/(1 - lost), at most some 50 here.
    assert found.restitution == pytest.approx(e * sqrt(1.0 - lost), rel=50 * EXACT)
    assert (found.steps == 2) == (lost > 0.0)


@pytest.mark.parametrize(("a", "error"), [((np.pi / 10) ** 2, 1.04e-4), (0.5, 7.76e-3), (1.0, 3.41e-2), (10.0, 0.437)])
def test_how_large_the_hole_is(a: float, error: float) -> None:
    """Law: the largest error is that of s -> 1 in mode 2, a contact that just began: e sqrt(1 - a (sqrt(1 + a + a^2) - 1)^2/(1 + a)^3)."""
    worst = 1.0 - sqrt(1.0 - a * (sqrt(1.0 + a + a * a) - 1.0) ** 2 / (1.0 + a) ** 3)
    found = max(1.0 - collide(PRINTED, a, 0.7, float(phase)).restitution / 0.7 for phase in np.linspace(1e-6, 1.0, 2001))
    assert found == pytest.approx(worst, rel=1e-4)  # the nearest of 2001 phases
    assert worst == pytest.approx(error, rel=5e-3)  # three figures


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("a", [1e-6, 1e-3, 1.0, 1e4])
@pytest.mark.parametrize("e", [0.0, 0.05, 1.0])
@pytest.mark.parametrize("overlap", [0.0, 5e-324, 1e-200, 1e-9, 1.0])
def test_edges_are_finite(name: str, a: float, e: float, overlap: float) -> None:
    """Law: at no overlap or the smallest, at rest, at e = 0 and 1, soft and hard, force, shift, loss and energy are finite numbers."""
    law = law_of(name)
    for vn in (0.0, -0.0, -1e-200, 1e-200, -1e-9, -1.0, 1.0):
        numbers = (overlap, vn, 2.0, 0.5, a * 2.0 / 0.25, e)
        assert all(isfinite(value) for value in (*law.step(*numbers), law.energy(*numbers)))


@pytest.mark.parametrize("name", ALL)
def test_at_rest_a_contact_is_pushed_apart(name: str) -> None:
    """Law: u = 0 in a soft contact gives the force 2 kn d/(1 + a), the linear spring's twice over the step it needs to turn; nothing is taken."""
    force, shift, loss = law_of(name).step(1e-3, 0.0, 1.0, 0.1, 1.0, 0.7)
    assert force == pytest.approx(2e-3 / 1.01, rel=1e-15)
    assert (shift, loss) == (0.0, 0.0)


@pytest.mark.parametrize("name", [MENDED, PRINTED])
def test_a_contact_that_begins_with_exact_touch_is_lost_once(name: str) -> None:
    """Law: whether rounding puts the first touch a trace above or below zero, the contact step comes once, and restitution is e."""
    hole = 1.1e-4 if name == PRINTED else 0.0  # at a = 0.1, see test_how_large_the_hole_is
    for trace in (0.0, 1e-16, -1e-16, 1e-12, 5e-10, -5e-10, 2e-9):
        u, d = 1.0, trace
        for _ in range(6):
            force, shift, _ = law_of(name).step(d, -u, 1.0, 1.0, 0.1, 0.7) if d > 0.0 else (0.0, 0.0, 0.0)
            u -= force
            d += u - shift
        assert -u == pytest.approx(0.7, rel=EXACT + hole)


rng = np.random.default_rng(5)
A, E, PHASE = 10.0 ** rng.uniform(-3.0, 2.0, 80), rng.uniform(0.05, 1.0, 80), rng.uniform(1e-3, 1.0, 80)


@pytest.mark.parametrize("integrator", [EulerSphere(), NveSphere()])
def test_restitution_of_spheres_on_a_wall(integrator: EulerSphere | NveSphere) -> None:
    """Law: through Simulation, with either integrator, a sphere leaves a wall with e of its speed."""
    simulation = on_walls(MENDED, A, E, PHASE, integrator)
    before = -simulation.bodies.v[:, 2]
    simulation.setup()
    simulation.advance(STEPS)
    assert simulation.bodies.v[:, 2] / before == pytest.approx(E, rel=EXACT)


@pytest.mark.parametrize("integrator", [EulerSphere(), NveSphere()])
def test_restitution_of_unequal_pairs(integrator: EulerSphere | NveSphere) -> None:
    """Law: two unequal spheres head on part with e of their approach speed; momentum stays, and the shift moves no centre of mass."""
    simulation = head_on(MENDED, A, E, PHASE, integrator)
    b = simulation.bodies
    mass, before = b.mass.reshape(-1, 2), b.v[::2, 0].copy()
    momentum = (mass * b.v[:, 0].reshape(-1, 2)).sum(axis=1)
    centre = (mass * b.x[:, 0].reshape(-1, 2)).sum(axis=1)
    simulation.setup()
    simulation.advance(STEPS)
    b = simulation.bodies
    assert (b.v[1::2, 0] - b.v[::2, 0]) / before == pytest.approx(E, rel=EXACT)
    assert (mass * b.v[:, 0].reshape(-1, 2)).sum(axis=1) == pytest.approx(momentum, rel=EXACT)
    moved = (mass * b.x[:, 0].reshape(-1, 2)).sum(axis=1) - centre
    assert moved == pytest.approx(momentum * STEPS * simulation.scene.timestep, rel=EXACT)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("collisions", [on_walls, head_on])
def test_the_budget_closes_at_every_step(name: str, collisions: Callable[..., Simulation]) -> None:
    """Law: with semi-implicit Euler, whose velocity is the approach of the model, held and lost energy add up after every single step."""
    total = totals(collisions(name, A, E, PHASE, EulerSphere()), STEPS)
    assert np.abs(total / total[0] - 1.0).max() <= EXACT


def cluster(name: str, dt: float, *, floor: bool) -> Simulation:
    """Thirty unequal spheres that are pushed together, several contacts each; on a floor under gravity, or free."""
    place = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3), axis=-1).reshape(-1, 3)
    x = np.vstack([grid * 1.9 + place.uniform(-0.05, 0.05, (27, 3)), 7.0 * np.eye(3) + 2.0])
    x[:, 2] += 1.02
    radius = place.uniform(0.85, 1.0, len(x))
    p = particles(np.ones(len(x)), x, np.vstack([0.57 - 0.57 * grid, -2.0 * np.eye(3)]), radius, radius**3)
    coefficients = np.full((1, 1), 1e3), np.full((1, 1), 0.7)
    where = {"gravity": 9.8, "floor": 0.0} if floor else {"gravity": 0.0, "floor": -1000.0}
    return Simulation(scene(name, p, coefficients, dt, NveSphere(), **where), budget=True, on_instability="off")


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("dt", [1e-3, 1e-2, 3e-2])
@pytest.mark.parametrize("floor", [True, False])
def test_many_contacts_at_once(name: str, dt: float, floor: bool) -> None:
    """Law: with several contacts a sphere and soft or hard steps (a = 5e-4 to 0.5 and more) nothing blows up, and free momentum stays."""
    simulation = cluster(name, dt, floor=floor)
    b = simulation.bodies
    momentum, highest = b.mass @ b.v, 0.5 * b.mass @ (b.v**2).sum(axis=1) + floor * 9.8 * b.mass @ b.x[:, 2]
    simulation.setup()
    simulation.advance(int(4.0 / dt))
    b = simulation.bodies
    assert 0.5 * b.mass @ (b.v**2).sum(axis=1) < highest
    if not floor:
        assert np.abs(b.mass @ b.v - momentum).max() <= 1e-12 * b.mass @ np.abs(b.v).max(axis=1)


@pytest.mark.parametrize("name", ALL)
def test_the_loop_equals_the_reference(name: str) -> None:
    """Law: the compiled loop applies the force that the plain reference finds for the same state."""
    simulation = cluster(name, 1e-2, floor=True)
    simulation.setup()
    simulation.advance(40)
    b, before = simulation.bodies, simulation.particles()
    plain, _, _ = forces(simulation.scene, before.x, before.v, before.omega, {}, False)
    plain[:, 2] -= 9.8 * b.mass
    simulation.setup()  # the reference was given whole velocities too
    assert np.abs(simulation.bodies.force - plain).max() <= 1e-12 * np.abs(plain).max()


"""Rolling spring, dashpot and slider: its limits, what it takes, and that no side of a contact is special."""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from demsolver import Box, ContactLaw, Freeze, Gravity, Neighbor, NveSphere, Scene, Simulation, Slab, Wall
from demsolver.contact import rolling_sds
from tests.support.calls import call, exchanged, numbers, spread, unit, vectors
from tests.support.laws import contact_law
from tests.support.scenes import spheres

Floats = NDArray[np.float64]
REFF, K, GAMMA, MU = 0.0025, 3e3, 0.1, 0.2
UP = np.array([0.0, 0.0, 1.0])


def known(w: Floats, rolled: Floats, **changes: Any) -> dict[str, Any]:
    """A contact along z pressed with 3 N."""
    law = {"rolling_stiffness": K, "rolling_damping": GAMMA, "rolling_friction": MU}
    held = {"critical_force": 3.0, "reff": REFF, "dt": 1e-5, "advance": True}
    return law | held | spread("n", UP) | spread("w", w) | spread("rolled_", rolled) | changes


def torque(one: dict[str, Any]) -> tuple[Floats, Floats]:
    """Torque (3,) and new rolling displacement (3,)."""
    result = np.array(call(rolling_sds.torque, one))
    return result[:3], result[3:]


def test_a_stuck_contact_is_a_torsion_spring() -> None:
    """Law: turned by an angle t about an axis in the tangent plane, a sphere feels -k reff^2 t, and the dashpot's -gamma reff^2 w."""
    found, rolled = torque(known(np.array([0.0, 4.0, 0.0]), np.zeros(3)))
    assert found == pytest.approx([0.0, -(REFF**2) * (K * 4.0 * 1e-5 + GAMMA * 4.0), 0.0], rel=1e-12)
    assert rolled == pytest.approx([REFF * 4.0 * 1e-5, 0.0, 0.0], rel=1e-12)  # w x n = (4, 0, 0)


def test_rolling_on_feels_a_constant_torque() -> None:
    """Law: a contact that rolls on and on ends at the torque mu reff Fn against the spin, whatever the spring."""
    rolled, w = np.zeros(3), np.array([30.0, -40.0, 0.0])
    for _ in range(2000):
        found, rolled = torque(known(w, rolled, rolling_damping=0.0))
    assert found == pytest.approx(-MU * REFF * 3.0 * w / 50.0, rel=1e-12)


def test_twist_is_not_rolling() -> None:
    """Law: spin along the contact normal neither moves the spring nor meets a torque."""
    found, rolled = torque(known(np.array([0.0, 0.0, 50.0]), np.zeros(3)))
    assert not found.any()
    assert not rolled.any()


def test_any_contact_normal() -> None:
    """Law: with v = reff w x n, the torque is reff n x (-k (r + dt v) - gamma v), whatever n."""
    n, w = unit(np.array([1.0, -2.0, 0.5])), np.array([0.3, 0.1, 0.7])
    r = 1e-6 * np.cross(n, np.array([1.0, 1.0, 0.0]))
    v = REFF * np.cross(w, n)
    found, rolled = torque(known(w, r, **spread("n", n)))
    assert rolled == pytest.approx(r + 1e-5 * v, rel=1e-12)
    assert found == pytest.approx(REFF * np.cross(n, -K * rolled - GAMMA * v), rel=1e-12)


@st.composite
def contacts(draw: st.DrawFn) -> dict[str, Any]:
    """Rolling and stuck contacts; the spring may lean out of the tangent plane."""
    n, w, r = draw(vectors), draw(vectors), draw(vectors)
    assume(np.linalg.norm(n) > 0.1)
    size = draw(st.sampled_from([0.0, 1e-5, 1e-3]))
    changes = {"critical_force": draw(numbers(0.0, 5.0)), "rolling_damping": draw(st.sampled_from([0.0, 0.1, 100.0])), "advance": draw(st.booleans())}
    return known(50.0 * w, size * r, **spread("n", unit(n)), **changes)


@settings(deadline=None)
@given(contacts())
def test_the_torque_has_a_limit(one: dict[str, Any]) -> None:
    """Law: |torque| <= mu reff Fn, and it has no part along n; set-up leaves the spring as it is."""
    found, rolled = torque(one)
    limit = MU * REFF * one["critical_force"]
    assert np.linalg.norm(found) <= limit * (1.0 + 1e-12)
    assert abs(found @ [one["nx"], one["ny"], one["nz"]]) <= 1e-12 * limit
    if not one["advance"]:
        assert np.array_equal(rolled, [one["rolled_x"], one["rolled_y"], one["rolled_z"]])


@settings(deadline=None)
@given(contacts())
def test_seen_from_the_partner(one: dict[str, Any]) -> None:
    """Law: exchanged particles feel the opposite torque and keep the very same spring: w and n both turn, w x n does not."""
    (mine, rolled), (theirs, same) = torque(one), torque(exchanged(one, rolling_sds.MEMORY))
    assert np.array_equal(mine, -theirs)
    assert np.array_equal(rolled, same)


@settings(deadline=None)
@given(st.lists(vectors, min_size=1, max_size=40))
def test_without_a_dashpot_it_only_takes(spins: list[Floats]) -> None:
    """Law: led about any way in the tangent plane, it holds no more than was put in; work by the trapezoid rule, exact for the spring."""
    rolled, work, scale = np.zeros(3), 0.0, 0.0
    for spin in spins:
        w = 400.0 * np.array([spin[0], spin[1], 0.0])
        one = known(w, rolled, rolling_damping=0.0)
        last = -REFF * K * np.cross(UP, rolled)  # the spring's torque at the begin of the step, reff n x (-k r)
        found, rolled = torque(one)
        work -= 0.5e-5 * float((last + found) @ w)
        held = call(rolling_sds.energy, known(w, rolled))
        scale = max(scale, held, 0.5 * K * (REFF * 1e-5) ** 2 * float(w @ w))
        assert held <= work + 1e-12 * scale


def test_a_strong_dashpot_winds_the_spring() -> None:
    """Law (as LAMMPS has it): where the dashpot alone exceeds the limit, the spring is set to (gamma v - mu Fn)/k against the motion: energy that
    no work has brought."""
    w = np.array([0.0, 100.0, 0.0])
    start = np.array([1e-7, 0.0, 0.0])
    _, rolled = torque(known(w, start, rolling_damping=10.0))
    expected = -(10.0 * REFF * 100.0 - MU * 3.0) / K
    assert rolled == pytest.approx([expected, 0.0, 0.0], rel=1e-12)
    assert call(rolling_sds.energy, known(w, rolled)) > 1e4 * call(rolling_sds.energy, known(w, start))


def rolling_ball(omega: float, dt: float, steps: int) -> Simulation:
    """A ball spinning about y on a floor without friction, pressed by its weight in balance."""
    mass, g, kn = 2500 * 4 / 3 * pi * 0.005**3, 9.81, 1e4
    x = np.array([[0.0, 0.0, 0.005 - mass * g / kn]])
    p = spheres(x, np.array([0.005]), omega=np.array([[0.0, omega, 0.0]]))
    law = contact_law((1,), friction="none", rolling="sds", values={"rolling_stiffness": 200.0, "rolling_damping": 2e-3})
    scene = Scene(
        Box(np.full(3, -0.1), np.full(3, 0.1), ("ff",) * 3), p, 1, dt, walls=(Wall("floor", Slab(2, lo=0.0), law),),
        forces=(Gravity((0.0, 0.0, -g)),), integrate=(NveSphere(),), neighbor=Neighbor(1e-3),
    )  # fmt: skip
    simulation = Simulation(scene, budget=True)
    simulation.setup()
    simulation.advance(steps)
    return simulation


def test_a_spinning_ball_slows_evenly() -> None:
    """Law: at the limit w = w0 - (5/2) mu g t/R; a wall counts as reff = R. The budget calls it rolled and stays put."""
    simulation = rolling_ball(100.0, 1e-5, 2000)
    # the spring is wound in 8e-4 s, in which it takes part of the limit alone
    late = rolling_ball(100.0, 1e-5, 1000)
    slowing = (late.bodies.omega[0, 1] - simulation.bodies.omega[0, 1]) / 1e-2
    assert slowing == pytest.approx(2.5 * MU * 9.81 / 0.005, rel=1e-9)
    budget = simulation.energy_budget()
    lost = 0.2 * simulation.bodies.mass[0] * 0.005**2 * (100.0**2 - simulation.bodies.omega[0, 1] ** 2)
    assert budget.rolled + budget.elastic_rolling == pytest.approx(lost, rel=1e-9)


def test_a_ball_rocks_to_rest() -> None:
    """Law: below the limit the spin is a damped oscillation of angular frequency sqrt(k R^2/I) and rate gamma R^2/(2 I), I = 2/5 m R^2."""
    dt, steps = 1e-6, 12_000
    simulation = rolling_ball(0.02, dt, steps)
    mass, t = simulation.bodies.mass[0], dt * steps
    rate, square = 2e-3 / (0.8 * mass), 200.0 / (0.4 * mass)
    frequency = sqrt(square - rate * rate)
    expected = 0.02 * exp(-rate * t) * (cos(frequency * t) - rate / frequency * np.sin(frequency * t))
    assert simulation.bodies.omega[0, 1] == pytest.approx(expected, abs=1e-3 * 0.02)  # the dashpot sees velocities half a step old: order dt
    assert frequency * t > 2 * pi


@pytest.mark.parametrize(("friction", "twisting"), [("mindlin_rescale", "marshall"), ("mindlin_rescale_force", "sds")])
def test_memory_crosses_a_periodic_face(friction: str, twisting: str) -> None:
    """Law: a pair that sticks and turns, drifting through a periodic face - where its contact is split in two halves and joined again, the
    particles changing places in the list - feels what it feels in the middle of the box, and takes as much energy."""
    law = contact_law(
        normal="jkr", damping="viscoelastic", tangential_stiffness="mindlin", tangential_damping="scaled", friction=friction,
        rolling="sds", twisting=twisting,
        values={"yeff": 1e7, "gamman": 2e6, "shear_stiffness": 8e6, "mu": 5.0, "rolling_friction": 2.0, "twisting_friction": 0.1},
    )  # fmt: skip
    (middle, taken), *others = (drift(law, order, start) for order in ((0, 1), (1, 0)) for start in (0.0, 0.085))
    assert np.abs(middle).max(axis=0).min() > 1e-6
    for torque_, taken_there in others:
        # positions of 0.1 m lose 1e-17 m, of an overlap of 1e-5 m
        assert np.abs(torque_ - middle).max() < 1e-9 * np.abs(middle).max()
        assert taken_there == pytest.approx(taken, rel=1e-9)


def drift(law: ContactLaw, order: tuple[int, int], start: float) -> tuple[Floats, Floats]:
    """Torques (2, 3), and what rolling, friction and damping took, of a pair that sets out at x = start with 10 m/s; order: of the particles."""
    along = np.array([0.9, 0.4, 0.1])
    x = np.array([start, 0.0, 0.0]) + np.array([np.zeros(3), (0.0099 - 9e-6) * unit(along)])
    v, omega = np.tile([10.0, 0.0, 0.0], (2, 1)), np.array([[3.0, 20.0, -10.0], [-7.0, 5.0, 20.0]])
    chosen = list(order)
    p = spheres(x[chosen], np.array([0.005, 0.0049])[chosen], v=v, omega=omega[chosen])
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("pp", "ff", "ff"))
    scene = Scene(box, p, 1, 1e-5, pair=law, integrate=(NveSphere(),), neighbor=Neighbor(1e-4, check=False))
    simulation = Simulation(scene, budget=True)
    simulation.setup()
    simulation.advance(170)
    assert simulation.image[:, 0].tolist() == ([1, 1] if start else [0, 0])
    budget = simulation.energy_budget()
    return simulation.bodies.torque[chosen], np.array([budget.rolled, budget.rubbed, budget.damped])


def test_a_frozen_partner_feels_nothing() -> None:
    """Law: a ball rolling on a fixed one of equal size has half its radius for reff; the fixed one does not turn."""
    x = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.00999]])
    p = spheres(x, np.full(2, 0.005), omega=np.array([[0.0, 0.0, 0.0], [0.0, 5.0, 0.0]]))
    p = replace(p, mask=np.array([3, 1]))
    law = contact_law(friction="none", rolling="sds", values={"rolling_damping": 0.0})
    scene = Scene(
        Box(np.full(3, -0.1), np.full(3, 0.1), ("ff",) * 3), p, 1, 1e-6, pair=law, forces=(Freeze(1),), integrate=(NveSphere(),),
        neighbor=Neighbor(1e-3),
    )  # fmt: skip
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(1)
    assert simulation.bodies.torque[1] == pytest.approx([0.0, -(0.0025**2) * 3e3 * 5.0 * 1e-6, 0.0], rel=1e-9)
    assert not simulation.bodies.torque[0].any()

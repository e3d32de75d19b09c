"""Semi-implicit Euler (DEM primer, 2.2), beside velocity Verlet: one orbit, another clock; its order, its energy, its limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from demsolver import Box, ContactLaw, EulerSphere, Gravity, Neighbor, NveSphere, Plane, Scene, Simulation, Wall
from tests.support.scenes import law, spheres

KN, R = 1e4, 0.005
BOX = Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))
MASS = 2500.0 * 4 / 3 * np.pi * R**3
OMEGA = np.sqrt(2.0 * KN / MASS)  # of a sphere between two springs


def oscillator(dt: float, x: float, v: float, *, euler: bool = True, damping: float = 0.0) -> Scene:
    """A sphere between two parallel planes that both press on it: m x'' = -2 kn x - 2 gamman v, exactly, as long as |x| < R/2."""
    one = ContactLaw("hooke", "velocity", "none", "none", "none", {"kn": np.full(1, KN), "gamman": np.full(1, damping)})
    walls = tuple(Wall(name, Plane((0.0, 0.0, 1.0), offset), one) for name, offset in (("low", 0.5 * R), ("high", -0.5 * R)))
    p = spheres(np.array([[0.0, 0.0, x]]), np.full(1, R), v=np.array([[0.0, 0.0, v]]))
    return Scene(BOX, p, 1, dt, walls=walls, integrate=(EulerSphere(),) if euler else (NveSphere(),), lost="ignore")


def started(scene: Scene, steps: int = 0) -> Simulation:
    """A simulation that has run."""
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    simulation.advance(steps)
    return simulation


def path(scene: Scene, steps: int) -> np.ndarray:
    """(steps + 1, 2) height and speed of its sphere."""
    simulation, rows = started(scene), []
    for _ in range(steps):
        rows.append((simulation.bodies.x[0, 2], simulation.bodies.v[0, 2]))
        simulation.advance(1)
    return np.array([*rows, (simulation.bodies.x[0, 2], simulation.bodies.v[0, 2])])


def test_the_scheme_is_the_one_of_the_primer() -> None:
    """Law (2.2): m (u' - u)/dt + k x = 0 with the old x, then x' = x + dt u' with the new u; so (2.3), x' - 2 x + old + K x = 0."""
    dt = 0.3 / OMEGA
    found = path(oscillator(dt, 0.1 * R, 0.2), 50)
    x, u = found.T
    k = 2.0 * KN * dt / MASS
    # rounding: x R, overlaps of which forces are made, 1e-16 of R each
    assert u[1:] == pytest.approx(u[:-1] - k * x[:-1], abs=1e-13)
    assert x[1:] == pytest.approx(x[:-1] + dt * u[1:], abs=1e-16)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_euler_is_verlet_half_a_step_behind_in_velocity(seed: int) -> None:
    """Law: started with v - dt/2 a and omega as they are before the first contact, Euler goes through the very positions of Verlet, whatever the
    contacts do: collisions of damped, spinning, rubbing spheres; its velocities are those of Verlet half a step earlier."""
    rng, dt, g = np.random.default_rng(seed), 2e-5, np.array([0.0, 0.0, -9.81])
    x = np.stack(np.meshgrid(*[np.arange(2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * 0.011
    p = spheres(x, rng.uniform(0.004, 0.005, 8), v=rng.normal(0, 0.5, (8, 3)) - 20.0 * (x - 0.0055), omega=rng.normal(0, 50, (8, 3)))
    verlet = Scene(BOX, p, 1, dt, pair=law((1, 1)), forces=(Gravity((0.0, 0.0, -9.81)),), integrate=(NveSphere(),), neighbor=Neighbor(0.001))
    euler = replace(verlet, integrate=(EulerSphere(),), particles=replace(p, v=p.v - 0.5 * dt * g))
    a, b = started(verlet, 400), started(euler, 400)
    assume(a.bodies.force[:, :2].any() or np.abs(a.bodies.omega - p.omega).any())  # they met
    # the same sums in another order, grown over a few collisions
    assert np.abs(a.bodies.x - b.bodies.x).max() < 1e-12
    half = a.bodies.v - 0.5 * dt * a.bodies.force / p.mass[:, None]
    assert np.abs(half - b.bodies.v).max() < 1e-9 * np.abs(half).max()
    turned = a.bodies.omega - 0.5 * dt * a.bodies.torque / (0.4 * p.mass * p.radius**2)[:, None]
    assert np.abs(turned - b.bodies.omega).max() < 1e-9 * np.abs(turned).max()


@pytest.mark.parametrize(("euler", "order"), [(True, 1.0), (False, 2.0)])
def test_order_of_convergence(euler: bool, order: float) -> None:
    """Law: started from one state, Euler's positions are off by order dt, Verlet's by dt^2."""
    amplitude, phase = 0.1 * R, 1.0
    time = 10.0 / OMEGA
    errors, steps = [], (800, 1600, 3200, 6400)
    for count in steps:
        x0, v0 = amplitude * np.cos(phase), -amplitude * OMEGA * np.sin(phase)
        end = started(oscillator(time / count, x0, v0, euler=euler), count).bodies.x[0, 2]
        errors.append(abs(end - amplitude * np.cos(10.0 + phase)))
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.05)


@pytest.mark.parametrize("ratio", [0.05, 0.5, 1.0, 1.9])
def test_euler_keeps_its_own_energy(ratio: float) -> None:
    """Law: without damping m u^2/2 + k x^2/2 - k dt x u/2 stays put at every step below the limit: Euler's energy errs by order dt and does not
    drift. ratio: omega dt; the primer's limit (2.24) is 2."""
    dt = ratio / OMEGA
    x, u = path(oscillator(dt, 0.01 * R, 0.02), 4000).T
    kept = 0.5 * MASS * u**2 + KN * x**2 - KN * dt * x * u
    # a rounding of 1e-16 R in overlaps of R/2 against amplitudes of R/100, over 4000 steps
    assert np.abs(kept / kept[0] - 1.0).max() < 1e-9


@pytest.mark.parametrize(("ratio", "stable"), [(1.99, True), (2.01, False)])
def test_the_limit_of_the_spring(ratio: float, stable: bool) -> None:
    """Law (2.24): below dt = 2 sqrt(m/k) an undamped spring stays bounded for ever, above it the motion grows in every step."""
    dt = ratio / OMEGA
    x = path(oscillator(dt, 1e-6 * R, 0.0), 60)[:, 0]
    grown = np.abs(x[-10:]).max() / np.abs(x[:2]).max()
    # just below the limit the orbit of the invariant is long and thin: x reaches 1/sqrt(1 - (ratio/2)^2) times its start, and 3 for the phase
    assert (grown < 3.0 / np.sqrt(1.0 - (0.5 * ratio) ** 2)) if stable else (grown > 100.0)


def test_gravity_is_off_by_half_a_step() -> None:
    """Law: free fall from rest falls by g t (t + dt)/2: the parabola, half a step ahead."""
    p = spheres(np.zeros((1, 3)), np.full(1, R))
    scene = Scene(BOX, p, 1, 1e-3, forces=(Gravity((0.0, 0.0, -9.81)),), integrate=(EulerSphere(),), lost="ignore")
    simulation = started(scene, 100)
    assert simulation.bodies.x[0, 2] == pytest.approx(-0.5 * 9.81 * 0.1 * 0.101, rel=1e-12)
    assert simulation.bodies.v[0, 2] == pytest.approx(-9.81 * 0.1, rel=1e-12)


@pytest.mark.parametrize("inertia", [0.4, 0.5])
def test_spin_answers_to_torque(inertia: float) -> None:
    """Law: d omega = dt T/I with I = inertia m R^2, in the very step."""
    one = ContactLaw("hooke", "none", "none", "mass", "no_history", {"kn": np.full(1, KN), "gammat": np.full(1, 40.0), "mu": np.full(1, 9e9)})
    p = spheres(np.array([[0.0, 0.0, 0.9 * R]]), np.full(1, R), v=np.array([[0.3, 0.0, 0.0]]))
    scene = Scene(BOX, p, 1, 1e-5, walls=(Wall("w", Plane((0.0, 0.0, 1.0), 0.0), one),), integrate=(EulerSphere(inertia=inertia),))
    simulation = started(scene)
    torque = simulation.bodies.torque[0].copy()
    simulation.advance(1)
    assert torque[1] == pytest.approx(40.0 * MASS * 0.3 * R)
    assert simulation.bodies.omega[0] == pytest.approx(1e-5 * torque / (inertia * MASS * R**2))


def test_two_integrators_are_refused() -> None:
    """Law: one scene has one integrator; the message names both."""
    scene = replace(oscillator(1e-5, 0.0, 0.0), integrate=(NveSphere(), EulerSphere()))
    with pytest.raises(ValueError, match="one scene has one integrator, not EulerSphere and NveSphere"):
        Simulation(scene, on_instability="off")

"""Twisting springs: their limits, what they take, and the one that can give energy from nothing."""

from __future__ import annotations

from math import cos, pi, sqrt
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import Box, Neighbor, NveSphere, Scene, Simulation, contact
from tests.support.calls import call, exchanged, numbers
from tests.support.laws import contact_law
from tests.support.scenes import spheres

NAMES = ("sds", "marshall")
K, GAMMA, MU = 0.05, 2e-6, 3e-4  # of sds; marshall gets the same of these:
RADIUS = 2e-4
SHEAR, DAMPING, FRICTION = K / (0.5 * RADIUS**2), GAMMA / (0.5 * RADIUS**2), MU / (2 / 3 * RADIUS)


def known(rate: float, twisted: float, **changes: Any) -> dict[str, Any]:
    """A contact pressed with 3 N."""
    sds = {"twisting_stiffness": K, "twisting_damping": GAMMA, "twisting_friction": MU}
    marshall = {"contact_radius": RADIUS, "shear_stiffness": SHEAR, "gt": DAMPING, "mu": FRICTION}
    return sds | marshall | {"critical_force": 3.0, "twist_rate": rate, "twisted": twisted, "dt": 1e-5, "advance": True} | changes


def law_of(name: str) -> ModuleType:
    """The module of a twisting law."""
    return contact.law("twisting", name)


def torque(name: str, one: dict[str, Any]) -> tuple[float, float]:
    """Torque along n and new angle of twist."""
    result: tuple[float, float] = call(law_of(name).torque, one)
    return result


def energy(name: str, twisted: float, **changes: Any) -> float:
    """Stored energy."""
    return float(call(law_of(name).energy, known(0.0, twisted, **changes)))


@pytest.mark.parametrize("name", NAMES)
def test_a_stuck_contact_is_a_torsion_spring(name: str) -> None:
    """Law: M = -k t - gamma q, E = k t^2/2; marshall's k, gamma are kt a^2/2, gt a^2/2: a disc sheared all over, its mean square radius a^2/2."""
    found, twisted = torque(name, known(2.0, 1e-5))
    assert twisted == pytest.approx(3e-5, rel=1e-14)
    assert found == pytest.approx(-K * 3e-5 - GAMMA * 2.0, rel=1e-12)
    assert energy(name, 3e-5) == pytest.approx(0.5 * K * 9e-10, rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_twisting_on_feels_a_constant_torque(name: str, sign: float) -> None:
    """Law: a contact that twists on ends at the torque mu Fn against it, marshall's mu 2/3 mu_t a: a disc that slips all over."""
    twisted = 0.0
    for _ in range(10_000):
        found, twisted = torque(name, known(sign * 5.0, twisted))
    assert found == pytest.approx(-sign * MU * 3.0, rel=1e-12)
    assert twisted == pytest.approx(sign * (MU * 3.0 - GAMMA * 5.0) / K, rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
@given(rate=numbers(-50.0, 50.0), wound=numbers(-1.0, 1.0), pressed=numbers(0.0, 5.0), advance=st.booleans())
def test_the_torque_has_a_limit(name: str, rate: float, wound: float, pressed: float, advance: bool) -> None:
    """Law: |M| <= mu Fn, at set-up too; where it is cut it opposes the twist."""
    one = known(rate, 0.05 * wound, critical_force=pressed, advance=advance)
    found, _ = torque(name, one)
    limit = MU * pressed
    assert abs(found) <= limit * (1.0 + 1e-12)
    if abs(found) == limit > 0.0:
        assert found * rate <= 0.0


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None)
@given(path=st.lists(st.tuples(numbers(-1.0, 1.0), numbers(0.1, 5.0)), min_size=1, max_size=40))
def test_without_a_dashpot_it_only_takes(name: str, path: list[tuple[float, float]]) -> None:
    """Law: twisted to and fro while it is pressed harder and softer, a contact of one radius holds no more than was put in."""
    twisted = work = scale = 0.0
    for twist, pressed in path:
        one = known(500.0 * twist, twisted, critical_force=pressed, twisting_damping=0.0, gt=0.0)
        before = float(np.clip(-K * twisted, -MU * pressed, MU * pressed))  # first pressed, then moved
        found, twisted = torque(name, one)
        work -= 0.5 * (before + found) * one["twist_rate"] * one["dt"]
        held = energy(name, twisted)
        scale = max(scale, held, energy(name, 500.0 * twist * 1e-5))
        assert held <= work + 1e-12 * scale


@pytest.mark.parametrize("name", NAMES)
def test_a_strong_dashpot_winds_the_spring(name: str) -> None:
    """Law (as LAMMPS has it): where the dashpot alone exceeds the limit, the spring is set to (gamma q - mu Fn)/k against the twist."""
    rate = 2.0 * MU * 3.0 / GAMMA
    found, twisted = torque(name, known(rate, 0.0, advance=False))
    assert found == pytest.approx(-MU * 3.0, rel=1e-12)
    assert twisted == pytest.approx(-MU * 3.0 / K, rel=1e-12)


def test_marshall_gives_energy_as_the_contact_closes() -> None:
    """Law: wound at a small contact radius and unwound at a larger one, a cycle gives (k_2 - k_1) t^2/2, from nothing."""
    twisted, work, steps, turn = 0.0, 0.0, 400, 1e-3
    for radius, sign in ((RADIUS, 1.0), (2.0 * RADIUS, -1.0)):
        last = call(law_of("marshall").torque, known(0.0, twisted, contact_radius=radius, gt=0.0, critical_force=1e9))[0]
        for _ in range(steps):
            rate = sign * turn / steps / 1e-5
            one = known(rate, twisted, contact_radius=radius, gt=0.0, critical_force=1e9)
            found, twisted = torque("marshall", one)
            work -= 0.5 * (last + found) * rate * 1e-5
            last = found
    assert twisted == pytest.approx(0.0, abs=1e-15)
    assert -work == pytest.approx((4.0 - 1.0) * 0.5 * K * turn**2, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_seen_from_the_partner(name: str) -> None:
    """Law: w and n both turn, so the twist rate and the spring are the same for both particles, and M n is opposite."""
    memory = law_of(name).MEMORY
    one = known(3.0, 1e-5)
    assert torque(name, exchanged(one, memory)) == torque(name, one)
    assert memory == {"twisted": 1}


@pytest.mark.parametrize("name", NAMES)
def test_without_a_spring_there_are_no_infinities(name: str) -> None:
    """Law: k = 0 is a dashpot and a slider, and the angle of twist a number."""
    found, twisted = torque(name, known(1e4, 1e-5, twisting_stiffness=0.0, shear_stiffness=0.0))
    assert found == pytest.approx(-MU * 3.0, rel=1e-12)
    assert np.isfinite(twisted)
    assert energy(name, twisted, twisting_stiffness=0.0, shear_stiffness=0.0) == 0.0


def test_two_twisted_spheres_swing() -> None:
    """Law: two equal spheres that stick and are twisted against each other swing with sqrt(2 k/I), I = 2/5 m R^2, and the budget stays put."""
    radius, yeff, gamma, dt, steps = 0.005, 1e7, 1.0, 1e-6, 4000
    balance = (9.0 * pi * gamma * (radius / 2) ** 2 / yeff) ** (2 / 3) / (1.5 * radius)  # a^2/(3 reff), where JKR's force is nothing
    x = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2 * radius - balance]])
    p = spheres(x, np.full(2, radius), omega=np.array([[0.0, 0.0, 0.05], [0.0, 0.0, -0.05]]))
    values = {"yeff": yeff, "surface_energy": gamma, "twisting_damping": 0.0, "twisting_friction": 1.0}
    law = contact_law(normal="jkr", friction="none", twisting="sds", values=values)
    scene = Scene(Box(np.full(3, -0.1), np.full(3, 0.1), ("ff",) * 3), p, 1, dt, pair=law, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))
    simulation = Simulation(scene, budget=True)
    simulation.setup()
    start = simulation.energy_budget()
    simulation.advance(steps)
    end, frequency = simulation.energy_budget(), sqrt(2.0 * K / (0.4 * p.mass[0] * radius**2))
    angle = frequency * dt * steps * (1.0 + (frequency * dt) ** 2 / 24.0)  # velocity Verlet runs ahead by as much
    assert angle > 6.0
    assert simulation.bodies.omega[0, 2] == pytest.approx(0.05 * cos(angle), abs=1e-9 * 0.05)
    assert 0.0 <= end.total - start.total <= 1.001 * (frequency * dt) ** 2 / 4.0 * start.rotational  # as Verlet's energy swings
    assert end.rolled == pytest.approx(0.0, abs=1e-12 * start.rotational)

"""DMT: Hertz and a constant pull while spheres overlap."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import Box, Neighbor, NveSphere, Scene, Simulation
from demsolver.contact import normal_dmt, normal_hertz
from tests.support.laws import contact_law
from tests.support.scenes import spheres

RADIUS, KN, GAMMA = 0.005, 4.0 / 3.0 * 1e7, 1.0
REFF = RADIUS / 2
PULL = 4.0 * pi * GAMMA * REFF


def force(overlap: float, gamma: float = GAMMA) -> float:
    """Normal force at an overlap."""
    return normal_dmt.force(overlap, sqrt(REFF * overlap), REFF, KN, gamma)


@given(st.floats(1e-12, 1e-3), st.floats(0.0, 10.0))
def test_the_pull_is_constant(overlap: float, gamma: float) -> None:
    """Law: F = Hertz - 4 pi g R at any overlap; at touch all of it is the pull, 4/3 of JKR's greatest."""
    hertz = normal_hertz.force(overlap, sqrt(REFF * overlap), KN)
    assert force(overlap, gamma) == pytest.approx(hertz - 4.0 * pi * gamma * REFF, rel=1e-12, abs=1e-15 * hertz)
    assert force(0.0, gamma) == -4.0 * pi * gamma * REFF


def test_energy_is_nothing_at_touch() -> None:
    """Law: E(0) = 0, so that a contact that ends with all of its pull leaves no energy behind; E is least where F = 0."""
    balance = (PULL / (KN * sqrt(REFF))) ** (2 / 3)
    assert normal_dmt.energy(0.0, 0.0, REFF, KN, GAMMA) == 0.0
    assert force(balance) == pytest.approx(0.0, abs=1e-14 * PULL)
    least = normal_dmt.energy(balance, sqrt(REFF * balance), REFF, KN, GAMMA)
    assert least == pytest.approx(-0.6 * PULL * balance, rel=1e-12)  # 2/5 P d - P d


def test_friction_feels_the_pull() -> None:
    """Law: friction's limit is mu |F + 2 (4 pi g R)|: at touch mu 4 pi g R, in balance twice that."""
    assert normal_dmt.critical_force(-PULL, REFF, GAMMA) == pytest.approx(PULL, rel=1e-14)
    assert normal_dmt.critical_force(0.0, REFF, GAMMA) == pytest.approx(2.0 * PULL, rel=1e-14)
    assert normal_dmt.critical_force(3.0, REFF, GAMMA) == pytest.approx(3.0 + 2.0 * PULL, rel=1e-14)


def rebound(dt: float, phase: float) -> tuple[float, float]:
    """Relative change of kinetic energy, and drift of the budget, over a bounce of two undamped spheres that start `phase` steps apart."""
    speed = 0.05
    x = np.array([[0.0, 0.0, 0.0], [2 * RADIUS + phase * speed * dt, 0.0, 0.0]])
    p = spheres(x, np.full(2, RADIUS), v=np.array([[speed / 2, 0.0, 0.0], [-speed / 2, 0.0, 0.0]]))
    law = contact_law(normal="dmt", friction="none", values={"kn": KN, "surface_energy": GAMMA})
    scene = Scene(Box(np.full(3, -0.1), np.full(3, 0.1), ("ff",) * 3), p, 1, dt, pair=law, integrate=(NveSphere(),), neighbor=Neighbor(5e-3))
    simulation = Simulation(scene, budget=True)
    simulation.setup()
    start = simulation.energy_budget()
    simulation.advance(round(4e-3 / dt))
    end = simulation.energy_budget()
    assert not simulation.pairs.touching.any()
    assert end.damped == 0.0
    return end.kinetic / start.kinetic - 1.0, (end.total - start.total) / start.kinetic


def test_a_bounce_gives_everything_back() -> None:
    """Law: an undamped bounce keeps its energy but for the jump of the force at touch, P v dt/2 at most at either end: of order dt."""
    p = spheres(np.zeros((1, 3)), np.array([RADIUS]))
    kinetic = 0.25 * p.mass[0] * 0.05**2
    for dt in (4e-6, 1e-6):
        for phase in (0.1, 0.4, 0.8):
            gain, drift = rebound(dt, phase)
            assert abs(gain) < 1.01 * PULL * 0.05 * dt / kinetic
            assert gain == pytest.approx(drift, abs=1e-12)

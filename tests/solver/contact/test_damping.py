"""Damping laws: what they promise about restitution, and their limits."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import contact

MASS, REFF = 2e-3, 5e-3
FRACTION = contact.law("damping", "fraction").coefficient
STOKES = contact.law("damping", "stokes").coefficient


def rebound(speed: float, stiffness: Callable[[float], float], fraction: float) -> float:
    """Ratio of speeds after and before a head-on impact m d'' = -k(d) d - gn d', by Runge-Kutta until the overlap is gone."""
    scale = speed * sqrt(MASS / stiffness(1e-4)) * 1e-3 / speed

    def slope(d: float, u: float) -> tuple[float, float]:
        k = stiffness(max(d, 1e-200))
        return u, -(k * d + FRACTION(MASS, k, fraction) * u) / MASS

    d, u = 0.0, speed
    while True:
        a = slope(d, u)
        b = slope(d + 0.5 * scale * a[0], u + 0.5 * scale * a[1])
        c = slope(d + 0.5 * scale * b[0], u + 0.5 * scale * b[1])
        e = slope(d + scale * c[0], u + scale * c[1])
        new_d = d + scale / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + e[0])
        new_u = u + scale / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + e[1])
        if new_d <= 0.0:
            part = d / (d - new_d)
            return -(u + part * (new_u - u)) / speed
        d, u = new_d, new_u


def linear(d: float) -> float:
    """Secant stiffness of a linear spring."""
    return 1e4


def hertz(d: float) -> float:
    """Secant stiffness of a Hertz spring."""
    return 2e6 * sqrt(REFF * d)


@pytest.mark.parametrize("restitution", [0.3, 0.8])
@pytest.mark.parametrize(("spring", "factor"), [(linear, 2.0), (hertz, sqrt(5.0))])
def test_fraction_gives_the_restitution(spring: Callable[[float], float], factor: float, restitution: float) -> None:
    """With damping_fraction -2 L/sqrt(pi^2 + L^2) (linear) or sqrt(5)/2 times that (Hertz), impacts rebound with e = exp(L)."""
    loss = -log(restitution) / sqrt(pi**2 + log(restitution) ** 2)
    assert rebound(0.3, spring, factor * loss) == pytest.approx(restitution, rel=2e-4)


def test_fraction_is_independent_of_the_impact_speed() -> None:
    """A Hertz contact damped by a fraction of sqrt(m k) rebounds alike at any speed."""
    assert rebound(0.1, hertz, 0.5) == pytest.approx(rebound(1.0, hertz, 0.5), rel=2e-4)


def test_fraction_is_relative_to_critical_damping() -> None:
    """A linear spring without overshoot needs damping_fraction 2: gn^2 = 4 m k."""
    assert FRACTION(MASS, 1e4, 2.0) ** 2 == pytest.approx(4.0 * MASS * 1e4, rel=1e-15)


@given(st.floats(1e-6, 1.0), st.floats(1e-6, 1e-3), st.floats(0.0, 1e6))
def test_plain_dashpots(meff: float, radius: float, gamman: float) -> None:
    """velocity, mass_velocity and viscoelastic are gamma times 1, the mass, the mass times the contact radius."""
    assert contact.law("damping", "velocity").coefficient(gamman) == gamman
    assert contact.law("damping", "mass_velocity").coefficient(meff, gamman) == gamman * meff
    assert contact.law("damping", "viscoelastic").coefficient(meff, radius, gamman) == pytest.approx(gamman * meff * radius)


@given(st.floats(-10.0, 10.0), st.floats(0.05, 1.0), st.floats(0.1, 100.0), st.floats(1e-6, 1.0))
def test_stokes_never_exceeds_critical_damping(vn: float, e_max: float, critical: float, viscosity: float) -> None:
    """0 <= gn <= 2 sqrt(m k) at every velocity, zero included."""
    gn = STOKES(vn, REFF, MASS, 1e4, log(e_max), critical, viscosity)
    assert 0.0 <= gn <= 2.0 * sqrt(MASS * 1e4) * (1.0 + 1e-15)


def test_stokes_limits() -> None:
    """At vn = 0 the damping is critical; a fast impact rebounds with e_max; approach is damped more than separation."""
    at_rest, fast, approach, separation = (STOKES(vn, REFF, MASS, 1e4, log(0.8), 10.0, 1e-3) for vn in (0.0, -1e12, -1e-3, 1e-3))
    dry = FRACTION(MASS, 1e4, -2.0 * log(0.8) / sqrt(pi**2 + log(0.8) ** 2))
    assert at_rest == pytest.approx(2.0 * sqrt(MASS * 1e4), rel=1e-15)
    assert fast == pytest.approx(dry, rel=1e-9)
    assert approach > separation


def test_stokes_restitution_of_one_impact_speed() -> None:
    """L = ln(e_max) + St_c/St with St = m vn/(6 pi viscosity R^2): St = -20, St_c = 10, e_max = 1 give e = exp(-1/2)."""
    vn = -20.0 * 6.0 * pi * 1e-3 * REFF**2 / MASS
    gn = STOKES(vn, REFF, MASS, 1e4, 0.0, 10.0, 1e-3)
    zeta = gn / (2.0 * sqrt(MASS * 1e4))
    assert exp(-pi * zeta / sqrt(1.0 - zeta**2)) == pytest.approx(exp(-0.5), rel=1e-12)

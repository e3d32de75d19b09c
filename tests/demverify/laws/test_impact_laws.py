"""Laws of oblique impact and spin, on frames that obey them and on frames with a planted error."""

from __future__ import annotations

from math import pi, radians, sin, sqrt

import numpy as np
import pytest

from demverify.frames import Floats, Frame
from demverify.laws import oblique_linear, oblique_mindlin, oblique_pair, spin_impact, spin_no_friction
from demverify.laws.oblique_mindlin import hertz_mindlin
from tests.support.law_frames import off

RADIUS, MASS = 0.0025, 2.618e-4


def _frame(step: int, v: Floats, omega: Floats, x: Floats | None = None) -> Frame:
    v, omega = np.atleast_2d(v), np.atleast_2d(omega)
    n = len(v)
    x = np.zeros((n, 3)) if x is None else x
    named = {"x": x[:, 0], "y": x[:, 1], "z": x[:, 2], "vx": v[:, 0], "vy": v[:, 1], "vz": v[:, 2]}
    spins = {"omegax": omega[:, 0], "omegay": omega[:, 1], "omegaz": omega[:, 2]}
    return Frame(step, np.zeros((3, 2)), ("f", "f", "f"), {**named, **spins, "radius": np.full(n, RADIUS), "mass": np.full(n, MASS)})


def _impact(vn: float, vx: float, spin: float, bounce: float, impulse: float) -> list[Frame]:
    after = np.array([vx - impulse, 0.0, bounce]), np.array([0.0, spin + 2.5 * impulse / RADIUS, 0.0])
    return [_frame(0, np.array([vx, 0.0, -vn]), np.array([0.0, spin, 0.0])), _frame(9, *after)]


@pytest.mark.parametrize("slip_sign", [1.0, -1.0])
def test_spin_impact(slip_sign: float) -> None:
    """Law: sliding impulse mu (1 + e) v_n against the slip, with a spin at first; a wrong sign of the impulse shows."""
    vn, spin, e, mu = 0.5, -slip_sign * 900.0, 0.6, 0.3
    impulse = slip_sign * mu * (1.0 + e) * vn
    assert max(off(spin_impact.measure(_impact(vn, 0.1, spin, e * vn, impulse), e, mu)).values()) < 1e-14
    wrong = off(spin_impact.measure(_impact(vn, 0.1, spin, e * vn, -impulse), e, mu))
    assert wrong["tangential velocity"] > 0.5
    assert wrong["slip"] > 0.1


@pytest.mark.parametrize("angle", [30.0, 45.0, 80.0])
def test_mindlin_slides_as_the_impulse_says(angle: float) -> None:
    """Law: above 28 degrees the integrated Mindlin contact gives P = mu (1 + e) v_n (Chung & Ooi 2011, test 4, aluminium oxide)."""
    vn, vt = 3.9 * sin(radians(90.0 - angle)), 3.9 * sin(radians(angle))
    eeff, geff = 3.8e11 / (1.0 - 0.23**2), 3.8e11 / (2.0 * (2.0 - 0.23) * 1.23)
    bounce, impulse = hertz_mindlin(eeff * sqrt(RADIUS) / MASS, geff * sqrt(RADIUS) / MASS, 1.0, 0.092, vn, vt, True)
    assert bounce == pytest.approx(vn, rel=1e-8)
    assert impulse == pytest.approx(0.184 * vn, rel=2e-5)


@pytest.mark.parametrize("pulling", [True, False])
def test_mindlin_restitution(pulling: bool) -> None:
    """Law: the dashpot gives its restitution where it may pull, and the higher one of Schwager & Poeschel 2007 where it may not."""
    b = np.log(2.0) / sqrt(pi**2 + np.log(2.0) ** 2)
    w = sqrt(1.0 - b * b)
    ends = np.exp(-(b / w) * (pi - np.arctan2(2.0 * b * w, 1.0 - 2.0 * b * b)))
    bounce, _ = hertz_mindlin(1e9, 1e9, 0.5, 0.1, 0.3, 0.3, pulling)
    assert bounce / 0.3 == pytest.approx(0.5 if pulling else ends, rel=1e-4)


def test_mindlin_measures_a_planted_error() -> None:
    """Law: 1 % more tangential impulse than the Mindlin contact gives shows as 1 %."""
    vn, vt = 3.0, 1.0
    eeff, geff = 1e9 / (1.0 - 0.09) / 2.0, 1e9 / (4.0 * 1.7 * 1.3)
    _, impulse = hertz_mindlin(eeff * sqrt(RADIUS) / MASS, geff * sqrt(RADIUS) / MASS, 1.0, 0.2, vn, vt, True)

    def scaled(factor: float) -> dict[str, float]:
        return off(oblique_mindlin.measure(_impact(vn, vt, 0.0, vn, factor * impulse), 1e9, 0.3, 1e9, 0.3, 1.0, 0.2, "yes"))

    assert max(scaled(1.0).values()) < 1e-7
    assert scaled(1.01)["spin"] == pytest.approx(0.01, rel=1e-3)


def test_linear_sticks_by_the_oscillator() -> None:
    """Law: without slip the linear contact is an oscillator, P = (2/7) slip (1 - cos(sqrt(7 kt/2 kn) pi))."""
    kn, kt, vn, vt = 1e5, 4e4, 1.0, 0.2
    impulse = 2.0 / 7.0 * vt * (1.0 - np.cos(sqrt(3.5 * kt / kn) * pi))
    assert max(off(oblique_linear.measure(_impact(vn, vt, 0.0, vn, impulse), kn, kt, 50.0)).values()) < 2e-4  # the contact ends within a step
    assert off(oblique_linear.measure(_impact(vn, vt, 0.0, vn, -impulse), kn, kt, 50.0))["spin"] == pytest.approx(2.0, rel=1e-3)


def _pair(impulse: float) -> list[Frame]:
    x = np.array([[-RADIUS, 0.0, 0.0], [RADIUS, 0.0, 0.0]])
    before, spin = np.array([[1.0, 0.0, 2.0], [-1.0, 0.0, -2.0]]), 2.5 * impulse / RADIUS
    after = np.array([[-0.8, 0.0, 2.0 - impulse], [0.8, 0.0, impulse - 2.0]])
    return [_frame(0, before, np.zeros((2, 3)), x), _frame(9, after, np.array([[0.0, spin, 0.0], [0.0, spin, 0.0]]), 1.01 * x)]


def test_oblique_pair() -> None:
    """Law: each of two mirrored spheres takes mu (1 + e) v_n; 10 % more impulse shows as 10 % of the spin."""
    assert max(off(oblique_pair.measure(_pair(0.18), 0.8, 0.1)).values()) < 1e-13
    assert off(oblique_pair.measure(_pair(0.198), 0.8, 0.1))["spin"] == pytest.approx(0.1)


def test_spin_no_friction() -> None:
    """Law: spins and sideways velocities stay; a spin that changed by 2 % shows as 2 %."""
    frames = _pair(0.0)
    spins = np.array([[0.0, 5.0, 0.0], [0.0, -5.0, 0.0]])
    x = frames[0].vectors("x", "y", "z")
    first = _frame(0, np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]), spins, x)
    same, changed = (_frame(9, np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]), factor * spins, x) for factor in (1.0, 1.02))
    assert max(off(spin_no_friction.measure([first, same])).values()) == 0.0
    assert off(spin_no_friction.measure([first, changed]))["spin change"] == pytest.approx(0.02)

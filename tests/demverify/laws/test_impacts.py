"""Closed forms of straight impacts, on trajectories that an integrator of the test's own has made."""

from __future__ import annotations

from math import exp, log, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from demverify.impact import damping_ratio
from demverify.laws import hertz_impact, limited_restitution, linear_impact, tsuji_restitution, viscoelastic_impact
from tests.support.impact_frames import Curve, impact, ratios
from tests.support.law_frames import off

RADIUS, MASS = (0.005, 0.01), (1e-3, 4e-3)
REDUCED, R = 0.8e-3, 0.01 / 3.0


def ratio_of(restitution: float) -> float:
    return -log(restitution) / sqrt(pi**2 + log(restitution) ** 2)


@pytest.mark.parametrize("restitution", [1e-3, 0.3, 0.999, 1.0])
def test_damping_ratio(restitution: float) -> None:
    """Law: half a swing of the oscillator with this ratio leaves e of the speed, exp(-pi b/sqrt(1 - b^2)) = e; undamped where e is 1."""
    b = damping_ratio(restitution)
    assert exp(-pi * b / sqrt(1.0 - b * b)) == pytest.approx(restitution, rel=1e-13)
    assert damping_ratio(1.0) == 0.0


def integrated(acceleration: object, speed: float, longest: float, mass: float) -> tuple[Curve, float]:
    """d'' = acceleration(d, d') from touch to d = 0 again, and how long that lasts."""

    def apart(t: float, y: np.ndarray) -> float:
        return float(y[0]) if t > 1e-3 * longest else 1.0

    apart.terminal = True  # type: ignore[attr-defined]

    def move(_: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], acceleration(max(y[0], 0.0), y[1])  # type: ignore[operator]

    scale = speed * longest
    run = solve_ivp(move, (0.0, longest), (0.0, speed), events=apart, rtol=1e-11, atol=1e-13 * scale, max_step=longest / 2000, dense_output=True)

    def curve(time: float) -> tuple[float, float, float]:
        overlap, rate = run.sol(time)
        return float(overlap), float(rate), -mass * acceleration(max(overlap, 0.0), rate)  # type: ignore[operator]

    return curve, float(run.t_events[0][0])


@pytest.mark.parametrize("restitution", [0.2, 0.8, 1.0])
def test_linear_impact(restitution: float) -> None:
    """Law: contact time pi / (w sqrt(1 - b^2)); twice the stiffness shortens it, and the overlap, by sqrt(2)."""
    b, w = ratio_of(restitution), sqrt(1e4 / REDUCED)
    p = w * sqrt(1.0 - b**2)

    def curve(t: float) -> tuple[float, float, float]:
        overlap = exp(-b * w * t) * sin(p * t) / p
        return overlap, exp(-b * w * t) * (np.cos(p * t) - b * w / p * sin(p * t)), 0.0

    frames, timestep = impact(curve, pi / p, RADIUS, MASS)
    assert max(off(linear_impact.measure(frames, 1e4, restitution, timestep)).values()) < 1e-7
    scaled = ratios(linear_impact.measure(frames, 2e4, restitution, timestep))
    assert scaled == pytest.approx({"contact time": sqrt(2.0), "peak overlap": sqrt(2.0)}, rel=1e-6)


@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_hertz_impact_damped(restitution: float) -> None:
    """Law: the damped Hertz impact is a linear oscillator in d^(5/4); the trajectory comes from an integrator that does not know that."""
    young, poisson = 1e8, 0.3
    k = 4.0 / 3.0 * young / (2.0 * 0.91) * sqrt(R)
    c = sqrt(5.0) * ratio_of(restitution) * sqrt(REDUCED * k)
    curve, duration = integrated(lambda d, v: -(k * d**1.5 + c * d**0.25 * v) / REDUCED, 1.0, 2e-3, REDUCED)
    frames, timestep = impact(curve, duration, RADIUS, MASS)
    assert max(off(hertz_impact.measure(frames, young, poisson, "alike", restitution, timestep)).values()) < 2e-5
    scaled = ratios(hertz_impact.measure(frames, 2.0 * young, poisson, "alike", restitution, timestep))
    assert scaled == pytest.approx({"contact time": 2**0.4, "peak overlap": 2**0.4, "peak force": 2**-0.4}, rel=1e-4)
    scaled = ratios(hertz_impact.measure(frames, young, poisson, "rigid", restitution, timestep))
    assert scaled["peak overlap"] == pytest.approx(2**0.4, rel=1e-4)


def test_hertz_impact_of_chung_and_ooi() -> None:
    """Law: test 1, limestone: 368.304 um, 7.10824 kN, 54.2010 us."""
    mass = 4.0 / 3.0 * pi * 0.01**3 * 2500.0
    curve = {0.0: (0.0, 20.0, 0.0)}.get
    frames, timestep = impact(lambda t: curve(t) or (0.0, -20.0, 0.0), 54.2010e-6, (0.01, 0.01), (mass, mass))
    expected = {one.quantity: one.expected for one in hertz_impact.measure(frames, 2e10, 0.25, "alike", 1.0, timestep)}
    assert expected == pytest.approx({"contact time": 54.2010e-6, "peak overlap": 368.304e-6, "peak force": 7108.24}, rel=2e-6)


@pytest.mark.parametrize("damping", [0.0, 5e5])
def test_viscoelastic_impact(damping: float) -> None:
    """Law: m d'' = -a (k d + g m d'); without damping that of Hertz. A dashpot twice as strong is another trajectory."""
    k = 1e8
    curve, duration = integrated(lambda d, v: -sqrt(R * d) * (k * d / REDUCED + damping * v), 1.0, 2e-3, REDUCED)
    frames, timestep = impact(curve, duration, RADIUS, MASS)
    found = viscoelastic_impact.measure(frames, k, damping, timestep)
    assert max(off(found).values()) < 2e-6
    if not damping:
        hertz = hertz_impact.measure(frames, 0.75 * k * 2.0 * 0.91, 0.3, "alike", 1.0, timestep)
        assert [one.expected for one in found[1:]] == pytest.approx([one.expected for one in hertz[:2]], rel=1e-8)
    assert ratios(viscoelastic_impact.measure(frames, k, 2.0 * damping + 1e5, timestep))["restitution"] > 1.005


def test_an_impact_on_the_plane() -> None:
    """Law: one sphere and the plane z = 0: reduced mass and radius are the sphere's."""
    w = sqrt(1e4 / 1e-3)
    frames, timestep = impact(lambda t: (sin(w * t) / w, float(np.cos(w * t)), 0.0), pi / w, (0.005,), (1e-3,))
    assert max(off(linear_impact.measure(frames, 1e4, 1.0, timestep)).values()) < 1e-7


@pytest.mark.parametrize(("nominal", "real"), [(0.9, 0.9284), (0.5, 0.6161), (0.1, 0.2349)])
def test_tsuji_restitution(nominal: float, real: float) -> None:
    """Law: what the wheel gives for a nominal restitution, as the register has it."""
    frames, _ = impact(lambda t: (0.0, 1.0 if t == 0.0 else -real, 0.0), 1e-3, RADIUS, MASS)
    (found,) = tsuji_restitution.measure(frames, nominal)
    assert found.measured == pytest.approx(found.expected, abs=2e-4)
    (found,) = tsuji_restitution.measure(frames, 0.7)
    assert abs(found.measured - found.expected) > 0.1


@pytest.mark.parametrize("hertz", [False, True])
@pytest.mark.parametrize(("nominal", "real"), [(0.3, 0.397), (0.5, 0.550), (0.8, 0.808)])
def test_limited_restitution(nominal: float, real: float, hertz: bool) -> None:
    """Law: a contact that may not pull, integrated until its force is zero; three digits as in the register."""
    b = ratio_of(nominal)
    k, n, c = (1e6, 1.5, sqrt(5.0) * b * sqrt(REDUCED * 1e6)) if hertz else (1e4, 1.0, 2.0 * b * sqrt(REDUCED * 1e4))

    def pull(d: float, v: float) -> float:
        return -max(k * d**n + c * d ** (0.5 * (n - 1.0)) * v, 0.0) / REDUCED

    curve, duration = integrated(pull, 1.0, 1e-2, REDUCED)
    frames, _ = impact(curve, duration, RADIUS, MASS)
    (found,) = limited_restitution.measure(frames, nominal)
    assert found.expected == pytest.approx(real, abs=5e-4)
    assert found.measured == pytest.approx(found.expected, rel=1e-4)
    assert limited_restitution.measure(frames, 0.9)[0].expected > 0.9 > found.measured

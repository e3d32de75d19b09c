"""Laws of balls on floors and slopes, and the momentum balance, on frames that obey them and on frames with a planted error."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, radians, sin, sqrt

import numpy as np
import pytest

from demverify.frames import Frame
from demverify.laws import incline, marshall_decay, momentum_conservation, slip_transient, spin_decay
from tests.support.law_frames import off

RADIUS, MASS, G, DT = 0.005, 1.3e-3, 9.81, 1e-3
State = Callable[[float], tuple[float, float, float, float]]  # t -> x, vx, omegay, omegaz


def _frames(state: State, until: float) -> list[Frame]:
    frames = []
    for step in range(round(until / DT) + 1):
        x, vx, wy, wz = state(step * DT)
        values = {"x": x, "y": 0.0, "z": RADIUS, "vx": vx, "vy": 0.0, "vz": 0.0, "omegax": 0.0, "omegay": wy, "omegaz": wz}
        columns = {name: np.array([value]) for name, value in {**values, "radius": RADIUS, "mass": MASS}.items()}
        frames.append(Frame(step, np.zeros((3, 2)), ("f", "f", "f"), columns))
    return frames


def _slip(mu: float) -> list[Frame]:
    return _frames(lambda t: (0.0, 1.0 - mu * G * t, 2.5 * mu * G * t / RADIUS, 0.0), 2.0 / (7.0 * mu * G))


def test_slip_transient() -> None:
    """Law: u = u0 - mu g t, omega = 5/2 mu g t/R until 2 u0/(7 mu g); 5 % more friction ends the slip 5 % sooner."""
    assert max(off(slip_transient.measure(_slip(0.3), 0.3, G, DT)).values()) < 1e-12
    assert off(slip_transient.measure(_slip(0.315), 0.3, G, DT))["end of the slip"] == pytest.approx(1.0 - 1.0 / 1.05, rel=1e-9)


@pytest.mark.parametrize("axis", ["y", "z"])
@pytest.mark.parametrize("until", [0.5, 1.5])
def test_spin_decay(axis: str, until: float) -> None:
    """Law: |omega| falls by 5/2 mu_r g t/R and ends at rest; no resistance shows as what it should have taken."""
    rate = 2.5 * 0.1 * G / RADIUS

    def state(t: float, rate: float = rate) -> tuple[float, float, float, float]:
        w = -max(100.0 - rate * t, 0.0)
        return (0.0, 0.0, w, 0.0) if axis == "y" else (0.0, 0.0, 0.0, w)

    stops = 100.0 / rate
    assert max(off(spin_decay.measure(_frames(state, until * stops), axis, 0.1, G, DT)).values()) < 1e-12  # type: ignore[arg-type]
    free = spin_decay.measure(_frames(lambda t: state(0.0), until * stops), axis, 0.1, G, DT)  # type: ignore[arg-type]
    assert max(off(free).values()) == pytest.approx(0.9 * min(until, 1.0) if until < 1 else 1.0, abs=0.01)


def test_marshall_decay() -> None:
    """Law: omega falls by 5/3 mu a g t/R^2, a = sqrt(R m g/k); a torque without the 2/3 shows."""
    rate = 5.0 / 3.0 * 0.5 * sqrt(RADIUS * MASS * G / 1e3) * G / RADIUS**2
    found = marshall_decay.measure(_frames(lambda t: (0.0, 0.0, 0.0, 100.0 - rate * t), 90.0 / rate), 0.5, 1e3, G, DT)
    assert max(off(found).values()) < 1e-12
    wrong = marshall_decay.measure(_frames(lambda t: (0.0, 0.0, 0.0, 100.0 - 1.5 * rate * t), 90.0 / rate), 0.5, 1e3, G, DT)
    assert off(wrong)["spin at 0.5"] == pytest.approx(0.225, abs=0.01)


@pytest.mark.parametrize(
    ("slope", "mu", "mur", "a", "alpha"),
    [
        (20.0, 0.5, 0.1, 5 / 7 * (sin(radians(20)) - 0.1 * cos(radians(20))), 5 / 7 * (sin(radians(20)) - 0.1 * cos(radians(20)))),
        (45.0, 0.2, 0.05, 0.8 * sin(radians(45)), 2.5 * 0.15 * cos(radians(45))),
        (10.0, 0.5, 0.3, 0.0, 0.0),
    ],
)
def test_incline(slope: float, mu: float, mur: float, a: float, alpha: float) -> None:
    """Law: a ball rolls, slides or rests on a slope; 1 % more speed shows as 1 %."""

    def state(t: float, extra: float = 1.0) -> tuple[float, float, float, float]:
        return 0.5 * a * G * t * t, extra * a * G * t, alpha * G * t / RADIUS, 0.0

    assert max(off(incline.measure(_frames(state, 0.2), slope, mu, mur, G, DT)).values()) < 1e-12
    if a:
        assert off(incline.measure(_frames(lambda t: state(t, 1.01), 0.2), slope, mu, mur, G, DT))["speed"] == pytest.approx(0.01)


def test_momentum_conservation() -> None:
    """Law: momentum and angular momentum stay; a spin from nowhere shows."""
    still = _frames(lambda t: (t, 1.0, 3.0, 0.0), 0.01)
    assert max(off(momentum_conservation.measure(still)).values()) < 1e-15
    spun = _frames(lambda t: (t, 1.0, 3.0 + 100.0 * t, 0.0), 0.01)
    found = off(momentum_conservation.measure(spun))
    assert found["momentum"] == 0.0
    assert found["angular momentum"] > 1e-4

"""A rigid sphere in a cylinder that may turn."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from scipy.special import ellipk

from demverify.errors import InputError
from demverify.laws.rolling_in_cylinder import Drum, measure, motion
from tests.support.law_frames import frame, off

RC, R, G = 0.02, 0.005, 9.81
L = RC - R
T = np.linspace(0.0, 0.6, 6001)


def drum(rate: float = 0.0, friction: float = 0.5, sphere: float = R) -> Drum:
    """A cylinder of radius RC and a sphere in it."""
    return Drum(RC, sphere, rate, friction, G)


def period(t: np.ndarray, angle: np.ndarray) -> float:
    """Between the first two falling passages through the lowest line."""
    k = np.flatnonzero((angle[:-1] > 0.0) & (angle[1:] <= 0.0))[:2]
    at = t[k] + (t[k + 1] - t[k]) * angle[k] / (angle[k] - angle[k + 1])
    return float(at[1] - at[0])


@pytest.mark.parametrize(("friction", "stretch"), [(0.5, 1.4), (0.0, 1.0)])
@pytest.mark.parametrize("amplitude", [1e-3, 0.5])
def test_period(friction: float, stretch: float, amplitude: float) -> None:
    """Law: a pendulum of length 7/5 L that rolls, L without friction; swings of amplitude a take 4 sqrt(l/g) K(sin(a/2)), nearly
    2 pi sqrt(l/g)."""
    found = motion(drum(friction=friction), np.array([amplitude, 0.0, 0.0]), T)
    exact = 4.0 * sqrt(stretch * L / G) * float(ellipk(np.sin(amplitude / 2.0) ** 2))
    assert period(T, found[:, 0]) == pytest.approx(exact, rel=1e-6)
    assert exact == pytest.approx(2.0 * pi * sqrt(stretch * L / G), rel=amplitude**2 / 8.0)


@pytest.mark.parametrize("rate", [0.0, 7.0, -7.0])
def test_rolling_keeps_energy(rate: float) -> None:
    """Law: v^2/2 + v^2/5 + g L (1 - cos f) of a ball that rolls stays put, whether the cylinder turns or not; its spin is that of rolling."""
    start = np.array([0.6, 1.0, (RC * rate - L) / R])
    angle, turning, spin = motion(drum(rate, friction=1.0), start, T).T
    energy = 0.7 * (L * turning) ** 2 + G * L * (1.0 - np.cos(angle))
    assert energy == pytest.approx(energy[0], rel=1e-9)
    assert L * turning + R * spin == pytest.approx(RC * rate, abs=1e-12)


def test_friction_takes_what_the_slip_is_worth() -> None:
    """Law: while a ball slides on a cylinder at rest, energy falls by mu N |s| in time; when it rolls it stays."""
    start, one = np.array([0.0, 60.0, 0.0]), drum(friction=0.3)
    t = np.linspace(0.0, 0.02, 20001)
    y = motion(one, start, t)
    energy = 0.5 * (L * y[:, 1]) ** 2 + 0.2 * (R * y[:, 2]) ** 2 + G * L * (1.0 - np.cos(y[:, 0]))
    power = one.friction * np.array([one.load(row) * abs(one.slip(row)) for row in y])
    taken = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) * 0.5 * np.diff(t))])
    assert energy + taken == pytest.approx(energy[0], rel=1e-6)
    assert taken[-1] > 0.1 * energy[0]


def test_a_wide_cylinder_is_a_belt() -> None:
    """Law: with Rc to infinity a sphere at rest on the bottom gains mu g t, and rolls with 2/7 of the speed of the wall from 2 V/(7 mu g) on."""
    wide, speed = 1e6, 0.1
    t = np.linspace(0.0, 0.02, 2001)
    turning = motion(Drum(wide, R, speed / wide, 0.3, G), np.zeros(3), t)[:, 1] * (wide - R)
    assert turning == pytest.approx(np.minimum(0.3 * G * t, 2.0 / 7.0 * speed), rel=1e-6, abs=1e-9)


def test_a_fast_wall_drags_to_the_angle_of_friction() -> None:
    """Law: where the slip never ends, friction mu N alone turns the direction of rest to tan f = mu, for small swings about it."""
    angle = motion(drum(1e4, friction=0.05), np.array([np.arctan(0.05), 0.0, 0.0]), T)[:, 0]
    assert angle == pytest.approx(np.arctan(0.05), rel=1e-9)


def test_it_slides_again_where_friction_cannot_hold() -> None:
    """Law: at rest at f a ball rolls if (2/7) tan f < mu, and slides if not; on its way down it rolls after all."""
    steep = motion(drum(friction=0.2), np.array([1.2, 0.0, 0.0]), T)
    slips = np.abs(L * steep[:, 1] + R * steep[:, 2])
    assert slips[100] > 0.01
    assert slips.min() == 0.0
    assert (slips < 1e-9).sum() > 1000
    gentle = motion(drum(friction=0.2), np.array([0.6, 0.0, 0.0]), T)
    assert np.abs(L * gentle[:, 1] + R * gentle[:, 2]).max() < 1e-9


def test_a_mirrored_drum_does_the_mirrored_thing() -> None:
    """Law: turned the other way, from the mirrored start, everything has the other sign."""
    start = np.array([0.3, 2.0, -20.0])
    assert motion(drum(30.0), start, T) == pytest.approx(-motion(drum(-30.0), -start, T), rel=1e-9, abs=1e-9)


def test_a_ball_that_leaves_the_wall_is_refused() -> None:
    """Law: beyond g cos f + L f'^2 = 0 there is no wall to roll on."""
    with pytest.raises(InputError, match=r"the sphere leaves the wall at time 0\.0"):
        motion(drum(friction=0.0), np.array([0.0, 45.0, 0.0]), T)


def frames(rate: float, lever: float = 1.0, friction: float = 0.3):
    """The motion from rest as frames, about an axis through (0.1, -0.2); lever: of the spin."""
    steps = np.arange(0, 30001, 300)
    found = []
    for k, (angle, turning, spin) in zip(steps, motion(drum(rate, friction), np.array([0.2, 0.0, 0.0]), steps * 1e-5), strict=True):
        out, along = np.array([np.sin(angle), -np.cos(angle), 0.0]), np.array([np.cos(angle), np.sin(angle), 0.0])
        found.append(frame(int(k), [0.1, -0.2, 0.0] + L * out, L * turning * along, [0.0, 0.0, lever * spin], radius=R))
    return found


@pytest.mark.parametrize("rate", [0.0, 20.0, -20.0])
def test_frames_are_read_as_they_were_written(rate: float) -> None:
    """Law: frames of the motion itself miss nothing; 2 % of the spin, 10 % of the friction or the rate are seen."""
    given = (1e-5, RC, rate, 0.3, G, 0.1, -0.2)
    assert max(off(measure(frames(rate), *given)).values()) < 1e-9
    assert off(measure(frames(rate, lever=1.02), *given))["spin"] == pytest.approx(0.02, rel=0.1)
    if rate:
        assert off(measure(frames(1.1 * rate), *given))["spin"] > 0.05
        assert off(measure(frames(rate, friction=0.33), *given))["speed"] > 0.01

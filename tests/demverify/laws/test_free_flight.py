"""Free flight."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws import largest_miss
from demverify.laws.free_flight import measure
from tests.support.law_frames import frame, off


def flight(g, shift: float = 0.0):
    x, v, w = np.array([1.0, 2.0, 3.0]), np.array([0.5, -1.0, 2.0]), np.array([1.0, 2.0, 3.0])
    return [frame(k, x + v * t + 0.5 * g * t * t + shift * t, v + g * t, w) for k, t in enumerate(0.1 * np.arange(8))]


@pytest.mark.parametrize(
    ("style", "numbers", "g"),
    [
        ("vector", (2.0, -3.0, 6.0), (2 / 7, -3 / 7, 6 / 7)),
        ("chute", (30.0, 0.0, 0.0), (0.5, 0.0, -np.sqrt(3) / 2)),
        ("spherical", (0.0, 90.0, 0.0), (1.0, 0.0, 0.0)),
        ("spherical", (90.0, 30.0, 0.0), (0.0, 0.5, np.sqrt(3) / 2)),
    ],
)
def test_parabolas(style, numbers, g):
    """Law: x = x0 + v0 t + g t^2/2 in the direction that the words mean."""
    assert max(off(measure(flight(9.81 * np.array(g)), 0.1, 9.81, style, *numbers, "verlet")).values()) < 1e-14


def test_a_drift_is_seen():
    """Law: a drift of 0.01 t shows in the path, not in the velocity."""
    found = off(measure(flight(np.zeros(3), 0.01), 0.1, 0.0, "vector", 0.0, 0.0, -1.0, "verlet"))
    assert found["velocity"] == 0.0
    assert found["path"] == pytest.approx(0.005, rel=0.01)


def test_the_largest_miss_is_the_worst_frame():
    """Law: of one miss a frame the largest counts, with its step; what is not a number counts before all."""
    frames = [frame(step, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]) for step in (0, 10, 20)]
    assert largest_miss("path", frames, [0.1, 0.3, 0.2], 2.0) == ("path", 10, 0.3, 0.0, 2.0)
    assert largest_miss("path", frames, [0.1, 0.3, np.nan], 2.0).step == 20


def test_a_changing_spin_is_seen():
    """Law (what must be rejected): free flight leaves the spin alone; one that grows from 3 to 3.7 shows as 0.7 of 3."""
    frames = flight(np.zeros(3))
    frames[-1].columns["omegaz"][:] += 0.7
    assert off(measure(frames, 0.1, 0.0, "vector", 0.0, 0.0, -1.0, "verlet"))["spin"] == pytest.approx(0.7 / 3.0)


def test_euler_is_ahead_of_the_parabola():
    """Law: v += dt g, x += dt v, summed step by step, gives x0 + v0 n dt + g dt^2 n (n + 1)/2; Verlet's parabola it misses by g t dt/2."""
    g, dt, x, v = np.array([0.0, 0.0, -9.81]), 0.1, np.zeros(3), np.array([0.5, -1.0, 2.0])
    frames = [frame(0, x, v)]
    for step in range(1, 20):
        v = v + dt * g
        x = x + dt * v
        frames.append(frame(step, x, v))
    assert max(off(measure(frames, dt, 9.81, "vector", 0.0, 0.0, -1.0, "euler")).values()) < 1e-14
    path = next(one for one in measure(frames, dt, 9.81, "vector", 0.0, 0.0, -1.0, "verlet") if one.quantity == "path")
    assert path.measured == pytest.approx(9.81 * 1.9 * dt / 2)

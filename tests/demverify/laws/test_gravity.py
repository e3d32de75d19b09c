"""Closed forms with gravity: free flight, fall and rebound, spheres on one another."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from demverify.frames import Frame
from demverify.laws import bounce_apex, column_at_rest, falling_contact, linear_chain
from tests.support.impact_frames import frame
from tests.support.law_frames import off

G = 9.80665
BALL = 4.0 / 3.0 * np.pi * 0.1**3 * 2600.0


def ball(step: int, z: float, v: float) -> Frame:
    return frame(step, [z], [v], [0.0], [0.1], [BALL])


@pytest.mark.parametrize(
    ("stiffness", "restitution", "duration", "leaving", "apex"),
    [(1e4, 0.9, 0.11181750, 2.47544321, 0.41243182), (5e4, 0.6, 0.04905376, 1.60203036, 0.23085515), (1e5, 0.8, 0.03373068, 2.21379521, 0.34987581)],
)
def test_falling_contact(stiffness: float, restitution: float, duration: float, leaving: float, apex: float) -> None:
    """Law: DEM01 of MFIX, its table: when the ball leaves the plane, how fast, and how high it comes."""
    fall, dt = sqrt(0.8 / G), 1e-7
    steps = [0, round(0.5 * fall / dt), round((fall + duration) / dt), round((fall + duration + leaving / G) / dt)]
    states = [(0.5, 0.0), (0.5 - G * (steps[1] * dt) ** 2 / 2, -G * steps[1] * dt), (0.1, leaving), (apex, 0.0)]
    frames = [ball(step, *state) for step, state in zip(steps, states, strict=True)]
    assert max(off(falling_contact.measure(frames, stiffness, restitution, G, dt)).values()) < 5e-7
    assert max(off(falling_contact.measure(frames, 2.0 * stiffness, restitution, G, dt)).values()) > 1e-2
    assert max(off(falling_contact.measure(frames, stiffness, 0.95 * restitution, G, dt)).values()) > 1e-2


def test_bounce_apex() -> None:
    """Law: hard spheres rise to e^2 and e^4 of the drop; a ball that is too slow by 1 % is 2 % too low."""
    speed = sqrt(2.0 * G * 0.4)
    frames = [ball(0, 0.5, 0.0), ball(10, 0.1, -speed), ball(20, 0.1001, sqrt(0.81 * speed**2 - 2e-4 * G))]
    frames += [ball(30, 0.2, -0.5), ball(40, 0.1001, 0.99 * 0.81 * speed)]
    found = off(bounce_apex.measure(frames, 0.9, G, 2))
    assert found["apex 1"] < 1e-12
    assert found["apex 2"] == pytest.approx(1.0 - 0.99**2, rel=0.03)
    with pytest.raises(LookupError, match="3 bounces wanted, 2 seen"):
        bounce_apex.measure(frames, 0.9, G, 3)


@pytest.mark.parametrize(
    ("restitution", "rows"),
    [
        (1.0, {1e-4: (4.32674646e-4, 1.38138579e-3), 5e-4: (4.36237480e-4, 1.37913935e-3), 1e-3: (4.27127992e-4, 1.38355316e-3)}),
        (0.5, {1e-4: (4.37175527e-4, 1.37186802e-3), 5e-4: (4.33883678e-4, 1.36825422e-3), 1e-3: (4.32838581e-4, 1.36628799e-3)}),
    ],
)
def test_linear_chain(restitution: float, rows: dict[float, tuple[float, float]]) -> None:
    """Law: DEM03 of MFIX: heights of the two spheres as an independent integration of its equations gave them, in nine digits."""
    m2 = 4.0 / 3.0 * np.pi * 5e-4**3 * 1e4
    states = {0.0: (4.5e-4, 1.35e-3), **rows}
    frames = [frame(round(t / 1e-7), z, [0.0, 0.0], [0.0, 0.0], [5e-4, 5e-4], [2.0 * m2, m2]) for t, z in states.items()]
    heights = {name: error for name, error in off(linear_chain.measure(frames, 1e3, restitution, G, 1.8e-3, 1e-7)).items() if "height" in name}
    assert len(heights) == 2
    assert max(heights.values()) < 1e-6
    swapped = off(linear_chain.measure(frames, 1e3, 0.7, G, 1.8e-3, 1e-7))
    assert min(swapped["height 1"], swapped["height 2"]) > 1e-2


@pytest.mark.parametrize("normal", ["hooke", "hertz"])
def test_column_at_rest(normal: str) -> None:
    """Law: three spheres; the floor carries all, the upper contact the top sphere. A lifted top sphere and a force left over show."""
    radius, mass, stiffness = np.array([0.01, 0.02, 0.01]), np.array([1.0, 2.0, 3.0]), 1e6
    weight = 10.0 * np.array([6.0, 5.0, 3.0])
    reduced = np.array([0.01, 0.02 / 3.0, 0.02 / 3.0])
    overlap = weight / stiffness if normal == "hooke" else (weight / stiffness / np.sqrt(reduced)) ** (2.0 / 3.0)
    gaps = np.concatenate([radius[:1], radius[1:] + radius[:-1]]) - overlap
    z = np.cumsum(gaps)
    still = frame(9, z, [0.0] * 3, [0.0] * 3, radius, mass)
    assert max(off(column_at_rest.measure([still], normal, stiffness, 10.0)).values()) < 1e-10  # type: ignore[arg-type]
    lifted = frame(9, np.add(z, [0.0, 0.0, 0.5 * overlap[2]]), [0.0] * 3, [0.0, 0.0, 1.5], radius, mass)
    wrong = off(column_at_rest.measure([lifted], normal, stiffness, 10.0))  # type: ignore[arg-type]
    assert wrong["force at contact 2"] == pytest.approx(0.5 if normal == "hooke" else 1.0 - 0.5**1.5, rel=1e-9)
    assert wrong["force left over"] == pytest.approx(0.05)
    assert wrong["force at floor"] < 1e-10

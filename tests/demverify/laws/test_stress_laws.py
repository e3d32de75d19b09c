"""Closed forms and conservation laws of the stress scenes, on motion that is known."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws import bounded_oscillation, elastic_scattering, released_spring, stays_at_rest
from tests.support.law_frames import frame, off


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 4.0)])
def test_a_spring_lets_go_what_it_holds(masses: tuple[float, float]) -> None:
    """Law: 1/2 k d^2 = 1/2 m* v^2, momentum stays; a tenth more speed is seen, and so is speed the other way."""
    m = np.array(masses)
    reduced, k, d, dt = m.prod() / m.sum(), 100.0, 0.2, 1e-3
    speed = d * np.sqrt(k / reduced)
    theta = dt * np.sqrt(k / reduced)
    still = frame(0, [[0, 0, 0], [0.8, 0, 0]], np.zeros((2, 3)), mass=m)

    def parted(v: float) -> dict[str, float]:
        after = frame(9, [[-1, 0, 0], [1, 0, 0]], [[-v * reduced / m[0], 0, 0], [v * reduced / m[1], 0, 0]], mass=m)
        return off(released_spring.measure([still, after], theta, dt))

    assert max(parted(speed).values()) < 1e-12
    assert parted(1.1 * speed)["speed of parting"] == pytest.approx(0.1)
    assert parted(-speed)["speed of parting"] == pytest.approx(2.0)


def test_a_spring_of_a_plane_lets_go() -> None:
    """Law: of a plane k d^2 = m v^2, upwards."""
    frames = [frame(0, [0, 0, 0.4], [0, 0, 0]), frame(9, [0, 0, 2], [0, 0, 3.0])]
    assert max(off(released_spring.measure(frames, 0.03, 1e-3)).values()) < 1e-12


@pytest.mark.parametrize(("quantity", "x", "v", "w"), [("drift", 1e-6, 0, 0), ("speed", 0, 1e-6, 0), ("spin", 0, 0, 1e-6), (None, 0, 0, 0)])
def test_rest_is_rest(quantity: str | None, x: float, v: float, w: float) -> None:
    """Law: after the first tenth, in which springs are wound, any way, speed or spin is seen, and nothing else."""
    frames = [frame(0, [0.1, 0, 0], [1, 0, 0], [0, 1, 0]), *(frame(k, [x * k, 0, 0], [v, 0, 0], [0, w, 0]) for k in range(1, 20))]
    missed = {name for name, miss in off(stays_at_rest.measure(frames, 9.81)).items() if miss > 1e-8}
    assert missed == ({quantity} if quantity else set())


def test_elastic_spheres_keep_momentum_and_energy() -> None:
    """Law: unequal spheres that exchange speeds as an elastic impact does; a sphere that has lost a hundredth of its speed is seen in both."""
    m = np.array([1.0, 3.0])
    before = frame(0, [[0, 0, 0], [2, 0, 0]], [[1, 0, 0], [0, 0, 0]], mass=m)
    whole = elastic_scattering.measure([before, frame(9, [[-1, 0, 0], [3, 0, 0]], [[-0.5, 0, 0], [0.5, 0, 0]], mass=m)])
    assert max(off(whole).values()) < 1e-12
    short = off(elastic_scattering.measure([before, frame(9, [[-1, 0, 0], [3, 0, 0]], [[-0.5, 0, 0], [0.495, 0, 0]], mass=m)]))
    assert min(short.values()) > 5e-3


def test_no_farther_than_the_start() -> None:
    """Law: |x| stays within its first value; growth and NaN are seen, a phase that is off is not asked for."""
    swing = [frame(k, [0, 0, 1.0 + 0.1 * np.cos(0.9 * k)], [0, 0, 0]) for k in range(30)]
    assert off(bounded_oscillation.measure(swing, 1.0))["amplitude"] < 1e-12
    assert off(bounded_oscillation.measure([*swing, frame(31, [0, 0, 0.88], [0, 0, 0])], 1.0))["amplitude"] == pytest.approx(0.2)
    assert np.isnan(off(bounded_oscillation.measure([*swing, frame(31, [0, 0, np.nan], [0, 0, 0])], 1.0))["amplitude"])

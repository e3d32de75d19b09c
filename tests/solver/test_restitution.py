"""Closed forms of restitution: limits, inverses, and impacts through `Simulation` on linear and Hertz springs, with and without the pulling tail."""

from __future__ import annotations

from math import exp, log, pi, sqrt
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import Box, ContactLaw, EulerSphere, Neighbor, NveSphere, Particles, Scene, Simulation, Slab, Wall
from demsolver.restitution import Spring, fraction_for, of_fraction

SPRINGS: tuple[Spring, ...] = get_args(Spring)
WANTED = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0])


@pytest.mark.parametrize("spring", SPRINGS)
@pytest.mark.parametrize("limit", [False, True])
@given(e=st.floats(1e-6, 1.0))
def test_the_inverse_is_the_inverse(spring: Spring, limit: bool, e: float) -> None:
    """Law: e(fraction(e)) = e."""
    # With the tail and e -> 0 the damping ratio nears 1 as 1 - pi^2/(2 ln^2 e): at 1e-6 a rounding of it weighs some 300 times.
    assert of_fraction(fraction_for(e, spring, limit_damping=limit), spring, limit_damping=limit) == pytest.approx(e, rel=1e-12)


@pytest.mark.parametrize("limit", [False, True])
@given(fraction=st.floats(0.0, 5.0), more=st.floats(1e-6, 1.0))
def test_more_damping_less_restitution(limit: bool, fraction: float, more: float) -> None:
    """Law: e falls from 1 as the fraction grows, and is never larger with the tail than without."""
    assert of_fraction(0.0, "hooke", limit_damping=limit) == 1.0
    less = of_fraction(fraction + more, "hooke", limit_damping=limit)
    assert less < of_fraction(fraction, "hooke", limit_damping=limit) or less == 0.0
    assert of_fraction(fraction, "hooke") <= of_fraction(fraction, "hooke", limit_damping=True)


def test_critical_damping() -> None:
    """Law: at the damping ratio 1 the contact with tail never ends, e = 0; without it e = exp(-2), from both sides."""
    assert of_fraction(2.0, "hooke") == 0.0
    for b in (1.0 - 1e-9, 1.0, 1.0 + 1e-9):
        assert of_fraction(2.0 * b, "hooke", limit_damping=True) == pytest.approx(exp(-2.0), rel=1e-7)  # arccos of 1 - 1e-9 has 8 digits


def test_hertz_is_hooke_in_another_variable() -> None:
    """Law: with s = overlap^(5/4) the Hertz impact is the linear one, b = alpha/sqrt(5)."""
    for e in WANTED:
        assert fraction_for(e, "hertz") == pytest.approx(sqrt(5.0) / 2.0 * fraction_for(e, "hooke"), rel=1e-14)
    assert fraction_for(0.5, "hooke") == pytest.approx(2.0 * log(2.0) / sqrt(pi**2 + log(2.0) ** 2), rel=1e-14)


@pytest.mark.parametrize("e", [0.0, -0.1, 1.1, float("nan")])
def test_a_restitution_out_of_range_is_refused(e: float) -> None:
    """Law: the error says the value and the range."""
    with pytest.raises(ValueError, match=r"restitution .* must be above 0, and at most 1"):
        fraction_for(e, "hooke")


def test_other_wrong_input_is_refused() -> None:
    """Law: a negative fraction, and a spring that is none, by value and name."""
    with pytest.raises(ValueError, match=r"damping_fraction -1\.0 must not be negative"):
        of_fraction(-1.0, "hooke")
    with pytest.raises(ValueError, match="spring 'hurtz' is not one of hooke, hertz"):
        of_fraction(0.1, "hurtz")  # type: ignore[arg-type]


def impacts(spring: Spring, limit: bool, steps: int, integrator: EulerSphere | NveSphere) -> np.ndarray:
    """Restitution through Simulation of one sphere for each of WANTED, a contact lasting some `steps` steps.

    Radius, mass and speed 1; kn = 100 gives overlaps of 0.1 and contacts of about 0.3 on either spring.
    """
    n, kn, dt = len(WANTED), 100.0, 0.3 / steps
    fraction = np.array([fraction_for(e, spring, limit_damping=limit) for e in WANTED])
    law = ContactLaw(spring, "fraction", "none", "none", "none", {"kn": np.full(n, kn), "damping_fraction": fraction}, limit_damping=limit)
    x = np.column_stack([5.0 * np.arange(n), np.zeros(n), np.full(n, 1.0 + 0.3 * dt)])
    v = np.tile([0.0, 0.0, -1.0], (n, 1))
    p = Particles(
        np.arange(1, n + 1), np.arange(1, n + 1), x, v, np.zeros((n, 3)), np.ones(n), np.ones(n), np.ones(n, dtype=int), np.zeros((n, 3), int)
    )  # fmt: skip
    box = Box(np.full(3, -100.0), np.full(3, 100.0), ("ff", "ff", "ff"))
    walls = (Wall("floor", Slab(2, lo=0.0), law),)
    scene = Scene(box, p, n, dt, walls=walls, integrate=(integrator,), neighbor=Neighbor(50.0))  # type: ignore[arg-type]
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(6 * steps)
    return simulation.bodies.v[:, 2].copy()


@pytest.mark.parametrize("spring", SPRINGS)
@pytest.mark.parametrize("limit", [False, True])
def test_restitution_comes_out_as_asked(spring: Spring, limit: bool) -> None:
    """Law: through Simulation e comes out within 1e-4 of the closed form; the error falls with the step (1e5 steps a contact here)."""
    assert impacts(spring, limit, 100_000, NveSphere()) == pytest.approx(WANTED, rel=1e-4)


def test_semi_implicit_euler_gives_the_same() -> None:
    """Law: so it does with semi-implicit Euler, which sees the velocities that velocity Verlet hands to the dashpot, half a step old."""
    assert impacts("hooke", False, 100_000, EulerSphere()) == pytest.approx(WANTED, rel=1e-4)


@pytest.mark.parametrize("limit", [False, True])
def test_the_two_forms_are_not_each_other(limit: bool) -> None:
    """Law: the fraction of one form run under the other misses e, by 0.12 at e = 0.2: the tail matters."""
    tail, none = (of_fraction(fraction_for(0.2, "hooke", limit_damping=limit), "hooke", limit_damping=other) for other in (limit, not limit))
    assert tail == pytest.approx(0.2, rel=1e-12)
    assert abs(none - 0.2) > 0.1

"""LIGGGHTS' cohesion sjkr alone: the circle and the lens as geometry has them, and what the limits of friction and rolling see of it."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from demsolver import Box, ContactLaw, Scene, Slab, Wall
from demsolver.contact.cohesion_sjkr import energy, force
from demsolver.reference import forces
from tests.support.scenes import spheres

radii = st.integers(1, 1000).map(lambda k: k * 1e-5)
shares = st.integers(1, 999).map(lambda k: k * 1e-3)


def cap(radius: float, height: float) -> float:
    """Volume of a cap: Gauss-Legendre quadrature of its discs, exact for a polynomial."""
    points, weights = np.polynomial.legendre.leggauss(4)
    depth = 0.5 * height * (points + 1.0)
    return float(0.5 * height * np.sum(weights * pi * depth * (2.0 * radius - depth)))


@settings(deadline=None)
@given(radius=radii, partner=radii, share=shares)
def test_circle_and_lens_of_two_spheres(radius: float, partner: float, share: float) -> None:
    """Law: F = -k A, A the circle in which the spheres meet; E = -k V, V the two caps on either side of its plane."""
    overlap = 2.0 * share * min(radius, partner)
    distance = radius + partner - overlap
    assume(distance > 0.0)
    plane = (distance**2 + radius**2 - partner**2) / (2.0 * distance)  # of the circle, from the centre of the particle
    area, volume = pi * (radius**2 - plane**2), cap(radius, radius - plane) + cap(partner, partner - (distance - plane))
    # the circle is a small difference of squares where the overlap is small
    assert force(overlap, radius, 1.0 / partner, 3.0) == pytest.approx(-3.0 * area, rel=1e-9, abs=1e-14 * 3.0 * pi * radius**2)
    assert energy(overlap, radius, 1.0 / partner, 3.0) == pytest.approx(-3.0 * volume, rel=1e-9, abs=1e-14 * 3.0 * radius**3)


@settings(deadline=None)
@given(radius=radii, share=shares)
def test_circle_and_cap_at_a_plane(radius: float, share: float) -> None:
    """Law: at a wall, which has no curvature, A = pi (R^2 - r^2) at the distance r = R - overlap, and V is the cap beyond it."""
    overlap = share * radius
    assert force(overlap, radius, 0.0, 3.0) == pytest.approx(-3.0 * pi * (radius**2 - (radius - overlap) ** 2), rel=1e-12)
    assert energy(overlap, radius, 0.0, 3.0) == pytest.approx(-3.0 * cap(radius, overlap), rel=1e-12)


@settings(deadline=None)
@given(radius=radii, partner=radii, share=shares)
def test_neither_sphere_is_special(radius: float, partner: float, share: float) -> None:
    """Law: seen from the partner, force and energy are the same."""
    overlap = share * min(radius, partner)
    for law in (force, energy):
        assert law(overlap, radius, 1.0 / partner, 1.0) == pytest.approx(law(overlap, partner, 1.0 / radius, 1.0), rel=1e-12)


@settings(deadline=None)
@given(radius=radii, share=shares, curvature=st.sampled_from([0.0, 1e2, 1e5]))
def test_a_contact_begins_and_ends_without_a_jump(radius: float, share: float, curvature: float) -> None:
    """Law: force and energy are 0 at the first touch, and the force grows there as -2 pi k R* overlap."""
    assert force(0.0, radius, curvature, 3.0) == energy(0.0, radius, curvature, 3.0) == 0.0
    overlap = 1e-6 * share * radius / (1.0 + curvature * radius)
    reff = radius / (1.0 + curvature * radius)
    assert force(overlap, radius, curvature, 3.0) == pytest.approx(-6.0 * pi * reff * overlap, rel=2e-6)


def resting(*, reduced: bool, rolling: str = "none") -> tuple[np.ndarray, np.ndarray, float, float]:
    """Force and torque (3,) on a ball that slides and rolls over a floor that pulls it, its spring force, and the pull."""
    overlap, k = 1e-5, 4e6
    values = {"kn": 1e4, "gt": 1.0, "gammat": 1.0, "mu": 0.3, "rolling_friction": 0.2, "torsion": 0.0}
    values |= {"cohesion_energy_density": k, "shear_stiffness": 1e9}
    law = ContactLaw(
        "hooke", "none", "constant", "absolute", "no_history", {name: np.array([value]) for name, value in values.items()},
        cohesion="sjkr", rolling=rolling, tangential_reduce=reduced,
    )  # fmt: skip
    p = spheres(np.array([[0.0, 0.0, 0.005 - overlap]]), np.array([0.005]), v=np.array([[9.0, 0.0, 0.0]]), omega=np.array([[0.0, 50.0, 0.0]]))
    scene = Scene(Box(np.full(3, -1.0), np.full(3, 1.0), ("ff",) * 3), p, 1, 1e-5, walls=(Wall("floor", Slab(2, lo=0.0), law),))
    found = forces(scene, p.x, p.v, p.omega, {}, True)
    return found[0][0], found[1][0], 1e4 * overlap, -force(overlap, 0.005, 0.0, k)


@pytest.mark.parametrize(("reduced", "rolling"), [(False, "none"), (True, "none"), (False, "epsd2"), (True, "epsd2")])
def test_limits_see_cohesion_only_when_told(reduced: bool, rolling: str) -> None:
    """Law: the normal force is spring less pull; friction and rolling are limited by mu times the spring force, with tangential_reduce
    by mu times the size of what is left of it, also where that pulls."""
    found, turn, spring, pull = resting(reduced=reduced, rolling=rolling)
    assert pull > 1.5 * spring
    limiting = pull - spring if reduced else spring
    assert found[2] == pytest.approx(spring - pull, rel=1e-12)
    assert found[0] == pytest.approx(-0.3 * limiting, rel=1e-12)
    rolled = turn[1] - 0.005 * 0.3 * limiting  # less the torque of friction
    assert rolled == pytest.approx(-0.2 * 0.005 * limiting if rolling != "none" else 0.0, rel=1e-12, abs=1e-15)

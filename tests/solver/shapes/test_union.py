"""Unions of spheres against closed forms, symmetries and nested quadrature; spheres that do not know of each other."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from demsolver.shapes.union import Solid, steiner, sum_of_spheres, union
from tests.support.unions import inertia_by_slices

Floats = NDArray[np.float64]
# Sums of some thousand terms of the size of the result, each good to 2e-16. Measured against 80-bit arithmetic: 1e-15 in general position,
# 1e-13 for spheres that touch within 1e-8.
ROUNDING = 1e-13
LENGTH = st.floats(-2, 2)
SPHERE = st.tuples(LENGTH, LENGTH, LENGTH, st.floats(0.3, 1.5))
CLUMP = st.lists(SPHERE, min_size=1, max_size=7).map(np.array)
TURN = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1).map(lambda q: Rotation.from_quat(q).as_matrix())


def of(spheres: Floats) -> Solid:
    """The union of rows x y z r."""
    return union(spheres[:, :3], spheres[:, 3])


def assert_same(found: Solid, law: Solid, tolerance: float = ROUNDING) -> None:
    """Volume, centroid and inertia, relative to the largest component; the centroid relative to the size of the body."""
    assert_allclose(found.volume, law.volume, rtol=tolerance)
    assert_allclose(found.centroid, law.centroid, rtol=tolerance, atol=tolerance * law.volume ** (1 / 3))
    assert_allclose(found.inertia, law.inertia, rtol=0, atol=tolerance * np.abs(law.inertia).max())


def moved(solid: Solid, turn: Floats, shift: Floats) -> Solid:
    """The body turned, then shifted."""
    return Solid(solid.volume, turn @ solid.centroid + shift, turn @ solid.inertia @ turn.T)


def on_one_line(z: Floats, radius: Floats) -> Solid:
    """Spheres with centres on the z axis: discs pi rho^2, rho the largest of the chords; polynomials of degree 4 between the breaks."""
    pairs = [(z[i], z[j], radius[i], radius[j]) for i in range(len(z)) for j in range(len(z)) if abs(radius[i] - radius[j]) < z[j] - z[i]]
    meet = [(a + b) / 2 + (r * r - s * s) / (2 * (b - a)) for a, b, r, s in pairs]
    breaks = np.unique(np.concatenate([z - radius, z + radius, meet]))
    node, weight = np.polynomial.legendre.leggauss(3)
    half = (breaks[1:] - breaks[:-1])[:, None] / 2
    at, weight = ((breaks[1:] + breaks[:-1])[:, None] / 2 + half * node).ravel(), (half * weight).ravel()
    square = np.maximum(radius**2 - (at[:, None] - z) ** 2, 0).max(1)
    volume, first, along = (np.pi * weight @ (at**n * square) for n in range(3))
    across = np.pi / 4 * weight @ square**2
    steep = across + along - first**2 / volume
    return Solid(volume, np.array([0, 0, first / volume]), np.diag([steep, steep, 2 * across]))


def test_one_sphere() -> None:
    """Law: V = 4/3 pi R^3, I = 2/5 V R^2 about the centre."""
    volume = 4 / 3 * np.pi * 8
    assert_same(union(np.array([[1.0, -2.0, 3.0]]), np.array([2.0])), Solid(volume, np.array([1.0, -2.0, 3.0]), 1.6 * volume * np.eye(3)), 1e-15)


@pytest.mark.parametrize("apart", [0.4, 0.5, 0.500001, 0.8, 1.0, 1.3, 1.499999, 1.5, 2.0])
def test_two_spheres_minus_their_lens(apart: float) -> None:
    """Law: V = V1 + V2 - pi (R + r - d)^2 (d^2 + 2 d (R + r) - 3 (R - r)^2) / (12 d), for radii R and r with centres d apart,
    also when one is inside the other (no such lens) or touches it, in- or outside."""
    big, small = 1.0, 0.5
    lens = np.pi * (big + small - apart) ** 2 * (apart**2 + 2 * apart * (big + small) - 3 * (big - small) ** 2) / (12 * apart)
    lens = 4 / 3 * np.pi * small**3 if apart <= big - small else lens * (apart < big + small)
    found = union(np.array([[0.0, 0, 0], np.array([2.0, 1, -2]) / 3 * apart]), np.array([big, small]))
    assert_allclose(found.volume, 4 / 3 * np.pi * (big**3 + small**3) - lens, rtol=ROUNDING)


@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(0.2, 1.5)), min_size=1, max_size=6, unique_by=lambda s: s[0]), TURN)
def test_centres_on_a_line(spheres: list[tuple[float, float]], turn: Floats) -> None:
    """Law: a chain is a solid of revolution, V = integral of pi rho^2 dz, and so on, of piecewise polynomials."""
    z, radius = np.array(spheres).T
    law = on_one_line(z, radius)
    shift = np.array([0.3, -0.2, 5.0])
    assert_same(union(np.outer(z, turn[:, 2]) + shift, radius), moved(law, turn, shift))


@pytest.mark.parametrize("seed", [1, 2])
def test_general_clump_against_nested_quadrature(seed: int) -> None:
    """Law: V, centroid and I are integrals of 1, x and x x over planes, lines and segments. 40 nodes a piece are good to 2e-12 here
    (5e-10 with 20: the error of 40 is about its square)."""
    rng = np.random.default_rng(seed)
    centre, radius = rng.normal(size=(4, 3)) * 0.6, rng.uniform(0.4, 1.0, 4)
    assert_same(union(centre, radius), Solid(*inertia_by_slices(centre, radius)), 1e-11)


@settings(deadline=None)
@given(CLUMP, TURN, st.tuples(LENGTH, LENGTH, LENGTH).map(np.array), st.sampled_from([1e-6, 1e-3, 1.0, 1e3]))
def test_turned_shifted_and_scaled(spheres: Floats, turn: Floats, shift: Floats, scale: float) -> None:
    """Law: a turned, shifted and scaled clump has the same volume times scale^3, and an inertia turned with it, times scale^5."""
    law = moved(of(spheres), turn, shift)
    found = union(scale * (spheres[:, :3] @ turn.T + shift), scale * spheres[:, 3])
    assert_same(Solid(found.volume / scale**3, found.centroid / scale, found.inertia / scale**5), law)


@settings(deadline=None)
@given(CLUMP, st.randoms(use_true_random=False))
def test_repeated_and_hidden_spheres_change_nothing(spheres: Floats, random) -> None:
    """Law: A ∪ A = A, and A ∪ B = A for B inside A, whatever the order."""
    inner = spheres.copy()
    inner[:, 0] += 0.3 * inner[:, 3]
    inner[:, 3] *= 0.7  # touches its sphere from inside
    rows = [*spheres, *spheres, *inner]
    random.shuffle(rows)
    assert_same(of(np.array(rows)), of(spheres), 1e-12)  # of each pair that touches, one goes at 1e-13 of the largest radius


@settings(deadline=None)
@given(CLUMP, CLUMP)
def test_parts_that_do_not_meet_add_up(one: Floats, other: Floats) -> None:
    """Law: volumes add, centroids weigh by volume, inertias add with Steiner's terms."""
    far = other + np.array([20.0, 5.0, 0.0, 0.0])
    a, b = of(one), of(far)
    arm = b.centroid - a.centroid
    steiners = a.volume * b.volume / (a.volume + b.volume) * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    centroid = (a.volume * a.centroid + b.volume * b.centroid) / (a.volume + b.volume)
    assert_same(of(np.vstack([one, far])), Solid(a.volume + b.volume, centroid, a.inertia + b.inertia + steiners))


@settings(deadline=None)
@given(CLUMP)
def test_no_more_than_the_spheres_no_less_than_the_largest(spheres: Floats) -> None:
    """Law: the union is as large as the spheres together only where they do not overlap, and contains the largest of them."""
    each = 4 / 3 * np.pi * spheres[:, 3] ** 3
    assert each.max() * (1 - ROUNDING) <= of(spheres).volume <= each.sum() * (1 + ROUNDING)


GRID = np.array(list(product([0.0, 1.0, 2.0], repeat=3)))
TOUCHING = {
    "edges of cubes touch": np.sqrt(1 / 2),
    "corners of cubes touch": np.sqrt(3 / 4),
    "faces touch": 0.5,
    "through the next centre": 1.0,
    "through the corner": np.sqrt(2),
}


@pytest.mark.parametrize("radius", TOUCHING.values(), ids=TOUCHING)
@pytest.mark.parametrize("shake", [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6])
def test_spheres_on_a_grid(radius: float, shake: float) -> None:
    """Law: a small change of the spheres changes the body little, also where many of them meet in one point, touch there, or share
    their circles: by no more than some areas times the shift."""
    rng = np.random.default_rng(5)
    turn = Rotation.random(random_state=1).as_matrix()
    centre = GRID + shake * rng.uniform(-1, 1, GRID.shape)
    law = union(GRID, np.full(len(GRID), radius))
    assert_same(union(centre @ turn.T, np.full(len(GRID), radius)), moved(law, turn, np.zeros(3)), 5 * shake + ROUNDING)


def test_a_solid_ball_of_spheres_on_a_grid() -> None:
    """Law: spheres of radius 1/2 at the points of a grid only touch: 27 pi/6, moments those of the spheres apart."""
    assert_same(union(GRID, np.full(27, 0.5)), sum_of_spheres(GRID, np.full(27, 0.5)))


@pytest.mark.parametrize("shake", [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-10, 1e-7])
def test_spheres_through_one_circle(shake: float) -> None:
    """Law: spheres with centres z through the circle x^2 + y^2 = 1, z = 0 have all caps on it, some on top of each other, some facing.
    The union is that of the two outermost; shaken, the change stays of the size of the shift."""
    z = np.array([0.0, 0.5, -0.5, 1.0, -1.0, 0.3, 2.0])
    law = on_one_line(np.array([-1.0, 2.0]), np.sqrt(1 + np.array([-1.0, 2.0]) ** 2))
    rng = np.random.default_rng(6)
    turn = Rotation.random(random_state=2).as_matrix()
    centre = np.outer(z, [0, 0, 1]) + shake * rng.uniform(-1, 1, (7, 3))
    assert_same(union(centre @ turn.T, np.sqrt(1 + z**2)), moved(law, turn, np.zeros(3)), 10 * shake + ROUNDING)


def test_three_spheres_that_meet_in_one_point() -> None:
    """Law: on the sides of a triangle of side sqrt(3) unit spheres meet in its middle only in pairs, so inclusion and exclusion of
    lenses is exact: V = 3 (4/3 pi) - 3 lenses."""
    corners = np.array([[np.cos(a), np.sin(a), 0.0] for a in 2 * np.pi / 3 * np.arange(3)])
    lens = np.pi / 12 * (4 + np.sqrt(3)) * (2 - np.sqrt(3)) ** 2
    for centre in (corners, corners @ Rotation.random(random_state=3).as_matrix()):
        assert_allclose(union(centre, np.ones(3)).volume, 4 * np.pi - 3 * lens, rtol=ROUNDING)


def test_many_spheres_of_very_different_size() -> None:
    """Law: spheres on the surface of a large one add each its own part outside: V = V of the pairs - (n - 1) V of the large one,
    where the small ones do not meet."""
    rng = np.random.default_rng(7)
    axes = Rotation.random(200, random_state=4).apply([0.0, 0.0, 1.0])
    small = 10.0 ** rng.uniform(-6, -3, 200)
    keep = [i for i in range(200) if all(np.linalg.norm(axes[i] - axes[j]) > small[i] + small[j] for j in range(i))]
    large = np.zeros(3)
    pairs = [union(np.vstack([large, axes[i]]), np.array([1.0, small[i]])).volume - 4 / 3 * np.pi for i in keep]
    found = union(np.vstack([large[None], axes[keep]]), np.append(1.0, small[keep]))
    assert_allclose(found.volume, 4 / 3 * np.pi + sum(pairs), rtol=ROUNDING)


def test_sum_of_spheres() -> None:
    """Law: seed compute-erotate, eq. (5), sphere by sphere: 2/5 m R^2 + m (r.r - r r^T); two unit balls 2 d apart: I = 2 (2/5 m + m d^2)."""
    mass = 4 / 3 * np.pi
    found = sum_of_spheres(np.array([[0.0, 0, -0.25], [0.0, 0, 0.25]]), np.ones(2))
    assert_same(found, Solid(2 * mass, np.zeros(3), mass * np.diag([0.8 + 0.125, 0.8 + 0.125, 0.8])), 1e-15)


def test_masses_of_many_bodies_at_once() -> None:
    """Law: the inertia about the centre of mass is that about the origin less M (X.X - X X^T); here for 5 bodies of 4 spheres."""
    rng = np.random.default_rng(8)
    mass, centre, radius = rng.uniform(1, 2, (5, 4)), rng.normal(size=(5, 4, 3)), rng.uniform(0, 1, (5, 4))
    total, middle, inertia = steiner(mass, centre, radius)
    for i in range(5):
        origin = sum(m * (0.4 * r * r + x @ x) * np.eye(3) - m * np.outer(x, x) for m, x, r in zip(mass[i], centre[i], radius[i], strict=True))
        x = mass[i] @ centre[i] / mass[i].sum()
        law = origin - mass[i].sum() * (x @ x * np.eye(3) - np.outer(x, x))
        assert_same(Solid(float(total[i]), middle[i], inertia[i]), Solid(mass[i].sum(), x, law))


@pytest.mark.parametrize(
    ("centre", "radius", "says"),
    [
        (np.empty((0, 3)), np.empty(0), "at least one sphere"),
        (np.zeros((2, 3)), np.ones(3), r"\(2, 3\) and \(3,\)"),
        (np.zeros((1, 3)), np.zeros(1), "radius above zero, got sphere 1: 0 0 0 0"),
        (np.zeros((2, 3)), np.array([1.0, -1.0]), "sphere 2: 0 0 0 -1"),
        (np.array([[0.0, np.nan, 0.0]]), np.ones(1), "sphere 1: 0 nan 0 1"),
        (np.zeros((1, 3)), np.array([np.inf]), "finite"),
    ],
)
@pytest.mark.parametrize("of_spheres", [union, sum_of_spheres])
def test_what_is_no_clump(centre: Floats, radius: Floats, says: str, of_spheres) -> None:
    """Law: spheres need a finite centre and a positive radius each."""
    with pytest.raises(ValueError, match=says):
        of_spheres(centre, radius)

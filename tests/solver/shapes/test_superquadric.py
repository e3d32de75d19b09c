"""Superquadrics: closed forms against the integral of the body's equation, the book's beta functions, and exact limits."""

from __future__ import annotations

from itertools import permutations
from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.special import beta, zeta

from demsolver.shapes.superquadric import inertia_per_mass, volume

Floats = NDArray[np.float64]

# Each of the closed forms is a product of five to eight gamma functions of about 3e-16 each; 2e-15 is the worst seen in 300 pairs of exponents.
ROUNDING = 5e-15
AXES = np.array([1.0, 1.5, 0.7])
EXPONENTS = [
    (2, 2), (2.006, 2.004), (2.1, 2.3), (2.5, 3.5), (3, 2), (4, 4), (6, 3), (8, 2), (2, 8), (20, 20), (50, 3.3), (200, 2), (2, 200), (200, 200)
]  # fmt: skip

NODES, WEIGHTS = leggauss(14)
# Shares of the way from an axis, where r(d) has the singularity of t^n, to an edge of the body, where it bends within 1/n.
MESH = np.array([0, 0.001, 0.006, 0.03, 0.12, 0.35, 0.65, 0.86, 0.95, 0.985, 0.996, 1.0])


def rule(start: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Gauss-Legendre panels from axis to edge: points and weights, (..., k) each."""
    middle, half = (MESH[1:] + MESH[:-1]) / 2, np.diff(MESH) / 2
    points, weights = (middle[:, None] + half[:, None] * NODES).ravel(), (half[:, None] * WEIGHTS).ravel()
    length = np.asarray(end - start)[..., None]
    return start[..., None] + length * points, np.abs(length) * weights


def quarter(edge: Floats) -> tuple[Floats, Floats]:
    """Points and weights on both sides of an edge, between the axes at angles 0 and pi/2."""
    sides = rule(np.zeros_like(edge), edge), rule(np.full_like(edge, pi / 2), edge)
    return np.concatenate([sides[0][0], sides[1][0]], axis=-1), np.concatenate([sides[0][1], sides[1][1]], axis=-1)


def integrated(shape: Floats, n1: float, n2: float) -> tuple[float, Floats]:
    """Volume and inertia per mass from the equation of the body alone, without gamma functions.

    In x = a r d1, y = b r d2, z = c r d3 with a direction d the surface is at r = f(d)^(-1/n1), f = (|d1|^n2 + |d2|^n2)^(n1/n2) + |d3|^n1.
    The volume is abc times the integral of r^3 / 3 over all directions, the integral of x^2 is a^3 b c times that of d1^2 r^5 / 5.
    """
    phi, over_phi = quarter(np.array(pi / 4))
    around = (np.cos(phi) ** n2 + np.sin(phi) ** n2) ** (1 / n2)
    theta, over_theta = quarter(np.arctan2(1, around))
    r = ((around[:, None] * np.sin(theta)) ** n1 + np.cos(theta) ** n1) ** (-1 / n1)
    d = np.stack([np.sin(theta) * np.cos(phi)[:, None], np.sin(theta) * np.sin(phi)[:, None], np.cos(theta)])
    weight = 8 * over_phi[:, None] * over_theta * np.sin(theta) * shape.prod()
    size = float((weight * r**3).sum() / 3)
    squares = shape**2 * (weight * r**5 * d**2).sum(axis=(1, 2)) / 5 / size
    return size, squares.sum() - squares


def of_one(shape: Floats, n1: float, n2: float) -> tuple[float, Floats]:
    """Closed forms for a single body."""
    return float(volume(shape[None], np.array([[n1, n2]]))[0]), inertia_per_mass(shape[None], np.array([[n1, n2]]))[0]


@pytest.mark.parametrize(("n1", "n2"), EXPONENTS)
def test_volume_and_inertia_are_the_integrals_over_the_body(n1: float, n2: float) -> None:
    """Law: V and I/m from the closed forms are the integrals of 1 and of r^2 - x_k^2 over the body's equation."""
    size, moments = of_one(AXES, n1, n2)
    size_integrated, moments_integrated = integrated(AXES, n1, n2)
    assert_allclose(size, size_integrated, rtol=ROUNDING)  # 14 nodes on each of 22 x 22 panels: the quadrature is exact to rounding
    assert_allclose(moments, moments_integrated, rtol=ROUNDING)


@pytest.mark.parametrize(("n1", "n2"), EXPONENTS)
def test_volume_and_inertia_are_the_beta_functions_of_the_book(n1: float, n2: float) -> None:
    """Law: V and I are the printed formulas of Jaklič, Leonardis and Solina, ch. 2, with e1 = 2/n1 and e2 = 2/n2."""
    (a, b, c), e1, e2 = AXES, 2 / n1, 2 / n2
    size = 2 * a * b * c * e1 * e2 * beta(e1 / 2, e1 + 1) * beta(e2 / 2, e2 / 2 + 1)
    across = beta(3 * e2 / 2, e2 / 2) * beta(e1 / 2, 2 * e1 + 1)
    along = 4 * c**2 * beta(e2 / 2, e2 / 2 + 1) * beta(3 * e1 / 2, e1 + 1)
    inertia = a * b * c * e1 * e2 / 2 * np.array([b**2 * across + along, a**2 * across + along, (a**2 + b**2) * across])
    found, moments = of_one(AXES, n1, n2)
    assert_allclose(found, size, rtol=ROUNDING)
    assert_allclose(moments * found, inertia, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ((1, 2, 3, 2, 2), (25.132741, 65.345127, 50.265482, 25.132741)),
        ((0.0015, 0.0025, 0.0035, 4, 4), (8.5076084e-8, 4.3151501e-13, 3.3821446e-13, 1.9826365e-13)),
        ((1, 1, 2, 10, 2), (12.230741, 18.5715, 18.5715, 5.9845069)),
        ((1, 1.5, 2, 8, 2), (18.100682, 32.455675, 26.972374, 14.256582)),
        ((1, 1.5, 2, 2, 8), (15.655373, 21.592436, 16.554582, 13.098421)),
        ((1, 2, 0.5, 6, 3), (6.6057313, 7.618071, 2.2760901, 8.9033014)),
        ((1, 1, 1, 20, 20), (7.9104806, 5.2030028, 5.2030028, 5.2030028)),
    ],
)
def test_table_of_volumes_and_inertias(row: tuple[float, ...], expected: tuple[float, ...]) -> None:
    """Law: V and I per density of seven bodies (a b c n1 n2) are the numbers an independent program printed, in eight digits."""
    size, moments = of_one(np.array(row[:3], dtype=float), *row[3:])
    assert_allclose([size, *size * moments], expected, rtol=5e-8)  # half a unit of the eighth digit of a number that starts with 1


def test_an_ellipsoid_is_the_default_and_exact() -> None:
    """Law: n1 = n2 = 2, or no blockiness, is 4/3 pi abc and (b^2 + c^2)/5: to a few units in the last place."""
    (a, b, c), shapes = AXES, AXES[None]
    assert_allclose(volume(shapes), [4 / 3 * pi * a * b * c], rtol=1e-15)
    assert_allclose(inertia_per_mass(shapes), [[(b * b + c * c) / 5, (a * a + c * c) / 5, (a * a + b * b) / 5]], rtol=1e-15)
    assert_array_equal(volume(shapes), volume(shapes, np.array([[2.0, 2.0]])))
    assert_array_equal(inertia_per_mass(shapes), inertia_per_mass(shapes, np.array([[2.0, 2.0]])))


def test_infinite_exponents_are_the_cylinder_and_the_box() -> None:
    """Law: n1 = inf, n2 = 2 is an elliptic cylinder of height 2c, n1 = n2 = inf a box of edges 2a, 2b, 2c; both without a NaN."""
    a, b, c = AXES
    size, moments = of_one(AXES, inf, 2)
    assert_allclose(size, 2 * pi * a * b * c, rtol=1e-15)
    assert_allclose(moments, [b * b / 4 + c * c / 3, a * a / 4 + c * c / 3, (a * a + b * b) / 4], rtol=1e-15)
    size, moments = of_one(AXES, inf, inf)
    assert_allclose(size, 8 * a * b * c, rtol=1e-15)
    assert_allclose(moments, [(b * b + c * c) / 3, (a * a + c * c) / 3, (a * a + b * b) / 3], rtol=1e-15)


@pytest.mark.parametrize("n", [1e2, 1e3, 1e4])
def test_the_limits_are_reached_as_one_over_n_squared(n: float) -> None:
    """Law: V falls short of the cylinder by pi^2/3 / n1^2 and of the box by pi^2/2 / n^2, I/m of the box by 2 pi^2/3 / n^2.

    With lnG(1 + x) = -gx + zeta(2) x^2/2 - zeta(3) x^3/3 + ... the next terms are 6, 8 and 24 zeta(3) / n^3. Those after them stay
    below 120 / n^4 (zeta(4)/4 times the sum of the fourth powers of k, most for I); rounding is multiplied by n^2.
    """
    tolerance = 120 / n**2 + ROUNDING * n**2
    (cylinder, _), (box, flat), (near, nearly_flat) = of_one(AXES, inf, 2), of_one(AXES, inf, inf), of_one(AXES, n, n)
    assert (of_one(AXES, n, 2)[0] / cylinder - 1) * n**2 == pytest.approx(-(pi**2) / 3 + 6 * zeta(3) / n, abs=tolerance)
    assert (near / box - 1) * n**2 == pytest.approx(-(pi**2) / 2 + 8 * zeta(3) / n, abs=tolerance)
    assert_allclose((nearly_flat / flat - 1) * n**2, -2 * pi**2 / 3 + 24 * zeta(3) / n, rtol=0, atol=tolerance)


@pytest.mark.parametrize("n", [2.0, 2.7, 4.0, 31.0, 200.0])
def test_equal_exponents_make_all_axes_alike(n: float) -> None:
    """Law: with n1 = n2 the equation is |x/a|^n + |y/b|^n + |z/c|^n = 1, so that permuted semi-axes permute the moments."""
    size, moments = of_one(AXES, n, n)
    for order in permutations(range(3)):
        permuted, turned = of_one(AXES[list(order)], n, n)
        assert_allclose(permuted, size, rtol=ROUNDING)
        assert_allclose(turned, moments[list(order)], rtol=ROUNDING)


semi_axes = st.tuples(*[st.floats(1e-6, 1e3)] * 3).map(np.array)
exponents = st.floats(2, 500)


@settings(max_examples=100, deadline=None)
@given(shape=semi_axes, n1=exponents, n2=exponents)
def test_a_and_b_may_be_exchanged(shape: Floats, n1: float, n2: float) -> None:
    """Law: a <-> b leaves V and I_zz as they are and exchanges I_xx and I_yy: bit for bit but the product abc."""
    size, moments = of_one(shape, n1, n2)
    exchanged, turned = of_one(shape[[1, 0, 2]], n1, n2)
    assert exchanged == pytest.approx(size, rel=ROUNDING)
    assert_allclose(turned[[1, 0, 2]], moments, rtol=ROUNDING)


@settings(max_examples=100, deadline=None)
@given(shape=semi_axes, n1=exponents, n2=exponents, power=st.integers(-20, 20))
def test_scaling(shape: Floats, n1: float, n2: float, power: int) -> None:
    """Law: a body k times as large has k^3 the volume and k^2 the inertia per mass; exact for powers of two."""
    (size, moments), k = of_one(shape, n1, n2), 2.0**power
    larger, wider = of_one(k * shape, n1, n2)
    assert larger == k**3 * size
    assert_array_equal(wider, k**2 * moments)


@settings(max_examples=100, deadline=None)
@given(shape=semi_axes, n1=exponents, n2=exponents)
def test_moments_are_those_of_a_solid(shape: Floats, n1: float, n2: float) -> None:
    """Law: I_i + I_j - I_k is twice the mean of x_k^2, which lies between 1/5 (ellipsoid) and 1/3 (box) of the squared semi-axis."""
    _, moments = of_one(shape, n1, n2)
    mean_squares = moments.sum() / 2 - moments
    slack = ROUNDING * moments.sum()  # the difference cancels where one axis is short
    assert np.all(mean_squares >= shape**2 / 5 - slack)
    assert np.all(mean_squares <= shape**2 / 3 + slack)


@settings(max_examples=100, deadline=None)
@given(n1=exponents, n2=exponents, more=st.floats(0.01, 100))
def test_blunter_bodies_are_larger(n1: float, n2: float, more: float) -> None:
    """Law: a body contains every body of the same semi-axes with smaller exponents."""
    size, _ = of_one(AXES, n1, n2)
    slack = 1 - ROUNDING
    assert of_one(AXES, n1 + more, n2)[0] >= size * slack
    assert of_one(AXES, n1, n2 + more)[0] >= size * slack
    assert 4 / 3 * pi * slack <= size / AXES.prod() <= 8 / slack


def test_rows_do_not_mix() -> None:
    """Law: a body among others has the numbers it has alone, in its own row, whatever exponents repeat."""
    rng = np.random.default_rng(3)
    shapes, blockiness = rng.uniform(0.5, 2, (40, 3)), rng.choice([2.0, 2.5, 4.0, 8.0], (40, 2))
    together = volume(shapes, blockiness), inertia_per_mass(shapes, blockiness)
    for row, (shape, pair) in enumerate(zip(shapes, blockiness, strict=True)):
        alone = of_one(shape, *pair)
        assert together[0][row] == alone[0]
        assert_array_equal(together[1][row], alone[1])


def test_no_bodies() -> None:
    """Law: no rows in, no rows out."""
    assert volume(np.empty((0, 3)), np.empty((0, 2))).shape == (0,)
    assert inertia_per_mass(np.empty((0, 3))).shape == (0, 3)


@pytest.mark.parametrize("function", [volume, inertia_per_mass])
@pytest.mark.parametrize("wrong", [0.0, -1.0, nan, inf])
def test_semi_axes_must_be_above_zero(function, wrong: float) -> None:
    """Law: a flat, negative, infinite or undefined body is refused, and the message shows its semi-axes."""
    with pytest.raises(ValueError, match=f"semi-axes above zero, got 1 {wrong:g} 3$"):
        function(np.array([[1.0, 1.0, 1.0], [1.0, wrong, 3.0]]))


@pytest.mark.parametrize("function", [volume, inertia_per_mass])
@pytest.mark.parametrize("wrong", [1.999, 0.0, -2.0, nan])
def test_exponents_must_be_two_or_more(function, wrong: float) -> None:
    """Law: exponents below 2, which both engines refuse too, and NaN are refused; the message shows the pair."""
    with pytest.raises(ValueError, match=f"blockiness of 2 or more, got 4 {wrong:g}$"):
        function(np.ones((2, 3)), np.array([[2.0, 2.0], [4.0, wrong]]))

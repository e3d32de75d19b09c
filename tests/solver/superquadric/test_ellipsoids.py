"""Superquadrics with exponents 2 are ellipsoids, for which there are closed forms: quadratic forms in the place of powers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from demsolver.shapes.rotation import matrix
from demsolver.superquadric import Body, Floats, body, pairs, planes, surface
from tests.support.superquadrics import near

SEEDS = st.integers(0, 10_000)


def ellipsoids(seed: int) -> tuple[Body, Body]:
    """Two that overlap, aspect ratios up to 5."""
    i, j = (one._replace(n1=2.0, n2=2.0, scale=1.0) for one in near(seed))
    return i, j


def form(one: Body) -> Floats:
    """A of (p - x).A (p - x) = 1."""
    r = matrix(np.array([one.q]))[0]
    return np.asarray(r @ np.diag(1.0 / np.array(one.axes) ** 2) @ r.T)


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_growth_is_perram_and_wertheims(seed: int) -> None:
    """Law: lam^2 is the most that s (1 - s) r.[(1 - s) A^-1 + s B^-1]^-1 r gets for s from 0 to 1 (doi:10.1016/0021-9991(85)90171-8, eq. 3.8)."""
    i, j = ellipsoids(seed)
    r, a, b = np.array(i.x) - np.array(j.x), np.linalg.inv(form(i)), np.linalg.inv(form(j))

    def less(s: float) -> float:
        return float(-s * (1.0 - s) * r @ np.linalg.solve((1.0 - s) * a + s * b, r))

    best = minimize_scalar(less, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12})
    p, found, _ = pairs.afresh(i, j, pairs.GAUGE)
    assert found
    assert pairs.grown(p, i, j)[0] ** 2 == pytest.approx(-best.fun, rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_a_line_leaves_by_a_quadratic(seed: int) -> None:
    """Law: from p along d an ellipsoid is left where t^2 d.A d + 2 t d.A p + p.A p = 1."""
    i, _ = ellipsoids(seed)
    rng = np.random.default_rng(seed)
    d, p = rng.normal(size=3), 0.5 * min(i.axes) * rng.uniform(-1.0, 1.0, 3) / np.sqrt(3.0)
    d /= np.linalg.norm(d)
    a, u = form(i), p
    at = np.array(i.x) + p
    big, half, less = d @ a @ d, d @ a @ u, u @ a @ u - 1.0
    assert surface.leaves(tuple(at), tuple(d), i) == pytest.approx((-half + np.sqrt(half * half - big * less)) / big, rel=1e-12)


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_the_farthest_point_and_the_curvature(seed: int) -> None:
    """Law: along d the farthest point is A^-1 d / sqrt(d.A^-1 d); there the Gaussian curvature is (d.A^-1 d)^2 |d|^-4 det A for any length of d."""
    i, _ = ellipsoids(seed)
    d = np.random.default_rng(seed).normal(size=3)
    a = form(i)
    b = np.linalg.inv(a)
    far = b @ d / np.sqrt(d @ b @ d)
    assert np.array(planes.support(tuple(d), i)) - np.array(i.x) == pytest.approx(far, abs=1e-14)
    along = matrix(np.array([i.q]))[0].T @ far
    gaussian = surface.curvature(tuple(along), i, surface.GAUSSIAN) ** 2
    assert gaussian == pytest.approx((d @ b @ d) ** 2 / (d @ d) ** 2 * np.linalg.det(a), rel=1e-9)


@pytest.mark.parametrize("kind", [surface.MEAN, surface.GAUSSIAN])
def test_a_sphere_is_curved_alike_everywhere(kind: int) -> None:
    """Law: 1/R, wherever."""
    one = body(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.full(3, 0.02), np.full(2, 2.0))
    for u in np.random.default_rng(1).normal(size=(20, 3)):
        assert surface.curvature(tuple(u), one, kind) == pytest.approx(50.0, rel=1e-12)

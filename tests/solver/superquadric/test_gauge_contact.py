"""The contact of two superquadrics whose force derives from an energy: its definition, its gradient, and collisions that keep the energy."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from demsolver import rotation
from demsolver.algebra import compiled
from demsolver.rotation.exact import first, second
from demsolver.shapes import superquadric
from demsolver.shapes.rotation import matrix
from demsolver.superquadric import Body, Floats, body, pairs
from tests.support.superquadrics import near


def growth(p: Floats, one: Body) -> float:
    """By how much a body grows to reach p, in numpy."""
    u = np.abs(matrix(np.array([one.q]))[0].T @ (p - np.array(one.x))) / np.array(one.axes)
    return float(((u[0] ** one.n2 + u[1] ** one.n2) ** (one.n1 / one.n2) + u[2] ** one.n1) ** (1.0 / one.n1))


def lam(i: Body, j: Body) -> float:
    """The growth at which they touch."""
    p, found, _ = pairs.afresh(i, j, pairs.GAUGE)
    assert found
    return pairs.grown(p, i, j)[0]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.05, 1.3))
def test_both_bodies_grown_alike_touch(seed: int, part: float) -> None:
    """Law: the larger of both growths is least where they are equal, as a minimiser of another kind finds too; deep inside each other as well."""
    i, j = near(seed)
    j = j._replace(x=tuple(part * np.array(j.x)))
    p, found, _ = pairs.afresh(i, j, pairs.GAUGE)
    size, _, n = pairs.grown(p, i, j)
    assert found
    assert growth(np.array(p), i) == pytest.approx(size, rel=1e-10)
    assert growth(np.array(p), j) == pytest.approx(size, rel=1e-10)
    assert np.dot(n, np.array(i.x) - np.array(j.x)) > 0.0
    other = minimize(
        lambda y: y[3], [*(np.array(p) / 0.03 + 0.1), 2.0], method="SLSQP", options={"maxiter": 500, "ftol": 1e-14},
        constraints=[{"type": "ineq", "fun": lambda y, one=one: y[3] - growth(0.03 * y[:3], one)} for one in (i, j)],
    )  # fmt: skip
    assert size <= other.fun + 1e-9
    if other.success:
        assert size == pytest.approx(other.fun, abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_force_and_torque_are_the_gradient(seed: int) -> None:
    """Law: moving or turning either body by a little changes lam by n times its share, and by (p - x) x n times it."""
    i, j = near(seed)
    p, _, _ = pairs.afresh(i, j, pairs.GAUGE)
    _, share, n = pairs.grown(p, i, j)
    for one, sign in ((i, 1.0), (j, -1.0)):
        for way in np.eye(3):
            step = 1e-6
            moved = [one._replace(x=tuple(np.array(one.x) + s * step * 0.03 * way)) for s in (1.0, -1.0)]
            half = [np.array([1.0, *(0.5 * s * step * way)]) for s in (1.0, -1.0)]
            turned = [one._replace(q=tuple(_product(q / np.linalg.norm(q), np.array(one.q)))) for q in half]
            ends = [[lam(new, j) if one is i else lam(i, new) for new in both] for both in (moved, turned)]
            by_way, by_turn = ((a - b) / (2.0 * step) for a, b in ends)
            assert by_way == pytest.approx(sign * share * np.dot(n, way) * 0.03, abs=2e-7)
            assert by_turn == pytest.approx(sign * share * np.dot(np.cross(np.array(p) - np.array(one.x), n), way), abs=2e-7)


def _product(p: Floats, q: Floats) -> Floats:
    w, x, y, z = p
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]]) @ q


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_nothing_jumps(seed: int) -> None:
    """Law: from touching to half a semi-axis deep lam falls steadily, and its slope, the force's share, changes by a little each time."""
    i, j = near(seed)
    away = np.array(j.x) / np.linalg.norm(j.x)
    ways = np.linalg.norm(j.x) - np.linspace(-0.1, 0.5, 400) * min(*i.axes, *j.axes)
    p, _, _ = pairs.afresh(i, j._replace(x=tuple(ways[0] * away)), pairs.GAUGE)
    sizes, slopes = [], []
    for way in ways:
        there = j._replace(x=tuple(way * away))
        p, found, _ = pairs.newton(p, i, there, pairs.GAUGE)
        assert found
        size, share, n = pairs.grown(p, i, there)
        sizes.append(size)
        slopes.append(share * np.array(n))
    assert (np.diff(sizes) < 0.0).all()
    assert np.linalg.norm(np.diff(slopes, axis=0), axis=1).max() < 0.1 * np.linalg.norm(slopes, axis=1).max()
    by_way = np.gradient(sizes, ways)
    assert by_way[1:-1] == pytest.approx(-(np.array(slopes) @ away)[1:-1], rel=2e-3)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.01, 3.0))
def test_growth_is_of_first_degree(seed: int, part: float) -> None:
    """Law: at a distance so many times as large, in the same orientations, lam is so many times as large: exactly, at any depth."""
    i, j = near(seed)
    assert lam(i, j._replace(x=tuple(part * np.array(j.x)))) == pytest.approx(part * lam(i, j), rel=1e-9)


def test_spheres_are_spheres() -> None:
    """Law: of equal axes (1 - lam)(Ri + Rj) is the overlap, and the share 1/(Ri + Rj)."""
    upright, round_ = np.array([1.0, 0.0, 0.0, 0.0]), np.full(2, 2.0)
    i, j = body(np.zeros(3), upright, np.full(3, 0.02), round_), body(np.array([0.0, 0.03, 0.04]), upright, np.full(3, 0.0305), round_)
    p, found, _ = pairs.afresh(i, j, pairs.GAUGE)
    size, share, n = pairs.grown(p, i, j)
    assert found
    assert (1.0 - size) * 0.0505 == pytest.approx(0.0005, rel=1e-9)
    assert share == pytest.approx(1.0 / 0.0505, rel=1e-12)
    assert n == pytest.approx((0.0, -0.6, -0.8), abs=1e-12)


@cache
def collide() -> Callable[..., tuple[float, float]]:
    """Steps two bodies with U = k (1 - lam)^(5/2) by velocity Verlet and the exact rotation; gives the energy at the end and the least lam."""

    @compiled
    def force(i, j, p, stiffness):
        p, found, _ = pairs.newton(p, i, j, 1)
        if not found:
            p, found, _ = pairs.afresh(i, j, 1)
        size, share, n = pairs.grown(p, i, j)
        pull = 2.5 * stiffness * (1.0 - size) ** 1.5 * share if size < 1.0 else 0.0
        f = (pull * n[0], pull * n[1], pull * n[2])
        return f, turn(p, i, f, 1.0), turn(p, j, f, -1.0), p, size

    @compiled
    def turn(p, one, f, sign):
        a = (p[0] - one.x[0], p[1] - one.x[1], p[2] - one.x[2])
        return sign * (a[1] * f[2] - a[2] * f[1]), sign * (a[2] * f[0] - a[0] * f[2]), sign * (a[0] * f[1] - a[1] * f[0])

    @compiled
    def kicked(v, f, h):
        return v[0] + h * f[0], v[1] + h * f[1], v[2] + h * f[2]

    @compiled
    def energy(mass, v, angmom, omega):
        kinetic = 0.5 * mass * (v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
        return kinetic + 0.5 * (angmom[0] * omega[0] + angmom[1] * omega[1] + angmom[2] * omega[2])

    @compiled
    def run(i, j, masses, inertias, vi, vj, wi, wj, li, lj, stiffness, dt, steps):
        p, _, _ = pairs.afresh(i, j, 1)
        f, ti, tj, p, least = force(i, j, p, stiffness)
        for _ in range(steps):
            vi, vj = kicked(vi, f, 0.5 * dt / masses[0]), kicked(vj, f, -0.5 * dt / masses[1])
            qi, li, wi = first(i.q, li, wi, ti, inertias[0], dt)
            qj, lj, wj = first(j.q, lj, wj, tj, inertias[1], dt)
            i = Body(kicked(i.x, vi, dt), qi, i.axes, i.n1, i.n2, i.scale)
            j = Body(kicked(j.x, vj, dt), qj, j.axes, j.n1, j.n2, j.scale)
            f, ti, tj, p, size = force(i, j, p, stiffness)
            least = min(least, size)
            vi, vj = kicked(vi, f, 0.5 * dt / masses[0]), kicked(vj, f, -0.5 * dt / masses[1])
            li, wi = second(i.q, li, wi, ti, inertias[0], dt)
            lj, wj = second(j.q, lj, wj, tj, inertias[1], dt)
        return energy(masses[0], vi, li, wi) + energy(masses[1], vj, lj, wj) + stiffness * max(0.0, 1.0 - size) ** 2.5, least

    return run


def lost(seed: int, steps: int) -> tuple[float, float]:
    """Energy that an elastic collision of random bodies, 1 m/s and spinning, lost in so many steps, relative; and the least lam."""
    rng = np.random.default_rng(seed)
    i, j = near(seed)
    away = np.array(j.x) / np.linalg.norm(j.x)
    j = j._replace(x=tuple(np.array(j.x) * 1.01 / lam(i, j)))  # apart by a hundredth
    shape, exponents = np.array([i.axes, j.axes]), np.array([[one.n1, one.n2] for one in (i, j)])
    mass = 2500.0 * superquadric.volume(shape, exponents)
    inertia = mass[:, None] * superquadric.inertia_per_mass(shape, exponents)
    state = rotation.turning(np.array([i.q, j.q]), rng.normal(0.0, 5.0, (2, 3)), inertia)
    v = np.array([0.5 * away, -0.5 * away])
    before = 0.5 * float(mass @ (v**2).sum(axis=1)) + 0.5 * float(np.sum(state.omega * state.angmom))
    stiffness = 2e5 * float(mass.min())  # some tenth of a semi-axis deep
    time = 0.06 * float(np.linalg.norm(j.x))  # six times what lies between them at 1 m/s
    motion = [tuple(row) for part in (v, state.omega, state.angmom) for row in part]
    after, least = collide()(i, j, tuple(mass), tuple(map(tuple, inertia)), *motion, stiffness, time / steps, steps)
    return abs(after / before - 1.0), least


def test_elastic_collisions_keep_the_energy() -> None:
    """Law: the energy of a frictionless collision is lost with the square of the step alone: 16 times less at a quarter of it (rms of 100 pairs)."""
    coarse, fine = (np.array([lost(seed, steps) for seed in range(100)]) for steps in (1000, 4000))
    assert (fine[:, 1] < 0.9999).mean() > 0.9  # they meet, off the centre line or not
    assert fine[:, 0].max() < 1e-4
    assert sqrt(np.mean(coarse[:, 0] ** 2) / np.mean(fine[:, 0] ** 2)) > 16.0 * 0.6

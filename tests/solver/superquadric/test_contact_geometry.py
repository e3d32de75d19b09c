"""Superquadrics in contact: derivatives, planes, pairs, each against its definition, and forces against dumps of LIGGGHTS 3.8.0."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from demsolver.shapes import superquadric
from demsolver.shapes.rotation import matrix
from demsolver.superquadric import Body, Floats, body, bounding_radius, pairs, planes, surface
from demverify.formats.dump import read_dump
from demverify.frames import Frame
from tests.support.superquadrics import drawn, near

DATA = Path(__file__).parents[2] / "data/superquadric"
PLANE_STRAIN = 1e7 / (2.0 * (1.0 - 0.3**2))  # of two alike, E = 1e7, nu = 0.3


def by_definition(p: Floats, one: Body) -> float:
    """f at a point of space, in numpy."""
    u = np.abs(matrix(np.array([one.q]))[0].T @ (p - np.array(one.x))) / np.array(one.axes)
    return float(one.scale * ((u[0] ** one.n2 + u[1] ** one.n2) ** (one.n1 / one.n2) + u[2] ** one.n1 - 1.0))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_derivatives(seed: int) -> None:
    """Law: value, gradient and second derivatives are those of the definition, by central differences."""
    rng = np.random.default_rng(seed)
    one, u = drawn(rng, np.zeros(3)), rng.uniform(-0.05, 0.05, 3)
    f, g = surface.slope(tuple(u), one)
    xx, yy, zz, xy, xz, yz = surface.curve(tuple(u), one)
    at, h = body(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.array(one.axes), np.array([one.n1, one.n2])), 1e-7
    steps = h * np.eye(3)
    assert f == pytest.approx(by_definition(u, at), rel=1e-12, abs=1e-14)
    assert surface.value(tuple(u), one) == pytest.approx(f, rel=1e-12, abs=1e-14)
    by_steps = np.array([(by_definition(u + s, at) - by_definition(u - s, at)) / (2.0 * h) for s in steps])
    assert g == pytest.approx(by_steps, rel=1e-4, abs=1e-6 * np.abs(by_steps).max())
    slopes = np.array([np.subtract(surface.slope(tuple(u + s), one)[1], surface.slope(tuple(u - s), one)[1]) / (2.0 * h) for s in steps])
    assert np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) == pytest.approx(slopes, rel=1e-4, abs=1e-5 * np.abs(slopes).max())


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_the_support_point_is_on_the_surface_and_farthest(seed: int) -> None:
    """Law: f is 0 there, the gradient is along the direction, and no point of the surface lies farther."""
    rng = np.random.default_rng(seed)
    one, d = drawn(rng, rng.normal(size=3)), rng.normal(size=3)
    p = np.array(planes.support(tuple(d), one))
    assert by_definition(p, one) == pytest.approx(0.0, abs=1e-9)
    out = rng.normal(size=(200, 3))
    ways = np.array([surface.leaves(one.x, tuple(way / np.linalg.norm(way)), one) for way in out])
    points = np.array(one.x) + ways[:, None] * out / np.linalg.norm(out, axis=1)[:, None]
    assert max(abs(by_definition(point, one)) for point in points) < 1e-9
    assert (points @ d).max() <= p @ d + 1e-12


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_the_point_of_equal_potentials(seed: int) -> None:
    """Law: it is where the larger of both potentials is least, as a minimiser of another kind finds too; there they are equal."""
    i, j = near(seed)
    p, found, _ = pairs.afresh(i, j, pairs.POTENTIAL)
    assert found
    f = by_definition(np.array(p), i), by_definition(np.array(p), j)
    size = max(abs(f[0]), abs(f[1]))
    assert f[0] == pytest.approx(f[1], abs=1e-10 * max(size, 1e-3))
    other = minimize(
        lambda y: y[3], [*(0.5 * (np.array(i.x) + j.x) / 0.03), 1.0], method="SLSQP", options={"maxiter": 500, "ftol": 1e-14},
        constraints=[{"type": "ineq", "fun": lambda y, one=one: y[3] - by_definition(0.03 * y[:3], one)} for one in (i, j)],
    )  # fmt: skip
    assert max(f) <= other.fun + 1e-9


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([(2.0, 48.0), (2.0, 100.0), (10.0, 60.0)]))
def test_a_round_and_a_blunt_body_touch_where_they_overlap(seed: int, exponents: tuple[float, float]) -> None:
    """Law: there is an overlap where two bodies grown by lam < 1 would touch, and none where lam > 1, however small the blunt one's potential is."""
    i, other = (Body(*one[:3], n, n, 2.0 ** (2.0 - n)) for one, n in zip(near(seed), exponents, strict=True))
    p, found, _ = pairs.afresh(i, other, pairs.GAUGE)
    assert found
    reach = np.array(other.x) / pairs.grown(p, i, other)[0]
    for part, touches in ((0.999, True), (0.95, True), (1.001, False)):
        j = Body(tuple(part * reach), *other[1:])
        p, found, _ = pairs.afresh(i, j, pairs.POTENTIAL)
        assert found
        assert (pairs.chord(p, i, j)[0] > 0.0) is touches


def test_a_small_block_touches_a_large_plate() -> None:
    """Law: the point of equal potentials is found where a plate of 1 : 20 and a block of other exponents, a hundredth of its size, just touch."""
    rng = np.random.default_rng(1)
    axes = 0.02 * np.array([1.0, 1.0, 0.05])
    for way in rng.normal(size=(30, 3)):
        turned = rng.normal(size=(2, 4))
        i, j = (
            body(x, q / np.linalg.norm(q), size * axes, np.full(2, n))
            for x, q, size, n in zip((np.zeros(3), 2.0 * way), turned, (100.0, 1.0), (2.0, 10.0), strict=True)
        )
        p, found, _ = pairs.afresh(i, j, pairs.GAUGE)
        assert found
        j = Body(tuple(0.9999 / pairs.grown(p, i, j)[0] * np.array(j.x)), *j[1:])
        p, found, _ = pairs.afresh(i, j, pairs.POTENTIAL)
        assert found
        assert pairs.chord(p, i, j)[0] > 0.0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_a_guess_changes_nothing(seed: int) -> None:
    """Law: from a guess off by a thousandth of a body, and with the bodies in the other order, point, overlap and normal are the same."""
    i, j = near(seed)
    p, _, cold = pairs.afresh(i, j, pairs.POTENTIAL)
    q, found, warm = pairs.newton(tuple(np.array(p) + 3e-5 * np.random.default_rng(seed).normal(size=3)), i, j, pairs.POTENTIAL)
    r, back, _ = pairs.afresh(j, i, pairs.POTENTIAL)
    assert found
    assert back
    assert warm <= cold
    (overlap, n), (again, m), (turned, o) = pairs.chord(p, i, j), pairs.chord(q, i, j), pairs.chord(r, j, i)
    assert overlap > 0.0
    assert again == pytest.approx(overlap, rel=1e-7)
    assert turned == pytest.approx(overlap, rel=1e-7)
    assert np.array(m) == pytest.approx(np.array(n), abs=1e-7)
    assert np.array(o) == pytest.approx(-np.array(n), abs=1e-7)


def test_spheres_are_spheres() -> None:
    """Law: of equal axes the overlap is that of spheres, the normal along the centres, and the point divides it as the radii."""
    upright, round_ = np.array([1.0, 0.0, 0.0, 0.0]), np.full(2, 2.0)
    i, j = body(np.zeros(3), upright, np.full(3, 0.02), round_), body(np.array([0.0, 0.03, 0.04]), upright, np.full(3, 0.0305), round_)
    p, found, _ = pairs.afresh(i, j, pairs.POTENTIAL)
    overlap, n = pairs.chord(p, i, j)
    assert found
    assert overlap == pytest.approx(0.0005, rel=1e-9)
    assert n == pytest.approx((0.0, -0.6, -0.8), abs=1e-12)
    assert p == pytest.approx(tuple(np.array([0.0, 0.6, 0.8]) * 0.02 * 0.05 / 0.0505), abs=1e-12)


def bodies(frame: Frame) -> tuple[list[Body], Floats]:
    """Of a dump, and their volume-equivalent radii (n,)."""
    quat = np.column_stack([frame.columns[f"quat{k}"] for k in range(1, 5)])
    shape, blockiness = frame.vectors("shapex", "shapey", "shapez"), np.column_stack([frame.columns[f"blockiness{k}"] for k in (1, 2)])
    assert bounding_radius(shape, blockiness) == pytest.approx(frame.columns["radius"], rel=1e-14)
    found = [body(*row) for row in zip(frame.vectors("x", "y", "z"), quat, shape, blockiness, strict=True)]
    return found, np.cbrt(3.0 * superquadric.volume(shape, blockiness) / (4.0 * np.pi))


def hertz(reff: float, overlap: float, modulus: float) -> float:
    return 4.0 / 3.0 * modulus * float(np.sqrt(reff)) * overlap**1.5


def actions(frame: Frame, name: str) -> tuple[Floats, Floats]:
    """Forces and torques (n, 3) on the bodies of a frame: pairs 1-2, 3-4, ..., or each on the plane z = -0.9."""
    found, r = bodies(frame)
    x = frame.vectors("x", "y", "z")
    force, torque = np.zeros_like(x), np.zeros_like(x)
    for k, one in enumerate(found):
        if name == "plane_elastic":
            overlap, p, n = planes.touch((x[k, 0], x[k, 1], -0.9), one)
            pull, feel = hertz(r[k], max(overlap, 0.0), PLANE_STRAIN) * np.array(n), [(k, 1.0)]
        elif k % 2 == 0:
            other = found[k + 1]
            p, converged, _ = pairs.afresh(one, other, pairs.POTENTIAL)
            assert converged
            overlap, n = pairs.chord(p, one, other)
            pull, feel = hertz(r[k] * r[k + 1] / (r[k] + r[k + 1]), overlap, PLANE_STRAIN) * np.array(n), [(k, 1.0), (k + 1, -1.0)]
        else:
            continue
        for row, sign in feel:
            force[row] += sign * pull
            torque[row] += sign * np.cross(np.array(p) - x[row], pull)
    return force, torque


@pytest.mark.parametrize(("name", "limit"), [("plane_elastic", 1e-12), ("pair_elastic", 1e-6)])
def test_forces_of_liggghts(name: str, limit: float) -> None:
    """Law: from each dumped state forces and torques are those of LIGGGHTS: with planes to rounding, between bodies to where its iteration ends."""
    frames = list(read_dump(DATA / f"{name}.dump.gz"))
    wanted = [(f.vectors("fx", "fy", "fz"), f.vectors("tqx", "tqy", "tqz")) for f in frames]
    most, arm = max(np.abs(force).max() for force, _ in wanted), frames[0].columns["radius"].max()
    assert most > 10.0
    for frame, (force, torque) in zip(frames, wanted, strict=True):
        found = actions(frame, name)
        assert np.abs(found[0] - force).max() <= limit * most
        assert np.abs(found[1] - torque).max() <= limit * most * arm

"""erotate/superquadric: what LIGGGHTS printed, from each set of columns alone; laws of rigid bodies; what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from demsolver.computes import erotate_superquadric
from demsolver.computes.erotate import children, erotate, erotate_by_shape
from demsolver.computes.erotate_sphere import erotate_sphere
from demsolver.computes.population import Population
from demsolver.shapes.rotation import to_body, to_space
from demsolver.shapes.superquadric import volume
from demverify.formats.dump import read_dump
from demverify.frames import Frame

Floats = NDArray[np.float64]
DATA = Path(__file__).parents[2] / "data" / "superquadric"
# Dump and table hold 16 digits or more, 1e-16 each; an energy is some 60 operations, a total 24 terms above zero: 1e-15 is the worst seen.
ROUNDING = 1e-14


def population(frame: Frame) -> Population:
    """All that a frame of these dumps says of its particles."""
    return Population(
        id=frame.columns["id"].astype(np.int64),
        mass=frame.columns["mass"],
        omega=frame.vectors("omegax", "omegay", "omegaz"),
        angmom=frame.vectors("angmomx", "angmomy", "angmomz"),
        quat=np.column_stack([frame.columns[f"quat{k}"] for k in range(1, 5)]),
        shape=frame.vectors("shapex", "shapey", "shapez"),
        blockiness=np.column_stack([frame.columns["blockiness1"], frame.columns["blockiness2"]]),
    )


def printed(name: str) -> dict[int, list[float]]:
    """Step -> the rotational energies in a table that LIGGGHTS printed."""
    head, *rows = [line.split() for line in (DATA / f"{name}.thermo").read_text().splitlines()]
    return {int(row[0]): [float(row[head.index(column)]) for column in ("rot", "ero") if column in head] for row in rows}


@pytest.mark.parametrize("density", [False, True], ids=["mass", "density"])
@pytest.mark.parametrize("without", ["omega", "angmom", "quat", "nothing"])
@pytest.mark.parametrize(("name", "frames"), [("free", 6), ("collide", 7)])
def test_the_printed_energy_comes_back(name: str, frames: int, without: str, density: bool) -> None:
    """Law: without omega, without angmom, without orientations or from everything, the total is what LIGGGHTS printed at that step."""
    table, seen = printed(name), 0
    for frame in read_dump(DATA / f"{name}.dump.gz"):
        bodies = population(frame)
        if density:
            assert bodies.shape is not None
            bodies = replace(bodies, mass=frame.columns["density"] * volume(bodies.shape, bodies.blockiness))
        bodies = bodies if without == "nothing" else replace(bodies, **{without: None})
        assert_allclose(table[frame.step], erotate(bodies), rtol=ROUNDING)
        seen += 1
    assert seen == frames


@pytest.mark.parametrize("name", ["free", "collide", "scheme3"])
def test_masses_and_moments_are_those_of_liggghts(name: str) -> None:
    """Law: mass = density V, and the principal moments are those in the dump, to rounding."""
    frame = next(read_dump(DATA / f"{name}.dump.gz"))
    bodies = population(frame)
    moments = erotate_superquadric.inertia(bodies, np.ones(frame.n, dtype=bool))
    assert_allclose(moments, frame.vectors("inertiax", "inertiay", "inertiaz"), rtol=ROUNDING)
    if "density" in frame.columns:
        assert_allclose(frame.columns["density"] * volume(bodies.shape, bodies.blockiness), bodies.mass, rtol=ROUNDING)


def each(bodies: Population, without: str) -> Floats:
    """Energy of every body when a field is missing."""
    return erotate_superquadric.energies(replace(bodies, **{without: None}), erotate_superquadric.owned(bodies)).value


@pytest.mark.parametrize("name", ["scheme3", "scheme3_contacts"])
def test_scheme_3_turns_the_angular_momentum_of_now_by_the_orientation_of_before(name: str) -> None:
    """Law: in LIGGGHTS' scheme 3 omega_n = R_n I^-1 R_(n-1)^T L_n, so that the energy from omega is that of L_n in the orientation of n-1.

    The energies from angmom and from omega differ by what this scheme's energy drifts in one step: of second order in the angle of 4e-3.
    """
    frames = list(read_dump(DATA / f"{name}.dump.gz"))
    assert any(np.abs(frame.vectors("tqx", "tqy", "tqz")).max() > 1e-3 for frame in frames) == (name == "scheme3_contacts")
    for before, now in zip(map(population, frames[:-1]), map(population, frames[1:]), strict=True):
        spinning = np.abs(now.angmom).max(axis=1) > 0
        moments = erotate_superquadric.inertia(now, spinning)
        omega = to_space(now.quat[spinning], to_body(before.quat[spinning], now.angmom[spinning]) / moments)
        fastest = np.linalg.norm(omega, axis=1, keepdims=True)
        assert_allclose(now.omega[spinning] / fastest, omega / fastest, atol=ROUNDING)
        lagging = each(replace(now, quat=before.quat), "omega")
        assert_allclose(each(now, "angmom"), lagging, rtol=ROUNDING)
        assert 1e-10 < np.nanmax(np.abs(each(now, "omega")[spinning] / lagging[spinning] - 1)) < 2e-5


def one(**changes: object) -> Population:
    """A body of exponents 4 and 3 with a spin and the angular momentum that belongs to it."""
    rng = np.random.default_rng(5)
    body = Population(
        id=np.array([7]),
        mass=np.array([2.5]),
        shape=np.array([[1.0, 1.5, 0.7]]),
        blockiness=np.array([[4.0, 3.0]]),
        quat=rng.normal(size=(1, 4)),
        omega=rng.normal(size=(1, 3)),
    )
    moments = erotate_superquadric.inertia(body, np.array([True]))
    body = replace(body, angmom=to_space(body.quat, moments * to_body(body.quat, body.omega)))
    return replace(body, **changes)


part = st.floats(-1, 1)
quaternions = st.tuples(part, part, part, part).map(lambda q: np.array([q])).filter(lambda q: np.linalg.norm(q) > 0.01)
spins = st.tuples(part, part, part).map(lambda v: np.array([v])).filter(lambda v: np.linalg.norm(v) > 1e-3)


@settings(max_examples=50, deadline=None)
@given(quat=quaternions, omega=spins, radius=st.floats(1e-3, 10), mass=st.floats(1e-6, 1e6))
def test_a_ball_is_a_sphere(quat: Floats, omega: Floats, radius: float, mass: float) -> None:
    """Law: with equal semi-axes and n1 = n2 = 2 the energy is m R^2 omega^2 / 5, however the ball is turned."""
    ball = Population(np.array([1]), np.array([mass]), shape=np.full((1, 3), radius), quat=quat, omega=omega)
    assert_allclose(erotate(ball), erotate_sphere(np.array([mass]), np.array([radius]), omega)[0], rtol=ROUNDING)


@settings(max_examples=50, deadline=None)
@given(turn=quaternions)
def test_energy_does_not_depend_on_the_axes_of_space(turn: Floats) -> None:
    """Law: turning orientation, spin and angular momentum together leaves all three energies as they are."""
    rotation = Rotation.from_quat(turn[:, [1, 2, 3, 0]])
    body = one()
    quat = (rotation * Rotation.from_quat(body.quat[:, [1, 2, 3, 0]])).as_quat()[:, [3, 0, 1, 2]]
    turned = replace(body, quat=quat, omega=rotation.apply(body.omega), angmom=rotation.apply(body.angmom))
    for without in ("omega", "angmom", "mass"):
        assert_allclose(each(turned, without), each(body, "omega"), rtol=ROUNDING)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_spin_about_a_principal_axis(axis: int) -> None:
    """Law: an ellipsoid that spins with w about its axis k has m (sum of the squares of the other two semi-axes) w^2 / 10."""
    a = np.array([1.0, 1.5, 0.7])
    quarter = np.array([[1.0, 1.0, 1.0, 1.0]])  # x to y to z to x
    omega = 3 * np.roll(np.eye(3)[axis], 1)[None]
    body = one(blockiness=None, quat=quarter, omega=omega, angmom=None)
    assert_allclose(erotate(body), 2.5 * (a @ a - a[axis] ** 2) * 9 / 10, rtol=ROUNDING)


def test_angular_momentum_goes_before_a_spin_that_does_not_belong_to_it() -> None:
    """Law: LAMMPS never updates the omega of an ellipsoid, so that angmom decides where both are there and the body is known."""
    assert erotate(one(omega=np.array([[9.0, 9.0, 9.0]]))) == erotate(one())
    assert erotate(one(angmom=2 * one().angmom)) == 4 * erotate(one())


@pytest.mark.parametrize("without", ["omega", "angmom"])
def test_the_length_of_a_quaternion_does_not_matter(without: str) -> None:
    """Law: a quaternion cut to three digits is off by 1e-3 in length; the energy of the same rotation stays."""
    quat = np.array([[0.5, 0.5, 0.5, 0.5]])
    assert_allclose(each(one(quat=1.001 * quat), without), each(one(quat=quat), without), rtol=ROUNDING)


def test_points_and_spheres_are_left_to_others() -> None:
    """Law: rows of zero semi-axes are not owned, and what stands in their other columns is not looked at."""
    two = Population(
        id=np.array([3, 4]),
        mass=np.array([0.0, 2.5]),
        radius=np.array([0.0, 9.0]),
        omega=np.ones((2, 3)),
        angmom=np.vstack([np.full(3, np.nan), one().angmom]),
        quat=np.vstack([np.zeros(4), one().quat]),
        shape=np.vstack([np.zeros(3), one().shape]),
        blockiness=np.vstack([np.zeros(2), one().blockiness]),
    )
    assert_array_equal(erotate_superquadric.owned(two), [False, True])
    assert not erotate_superquadric.owned(replace(two, shape=None)).any()
    parts = dict(erotate_by_shape(two))
    assert list(parts) == ["superquadric", "sphere"]
    assert_array_equal(parts["superquadric"].id, [4])
    assert parts["superquadric"].total == erotate(one())
    assert parts["sphere"].total == 0.0


def test_erotate_finds_this_child_before_spheres() -> None:
    """Law: the file's name alone makes `erotate` call it."""
    shapes = [shape for shape, _ in children()]
    assert shapes.index("superquadric") < shapes.index("sphere")


def test_missing_columns_are_named() -> None:
    """Law: where no alternative is complete, the error lists all of them."""
    with pytest.raises(LookupError, match="mass shape quat angmom or omega angmom or mass shape quat omega"):
        erotate(one(omega=None, angmom=None))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": np.array([0.0])}, "masses above zero, got 0"),
        ({"mass": np.array([-1.0])}, "masses above zero, got -1"),
        ({"mass": np.array([np.nan])}, "masses above zero, got nan"),
        ({"shape": np.array([[1.0, 0.0, 2.0]])}, "semi-axes above zero, got 1 0 2"),
        ({"shape": np.array([[1.0, np.nan, 2.0]])}, "semi-axes above zero, got 1 nan 2"),
        ({"blockiness": np.array([[1.0, 2.0]])}, "blockiness of 2 or more, got 1 2"),
        ({"quat": np.zeros((1, 4))}, "quaternion w x y z other than zero, got 0 0 0 0"),
    ],
)
@pytest.mark.parametrize("without", ["omega", "angmom"])
def test_impossible_bodies_are_refused(changes: dict[str, Floats], message: str, without: str) -> None:
    """Law: a body without mass, extent or orientation is an error that shows the value, never a NaN or an infinite energy."""
    with pytest.raises(ValueError, match=message):
        erotate(one(**changes, **{without: None}))

"""Rotational energy of rigid bodies, and who counts members."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from demsolver.computes import Population, RigidBodies, erotate
from demsolver.computes.erotate import erotate_by_shape
from demsolver.computes.erotate_multisphere import erotate_multisphere

ROUNDING = 1e-14  # a dozen products
NOBODY = np.empty(0, dtype=np.int64)


@pytest.fixture
def bodies() -> RigidBodies:
    """Three bodies whose angular momentum is I omega."""
    rng = np.random.default_rng(1)
    turn = Rotation.random(3, random_state=2)
    inertia, omega = rng.uniform(1, 3, (3, 3)), rng.normal(size=(3, 3))
    angmom = turn.apply(inertia * turn.inv().apply(omega))
    return RigidBodies(np.array([4, 5, 9]), inertia, np.roll(turn.as_quat(), 1, axis=1), omega=omega, angmom=angmom)


def test_energy_of_a_body_in_space(bodies: RigidBodies) -> None:
    """Law: E = 1/2 omega . I omega = 1/2 L . omega, in any axes; from either of L and omega."""
    law = 0.5 * np.einsum("ij,ij->i", bodies.angmom, bodies.omega)
    assert_allclose(erotate_multisphere(bodies), law, rtol=ROUNDING)
    assert_allclose(erotate_multisphere(replace(bodies, omega=None)), law, rtol=ROUNDING)
    assert_allclose(erotate_multisphere(replace(bodies, angmom=None)), law, rtol=ROUNDING)


def test_angular_momentum_goes_first(bodies: RigidBodies) -> None:
    """Law: both engines print sum of L_k^2 / (2 I_k); with both known and at odds, that is the answer."""
    assert_array_equal(erotate_multisphere(replace(bodies, omega=2 * bodies.omega)), erotate_multisphere(bodies))


def test_an_axis_without_inertia_counts_nothing() -> None:
    """Law: w = L / I, 0 where I is 0 (both engines), so points in a line have no energy about it, whatever L says."""
    rod = RigidBodies(np.array([1]), np.array([[0.0, 2.0, 2.0]]), np.array([[1.0, 0, 0, 0]]), angmom=np.array([[5.0, 2.0, 4.0]]))
    assert_allclose(erotate_multisphere(rod), [0.5 * (4 + 16) / 2], rtol=ROUNDING)


def test_members_count_once_as_their_body_and_not_as_spheres(bodies: RigidBodies) -> None:
    """Law: of the particles only those without a body (0 or less) are spheres; every body counts, also without a member in sight."""
    free = np.array([False, True, True, True, False, True])
    body = np.where(free, [1, 0, -1, 0, 1, 0], [4, 0, 0, 0, 9, 0])
    n = len(body)
    population = Population(np.arange(n), np.ones(n), np.full(n, 2.0), np.tile([1.0, 0, 0], (n, 1)), body=body, bodies=bodies)
    found = dict(erotate_by_shape(population))
    assert list(found) == ["multisphere", "sphere"]
    assert_array_equal(found["multisphere"].id, [4, 5, 9])
    assert_array_equal(found["sphere"].id, np.flatnonzero(free))
    assert_allclose(erotate(population), erotate_multisphere(bodies).sum() + free.sum() * 0.5 * 0.4 * 4, rtol=ROUNDING)


def test_bodies_without_any_particles(bodies: RigidBodies) -> None:
    """Law: a dump of bodies lists no particles; its energy is that of the bodies."""
    assert_allclose(erotate(Population(NOBODY, bodies=bodies)), erotate_multisphere(bodies).sum(), rtol=ROUNDING)


def test_no_bodies_no_shape() -> None:
    """Law: particles of which none has a body make no clumps."""
    population = Population(np.arange(2), np.ones(2), np.ones(2), np.zeros((2, 3)), body=np.array([-1, 0]))
    assert [shape for shape, _ in erotate_by_shape(population)] == ["sphere"]


def test_a_member_of_an_unknown_body(bodies: RigidBodies) -> None:
    """Law: a member whose body is not known makes the sum wrong: an error that says which."""
    population = Population(np.arange(2), body=np.array([4, 7]), bodies=bodies)
    with pytest.raises(LookupError, match="no body 7"):
        erotate(population)
    with pytest.raises(LookupError, match="no body 4"):
        erotate(replace(population, bodies=None))


def test_neither_momentum_nor_velocity(bodies: RigidBodies) -> None:
    """Law: orientation and inertia alone say nothing of the energy."""
    with pytest.raises(LookupError, match="neither angmom nor omega"):
        erotate_multisphere(replace(bodies, omega=None, angmom=None))


def test_negative_moment_of_inertia(bodies: RigidBodies) -> None:
    """Law: principal moments are not negative."""
    wrong = bodies.inertia.copy()
    wrong[1, 2] = -1.0
    with pytest.raises(ValueError, match="got -1 for body 5"):
        erotate_multisphere(replace(bodies, inertia=wrong))

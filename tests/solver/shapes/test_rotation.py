"""Quaternions: the same rotation as scipy's, whatever the length, and clear errors."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from demsolver.shapes.rotation import matrix, quaternion, to_body, to_space

Floats = NDArray[np.float64]
ROUNDING = 1e-15  # about ten products of numbers up to 1, half a unit of 2e-16 each
part = st.floats(-1, 1)
quaternions = st.tuples(part, part, part, part).map(lambda q: np.array([q])).filter(lambda q: np.linalg.norm(q) > 0.01)
vectors = st.tuples(part, part, part).map(lambda v: np.array([v]))


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    """Law: q = (cos 45°, 0, 0, sin 45°), w first, turns the body's x axis to the y axis of space; to_body is the way back."""
    quarter = np.array([[1.0, 0.0, 0.0, 1.0]])
    assert_allclose(to_space(quarter, np.array([[1.0, 0.0, 0.0]])), [[0.0, 1.0, 0.0]], atol=ROUNDING)
    assert_allclose(to_body(quarter, np.array([[1.0, 0.0, 0.0]])), [[0.0, -1.0, 0.0]], atol=ROUNDING)


@settings(max_examples=100, deadline=None)
@given(quat=quaternions, v=vectors)
def test_rotations_are_those_of_scipy(quat: Floats, v: Floats) -> None:
    """Law: R(q) v is what an independent program (x y z w) makes of it, and R^T R = 1."""
    reference = Rotation.from_quat(quat[:, [1, 2, 3, 0]])
    assert_allclose(to_space(quat, v), reference.apply(v), atol=2 * ROUNDING)
    assert_allclose(to_body(quat, v), reference.apply(v, inverse=True), atol=2 * ROUNDING)
    assert_allclose(matrix(quat)[0].T @ matrix(quat)[0], np.eye(3), atol=2 * ROUNDING)


@settings(max_examples=50, deadline=None)
@given(quat=quaternions, v=vectors, length=st.floats(1e-6, 1e6))
def test_length_and_sign_of_a_quaternion_do_not_matter(quat: Floats, v: Floats, length: float) -> None:
    """Law: k q is the same rotation for every k but 0, so that no vector grows for want of digits in a dump."""
    assert_allclose(to_body(length * quat, v), to_body(quat, v), atol=2 * ROUNDING)
    assert_array_equal(to_body(-quat, v), to_body(quat, v))


def test_every_row_has_its_own_rotation() -> None:
    """Law: row i of the result is row i alone; to_space undoes to_body."""
    rng = np.random.default_rng(1)
    quat, v = rng.normal(size=(20, 4)), rng.normal(size=(20, 3))
    body = to_body(quat, v)
    for row in range(20):
        assert_array_equal(body[row], to_body(quat[row : row + 1], v[row : row + 1])[0])
    assert_allclose(to_space(quat, body), v, atol=20 * ROUNDING)  # components up to 3, twice through
    assert to_body(quat[:0], v[:0]).shape == (0, 3)


@pytest.mark.parametrize("wrong", [(0.0, 0.0, 0.0, 0.0), (nan, 0.0, 0.0, 1.0), (1.0, inf, 0.0, 0.0)])
def test_no_rotation_from_no_quaternion(wrong: tuple[float, ...]) -> None:
    """Law: a quaternion of zeros (a dump's way to say none) or with nan or inf is refused and shown."""
    shown = " ".join(f"{value:g}" for value in wrong)
    with pytest.raises(ValueError, match=f"other than zero, got {shown}$"):
        matrix(np.array([(1.0, 0.0, 0.0, 0.0), wrong]))


@settings(max_examples=50, deadline=None)
@given(quat=quaternions)
def test_quaternion_of_a_matrix(quat: Floats) -> None:
    """Law: quaternion undoes matrix but for the sign; its length is 1. Half turns (w = 0) about each axis too."""
    turns = np.vstack([quat, np.eye(4)])
    back = quaternion(matrix(turns))
    assert_allclose(np.linalg.norm(back, axis=1), 1.0, rtol=ROUNDING)
    assert_allclose(matrix(back), matrix(turns), atol=4 * ROUNDING)  # two conversions

"""Boxes of tilted cells."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demverify.errors import InputError, Place
from demverify.formats.cell import general, orthogonal, tilted

HERE = Place(Path("d.txt"), 5)
threes = st.lists(st.floats(-3, 3), min_size=3, max_size=3).map(np.array)
lengths = st.lists(st.floats(0.1, 3), min_size=3, max_size=3).map(np.array)


def cell_of(edges: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """Rows a b c of a cell with a along x and b in the xy plane."""
    cell = np.diag(edges).astype(float)
    cell[1, 0], cell[2, 0], cell[2, 1] = tilt
    return cell


@given(origin=threes, edges=lengths, tilt=threes)
def test_bounds_around_the_corners_are_undone(origin: np.ndarray, edges: np.ndarray, tilt: np.ndarray) -> None:
    """Law: from the least and greatest corner, which the engines write, and the tilt come the box before tilting and the cell."""
    cell = cell_of(edges, tilt)
    corners = origin + np.array(list(product((0, 1), repeat=3))) @ cell
    box, got = tilted(np.column_stack([corners.min(axis=0), corners.max(axis=0)]), tilt, HERE)
    # sums of a few numbers up to 12: some ulp of that
    np.testing.assert_allclose(box, np.column_stack([origin, origin + edges]), atol=1e-14)
    np.testing.assert_allclose(got, cell, atol=1e-14)


@given(origin=threes, edges=lengths, tilt=threes, turn=st.lists(st.floats(-1, 1), min_size=9, max_size=9))
def test_general_axes_have_the_lengths_of_the_turned_cell(
    origin: np.ndarray, edges: np.ndarray, tilt: np.ndarray, turn: list[float]
) -> None:
    """Law: however the cell is turned, the box has the lengths it has with a along x and b in the xy plane."""
    rotation = np.linalg.qr(np.reshape(turn, (3, 3)) + 3.0 * np.eye(3)).Q
    box, cell = general(cell_of(edges, tilt) @ rotation.T, origin, HERE)
    np.testing.assert_allclose(box[:, 1] - box[:, 0], edges, atol=1e-13)  # products of three numbers of order 5, in ulp
    np.testing.assert_array_equal(box[:, 0], origin)
    np.testing.assert_allclose(cell, cell_of(edges, tilt) @ rotation.T)


@pytest.mark.parametrize("bounds", [[[0, 1], [0, 1], [1, 0]], [[0, 1], [np.nan, 1], [0, 1]]])
def test_bounds_must_be_in_order(bounds: list[list[float]]) -> None:
    """Law: lo > hi, or NaN, is refused with its place."""
    with pytest.raises(InputError, match=r"d\.txt:5: expected box bounds lo <= hi, got 0 1, "):
        orthogonal(np.array(bounds), HERE)


def test_bounds_narrower_than_the_tilt_are_refused() -> None:
    """Law: a tilt of 2 cannot fit into bounds of 1."""
    with pytest.raises(InputError, match="lo <= hi"):
        tilted(np.array([[0.0, 1.0]] * 3), np.array([2.0, 0.0, 0.0]), HERE)

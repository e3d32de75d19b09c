"""Rows in the order of their ids: compiled, without the interpreter's lock."""

# mypy: disable-error-code="no-untyped-def, assignment"
# ruff: noqa: ANN001, ANN202 (Numba finds the types of what it compiles)

from __future__ import annotations

import numpy as np
from numba import njit

from demverify.errors import InputError, Place
from demverify.frames import Floats

_LARGEST = 2.0**53  # whole numbers beyond are not told apart
_ASCENDING, _COUNTED, _SPARSE, _NOT_WHOLE, _TWICE = range(5)


def sort_by_id(table: Floats, ids: int, place: Place) -> None:
    """Puts the columns of a table (rows of the array, one a column) in the order of the ids in its row `ids`, in place.

    Raises InputError where an id is no whole number or stands in two rows.
    """
    order = np.empty(table.shape[1], np.int64)
    state, at = _count(table[ids], order)
    if state == _SPARSE:
        order[:] = np.argsort(table[ids], kind="stable")
        twice = np.flatnonzero(np.diff(table[ids, order]) == 0)
        if len(twice):
            state, at = _TWICE, order[twice[0]]
    if state == _NOT_WHOLE:
        message = f"id {table[ids, at]:.17g} in the frame that ends here: expected a whole number up to 2^53"
        raise InputError(message, place)
    if state == _TWICE:
        message = f"id {table[ids, at]:.17g} stands in two rows of the frame that ends here"
        raise InputError(message, place)
    if state != _ASCENDING:
        _arrange(table, order)


@njit(cache=True, nogil=True, error_model="numpy")
def _count(ids, order):
    """What ids are like, and the one that is wrong; their order where they lie close together."""
    low, high, ascending = np.inf, -np.inf, True
    for i in range(len(ids)):
        if not (abs(ids[i]) <= _LARGEST and np.floor(ids[i]) == ids[i]):
            return _NOT_WHOLE, i
        ascending &= ids[i] > high
        low, high = min(low, ids[i]), max(high, ids[i])
    if ascending:
        return _ASCENDING, 0
    span = np.int64(high - low) + 1
    if span > 8 * len(ids) + 1024:
        return _SPARSE, 0
    rows = np.full(span, -1, np.int64)
    for i in range(len(ids)):
        slot = np.int64(ids[i] - low)
        if rows[slot] >= 0:
            return _TWICE, i
        rows[slot] = i
    n = 0
    for slot in range(span):
        if rows[slot] >= 0:
            order[n] = rows[slot]
            n += 1
    return _COUNTED, 0


@njit(cache=True, nogil=True, error_model="numpy")
def _arrange(table, order):
    """Column by column, so that no second table is needed."""
    column = np.empty(len(order))
    for row in range(len(table)):
        for i in range(len(order)):
            column[i] = table[row, order[i]]
        table[row] = column

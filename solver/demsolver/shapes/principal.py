"""Principal axes of a rigid body, as LAMMPS and LIGGGHTS find and name them.

Both turn an inertia tensor by rotations of Jacobi's until it is diagonal. LAMMPS removes the largest element first and sorts the moments; LIGGGHTS
goes round and leaves each moment where the rotations leave it, so that a tensor that is diagonal already keeps its axes. The third axis is turned
round where the three would be left-handed. Rules measured on both; C. G. J. Jacobi's method: doi:10.1515/crll.1846.30.51.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_PLACES = ((0, 1), (0, 2), (1, 2))
_MOST = 60
_EARLY = 3  # rounds of LIGGGHTS in which it passes over small elements
_QUARTER = 0.25


def principal(tensor: Floats, *, ascending: bool) -> tuple[Floats, Floats]:
    """Moments (3,) and axes (3, 3), a column each, right-handed, of a symmetric tensor (3, 3). ascending: sorted, the largest element removed first
    (LAMMPS); else as they come (LIGGGHTS)."""
    a, axes = np.array(tensor, dtype=np.float64), np.eye(3)
    (_by_size if ascending else _round)(a, axes)
    moments = np.diag(a).copy()
    if ascending:
        order = np.argsort(moments, kind="stable")
        moments, axes = moments[order], axes[:, order]
    if np.cross(axes[:, 0], axes[:, 1]) @ axes[:, 2] < 0.0:
        axes[:, 2] *= -1.0
    return moments, axes


def _by_size(a: Floats, axes: Floats) -> None:
    for _ in range(_MOST):
        i, j = max(_PLACES, key=lambda place: abs(a[place]))
        if a[i, j] == 0.0 or _lost(a, i, j, abs(a[i, j]) / 1e3):
            return
        _turn(a, axes, i, j)


def _round(a: Floats, axes: Floats) -> None:
    for turn in range(_MOST):
        rest = sum(abs(a[place]) for place in _PLACES)
        if rest == 0.0:
            return
        least = 0.2 * rest / 9.0 if turn < _EARLY else 0.0
        for i, j in _PLACES:
            if _lost(a, i, j, 100.0 * abs(a[i, j])):
                a[i, j] = a[j, i] = 0.0
            elif abs(a[i, j]) > least:
                _turn(a, axes, i, j)


def _lost(a: Floats, i: int, j: int, part: float) -> bool:
    """Whether that much is lost in rounding beside the moments."""
    return bool(abs(a[i, i]) + part == abs(a[i, i]) and abs(a[j, j]) + part == abs(a[j, j]))


def _turn(a: Floats, axes: Floats, i: int, j: int) -> None:
    """Removes element (i, j), in place."""
    apart, t = a[j, j] - a[i, i], 1.0
    if apart != 0.0:
        k = apart / (2.0 * a[i, j])
        t = (-1.0 if k < 0.0 else 1.0) / (sqrt(1.0 + k * k) + abs(k))
    c = 1.0 / sqrt(1.0 + t * t)
    s = c * t
    rotation = np.eye(3)
    rotation[i, i] = rotation[j, j] = c
    rotation[i, j], rotation[j, i] = s, -s
    a[:] = rotation.T @ a @ rotation
    a[i, j] = a[j, i] = 0.0
    axes[:] = axes @ rotation


def first_quaternion(axes: Floats) -> Floats:
    """w x y z (4,) of axes (3, 3), of the two the one that both engines take: of w, x, y, z the first whose square is at least 1/4 is above 0."""
    trace = 0.25 * (axes[0, 0] + axes[1, 1] + axes[2, 2] + 1.0)
    squares = (trace, *(trace - 0.5 * (axes[m, m] + axes[n, n]) for m, n in ((1, 2), (0, 2), (0, 1))))
    products = {
        (0, 1): axes[2, 1] - axes[1, 2], (0, 2): axes[0, 2] - axes[2, 0], (0, 3): axes[1, 0] - axes[0, 1],
        (1, 2): axes[1, 0] + axes[0, 1], (1, 3): axes[2, 0] + axes[0, 2], (2, 3): axes[2, 1] + axes[1, 2],
    }  # fmt: skip
    k = next((k for k, square in enumerate(squares) if square >= _QUARTER), int(np.argmax(squares)))
    q = np.empty(4)
    q[k] = sqrt(squares[k])
    for m in range(4):
        if m != k:
            q[m] = products[min(m, k), max(m, k)] / (4.0 * q[k])
    return q / np.linalg.norm(q)

"""Rotation by quaternions w x y z, which turn body axes to space axes: v_space = R(q) v_body.

Quaternions are divided by their length. LAMMPS and LIGGGHTS do not (MathExtra::quat_to_mat), but they normalise each one when it is
set and after every step, so here and there agree to rounding. A dump in six digits has lengths off by 1e-6: taken as they are, R
would stretch vectors by the square of that length, and energies by its fourth power.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def matrix(quat: Floats) -> Floats:
    """quat (n, 4) w x y z, of any length but zero -> R (n, 3, 3); its columns are the body axes in space.

    Raises ValueError for a quaternion of zeros or one that is not finite.
    """
    length = np.sqrt(np.einsum("ij,ij->i", quat, quat))
    if not np.all((length > 0) & np.isfinite(length)):
        worst = quat[np.flatnonzero(~((length > 0) & np.isfinite(length)))[0]]
        message = f"expected a quaternion w x y z other than zero, got {' '.join(f'{part:g}' for part in worst)}"
        raise ValueError(message)
    w, x, y, z = (quat / length[:, None]).T
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return np.moveaxis(np.array(rows, dtype=np.float64), 2, 0)


def to_body(quat: Floats, vectors: Floats) -> Floats:
    """Components along the body axes, R^T v. quat (n, 4), vectors (n, 3) in space -> (n, 3). Raises ValueError as `matrix`."""
    return np.asarray(np.einsum("nji,nj->ni", matrix(quat), vectors))


def to_space(quat: Floats, vectors: Floats) -> Floats:
    """Components along the space axes, R v. quat (n, 4), vectors (n, 3) along the body axes -> (n, 3). Raises ValueError as `matrix`."""
    return np.asarray(np.einsum("nij,nj->ni", matrix(quat), vectors))


def quaternion(rotation: Floats) -> Floats:
    """R (n, 3, 3), right-handed and orthonormal -> quat (n, 4) w x y z of length 1; the inverse of `matrix` up to the sign.

    4 q q^T is linear in R; its row of the largest diagonal element is divided by that element's root.
    """
    r = np.moveaxis(rotation, 0, 2)
    (xx, yy, zz), one = (r[0, 0], r[1, 1], r[2, 2]), np.ones(len(rotation))
    wx, wy, wz = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    xy, xz, yz = r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1]
    rows = np.array(
        (
            (one + xx + yy + zz, wx, wy, wz),
            (wx, one + xx - yy - zz, xy, xz),
            (wy, xy, one - xx + yy - zz, yz),
            (wz, xz, yz, one - xx - yy + zz),
        )
    )
    best = np.argmax(np.einsum("iin->in", rows), axis=0)
    found = rows[best, :, np.arange(len(rotation))]
    return np.asarray(found / np.sqrt(np.einsum("ij,ij->i", found, found))[:, None])

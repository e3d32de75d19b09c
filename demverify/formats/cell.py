"""Boxes of tilted cells, as LAMMPS and LIGGGHTS write them (https://docs.lammps.org/Howto_triclinic.html)."""

from __future__ import annotations

import numpy as np

from demverify.errors import InputError, Place
from demverify.frames import Floats


def orthogonal(bounds: Floats, place: Place) -> Floats:
    """Bounds (3, 2) as they are. Raises InputError unless lo <= hi on every axis."""
    if not (bounds[:, 0] <= bounds[:, 1]).all():
        shown = ", ".join(f"{lo:g} {hi:g}" for lo, hi in bounds.tolist())
        message = f"expected box bounds lo <= hi, got {shown}"
        raise InputError(message, place)
    return bounds


def tilted(bounds: Floats, tilt: Floats, place: Place) -> tuple[Floats, Floats]:
    """Box before tilting (3, 2) and cell (3, 3), rows a b c, of bounds (3, 2) around the tilted cell and tilt xy xz yz.

    a is along x and b in the xy plane. Raises InputError where the bounds are narrower than the tilt.
    """
    xy, xz, yz = tilt.tolist()
    shifts = np.array([[min(0.0, xy, xz, xy + xz), max(0.0, xy, xz, xy + xz)], [min(0.0, yz), max(0.0, yz)], [0.0, 0.0]])
    box = orthogonal(bounds - shifts, place)
    cell = np.diag(box[:, 1] - box[:, 0])
    cell[1, 0], cell[2, 0], cell[2, 1] = xy, xz, yz
    return box, cell


def general(vectors: Floats, origin: Floats, place: Place) -> tuple[Floats, Floats]:
    """Box (3, 2) and cell (3, 3) of edge vectors a b c, the rows of `vectors`, in any direction, from `origin`.

    The box has the lengths that LAMMPS gives the cell when it turns it so that a is along x and b in the xy plane.
    Raises InputError for what is not a number.
    """
    lengths = np.abs(np.diag(np.linalg.qr(vectors.T, mode="r")))
    return orthogonal(np.column_stack([origin, origin + lengths]), place), vectors

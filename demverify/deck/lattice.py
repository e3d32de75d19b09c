"""Lattices and the points they put into a box, in the order and with the round-off of LAMMPS."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from demverify.deck.command import Command
from demverify.deck.setup import Floats, Ints, Setup
from demverify.errors import InputError

_HALF = 0.5
_BASIS: dict[str, list[tuple[float, float, float]]] = {
    "sc": [(0, 0, 0)],
    "bcc": [(0, 0, 0), (_HALF, _HALF, _HALF)],
    "fcc": [(0, 0, 0), (_HALF, _HALF, 0), (_HALF, 0, _HALF), (0, _HALF, _HALF)],
    "hcp": [(0, 0, 0), (_HALF, _HALF, 0), (_HALF, 5.0 / 6.0, _HALF), (0, 1.0 / 3.0, _HALF)],
    "sq": [(0, 0, 0)],
    "sq2": [(0, 0, 0), (_HALF, _HALF, 0)],
    "hex": [(0, 0, 0), (_HALF, _HALF, 0)],
}
_FLAT = ("sq", "sq2", "hex")
_MOST_POINTS = 1e7
_EDGE = 1e-6  # LAMMPS shifts the window for new particles by this share of a periodic box, to get each image once


@dataclass(frozen=True)
class Lattice:
    """basis (m, 3) in cell units; cell (3,): edges of the unit cell over `scale`; spacing (3,): extent of the cell in the box."""

    style: str
    scale: float
    basis: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    cell: Floats = field(default_factory=lambda: np.ones(3))
    origin: Floats = field(default_factory=lambda: np.zeros(3))
    orient: Ints = field(default_factory=lambda: np.eye(3, dtype=np.int64))
    spacing: Floats = field(default_factory=lambda: np.ones(3))

    def to_box(self, x: Floats) -> Floats:
        """(n, 3) lattice coordinates as box coordinates."""
        return np.asarray(_rotate(self.rows, self.cell * x * self.scale) + self.spacing * self.origin)

    def from_box(self, x: Floats) -> Floats:
        """(n, 3) box coordinates as lattice coordinates."""
        return np.asarray(_rotate(self.rows.T, x - self.spacing * self.origin) / self.scale / self.cell)

    @property
    def rows(self) -> Floats:
        """(3, 3) rotation: the orientation vectors at unit length."""
        return np.asarray(self.orient / np.sqrt((self.orient * self.orient).sum(axis=1, keepdims=True).astype(float)))


def _rotate(rows: Floats, x: Floats) -> Floats:
    """rows @ x for each of the (n, 3), summed from left to right as LAMMPS does (BLAS would round otherwise)."""
    parts = x[:, None, :] * rows[None, :, :]
    return np.asarray(parts[:, :, 0] + parts[:, :, 1] + parts[:, :, 2])


def read_lattice(setup: Setup, cmd: Command) -> Lattice:
    """A lattice from its command. Raises InputError. In lj units the number is a reduced density, else a length."""
    style = cmd.choice("style", ("none", *_BASIS))
    cmd.what = f"lattice {style}"
    number = cmd.positive("scale")
    if style == "none":
        cmd.end()
        return Lattice(style, number, spacing=np.full(3, number))
    if (style in _FLAT) != (setup.dimension == 2):
        raise cmd.error(f"does not fit dimension {setup.dimension}")
    basis = np.array(_BASIS[style], dtype=float)
    cell = np.array([1.0, np.sqrt(3.0) if style in ("hex", "hcp") else 1.0, np.sqrt(8.0 / 3.0) if style == "hcp" else 1.0])
    scale = number
    if setup.units == "lj":
        scale = float((len(basis) / np.prod(cell) / number) ** (1.0 / setup.dimension))
    return _oriented(cmd, style, scale, basis, cell)


def _oriented(cmd: Command, style: str, scale: float, basis: Floats, cell: Floats) -> Lattice:
    origin, orient, spacing = np.zeros(3), np.eye(3, dtype=np.int64), None
    while cmd:
        keyword = cmd.choice("keyword", ("origin", "orient", "spacing"))
        if keyword == "origin":
            origin = np.array([cmd.number(f"origin {k}", 0.0, np.nextafter(1.0, 0.0)) for k in "xyz"])
        elif keyword == "orient":
            row = "xyz".index(cmd.choice("orient dim", "xyz"))
            orient[row] = [cmd.integer(f"orient {k}") for k in "ijk"]
        else:
            spacing = np.array([cmd.positive(f"spacing {k}") for k in "xyz"]) * scale
    _check_orient(cmd, orient)
    bare = Lattice(style, scale, basis, cell, np.zeros(3), orient, np.zeros(3))
    corners = np.array([(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=float)
    extent = np.ptp(bare.to_box(corners), axis=0)
    return Lattice(style, scale, basis, cell, origin, orient, extent if spacing is None else spacing)


def _check_orient(cmd: Command, orient: Ints) -> None:
    gram = orient @ orient.T
    if np.any(gram != np.diag(np.diag(gram))) or np.linalg.det(orient.astype(float)) <= 0.0:
        raise cmd.error("orient vectors must be orthogonal, not zero and right-handed")


def lattice_points(setup: Setup) -> tuple[Floats, Ints]:
    """(n, 3) lattice points inside the box and their (n,) basis indices, in the order in which LAMMPS makes them."""
    lattice: Lattice = setup.lattice
    box = setup.box
    assert box is not None
    corners = np.stack(np.meshgrid(*zip(box.lo, box.hi, strict=True)), axis=-1).reshape(-1, 3)
    reach = lattice.from_box(corners)
    if (count := float(np.prod(np.ptp(reach, axis=0) + 3.0))) * len(lattice.basis) > _MOST_POINTS:
        raise InputError(f"the lattice has {count:.1e} cells in this box, more than {_MOST_POINTS:.0e} points")
    lo, hi = np.floor(reach.min(axis=0)).astype(int) - 1, np.ceil(reach.max(axis=0)).astype(int) + 1
    if setup.dimension == 2:
        lo[2] = hi[2] = 0
    k, j, i, m = np.meshgrid(*(np.arange(lo[a], hi[a] + 1) for a in (2, 1, 0)), np.arange(len(lattice.basis)), indexing="ij")
    cells = np.column_stack([i.ravel(), j.ravel(), k.ravel()])
    x = lattice.to_box(cells + lattice.basis[m.ravel()])
    edge = np.where(box.periodic, (box.hi - box.lo) * _EDGE, 0.0)
    kept = np.all((x >= box.lo - edge) & (x < box.hi - 2.0 * edge), axis=1)
    return x[kept], m.ravel()[kept]

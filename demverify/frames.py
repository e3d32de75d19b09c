"""A frame: what one engine says of every particle at one step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

UNKNOWN_BOUNDARY = ("??", "??", "??")


@dataclass(frozen=True)
class Frame:
    """One snapshot, rows sorted by particle id. Float64 throughout.

    step: timestep number. box: (3, 2) lower and upper bounds; of a tilted box, of the cell before it was tilted; NaN: not known.
    boundary: per axis two letters of p f s m; UNKNOWN_BOUNDARY where the file does not say (VTK, MDAnalysis).
    columns: name -> (n,) array, under LAMMPS' own dump names (id type mol x y z xu yu zu ix iy iz vx vy vz fx fy fz omegax omegay omegaz
    tqx tqy tqz radius diameter mass density ...).
    cell: (3, 3) rows a, b, c of a tilted box, None for an orthogonal one.
    time, units: as the file says (ITEM: TIME, ITEM: UNITS), None where it does not.
    dialect: the engine that wrote the file, where that shows; None where it does not.
    local: rows are what `dump local` lists (bodies, contacts), in the order of the file, not particles.
    """

    step: int
    box: Floats
    boundary: tuple[str, str, str]
    columns: dict[str, Floats]
    cell: Floats | None = None
    time: float | None = None
    units: str | None = None
    dialect: Literal["lammps", "liggghts"] | None = None
    local: bool = False

    @property
    def n(self) -> int:
        """Number of particles."""
        return len(next(iter(self.columns.values()))) if self.columns else 0

    @property
    def edges(self) -> Floats:
        """Edge vectors a, b, c of the box, (3, 3), rows."""
        return np.diag(self.box[:, 1] - self.box[:, 0]) if self.cell is None else self.cell

    def vectors(self, x: str, y: str, z: str) -> Floats:
        """Three columns as an (n, 3) array, e.g. vectors("fx", "fy", "fz"). Raises KeyError naming what exists."""
        missing = [name for name in (x, y, z) if name not in self.columns]
        if missing:
            message = f"no column {missing[0]!r}; this frame has {' '.join(self.columns)}"
            raise KeyError(message)
        return np.column_stack([self.columns[x], self.columns[y], self.columns[z]])


@dataclass(frozen=True)
class Thermo:
    """A thermo table: column names as the engine prints them, values (rows, columns) float64."""

    columns: tuple[str, ...]
    values: Floats

    def __getitem__(self, name: str) -> Floats:
        return self.values[:, self.columns.index(name)]


def by_step(frames: Iterable[Frame]) -> dict[int, Frame]:
    """Frames keyed by step; of frames with the same step the last one wins (a `run` boundary writes it twice)."""
    return {frame.step: frame for frame in frames}

"""Frames of an MDAnalysis Universe (any reader; https://docs.mdanalysis.org).

MDAnalysis keeps positions, velocities and forces in float32 and moves LAMMPS boxes to the origin; what a reader puts into `ts.data`
(LAMMPS dumps with additional_columns=True: omegax, radius, mass, type, mol ...) is float64. Numbers are in the units that MDAnalysis hands
out. It tells no boundary flags, no units and no dialect.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from demverify.frames import UNKNOWN_BOUNDARY, Floats, Frame

if TYPE_CHECKING:
    from MDAnalysis import Universe

_DUMP = "LAMMPSDUMP"
_OF_TOPOLOGY = {"masses": "mass", "radii": "radius", "types": "type"}


def frames_of_universe(universe: Universe) -> Iterator[Frame]:
    """A frame for every step of the trajectory."""
    for _ in universe.trajectory:
        yield frame_of(universe)


def frame_of(universe: Universe) -> Frame:
    """The frame where the trajectory stands, rows sorted by id (those of the topology, else 1 to n), arrays of its own.

    Columns: id; x y z (xu yu zu when a LAMMPS dump was read in an unwrapped convention), vx vy vz, fx fy fz; what has a number a particle in
    ts.data; mass, radius and type of the topology where it has them, unless MDAnalysis guessed them. Bounds start at 0 and are NaN
    without a box. time is None for a LAMMPS dump opened without `dt`: MDAnalysis would count steps.
    """
    ts = universe.trajectory.ts
    columns = _of_topology(universe, ts) | _vectors(universe.trajectory, ts)
    columns |= {name: np.asarray(values, dtype=np.float64) for name, values in ts.data.items() if _has_a_row_each(values, ts.n_atoms)}
    order = np.argsort(columns["id"], kind="stable")
    step = int(ts.data.get("step", ts.frame))
    counted = universe.trajectory.format == _DUMP and "dt" not in ts.data
    box, cell = _box(ts)
    time = None if counted else float(ts.time)
    return Frame(step, box, UNKNOWN_BOUNDARY, {name: values[order] for name, values in columns.items()}, cell, time)


def hides_columns(universe: Universe) -> bool:
    """True for a LAMMPS dump that was opened without `additional_columns`."""
    trajectory = universe.trajectory
    return bool(trajectory.format == _DUMP and not any(_has_a_row_each(values, trajectory.n_atoms) for values in trajectory.ts.data.values()))


def _has_a_row_each(values: object, n: int) -> bool:
    return isinstance(values, np.ndarray) and values.shape == (n,) and values.dtype.kind in "iufb"


def _of_topology(universe: Universe, ts: Any) -> dict[str, Floats]:
    atoms = universe.atoms
    guessed = {attribute.attrname for attribute in universe._topology.guessed_attributes}
    columns = {"id": atoms.ids.astype(np.float64) if hasattr(atoms, "ids") else np.arange(1.0, ts.n_atoms + 1.0)}
    for attribute, name in _OF_TOPOLOGY.items():
        values = getattr(atoms, attribute, None)
        if values is None or attribute in guessed or (attribute == "masses" and _made_up(universe, values)):
            continue
        try:
            columns[name] = np.array(values, dtype=np.float64)
        except ValueError:  # types that are words
            continue
    return columns


def _made_up(universe: Universe, masses: Floats) -> bool:
    """The parser of LAMMPS dumps gives every particle a mass of 1 where the dump has none, and does not call it guessed."""
    return bool(universe.trajectory.format == _DUMP and (masses == 1.0).all())


def _vectors(trajectory: Any, ts: Any) -> dict[str, Floats]:
    unwrapped = getattr(trajectory, "lammps_coordinate_convention", "").endswith("unwrapped")
    found = {("xu", "yu", "zu") if unwrapped else ("x", "y", "z"): ts.positions} if ts.has_positions else {}
    found |= {("vx", "vy", "vz"): ts.velocities} if ts.has_velocities else {}
    found |= {("fx", "fy", "fz"): ts.forces} if ts.has_forces else {}
    return {name: values[:, i].astype(np.float64) for names, values in found.items() for i, name in enumerate(names)}


def _box(ts: Any) -> tuple[Floats, Floats | None]:
    if ts.dimensions is None:
        return np.full((3, 2), np.nan), None
    edges = np.asarray(ts.triclinic_dimensions, dtype=np.float64)
    tilted = bool((ts.dimensions[3:] != 90.0).any())
    return np.column_stack([np.zeros(3), np.diag(edges)]), edges if tilted else None

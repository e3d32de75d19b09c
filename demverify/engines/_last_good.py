"""The last state of a native run before it went wrong, as a dump that every reader of dumps understands."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from demsolver import Simulation
from demsolver.guard import Good
from demsolver.scene import Box, Particles
from demverify.deck.setup import DumpSpec, Setup
from demverify.errors import Place
from demverify.formats.columns import Snapshot, snapshot_frame
from demverify.formats.dump import DumpWriter

NAME = "last-good.dump"
COLUMNS = (
    "id", "type", "x", "y", "z", "ix", "iy", "iz", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "radius", "mass",
)  # fmt: skip


def save_last_good(folder: Path, setup: Setup, simulation: Simulation) -> str:
    """Writes folder/last-good.dump, whole or not at all, with all digits. Returns what to tell of it, nothing where there is no such state."""
    if (good := simulation.last_good) is None:
        return ""
    spec = DumpSpec("last-good", "all", "custom", 1, NAME, COLUMNS, Place(folder / NAME), sort="id", format={"float": "%.17g"})
    with DumpWriter(spec, setup.dialect, folder) as writer:
        writer.write(snapshot_frame(snapshot_of(good, simulation, setup.dimension), COLUMNS, spec.place))
    return f"; the last good state, of step {good.step}, is in {folder / NAME}"


def snapshot_of(good: Good, simulation: Simulation, dimension: int) -> Snapshot:
    """The state with what does not move: those particles that are still there."""
    now = simulation.particles()
    still = np.isin(good.id, now.id)
    ids = good.id[still]
    at = np.searchsorted(now.id, ids, sorter=np.argsort(now.id))
    at = np.argsort(now.id)[at]
    kept = Particles(
        ids, now.type[at], good.x[still], good.v[still], good.omega[still], now.radius[at], now.mass[at], now.mask[at],
        good.image[still].astype(np.int64),
    )  # fmt: skip
    nothing = np.zeros((len(ids), 3))
    box = Box(good.lo, good.hi, simulation.scene.box.boundary)
    return Snapshot(good.step, box, kept, nothing, nothing, np.zeros(len(ids), dtype=np.int64), dimension)

"""Decks and dumps of LIGGGHTS 3.8.0 with superquadrics (tests/data/superquadric), and the native engine on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from demsolver import Scene, Simulation
from demverify.formats.dump import read_dump
from demverify.frames import Frame
from demverify.runs import plan

DATA = Path(__file__).parents[1] / "data/superquadric"


def scene_of(name: str) -> Scene:
    """Of the deck of that name."""
    return plan(DATA / f"decks/in.{name}", {}).runs[0].scene


def frames_of(path: str) -> list[Frame]:
    """The frames of a dump, `path` below the folder of the data."""
    return list(read_dump(DATA / f"{path}.dump.gz"))


def vectors(frame: Frame, name: str) -> np.ndarray:
    """Columns of three: x "", v, f, omega, tq, angmom."""
    return frame.vectors(f"{name}x", f"{name}y", f"{name}z")


def place(simulation: Simulation, frame: Frame) -> None:
    """Puts the bodies where a dump has them, with its forces as those of the last step; contacts keep what they remember."""
    b, order = simulation._bodies, simulation._order
    for array, name in ((b.x, ""), (b.v, "v"), (b.omega, "omega"), (b.angmom, "angmom"), (b.force, "f"), (b.torque, "tq")):
        array[:] = vectors(frame, name)[order]
    b.quat[:] = np.column_stack([frame.columns[f"quat{k}"] for k in range(1, 5)])[order]
    if np.abs(b.x - b.held).max() > 0.5 * simulation.scene.neighbor.skin:
        simulation._relist()


def steps_from(scene: Scene, frames: Sequence[Frame]) -> Iterator[tuple[Simulation, Frame]]:
    """The simulation at the set-up and, one step on from each dumped state, at the next frame; beside what LIGGGHTS has there."""
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    yield simulation, frames[0]
    for before, now in pairwise(frames):
        place(simulation, before)
        simulation.advance(1)
        yield simulation, now


class Worst:
    """The largest difference in force and torque over the largest force and torque there is, of some bodies."""

    def __init__(self, frames: Sequence[Frame], rows: slice = slice(None)) -> None:
        self.rows = rows
        self.most = [max(np.abs(vectors(frame, name)[rows]).max() for frame in frames) for name in ("f", "tq")]
        self.force = self.torque = 0.0

    def look(self, simulation: Simulation, frame: Frame) -> None:
        """At one more frame."""
        force, torque = simulation.forces()
        self.force = max(self.force, np.abs(force - vectors(frame, "f"))[self.rows].max() / self.most[0])
        self.torque = max(self.torque, np.abs(torque - vectors(frame, "tq"))[self.rows].max() / self.most[1])

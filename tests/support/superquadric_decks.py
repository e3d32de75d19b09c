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


WORDS = """atom_style superquadric
atom_modify map array sort 0 0
boundary f f f
newton off
communicate single vel yes
units si
region box block -1 1 -1 1 -1 1 units box
create_box 1 box
create_atoms 1 single 0 0 0
create_atoms 1 single 0.01 0.005 0.06
set type 1 shape 0.03 0.025 0.035 blockiness 4 3 density 2500
set atom 1 quat 1 1 0 30 omegax 3
set atom 2 vz -0.5
"""
RULES = """neighbor 0.01 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 1e7
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.6
fix m4 all property/global coefficientFriction peratomtypepair 1 0.4
pair_style gran model hertz tangential history surface superquadric
pair_coeff * *
timestep 4e-05
fix w0 all wall/gran model hertz tangential history surface superquadric primitive type 1 zplane -0.033
fix move all nve/superquadric integration_scheme 1
compute rot all erotate/superquadric
thermo_style custom step atoms ke c_rot
thermo_modify norm no
thermo 20
"""
"""Two superquadrics that touch each other, and one of them a plane; the same source for the compiler as the deck plane_friction."""


def deck(*changes: tuple[str, str], end: str = "run 40\n") -> str:
    """Their deck with words replaced, each of which must be there."""
    text = WORDS + RULES + end
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return text

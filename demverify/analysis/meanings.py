"""What a dump does not say of itself: what its columns are, which materials, which clumps. From a deck, or from options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from demsolver.shapes.multisphere import Template
from demverify.deck.setup import Dialect
from demverify.frames import Frame


@dataclass(frozen=True)
class DumpWords:
    """One `dump` command: file as in the deck (with its `*`), style, and the columns as its header would name them."""

    file: str
    style: str
    columns: tuple[str, ...]


@dataclass(frozen=True)
class Meanings:
    """All of it optional.

    names: column of the dump -> what it is. Particles: the words of `dump custom` (id type mass radius diameter density x y z
        vx vy vz omegax omegay omegaz angmomx angmomy angmomz tqx tqy tqz quat1 quat2 quat3 quat4 (w x y z) shapex shapey shapez
        blockiness1 blockiness2 mol id_multisphere). Bodies (`compute multisphere property`): id_multisphere masstotal xcm[1]
        xcm[2] xcm[3] vcm[i] omega[i] angmom[i] quat[i] inertia[i] clumptype.
    density: particle type -> density. unknown_density: why other types have none, for messages.
    dimension: 2 makes the mass of a particle that of a disc. timestep: time of one step. units: word of the `units` command.
    atom_style: words of the `atom_style` command; empty: not known.
    rigid: how particles belong to rigid bodies: "molecule" (LAMMPS fix rigid molecule), "multisphere" (LIGGGHTS), "none" (the deck
        has neither), None: nobody has said.
    templates: the clumps that the deck inserts. dumps: the deck's dump commands, for files without column names.
    """

    dialect: Dialect | None = None
    units: str | None = None
    atom_style: tuple[str, ...] = ()
    timestep: float | None = None
    dimension: int = 3
    names: Mapping[str, str] = field(default_factory=dict)
    density: Mapping[int, float] = field(default_factory=dict)
    unknown_density: tuple[str, ...] = ()
    rigid: Literal["molecule", "multisphere", "none"] | None = None
    templates: tuple[Template, ...] = ()
    dumps: tuple[DumpWords, ...] = ()

    def dialect_of(self, frame: Frame) -> Dialect | None:
        """Whose words a frame's columns are: the deck's, else what the file shows; None: nobody says."""
        return self.dialect or frame.dialect

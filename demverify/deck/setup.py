"""What the commands of a deck have built so far. Commands fill it in; `run` hands it to an engine; `scene_of` freezes it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from demverify.errors import Place

if TYPE_CHECKING:
    from demsolver.memories import Memories
    from demsolver.scene import Box, Clumps, Superquadrics
    from demverify.deck.rotating import Turn

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Dialect = Literal["lammps", "liggghts"]


@dataclass
class Atoms:
    """The particles, as arrays of n rows (see demsolver.scene.Particles). mass is NaN until something gave it."""

    id: Ints
    type: Ints
    x: Floats
    v: Floats
    omega: Floats
    radius: Floats
    mass: Floats
    mask: Ints
    image: Ints
    molecule: Ints
    superquadrics: Superquadrics | None = None
    clumps: Clumps | None = None

    @property
    def n(self) -> int:
        """Number of particles."""
        return len(self.id)


@dataclass(frozen=True)
class Spec:
    """A fix, compute or dump as the deck wrote it: `fix ID group style args...`. `group` is the group's name."""

    id: str
    group: str
    style: str
    args: tuple[str, ...]
    place: Place


@dataclass
class DumpSpec:
    """A dump custom as the deck and its dump_modify lines wrote it."""

    id: str
    group: str
    style: str  # custom | atom
    every: int
    file: str
    columns: tuple[str, ...]
    place: Place  # of the dump, or of its last dump_modify
    sort: str | None = None
    format: dict[str, str] = field(default_factory=dict)  # "float" | "int" | "line" | column number -> printf format
    first: bool = False
    pad: int = 0


@dataclass
class ThermoSpec:
    """thermo, thermo_style and thermo_modify as the deck wrote them."""

    every: int = 0
    style: str = "one"
    columns: tuple[str, ...] = ()  # filled for style custom
    modify: dict[str, str] = field(default_factory=dict)  # norm yes|no, lost ..., format ..., flush ...
    place: Place | None = None  # of thermo_style


@dataclass
class NeighborSpec:
    """neighbor and neigh_modify as the deck wrote them."""

    skin: float | None = None  # None: the default of the units
    every: int = 1
    delay: int | None = None  # None: the default of the dialect (LAMMPS 2025: 0, LIGGGHTS: 10)
    check: bool = True
    exclude: list[tuple[str, str, str]] = field(default_factory=list)  # ("group"|"type", a, b)
    exclude_intra: list[tuple[str, Place]] = field(default_factory=list)  # groups within whose molecules nobody sees another
    contact_distance_factor: float = 1.0


@dataclass
class Setup:
    """The state of a deck between two commands."""

    dialect: Dialect
    units: str = "lj"
    dimension: int = 3
    atom_style: str = "sphere"
    boundary: tuple[str, str, str] = ("pp", "pp", "pp")
    newton: bool = True
    box: Box | None = None
    ntypes: int = 0
    atoms: Atoms | None = None
    groups: dict[str, int] = field(default_factory=lambda: {"all": 0})
    regions: dict[str, Any] = field(default_factory=dict)
    lattice: Any = None
    pair_style: tuple[str, ...] | None = None
    pair_place: Place | None = None
    pair_coeffs: list[tuple[tuple[str, ...], Place]] = field(default_factory=list)
    fixes: dict[str, Spec] = field(default_factory=dict)
    computes: dict[str, Spec] = field(default_factory=dict)
    dumps: dict[str, DumpSpec] = field(default_factory=dict)
    thermo: ThermoSpec = field(default_factory=ThermoSpec)
    neighbor: NeighborSpec = field(default_factory=NeighborSpec)
    timestep: float | None = None  # None: the default of the units
    step: int = 0
    time: float = 0.0
    turns: dict[str, Turn] = field(default_factory=dict)  # of the last run: how the regions turned that are walls
    soft_particles: bool = False  # LIGGGHTS: lifts the lower bound on youngsModulus
    hard_particles: bool = False  # LIGGGHTS: lifts the upper one
    cleared: bool = False  # whether a `clear` came before: only read_restart can make the box then
    memories: Memories | None = None  # of a restart file, until the next run takes them up
    restored: Place | None = None  # where the deck said read_restart
    folder: Path = field(default_factory=Path)  # of the deck: where the files are that it names
    inserted: set[str] = field(default_factory=set)  # fixes insert/pack that have done so
    molecules: dict[str, Any] = field(default_factory=dict)  # LAMMPS: what `molecule` read
    variables: Any = None  # the deck's demverify.deck.variables.Variables, for v_name in thermo and print lines

    @property
    def dt(self) -> float:
        """The time step: the deck's own, or the default of its units, in both engines lj 0.005, si and cgs 1e-8, micro 2."""
        return self.timestep if self.timestep is not None else {"lj": 0.005, "micro": 2.0}.get(self.units, 1e-8)

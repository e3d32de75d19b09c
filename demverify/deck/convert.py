"""A deck of one dialect as a deck of the other: the same commands in the same order, with what differs said in the other's words.

Variables are substituted and loops unrolled. Where particles come from a data file or from random numbers, or where LIGGGHTS needs a
type of its own for a wall, their state at the first run is handed over in a data file beside the deck, exact to the last bit.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from demsolver.scene import Cylinder, Plane
from demverify.deck import convert_laws as laws
from demverify.deck.atom_formula import COLUMNS
from demverify.deck.command import Executed
from demverify.deck.scene_builder import LOST
from demverify.deck.setup import Dialect
from demverify.errors import InputError, Place
from demverify.formats.atomic import atomic_write, check_writable
from demverify.formats.data_file import write_data

if TYPE_CHECKING:
    from demsolver.scene import ContactLaw
    from demverify.runs import Plan

WALLS = ("wall/gran", "wall/gran/region")
WATCHING = ("dump", "dump_modify", "undump", "fix", "unfix")  # left out where the reader did: the other engine may not know the style
STATE = (
    "create_box", "create_atoms", "read_data", "set", "velocity", "displace_atoms", "lattice", "mass", "density", "diameter", "molecule",
)  # fmt: skip
DROPPED = ("variable", "log", "echo", "processors", "comm_modify", "communicate", "newton", "atom_modify", "suffix", "package", "label",
           "pair_coeff", "pair_modify", "soft_particles", "hard_particles", "thermo_modify", "compute_modify", "fix_modify", "timers",
           "run_style", "next", "jump", "include", "if", "info", "timer", "balance", "restart",
           "write_restart", "write_data", "write_dump")  # fmt: skip


@dataclass(frozen=True)
class Conversion:
    """A converted deck: its lines, whether a data file goes with it, and which setting was mapped to what (theirs, ours, meaning)."""

    target: Dialect
    lines: tuple[str, ...]
    ntypes: int
    handover: bool
    rows: tuple[tuple[str, str, str], ...]


def convert(plan: Plan, target: Dialect, output: Path) -> Conversion:
    """Writes the deck of `plan` in the other dialect to `output`, and a data file beside it where one is needed.

    Raises InputError for a deck that is in this dialect already, that goes on with results of its own runs, or that says something
    the other engine cannot.
    """
    check_writable(output)
    if output.exists() and output.samefile(plan.deck):
        message = f"{output} is the deck that is converted; expected another file to write"
        raise InputError(message)
    found = conversion(plan, target, output.name + ".data")
    if found.handover:
        setup = plan.runs[0].setup
        assert setup.atoms is not None
        assert setup.box is not None
        write_data(output.with_name(output.name + ".data"), setup.atoms, setup.box, found.ntypes, target, setup.dimension)
    with atomic_write(output) as temporary:
        temporary.write_text("\n".join(found.lines) + "\n")
    return found


def conversion(plan: Plan, target: Dialect, data_name: str) -> Conversion:
    """The lines of the converted deck; writes nothing."""
    if plan.dialect == target:
        message = f"this is a {target} deck already"
        raise InputError(message, Place(plan.deck))
    if not plan.runs or not plan.whole:
        message = "cannot be converted: it " + ("has no run" if not plan.runs else "goes on with values that only its own runs give")
        raise InputError(message, Place(plan.deck))
    if plan.setup.atom_style == "superquadric":
        message = "cannot be converted: LAMMPS has no superquadrics like those of LIGGGHTS"
        raise InputError(message, Place(plan.deck))
    if any(run.scene.particles.clumps is not None for run in plan.runs):
        message = "this deck has clumps, which are not converted: the engines place them by other commands and files"
        raise InputError(message, Place(plan.deck))
    return _Translator(plan, target, data_name).translate()


class _Translator:
    def __init__(self, plan: Plan, target: Dialect, data_name: str) -> None:
        self.plan, self.target, self.data_name = plan, target, data_name
        self.setup = plan.runs[0].setup
        self.scene = plan.runs[0].scene
        self.place = self.setup.pair_place
        self.rows: list[tuple[str, str, str]] = []
        self.ntypes = self.setup.ntypes
        self.wall_types: list[int] = []
        self.tables: list[laws.Table] = []
        self.pair: ContactLaw | None = None
        self.walls: list[ContactLaw] = []
        if target == "liggghts":
            self._type_walls()
        self.handover = self.ntypes > self.setup.ntypes or any(_draws(e) or e.words[0] == "read_data" for e in plan.interpreter.executed)
        self._handed = self._ran = self._paired = False
        self._written: dict[str, list[str]] = {}  # ID of a fix -> those it has become

    def translate(self) -> Conversion:
        lines = [f"# {self.target} deck written by demverify from {self.plan.deck.name}"]
        left_out = {line for line in self.plan.interpreter.ignored if line.words[0] in WATCHING}
        for executed in self.plan.interpreter.executed:
            for line in self._one(executed) if executed not in left_out else ():
                lines.append(line)
                if line.split() != executed.text.split():
                    self.rows.append((f"{executed.place.line}: {' '.join(executed.text.split())}", line, ""))
        return Conversion(self.target, tuple(lines), self.ntypes, self.handover, tuple(self.rows))

    def _one(self, executed: Executed) -> Iterator[str]:
        name, words = executed.words[0], executed.words
        if name in ("clear", "read_restart"):
            message = f"{name}: a deck that restarts is not converted"
            raise InputError(message, executed.place)
        if name == "run":
            if not self._ran and "lost" not in self.setup.thermo.modify:  # the dialects differ in the default
                yield f"thermo_modify lost {LOST[self.plan.dialect]}"
            self._ran = True
        if self._ran and (name in ("pair_style", "pair_coeff") or (name == "fix" and words[3] in (*WALLS, "property/global"))):
            message = f"{' '.join(words[:4])}: contact laws that change between runs are not converted"
            raise InputError(message, executed.place)
        if name in STATE and self.handover and not self._ran:
            yield from self._hand_over(name)
        elif name == "variable" and words[2:3] == ("equal",):
            yield f"variable {words[1]} equal \"{' '.join(words[3:])}\""
        elif name == "variable" and words[2:3] == ("atom",):
            yield f"variable {words[1]} atom \"{self._atom_formula(' '.join(words[3:]))}\""
        elif name == "thermo_modify":
            yield from self._thermo_modify(words)
        elif name in COMMANDS:
            yield from COMMANDS[name](self, words)
        elif name not in DROPPED:
            yield executed.text.strip()

    def _atom_formula(self, formula: str) -> str:
        """The formula with the other engine's words for what a particle has."""
        theirs = COLUMNS[self.plan.dialect]
        ours = {column: word for word, column in COLUMNS[self.target].items()}
        return re.sub(r"[A-Za-z_]\w*", lambda word: ours[theirs[word[0]]] if word[0] in theirs else word[0], formula)

    def _hand_over(self, name: str) -> Iterator[str]:
        if not self._handed and name in ("create_box", "read_data"):
            self._handed = True
            yield f"read_data {self.data_name}"

    def _type_walls(self) -> None:
        """LIGGGHTS: tables of the pair law, widened where a wall has a law of its own, and the type of every wall."""
        pair, particles = self.scene.pair, self.scene.particles
        self.pair = laws.absolute(pair, particles, wall=False) if pair else None
        self.walls = [laws.absolute(wall.law, particles, wall=True) for wall in self.scene.walls]
        for law in filter(None, [self.pair, *self.walls]):
            laws.liggghts_style(law, self.place)
        if self.pair and laws.is_material(self.pair):
            self.tables = laws.material_tables(self.pair, self.place)
            self.wall_types = laws.material_wall_types(self.pair, self.walls, self.place)
            return
        start = laws.liggghts_tables(self.pair) if self.pair else []
        tables = [laws.liggghts_tables(wall) for wall in self.walls]
        self.tables, self.wall_types = laws.with_wall_types(start, tables, self.ntypes, self.place)
        self.ntypes = max([self.ntypes, *self.wall_types])

    def _atom_style(self, words: tuple[str, ...]) -> Iterator[str]:
        if self.target == "lammps":
            yield from ("atom_style sphere", "comm_modify vel yes")
        else:
            yield from ("atom_style granular", "atom_modify map array", "newton off", "communicate single vel yes")

    def _pair_style(self, words: tuple[str, ...]) -> Iterator[str]:
        law = self.scene.pair
        if law is None or self._paired:
            return
        self._paired = True
        if self.target == "lammps":
            yield "pair_style granular"
            yield from laws.lammps_pair_coeffs(law, self.scene.particles, self.setup.ntypes, self.place)
        else:
            assert self.pair is not None
            yield from self._limits()
            yield from laws.property_lines(self.tables)
            yield f"pair_style gran {laws.liggghts_style(self.pair, self.place)}"
            yield "pair_coeff * *"

    def _limits(self) -> Iterator[str]:
        """LIGGGHTS refuses Young's moduli outside 5e6 to 1e9 Pa unless told."""
        young = next((table.values for table in self.tables if table.name == "youngsModulus"), None)
        if young is not None and self.setup.units == "si":
            if young.min() < 5e6:
                yield "soft_particles yes"
            if young.max() > 1e9:
                yield "hard_particles yes"

    def _fix(self, words: tuple[str, ...]) -> Iterator[str]:
        style = words[3]
        if style in WALLS:
            yield from self._wall(words)
        elif style == "euler/sphere":
            message = f"fix {words[1]} euler/sphere: {self.target} has no such integrator, only the native engine"
            raise InputError(message, self.place)
        elif style in ("property/global", "check/timestep/gran"):
            self._written[words[1]] = []
        elif style == "nve/sphere" and self.target == "liggghts":
            yield " ".join(words[:4])
        elif style == "nve/sphere" and self.setup.dimension == 2:
            yield f"{' '.join(words[:4])} disc"
        else:
            yield " ".join(words)

    def _wall(self, words: tuple[str, ...]) -> Iterator[str]:
        names = [wall.name for wall in self.scene.walls]
        written = self._written[words[1]] = []
        if words[1] not in names:  # taken away again before the first run
            return
        index = names.index(words[1])
        wall = self.scene.walls[index]
        head = " ".join(("fix", words[1], words[2], "wall/gran"))
        if any(wall.velocity) or (wall.shape.moving if isinstance(wall.shape, Plane) else isinstance(wall.shape, Cylinder) and wall.shape.rotation):
            message = f"fix {words[1]}: a moving wall is not converted"
            raise InputError(message, self.place)
        if self.target == "lammps":
            written.append(words[1])
            yield f"{head} {laws.lammps_wall(wall, self.scene.particles, self.place)}"
            return
        style = laws.liggghts_style(self.walls[index], self.place)
        for k, text in enumerate(laws.liggghts_walls(wall, style, self.wall_types[index], self.place)):
            written.append(words[1] if k == 0 else f"{words[1]}_{k}")
            yield f"fix {written[-1]} {words[2]} wall/gran {text}"

    def _unfix(self, words: tuple[str, ...]) -> Iterator[str]:
        for name in self._written.pop(words[1], [words[1]]):
            yield f"unfix {name}"

    def _compute(self, words: tuple[str, ...]) -> Iterator[str]:
        yield " ".join((*words[:3], "erotate/sphere" if self.target == "lammps" and words[3] == "erotate" else words[3], *words[4:]))

    def _thermo_style(self, words: tuple[str, ...]) -> Iterator[str]:
        if words[1] == "custom":
            yield " ".join(word for word in words if self.target == "liggghts" or not word.startswith("f_"))  # of fix check/timestep/gran
            if "norm" not in self.setup.thermo.modify:
                yield f"thermo_modify norm {'yes' if self.setup.units == 'lj' else 'no'}"

    def _thermo_modify(self, words: tuple[str, ...]) -> Iterator[str]:
        kept = [(key, value) for key, value in itertools.pairwise(words) if key in ("norm", "lost")]
        if kept:
            yield "thermo_modify " + " ".join(f"{key} {value}" for key, value in kept)

    def _dump_modify(self, words: tuple[str, ...]) -> Iterator[str]:
        kept = [(key, value) for key, value in itertools.pairwise(words) if key in ("sort", "every", "first", "pad")]
        if kept:
            yield f"dump_modify {words[1]} " + " ".join(f"{key} {value}" for key, value in kept)

    def _neighbor(self, words: tuple[str, ...]) -> Iterator[str]:
        yield " ".join(words)
        if self.setup.neighbor.delay is None:  # the dialects differ in the default
            yield f"neigh_modify delay {0 if self.plan.dialect == 'lammps' else 10}"


COMMANDS: dict[str, Callable[[_Translator, tuple[str, ...]], Iterator[str]]] = {
    "atom_style": _Translator._atom_style,
    "pair_style": _Translator._pair_style,
    "fix": _Translator._fix,
    "unfix": _Translator._unfix,
    "compute": _Translator._compute,
    "thermo_style": _Translator._thermo_style,
    "dump_modify": _Translator._dump_modify,
    "neighbor": _Translator._neighbor,
}


def _draws(executed: Executed) -> bool:
    """Whether a command draws random numbers, which every engine draws in its own way."""
    words = executed.words
    return (
        (words[0] == "create_atoms" and "random" in words[1:4])
        or (words[0] == "velocity" and "create" in words[2:3])
        or (words[0] == "displace_atoms" and "random" in words[2:3])
        or (words[0] == "set" and any(word.endswith(("fraction", "random")) for word in words))
    )

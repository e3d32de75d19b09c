"""A deck as a dictionary: what the columns of its dumps mean, densities, clumps, units and step, from any deck of either engine.

It need not be one that can be run here. What has nothing to do with dumps is passed over; what matters and cannot be told (the value
of a variable that only a run knows, two densities of one type, a missing file) is noted, and left out of the result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Protocol, TypeVar

from demverify.analysis.meanings import Meanings
from demverify.deck.dialects import detect_dialect
from demverify.deck.dictionary_clumps import Rigid, distinct
from demverify.deck.dictionary_columns import Columns
from demverify.deck.dictionary_particles import Particles
from demverify.deck.dictionary_script import Script, Spoken
from demverify.deck.dictionary_settings import Settings
from demverify.deck.setup import Dialect
from demverify.errors import InputError

_T = TypeVar("_T")


@dataclass(frozen=True)
class Dictionary:
    """meanings: what the deck tells. passed_over: what was not understood and may matter, each with file and line."""

    meanings: Meanings
    passed_over: list[str]


class _Part(Protocol):
    """What reads one kind of commands."""

    def concerns(self, cmd: Spoken) -> bool:
        """Whether a command is of this kind."""

    def read(self, cmd: Spoken) -> None:
        """Raises InputError."""

    def doubt(self, cmd: Spoken, why: str) -> None:
        """A command could not be read; what it may have changed is not known any more."""


class _Chapter:
    """A deck from one `clear` to the next: one simulation."""

    def __init__(self, script: Script, dialect: Dialect) -> None:
        self.settings, self.particles = Settings(), Particles(script, dialect)
        self.rigid, self.columns = Rigid(script), Columns(script)
        self.dumped, self.empty = False, True
        self._script = script
        self._parts: tuple[_Part, ...] = (self.settings, self.particles, self.rigid, self.columns)

    def hear(self, cmd: Spoken) -> None:
        """Takes in a command."""
        for part in self._parts:
            if part.concerns(cmd):
                self.empty = False
                self._take_in(part, cmd)
        self.particles.dimension = self.settings.dimension
        if cmd.name in {"run", "rerun", "write_dump"}:
            dumping = self.columns.dumping or cmd.name == "write_dump"
            self.dumped |= dumping
            self.particles.densities.observe(dumping=dumping)
            if cmd.name == "run" and cmd.args[:1] != ("0",):
                self.settings.run(dumping=dumping)

    def _take_in(self, part: _Part, cmd: Spoken) -> None:
        fresh = Spoken((cmd.name, *cmd.args), cmd.text, cmd.place, certain=cmd.certain, unknown=cmd.unknown)
        try:
            part.read(fresh)
        except InputError as error:
            self._script.note(error, cmd.place)
            part.doubt(cmd, f"the {cmd.name} command of {cmd.where}")

    def meanings(self, dialect: Dialect) -> tuple[Meanings, list[str]]:
        """What it tells, and why not more."""
        names, dumps, of_columns = self.columns.result()
        density, of_density = self.particles.densities.result()
        templates, of_templates = distinct(self.particles.templates)
        timestep, of_step = self.settings.timestep()
        rigid, of_bodies = self.rigid.result()
        told = Meanings(
            dialect=dialect,
            units=self.settings.units,
            atom_style=() if self.particles.style == ("atomic",) else self.particles.style,
            timestep=timestep,
            dimension=self.settings.dimension,
            names=names,
            density=density,
            unknown_density=tuple(of_density),
            rigid=rigid,
            templates=tuple(templates),
            dumps=tuple(dumps),
        )
        return told, of_columns + of_density + of_templates + of_bodies + of_step


def read_dictionary(path: Path, variables: Mapping[str, Sequence[str]] | None = None) -> Dictionary:
    """What a deck tells of its dumps. variables: name -> values, as -var on the command line of the engine.

    Computes, dumps and fixes keep their meaning when they are undone, as the files they wrote do. A `clear` starts anew: what came
    before it counts only if a dump was written there, or if nothing comes after; where a restart file that the deck wrote is read, the simulation
    before goes on. Raises InputError where the deck itself cannot be read.
    """
    dialect = detect_dialect(path)
    script = Script(path, variables or {})
    chapters = [_Chapter(script, dialect)]
    restarts: set[str] = set()
    for cmd in script.commands():
        if cmd.name == "clear":
            chapters.append(_Chapter(script, dialect))
        elif cmd.name == "write_restart":
            restarts.add(cmd.peek())
        elif cmd.name == "read_restart" and len(chapters) > 1 and any(fnmatchcase(cmd.peek(), name) for name in restarts):
            chapters.pop()
        else:
            chapters[-1].hear(cmd)
    kept = [chapter for chapter in chapters if chapter.dumped]
    kept = kept or [chapter for chapter in chapters if not chapter.empty][-1:] or chapters[-1:]
    told = [chapter.meanings(dialect) for chapter in kept]
    merged, notes = _merged([meanings for meanings, _ in told])
    found = [f"{path}: {note}" for note in dict.fromkeys([note for _, of_chapter in told for note in of_chapter] + notes)]
    return Dictionary(merged, [note.replace("\n", " ") for note in script.passed_over + found])  # a quoted word may have lines


def _merged(chapters: Sequence[Meanings]) -> tuple[Meanings, list[str]]:
    """What several simulations in one deck have in common; where they differ, which of them wrote a file is not known."""
    if len(chapters) == 1:
        return chapters[0], []
    first = chapters[0]
    templates, notes = distinct([template for one in chapters for template in one.templates])
    names = {name: what for one in chapters for name, what in one.names.items()}
    merged = Meanings(
        dialect=first.dialect,
        units=_common([one.units for one in chapters]),
        atom_style=_common([one.atom_style for one in chapters]) or (),
        timestep=_common([one.timestep for one in chapters]),
        dimension=_common([one.dimension for one in chapters]) or first.dimension,
        names={name: what for name, what in names.items() if all(one.names.get(name, what) == what for one in chapters)},
        density={kind: rho for kind, rho in first.density.items() if all(one.density.get(kind) == rho for one in chapters)},
        unknown_density=tuple(note for one in chapters for note in one.unknown_density),
        rigid=first.rigid if all(one.rigid == first.rigid for one in chapters) else None,
        templates=tuple(templates),
        dumps=tuple(dump for one in chapters for dump in one.dumps),
    )
    for what in ("units", "timestep", "dimension", "density", "rigid"):
        if any(getattr(one, what) != getattr(merged, what) for one in chapters):
            notes.append(f"{what} is not the same in the simulations that `clear` parts")
    lost = [name for name in names if name not in merged.names]
    return merged, notes + [f"column {name} means other things in the simulations that `clear` parts" for name in lost]


def _common(values: Sequence[_T]) -> _T | None:
    """The value that all have, or None."""
    return values[0] if all(value == values[0] for value in values) else None

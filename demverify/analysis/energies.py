"""Rotational energy of one frame, by shape and particle by particle. What cannot be summed is told, not hidden."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.erotate import LAST, children, erotate_by_shape
from demsolver.computes.ke import ke
from demsolver.computes.population import Energies, Population, RigidBodies
from demverify.analysis.clumps import Inertia, rigid_bodies
from demverify.analysis.doubts import doubts, forecasts, remarks
from demverify.analysis.meanings import Meanings
from demverify.analysis.quantities import bodies_of, check_complete, population_of
from demverify.errors import InputError
from demverify.frames import Floats, Frame

SHAPES = (LAST, *(shape for shape, _ in children() if shape != LAST))
"""Every shape that has a compute: sphere, multisphere, superquadric ..."""
_MVV2E = {"real": 48.88821291**2, "metal": 1.0364269e-4, "electron": 1.06657236}
"""Mass times velocity squared to energy, in units where that is not 1 (LAMMPS, update.cpp)."""
_NAMED = 3  # particles a note names


@dataclass(frozen=True)
class Row:
    """Energies of one frame.

    n: particles in the dump, members of clumps included (as `atoms` in the log); of a dump of bodies alone: bodies.
    by_shape: rotational energy per shape, those that are not there 0. NaN: the frame holds numbers that are not finite.
    ke: translational kinetic energy; None where the dump does not tell it. particles: checksum of the ids.
    """

    step: int
    time: float | None
    n: int
    by_shape: dict[str, float]
    ke: float | None
    particles: int = 0

    @property
    def erotate(self) -> float:
        """Rotational energy of everything."""
        return sum(self.by_shape.values())

    def as_dict(self) -> dict[str, float | int | None]:
        """The columns of the table, in order: step time n erotate sphere multisphere superquadric ke."""
        return {"step": self.step, "time": self.time, "n": self.n, "erotate": self.erotate, **self.by_shape, "ke": self.ke}


@dataclass(frozen=True)
class FrameEnergies:
    """A row; and per shape the energy of each particle or body; and what is to be told of the frame."""

    row: Row
    by_particle: dict[str, Energies]
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Wanted:
    """What is to be computed, and how.

    halfstep: as LIGGGHTS' keyword. clumps: "members": made of the spheres in the frames; "left out": these come from a dump of bodies;
        "alone": the frames are that dump.
    inertia: of a clump: "union" of its spheres, or formula (5) of the seed, "spheres" that do not know of each other; None: the
    convention of the engine that wrote the dump (LIGGGHTS: union; LAMMPS: spheres).
    """

    meanings: Meanings = field(default_factory=Meanings)
    halfstep: bool = False
    clumps: Literal["members", "left out", "alone"] = "members"
    inertia: Inertia | None = None


def energies_of(frame: Frame, wanted: Wanted, present: Sequence[str] = ()) -> FrameEnergies:
    """All of one frame; see `measured`."""
    return measured(frame, wanted, present)[1]


def measured(frame: Frame, wanted: Wanted, present: Sequence[str] = ()) -> tuple[Population, FrameEnergies]:
    """What was summed over, and all of one frame. present: the names of all columns in the file, for messages.

    Numbers that are not finite make the energies of their shape NaN, and a note with step, column and id.
    Raises InputError where the columns do not tell what is needed.
    """
    notes: list[str] = []
    spoilt: set[str] = set()
    try:
        if wanted.clumps == "alone" and not frame.local:
            message = "expected a dump local of bodies, got a dump of particles"
            raise InputError(message)
        if frame.local:
            bodies = _listed(frame, present)
            population = Population(np.empty(0, np.int64), bodies=bodies)
            notes += doubts(bodies.inertia, frame.columns.get("clumptype"), wanted.meanings.templates)
        else:
            population = _sound(population_of(frame, wanted.meanings, halfstep=wanted.halfstep), frame.step, notes, spoilt)
            population = _with_bodies(population, frame, wanted)
            notes += remarks(frame, wanted.meanings)
            if population.bodies and wanted.meanings.dialect_of(frame) == "liggghts":
                notes += forecasts(wanted.meanings.templates)
            check_complete(population, list(present or frame.columns))
        found = dict(erotate_by_shape(population))
    except (ValueError, LookupError) as error:
        message = f"step {frame.step}: {error.message if isinstance(error, InputError) else error.args[0]}"
        raise InputError(message, error.place if isinstance(error, InputError) else None) from None
    factor = energy_factor(frame, wanted.meanings)
    by_particle = {shape: Energies(energies.id, factor * energies.value) for shape, energies in found.items()}
    for shape, energies in by_particle.items():
        bad = ~np.isfinite(energies.value)
        notes += [f"step {frame.step}: the energy of {shape} {i} is not finite" for i in energies.id[bad][:_NAMED]]
    by_shape = {shape: by_particle[shape].total if shape in by_particle else 0.0 for shape in SHAPES}
    by_shape |= dict.fromkeys(spoilt, np.nan)
    row = Row(frame.step, _time(frame, wanted.meanings), frame.n, by_shape, _ke(population, spoilt, factor), crc32(population.id.tobytes()))
    unsound = [name for name, value in (("erotate", row.erotate), ("ke", row.ke)) if not np.isfinite(value or 0.0)]
    if unsound and not any(note.startswith("step ") for note in notes):  # finite numbers, but too large together
        notes.append(f"step {frame.step}: {' and '.join(unsound)} not finite")
    return population, FrameEnergies(row, by_particle, notes)


def energy_factor(frame: Frame, meanings: Meanings) -> float:
    """Mass times velocity squared to energy, in the units of the deck or the file."""
    return _MVV2E.get(meanings.units or frame.units or "", 1.0)


def _listed(frame: Frame, present: Sequence[str]) -> RigidBodies:
    bodies = bodies_of(frame)
    if bodies is None:
        message = (
            "the rows of this dump local are not bodies: expected the columns inertia[1..3], quat[1..4] and angmom[1..3] or omega[1..3], "
            f"got {' '.join(present or frame.columns)}; --deck or --columns can say what they are"
        )
        raise InputError(message)
    return bodies


def _with_bodies(population: Population, frame: Frame, wanted: Wanted) -> Population:
    """The population with the bodies its members make, or without its members when the bodies come from elsewhere."""
    if wanted.clumps == "left out":
        if population.body is None and len(population.id):
            message = "the dump of particles needs a column id_multisphere or mol: members of clumps are to be left out, for their bodies are given"
            raise InputError(message)
        return _rows(population, population.body <= 0) if population.body is not None else population
    if population.body is None or not (population.body > 0).any():
        return population
    return replace(population, bodies=rigid_bodies(population, frame, wanted.meanings, wanted.inertia))


def _sound(population: Population, step: int, notes: list[str], spoilt: set[str]) -> Population:
    """The population without particles that have a number that is not finite; these go into the notes, their shapes into `spoilt`."""
    good = np.ones(len(population.id), dtype=bool)
    clumps = population.body is not None and bool((population.body > 0).any())
    for name, values in _arrays(population):
        if name == "x" and not clumps:
            continue
        fine = np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
        notes += [f"step {step}: {name} of particle {i} is not finite" for i in population.id[~fine][:_NAMED]]
        if name != "v":
            good &= fine
    if good.all():
        return population
    member = np.zeros_like(good) if population.body is None else population.body > 0
    if (member & ~good).any():
        spoilt.add("multisphere")
        good &= ~np.isin(population.body, population.body[member & ~good]) if population.body is not None else good
    if (~member & ~good).any():
        spoilt.add(LAST if population.shape is None else "superquadric")
    return _rows(population, good)


def _arrays(population: Population) -> Iterator[tuple[str, Floats]]:
    for item in fields(population):
        values = getattr(population, item.name)
        if isinstance(values, np.ndarray):
            yield item.name, values


def _rows(population: Population, kept: NDArray[np.bool_]) -> Population:
    taken: dict[str, Any] = {name: values[kept] for name, values in _arrays(population)}
    return replace(population, **taken)


def _time(frame: Frame, meanings: Meanings) -> float | None:
    if frame.time is not None or meanings.timestep is None:
        return frame.time
    return frame.step * meanings.timestep


def _ke(population: Population, spoilt: set[str], factor: float) -> float | None:
    """Translational kinetic energy of free particles and of bodies; None where velocities or masses are missing."""
    free = np.ones(len(population.id), dtype=bool) if population.body is None else population.body <= 0
    total = 0.0
    if free.any():
        if population.mass is None or population.v is None:
            return None
        total += ke(population.mass[free], population.v[free])
    if population.bodies:
        if population.bodies.mass is None or population.bodies.v is None:
            return None
        total += ke(population.bodies.mass, population.bodies.v)
    return np.nan if spoilt else factor * total

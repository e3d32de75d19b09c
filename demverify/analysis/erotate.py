"""`compute erotate` for finished runs: dumps in, energies over time out."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from demverify.analysis.clumps import Inertia
from demverify.analysis.energies import FrameEnergies, Wanted, energies_of, measured
from demverify.analysis.meanings import Meanings
from demverify.analysis.needed import NeededColumns
from demverify.analysis.options import meanings_from
from demverify.analysis.series import Rows, Series, with_bodies
from demverify.errors import InputError, Place
from demverify.formats.dump import blocks_of, dump_files, has_names, read_block
from demverify.formats.reading import Block, Reading
from demverify.formats.universe import frames_of_universe
from demverify.frames import Frame

if TYPE_CHECKING:
    from MDAnalysis import Universe

    from demsolver.computes.population import Population

Paths = str | Path | Sequence[str | Path]
_ROWS = 1 << 18  # in a part: about those of a block


@dataclass(frozen=True)
class Request:
    """Everything that a worker must know; it can be sent to another machine.

    columns: names of all columns of the dump, in order. keep_particles: give every particle's energy back, not only sums.
    """

    wanted: Wanted = field(default_factory=Wanted)
    columns: tuple[str, ...] | None = None
    keep_particles: bool = False


@dataclass(frozen=True)
class Part:
    """Some frames of one file, in order."""

    source: str
    frames: list[FrameEnergies]
    notes: list[str]


def split(request: Request, body_columns: tuple[str, ...] | None = None) -> tuple[Request, Request]:
    """What to ask of the dump of particles and of that of their bodies. `mol` then numbers bodies, if nobody says otherwise."""
    meanings = request.wanted.meanings
    known = replace(meanings, rigid="multisphere" if meanings.rigid is None else meanings.rigid)
    particles = replace(request, wanted=replace(request.wanted, clumps="left out", meanings=known))
    return particles, replace(request, wanted=replace(request.wanted, clumps="alone"), columns=body_columns)


def parts_of_block(block: Block, request: Request) -> Iterator[Part]:
    """All frames of a block, some at a time: a packed file is one block, however long. Raises InputError."""
    notes: list[str] = []
    reading = reading_of(block.path, request, notes)
    frames: list[FrameEnergies] = []
    rows = 0
    for frame in read_block(block, reading):
        found = measured_in(block.path, frame, request.wanted, reading.seen)[1]
        frames.append(found if request.keep_particles else replace(found, by_particle={}))
        rows += 1 + found.row.n
        if rows >= _ROWS:
            yield Part(str(block.path), frames, [])
            frames, rows = [], 0
    yield Part(str(block.path), frames, notes)


def reading_of(path: Path, request: Request, notes: list[str], *, positions: bool = False) -> NeededColumns:
    """How a file is read, which adds to `notes` where it ends inside a frame. positions: wanted of all particles. Raises InputError."""
    return NeededColumns(
        request.columns or _columns_of_deck(path, request.wanted.meanings),
        names=request.wanted.meanings.names,
        half_written=lambda error: notes.append(f"{error}; the frames before it are used"),
        halfstep=request.wanted.halfstep,
        positions=positions,
    )


def measured_in(path: Path, frame: Frame, wanted: Wanted, present: Sequence[str]) -> tuple[Population, FrameEnergies]:
    """A frame of a file, measured; an InputError names the file."""
    try:
        return measured(frame, wanted, present)
    except InputError as error:
        raise InputError(error.message, error.place or Place(path)) from None


def _columns_of_deck(path: Path, meanings: Meanings) -> tuple[str, ...] | None:
    """The columns that the deck gave to a file without names; None: the file has names, or the deck does not know it.

    Raises InputError when dumps of different columns went to such a name.
    """
    if not meanings.dumps or has_names(path):
        return None
    patterns = [(fnmatch.translate(Path(dump.file).name.replace("%", "*")), dump.columns) for dump in meanings.dumps]
    found = {columns for pattern, columns in patterns if re.match(pattern, path.name)}
    if len(found) > 1:
        message = "several dumps of the deck, with different columns, could have written this file: name its columns with --columns"
        raise InputError(message, Place(path))
    return found.pop() if found else None


def erotate(
    frames: Paths | Iterable[Frame] | Universe,
    bodies: Paths | None = None,
    *,
    deck: str | Path | None = None,
    templates: Sequence[str | Path] = (),
    density: float | None = None,
    timestep: float | None = None,
    columns: Sequence[str] | None = None,
    inertia: Inertia | None = None,
    halfstep: bool = False,
) -> Series:
    """Rotational energy over time, in total and per shape, of a finished run.

    frames: names of dump files or patterns, frames, or an MDAnalysis Universe (float32: see demverify.formats.universe).
    bodies: dumps of the clumps that `frames` has the members of (LIGGGHTS `compute multisphere property`, `dump local`).
    deck: says what columns are, densities, clumps, units, step. templates: files of clumps. density: of all particles.
    columns: names of all columns of the dumps in `frames`, where the files have none or others.
    inertia: of clumps, "union" of the spheres or "spheres" as if they did not overlap. halfstep: spins half a step later.
    Raises InputError where files cannot be read, and where the columns do not tell what is needed.
    """
    meanings, notes = meanings_from(Path(deck) if deck else None, None, [Path(path) for path in templates], density, timestep)
    request = Request(Wanted(meanings, halfstep, inertia=inertia), tuple(columns) if columns else None)
    if bodies is None:
        found = _series(frames, request)
    else:
        of_particles, of_bodies = split(request)
        found = with_bodies(_series(frames, of_particles), _series(bodies, of_bodies))
    return replace(found, notes=(*notes, *found.notes))


def _series(frames: Paths | Iterable[Frame] | Universe, request: Request) -> Series:
    if isinstance(frames, str | Path):
        frames = [frames]
    if isinstance(frames, Sequence) and all(isinstance(item, str | Path) for item in frames):
        return gather(part for block in blocks_of(dump_files(frames)) for part in parts_of_block(block, request))
    many = cast("Iterable[Frame]", frames_of_universe(frames) if hasattr(frames, "trajectory") else frames)
    return gather(Part("frames", [energies_as_written(frame, request.wanted)], []) for frame in many)


def energies_as_written(frame: Frame, wanted: Wanted) -> FrameEnergies:
    """All of a frame whose columns have the names that its file gives them. Raises InputError."""
    names = Reading(names=wanted.meanings.names).called(list(frame.columns), Place(Path("frames")))
    columns = {name: values for name, values in zip(names, frame.columns.values(), strict=True) if name is not None}
    return energies_of(replace(frame, columns=columns), wanted, list(frame.columns))


def gather(parts: Iterable[Part], watch: Callable[[Part], object] = lambda part: None) -> Series:
    """The rows of parts that come in the order of the run. watch: called with each part before its energies are let go."""
    rows, notes = Rows(), list[str]()
    for part in parts:
        watch(part)
        notes += part.notes
        for found in part.frames:
            notes += found.notes
            rows.add(found.row, part.source)
    return rows.series(notes)

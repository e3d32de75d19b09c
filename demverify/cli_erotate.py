"""`demverify erotate`: the words of the command line, and where its results go."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demverify.cli_dumps import Bodies, BodyColumns, Columns, Deck, Density, Inertia, Templates, Timestep, Variables, names_in, tell

if TYPE_CHECKING:
    from demverify.analysis.energies import Row
    from demverify.analysis.erotate import Part, Request
    from demverify.analysis.series import Series
    from demverify.analysis.workers import Workers
    from demverify.formats.reading import Block
    from demverify.formats.table import Table

def erotate(
    files: Annotated[list[str], typer.Argument(metavar="FILE...", help="Dumps of LAMMPS or LIGGGHTS, of any kind; patterns in quotes work too.")],
    bodies: Bodies = None,
    template: Templates = None,
    density: Density = None,
    deck: Deck = None,
    var: Variables = None,
    columns: Columns = None,
    body_columns: BodyColumns = None,
    timestep: Timestep = None,
    inertia: Inertia = None,
    halfstep: Annotated[bool, typer.Option("--halfstep", help="Spins half a step later, as LIGGGHTS' keyword.")] = False,
    per_particle: Annotated[bool, typer.Option("--per-particle", help="Tables of every particle's energy, not of sums.")] = False,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the table as JSON: a list of objects.")] = None,
    csv: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the table as CSV.")] = None,
    h5: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the table as HDF5, a dataset a column.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.svg", help="Also draw energy over time.")] = None,
    threads: Annotated[int | None, typer.Option(min=1, max=256, help="Threads that read; default: all cores.")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler whose workers do the reading.")] = None,
) -> None:
    """Rotational energy of a finished run from its dumps: spheres, clumps and superquadrics, in total and per shape."""
    from demverify.analysis.energies import Wanted
    from demverify.analysis.erotate import Request, gather, split
    from demverify.analysis.options import meanings_from
    from demverify.analysis.series import with_bodies
    from demverify.cli import variables_of
    from demverify.formats.atomic import check_writable
    from demverify.formats.dump import dump_files

    check_writable(json, csv, h5, plot)
    meanings, notes = meanings_from(deck, variables_of(var), template or (), density, timestep)
    request = Request(Wanted(meanings, halfstep, inertia=inertia), names_in(columns), keep_particles=per_particle)
    with ExitStack() as stack:
        workers = stack.enter_context(_workers(threads, scheduler))
        tables = _tables(stack, json, csv, h5)
        watch = _each_particle(tables) if per_particle else _nothing
        if bodies:
            of_particles, of_bodies = split(request, names_in(body_columns))
            particles = gather(_run(dump_files(files), of_particles, workers), watch)
            found = with_bodies(particles, gather(_run(dump_files(bodies), of_bodies, workers), watch))
        else:
            found = gather(_run(dump_files(files), request, workers), watch)
        if not per_particle:
            for table in tables:
                table.write(_chunk(found.rows))
    if plot and found.rows:
        from demverify.report.erotate import write_picture

        write_picture(plot, found.rows)
    tell((*notes, *found.notes))
    raise typer.Exit(0 if _sound(found) else 1)


@contextmanager
def _workers(threads: int | None, scheduler: str | None) -> Iterator[Workers]:
    import os

    from demverify.analysis import workers

    count = threads or len(os.sched_getaffinity(0))
    with workers.threads(count) if scheduler is None else workers.cluster(scheduler) as found:
        yield found


def _run(files: Sequence[Path], request: Request, workers: Workers) -> Iterator[Part]:
    from demverify.analysis.workers import parts_in_parallel
    from demverify.formats.dump import blocks_of

    with _bar(sum(path.stat().st_size for path in files)) as done:
        yield from parts_in_parallel(blocks_of(files), request, workers, done)


@contextmanager
def _bar(size: int) -> Iterator[Callable[[Block], object]]:
    """A progress bar on stderr, in bytes, with rate and time left, where there is somebody to see it."""
    if not sys.stderr.isatty():
        yield _nothing
        return
    from rich.console import Console
    from rich.progress import BarColumn, DownloadColumn, Progress, TimeRemainingColumn, TransferSpeedColumn

    columns = (BarColumn(), DownloadColumn(), TransferSpeedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task("", total=size)
        yield lambda block: bars.advance(task, (block.stop or block.path.stat().st_size) - block.start)


def _nothing(_: object) -> None:
    pass


def _tables(stack: ExitStack, json: Path | None, csv: Path | None, h5: Path | None) -> list[Table]:
    from demverify.formats.table import TextTable, csv_table, h5_table, json_table

    opened = [stack.enter_context(make(path)) for make, path in ((json_table, json), (csv_table, csv), (h5_table, h5)) if path]
    return [TextTable(sys.stdout), *opened]


def _chunk(rows: Sequence[Row]) -> dict[str, list[Any]]:
    """The rows as columns; of no rows the names alone."""
    from demverify.analysis.energies import SHAPES, Row

    names = Row(0, None, 0, dict.fromkeys(SHAPES, 0.0), None).as_dict()
    dicts = [row.as_dict() for row in rows]
    return {name: [values[name] for values in dicts] for name in names}


def _each_particle(tables: Sequence[Table]) -> Callable[[Part], None]:
    """Writes the energy of every particle of a part, a chunk a frame: step time shape id erotate."""

    def write(part: Part) -> None:
        for frame in part.frames:
            for shape, energies in frame.by_particle.items():
                n = len(energies.id)
                chunk: dict[str, Any] = {"step": [frame.row.step] * n, "time": [frame.row.time] * n, "shape": [shape] * n}
                chunk |= {"id": energies.id, "erotate": energies.value}
                for table in tables:
                    table.write(chunk)

    return write


def _sound(found: Series) -> bool:
    """False when a number was not finite."""
    return all(math.isfinite(value or 0.0) for row in found.rows for value in (row.erotate, row.ke))

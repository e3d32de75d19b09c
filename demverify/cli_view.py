"""`demverify view`: the words of the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from demverify.cli_dumps import Bodies, BodyColumns, Columns, Deck, Density, Inertia, Templates, Timestep, Variables, names_in, tell


def view(
    files: Annotated[list[str], typer.Argument(metavar="FILE...", help="Dumps of LAMMPS or LIGGGHTS, trajectory.h5; patterns in quotes work too.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.html", help="The page.")] = Path("view.html"),
    bodies: Bodies = None,
    template: Templates = None,
    density: Density = None,
    deck: Deck = None,
    var: Variables = None,
    columns: Columns = None,
    body_columns: BodyColumns = None,
    timestep: Timestep = None,
    inertia: Inertia = None,
    every: Annotated[int, typer.Option(min=1, metavar="N", help="Take one of N frames.")] = 1,
    most_frames: Annotated[int | None, typer.Option(min=1, metavar="N", help="Frames at most; default: what a page of 30 MB holds.")] = None,
) -> None:
    """A page that shows a run in its real shapes, coloured by rotational energy: to turn, zoom and play, without network."""
    from demverify.analysis.energies import Wanted
    from demverify.analysis.erotate import Request
    from demverify.analysis.options import meanings_from
    from demverify.cli import variables_of
    from demverify.formats.atomic import check_writable
    from demverify.formats.dump import dump_files
    from demverify.view.frames import viewed
    from demverify.view.page import write_page

    check_writable(output)
    meanings, notes = meanings_from(deck, variables_of(var), template or (), density, timestep)
    request = Request(Wanted(meanings, inertia=inertia), names_in(columns))
    paths = dump_files(files)
    found = viewed(paths, request, dump_files(bodies) if bodies else (), names_in(body_columns), every, most_frames)
    write_page(output, found.scenes, paths[0].name if len(paths) == 1 else f"{paths[0].name} to {paths[-1].name}")
    tell((*notes, *found.notes))
    first, size = found.scenes[0], output.stat().st_size
    steps = f"frame of step {first.step}" if len(found.scenes) == 1 else f"frames from step {first.step} to {found.scenes[-1].step}"
    print(f"{output}: {len(found.scenes)} {steps}, {max(len(scene.x) for scene in found.scenes)} particles, {size / 1e6:.2g} MB")
    raise typer.Exit(0 if found.sound else 1)

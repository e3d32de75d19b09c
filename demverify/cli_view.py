"""`demverify view`: the words of the command line."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer


def view(
    files: Annotated[list[str], typer.Argument(metavar="FILE...", help="Dumps of LAMMPS or LIGGGHTS, trajectory.h5; patterns in quotes work too.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.html", help="The page.")] = Path("view.html"),
    bodies: Annotated[list[str] | None, typer.Option(metavar="FILE...", help="Dumps of the bodies of clumps (dump local).")] = None,
    template: Annotated[list[Path] | None, typer.Option(metavar="FILE", help="Template of a clump: rows x y z r; may be repeated.")] = None,
    density: Annotated[float | None, typer.Option(help="Density of all particles, where the dump has no mass.")] = None,
    deck: Annotated[Path | None, typer.Option(help="The deck of the run: says what columns are, densities, clumps, units, time step.")] = None,
    var: Annotated[list[str] | None, typer.Option(metavar="NAME VALUE", help="A variable of the deck, as -var of LAMMPS.")] = None,
    columns: Annotated[str | None, typer.Option(metavar='"ID TYPE ..."', help="Names of all columns of FILE, in order.")] = None,
    body_columns: Annotated[str | None, typer.Option(metavar='"..."', help="Names of all columns of the --bodies files.")] = None,
    timestep: Annotated[float | None, typer.Option(help="Time of one step, where neither dump nor deck says it.")] = None,
    inertia: Annotated[Literal["union", "spheres"] | None, typer.Option(help="Of clumps: union of the spheres, or spheres as if apart.")] = None,
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
    request = Request(Wanted(meanings, inertia=inertia), tuple(columns.split()) if columns else None)
    given = tuple(body_columns.split()) if body_columns else None
    paths = dump_files(files)
    found = viewed(paths, request, dump_files(bodies) if bodies else (), given, every, most_frames)
    write_page(output, found.scenes, paths[0].name if len(paths) == 1 else f"{paths[0].name} to {paths[-1].name}")
    for note in (*notes, *found.notes):
        print(f"demverify: note: {note}", file=sys.stderr)
    first, size = found.scenes[0], output.stat().st_size
    steps = f"frame of step {first.step}" if len(found.scenes) == 1 else f"frames from step {first.step} to {found.scenes[-1].step}"
    print(f"{output}: {len(found.scenes)} {steps}, {max(len(scene.x) for scene in found.scenes)} particles, {size / 1e6:.2g} MB")
    raise typer.Exit(0 if found.sound else 1)

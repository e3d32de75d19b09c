"""`demverify bench`: the words of the command line, and where its results go."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

bench = typer.Typer(help="Measure run time against error.", no_args_is_help=True)


@bench.callback()
def _room() -> None:
    """Measure run time against error."""


@bench.command()
def accuracy(
    scene: Annotated[list[str] | None, typer.Argument(metavar="[SCENE]...", help="Which scenes; all when none is named.")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for reports, pictures and numbers.")] = Path("demverify-accuracy"),
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write claims and numbers of all scenes as JSON.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few and long steps, the engines in one scene; a minute once all is compiled.")] = False,
) -> None:
    """Draw error against wall time and steps, for every law, integrator and engine, in scenes whose solution is known."""
    from demverify import bench as scenes
    from demverify.cli_reproduce import study_all

    names = tuple(dict.fromkeys(scene or scenes.listing()))
    scenes.check(names)
    study_all(names, scenes.run, "demverify bench accuracy", "scenes", out, json, quick)

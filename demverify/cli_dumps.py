"""What the commands that read dumps share, `erotate` and `view`: options, and how they tell what was taken for granted."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

import typer

Bodies = Annotated[list[str] | None, typer.Option(metavar="FILE...", help="Dumps of the bodies of clumps (dump local).")]
Templates = Annotated[list[Path] | None, typer.Option(metavar="FILE", help="Template of a clump: rows x y z r; may be repeated.")]
Density = Annotated[float | None, typer.Option(help="Density of all particles, where the dump has no mass.")]
Deck = Annotated[Path | None, typer.Option(help="The deck of the run: says what columns are, densities, clumps, units, time step.")]
Variables = Annotated[list[str] | None, typer.Option(metavar="NAME VALUE", help="A variable of the deck, as -var of LAMMPS.")]
Columns = Annotated[str | None, typer.Option(metavar='"ID TYPE ..."', help="Names of all columns of FILE, in order.")]
BodyColumns = Annotated[str | None, typer.Option(metavar='"..."', help="Names of all columns of the --bodies files.")]
Timestep = Annotated[float | None, typer.Option(help="Time of one step, where neither dump nor deck says it.")]
Inertia = Annotated[Literal["union", "spheres"] | None, typer.Option(help="Of clumps: union of the spheres, or spheres as if apart.")]


def names_in(text: str | None) -> tuple[str, ...] | None:
    """The columns that --columns or --body-columns names."""
    return tuple(text.split()) if text else None


def tell(notes: Iterable[str]) -> None:
    """A line on stderr for each."""
    for note in notes:
        print(f"demverify: note: {note}", file=sys.stderr)

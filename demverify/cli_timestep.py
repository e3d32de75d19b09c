"""`demverify timestep`: the words of the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def timestep(
    deck: Annotated[Path, typer.Argument(help="A deck of LAMMPS or LIGGGHTS.")],
    var: Annotated[list[str] | None, typer.Option("--var", metavar="NAME VALUE", help="A variable of the deck, as -var of LAMMPS.")] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the result as JSON.")] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse a step above its stability limit: exit status 2.")] = False,
) -> None:
    """Say how long the step of a deck may be: every limit, its formula, and which rules."""
    from demverify.cli import variables_of
    from demverify.formats.atomic import check_writable
    from demverify.report.json import write_data
    from demverify.report.timestep import as_dict, print_timestep
    from demverify.timestep import refuse, step_report

    check_writable(json)
    report = step_report(deck, variables_of(var))
    if json:
        write_data(json, as_dict(report))
    print_timestep(report)
    if strict:
        refuse(report)

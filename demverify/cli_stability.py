"""`demverify stability`: the words of the command line, and where its results go."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def stability(
    deck: Annotated[Path | None, typer.Argument(metavar="[DECK]", help="A deck of LAMMPS or LIGGGHTS whose first run is looked at.")] = None,
    all_: Annotated[bool, typer.Option("--all", help="Everything there is; what is done when no deck is named.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="A smaller run, under three minutes, that shows the same.")] = False,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for report, pictures and numbers.")] = Path("demverify-stability"),
    var: Annotated[list[str] | None, typer.Option("--var", metavar="NAME VALUE", help="A variable of the deck, as -var of LAMMPS.")] = None,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write claims and numbers as JSON.")] = None,
) -> None:
    """Measure where the step breaks, of a deck or of every kind of contact, against where theory says."""
    from demverify.cli import variables_of
    from demverify.cli_reproduce import bar
    from demverify.errors import InputError
    from demverify.formats.atomic import check_writable
    from demverify.report.json import write_whole
    from demverify.report.study import as_dict, as_json, write_study
    from demverify.report.study_text import print_study
    from demverify.studies import unexplained

    if deck and all_:
        message = "a deck or --all, not both"
        raise InputError(message)
    if var and not deck:
        message = "--var is for a deck, and none is named"
        raise InputError(message)
    variables = variables_of(var)
    check_writable(json)
    name = deck.name if deck else "stability"
    with bar(name) as progress:
        if deck:
            from demverify.stability.deck import of_deck, standing

            stand = standing(deck, variables)  # refuses before anything is written
            out.mkdir(parents=True, exist_ok=True)
            found = of_deck(stand, quick, progress)
        else:
            from demverify.stability.parts import run

            out.mkdir(parents=True, exist_ok=True)
            found = run(quick, progress)
    set_ = "".join(f" --var {one.replace('=', ' ', 1)}" for one in var or ())
    command = f"demverify stability{f' {deck}' if deck else ''}{set_}{' --quick' if quick else ''}"
    print_study(name, found, write_study(out, found, command))
    if json:
        write_whole(json, as_json({"quick": quick, **as_dict(found)}))
    raise typer.Exit(1 if unexplained(found) else 0)

"""`demverify reproduce`: the words of the command line, and where its results go."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

if TYPE_CHECKING:
    from demverify.studies import Progress, Study


def reproduce(
    study: Annotated[list[str] | None, typer.Argument(metavar="[STUDY]...", help="Which studies; all when none is named.")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for reports, pictures and numbers.")] = Path("demverify-reproduce"),
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write claims and numbers of all studies as JSON.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A smaller run, under a minute, that shows the same.")] = False,
) -> None:
    """Compute again what a document states, and say of each statement whether it came out."""
    from demverify import studies

    names = tuple(dict.fromkeys(study or studies.listing()))
    studies.check(names)
    study_all(names, studies.run, "demverify reproduce", "studies", out, json, quick)


def study_all(
    names: Sequence[str], run: Callable[[str, bool, Progress], Study], command: str, plural: str, out: Path, json: Path | None, quick: bool
) -> NoReturn:
    """Runs studies one by one, writes and prints each, and ends with status 1 if something did not come out and nothing says why.

    command: what runs one when its name follows; plural: what the JSON file calls them. Raises InputError for a file that cannot be written."""
    from demverify.formats.atomic import check_writable
    from demverify.report.json import write_whole
    from demverify.report.study import as_dict, as_json, write_study
    from demverify.report.study_text import print_study
    from demverify.studies import unexplained

    check_writable(json)
    for name in names:
        (out / name).mkdir(parents=True, exist_ok=True)
    found = {}
    for name in names:
        with bar(name) as progress:
            found[name] = run(name, quick, progress)
        page = write_study(out / name, found[name], f"{command} {name}{' --quick' if quick else ''}")
        print_study(name, found[name], page)
    if json:
        write_whole(json, as_json({"quick": quick, plural: {name: as_dict(one) for name, one in found.items()}}))
    raise typer.Exit(1 if any(unexplained(one) for one in found.values()) else 0)


@contextmanager
def bar(name: str) -> Iterator[Progress]:
    """What is being done and how far it is, on stderr, where there is somebody to see it."""
    if not sys.stderr.isatty():
        yield lambda what, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn(name), BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with Bars(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task("", total=1.0)
        yield lambda what, share: bars.update(task, completed=share, description=what)

"""`demverify cases`, `demverify verify`, `demverify new-case`: the verification library on the command line."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from demverify.errors import InputError
from demverify.formats.atomic import check_writable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from demverify.cases import Case
    from demverify.library import Verified
    from demverify.verify import Settings

_NAMES = "Cases, case:variant or scenarios of the library, or folders of your own. All of the library by default."
Names = Annotated[list[str] | None, typer.Argument(metavar="[CASE]...", help=_NAMES)]
Json = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the result as JSON.")]


def cases(names: Names = None, json: Json = None) -> None:
    """List the verification library: case, physics, closed form, source, engines."""
    from demverify.library import catalogue
    from demverify.report.json import write_data
    from demverify.report.library_text import print_catalogue

    check_writable(json)
    found = catalogue(names or ())
    if json:
        write_data(json, [_described(case) for case in found])
    print_catalogue(found)


def verify(
    names: Names = None,
    engines: Annotated[list[str] | None, typer.Option("--engines", help="Only these engines: native, lammps, liggghts; may be repeated.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for runs and reports.")] = Path("demverify-verify"),
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write JUnit XML, for continuous integration.")] = None,
    json: Json = None,
    record: Annotated[bool, typer.Option("--record", help="Keep each case's motion in its folder: later runs are held against it.")] = False,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Cases at a time.")] = min(2, os.cpu_count() or 1),
    timeout: Annotated[float, typer.Option(min=1.0, help="Time limit of one engine on one case, in seconds.")] = 600.0,
) -> None:
    """Run cases of the library, or your own, in every engine there is; exit status 0: all as it should be, 1: something is off."""
    from demverify.library import COLUMNS, catalogue
    from demverify.reference import record_references
    from demverify.register import load
    from demverify.report.library_text import print_verified
    from demverify.report.matrix import write_matrix
    from demverify.verify import Settings, known_engines

    check_writable(junit, json)
    settings = Settings(known_engines(engines), timeout_s=timeout, thorough=False)
    columns = [engine for engine in COLUMNS if settings.engines is None or engine in settings.engines]
    done = _in_their_order(catalogue(names or ()), out, settings, workers)
    page = out / "index.html"
    write_matrix(page, done, columns, load())
    if record:
        record_references(done, out)
    _tell_machines(done, columns, junit, json)
    print_verified(done, columns, page)
    _end(done, columns)


def _in_their_order(found: Sequence[Case], out: Path, settings: Settings, workers: int) -> list[Verified]:
    """Runs the cases behind a progress bar; workers finish them in any order."""
    from demverify.library import verified

    out.mkdir(parents=True, exist_ok=True)
    done: list[Verified] = []
    with _bar(len(found)) as told:
        for one in verified(found, out, settings, workers):
            done.append(one)
            told(len(done))
    order = {(case.folder, case.name): k for k, case in enumerate(found)}
    return sorted(done, key=lambda one: order[one.case.folder, one.case.name])


def _tell_machines(done: Sequence[Verified], columns: Sequence[str], junit: Path | None, json: Path | None) -> None:
    """What continuous integration reads: files that were asked for, and the summary of a GitHub step."""
    from demverify.report.json import write_data, write_whole
    from demverify.report.junit import junit as junit_text
    from demverify.report.junit import markdown

    if junit:
        write_whole(junit, junit_text(done, columns))
    if json:
        write_data(json, [_result(one, columns) for one in done])
    if summary := os.environ.get("GITHUB_STEP_SUMMARY"):
        with Path(summary).open("a", encoding="utf-8") as file:
            file.write(markdown(done, columns))


def _end(done: Sequence[Verified], columns: Sequence[str]) -> None:
    """Exit status 1 where a cell failed, or nothing was judged."""
    statuses = {one.cell(engine).status for one in done for engine in columns}
    if not statuses & {"pass", "deviation", "fail"}:
        print("demverify: nothing was judged, so nothing agrees", file=sys.stderr)
    if "fail" in statuses or not statuses & {"pass", "deviation"}:
        raise typer.Exit(1)


@contextmanager
def _bar(total: int) -> Iterator[Callable[[int], object]]:
    """A progress bar on stderr, where there is somebody to see it."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    with Progress("cases", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task("cases", total=total)
        yield lambda done: bars.update(task, completed=done)


def new_case(folder: Annotated[Path, typer.Argument(help="The folder to make.")]) -> None:
    """Make a case of your own from a template: two decks and a case.toml to change."""
    from importlib.resources import files

    from demverify.report.json import write_whole

    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        message = f"{folder} is there already; new-case makes a new folder"
        raise InputError(message)
    folder.mkdir(parents=True, exist_ok=True)
    for part in files("demverify").joinpath("template_case").iterdir():
        if part.name in ("in.lammps", "in.liggghts", "case.toml"):
            write_whole(folder / part.name, part.read_text(encoding="utf-8"))
    print(f"{folder}: in.lammps, in.liggghts, case.toml; now change them, and run: demverify verify {folder}")


def _described(case: Case) -> dict[str, object]:
    return {
        "name": case.name, "scenario": case.scenario, "title": case.title, "what": case.what, "source": case.source,
        "laws": [law.name for law in case.laws], "engines": _engines(case), "without": dict(case.without),
    }  # fmt: skip


def _engines(case: Case) -> list[str]:
    return ["native", *case.decks]


def _result(one: Verified, columns: Sequence[str]) -> dict[str, object]:
    cells = {}
    for engine in columns:
        cell = one.cell(engine)
        nearest = cell.nearest
        cells[engine] = {"status": cell.status, "reason": cell.reason} | (
            {"nearest": {"quantity": nearest.quantity, "engines": list(nearest.engines), "relative": nearest.max_rel, "limit": nearest.tolerance}}
            if nearest and math.isfinite(nearest.max_rel)
            else {}
        )
    return {"name": one.case.name, "scenario": one.case.scenario, "seconds": round(one.seconds, 3), "checks": dict(one.counts), "cells": cells}

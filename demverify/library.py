"""The verification library: cases by name, each run in every engine and judged; a cell is one case in one engine."""

from __future__ import annotations

import difflib
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from itertools import groupby
from multiprocessing import get_context
from pathlib import Path
from typing import Literal

import numpy as np

from demverify.cases import FILE, Case, find_cases, load_case, load_cases, split_variant
from demverify.compare import KNOWN, Check, nearest
from demverify.errors import InputError
from demverify.report.content import EngineInfo
from demverify.runs import engine_of
from demverify.verify import Comparison, Settings, compare_case

Status = Literal["pass", "deviation", "skipped", "fail"]
POINTS = 80  # of a line in a picture
COLUMNS = ("native", "lammps", "liggghts")
PORTION = 6
"""Cases that one worker takes at a time: they share a deck, and so what has been compiled for it."""


@dataclass(frozen=True)
class Cell:
    """One case in one engine. reason: why it is not a plain pass. checks: all that touch the engine, the worst step of each."""

    status: Status
    reason: str
    checks: tuple[Check, ...] = ()

    @property
    def nearest(self) -> Check | None:
        """Of what was judged, the one nearest to its limit, or farthest beyond."""
        return nearest(check for check in self.checks if check.outcome in ("pass", "fail"))


@dataclass(frozen=True)
class Verified:
    """What came of a case. checks: of each pair, quantity and tier the worst. counts: how many there were of each outcome. pictures: engine ->
    its energies, each an svg. page: the report of the case, from the folder of the library's. error: a case that could not run."""

    case: Case
    checks: tuple[Check, ...] = ()
    counts: Mapping[str, int] = field(default_factory=dict)
    engines: Mapping[str, EngineInfo] = field(default_factory=dict)
    pictures: Mapping[str, Sequence[str]] = field(default_factory=dict)
    seconds: float = 0.0
    page: str = ""
    error: str = ""

    def cell(self, engine: str) -> Cell:
        """This case in an engine: native is judged in both dialects."""
        if self.error:
            return Cell("fail", self.error)
        if engine in self.case.without or (engine != "native" and engine not in self.case.decks):
            return Cell("skipped", self.case.without.get(engine) or f"no in.{engine}")
        own = tuple(check for check in self.checks if any(engine_of(label) == engine for label in check.engines))
        if bad := [check for check in own if check.outcome in ("fail", "crashed")]:
            first = min(bad, key=lambda check: (check.outcome != "crashed", check.step))
            return Cell("fail", f"{first.quantity} of {' and '.join(first.engines)} at step {first.step}: {first.reason or 'differs'}", own)
        if not any(check.outcome == "pass" for check in own):
            info = self.engines.get(engine)
            return Cell("skipped", (info.reason if info else "") or next((check.reason for check in own), "not asked for"), own)
        known = [check.reason for check in own if check.reason.startswith(KNOWN) and "closed form" in check.engines]
        return Cell("deviation", known[0], own) if known else Cell("pass", "", own)


def library() -> Path:
    """The cases that come with this package."""
    package = Path(__file__).parent
    return next(folder for folder in (package / "library", package.parent / "inputs") if folder.is_dir())


def stress_folder() -> Path:
    """Scenes that are to break engines: of `demverify stability`, no part of the library."""
    return library() / "stress"


def catalogue(names: Sequence[str] = ()) -> list[Case]:
    """Cases in the order of their scenarios. names: case, case:variant or scenario of the library, or a folder with cases of one's own, also
    FOLDER:VARIANT; all of the library by default. Raises InputError for a name that nothing has, and for a case that is wrong."""
    found: dict[tuple[Path, str], Case] = {}
    known = [] if names and all(_own(name) for name in names) else _all(library())
    for name in names:
        own = _own(name)
        wanted = own if own is not None else [case for case in known if name in _names(case)]
        if not wanted:
            raise InputError(_unknown(name, known))
        found |= {(case.folder, case.name): case for case in wanted}
    cases = list(found.values()) if names else known
    return sorted(cases, key=lambda case: (case.scenario, case.folder.name))


def _all(root: Path) -> list[Case]:
    apart = stress_folder().resolve()
    folders = [folder for folder in find_cases(root) if apart not in folder.resolve().parents or apart in (root.resolve(), *root.resolve().parents)]
    if not folders:
        message = f"there is no {FILE} in {root} or below it"
        raise InputError(message)
    return [case for folder in folders for case in load_cases(folder)]


def _own(name: str) -> list[Case] | None:
    """Cases of a folder that exists, or None. Raises InputError for a variant that it does not have."""
    if not (found := split_variant(Path(name))):
        return None
    folder, variant = found
    return [load_case(folder, variant)] if variant else _all(folder)


def _names(case: Case) -> tuple[str, ...]:
    return case.name, case.name.partition(":")[0], case.scenario, case.scenario.replace(" ", "-")


def _unknown(name: str, known: Sequence[Case]) -> str:
    near = difflib.get_close_matches(name, sorted({one for case in known for one in _names(case)}), 3)
    return f"there is no case, scenario or folder {name!r}" + (f"; did you mean {', '.join(near)}?" if near else "; demverify cases lists them")


def verified(cases: Sequence[Case], out: Path, settings: Settings, workers: int = 1) -> Iterator[Verified]:
    """Runs cases, in the order in which they are done. out: the folder for runs and reports, one below it for each case."""
    portions = _portions(cases)
    if workers == 1:
        for portion in portions:
            for case in portion:
                yield verify_case(case, out, settings)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(_verify_all, portion, out, settings) for portion in portions]
        try:
            for done in as_completed(waiting):
                yield from done.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _portions(cases: Sequence[Case]) -> list[list[Case]]:
    """Cases of one folder together, no more than PORTION."""
    folders = [list(group) for _, group in groupby(cases, key=lambda case: case.folder)]
    return [group[k : k + PORTION] for group in folders for k in range(0, len(group), PORTION)]


def _verify_all(cases: Sequence[Case], out: Path, settings: Settings) -> list[Verified]:
    return [verify_case(case, out, settings) for case in cases]


def verify_case(case: Case, out: Path, settings: Settings) -> Verified:
    """Runs and judges one case, and writes its own report. A case that cannot run says why instead of raising."""
    from demverify.report.html import write_report

    folder, began = out / "cases" / case.name.replace(":", "-"), time.perf_counter()
    try:
        found = compare_case(case, folder, settings, lambda _: None)
    except InputError as error:
        return Verified(case, error=f"{error}", seconds=time.perf_counter() - began)
    folder.mkdir(parents=True, exist_ok=True)  # an engine that refuses leaves none
    write_report(folder / "report.html", found.report)
    outcomes = [check.outcome for check in found.checks]
    return Verified(
        case, condensed(found.checks), {name: outcomes.count(name) for name in dict.fromkeys(outcomes)}, found.report.engines, _pictures(found),
        time.perf_counter() - began, os.path.relpath(folder / "report.html", out),
    )  # fmt: skip


def condensed(checks: Sequence[Check]) -> tuple[Check, ...]:
    """Of each pair, quantity, tier and outcome the check farthest beyond, or nearest to, its limit; with the first reason."""

    def key(check: Check) -> tuple[str, tuple[str, str], int, str, str]:
        return check.kind, check.engines, check.tier, check.quantity, check.outcome

    groups: dict[object, list[Check]] = {}
    for check in checks:
        groups.setdefault(key(check), []).append(check)
    worst = (max(group, key=lambda c: c.max_rel if c.max_rel == c.max_rel else -1.0) for group in groups.values())
    return tuple(replace(check, reason=group[0].reason) for check, group in zip(worst, groups.values(), strict=True))


def _pictures(found: Comparison) -> dict[str, list[str]]:
    """The energies of each engine over time."""
    from demverify.report.pictures import energy_picture

    pictures: dict[str, list[str]] = {}
    for label, whole in found.report.series.items():
        some = np.unique(np.linspace(0, len(whole.step) - 1, POINTS).astype(int))  # the whole report has them all
        series = replace(whole, step=whole.step[some], time=whole.time[some], values={name: line[some] for name, line in whole.values.items()})
        drawn = [energy_picture(name, {label: series}) for name in ("ke", "erotate") if name in series.values and series.values[name].any()]
        pictures[engine_of(label)] = pictures.get(engine_of(label)) or drawn
    return pictures

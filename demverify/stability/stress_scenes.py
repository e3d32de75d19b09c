"""Stress scenes, inputs/stress: what becomes of each in an engine.

stayed   within the stated error of its closed form or conservation law
refused  an error said, before or when it went wrong
warned   wrong, or a step that should not be taken, but it was told
lied     wrong beyond the stated error, and nothing was said: NaN, an energy burst, a wall passed through, a contact lost
crashed  a signal, a time limit, a traceback
skipped  the engine is not here
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

from demverify import laws
from demverify.cases import FILE, Case, load_cases
from demverify.deck.setup import Dialect
from demverify.engines.base import Job
from demverify.errors import InputError, Place
from demverify.frames import Frame
from demverify.library import stress_folder
from demverify.runs import Run, execute, frame_interval, plan

Outcome = Literal["stayed", "refused", "warned", "lied", "crashed", "skipped"]
OUTCOMES: tuple[Outcome, ...] = ("stayed", "refused", "warned", "lied", "crashed", "skipped")
ENGINES = ("native", "native-liggghts", "lammps", "liggghts")
"""As columns: the native solver on each of the two decks, and the engines on their own."""
TIMEOUT_S = 900.0
QUICK_STEPS = 100_000
"""Of the resting contact, whose deck has 10,000,000."""
_WARNING = re.compile(r"^\W*WARNING(?: on proc \d+)?: (.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Found:
    """What became of a scene in an engine. message: what was said, or what is wrong. miss: the largest over its stated error, NaN where nothing was
    measured."""

    scene: str
    engine: str
    outcome: Outcome
    message: str
    miss: float = nan


def scenes() -> list[Case]:
    """All variants of all stress scenes, in the order of their folders."""
    return [case for folder in sorted(stress_folder().iterdir()) if (folder / FILE).is_file() for case in load_cases(folder)]


def quick(case: Case) -> Case:
    """The same scene; of one whose deck takes its steps from a variable that the case does not set, QUICK_STEPS of them."""
    text = next(iter(case.decks.values())).read_text(encoding="utf-8")
    if "steps" in case.variables or not re.search(r"^run\s+\$\{steps\}", text, re.MULTILINE):
        return case
    return replace(case, variables={**case.variables, "steps": [f"{QUICK_STEPS}"]})


def try_scene(case: Case, engine: str, timeout_s: float = TIMEOUT_S) -> Found:
    """Runs a scene in an engine, one of ENGINES, and says what became of it. Never raises for what the scene or the engine does."""
    dialect: Dialect = "liggghts" if engine.endswith("liggghts") else "lammps"
    said: list[str] = []
    with TemporaryDirectory() as folder:
        try:
            job = Job(case.decks[dialect], Path(folder) / "run", dict(case.variables), _every(case, dialect), timeout_s)
            if engine.startswith("native"):
                run = execute("native", engine, job, keep=True, unstable=said.append, warn=said.append)
            else:
                run = execute(engine, engine, job, keep=True)
                said += _warnings(run)
        except InputError as error:
            return Found(case.name, engine, "refused", error.message)
        except Exception as error:  # noqa: BLE001 (a traceback is an outcome here)
            return Found(case.name, engine, "crashed", f"{type(error).__name__}: {error}")
        return judged(case, engine, run, said)


def _every(case: Case, dialect: Dialect) -> int:
    if case.every:
        return case.every
    try:
        known = plan(case.decks[dialect], case.variables)
    except InputError:
        return 1000
    return frame_interval(known.steps, known.particles)


def _warnings(run: Run) -> list[str]:
    log = run.outcome.log
    return _WARNING.findall(log.read_text(errors="replace")) if log and log.is_file() else []


def judged(case: Case, engine: str, run: Run, said: Sequence[str]) -> Found:
    """The outcome of a run. said: warnings."""
    outcome = run.outcome
    if outcome.status == "skipped":
        return Found(case.name, engine, "skipped", outcome.reason)
    if outcome.status == "crashed":
        spoke = engine.startswith("native") or "ERROR" in outcome.reason
        return Found(case.name, engine, "refused" if spoke else "crashed", _first_line(outcome.reason).replace(f"{case.folder}{os.sep}", ""))
    miss, what = worst_miss(case, run.frames)
    if miss <= 1.0:
        return Found(case.name, engine, "stayed", "; ".join(dict.fromkeys(said)), miss)
    told = "; ".join(dict.fromkeys(said))
    return Found(case.name, engine, "warned" if told else "lied", f"{what}{'; ' if told else ''}{told}", miss)


def worst_miss(case: Case, frames: Sequence[Frame]) -> tuple[float, str]:
    """The largest difference from a closed form of the scene over its stated error, and which; infinite for what is no number or nobody there."""
    if not frames:
        return inf, "no frames"
    if any(frame.n != frames[0].n for frame in frames):
        return inf, f"{frames[0].n - frames[-1].n} of {frames[0].n} particles vanished"
    found = [(one, law) for law in case.laws for one in laws.measure(law.name, frames, law.parameters, Place(case.folder / FILE))]
    misses = [_miss(one) / law.tolerance for one, law in found]
    worst = max(range(len(misses)), key=misses.__getitem__)
    one, law = found[worst]
    return misses[worst], f"{one.quantity} {one.measured:.4g} for {one.expected:.4g}, stated error {law.tolerance:.2g}"


def _miss(one: laws.Measured) -> float:
    """Relative, as comparisons have it; of nothing as it is; infinite where it is no number."""
    scale = abs(one.expected) if one.scale is None else one.scale
    miss = abs(one.measured - one.expected) / (scale or 1.0)
    return miss if isfinite(miss) else inf


def _first_line(reason: str) -> str:
    return (reason.strip().splitlines() or ["no reason given"])[0]

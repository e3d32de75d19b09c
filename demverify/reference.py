"""Recorded references: the motion of a case as it once was, in its folder; later runs are held against it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from demverify.cases import Case
from demverify.chaos import Envelope
from demverify.compare import Check, compare_series
from demverify.deck.setup import Dialect
from demverify.errors import InputError
from demverify.runs import Run, native_label

if TYPE_CHECKING:
    from demverify.library import Verified

RECORDED = "recorded"


def reference_file(case: Case, dialect: Dialect) -> Path:
    """Where the recorded motion of a case in a dialect is, or would be."""
    variant = case.name.partition(":")[2]
    return case.folder / f"reference-{f'{variant}-' if variant else ''}{dialect}.h5"


def reference_checks(case: Case, runs: Mapping[str, Run], envelopes: Mapping[Dialect, Envelope]) -> list[Check]:
    """Every run that has a recorded reference of its dialect, against that."""
    from demverify.formats.h5md import read_h5md

    checks: list[Check] = []
    for dialect in case.decks:
        file = reference_file(case, dialect)
        own = [run for run in runs.values() if run.dialect == dialect and run.outcome.status == "ok"]
        if own and file.is_file():
            frames = list(read_h5md(file))
            for run in own:
                checks += compare_series(frames, run.frames, (RECORDED, run.label), envelopes.get(dialect))
    return checks


def record_references(found: Sequence[Verified], out: Path) -> list[Path]:
    """Copies the motion of each case into its folder: that of the dialect's own engine, or of native where it did not run. Raises InputError
    for a case that could not run."""
    from demverify.formats.atomic import atomic_write

    written = []
    for one in found:
        if one.error:
            raise InputError(f"{one.case.name} is not recorded: {one.error}")
        for dialect in one.case.decks:
            ran = [label for label in (dialect, native_label(dialect, one.case.decks)) if label in one.engines and one.engines[label].status == "ran"]
            if ran:
                with atomic_write(reference_file(one.case, dialect)) as part:
                    shutil.copyfile((out / one.page).parent / ran[0] / "trajectory.h5", part)
                written.append(reference_file(one.case, dialect))
    return written

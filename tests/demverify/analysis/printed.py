"""What an engine printed, against what `demverify` finds in the files of the same run."""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.testing import assert_allclose

from demverify import cli
from demverify.analysis.series import Series
from tests.support.engines import EngineRun

ROUNDING = 1e-12
"""Dumps and tables hold 16 digits or more, 1e-16 each; an energy is a sum of up to 1000 terms above zero, each of some 60 operations, in
another order than the engine's: 2e-14 is the worst seen."""


class Run(NamedTuple):
    """The folder of a run, where the deck is called in.deck, and what the engine printed: step -> column -> value."""

    folder: Path
    table: dict[int, dict[str, float]]

    @property
    def deck(self) -> Path:
        """The deck that the engine ran."""
        return self.folder / "in.deck"


def printed(run: EngineRun) -> dict[int, dict[str, float]]:
    """Step -> column without its `c_` or `v_` -> value; of steps that several tables have, the last."""
    names = [[name.removeprefix("c_").removeprefix("v_") for name in table.columns] for table in run.thermo]
    return {int(row[0]): dict(zip(of, row, strict=True)) for of, table in zip(names, run.thermo, strict=True) for row in table.values}


def assert_printed(found: Series, table: dict[int, dict[str, float]], steps: int, rtol: float = ROUNDING, **columns: str) -> None:
    """At each of the steps that both have, which are so many, the columns are what was printed: erotate="er", ke="k" ..."""
    rows = [row.as_dict() for row in found.rows if row.step in table]
    assert len(rows) == steps
    for name, theirs in columns.items():
        expected = [table[int(row["step"] or 0)][theirs] for row in rows]
        assert max(expected) > 0, f"{theirs} shows nothing"
        assert_allclose(np.array([row[name] for row in rows], dtype=float), expected, rtol=rtol, err_msg=name)


def command(folder: Path, *words: object) -> tuple[list[dict[str, float]], str]:
    """`demverify erotate` with these words, in a folder: its rows, and what it said on stderr."""
    out, said = folder / "table.json", StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()), redirect_stderr(said), pytest.raises(SystemExit) as ended:
        patch.chdir(folder)
        patch.setattr(sys, "argv", ["demverify", "erotate", *map(str, words), "--json", str(out)])
        cli.main()
    assert ended.value.code == 0, said.getvalue()
    rows: list[dict[str, float]] = json.loads(out.read_text())
    return rows, said.getvalue()

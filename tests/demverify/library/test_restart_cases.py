"""The cases that restart in mid-contact: they see what is lost, and let pass only what the register says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from demsolver import Simulation
from demverify import laws
from demverify.cases import load_case
from demverify.deck.setup import Dialect
from demverify.engines.base import Job
from demverify.errors import Place
from demverify.library import verify_case
from demverify.runs import execute
from demverify.verify import Settings
from tests.support.engines import require_lammps
from tests.support.scenes import INPUTS

REMEMBERING: list[tuple[str, str, Dialect]] = [
    ("restart-pair", "hooke", "lammps"),
    ("restart-pair", "hertz", "liggghts"),
    ("restart-wall", "30", "lammps"),
    ("restart-rolling-sds", "winding", "lammps"),
    ("restart-rolling", "epsd-winding", "liggghts"),
]


@pytest.mark.parametrize(("folder", "variant", "dialect"), REMEMBERING, ids=[f"{folder}:{variant}" for folder, variant, _ in REMEMBERING])
def test_a_restart_that_forgets_is_seen(
    folder: str, variant: str, dialect: Dialect, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Law: a case of remembering shows something only if forgetting makes it fail: springs are wound at the restart, and matter later."""
    case = load_case(INPUTS / folder, variant)
    law = next(law for law in case.laws if law.name == "motion_repeated")

    def off(name: str) -> float:
        run = execute("native", "native", Job(case.decks[dialect], tmp_path / name, dict(case.variables), case.every), keep=True)
        found = laws.measure(law.name, run.frames, law.parameters, Place(INPUTS))
        return max(abs(one.measured - one.expected) / (one.scale or abs(one.expected)) for one in found)

    assert off("kept") == 0.0
    monkeypatch.setattr(Simulation, "recall", lambda *_: None)
    assert off("forgotten") > 1e6 * law.tolerance


def test_what_an_engine_loses_is_a_deviation_by_the_register_alone(tmp_path: Path) -> None:
    """Law: the engine's defect is accepted where the case names it, in the law and beside native; without its entry the cell fails."""
    require_lammps()
    case = load_case(INPUTS / "restart-pair", "gran-hooke-history")
    settings = Settings(engines=("native", "lammps"), thorough=False)
    named = verify_case(case, tmp_path / "named", settings)
    assert [named.cell(engine).status for engine in ("native", "lammps")] == ["pass", "deviation"]
    assert "lammps-restart-legacy-history" in named.cell("lammps").reason
    silent = replace(case, laws=tuple(replace(law, deviates={}) for law in case.laws))
    assert verify_case(silent, tmp_path / "silent", settings).cell("lammps").status == "fail"

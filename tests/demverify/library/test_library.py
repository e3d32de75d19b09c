"""The library: which cases a name means, what a cell says, and what deviates must deviate."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demverify import library, register
from demverify.cases import Case, Law
from demverify.compare import KNOWN, Check
from demverify.errors import InputError
from demverify.library import Verified, catalogue, condensed, verified, verify_case
from demverify.verify import Settings, compare_case
from tests.support.engines import require_lammps, require_liggghts

TEMPLATE = Path(library.__file__).parent / "template_case"


def check(engines: tuple[str, str], outcome: str, reason: str = "", kind: str = "engine", rel: float = 1e-12, step: int = 0) -> Check:
    return Check("force", engines, step, rel, rel, 1e-9, outcome, reason, 1, kind)  # type: ignore[arg-type]


def case_of(*dialects: str, **rest: object) -> Case:
    return Case("t", {dialect: Path("c") / f"in.{dialect}" for dialect in dialects}, name="c", **rest)  # type: ignore[arg-type]


def mine(folder: Path, old: str = "", new: str = "", deck: str = "in.lammps") -> Path:
    shutil.copytree(TEMPLATE, folder, ignore=lambda _, names: [name for name in names if name.startswith("__")])
    text = (folder / deck).read_text()
    assert old in text
    (folder / deck).write_text(text.replace(old, new) if old else text)
    return folder


def test_names_of_the_library() -> None:
    """Law: a case, a variant and a scenario each name what they should; all cases come in the order of their scenarios; wrong names are told."""
    every = catalogue()
    assert [case.scenario for case in every] == sorted(case.scenario for case in every)
    assert len({case.name for case in every}) == len(every)
    for case in every[:: max(1, len(every) // 7)]:
        assert case.name in [one.name for one in catalogue([case.name])]
        assert {one.folder for one in catalogue([case.folder.name])} == {case.folder}
        assert {one.scenario for one in catalogue([case.scenario.replace(" ", "-")])} == {case.scenario}
    with pytest.raises(InputError, match="did you mean head-on-hooke"):
        catalogue(["head-on-hook"])


def test_cells() -> None:
    """Law: a cell fails with anything that failed of its engine, is skipped where nothing was judged, a deviation where a closed form is known to be
    missed, and else passes; native answers for both dialects."""
    good, law = check(("native", "lammps"), "pass"), check(("lammps", "closed form"), "skipped", f"{KNOWN}entry: why", "law")
    found = Verified(case_of("lammps", without={"liggghts": "it has no JKR"}), (good, law))
    assert [found.cell(engine).status for engine in library.COLUMNS] == ["pass", "deviation", "skipped"]
    assert found.cell("liggghts").reason == "it has no JKR"
    bad = Verified(case_of("lammps", "liggghts"), (good, check(("native-liggghts", "closed form"), "fail", "off", "law")))
    assert [bad.cell(engine).status for engine in library.COLUMNS] == ["fail", "pass", "skipped"]
    assert Verified(case_of("lammps"), error="wrong deck").cell("native").status == "fail"
    assert Verified(case_of("lammps")).cell("native").status == "skipped"
    crashed = Verified(case_of("lammps"), (good, check(("native", "lammps"), "crashed", "died")))
    assert crashed.cell("lammps").status == "fail"


def test_the_worst_of_each_is_kept() -> None:
    """Law: of checks that differ in the step only the worst is kept, NaN below all numbers, with the reason of the first."""
    pair = ("native", "lammps")
    checks = [check(pair, "pass", "first", rel=r, step=k) for k, r in enumerate((1e-13, 3e-11, np.nan, 2e-12))]
    [kept] = condensed(checks)
    assert (kept.step, kept.max_rel, kept.reason) == (1, 3e-11, "first")
    assert len(condensed([*checks, check(pair, "fail")])) == 2


@pytest.mark.lammps
@pytest.mark.liggghts
def test_a_new_case_passes_and_a_wrong_one_does_not(tmp_path: Path) -> None:
    """Law: the template passes in all engines; with another stiffness in one deck it fails in both engines, and with a dashpot that is off in one
    deck against the closed form too."""
    require_lammps()
    require_liggghts()
    [good, *_] = verified(catalogue([f"{mine(tmp_path / 'good')}"]), tmp_path / "out", Settings())
    assert [good.cell(engine).status for engine in library.COLUMNS] == ["pass"] * 3
    assert (tmp_path / "out" / good.page).is_file()
    wrong = mine(tmp_path / "wrong", "k index 1.0e4", "k index 1.001e4")
    [bad] = verified(catalogue([f"{wrong}:e0.8"]), tmp_path / "out", Settings())
    assert [bad.cell(engine).status for engine in library.COLUMNS] == ["pass", "fail", "fail"]
    off = mine(tmp_path / "off", "gamma equal sqrt(8.0", "gamma equal sqrt(7.0")
    [bad] = verified(catalogue([f"{off}:e0.8"]), tmp_path / "out", Settings())
    assert [bad.cell(engine).status for engine in library.COLUMNS] == ["fail"] * 3
    assert "closed form" in bad.cell("native").reason


@pytest.mark.lammps
@pytest.mark.parametrize("holds", [False, True])
def test_deviations_are_strict(tmp_path: Path, holds: bool) -> None:
    """Law: an engine that misses a law for what the register says is a deviation; where the law holds all the same, the cell fails: the register
    is to be mended."""
    require_lammps()
    [case, *_] = catalogue([f"{mine(tmp_path / 'case')}:e0.8"])
    entry = next(entry for entry in register.load() if entry.engine == "lammps" and entry.kind == "convention")
    law = Law("collision_restitution", 2e-3, "r", {"restitution": 0.8 if holds else 0.7}, {"lammps": entry.id})
    only = Case(case.title, {"lammps": case.decks["lammps"]}, name="c", laws=(law,), variables=case.variables)
    found = verify_case(only, tmp_path / "out", Settings())
    assert [found.cell(engine).status for engine in ("native", "lammps")] == (["fail"] * 2 if holds else ["deviation"] * 2)
    told = found.cell("lammps").reason
    assert ("mend the case, or the register" in told) if holds else told.startswith(KNOWN + entry.id)


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize("engines", [None, ("native", "lammps"), ("lammps", "liggghts")])
def test_accepted_differences_are_strict(tmp_path: Path, engines: tuple[str, ...] | None) -> None:
    """Law (what must be rejected): where LAMMPS and LIGGGHTS agree, an accepted difference fails in both, in one line that names the entry, the
    case.toml and what to do; a pair that did not run is no evidence."""
    require_lammps()
    require_liggghts()
    [case, *_] = catalogue([f"{mine(tmp_path / 'case')}:e0.8"])
    idle = replace(case, accept=("liggghts-contact-arm", "lammps-2d-mass"))
    found = verify_case(idle, tmp_path / "out", Settings(engines))
    strict = engines is None or set(engines) >= {"lammps", "liggghts"}
    assert [found.cell(engine).status for engine in ("lammps", "liggghts")] == (["fail"] * 2 if strict else ["pass", "skipped"])
    assert found.cell("native").status == ("pass" if engines is None or "native" in engines else "skipped")
    if strict:
        told = found.cell("liggghts").reason
        assert "is explained by liggghts-contact-arm, lammps-2d-mass: take it out of accept in" in told
        assert f"{case.folder / 'case.toml'}, or move it to the variants that need it" in told
        assert "\n" not in told


@pytest.mark.lammps
@pytest.mark.liggghts
def test_an_accepted_difference_that_is_there_is_no_news(tmp_path: Path) -> None:
    """Law: an accepted entry that explains a difference passes; one beside it that cannot apply to the deck is told alone; while the difference
    fails for another reason nothing is told of either."""
    require_lammps()
    require_liggghts()
    [case] = catalogue(["wall-oblique"])
    assert case.accept == ("liggghts-contact-arm",)
    good = compare_case(case, tmp_path / "good", Settings(thorough=False), lambda _: None)
    assert {check.outcome for check in good.checks} == {"pass", "skipped"}
    beside = replace(case, accept=("liggghts-contact-arm", "lammps-2d-mass"))
    told = [c for c in compare_case(beside, tmp_path / "beside", Settings(thorough=False), lambda _: None).checks if c.outcome == "fail"]
    assert [c.quantity for c in told] == ["accepted difference"]
    assert "explained by lammps-2d-mass: take it out" in told[0].reason
    other = replace(case, accept=("lammps-2d-mass",))
    wrong = [c for c in compare_case(other, tmp_path / "other", Settings(thorough=False), lambda _: None).checks if c.outcome == "fail"]
    assert wrong
    assert "accepted difference" not in {c.quantity for c in wrong}


def test_a_recorded_motion_is_held_against(tmp_path: Path) -> None:
    """Law: what was recorded passes again and leaves no file half written; a change of 1e-3 in the stiffness, in every deck, does not pass."""
    from demverify.reference import record_references

    folder = mine(tmp_path / "case")
    native = Settings(engines=("native",))
    cases = catalogue([f"{folder}:e0.8"])
    record_references(list(verified(cases, tmp_path / "out", native)), tmp_path / "out")
    assert sorted(path.name for path in folder.glob("*ref*")) == ["reference-e0.8-lammps.h5", "reference-e0.8-liggghts.h5"]
    [again] = verified(cases, tmp_path / "out", native)
    assert again.cell("native").status == "pass"
    assert any("recorded" in check.engines for check in again.checks)
    for deck in ("in.lammps", "in.liggghts"):
        (folder / deck).write_text((folder / deck).read_text().replace("k index 1.0e4", "k index 1.001e4"))
    [changed] = verified(cases, tmp_path / "out", native)
    assert changed.cell("native").status == "fail"
    assert "recorded" in changed.cell("native").reason

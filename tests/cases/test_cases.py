"""Cases of inputs/ in every engine, judged, and held against their closed forms; the whole library runs as `demverify verify` (.ci/run)."""

from __future__ import annotations

from pathlib import Path

import pytest

from demverify import register
from demverify.cases import Case, load_case
from demverify.compare import TIER1, TIER2, verdict
from demverify.library import catalogue
from demverify.verify import DIALECTS, SAME_RULES, Settings, compare_case
from tests.support.engines import require_lammps, require_liggghts

INPUTS = Path(__file__).parents[2] / "inputs"
CASES = ("bed", "chute", "head-on-hertz", "slip-to-roll", "wall-normal", "wall-oblique")
LIBRARY = catalogue()


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize("name", CASES)
def test_the_engines_agree(name: str, tmp_path: Path) -> None:
    """Law: native equals LAMMPS on the LAMMPS deck and LIGGGHTS on its own, to tier 1 and 2; all meet the closed forms of the case."""
    require_lammps()
    require_liggghts()
    found = compare_case(load_case(INPUTS / name), tmp_path, Settings(), lambda label: None)
    failed = [check for check in found.checks if check.outcome in ("fail", "crashed")]
    assert not failed, failed[:3]
    assert verdict(found.checks) == "pass"
    twins = {("native", "lammps"), ("native-liggghts", "liggghts")}
    own = [c for c in found.checks if c.engines in twins and c.tier < 3]
    assert {c.engines for c in own} == twins
    assert all(c.outcome == "pass" and c.max_rel <= (TIER1 if c.tier == 1 else TIER2) for c in own)


@pytest.mark.parametrize("case", LIBRARY, ids=[case.name for case in LIBRARY])
def test_a_case_is_whole(case: Case) -> None:
    """Law: a case has both decks or says which engine it is without (its deck is then for native alone), says what it measures, of which scenario
    and from which source, and names only differences and deviations that the register has."""
    assert set(case.decks) | set(case.without) == {"lammps", "liggghts"}
    assert case.decks
    assert case.title
    assert len(case.what) > 40
    assert case.scenario
    assert case.source or not case.laws
    known = {entry.id for entry in register.load()}
    assert set(case.accept) | {entry for law in case.laws for entry in law.deviates.values()} <= known
    assert all(len(law.reason) > 10 and law.tolerance > 0 for law in case.laws)


def test_the_library_is_broad() -> None:
    """Law: at least 120 cases in 20 scenarios, each with a closed form or against the engines, and no two of one name."""
    assert len(LIBRARY) >= 120
    assert len({case.scenario for case in LIBRARY}) >= 20
    assert len({case.name for case in LIBRARY}) == len(LIBRARY)
    assert sum(bool(case.laws) for case in LIBRARY) >= 110


@pytest.mark.lammps
@pytest.mark.liggghts
def test_the_rules_alone_are_named_but_not_excused(tmp_path: Path) -> None:
    """Law: a difference that only the engines' rules make fails unless accepted; its reason names the entries, and says that under the
    same rules the decks do the same."""
    require_lammps()
    require_liggghts()
    for name in ("in.lammps", "in.liggghts"):
        (tmp_path / name).write_text((INPUTS / "wall-oblique" / name).read_text())
    found = compare_case(load_case(tmp_path), tmp_path / "out", Settings(), lambda label: None)
    wrong = [c for c in found.checks if c.outcome == "fail"]
    assert {c.engines for c in wrong} == {DIALECTS}
    assert all("explained by liggghts-contact-arm" in c.reason and c.reason.endswith("the decks do the same") for c in wrong)


@pytest.mark.lammps
@pytest.mark.liggghts
def test_two_laws_do_not_agree(tmp_path: Path) -> None:
    """Law (what must be rejected): the same scene with another friction coefficient in one deck fails, also where the case lives with
    differences of the engines' rules: under the same rules the decks still differ."""
    require_lammps()
    require_liggghts()
    for name in ("in.lammps", "in.liggghts"):
        text = (INPUTS / "wall-oblique" / name).read_text()
        (tmp_path / name).write_text(text.replace("peratomtypepair 1 0.1", "peratomtypepair 1 0.1001") if "liggghts" in name else text)
    settings = Settings(accept=("liggghts-contact-arm",))
    found = compare_case(load_case(tmp_path), tmp_path / "out", settings, lambda label: None)
    assert verdict(found.checks) == "fail"
    wrong = [c for c in found.checks if c.outcome == "fail"]
    assert {c.engines for c in wrong} == {DIALECTS, (SAME_RULES, "native-liggghts")}
    assert any(c.quantity == "force" for c in wrong)
    assert any("do not describe the same scene" in c.reason for c in wrong)

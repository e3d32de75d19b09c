"""pytest --demverify in a project of one's own."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from demverify import library
from tests.support.engines import require_lammps, require_liggghts

pytest_plugins = ["pytester"]
TEMPLATE = Path(library.__file__).parent / "template_case"
OPTIONS = ("--demverify", "-p", "no:cacheprovider", "--import-mode=importlib")


@pytest.fixture
def project(pytester: pytest.Pytester) -> Path:
    require_lammps()
    require_liggghts()
    for name in ("in.lammps", "in.liggghts", "case.toml"):
        (pytester.path / "cases").mkdir(exist_ok=True)
        shutil.copy(TEMPLATE / name, pytester.path / "cases" / name)
    pytester.makepyfile(test_mine="def test_mine():\n    pass\n")
    return pytester.path


@pytest.mark.lammps
@pytest.mark.liggghts
def test_green_and_red(pytester: pytest.Pytester, project: Path) -> None:
    """Law: each case and engine is a test; after a planted change in one deck those that are off fail, in words, without a traceback."""
    done = pytester.runpytest_subprocess(*OPTIONS, "--junitxml=out.xml")
    done.assert_outcomes(passed=7)
    assert 'name="nearest"' in (project / "out.xml").read_text()
    deck = project / "cases" / "in.lammps"
    deck.write_text(deck.read_text().replace("sqrt(8.0*", "sqrt(7.0*"))
    done = pytester.runpytest_subprocess(*OPTIONS, "-v")
    done.assert_outcomes(passed=1, failed=6)
    told = ["*collision_restitution: *closed form 0.8*", "report: *report.html", "FAILED cases/case.toml::cases:e0.8[[]native[]]*"]
    done.stdout.fnmatch_lines(told)
    assert "Traceback" not in done.stdout.str()


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.usefixtures("project")
def test_with_xdist_each_case_runs_once(pytester: pytest.Pytester) -> None:
    """Law: with -n 2 the outcome is the same, and the tests of a folder stay on one worker, so that each case runs once."""
    done = pytester.runpytest_subprocess(*OPTIONS, "-n", "2", "-v", "--demverify-out=out")
    done.assert_outcomes(passed=7)
    lines = [line for line in done.stdout.lines if "PASSED" in line and "case.toml" in line]
    assert len(lines) == 6
    assert len({line.split("]")[0] for line in lines}) == 1


@pytest.mark.usefixtures("project")
def test_nothing_without_the_option(pytester: pytest.Pytester) -> None:
    """Law: without --demverify the plugin collects nothing."""
    pytester.runpytest_subprocess("-p", "no:cacheprovider").assert_outcomes(passed=1)


def test_a_wrong_case_is_told_at_collection(pytester: pytest.Pytester, project: Path) -> None:
    """Law: a case.toml that is wrong is an error of collection, in one line that says what."""
    file = project / "cases" / "case.toml"
    file.write_text(file.read_text().replace("restitution =", "restitutoin ="))
    done = pytester.runpytest_subprocess(*OPTIONS)
    done.assert_outcomes(errors=1)
    done.stdout.fnmatch_lines(["*law collision_restitution takes restitution; got restitutoin*"])


def test_a_deck_alone(pytester: pytest.Pytester, project: Path) -> None:
    """Law: a deck without case.toml is a case too: the engine of its dialect against native, the other skipped with the reason."""
    (project / "cases" / "case.toml").unlink()
    (project / "cases" / "in.liggghts").rename(project / "in.mine")
    shutil.rmtree(project / "cases")
    done = pytester.runpytest_subprocess(*OPTIONS, "-rs")
    done.assert_outcomes(passed=3, skipped=1)
    done.stdout.fnmatch_lines(["SKIPPED*no in.lammps*"])

"""pytest --demverify FOLDER: every case and every engine a test of its own, in any project that has this package installed.

Collected are folders with a case.toml, or without one with in.lammps or in.liggghts, and other decks called in.SOMETHING. A test is one case
in one engine: passed, failed with what is off, or skipped with the reason; an expected deviation passes. Each case runs once, whatever the
number of its tests, also with pytest-xdist, where the tests of a folder stay on one worker. Reports are kept in .pytest_cache/d/demverify.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from demverify.cases import Case
    from demverify.library import Verified

CASE_FILES = ("case.toml", "in.lammps", "in.liggghts")


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options of the plugin."""
    group = parser.getgroup("demverify", "decks of LAMMPS and LIGGGHTS, held against closed forms and each other")
    group.addoption("--demverify", action="store_true", help="collect cases (case.toml) and decks (in.*) as tests")
    group.addoption("--demverify-out", metavar="DIR", default=None, help="folder for runs and reports")


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """With pytest-xdist the tests of a folder stay together."""
    if config.getoption("--demverify") and getattr(config.option, "dist", "no") == "load":
        config.option.dist = "loadfile"


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> CaseFile | None:
    """A case.toml, a deck of a folder without one, or any deck called in.SOMETHING."""
    if not parent.config.getoption("--demverify"):
        return None
    if file_path.name == "case.toml":
        return CaseFile.from_parent(parent, path=file_path)
    if not file_path.name.startswith("in.") or (file_path.parent / "case.toml").is_file():
        return None
    if file_path.name == "in.liggghts" and (file_path.parent / "in.lammps").is_file():
        return None  # with in.lammps
    return CaseFile.from_parent(parent, path=file_path)


class CaseFile(pytest.File):
    """A case folder, or a deck."""

    def collect(self) -> Iterator[CaseItem]:
        """A test for each case and engine."""
        from demverify.library import COLUMNS

        for case in self._cases():
            for engine in COLUMNS:
                yield CaseItem.from_parent(self, name=f"{case.name}[{engine}]", case=case, engine=engine)

    def _cases(self) -> tuple[Case, ...]:
        from demverify.cases import Case, load_cases
        from demverify.deck.dialects import detect_dialect
        from demverify.errors import InputError

        try:
            if self.path.name in CASE_FILES:
                return load_cases(self.path.parent)
            return (Case(self.path.name, {detect_dialect(self.path): self.path}, name=self.path.name),)
        except InputError as error:
            raise self.CollectError(f"{error}") from None


class CaseItem(pytest.Item):
    """One case in one engine."""

    def __init__(self, *, case: Case, engine: str, **rest: Any) -> None:
        super().__init__(**rest)
        self.case, self.engine = case, engine

    def runtest(self) -> None:
        """Judges the cell; the case runs if no other of its tests has run it."""
        found = _verified(self.config, self.case)
        cell = found.cell(self.engine)
        if cell.nearest is not None:
            nearest = cell.nearest
            self.user_properties.append(("nearest", f"{nearest.quantity} {nearest.max_rel:.3g} of {nearest.tolerance:.3g}"))
        if cell.status == "deviation":
            self.user_properties.append(("deviation", cell.reason))
        if cell.status == "skipped":
            pytest.skip(" ".join(cell.reason.split()))
        if cell.status == "fail":
            page = f"\nreport: {_out(self.config) / found.page}" if found.page else ""
            raise CaseFailed(f"{self.case.name} in {self.engine}: {cell.reason}{page}")

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What is off, without a traceback."""
        return str(excinfo.value) if isinstance(excinfo.value, CaseFailed) else super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Where it is and what it is called."""
        return self.path, 0, self.name


class CaseFailed(Exception):
    """A case that is off in an engine: what, by how much, and where the report is."""


_DONE = pytest.StashKey[dict[tuple[Path, str], "Verified"]]()
_OUT = pytest.StashKey[Path]()


def _out(config: pytest.Config) -> Path:
    """The folder for runs and reports."""
    if _OUT not in config.stash:
        given, cache = config.getoption("--demverify-out"), getattr(config, "cache", None)
        folder = Path(given).absolute() if given else Path(cache.mkdir("demverify") if cache else tempfile.mkdtemp())
        config.stash[_OUT] = folder / os.environ.get("PYTEST_XDIST_WORKER", "")  # two workers never write to one place
    return config.stash[_OUT]


def _verified(config: pytest.Config, case: Case) -> Verified:
    from demverify.library import verify_case
    from demverify.verify import Settings

    done = config.stash.setdefault(_DONE, {})
    key = case.folder, case.name
    if key not in done:
        done[key] = verify_case(case, _out(config), Settings(timeout_s=600.0, thorough=False))
    return done[key]

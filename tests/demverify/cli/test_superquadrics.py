"""Superquadrics under every command that reads decks: what knows spheres alone says so in one line, and nothing is written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.cli import Call, files_in
from tests.support.engines import require_liggghts
from tests.support.superquadric_decks import deck

Write = Callable[..., Path]
LIMITS = "the limits of a step are known for spheres on their own, not for superquadrics"


@pytest.mark.parametrize(("words", "said"), [
    (("timestep", "IN"), LIMITS),
    (("stability", "IN", "--quick", "--out", "OUT"), LIMITS),
    (("run", "IN", "--strict", "--out", "OUT"), LIMITS),
    (("run", "IN", "--sleep", "1e-3", "--out", "OUT"), "superquadrics and clumps do not sleep"),
    (("convert", "IN", "--to", "lammps", "-o", "OUT"), "cannot be converted: LAMMPS has no superquadrics like those of LIGGGHTS"),
])  # fmt: skip
def test_what_knows_spheres_alone_refuses(demverify: Call, write: Write, tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    """Law: status 2, one line, no file."""
    path, out = write(deck(), "in.liggghts"), tmp_path / "out"
    called = demverify(*({"IN": path, "OUT": out}.get(word, word) for word in words))
    assert called.status == 2
    assert said in called.err
    assert called.err.count("\n") == 1
    assert files_in(tmp_path) == {"in.liggghts"}


def test_a_run_and_its_energies(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: run warns of nothing it does not know; erotate of its trajectory, and of its dump with the deck, are the same numbers, all of
    superquadrics."""
    columns = "mass shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2 omegax omegay omegaz angmomx angmomy angmomz vx vy vz"
    dump = f"dump d all custom 20 d.dump id type {columns}\ndump_modify d format '%d %d{19 * ' %.17g'}'\n"
    path = write(deck(end=f"{dump}run 40\n"), "in.liggghts")
    ran = demverify("run", path, "--out", tmp_path / "out")
    assert (ran.status, ran.err) == (0, "")
    tables = [demverify("erotate", *words) for words in ((tmp_path / "out/trajectory.h5",), (tmp_path / "out/d.dump", "--deck", path))]
    rows = [[[float(word) for word in line.split()] for line in table.out.splitlines()[1:]] for table in tables]
    assert len(rows[0]) == len(rows[1]) == 3
    for mine, theirs in zip(*rows, strict=True):
        assert mine == pytest.approx(theirs, rel=1e-12)
        assert mine[3] == mine[6] > 0.0  # erotate, superquadric


@pytest.mark.liggghts
def test_a_liggghts_without_superquadrics_is_skipped(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: Debian's LIGGGHTS has no superquadrics: run and compare say so, and how to get one, and do not call it a crash."""
    require_liggghts()
    path = write(deck(), "in.liggghts")
    ran = demverify("run", path, "--engine", "liggghts", "--out", tmp_path / "run")
    assert ran.status == 2
    assert "liggghts skipped: this LIGGGHTS is built without superquadrics; install it with: make" in ran.err
    compared = demverify("compare", path, "--out", tmp_path / "compare")
    assert compared.status == 1
    assert "Nothing was judged" in compared.out
    assert "built without superquadrics" in compared.out
    assert (tmp_path / "compare/in.liggghts/report.html").is_file()


def test_a_contact_that_is_too_deep_is_named(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: the guard names who overlap, by how much of the smaller radius of the same volume, and not what their bounding spheres do."""
    path = write(deck(("single 0.01 0.005 0.06", "single 0.01 0.005 0.048")), "in.liggghts")
    ran = demverify("run", path, "--out", tmp_path / "out")
    assert ran.status == 3
    assert "particles 1 and 2 overlap by" in ran.err
    part = float(ran.err.split("overlap by ")[1].split()[0])
    assert 0.5 < part < 0.8
    assert ran.err.count("\n") == 1

"""Modes of the native engine that are not exact, from the command line: --precision mixed and --sleep."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.support.cli import Call, deck

Write = Callable[..., Path]
FLOOR = (
    "fix move all nve/sphere\nfix down all gravity 9.81 vector 0 0 -1\n"
    "fix floor all wall/gran granular hooke 1.0e4 2000.0 tangential linear_nohistory 0.0 0.0 damping mass_velocity zplane -0.05 NULL"
)


def energies(demverify: Call, path: Path, out: Path, *words: object) -> np.ndarray:
    """Kinetic energy of the last run, with all its digits."""
    assert demverify("run", path, "--out", out, *words).status == 0
    table = np.genfromtxt(out / "thermo.csv", delimiter=",", names=True)
    return table[table.dtype.names[2]]


def test_mixed_precision_is_near_but_not_the_same(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: with a contact's geometry as float32 the energy of a collision is off by some roundings of it, of 6e-8 each, and not by nothing."""
    path = write(deck(run="run 1000"))
    exact, mixed = (energies(demverify, path, tmp_path / mode, "--precision", mode) for mode in ("double", "mixed"))
    error = np.abs(mixed - exact).max() / exact.max()
    assert 0.0 < error < 1e-4


def test_what_rests_sleeps_when_asked_to(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: spheres that have come to rest on a floor have no energy at all with --sleep, and the last of a decay without."""
    places = {name: f"create_atoms 1 single {x} 0.0 -0.0450001" for name, x in (("first", -0.02), ("second", 0.02))}
    path = write(deck(**places, speed="", nve=FLOOR, timestep="timestep 1.0e-5", skin="neighbor 0.002 bin", thermo="thermo 500", run="run 1000"))
    awake, asleep = (energies(demverify, path, tmp_path / name, *words) for name, words in (("awake", ()), ("asleep", ("--sleep", 1e-3))))
    assert awake[-1] > 0.0
    assert asleep[-1] == 0.0


def test_what_cannot_sleep_is_refused(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: a thermo column that needs every contact and --sleep exclude each other: one line that says so, and nothing written."""
    called = demverify("run", write(deck(columns="thermo_style custom step press")), "--out", tmp_path / "out", "--sleep", 1e-3)
    assert called.status == 2
    assert "in.lammps:21: --sleep 0.001: the energy budget and the virial need every contact in every step" in called.err
    assert not (tmp_path / "out").exists()

"""Rows in order: restarts, files that overlap, bodies from files of their own."""

from __future__ import annotations

import pytest

from demverify.analysis.energies import Row
from demverify.analysis.series import Rows, with_bodies
from demverify.errors import InputError


def row(step: int, sphere: float = 1.0, clump: float = 0.0, particles: int = 7) -> Row:
    """A row with these energies; ke is ten times the spheres'."""
    return Row(step, None, 10, {"sphere": sphere, "multisphere": clump, "superquadric": 0.0}, 10 * sphere, particles)


def gathered(*steps: tuple[int, float]) -> list[tuple[int, float]]:
    """What is left of rows (step, energy) of one file."""
    rows = Rows()
    for step, energy in steps:
        rows.add(row(step, energy), "a.dump")
    return [(r.step, r.erotate) for r in rows.series().rows]


def test_the_same_step_twice_counts_once() -> None:
    """Law: the end of one `run` and the start of the next are one frame; the later one holds."""
    assert gathered((0, 1.0), (10, 2.0), (10, 3.0), (20, 4.0)) == [(0, 1.0), (10, 3.0), (20, 4.0)]


def test_a_restart_replaces_what_it_does_again() -> None:
    """Law: after a restart from step 10 the frames of the first run beyond it are gone, and the reader is told."""
    rows = Rows()
    for step, energy in ((0, 1.0), (10, 2.0), (20, 3.0), (30, 4.0), (10, 5.0), (20, 6.0)):
        rows.add(row(step, energy), "a.dump")
    series = rows.series(["half written", "half written"])
    assert [(r.step, r.erotate) for r in series.rows] == [(0, 1.0), (10, 5.0), (20, 6.0)]
    assert series.notes == ("half written", "the run went back to step 10: its earlier frames from there on are replaced")


def test_parts_of_one_frame_in_two_files_are_refused() -> None:
    """Law: two files with the same step of different particles are not a restart; taking one for the other would be silently wrong."""
    rows = Rows()
    rows.add(row(0, particles=1), "spheres.dump")
    with pytest.raises(InputError, match=r"spheres.dump \(10 particles\) and clumps.dump \(10\) both hold step 0, of different particles"):
        rows.add(row(0, particles=2), "clumps.dump")


def test_columns_come_by_name() -> None:
    """Law: a series gives its columns as arrays; what is unknown is NaN; another name is a KeyError."""
    rows = Rows()
    rows.add(row(3, 2.0, 0.5), "a")
    series = rows.series()
    assert series["erotate"].tolist() == [2.5]
    assert series["step"].tolist() == [3.0]
    assert series["time"] != series["time"]
    with pytest.raises(KeyError):
        series["spin"]


def test_bodies_are_added_step_by_step() -> None:
    """Law: energies of free particles and of bodies add up where both are known, and steps with only one of them are told."""
    particles, bodies = Rows(), Rows()
    for step in (0, 10, 20):
        particles.add(row(step, 1.0), "a")
    for step in (10, 20, 30, 40):
        bodies.add(row(step, 0.0, 0.25), "b")
    both = with_bodies(particles.series(), bodies.series())
    assert [(r.step, r.erotate, r.by_shape["multisphere"], r.n) for r in both.rows] == [(10, 1.25, 0.25, 10), (20, 1.25, 0.25, 10)]
    assert both.notes == (
        "1 steps with particles but no bodies are left out: 0",
        "2 steps with bodies but no particles are left out: 30 40",
    )
    lonely = Rows()
    lonely.add(row(5), "b")
    with pytest.raises(InputError, match="none of the steps"):
        with_bodies(particles.series(), lonely.series())

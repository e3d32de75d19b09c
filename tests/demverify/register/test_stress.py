"""Register entries on what the engines do where a contact has no direction, no step, or nobody left: the decks are those of inputs/stress."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.decks import COLUMNS
from tests.support.deviations import assert_deviates, assert_nan
from tests.support.engines import EngineRun, run_lammps, run_liggghts

STRESS = Path(__file__).parents[3] / "inputs" / "stress"
RUN: dict[str, Callable[[str, Path], EngineRun]] = {"lammps": run_lammps, "liggghts": run_liggghts}


def end_of(engine: str, scene: str, folder: Path, **values: str) -> EngineRun:
    """A deck of inputs/stress with other values of its variables, and a dump of the last step."""
    deck = (STRESS / scene / f"in.{engine}").read_text()
    for name, value in values.items():
        line = next(line for line in deck.splitlines() if line.split()[:2] == ["variable", name])
        deck = deck.replace(line, f"variable {name} index {value}")
    before, run, steps = deck.rpartition("run ")
    return RUN[engine](f"{before}dump e all custom 1 zz.dump {COLUMNS}\ndump_modify e sort id\n{run}{steps}", folder)


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize("engine", ["lammps", "liggghts"])
def test_two_particles_at_one_point_become_nan(engine: str, tmp_path: Path) -> None:
    """Law: nothing has no direction; who cannot part must be refused. Both engines divide by the distance and go on to the end."""
    found = end_of(engine, "deep-pair", tmp_path, overlap="2.0")
    assert "ERROR" not in found.log
    assert_nan("both-one-point", found.frames[-1].columns["vx"])


@pytest.mark.lammps
@pytest.mark.liggghts
@pytest.mark.parametrize("engine", ["lammps", "liggghts"])
def test_a_centre_in_a_plane_wall_becomes_nan(engine: str, tmp_path: Path) -> None:
    """Law: the same at a wall, whose normal is the way from it over its length."""
    found = end_of(engine, "deep-wall", tmp_path, overlap="1.0")
    assert "ERROR" not in found.log
    assert_nan("both-centre-in-wall", found.frames[-1].columns["vz"])


@pytest.mark.lammps
def test_lammps_takes_a_restitution_of_zero_for_nan(tmp_path: Path) -> None:
    """Law: a restitution of 0 is critical damping. The formula of LAMMPS has -ln e/sqrt(pi^2 + ln^2 e), which is inf/inf there."""
    found = end_of("lammps", "restitution", tmp_path, e="0.0")
    assert "ERROR" not in found.log
    assert_nan("lammps-restitution-zero", found.frames[-1].columns["vx"])


@pytest.mark.liggghts
def test_liggghts_says_nothing_of_lost_particles(tmp_path: Path) -> None:
    """Law: spheres that an unstable step has blown out of the box are missed (LAMMPS ends the run). LIGGGHTS ends well with nobody left."""
    found = end_of("liggghts", "stiffness", tmp_path, stiffness="1e9", steps="150")
    assert found.code == 0
    assert "ERROR" not in found.log
    assert_deviates("liggghts-lost-unsaid", found.thermo[-1]["Atoms"][-1], engine_rule=0.0, law=2.0, rtol=1e-12)

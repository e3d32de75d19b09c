"""Formulas that ask for a particle after a run, as decks do that turn velocities round."""

from __future__ import annotations

from pathlib import Path

import pytest

from demverify.engines.base import Job
from demverify.errors import InputError
from demverify.runs import execute, plan

DECK = """units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05
create_box 1 box
create_atoms 1 single 0.0 0.0 0.0
set type 1 diameter 0.01 density 2500.0
fix down all gravity 10.0 vector 0.0 0.0 -1.0
timestep 1.0e-4
fix move all nve/sphere
thermo_style custom step {column}
thermo 10
run 20
{after}
run 20
"""


def deck(folder: Path, after: str, column: str = "atoms") -> Path:
    path = folder / "in.lammps"
    path.write_text(DECK.format(after=after, column=column))
    return path


def test_velocities_turned_round_between_runs(tmp_path: Path) -> None:
    """Law: thrown back with the velocity it has fallen to, a ball is at its starting point, at rest, after the same time."""
    job = Job(deck(tmp_path, "set atom 1 vz $(-vz[1])"), tmp_path / "out", {}, 20, 60.0, 1, 1)
    last = execute("native", "native", job, keep=True).frames[-1]
    assert last.columns["z"][0] == pytest.approx(0.0, abs=1e-15)
    assert last.columns["vz"][0] == pytest.approx(0.0, abs=1e-15)


def test_a_plan_says_that_more_follows(tmp_path: Path) -> None:
    """Law: a plan knows the runs before the formula, and group functions count as particles do."""
    found = plan(deck(tmp_path, "set atom 1 vz $(-vcm(all,z))"), {})
    assert not found.whole
    assert found.steps == 20


@pytest.mark.parametrize("keyword", ["vq[1]", "swirl(all)"])
def test_what_is_no_column_is_refused(keyword: str, tmp_path: Path) -> None:
    """Law: a formula after a run may ask for columns and group functions that there are, and for nothing else."""
    with pytest.raises(InputError):
        plan(deck(tmp_path, f"set atom 1 vz $({keyword})"), {})


def test_a_thermo_table_has_no_particles(tmp_path: Path) -> None:
    """Law: thermo_style custom takes no vz[1]; a variable may."""
    with pytest.raises(InputError):
        plan(deck(tmp_path, "", column="vz[1]"), {})

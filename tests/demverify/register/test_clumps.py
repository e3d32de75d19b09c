"""Register entries on rigid clumps in both engines: what is written beside their members."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.support.clump_decks import BODY, MOVE, again, ran
from tests.support.deviations import assert_deviates

GRAVITY, DT = 9.81, 2.5e-6


@pytest.mark.lammps
@pytest.mark.liggghts
def test_members_of_a_clump_have_its_mass_and_no_weight(tmp_path: Path) -> None:
    """Entry liggghts-clump-members: of a clump in free fall LAMMPS writes each sphere's mass and weight, LIGGGHTS the whole mass and no force."""
    lammps, liggghts = (ran("clump-bounce", engine, tmp_path / engine, every=10, steps=10) for engine in ("lammps", "liggghts"))
    own, whole = lammps.members[10], liggghts.members[10]
    total = float(own["mass"].sum())
    assert lammps.bodies[10][0, 1] == pytest.approx(total, rel=1e-14)
    assert_deviates("liggghts-clump-members", whole["mass"], engine_rule=np.full(4, total), law=own["mass"], rtol=1e-12)
    assert_deviates("liggghts-clump-members", whole["f"][:, 2], engine_rule=np.zeros(4), law=-GRAVITY * own["mass"], rtol=1e-12)
    assert np.abs(own["f"][:, 2] + GRAVITY * own["mass"]).max() < 1e-14 * GRAVITY * total
    assert np.abs(own["x"] - whole["x"]).max() < 1e-14  # both move alike


WEIGHT = f"fix             gravity all gravity {GRAVITY} vector 0.0 0.0 -1.0\n"
RIGID = "fix             move all rigid/small molecule\n"


def first_pull(engine: str, folder: Path, *fixes: str) -> float:
    """Acceleration along z in the first step of a second run, of a clump that nothing touches, with these fixes in this order."""

    def edit(text: str) -> str:
        return text.replace(WEIGHT, "").replace(MOVE if MOVE in text else RIGID, "".join(fixes)) + "run 2\n"

    run = ran("clump-bounce", engine, folder, edit=edit, every=1, steps=5)
    return float((run.bodies[6][0, BODY["v"]] - run.bodies[5][0, BODY["v"]])[2]) / DT


@pytest.mark.lammps
def test_forces_behind_fix_rigid_miss_half_a_step(tmp_path: Path) -> None:
    """Entry lammps-rigid-before-forces: what falls, falls at g from its first step on; behind fix rigid at g/2. In native at g."""
    law = first_pull("lammps", tmp_path / "in front", WEIGHT, RIGID)
    assert law == pytest.approx(-GRAVITY, rel=1e-8)
    measured = first_pull("lammps", tmp_path / "behind", RIGID, WEIGHT)
    assert_deviates("lammps-rigid-before-forces", measured, engine_rule=-0.5 * GRAVITY, law=law, rtol=1e-8)
    assert first_pull("native-lammps", tmp_path / "native", RIGID, WEIGHT) == pytest.approx(-GRAVITY, rel=1e-8)


@pytest.mark.liggghts
def test_forces_behind_fix_multisphere_miss_half_a_step(tmp_path: Path) -> None:
    """Entry liggghts-multisphere-before-wall: in the first half step of a run a clump feels no wall and no addforce that is defined behind fix
    multisphere; in front of it, it does. Its weight it feels wherever that stands."""
    found = []
    for first in (True, False):
        edit = partial(again, floor_first=first)
        run = ran("clump-bounce", "liggghts", tmp_path / f"{first}", edit=edit, every=1, steps=250, gamma=0.0, mu=0.0)
        mass = run.bodies[250][0, 1]
        pushed = (run.bodies[251][0, BODY["v"]] - run.bodies[250][0, BODY["v"]])[2] * mass / (0.5 * DT) + 2.0 * mass * GRAVITY
        found.append((pushed, *(float(run.members[step]["f"][:, 2].sum()) for step in (250, 251))))
    (right, before, after), (missed, then, later) = found
    assert before > 1.0  # a spring alone: the set-up finds the force of the step before
    assert right == pytest.approx(before + after, rel=1e-9)
    assert_deviates("liggghts-multisphere-before-wall", missed, engine_rule=later, law=then + later, rtol=1e-9)
    push = "fix             push all addforce 0.0 0.0 0.01\n"
    law = first_pull("liggghts", tmp_path / "push in front", push, MOVE)
    measured = first_pull("liggghts", tmp_path / "push behind", MOVE, push)
    assert_deviates("liggghts-multisphere-before-wall", measured, engine_rule=0.5 * law, law=law, rtol=1e-8)
    assert first_pull("liggghts", tmp_path / "weight behind", MOVE, WEIGHT) == pytest.approx(-GRAVITY, rel=1e-8)

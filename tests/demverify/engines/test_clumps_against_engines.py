"""Clumps of the native engine against LIGGGHTS' fix multisphere and LAMMPS' fix rigid/small: forces, and trajectories of members and bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demverify.cases import load_case
from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.rules import under_liggghts_rules
from demverify.runs import plan
from tests.support.clump_decks import BODY, INPUTS, Dumps, again, apart, bodies_apart, largest, ran

ENGINES = [pytest.param(name, marks=getattr(pytest.mark, name)) for name in ("lammps", "liggghts")]
Both = tuple[Dumps, Dumps]
RIGID = "fix             move all rigid/small molecule\n"


def both(case: str, engine: str, folder: Path, **settings: object) -> Both:
    return ran(case, f"native-{engine}", folder / "ours", **settings), ran(case, engine, folder / "theirs", **settings)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def bounce(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Both]:
    """inputs/clump-bounce, 7,000 steps, in native and the engine, on demand."""
    return _Lazy("clump-bounce", tmp_path_factory, every=10)


@pytest.fixture(scope="module")
def collision(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Both]:
    """inputs/clump-collision, 1,500 steps."""
    return _Lazy("clump-collision", tmp_path_factory, every=1)


class _Lazy(dict[str, Both]):
    def __init__(self, case: str, paths: pytest.TempPathFactory, every: int) -> None:
        super().__init__()
        self.case, self.paths, self.every = case, paths, every

    def __missing__(self, engine: str) -> Both:
        self[engine] = both(self.case, engine, self.paths.mktemp(f"{self.case}-{engine}"), every=self.every)
        return self[engine]


@pytest.mark.parametrize("engine", ENGINES)
def test_forces_on_the_floor(engine: str, tmp_path: Path) -> None:
    """Law: a clump that meets the floor (step 229), with friction and damping both ways, and a second run that starts in contact at step 260: every
    member's force and torque, and the motion of members and body, are the engine's to 1e-12 of the largest over 320 steps."""
    ours, theirs = both("clump-bounce", engine, tmp_path, edit=again, every=1, steps=260)
    assert sorted(ours.members) == sorted(theirs.members) == list(range(321))
    assert np.abs(theirs.members[260]["f"][:, 2]).max() > 1.0
    assert largest(theirs, "tq") > 1e-3
    for name in ("f", "tq", "x", "v", "omega"):
        assert apart(ours, theirs, name) < 1e-12, name
    for name in set(BODY) - {"quat"}:
        assert bodies_apart(ours, theirs, name) < 1e-12, name
    assert bodies_apart(ours, theirs, "quat") < 1e-11  # from axes found anew in the second run


@pytest.mark.parametrize("engine", ENGINES)
def test_forces_between_two_clumps(collision: dict[str, Both], engine: str) -> None:
    """Law: from the first touch of two clumps (step 569) on, for 60 steps, members' forces and torques are the engine's to 1e-12 of the largest."""
    ours, theirs = collision[engine]
    steps = list(range(560, 630))
    assert np.abs(theirs.members[580]["f"]).max() > 1.0
    assert len(np.unique(np.flatnonzero(theirs.members[580]["f"].any(axis=1)) // 4)) == 2
    for name, limit in (("f", 1e-12), ("tq", 2e-12), ("x", 1e-13), ("v", 1e-12), ("omega", 1e-12)):
        assert apart(ours, theirs, name, steps) < limit, name


@pytest.mark.parametrize("engine", ENGINES)
def test_two_clumps_collide_and_part(collision: dict[str, Both], engine: str) -> None:
    """Law: through the collision and after it members and bodies are the engine's to 1e-11 over 1,500 steps."""
    ours, theirs = collision[engine]
    assert sorted(ours.members) == sorted(theirs.members) == list(range(1501))
    for name in ("x", "v", "omega", "f", "tq"):
        assert apart(ours, theirs, name) < 1e-11, name
    for name in BODY:
        assert bodies_apart(ours, theirs, name) < 1e-11, name


@pytest.mark.lammps
def test_a_clump_across_a_periodic_face(tmp_path: Path) -> None:
    """Law: spheres beyond a periodic face are inside at once, as commands behind create_atoms see them in LAMMPS: velocities from formulas of x."""

    def edit(text: str) -> str:
        return text.replace("boundary        f f f", "boundary        p p f").replace("single 0.00163", "single 0.04963")

    ours, theirs = both("clump-bounce", "lammps", tmp_path, edit=edit, every=10, steps=100)
    at = theirs.members[0]["x"][:, 0]
    assert at.min() < -0.04
    assert at.max() > 0.04
    for name in ("x", "v", "omega", "f"):
        assert apart(ours, theirs, name) < 1e-12, name


@pytest.mark.lammps
def test_molecules_of_the_file(tmp_path: Path) -> None:
    """Law: molecules that the file numbers count on from the largest there is, as in LAMMPS: 3 behind none is 3."""
    file = tmp_path / "three.mol"
    file.write_text((INPUTS / "clump-bounce" / "clump.mol").read_text() + "\nMolecules\n\n1 3\n2 3\n3 3\n4 3\n")

    def edit(text: str) -> str:
        return text.replace("clump.mol", str(file)).replace("group           a molecule 1", "group           a molecule 3")

    ours, theirs = both("clump-bounce", "lammps", tmp_path, edit=edit, every=10, steps=10)
    assert theirs.members[0]["mol"].tolist() == ours.members[0]["mol"].tolist() == [3.0] * 4
    assert bodies_apart(ours, theirs, "v") < 1e-13


@pytest.mark.lammps
@pytest.mark.parametrize("fixes", ["fix hold b freeze\n{}", "{}fix hold b freeze\n"], ids=["freeze-first", "freeze-last"])
def test_a_frozen_clump_flies_on_unpushed(fixes: str, tmp_path: Path) -> None:
    """Law: contacts push no member under fix freeze, before fix rigid/small or behind it, nor count its mass; the clump flies on as it was, the other
    one recoils as in LAMMPS to 1e-11."""
    ours, theirs = both("clump-collision", "lammps", tmp_path, edit=lambda text: text.replace(RIGID, fixes.format(RIGID)), every=1)
    assert sorted(ours.members) == sorted(theirs.members) == list(range(1501))
    for name in ("x", "v", "omega", "f", "tq"):
        assert apart(ours, theirs, name) < 1e-11, name
    gained = ours.bodies[1500][:, BODY["v"]] - ours.bodies[0][:, BODY["v"]]
    assert not gained[1].any()
    assert np.abs(gained[0]).max() > 0.1


@pytest.mark.parametrize("engine", ENGINES)
def test_a_clump_bounces_as_in_the_engine(bounce: dict[str, Both], engine: str) -> None:
    """Law: members and body of a clump that tumbles and bounces are the engine's to 1e-10 through its second impact, and its third, to the end."""
    ours, theirs = bounce[engine]
    contact = [step for step in sorted(theirs.members) if np.abs(theirs.members[step]["tq"]).max() > 0.0]
    impacts = [b for a, b in zip([-100, *contact], contact, strict=False) if b - a > 50]
    assert len(impacts) == 3
    for name in ("x", "v", "omega", "f", "tq"):
        assert apart(ours, theirs, name) < 1e-10, name
    for name in BODY:
        assert bodies_apart(ours, theirs, name) < 1e-10, name


@pytest.mark.parametrize("engine", ENGINES)
def test_masses_are_the_engines(bounce: dict[str, Both], engine: str) -> None:
    """Law: mol, radius and mass of members, number and mass of the body are what the engine writes; LIGGGHTS' members carry the mass of the whole."""
    ours, theirs = bounce[engine]
    for name in ("id", "mol", "radius", "mass"):
        assert np.abs(ours.members[0][name] / theirs.members[0][name] - 1.0).max() < 1e-15, name
    assert np.abs(ours.bodies[0][:, :2] - theirs.bodies[0][:, :2]).max() < 1e-18
    whole = theirs.bodies[0][0, 1]
    assert theirs.members[0]["mass"].sum() == pytest.approx(whole if engine == "lammps" else 4 * whole, rel=1e-14)


@pytest.mark.parametrize("case", ["clump-bounce", "clump-collision"])
def test_under_the_same_rules_both_decks_are_one_scene(case: str, tmp_path: Path) -> None:
    """Law: the LAMMPS deck under LIGGGHTS' rules does what the LIGGGHTS deck does, through the first impact and after it, to 1e-9; masses too."""
    folder = INPUTS / case
    other = plan(folder / "in.liggghts", {}).runs[-1].scene
    found = []
    for dialect, rules in (("lammps", lambda scene: under_liggghts_rules(scene, other)), ("liggghts", None)):
        job = Job(folder / f"in.{dialect}", tmp_path / dialect, {"every": ["1000000"], "steps": ["700"]}, 10, 600.0, 1, 1)
        outcome, outputs = ENGINE.run_with(job, keep=True, rules=rules)
        assert outcome.status == "ok", outcome.reason
        found.append({frame.step: frame for frame in outputs.frames})
    ours, theirs = found
    assert sorted(set(ours) & set(theirs)) == list(range(0, 701, 10))
    for columns in (("fx", "fy", "fz"), ("tqx", "tqy", "tqz"), ("x", "y", "z"), ("vx", "vy", "vz"), ("omegax", "omegay", "omegaz")):
        size = max(np.abs(frame.vectors(*columns)).max() for frame in theirs.values())
        assert size > 0.0
        assert max(np.abs(ours[k].vectors(*columns) - theirs[k].vectors(*columns)).max() for k in range(0, 701, 10)) < 1e-9 * size
    assert (ours[0].columns["mass"] == theirs[0].columns["mass"]).all()


@pytest.mark.parametrize("case", ["clump-bounce", "clump-collision"])
def test_the_cases_are_of_the_library(case: str) -> None:
    """Law: both decks stand in the scenario clumps, with what they accept and a law."""
    found = load_case(INPUTS / case)
    assert found.scenario == "clumps"
    assert "liggghts-clump-members" in found.accept
    assert found.laws

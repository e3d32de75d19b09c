"""The plain engine of superquadrics against LIGGGHTS 3.8.0, step by step from its dumps, with contact histories carried along."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demsolver import ContactLaw
from demsolver.shapes import superquadric
from demsolver.superquadric.reference import Planes, Shaped, forces, step
from demverify.formats.dump import read_dump
from demverify.frames import Frame
from demverify.runs import plan

DATA = Path(__file__).parents[2] / "data/superquadric"
DT = 4e-5
SCHEMES = ("richardson", "no_squish", "midpoint", "woodem")
HERTZ, HOOKE = "hertz tangential history", "hooke tangential history"
DECK = """atom_style granular
boundary f f f
newton off
communicate single vel yes
region b block -1 1 -1 1 -1 1
create_box 1 b
create_atoms 1 single 0 0 0
create_atoms 1 single 0 0 0.5
set type 1 diameter 0.1 density 2500
fix m1 all property/global youngsModulus peratomtype 1e7
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.6
fix m4 all property/global coefficientFriction peratomtypepair 1 0.4
fix m5 all property/global characteristicVelocity scalar 1.0
fix m6 all property/global coefficientRollingFriction peratomtypepair 1 0.2
fix m7 all property/global coefficientRollingViscousDamping peratomtypepair 1 0.3
pair_style gran model MODEL
pair_coeff * *
neighbor 0.01 bin
timestep 4e-5
fix floor all wall/gran model MODEL primitive type 1 zplane -0.9
fix move all nve/sphere
run 1
"""


def laws(model: str, folder: Path) -> tuple[ContactLaw, ContactLaw]:
    """Of pairs and of the plane, as a deck of spheres with the materials of all these runs has them."""
    path = folder / "in.liggghts"
    path.write_text(DECK.replace("MODEL", model))
    scene = plan(path, {}).runs[0].scene
    assert scene.pair
    return scene.pair, scene.walls[0].law


def shaped(frame: Frame) -> Shaped:
    """The bodies of a dump."""

    def of(name: str) -> np.ndarray:
        return frame.vectors(f"{name}x", f"{name}y", f"{name}z")

    quat, blockiness = (np.column_stack([frame.columns[f"{name}{k}"] for k in range(1, n + 1)]) for name, n in (("quat", 4), ("blockiness", 2)))
    found = Shaped(of(""), of("v"), quat, of("angmom"), of("omega"), of("shape"), blockiness, frame.columns["mass"], of("inertia"))
    assert found.mass[:, None] * superquadric.inertia_per_mass(found.shape, found.blockiness) == pytest.approx(found.inertia, rel=1e-13)
    return found


@pytest.mark.parametrize(("name", "model", "scheme", "limit"), [
    ("pair_friction", HERTZ, 1, 1e-6), ("plane_friction", HERTZ, 1, 1e-12), ("hooke_friction", HOOKE, 1, 1e-6),
    ("roll_cdt", f"{HERTZ} rolling_friction cdt", 1, 1e-6), ("roll_epsd", f"{HERTZ} rolling_friction epsd", 1, 1e-6),
    ("roll_epsd2", f"{HERTZ} rolling_friction epsd2", 1, 1e-6),
    ("integ_s0", HERTZ, 0, 1e-6), ("integ_s2", HERTZ, 2, 1e-6), ("integ_s3", HERTZ, 3, 1e-6),
])  # fmt: skip
def test_each_step_is_liggghts(name: str, model: str, scheme: int, limit: float, tmp_path: Path) -> None:
    """Law: from each dumped state the next follows: forces to 1e-6 of the largest, where LIGGGHTS' iteration ends, with planes to rounding."""
    pair, wall = laws(model, tmp_path)
    planes = (Planes("floor", 2, -0.9, wall),)
    frames = list(read_dump(DATA / f"{name}.dump.gz"))
    before, history = shaped(frames[0]), {}
    force, torque, history = forces(before, pair, planes, history, DT, False)
    assert not force.any()
    most, off, twisted, spins, places = 0.0, 0.0, 0.0, 0.0, 0.0
    for frame in frames[1:]:
        now, force, torque, history = step(SCHEMES[scheme], before, force, torque, pair, planes, history, DT, np.zeros(3))
        there, wanted, turned = shaped(frame), frame.vectors("fx", "fy", "fz"), frame.vectors("tqx", "tqy", "tqz")
        most, off = max(most, np.abs(wanted).max()), max(off, np.abs(force - wanted).max())
        twisted = max(twisted, np.abs(torque - turned).max() / frame.columns["radius"].max())
        spins = max(spins, np.abs(now.omega - there.omega).max() / np.abs(there.omega).max())
        places = max(places, np.abs(now.x - there.x).max(), np.abs(now.quat - there.quat).max())
        before, force, torque = there, wanted, turned
    assert most > 1.0
    assert len(history) > 1
    assert off <= limit * most
    assert twisted <= limit * most
    assert spins <= limit
    assert places <= 1e-14

"""Register entries on LAMMPS' granular walls. A ball touches the plane z = 0 or a cylinder; without an integrator it keeps its
place and velocity, and only the contact history grows: every step has a closed form."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Floats
from tests.support.decks import Ball, simulate_lammps
from tests.support.deviations import assert_deviates, assert_nan
from tests.support.engines import EngineRun

pytestmark = pytest.mark.lammps

RADIUS, OVERLAP, SPEED, DT = 0.01, 1e-5, 0.1, 1e-6
STIFFNESS, FRICTION = 1e5, 0.497
CONTACT_RADIUS = sqrt(RADIUS * OVERLAP)
SLIDING = [Ball((0.0, 0.0, RADIUS - OVERLAP), v=(SPEED, 0.0, 0.0))]


def slide(style: str, steps: int, folder: Path) -> EngineRun:
    """A ball pressed on the plane z = 0 slides along x."""
    return simulate_lammps(SLIDING, f"pair_style none\nfix w all wall/gran {style} zplane 0 NULL\nrun {steps}", folder)


def friction_force(run: EngineRun) -> Floats:
    """Force along x at each step."""
    return np.array([frame.columns["fx"][0] for frame in run.frames])


def test_wall_hooke_history_multiplies_the_spring_by_the_contact_radius(tmp_path: Path) -> None:
    """Law: the tangential force of a sticking contact is -kt times the distance slid, k v dt after k steps."""
    run = slide(f"hooke/history {STIFFNESS} {STIFFNESS} 1.0 0.0 {FRICTION} 0", 10, tmp_path)
    slid = SPEED * DT * np.arange(11)
    assert_deviates(
        "lammps-wall-hooke-history-kt",
        friction_force(run),
        engine_rule=-STIFFNESS * CONTACT_RADIUS * slid,
        law=-STIFFNESS * slid,
        rtol=1e-12,
    )


def test_wall_hertz_history_loses_friction_after_slip(tmp_path: Path) -> None:
    """Law: a contact that slides on and on holds the friction force at mu Fn. Here the spring is reset to mu Fn / kt in place of
    mu Fn / (kt a), so the step after the first slip carries mu Fn a, and the climb begins anew."""
    run = slide(f"hertz/history {STIFFNESS} {STIFFNESS} 1.0 0.0 {FRICTION} 0", 60, tmp_path)
    limit = FRICTION * STIFFNESS * CONTACT_RADIUS * OVERLAP
    increment = STIFFNESS * CONTACT_RADIUS * SPEED * DT
    first_slip = int(np.argmax(increment * np.arange(61) > limit))
    measured = friction_force(run)[first_slip : first_slip + 3]
    after_reset = limit * CONTACT_RADIUS
    assert_deviates(
        "lammps-wall-hertz-history-slip",
        measured,
        engine_rule=[-limit, -(after_reset + increment), -(after_reset + 2 * increment)],
        law=[-limit] * 3,
        rtol=1e-9,
    )


@pytest.mark.parametrize("style", ["hooke", "hooke/history", "hertz/history"])
def test_undamped_legacy_wall_gives_nan(style: str, tmp_path: Path) -> None:
    """Law: with no damping the normal force of a ball at rest on a plane is its elastic force, a finite number."""
    run = slide(f"{style} {STIFFNESS} {STIFFNESS} 0.0 0.0 {FRICTION} 0", 0, tmp_path)
    assert_nan("lammps-wall-legacy-undamped-nan", run.frame(0).columns["fz"])


def test_cylinder_takes_its_diameter_for_its_radius(tmp_path: Path) -> None:
    """Law (Hertz): inside a cylinder 1/R* = 1/R - 1/Rc; the engine takes 1/R - 1/(2 Rc)."""
    cylinder, overlap = 0.03, 4e-4
    ball = Ball((cylinder - RADIUS + overlap, 0.0, 0.0))
    wall = f"granular hertz {STIFFNESS} 1.0 tangential linear_nohistory 0 0 damping velocity zcylinder {cylinder}"
    run = simulate_lammps([ball], f"pair_style none\nfix w all wall/gran {wall}\nrun 0", tmp_path)

    def hertz(curvature: float) -> float:
        return -STIFFNESS * sqrt(overlap / (1 / RADIUS - curvature)) * overlap

    assert_deviates(
        "lammps-concave-wall-radius",
        run.frame(0).columns["fx"][0],
        engine_rule=hertz(1 / (2 * cylinder)),
        law=hertz(1 / cylinder),
        rtol=1e-10,
    )


def test_open_cylinder_region_gives_nan_in_the_plane_of_its_edge(tmp_path: Path) -> None:
    """Law: a ball inside an open cylinder, its centre level with the rim, is pushed to the axis by kn times the overlap."""
    cylinder, top, overlap = 0.03, 0.1, 4e-4
    wall = f"region c cylinder z 0 0 {cylinder} -{top} {top} open 1 open 2\nfix w all wall/gran/region granular hooke 1e5 1.0"
    body = f"pair_style none\n{wall} tangential linear_nohistory 0 0 damping velocity region c\nrun 0"
    below, level = (
        simulate_lammps([Ball((cylinder - RADIUS + overlap, 0.0, z))], body, tmp_path / name).frame(0).columns["fx"][0]
        for name, z in (("below", 0.99 * top), ("level", top))
    )
    assert below == pytest.approx(-1e5 * overlap, rel=1e-9)
    assert_nan("lammps-open-cylinder-edge-nan", level)


def test_two_planes_of_one_fix_are_not_felt_at_once(tmp_path: Path) -> None:
    """Law: a ball pressed by d1 on one plane and by d2 on the plane opposite feels k (d1 - d2), whichever is nearer."""
    below, above = 4e-5, 1e-5
    upper = 2.0 * RADIUS - below - above
    ball = [Ball((0.0, 0.0, RADIUS - below))]
    wall = f"granular hooke {STIFFNESS} 0.0 tangential linear_nohistory 0.0 0.0 damping velocity"
    one = simulate_lammps(ball, f"pair_style none\nfix w all wall/gran {wall} zplane 0 {upper}\nrun 0", tmp_path)
    assert_deviates(
        "lammps-nearer-plane-only",
        one.frame(0).columns["fz"],
        engine_rule=[STIFFNESS * below],
        law=[STIFFNESS * (below - above)],
        rtol=1e-9,
    )

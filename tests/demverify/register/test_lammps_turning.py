"""Register entries on LAMMPS' rolling, twisting and cohesive granular models."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from demsolver.contact import normal_jkr
from demverify.frames import Frame
from tests.support.decks import Ball, simulate_lammps
from tests.support.deviations import assert_deviates
from tests.support.engines import EngineRun

pytestmark = pytest.mark.lammps

RADIUS, OVERLAP, DT = 0.01, 4e-4, 1e-5
SPIN = (3.0, 2.0, 1.0)


def carried(sub_model: str, folder: Path, *, sort: str) -> EngineRun:
    """Two balls, one spinning, are carried along y from one row of sorting bins (50 mm) into the next at step 20: from then on they lie in
    one row, where the other ball comes first."""
    offset, speed = (2 * RADIUS - OVERLAP) / sqrt(2), 5.0
    balls = [
        Ball((0.001, -0.001, 0.0), v=(0.0, speed, 0.0), omega=SPIN),
        Ball((0.001 - offset, -0.001 + offset, 0.0), v=(0.0, speed, 0.0)),
    ]
    law = f"pair_style granular\npair_coeff * * hooke 1e4 0 tangential linear_history 1e4 0 0.5 {sub_model}\n"
    motion = f"neigh_modify delay 0 every 1 check no\natom_modify sort {sort}\nfix m all move linear 0 {speed} 0\nrun 21"
    return simulate_lammps(balls, law + motion, folder, dt=DT)


def own_torque(frame: Frame, sub_model: str) -> float:
    """What the sub-model turns the first ball with: all along the contact normal is twist; rolling resistance is what the two balls feel in
    opposite ways in the tangent plane, friction what they feel alike."""
    x, torque = frame.vectors("x", "y", "z"), frame.vectors("tqx", "tqy", "tqz")
    normal = (x[0] - x[1]) / np.linalg.norm(x[0] - x[1])
    return float(torque[0] @ normal) if sub_model.startswith("twisting") else float((torque[0] - torque[1])[0]) / 2


@pytest.mark.parametrize("sub_model", ["rolling sds 1e2 0 0.5", "twisting sds 1e2 0 0.5", "twisting marshall"])
def test_springs_turn_round_when_balls_change_places(sub_model: str, tmp_path: Path) -> None:
    """Law: how far two balls have rolled or twisted on each other is the same seen from either, so the torque of a spring wound at an even
    pace grows evenly. The engine turns all history round when a pair changes places in its list, as sorting its atoms makes it."""
    kept, sorted_ = (carried(sub_model, tmp_path / name, sort=sort) for name, sort in (("kept", "0 0.0"), ("sorted", "1 0.05")))
    winding = [np.array([own_torque(frame, sub_model) for frame in run.frames]) for run in (kept, sorted_)]
    one = winding[0][1]
    assert winding[0] == pytest.approx(one * np.arange(22), rel=1e-9)
    assert_deviates("lammps-turning-springs-change-sign", winding[1][19:] / one, engine_rule=[19.0, -18.0, -17.0], law=[19.0, 20.0, 21.0], rtol=1e-9)


def test_marshall_leaves_out_a_contact_radius(tmp_path: Path) -> None:
    """Law (Marshall 2009, eq. 32): the twisting stiffness is kt a^2/2 with the tangential stiffness kt, which is a times its coefficient behind
    mindlin. The engine takes the coefficient itself, whose dimension is another."""
    balls = [Ball((0.0, 0.0, 0.0), omega=(7.0, 0.0, 0.0)), Ball((2 * RADIUS - OVERLAP, 0.0, 0.0))]
    law = "pair_style granular\npair_coeff * * hertz 1e6 0 tangential mindlin 1e6 0 1e9 twisting marshall\nrun 1"
    torque = simulate_lammps(balls, law, tmp_path, dt=DT).frame(1).columns["tqx"][0]
    a = sqrt(RADIUS / 2 * OVERLAP)
    coefficient = -torque / (0.5 * a**2 * 7.0 * DT)
    assert_deviates("lammps-marshall-mindlin-radius", coefficient, engine_rule=1e6, law=1e6 * a, rtol=1e-9)


def test_jkr_contacts_end_at_their_greatest_pull(tmp_path: Path) -> None:
    """Law (JKR): pulled apart slowly, two balls hold on up to a gap of (3/4) [pi^2 (w/E*)^2 R]^(1/3), w = 2 gamma. The engine ends the contact where
    the pull is greatest, as under a dead weight."""
    young, gamma, speed, reff = 1e6, 0.5, 0.1, RADIUS / 2
    modulus = young / (2 * (1 - 0.3**2))
    whole = 0.75 * (pi**2 * (2 * gamma / modulus) ** 2 * reff) ** (1 / 3)
    steps = 400
    dt = 1.2 * whole / speed / steps
    balls = [Ball((0.0, 0.0, 0.0)), Ball((2 * RADIUS - 1e-9, 0.0, 0.0), v=(speed, 0.0, 0.0), type=2)]
    law = f"pair_style granular\npair_coeff * * jkr {young} 0 0.3 {gamma} tangential linear_nohistory 0 0\n"
    motion = f"group a type 1\ngroup c type 2\nfix k a move linear 0 0 0\nfix l c move linear {speed} 0 0\nrun {steps}"
    run = simulate_lammps(balls, law + motion, tmp_path, dt=dt)
    gap = max(float(f.columns["x"][1] - f.columns["x"][0]) - 2 * RADIUS for f in run.frames if f.columns["fx"][0] > 0.0)
    assert normal_jkr.reach(reff, modulus, gamma) == pytest.approx(whole / 9 ** (1 / 3), rel=1e-12)
    assert_deviates("lammps-jkr-greatest-pull", gap, engine_rule=whole / 9 ** (1 / 3), law=whole, rtol=2.4 / steps)


@pytest.mark.parametrize(("model", "radius_in_spring"), [("linear_history_classic", True), ("mindlin_classic", False)])
def test_classic_models_miscount_the_contact_radius(model: str, radius_in_spring: bool, tmp_path: Path) -> None:
    """Law: a spring of coefficient k holds k s, behind mindlin k a s; a slipping contact keeps mu Fn. The engine multiplies the former by a too,
    and forgets a in the latter once it has slipped."""
    k, overlap = 1e5, 1e-5
    a = sqrt(RADIUS / 2 * overlap)
    normal = f"hooke {k} 0" if radius_in_spring else f"hertz {k} 0"
    limit = 0.5 * k * overlap * (1.0 if radius_in_spring else a)
    speed = 1e-2 if radius_in_spring else 0.3 * limit / (k * a * DT)
    balls = [Ball((0.0, 0.0, 0.0), v=(0.0, speed, 0.0)), Ball((2 * RADIUS - overlap, 0.0, 0.0))]
    law = f"pair_style granular\npair_coeff * * {normal} tangential {model} {k} 0 0.5\nrun 5"
    run = simulate_lammps(balls, law, tmp_path, dt=DT)
    force = -np.array([frame.columns["fy"][0] for frame in run.frames])
    if radius_in_spring:
        rule, true = k * a * speed * DT * np.arange(6), k * speed * DT * np.arange(6)
    else:
        step = 0.3 * limit
        rule, true = np.array([0.0, step, 2 * step, 3 * step, limit, a * limit + step]), np.minimum(step * np.arange(6), limit)
    assert_deviates("lammps-classic-tangential-models", force, engine_rule=rule, law=true, rtol=1e-9)


def test_jkr_ends_at_touch_inside_a_cylinder(tmp_path: Path) -> None:
    """Law: a contact that has touched goes on beyond touch, at a cylinder as at a plane. The engine holds a ball off the inside of a cylinder for
    apart as soon as they do not overlap."""
    hollow, speed, steps = 0.06, 0.1, 20
    radius = -2 * hollow * RADIUS / (RADIUS - 2 * hollow)  # the engine's, see lammps-concave-wall-radius
    modulus, gamma = 1e6 / (2 * (1 - 0.3**2)), 0.5
    gap = normal_jkr.reach(radius, modulus, gamma)
    balls = [Ball((hollow - RADIUS + gap / 2, 0.0, 0.0), v=(-speed, 0.0, 0.0))]
    law = f"pair_style none\nfix w all wall/gran granular jkr 1e6 0 0.3 {gamma} tangential linear_nohistory 0 0 zcylinder {hollow}\n"
    run = simulate_lammps(balls, f"{law}fix m all move linear {-speed} 0 0\nrun {steps}", tmp_path, dt=gap / speed / steps)
    overlaps = np.array([frame.columns["x"][0] + RADIUS - hollow for frame in run.frames])
    whole = [normal_jkr.force(normal_jkr.contact_radius(d, radius, modulus, gamma), radius, modulus, gamma) for d in overlaps]
    ended = [-f if d > 0.0 else 0.0 for f, d in zip(whole, overlaps, strict=True)]
    assert (overlaps > -gap).all()
    assert_deviates("lammps-jkr-hollow-cylinder", [f.columns["fx"][0] for f in run.frames], engine_rule=ended, law=np.negative(whole), rtol=1e-9)

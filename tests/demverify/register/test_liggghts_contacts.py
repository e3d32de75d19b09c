"""Register entries on LIGGGHTS' contact models. Without an integrator balls keep place and velocity, and only the contact history
grows: every step has a closed form."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Floats
from tests.support.decks import Ball, Material, simulate_liggghts
from tests.support.deviations import assert_deviates, assert_nan
from tests.support.engines import EngineRun

pytestmark = pytest.mark.liggghts

RADIUS, OVERLAP, DENSITY, DT = 0.01, 4e-4, 2500.0, 1e-6
MASS = 4 / 3 * pi * RADIUS**3 * DENSITY
NEIGHBOUR_X = 2 * RADIUS - OVERLAP
ELASTIC = {"youngsModulus": 1e7, "poissonsRatio": 0.3, "coefficientRestitution": 0.5, "characteristicVelocity": 1.0}
HISTORY = "tangential history"


def stiffness(
    kn: float = 1e4, kt: float = 1e4, gamman: float = 10.0, gammat: float = 20.0, mu: float = 0.5, *, types: int = 1
) -> Material:
    """Constants of the stiffness models."""
    return Material(types, {"kn": kn, "kt": kt, "gamman": gamman, "gammat": gammat, "coefficientFriction": mu})


def pair(balls: list[Ball], material: Material, model: str, steps: int, folder: Path) -> EngineRun:
    """Balls at rest or in steady motion under one contact model."""
    return simulate_liggghts(balls, material, f"pair_style gran model {model}\npair_coeff * *\nrun {steps}", folder)


def wall(ball: Ball, model: str, shape: str, folder: Path, kn: float = 1e4) -> Floats:
    """Force on one ball at a primitive wall, at setup."""
    body = f"pair_style gran model {model}\npair_coeff * *\nfix w all wall/gran model {model} primitive type 1 {shape}\nrun 0"
    run = simulate_liggghts([ball], stiffness(kn), body, folder)
    return np.array([run.frame(0).columns[name][0] for name in ("fx", "fy", "fz")])


def test_contact_arm_shortens_with_overlap(tmp_path: Path) -> None:
    """Law of LAMMPS: the spin moves the contact point with the arm R. LIGGGHTS takes R - overlap/2 there
    and in the torque."""
    spin, speed = 5.0, 0.3
    balls = [Ball((0.0, 0.0, 0.0), v=(0.0, speed, 0.0), omega=(0.0, 0.0, spin)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    columns = pair(balls, stiffness(mu=100.0), f"hooke/stiffness {HISTORY}", 0, tmp_path).frame(0).columns

    def force_and_arm(arm: float) -> tuple[float, float]:
        return -0.5 * MASS * 20.0 * (speed + spin * arm), arm

    measured = (columns["fy"][0], columns["tqz"][0] / columns["fy"][0])
    entry = "liggghts-contact-arm"
    ours, law = force_and_arm(RADIUS - OVERLAP / 2), force_and_arm(RADIUS)
    for value, claimed, textbook in zip(measured, ours, law, strict=True):
        assert_deviates(entry, value, engine_rule=claimed, law=textbook, rtol=1e-10)


@pytest.mark.parametrize("mu", [0.5, 0.0])
def test_friction_limit_leaves_damping_out(mu: float, tmp_path: Path) -> None:
    """Law (Coulomb): the whole tangential force is at most mu Fn. Here the spring alone is limited: a fresh contact carries its
    full damping force, even with mu = 0, and drops to mu Fn once the spring slips."""
    speed, kt, gammat = 0.3, 1e7, 3000.0
    balls = [Ball((0.0, 0.0, 0.0), v=(0.0, speed, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    run = pair(balls, stiffness(kt=kt, gammat=gammat, mu=mu), f"hooke/stiffness {HISTORY}", 1, tmp_path)
    ratio = [abs(frame.columns["fy"][0] / frame.columns["fx"][0]) for frame in run.frames]
    damping = 0.5 * MASS * gammat * speed / (1e4 * OVERLAP)
    assert_deviates("liggghts-damping-outside-coulomb", ratio, engine_rule=[damping, mu], law=[mu, mu], rtol=1e-9)


def bounce_twice(neighbours: str, folder: Path) -> float:
    """A ball swings in and out of a second one that slides past at 0.01 m/s: two contacts of half a period each. Returns the
    largest friction force of the second contact over that of the first."""
    period, swing = 100 * DT, 3e-5
    balls = [Ball((0.0, 0.0, 0.0)), Ball((2 * RADIUS + 1e-5, 0.0, 0.0), type=2)]
    motion = f"fix k a move wiggle {swing} 0 0 {period!r} units box\nfix l c move linear 0 0.01 0 units box"
    groups = "group a type 1\ngroup c type 2"
    body = f"pair_style gran model hooke/stiffness {HISTORY}\npair_coeff * *\n{neighbours}\n{groups}\n{motion}\nrun 200"
    run = simulate_liggghts(balls, stiffness(kn=1e5, kt=1e5, gamman=0.0, gammat=0.0, mu=100.0, types=2), body, folder)
    friction = np.array([abs(frame.columns["fy"][0]) for frame in run.frames])
    return float(friction[100:].max() / friction[:100].max())


def test_pair_history_survives_separation(tmp_path: Path) -> None:
    """Law: a contact that ends forgets its spring, so a second, equal contact carries an equal friction force. Here the spring
    goes on from where it stopped, to twice the force, until the neighbour list is rebuilt; contact_distance_factor 1.1 obeys."""
    lawful = bounce_twice("neigh_modify contact_distance_factor 1.1", tmp_path / "lawful")
    assert lawful == pytest.approx(1.0, rel=0.01)
    measured = bounce_twice("", tmp_path / "default")
    assert_deviates("liggghts-pair-history-kept", measured, engine_rule=2.0, law=1.0, rtol=0.01)


def test_viscous_gives_nan_at_rest(tmp_path: Path) -> None:
    """Law: two overlapping balls at rest push each other with their elastic force, a finite number. `viscous` divides by vn."""
    material = Material(
        1, ELASTIC | {"coefficientFriction": 0.5, "FluidViscosity": 1e-3, "CriticalStokes": 10.0, "MaximumRestitution": 0.9}
    )
    balls = [Ball((0.0, 0.0, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    assert_nan("liggghts-viscous-nan", pair(balls, material, f"hooke {HISTORY} viscous on", 0, tmp_path).frame(0).columns["fx"])


def test_kt_ratio_has_nine_digits(tmp_path: Path) -> None:
    """Law: ktToKnUser sets kt = 2/7 kn. The code writes 0.285714286. One step of sliding shows kt, the overlap shows kn."""
    speed = 1.0
    balls = [Ball((0.0, 0.0, 0.0), v=(0.0, speed, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    material = Material(1, ELASTIC | {"coefficientFriction": 50.0})
    run = pair(balls, material, f"hooke {HISTORY} tangential_damping off ktToKnUser on", 1, tmp_path)
    kn = abs(run.frame(0).columns["fx"][0]) / OVERLAP
    kt = abs(run.frame(1).columns["fy"][0]) / (speed * DT)
    assert_deviates("liggghts-kt-ratio-digits", kt / kn, engine_rule=0.285714286, law=2 / 7, rtol=5e-11)


def test_cylinder_wall_is_flat(tmp_path: Path) -> None:
    """Law (Hertz): inside a cylinder 1/R* = 1/R - 1/Rc. Here R* = R. Force kn sqrt(R* overlap) overlap."""
    cylinder, kn = 0.03, 1e6
    ball = Ball((cylinder - RADIUS + OVERLAP, 0.0, 0.0))
    force = wall(ball, f"hertz/stiffness {HISTORY}", f"zcylinder {cylinder} 0. 0.", tmp_path, kn=kn)
    flat, curved = (-kn * sqrt(OVERLAP / curvature) * OVERLAP for curvature in (1 / RADIUS, 1 / RADIUS - 1 / cylinder))
    assert_deviates("liggghts-concave-wall-flat", force[0], engine_rule=flat, law=curved, rtol=1e-10)


def test_ball_on_the_axis_of_a_narrow_cylinder_is_dragged(tmp_path: Path) -> None:
    """Law: a ball that does not touch the wall feels nothing. On the axis, the wall within the skin, it feels -m gammat v."""
    velocity = (0.1, 0.2, 0.3)
    force = wall(Ball((0.0, 0.0, 0.0), v=velocity), f"hooke/stiffness {HISTORY}", "zcylinder 0.0105 0. 0.", tmp_path)
    assert_deviates(
        "liggghts-narrow-cylinder-axis", force, engine_rule=-20.0 * MASS * np.array(velocity), law=np.zeros(3), rtol=1e-10
    )


def test_wall_acts_at_zero_gap(tmp_path: Path) -> None:
    """Law of LAMMPS: contact begins with a positive overlap. Here a ball that just reaches the wall is damped by m gamman v."""
    force = wall(Ball((0.0, 0.0, RADIUS), v=(0.0, 0.0, -1.0)), "hooke/stiffness", "zplane 0.0", tmp_path)
    assert_deviates("liggghts-wall-touch-closed", force[2], engine_rule=10.0 * MASS, law=0.0, rtol=1e-10)


def test_ycylinder_centre_is_given_z_first(tmp_path: Path) -> None:
    """Law: a centre is given as x, then z, as the axes are named. `ycylinder R 0.1 0.2` has its axis at z = 0.1, x = 0.2."""
    cylinder = 0.03
    x_first, z_first = (
        wall(
            Ball((x + cylinder - RADIUS + OVERLAP, 0.0, z)), "hooke/stiffness", f"ycylinder {cylinder} 0.1 0.2", tmp_path / name
        )[0]
        for name, x, z in (("x", 0.1, 0.2), ("z", 0.2, 0.1))
    )
    push = -1e4 * OVERLAP
    assert_deviates("liggghts-ycylinder-order", [x_first, z_first], engine_rule=[0.0, push], law=[push, 0.0], rtol=1e-9)

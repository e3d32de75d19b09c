"""Register entries on LAMMPS' granular pairs."""

from __future__ import annotations

from math import cos, exp, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Floats, Frame
from tests.support.decks import Ball, simulate_lammps
from tests.support.deviations import assert_deviates

pytestmark = pytest.mark.lammps

RADIUS, OVERLAP, DENSITY = 0.01, 4e-4, 2500.0
NORMAL, TANGENTIAL = 1e3, 286.0
MASS = 4 / 3 * pi * RADIUS**3 * DENSITY
NEIGHBOUR_X = 2 * RADIUS - OVERLAP
SHEARED = [Ball((0.0, 0.0, 0.0), v=(0.1, 0.3, 0.0), omega=(0.0, 0.0, 5.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]


def granular(law: str) -> str:
    """`pair_style granular` with one law for all."""
    return f"pair_style granular\npair_coeff * * {law}\n"


def test_legacy_pair_turns_with_the_full_radius(tmp_path: Path) -> None:
    """Law: contact forces are internal, so torques plus x cross F sum to zero; the arm R leaves overlap times friction over."""
    run = simulate_lammps(SHEARED, "pair_style gran/hooke/history 1e4 1e4 10 20 100.0 1\npair_coeff * *\nrun 0", tmp_path)
    columns = run.frame(0).columns
    friction = columns["fy"][0]
    total = columns["tqz"].sum() + (columns["x"] * columns["fy"] - columns["y"] * columns["fx"]).sum()
    assert friction == pytest.approx(-0.5 * MASS * 20 * (0.3 + 5 * RADIUS), rel=1e-12)
    assert_deviates(
        "lammps-legacy-torque-arm", total / (NEIGHBOUR_X * abs(friction)), engine_rule=-OVERLAP / NEIGHBOUR_X, law=0.0, rtol=1e-9
    )


def energy(frame: Frame) -> float:
    """Kinetic, rotational and elastic energy, with kn = NORMAL and kt = TANGENTIAL: the force component squared over 2k."""
    c = frame.columns
    linear = c["vx"] ** 2 + c["vy"] ** 2 + c["vz"] ** 2
    spin = c["omegax"] ** 2 + c["omegay"] ** 2 + c["omegaz"] ** 2
    force, (normal, _) = frame.vectors("fx", "fy", "fz")[0], normal_and_slip(frame)
    along = float(np.dot(force, normal))
    elastic = along**2 / (2 * NORMAL) + (float(np.dot(force, force)) - along**2) / (2 * TANGENTIAL)
    return float(np.sum(0.5 * c["mass"] * linear + 0.2 * c["mass"] * c["radius"] ** 2 * spin)) + elastic


def oblique_impact(pair: str, steps: int, folder: Path) -> list[Frame]:
    """Two balls meet at 0.5 m/s each, 20 degrees off the line of centres; undamped, sticking; nine tenths of the contact."""
    vx, vy = 0.5 * cos(radians(20)), 0.5 * sin(radians(20))
    balls = [Ball((0.0, 0.0, 0.0), v=(vx, vy, 0.0)), Ball((2 * RADIUS + 1e-9, 0.0, 0.0), v=(-vx, -vy, 0.0))]
    dt = pi * sqrt(MASS / 2 / NORMAL) / steps
    return list(simulate_lammps(balls, f"{pair}fix n all nve/sphere\nrun {steps * 9 // 10}", folder, dt=dt).frames)


def test_granular_pair_loses_energy_by_its_two_arms(tmp_path: Path) -> None:
    """Law: an undamped sticking contact gives its energy back. `pair granular` loads the spring with the arm R and
    unloads it with R - overlap/2: the loss is the work of the torque times (R / (R - overlap/2) - 1), whatever the step."""
    law = granular(f"hooke {NORMAL} 0 tangential linear_history {TANGENTIAL} 0 1e4 damping mass_velocity")
    legacy = f"pair_style gran/hooke/history {NORMAL} {TANGENTIAL} 0 0 1e4 0\npair_coeff * *\n"
    coarse, fine = (oblique_impact(law, steps, tmp_path / str(steps)) for steps in (150, 300))
    one_arm = oblique_impact(legacy, 300, tmp_path / "legacy")
    dt = pi * sqrt(MASS / 2 / NORMAL) / 300
    missing = -sum(lost_power(frame) for frame in fine) * dt / energy(fine[0])
    assert gain(coarse) == pytest.approx(gain(fine), rel=0.02), "a loss by the arms does not shrink with the step"
    assert abs(gain(one_arm)) < abs(missing) / 50, "with one arm the energy comes back"
    assert_deviates("lammps-granular-two-arms", gain(fine), engine_rule=missing, law=0.0, rtol=0.02)


def gain(frames: list[Frame]) -> float:
    """Energy gained over the run, as a share of the energy at its start."""
    return energy(frames[-1]) / energy(frames[0]) - 1


def lost_power(frame: Frame) -> float:
    """What the torques would have given on top with the arm R: T.w (R / (R - overlap/2) - 1), summed over both balls."""
    c = frame.columns
    overlap = max(0.0, 2 * RADIUS - float(np.hypot(c["x"][0] - c["x"][1], c["y"][0] - c["y"][1])))
    return float(np.sum(c["tqz"] * c["omegaz"]) * (RADIUS / (RADIUS - overlap / 2) - 1))


def test_granular_turns_the_history_at_constant_length(tmp_path: Path) -> None:
    """Law of the legacy styles (and LIGGGHTS): add the increment, then project on the tangent plane. `pair granular` turns
    the old spring into the tangent plane at constant length, then adds."""
    motion = "group a type 1\ngroup c type 2\nfix k a move linear 0 0 0\nfix l c move linear 0 50.0 20.0\nrun 20"
    balls = [Ball((0.0, 0.0, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0), type=2)]
    run = simulate_lammps(
        balls, granular("hooke 1e5 0 tangential linear_history 1e3 0 1e3 damping mass_velocity") + motion, tmp_path
    )
    forces = np.array([frame.vectors("fx", "fy", "fz")[0] for frame in run.frames])
    normals, slips = zip(*(normal_and_slip(frame) for frame in run.frames), strict=True)
    tangential = forces - np.sum(forces * normals, axis=1)[:, None] * normals
    turned, projected = np.zeros(3), np.zeros(3)
    for normal, slip in zip(normals[1:], slips[1:], strict=True):
        turned = turn(turned, normal) + slip
        projected = projected + slip - np.dot(projected + slip, normal) * normal
    assert_deviates("lammps-granular-history-turn", tangential[-1], engine_rule=-1e3 * turned, law=-1e3 * projected, rtol=1e-10)


def normal_and_slip(frame: Frame) -> tuple[Floats, Floats]:
    """Unit vector from ball 2 to ball 1, and the tangential displacement of 1 against 2 in one step of 1e-6 s; no spin."""
    x, v = frame.vectors("x", "y", "z"), frame.vectors("vx", "vy", "vz")
    normal = (x[0] - x[1]) / np.linalg.norm(x[0] - x[1])
    velocity = v[0] - v[1]
    return normal, 1e-6 * (velocity - np.dot(velocity, normal) * normal)


def turn(spring: Floats, normal: Floats) -> Floats:
    """The spring turned into the plane normal to `normal`, its length kept."""
    flat = spring - np.dot(spring, normal) * normal
    length = float(np.linalg.norm(flat))
    turned: Floats = flat * float(np.linalg.norm(spring)) / (length or 1.0)
    return turned


@pytest.mark.parametrize(
    "pair",
    [
        "pair_style gran/hooke/history 1e4 1e4 10 3000 0.5 1\npair_coeff * *\n",
        granular("hooke 1e4 10 tangential linear_history 1e4 300.0 0.5 damping mass_velocity"),
    ],
    ids=["legacy", "granular"],
)
def test_no_friction_at_first_touch_beyond_the_limit(pair: str, tmp_path: Path) -> None:
    """Law (Coulomb): a sliding contact carries mu Fn. With an empty spring and damping above the limit the engine gives zero."""
    balls = [Ball((0.0, 0.0, 0.0), v=(0.0, 0.3, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    run = simulate_lammps(balls, f"{pair}run 1", tmp_path)
    ratio = [abs(frame.columns["fy"][0] / frame.columns["fx"][0]) for frame in run.frames]
    assert_deviates("lammps-no-friction-at-first-touch", ratio, engine_rule=[0.0, 0.5], law=[0.5, 0.5], rtol=1e-12)


def head_on(damping: str, restitution: float, folder: Path) -> float:
    """Restitution of two balls meeting at 1 m/s, `hertz/material` with E 1e7 Pa, nu 0.3."""
    balls = [Ball((0.0, 0.0, 0.0), v=(0.5, 0.0, 0.0)), Ball((2 * RADIUS + 1e-9, 0.0, 0.0), v=(-0.5, 0.0, 0.0))]
    modulus = 1e7 / (2 * (1 - 0.3**2))
    hertz_time = 2.87 * ((MASS / 2 / modulus) ** 2 / (RADIUS / 2)) ** 0.2
    law = granular(f"hertz/material 1e7 {restitution} 0.3 tangential linear_nohistory 0 0 damping {damping}")
    run = simulate_lammps(balls, f"{law}dump_modify d every 2000\nfix n all nve/sphere\nrun 2000", folder, dt=hertz_time / 1000)
    speed = run.frames[-1].columns["vx"]
    return float(speed[1] - speed[0])


@pytest.mark.parametrize("nominal", [0.9, 0.5])
def test_tsuji_damping_misses_the_restitution(nominal: float, tmp_path: Path) -> None:
    """Law: the balls part with e times their speed of approach. The coded prefactor lacks sqrt(2) against Tsuji's: the damping
    ratio is alpha(e) / sqrt(5). `coeff_restitution` shows that the set-up itself is right."""
    polynomial = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    ratio = sum(factor * nominal**power for power, factor in enumerate(polynomial)) / sqrt(5)
    measured = head_on("tsuji", nominal, tmp_path / "tsuji")
    assert head_on("coeff_restitution", nominal, tmp_path / "right") == pytest.approx(nominal, rel=3e-4)
    assert_deviates(
        "lammps-tsuji-restitution", measured, engine_rule=exp(-pi * ratio / sqrt(1 - ratio**2)), law=nominal, rtol=3e-4
    )

"""Register entries on LIGGGHTS' rolling friction. Without an integrator balls keep place and spin, and only the memory of the contact grows:
every step has a closed form. Friction and tangential damping are zero, so all torques are of rolling friction."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Floats
from tests.support.decks import Ball, Material, simulate_liggghts
from tests.support.deviations import assert_deviates
from tests.support.engines import EngineRun

pytestmark = pytest.mark.liggghts

RADIUS, OVERLAP, DENSITY, DT = 0.01, 4e-4, 2500.0, 1e-6
MASS = 4 / 3 * pi * RADIUS**3 * DENSITY
REFF = RADIUS / 2
NEIGHBOUR_X = 2 * RADIUS - OVERLAP
KN, KT, GAMMAN = 1e4, 3e3, 100.0
SPIN = 50.0
LOOSE = 100.0  # a coefficientRollingFriction at which no spring reaches its limit


def material(rolling_friction: float = LOOSE, *, types: int = 1, kn: float = KN, kt: float = KT, gamman: float = 0.0) -> Material:
    """Constants of the stiffness models; the dashpot of epsd is zero."""
    constants = {"kn": kn, "kt": kt, "gamman": gamman, "gammat": 0.0, "coefficientFriction": 0.0}
    return Material(types, constants | {"coefficientRollingFriction": rolling_friction, "coefficientRollingViscousDamping": 0.0})


def pair(
    balls: list[Ball], constants: Material, rolling: str, steps: int, folder: Path, *, model: str = "hooke/stiffness", more: str = ""
) -> EngineRun:
    """Balls in steady motion, of model hooke/stiffness or hertz/stiffness; `more`: fixes."""
    body = f"pair_style gran model {model} tangential off rolling_friction {rolling}\npair_coeff * *\n{more}\nrun {steps}"
    return simulate_liggghts(balls, constants, body, folder)


def torque(run: EngineRun, step: int) -> Floats:
    """Torque (3,) on the first ball."""
    return np.asarray(run.frame(step).vectors("tqx", "tqy", "tqz")[0])


def test_cdt_takes_the_elastic_force(tmp_path: Path) -> None:
    """Law (Ai et al. 2011, model A): the torque is rolling_friction R* Fn. Here Fn is kn overlap, while damping makes the normal force another."""
    speed = 1.0
    balls = [Ball((0.0, 0.0, 0.0), v=(speed, 0.0, 0.0), omega=(0.0, SPIN, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    run = pair(balls, material(0.1, gamman=GAMMAN), "cdt", 0, tmp_path)
    normal = abs(run.frame(0).columns["fx"][0])
    assert normal == pytest.approx(KN * OVERLAP + 0.5 * MASS * GAMMAN * speed)
    elastic, whole = (-0.1 * REFF * force for force in (KN * OVERLAP, normal))
    assert_deviates("liggghts-cdt-elastic-force", torque(run, 0)[1], engine_rule=elastic, law=whole, rtol=1e-10)


def test_cdt_is_weaker_where_balls_twist(tmp_path: Path) -> None:
    """Law: rolling resistance has the size rolling_friction R* Fn whatever the twist. Here it is the smaller, the more the balls twist."""
    balls = [Ball((0.0, 0.0, 0.0), omega=(3.0 * SPIN, SPIN, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    run = pair(balls, material(0.1), "cdt", 0, tmp_path)
    law = -0.1 * REFF * KN * OVERLAP
    assert_deviates("liggghts-cdt-twist", torque(run, 0)[1], engine_rule=law / sqrt(10.0), law=law, rtol=1e-10)


def test_cdt_never_comes_to_rest(tmp_path: Path) -> None:
    """Law: friction stops a spin, and is zero then. Here the torque turns round at every step once the spin is braked."""
    moment, inertia, weight = 1e-4, 0.4 * MASS * RADIUS**2, MASS * 9.81
    rolling_friction, spin = moment / (RADIUS * weight), 3.3 * moment / inertia * DT
    model = "model hooke/stiffness tangential off rolling_friction cdt"
    lines = (f"pair_style gran {model}", "pair_coeff * *", f"fix w all wall/gran {model} primitive type 1 zplane 0.0")
    body = "\n".join((*lines, "fix g all gravity 9.81 vector 0 0 -1", "fix n all nve/sphere", "run 9"))
    run = simulate_liggghts([Ball((0.0, 0.0, RADIUS - weight / KN), omega=(0.0, spin, 0.0))], material(rolling_friction), body, tmp_path)
    last = np.array([torque(run, step)[1] for step in range(5, 10)]) * (-1.0) ** np.arange(5)
    assert_deviates("liggghts-cdt-chatter", last * np.sign(last[0]), engine_rule=[moment] * 5, law=[0.0] * 5, rtol=1e-9)


@pytest.mark.parametrize(("rolling", "stiffness"), [("epsd", 2.25 * KN * LOOSE**2 * REFF**2), ("epsd2", KT * REFF**2)])
def test_set_up_winds_the_spring_of_the_torque_only(rolling: str, stiffness: float, tmp_path: Path) -> None:
    """Law: a run begins with springs as they are: a new contact has none. Here its first torque holds a step of winding, and the spring
    of the second step is no longer for that."""
    balls = [Ball((0.0, 0.0, 0.0), omega=(0.0, SPIN, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0))]
    run = pair(balls, material(), rolling, 1, tmp_path)
    step = -stiffness * DT * SPIN
    measured = [torque(run, k)[1] for k in (0, 1)]
    assert_deviates("liggghts-rolling-set-up", measured, engine_rule=[step, step], law=[0.0, step], rtol=1e-10)


def winding(normals: Floats, stiffness: Floats) -> Floats:
    """Torque (3,) of the spring after the steps with these normals (s, 3) and stiffnesses (s,), turned by the spin SPIN about y."""
    spin = np.array([0.0, SPIN, 0.0])
    rolled = spin - (normals @ spin)[:, None] * normals
    return np.asarray(-np.sum(DT * stiffness[:, None] * rolled, axis=0))


def test_the_spring_does_not_turn_with_the_contact(tmp_path: Path) -> None:
    """Law: rolling resistance acts in the tangent plane. Here the spring keeps its direction in space as a ball passes, and comes to twist."""
    speed, steps = 10.0, 200
    balls = [Ball((0.0, 0.0, 0.0), omega=(0.0, SPIN, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0), type=2)]
    more = f"group c type 2\nfix c c move linear 0 {speed} 0 units box"
    run = pair(balls, material(types=2), "epsd2", steps, tmp_path, more=more)
    away = np.array([(-NEIGHBOUR_X, -speed * DT * k, 0.0) for k in range(1, steps + 1)])
    normals = away / np.linalg.norm(away, axis=1)[:, None]
    twist = winding(normals, np.full(steps, KT * REFF**2)) @ normals[-1]
    assert_deviates("liggghts-rolling-spring-fixed", torque(run, steps) @ normals[-1], engine_rule=twist, law=0.0, rtol=1e-9)


def test_the_spring_keeps_its_torque_as_the_contact_softens(tmp_path: Path) -> None:
    """Law: the torque of a spring is its stiffness times its angle. Here it stays as the stiffness falls with the overlap (hertz): the spring
    then holds more energy than was put in."""
    speed, steps, kt = 1.0, 200, 1e6
    balls = [Ball((0.0, 0.0, 0.0), omega=(0.0, SPIN, 0.0)), Ball((NEIGHBOUR_X, 0.0, 0.0), type=2)]
    more = f"group c type 2\nfix c c move linear {speed} 0 0 units box"
    run = pair(balls, material(types=2, kn=1e7, kt=kt), "epsd2", steps, tmp_path, model="hertz/stiffness", more=more)
    stiffness = kt * np.sqrt(REFF * (OVERLAP - speed * DT * np.arange(1, steps + 1))) * REFF**2
    kept = winding(np.tile([-1.0, 0.0, 0.0], (steps, 1)), stiffness)[1]
    law = -stiffness[-1] * steps * DT * SPIN
    assert_deviates("liggghts-rolling-torque-kept", torque(run, steps)[1], engine_rule=kept, law=law, rtol=1e-9)


def test_walls_see_more_spin(tmp_path: Path) -> None:
    """Law: a ball at a wall rolls with its own spin. Here with that times (R - overlap/2)/(R - overlap)."""
    model = "model hooke/stiffness tangential off rolling_friction epsd2"
    body = f"pair_style gran {model}\npair_coeff * *\nfix w all wall/gran {model} primitive type 1 zplane 0.0\nrun 0"
    run = simulate_liggghts([Ball((0.0, 0.0, RADIUS - OVERLAP), omega=(0.0, SPIN, 0.0))], material(), body, tmp_path)
    law = -KT * RADIUS**2 * DT * SPIN
    ratio = (RADIUS - OVERLAP / 2) / (RADIUS - OVERLAP)
    assert_deviates("liggghts-rolling-wall-arm", torque(run, 0)[1], engine_rule=ratio * law, law=law, rtol=1e-10)


def touch_twice(neighbours: str, folder: Path) -> float:
    """A spinning ball swings in and out of a second one: two contacts of half a period each. Returns the largest torque of the second
    contact over that of the first."""
    period, swing = 100 * DT, 3e-5
    balls = [Ball((0.0, 0.0, 0.0)), Ball((2 * RADIUS + 1e-5, 0.0, 0.0), omega=(0.0, SPIN, 0.0), type=2)]
    more = f"{neighbours}\ngroup a type 1\nfix k a move wiggle {swing} 0 0 {period!r} units box"
    run = pair(balls, material(types=2), "epsd2", 200, folder, more=more)
    size = np.array([abs(frame.columns["tqy"][0]) for frame in run.frames])
    return float(size[100:].max() / size[:100].max())


def test_the_spring_survives_separation(tmp_path: Path) -> None:
    """Law: a contact that ends forgets its spring. Here the next one goes on from where it stopped, until the list is rebuilt; with
    contact_distance_factor 1.1 it forgets."""
    lawful = touch_twice("neigh_modify contact_distance_factor 1.1", tmp_path / "lawful")
    assert lawful == pytest.approx(1.0, rel=0.01)
    measured = touch_twice("", tmp_path / "default")
    assert_deviates("liggghts-rolling-history-kept", measured, engine_rule=2.0, law=1.0, rtol=0.01)

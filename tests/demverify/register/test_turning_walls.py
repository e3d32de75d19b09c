"""Register entries on cylinders that turn. A ball at rest, or spinning, touches the wall at its bottom; without an integrator it keeps its place, and
viscous friction measures the velocity of the surface against that of a wall that slides along its axis."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

from demverify.frames import Floats
from tests.support.decks import Ball, Material, simulate_lammps, simulate_liggghts
from tests.support.deviations import assert_deviates

RADIUS, RC, OVERLAP, SPEED = 0.01, 0.03, 1e-4, 0.7
MASS = 4 / 3 * pi * RADIUS**3 * 2500.0
DEEP = RC - RADIUS + OVERLAP  # from the axis to the centre of the ball
RATE = SPEED / RC
LAW = "granular hooke 1e5 10 damping velocity tangential linear_nohistory 1 1e3"
SPIN = (0.0, 0.0, RATE)


def lammps(wall: str, folder: Path, ball: Ball | None = None, *, law: str = LAW, region: str = "") -> tuple[Floats, Floats]:
    """Force (2, 3) and torque (2, 3) on one ball at the steps 0 and 1."""
    fix = "wall/gran/region" if region else "wall/gran"
    body = f"pair_style none\nvariable th equal step*dt*{RATE}\n{region}\nfix w all {fix} {law} {wall}\nrun 1"
    frames = simulate_lammps([ball or Ball((0.0, -DEEP, 0.0))], body, folder).frames
    return np.array([f.vectors("fx", "fy", "fz")[0] for f in frames]), np.array([f.vectors("tqx", "tqy", "tqz")[0] for f in frames])


def turning(axis: str = "0 0 1") -> str:
    """The region of a cylinder that turns."""
    return f"region drum cylinder z 0 0 {RC} INF INF units box rotate v_th 0 0 0 {axis}"


def liggghts(wall: str, folder: Path, ball: Ball, *, rolling: str = "", mu: float = 1e3) -> tuple[Floats, Floats]:
    """Force (3,) and torque (3,) on one ball in the first force of a run."""
    material = Material(
        1, {"kn": 1e5, "kt": 1e4, "gamman": 10.0, "gammat": 20.0, "coefficientFriction": mu, "coefficientRollingFriction": 0.1}
    )
    model = f"hooke/stiffness tangential no_history {rolling}"
    body = f"pair_style gran model {model}\npair_coeff * *\nfix w all wall/gran model {model} primitive type 1 {wall}\nrun 0"
    frame = simulate_liggghts([ball], material, body, folder).frame(0)
    return frame.vectors("fx", "fy", "fz")[0], frame.vectors("tqx", "tqy", "tqz")[0]


@pytest.mark.lammps
def test_shear_across_a_cylinder_does_not_turn_it(tmp_path: Path) -> None:
    """Law: a cylinder that turns drags a ball on its bottom and one on its top with the same speed, in opposite ways. The engine adds V to the
    turning V: nothing at the bottom, 2 V at the top."""
    along = lammps(f"zcylinder {RC} shear z {SPEED}", tmp_path / "along")[0][0, 2]
    bottom, top = (lammps(f"zcylinder {RC} shear x {SPEED}", tmp_path / f"{y}", Ball((0.0, y, 0.0)))[0][0, 0] / along for y in (-DEEP, DEEP))
    assert_deviates("lammps-cylinder-shear", [bottom, top], engine_rule=[0.0, 2.0], law=[-1.0, 1.0], rtol=1e-10)


@pytest.mark.lammps
def test_the_length_of_the_axis_of_a_region_counts(tmp_path: Path) -> None:
    """Law: an axis is a direction, whatever its length. The engine multiplies the velocity of the surface by it."""
    one, two = (lammps("region drum", tmp_path / axis[-1], region=turning(axis))[0][1, 0] for axis in ("0 0 1", "0 0 2"))
    assert one > 0.0
    assert_deviates("lammps-region-axis-length", two / one, engine_rule=2.0, law=1.0, rtol=1e-9)


@pytest.mark.lammps
def test_a_turning_region_is_still_at_setup(tmp_path: Path) -> None:
    """Law: the surface has the velocity W Rc from the first force on. The engine has none in the set-up of a run: it takes angles of two steps."""
    along = lammps(f"zcylinder {RC} shear z {SPEED}", tmp_path / "along")[0][0, 2]
    force = lammps("region drum", tmp_path / "turning", region=turning())[0][:, 0] / along
    assert_deviates("lammps-turning-region-setup", force, engine_rule=[0.0, 1.0], law=[1.0, 1.0], rtol=1e-9)


@pytest.mark.liggghts
def test_the_velocity_of_a_turning_cylinder_is_that_at_the_centre(tmp_path: Path) -> None:
    """Law: the surface moves with W Rc. The engine takes W times the distance of the ball's centre from the axis."""
    ball = Ball((0.0, -DEEP, 0.0))
    along = liggghts(f"zcylinder {RC} 0 0 shear z {SPEED}", tmp_path / "along", ball)[0][2]
    force = liggghts(f"zcylinder {RC} 0 0 shear x {RATE}", tmp_path / "turning", ball)[0][0] / along
    assert_deviates("liggghts-turning-cylinder-center", force, engine_rule=DEEP / RC, law=1.0, rtol=1e-9)


@pytest.mark.liggghts
def test_a_ycylinder_is_strained(tmp_path: Path) -> None:
    """Law: a wall that turns with W about y has the velocity W (z, 0, -x), which drags a ball at z = -r along x. In the engine it has W (x, 0, -z):
    a ball there is pushed off, and one at 45 degrees is dragged as by a wall that turns."""
    places = [Ball((0.0, 0.0, -DEEP)), Ball((DEEP, 0.0, 0.0))]
    force = [liggghts(f"ycylinder {RC} 0 0 shear x {RATE}", tmp_path / f"{k}", ball)[0][[0, 2]] for k, ball in enumerate(places)]
    push, c, way = 1e5 * OVERLAP, MASS * np.array([10.0, 20.0]), RATE * DEEP  # gamman along the normal, gammat across it
    engine = [[0.0, push + c[0] * way], [-push + c[0] * way, 0.0]]
    law = [[-c[1] * way, push], [-push, -c[1] * way]]
    assert_deviates("liggghts-ycylinder-shear", force, engine_rule=engine, law=law, rtol=1e-9)


@pytest.mark.parametrize("engine", [pytest.param("lammps", marks=pytest.mark.lammps), pytest.param("liggghts", marks=pytest.mark.liggghts)])
def test_rolling_resistance_does_not_know_the_spin_of_the_wall(engine: str, tmp_path: Path) -> None:
    """Law: a ball that spins with the wall does not roll on it, and meets no rolling resistance. Both engines resist its own spin, as if the wall
    were still. Without friction, so that nothing else turns the ball."""
    ball = Ball((0.0, -DEEP, 0.0), omega=SPIN)
    if engine == "lammps":
        law = "granular hooke 1e5 10 damping velocity tangential linear_nohistory 0 0 rolling sds 1e3 10 0.5"
        regions = (turning(), turning().partition(" rotate")[0])
        moving, still = (lammps("region drum", tmp_path / f"{k}", ball, law=law, region=r)[1][1, 2] for k, r in enumerate(regions))
    else:
        shear = (f"shear x {RATE}", "")
        moving, still = (
            liggghts(f"zcylinder {RC} 0 0 {s}", tmp_path / f"{k}", ball, rolling="rolling_friction cdt", mu=0.0)[1][2] for k, s in enumerate(shear)
        )
    assert still < 0.0
    assert_deviates("both-rolling-on-turning-wall", moving / still, engine_rule=1.0, law=0.0, rtol=1e-2)

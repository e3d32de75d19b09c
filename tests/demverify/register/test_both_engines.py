"""Register entries that LAMMPS and LIGGGHTS share: what a closed form, a textbook solver or a post-processor will stumble on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import atan2, exp, log, pi, sqrt
from pathlib import Path

import pytest

from demverify.frames import Frame
from tests.support.decks import Ball, Material, simulate_lammps, simulate_liggghts
from tests.support.deviations import assert_deviates
from tests.support.engines import EngineRun

RADIUS, DENSITY, DT = 0.01, 2500.0, 1e-6
MASS = 4 / 3 * pi * RADIUS**3 * DENSITY
KN, GAMMA = 1e5, 2000.0
DAMPING = MASS / 2 * GAMMA
Runner = Callable[..., EngineRun]


def lammps_pair(
    body: str, balls: Sequence[Ball], folder: Path, *, gamma: float = GAMMA, switch: str = "", dt: float = DT
) -> EngineRun:
    """`pair granular` hooke, damped by gamma m* vn, run with LAMMPS."""
    law = f"hooke {KN} {gamma!r} tangential linear_nohistory 0 0 damping mass_velocity {switch and 'limit_damping'}"
    return simulate_lammps(balls, f"pair_style granular\npair_coeff * * {law}\nfix n all nve/sphere\n{body}", folder, dt=dt)


def liggghts_pair(
    body: str, balls: Sequence[Ball], folder: Path, *, gamma: float = GAMMA, switch: str = "", dt: float = DT
) -> EngineRun:
    """The same contact in LIGGGHTS: hooke/stiffness."""
    material = Material(1, {"kn": KN, "kt": KN, "gamman": gamma, "gammat": 0.0, "coefficientFriction": 0.0})
    law = f"hooke/stiffness {switch and 'limitForce on'}"
    return simulate_liggghts(
        balls, material, f"pair_style gran model {law}\npair_coeff * *\nfix n all nve/sphere\n{body}", folder, dt=dt
    )


both_engines = pytest.mark.parametrize(
    "pair",
    [
        pytest.param(lammps_pair, id="lammps", marks=pytest.mark.lammps),
        pytest.param(liggghts_pair, id="liggghts", marks=pytest.mark.liggghts),
    ],
)


def meeting(speed: float = 0.5, overlap: float = 1e-5) -> list[Ball]:
    """Two balls on the x axis, each at `speed` towards the other (away, when negative)."""
    return [Ball((0.0, 0.0, 0.0), v=(speed, 0.0, 0.0)), Ball((2 * RADIUS - overlap, 0.0, 0.0), v=(-speed, 0.0, 0.0))]


def contact(frame: Frame) -> tuple[float, float, float]:
    """Force on ball 1 along x, overlap, and speed of approach, of a dumped state."""
    c = frame.columns
    return float(c["fx"][0]), float(2 * RADIUS - (c["x"][1] - c["x"][0])), float(c["vx"][0] - c["vx"][1])


@both_engines
def test_dumped_force_belongs_to_the_half_step_velocity(pair: Runner, tmp_path: Path) -> None:
    """Law: force, position and velocity of one frame belong together. The damping of a dumped force is that of v - (dt/2) F/m."""
    force, overlap, approach = contact(pair("run 5", meeting(), tmp_path).frame(5))
    half_step = approach - DT * force / MASS
    assert_deviates(
        "both-half-step-velocity",
        force,
        engine_rule=-(KN * overlap + DAMPING * half_step),
        law=-(KN * overlap + DAMPING * approach),
        rtol=1e-10,
    )


@both_engines
def test_a_new_run_changes_the_force_of_its_first_step(pair: Runner, tmp_path: Path) -> None:
    """Law: `run 5; run 5` is `run 10`. Each run computes its first force anew, with the full-step velocity: each ball's velocity
    shifts by (dt/2) times the change of the damping force over m, and is damped from there on, by less than 2 percent here."""
    whole, cut = (pair(body, meeting(), tmp_path / body.replace("\n", "-")) for body in ("run 10", "run 5\nrun 5"))
    force, overlap, approach = contact(whole.frame(5))
    shift = DT / 2 * (-(KN * overlap + DAMPING * approach) - force) / MASS
    measured = cut.frames[-1].columns["vx"][0] - whole.frames[-1].columns["vx"][0]
    assert cut.frames[-1].step == 10
    assert_deviates("both-new-run-new-force", measured / shift, engine_rule=1.0, law=0.0, rtol=0.02)


@both_engines
def test_damped_contacts_pull_at_their_end(pair: Runner, tmp_path: Path) -> None:
    """Law: dry grains do not attract each other. Near zero overlap, balls that part pull with gamma vn - kn overlap."""
    force, overlap, approach = contact(pair("run 0", meeting(speed=-0.5), tmp_path).frame(0))
    pull = -(KN * overlap + DAMPING * approach)
    assert pull > 0
    assert_deviates("both-attractive-tail", force, engine_rule=pull, law=0.0, rtol=1e-10)


@both_engines
def test_limited_damping_raises_the_restitution(pair: Runner, tmp_path: Path) -> None:
    """Law: a damping ratio b = -ln e / sqrt(pi^2 + ln^2 e) gives the restitution e. With pulling cut off it is
    exp(-b/s (pi - atan2(2 b s, 1 - 2 b^2))), s = sqrt(1 - b^2): Schwager and Poeschel 2007, doi:10.1007/s10035-007-0065-z."""
    nominal = 0.5
    ratio = -log(nominal) / sqrt(pi**2 + log(nominal) ** 2)
    root = sqrt(1 - ratio**2)
    dt = pi / (root * sqrt(KN / (MASS / 2))) / 1000
    body = "dump_modify d every 1020\nrun 1020"
    run = pair(body, meeting(overlap=-1e-9), tmp_path, gamma=2 * ratio * sqrt(KN * MASS / 2) / (MASS / 2), switch="on", dt=dt)
    limited = exp(-ratio / root * (pi - atan2(2 * ratio * root, 1 - 2 * ratio**2)))
    parted = run.frames[-1].columns["vx"]
    assert_deviates("both-limited-damping-restitution", parted[1] - parted[0], engine_rule=limited, law=nominal, rtol=1e-3)


@pytest.mark.parametrize(
    "simulate",
    [
        pytest.param(
            lambda balls, body, folder: simulate_lammps(balls, f"pair_style none\n{body} disc\nrun 0", folder, dimension=2),
            id="lammps",
            marks=pytest.mark.lammps,
        ),
        pytest.param(
            lambda balls, body, folder: simulate_liggghts(
                balls,
                Material(1, {"kn": KN, "kt": KN, "gamman": 0.0, "gammat": 0.0, "coefficientFriction": 0.0}),
                f"pair_style gran model hooke/stiffness\npair_coeff * *\n{body}\nrun 0",
                folder,
                dimension=2,
            ),
            id="liggghts",
            marks=pytest.mark.liggghts,
        ),
    ],
)
def test_erotate_sphere_takes_discs_for_spheres(simulate: Runner, tmp_path: Path) -> None:
    """Law: a disc, which the integrator turns with I = 1/2 m R^2, has the energy 1/4 m R^2 w^2; the compute has 1/5 m R^2 w^2."""
    spin = 3.0
    output = "thermo_style custom step c_e\nthermo_modify norm no format float %.16g"
    body = f"compute e all erotate/sphere\n{output}\nfix n all nve/sphere"
    run = simulate([Ball((0.0, 0.0, 0.0), omega=(0.0, 0.0, spin))], body, tmp_path)
    scale = run.frame(0).columns["mass"][0] * RADIUS**2 * spin**2
    assert_deviates("both-erotate-sphere-discs", run.thermo[0].values[0, 1] / scale, engine_rule=0.2, law=0.25, rtol=1e-10)


@both_engines
def test_dumps_have_six_digits_unless_told(pair: Runner, tmp_path: Path) -> None:
    """Law: a dump holds the state. Without `dump_modify format` floats are written with %g: six digits."""
    balls = [Ball((0.123456789, 0.0, 0.0))]
    run = pair("undump d\ndump s all custom 1 short.dump id x\nrun 0", balls, tmp_path)
    position = next(frame for frame in run.frames if "radius" not in frame.columns).columns["x"][0]
    assert_deviates("both-dump-six-digits", position, engine_rule=0.123457, law=0.123456789, rtol=1e-9)

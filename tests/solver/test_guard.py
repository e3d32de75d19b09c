"""The guard: what goes wrong is said, before or when it happens, by its kind, with who and when; what goes well is not disturbed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, ContactLaw, EulerSphere, Gravity, Neighbor, NveSphere, Plane, Scene, SetForce, Simulation, Slab, Unstable, Wall
from demsolver.guard import DEEPEST, FARTHEST
from demverify.stability.held import KN, MASS, RADIUS, linear, on_floor
from tests.support.scenes import bed, spheres

SPRING = linear((1, 1), mu=0.0)
FLOOR = linear((1,), mu=0.0)
STEP = 1e-5  # the half period of a contact is pi sqrt(MASS/2 KN) = 8e-4


def meeting(speed: float, dt: float = STEP, *, ratio: float = 1.0, gap: float = 0.3, drift: float = 0.0, law: ContactLaw = SPRING) -> Scene:
    """Two spheres closing in head on with `speed`, the second of `ratio` times the radius, `gap` radii apart, both drifting along y."""
    radius = np.array([RADIUS, ratio * RADIUS])
    x = np.array([[0.0, 0.0, 0.0], [radius.sum() + gap * RADIUS, 0.0, 0.0]])
    p = spheres(x, radius, v=np.array([[0.5 * speed, drift, 0.0], [-0.5 * speed, drift, 0.0]]))
    return Scene(Box(np.full(3, -1.0), np.full(3, 1.0)), p, 1, dt, pair=law, integrate=(NveSphere(),), neighbor=Neighbor(0.5 * RADIUS))


def message_of(scene: Scene, steps: int) -> str:
    """What stops the run, or nothing."""
    try:
        simulation = Simulation(scene)
        simulation.setup()
        simulation.advance(steps)
    except Unstable as error:
        return str(error)
    return ""


@pytest.mark.parametrize("make", [lambda: bed(1e-5), lambda: meeting(1.0)])
def test_a_guarded_run_has_the_bits_of_one_without(make) -> None:  # type: ignore[no-untyped-def]
    """Law: the guard changes no number."""
    runs = []
    for mode in ("off", "stop", "warn"):
        simulation = Simulation(make(), on_instability=mode)  # type: ignore[arg-type]
        simulation.setup()
        simulation.advance(777)
        runs.append(simulation.bodies)
    for one in runs[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(runs[0], one, strict=True))


def test_too_fast_is_said_with_the_particle_and_a_step_that_would_do() -> None:
    """Law: more than half its radius in a step stops the run before any harm, and the step that is advised runs."""
    scene = replace(meeting(2.2 * FARTHEST * RADIUS / STEP, gap=40.0), pair=linear((1, 1), mu=0.0))
    said = message_of(scene, 5)
    assert said.startswith("particle 1 moves 0.55 of its radius in step 0 (limit 0.5)")
    advised = float(said.split("shorten the timestep ")[1].split(" to ")[1].split(",")[0])
    assert message_of(replace(scene, timestep=advised), 5) == ""


@pytest.mark.parametrize("part", [0.55, 1.0, 3.7, 40.0, 1000.0])
def test_nobody_tunnels_unseen(part: float) -> None:
    """Law: two that would change places between steps, or a ball and a floor, never do so silently, however fast."""
    fast = part * RADIUS / STEP
    assert message_of(meeting(2.0 * fast, gap=7.3), 40)
    ball = on_floor(STEP, FLOOR, along=-fast, overlap=-7.3 * RADIUS, pull=0.0)
    assert message_of(ball, 40)
    assert message_of(replace(ball, integrate=(EulerSphere(),)), 40)


@pytest.mark.parametrize("part", [0.45, 0.55])
def test_speed_counts_in_radii_of_the_one_that_moves(part: float) -> None:
    """Law: a small sphere may move half of its own radius in a step, whatever the size of what it meets."""
    scene = replace(meeting(0.0, ratio=0.01, gap=0.5), walls=(Wall("floor", Slab(2, lo=-0.9), FLOOR),))
    scene.particles.v[1, 0] = -part * 0.01 * RADIUS / STEP
    assert message_of(scene, 0).startswith("particle 2 moves 0.55 of its radius") == (part > FARTHEST)


def test_a_drift_of_all_is_no_speed() -> None:
    """Law: without walls only speeds against each other count (Galilei): 5 radii a step of common drift are nothing, with a wall they are."""
    drift = 5.0 * RADIUS / STEP
    assert message_of(meeting(0.5, drift=drift), 100) == ""
    floor = Wall("floor", Slab(2, lo=-0.9), FLOOR)
    assert "moves 5 of its radius" in message_of(replace(meeting(0.5, drift=drift), walls=(floor,)), 100)


@pytest.mark.parametrize("part", [0.49, 0.51])
def test_too_deep_is_said_at_set_up(part: float) -> None:
    """Law: an overlap of more than half the smaller radius stops the run at once, and names both."""
    said = message_of(meeting(0.0, gap=-part, ratio=3.0), 0)
    assert said.startswith("particles 1 and 2 overlap by 0.51 of the smaller radius in step 0 (limit 0.5)") == (part > DEEPEST)


def test_two_particles_at_one_point_are_said() -> None:
    """Law: no direction to part in is an overlap of 2 of the radius, not NaN."""
    scene = meeting(0.0, gap=-2.0)
    assert message_of(scene, 0).startswith("particles 1 and 2 overlap by 2 of the smaller radius in step 0")


def test_too_deep_at_a_wall_names_the_wall() -> None:
    """Law: the same at walls."""
    assert message_of(on_floor(1e-6, FLOOR, overlap=0.6 * RADIUS), 0).startswith("particle 1 and wall floor overlap by 0.6 of the smaller radius")


def test_a_deep_impact_is_said_in_the_step_that_makes_it() -> None:
    """Law: a soft contact driven beyond half a radius stops in the step after, where the closed form v/omega sin(omega t) is there."""
    omega = np.sqrt(2.0 * KN / MASS)
    speed = 0.6 * RADIUS * omega  # would reach 0.6 radii at a quarter period
    scene = replace(meeting(speed, gap=1e-9), timestep=1e-3 / omega)
    said = message_of(scene, 2000)
    step = int(said.split(" in step ")[1].split(" ")[0])
    reached = np.arcsin(0.5 / 0.6) / 1e-3
    assert step == pytest.approx(reached, abs=3)


def test_a_deep_impact_is_said_though_the_list_is_due_in_every_step() -> None:
    """Law: so it is where the skin is so thin that each step begins with a new list, at a wall and between two; and a speed likewise."""
    for scene in (on_floor(STEP, FLOOR, along=-0.1 * RADIUS / STEP, overlap=-0.25 * RADIUS, pull=0.0), meeting(0.1 * RADIUS / STEP, gap=0.25)):
        said = message_of(replace(scene, neighbor=Neighbor(0.0)), 500)
        assert int(said.split(" in step ")[1].split(" ")[0]) <= 9
        assert "overlap by 0.6" in said
    floor = Wall("floor", Slab(2, lo=-0.9), FLOOR)
    falling = replace(meeting(0.0), neighbor=Neighbor(0.0), walls=(floor,), forces=(Gravity((0.0, 0.0, -2e-3 * RADIUS / STEP**2)),))
    assert message_of(falling, 500).startswith("particle 1 moves 0.50")


def test_growth_of_energy_is_said() -> None:
    """Law: a step a little above the limit of a contact grows from rounding and is stopped, long before anything is infinite: for its energy where
    that is looked at often, else for its speed."""
    scene = on_floor(1.001 * 2.0 * np.sqrt(MASS / KN), FLOOR, along=1e-9)
    simulation = Simulation(scene)
    simulation.setup()
    with pytest.raises(Unstable, match=r"the energy grew by .* the fastest is particle 1"):
        for _ in range(100):
            simulation.advance(10)
            simulation.look()
    assert simulation.step < 500
    assert message_of(scene, 100_000).startswith("particle 1 moves")


@pytest.mark.parametrize("drive", ["wall", "force", "conveyor"])
def test_a_driven_scene_may_gain_energy(drive: str) -> None:
    """Law: where motion is prescribed energy may grow; nobody is accused."""
    scene = on_floor(1e-5, linear((1,), gamman=1000.0, mu=0.5, kt=KN, xt=0.5))
    scene = replace(scene, box=replace(scene.box, boundary=("ss", "ss", "ss")))
    if drive == "wall":
        plane = Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, 0.0, 0.5))
        scene = replace(scene, walls=(replace(scene.walls[0], shape=plane),))
    elif drive == "force":
        scene = replace(scene, forces=(*scene.forces, SetForce((1e-2, None, None))))
    else:
        scene = replace(scene, walls=(replace(scene.walls[0], velocity=(1.0, 0.0, 0.0)),))
    assert message_of(scene, 60_000) == ""


def test_falling_bouncing_and_settling_are_no_growth() -> None:
    """Law: energy that gravity gives comes from somewhere: nothing is said of a ball that falls, bounces without loss or comes to rest."""
    for gamman in (0.0, 50.0, 2000.0):
        ball = on_floor(1e-5, linear((1,), gamman=gamman, mu=0.0), overlap=-3.0 * RADIUS, pull=9.81)
        assert message_of(ball, 300_000) == ""


@pytest.mark.parametrize("part", [0.05, 0.2, 0.3])
def test_a_coarse_fall_from_rest_is_no_growth(part: float) -> None:
    """Law: where all energy there was is one of height, what an impact gets wrong is measured against what the fall has given since."""
    dt = part * np.pi * np.sqrt(MASS / KN)
    assert message_of(on_floor(dt, FLOOR, overlap=-10.0 * RADIUS, pull=9.81), 3000) == ""


def test_warn_goes_on_and_says_each_kind_once() -> None:
    """Law: with "warn" the run goes on, and each kind of trouble is told once."""
    told: list[str] = []
    scene = replace(meeting(2.4 * FARTHEST * RADIUS / STEP, gap=1.0), pair=linear((1, 1), mu=0.0))
    simulation = Simulation(scene, on_instability="warn", tell=told.append)
    simulation.setup()
    simulation.advance(50)
    assert simulation.step == 50
    assert [line.split()[0] for line in told] == ["particle", "particles"]


def test_the_last_good_state_is_kept() -> None:
    """Law: what is kept is the state at the last look before the trouble, bit for bit that of a run to that step."""
    scene = on_floor(1.0001 * 2.0 * np.sqrt(MASS / KN), FLOOR, along=1e-9)
    simulation = Simulation(scene)
    simulation.setup()
    with pytest.raises(Unstable):
        simulation.advance(100_000_000)
    good = simulation.last_good
    assert good is not None
    again = Simulation(scene, on_instability="off")
    again.setup()
    again.advance(good.step)
    assert np.array_equal(again.bodies.x, good.x)
    assert np.array_equal(again.bodies.v, good.v)


def test_nobody_to_meet_is_not_watched() -> None:
    """Law: a single particle without walls can meet nobody, and flies as fast as it likes."""
    bullet = spheres(np.zeros((1, 3)), np.array([RADIUS]), v=np.array([[100 * RADIUS / STEP, 0.0, 0.0]]))
    box = Box(np.full(3, -1.0), np.full(3, 1.0), ("ss", "ss", "ss"))
    assert message_of(replace(meeting(0.0), particles=bullet, box=box, forces=(Gravity((0.0, 0.0, -9.81)),)), 300) == ""


@pytest.mark.parametrize("shape", [Slab(2, lo=0.0), Plane((0.0, 0.0, 1.0), 0.0)])
def test_a_centre_in_the_plane_of_a_wall_is_said(shape: Slab | Plane) -> None:
    """Law: where a wall has no normal a sphere is as deep in it as its radius, at set-up and wherever a step leads there."""
    scene = on_floor(1e-6, FLOOR, overlap=RADIUS)
    scene = replace(scene, walls=(replace(scene.walls[0], shape=shape),))
    assert message_of(scene, 0).startswith("particle 1 and wall floor overlap by 1 of the smaller radius in step 0")
    exact = 0.5 * RADIUS / 2.0**-20  # from R to R/2, whose overlap is not yet too deep, to 0
    soft = replace(FLOOR, coefficients={**FLOOR.coefficients, "kn": np.full(1, 1e-30)})
    landing = on_floor(2.0**-20, soft, overlap=0.0, along=-exact, pull=0.0)
    assert "overlap by 1 of the smaller radius in step 2" in message_of(replace(landing, walls=(Wall("floor", shape, soft),)), 2)


@pytest.mark.parametrize(("far", "fine"), [(1e9, True), (1e12, False)])
def test_positions_too_coarse_are_said(far: float, fine: bool) -> None:
    """Law: where the numbers beside a position are more than a thousandth of the radius apart, contacts are rounded away."""
    x = np.array([[far, 0.0, 0.0], [far + 3.0 * RADIUS, 0.0, 0.0]])
    box = Box(np.array([far - 1.0, -1.0, -1.0]), np.array([far + 1.0, 1.0, 1.0]))
    scene = replace(meeting(0.1), particles=spheres(x, np.full(2, RADIUS)), box=box)
    assert (np.spacing(far) < 1e-3 * RADIUS) == fine
    assert message_of(scene, 1).startswith("so far from the origin positions are no finer than") != fine


def test_the_end_of_a_run_can_be_looked_at() -> None:
    """Law: `look` does not wait until it is time: energy that a short run has gained is said."""
    scene = meeting(0.05, 3.2 * np.sqrt(0.5 * MASS / KN), gap=0.0005)
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(3)
    with pytest.raises(Unstable, match="the energy grew by"):
        simulation.look()


def test_a_burst_that_leaves_the_box_is_said_where_lost_particles_are_ignored() -> None:
    """Law: who vanishes takes no energy along unseen that the step has made."""
    burst = replace(meeting(0.05, 3.2 * np.sqrt(0.5 * MASS / KN), gap=0.0005), lost="ignore")
    burst = replace(burst, box=Box(np.full(3, -0.03), np.full(3, 0.03), ("ff", "ff", "ff")))
    assert "the energy grew by" in message_of(burst, 190)


def test_a_wall_that_moves_too_fast_is_said() -> None:
    """Law: a plane that moves more than half a radius in a step could pass through a sphere unseen, by pushing or by turning."""
    pushing = Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, 0.0, 0.6 * RADIUS / STEP))
    turning = Plane((0.0, 0.0, 1.0), 0.0, omega=(0.6 * RADIUS / STEP, 0.0, 0.0), pivot=(0.0, 1.0, 0.0))
    scene = on_floor(STEP, FLOOR, overlap=-0.1 * RADIUS)
    for shape in (pushing, turning):
        said = message_of(replace(scene, walls=(replace(scene.walls[0], shape=shape),)), 0)
        assert said.startswith("wall floor moves 0.6 of the smallest radius in a step")

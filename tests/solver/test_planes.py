"""Planes a x + b y + c z + d = 0: where they are, how they move and turn, and what their motion gives to the particles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import Box, ContactLaw, Gravity, Neighbor, NveSphere, Plane, Scene, Simulation, Slab, Wall
from demsolver.reference import forces
from tests.support.scenes import law, spheres
from tests.support.turns import rotation

KN, R = 1e4, 0.005
BOX = Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))


def contact(**given: float) -> ContactLaw:
    """An elastic spring, and what else is given: viscous friction -gammat m vt below mu |Fn|, rolling resistance. One form, so one compiled loop."""
    values = {"kn": KN, "gamman": 0.0, "gammat": 0.0, "mu": 1e9, "rolling_friction": 0.0} | given
    tables = {name: np.full(1, value) for name, value in values.items()}
    return ContactLaw("hooke", "mass_velocity", "none", "mass", "no_history", tables, rolling="primer", surface_arm="contact")


SPRING, VISCOUS = contact(), contact(gammat=40.0)


def scene(
    plane: Plane, x: np.ndarray, *, law: ContactLaw = SPRING, dt: float = 1e-5, free: bool = True, g: float = 0.0, **motion: np.ndarray
) -> Scene:
    """Spheres of radius R and one plane."""
    p = spheres(np.atleast_2d(x), np.full(len(np.atleast_2d(x)), R), **motion)
    fields = (Gravity((0.0, 0.0, -g)),)
    return Scene(BOX, p, 1, dt, walls=(Wall("plane", plane, law),), forces=fields, integrate=(NveSphere(),) if free else ())


def started(what: Scene, steps: int = 0) -> Simulation:
    """A simulation that has run."""
    simulation = Simulation(what, budget=True, on_instability="off")  # forces of any overlap are compared
    simulation.setup()
    simulation.advance(steps)
    return simulation


def walled(planes: tuple[Plane, ...], *, dt: float = 1e-5, spread: float = 0.0125, speed: float = 0.4) -> Scene:
    """27 spheres, about to collide, under gravity between three planes with damping, friction and rolling resistance; the last plane slides."""
    rng = np.random.default_rng(12)
    x = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * spread + 0.01
    p = spheres(x, rng.uniform(0.0055, 0.006, 27), v=rng.normal(0, speed, (27, 3)), omega=rng.normal(0, 40, (27, 3)))
    pair, sticky = law((1, 1), friction="rotated_history"), law((1,), friction="rotated_history")
    sticky = replace(sticky, rolling="primer", coefficients={**sticky.coefficients, "rolling_friction": np.full(1, 0.1)})
    walls = tuple(Wall(str(k), plane, sticky, velocity=(0.4, 0.0, 0.0) if k == 2 else (0.0, 0.0, 0.0)) for k, plane in enumerate(planes))
    fields = (Gravity((0.0, 0.0, -9.81)),)
    return Scene(BOX, p, 1, dt, pair=pair, walls=walls, forces=fields, integrate=(NveSphere(),), neighbor=Neighbor(0.002))


STILL = (Plane((1.0, 0.0, 0.0), -0.004), Plane((0.0, 1.0, 0.0), -0.005), Plane((0.0, 0.0, 1.0), -0.004))
MOVING = (
    Plane((0.1, 0.2, 1.0), -0.004, (0.05, 0.0, 0.3)),
    Plane((1.0, 0.1, 0.0), -0.003, omega=(3.0, 5.0, 8.0), pivot=(0.01, 0.05, 0.0)),
    Plane((0.0, 1.0, 0.0), -0.005, velocity=(0.0, 0.1, 0.0)),
)


def turned_plane(plane: Plane, turn: np.ndarray) -> Plane:
    """The plane in a turned frame."""
    return replace(plane, **{name: _three(turn @ np.array(getattr(plane, name))) for name in ("normal", "velocity", "omega", "pivot")})


def test_axis_planes_are_slabs() -> None:
    """Law: planes along the axes are slabs, bit for bit over 200 steps of a spinning, sliding crowd, whichever way their normals point."""
    slabs = (Slab(0, lo=0.004), Slab(1, lo=0.005), Slab(2, lo=0.004))
    flipped = tuple(Plane(_three(-np.array(plane.normal)), -plane.offset) for plane in STILL)
    base = walled(STILL)
    a, b, c = (
        started(replace(base, walls=tuple(replace(wall, shape=shape) for wall, shape in zip(base.walls, shapes, strict=True))), 200)
        for shapes in (slabs, STILL, flipped)
    )
    assert a.energy_budget().rubbed > 0.0 < a.energy_budget().rolled
    for other in (b, c):
        for name in ("x", "v", "omega", "force", "torque"):
            assert np.array_equal(getattr(a.bodies, name), getattr(other.bodies, name))
        assert a.energy_budget() == other.energy_budget()


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 6))
vectors = st.tuples(numbers, numbers, numbers).filter(lambda v: np.linalg.norm(v) > 0.1)


@settings(max_examples=20, deadline=None)
@given(axis=vectors, angle=st.floats(0.1, 6.0))
def test_no_orientation_is_special(axis: tuple[float, float, float], angle: float) -> None:
    """Law: the turned scene, its moving and turning planes too, does what the scene did, turned."""
    turn = rotation(np.array(axis), angle)
    base = walled(MOVING)
    p = base.particles
    walls = tuple(replace(w, shape=turned_plane(w.shape, turn), velocity=_three(turn @ np.array(w.velocity))) for w in base.walls)
    other = replace(p, x=p.x @ turn.T, v=p.v @ turn.T, omega=p.omega @ turn.T)
    fields = (Gravity(_three(turn @ np.array(base.forces[0].acceleration))),)
    a, b = (started(what, 50) for what in (base, replace(base, particles=other, walls=walls, forces=fields)))
    # Rounding of the turn, 1e-16 of the coordinates over overlaps of 1e-2 of them, grown over 50 steps of collisions.
    assert np.abs(b.bodies.force - a.bodies.force @ turn.T).max() < 1e-9 * np.abs(a.bodies.force).max()
    assert np.abs(b.bodies.x - a.bodies.x @ turn.T).max() < 1e-12


def _three(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z


@settings(max_examples=40, deadline=None)
@given(normal=vectors, place=vectors, side=st.sampled_from([1.0, -1.0]), factor=st.floats(1e-120, 1e120), flip=st.sampled_from([1.0, -1.0]))
def test_distance_and_direction(normal: tuple, place: tuple, side: float, factor: float, flip: float) -> None:
    """Law (3.1), (3.3): with d = -(a x0 + b y0 + c z0) the plane goes through x0; a sphere 0.9 R off it, on either side, is pushed off by
    kn (R - |a x + b y + c z + d|/sqrt(a^2 + b^2 + c^2)), whatever factor multiplies all four numbers."""
    n, x0 = np.array(normal), 0.5 * np.array(place)
    unit = n / np.linalg.norm(n)
    scaled = flip * factor * n
    plane = Plane(_three(scaled), -float(scaled @ x0))
    f = started(scene(plane, x0 + 0.9 * side * R * unit, free=False)).bodies.force[0]
    # a rounding of the coordinates, 1e-16, is a part in 1e12 of the overlap
    assert np.abs(f - side * KN * 0.1 * R * unit).max() < 1e-11 * KN * R


def test_the_printed_offset_is_another_plane() -> None:
    """Law: d = +(a x0 + b y0 + c z0), as (3.3) has it, puts the plane on the other side of the origin: the sphere at x0 feels nothing."""
    x0 = np.array([0.0, 0.0, 0.1])
    for sign, felt in ((-1.0, True), (1.0, False)):
        f = started(scene(Plane((0.0, 0.0, 1.0), sign * 0.1), x0 + np.array([0.0, 0.0, 0.9 * R]), free=False)).bodies.force[0]
        assert bool(f.any()) is felt


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_loop_equals_the_plain_sum(seed: int) -> None:
    """Law: force and torque of planes at any place, moving and turning, are those of the plain reference."""
    rng = np.random.default_rng(seed)
    planes = []
    for _ in range(3):
        n = rng.normal(size=3)
        middle = float(n @ rng.uniform(0.01, 0.04, 3))
        planes.append(Plane(_three(n), -middle, _three(rng.normal(size=3)), _three(rng.normal(0, 20, 3)), _three(rng.normal(size=3))))
    base = walled(tuple(planes))
    simulation = started(base)
    b, g = simulation.bodies, np.array([0.0, 0.0, -9.81])
    force, torque, _ = forces(base, b.x, b.v, b.omega, {}, False)
    assert np.abs(force).max() > 0.0
    # a pivot some unit off costs 1e-16 of the coordinates, a part in 1e13 of the overlaps; the surface velocity 20 units
    assert np.abs(b.force - force - b.mass[:, None] * g).max() < 1e-12 * np.abs(force).max()
    assert np.abs(b.torque - torque).max() < 1e-12 * max(np.abs(torque).max(), np.abs(force).max() * R)


def test_a_moving_plane_is_a_moving_frame() -> None:
    """Law (Galileo): planes with velocity V against spheres are the planes at rest against spheres with velocity less V, friction, spin and all."""
    push = np.array([0.1, -0.3, 0.7])
    still, steps = walled(STILL), 300
    p, walls = still.particles, tuple(replace(wall, shape=replace(wall.shape, velocity=_three(push))) for wall in still.walls)
    a = started(replace(still, walls=walls), steps)
    b = started(replace(still, particles=replace(p, v=p.v - push)), steps)
    way = steps * still.timestep * push
    # rounding of the shifted coordinates, grown over the collisions of 300 steps (some contact times)
    assert np.abs(a.bodies.x - way - b.bodies.x).max() < 1e-12
    assert np.abs(a.bodies.omega - b.bodies.omega).max() < 1e-9 * np.abs(a.bodies.omega).max()


def test_where_a_plane_is_after_many_steps() -> None:
    """Law: after N steps the pivot has gone N dt V, and the plane has turned about it by N dt omega: the force on a sphere that stays says so."""
    n, pivot, velocity, omega = (np.array(v) for v in ([0.3, -0.5, 1.0], [0.05, 0.02, -0.01], [0.4, 0.3, -0.2], [3.0, -7.0, 5.0]))
    point, dt, steps = np.array([0.01, 0.03, 0.02]), 1e-4, 2500
    time = steps * dt
    turn = rotation(omega, time * float(np.linalg.norm(omega)))
    later, unit = pivot + time * velocity + turn @ (point - pivot), turn @ n / np.linalg.norm(n)
    plane = Plane(_three(n), -float(n @ point), _three(velocity), _three(omega), _three(pivot))
    at = later + 0.7 * R * unit + 0.03 * np.cross(unit, [1.0, 0, 0])
    f = started(scene(plane, at, dt=dt, free=False), steps).bodies.force[0]
    # 2500 turns, each rounded to 1e-16, at 0.3 from the pivot: 1e-13 of length, a part in 1e10 of the overlap of 0.3 R
    assert f == pytest.approx(0.3 * KN * R * unit, rel=1e-9, abs=1e-9 * KN * R)


def test_the_surface_of_a_turning_plane_drags() -> None:
    """Law: a resting sphere feels the surface velocity V + omega x r: Ft = gammat m (V + omega x r)_t, at the foot of the sphere on the plane."""
    omega, pivot, velocity = np.array([0.3, -0.2, 4.0]), np.array([0.1, 0.2, 0.0]), np.array([0.5, 0.0, 0.0])
    plane = Plane((0.0, 0.0, 1.0), 0.0, _three(velocity), _three(omega), _three(pivot))
    x = np.array([0.3, 0.1, 0.99 * R])
    simulation = started(scene(plane, x, law=VISCOUS, free=False))
    surface = velocity + np.cross(omega, [0.3, 0.1, 0.0] - pivot)
    assert simulation.bodies.force[0, :2] == pytest.approx(40.0 * simulation.bodies.mass[0] * surface[:2], rel=1e-12)


@pytest.mark.parametrize("omega", [(0.0, 0.0, 7.0), (3.0, 1.0, 7.0)])
def test_turning_along_with_the_plane_is_rest(omega: tuple[float, float, float]) -> None:
    """Law: a sphere that goes round and spins with a turning plane feels no friction, but for the half overlap that its lever R - overlap/2
    stops short of the plane: vt = overlap/2 n x omega."""
    pivot, w = np.array([0.1, 0.2, 0.0]), np.array(omega)
    x = np.array([0.3, 0.1, 0.99 * R])
    plane = Plane((0.0, 0.0, 1.0), 0.0, omega=omega, pivot=_three(pivot))
    b = started(scene(plane, x, law=VISCOUS, v=np.cross(w, x - pivot)[None], omega=w[None], free=False)).bodies
    short = 0.5 * 0.01 * R * np.cross([0.0, 0.0, 1.0], w)
    # rounding of the surface velocity, 2 units per second
    assert b.force[0, :2] == pytest.approx(-40.0 * b.mass[0] * short[:2], rel=1e-9, abs=1e-15 * 40.0 * b.mass[0] * 100)


def test_a_ball_on_a_turntable_circles() -> None:
    """Law: a ball that rolls on a table turning with W goes round with 2/7 W, wherever it starts (S. Earnshaw, Dynamics, 1839)."""
    table, speed = 5.0, 0.2
    spring = {"kn": np.full(1, KN), "gamman": np.full(1, 2e3), "shear_stiffness": np.full(1, KN), "gammat": np.full(1, 1e3), "mu": np.full(1, 10.0)}
    rolls = ContactLaw("hooke", "mass_velocity", "constant", "mass", "rotated_history", spring, surface_arm="contact", torque_arm="contact")
    start, v = np.array([0.2, 0.1, R]), np.array([speed, 0.0, 0.0])
    surface = np.cross([0.0, 0.0, table], start)
    spin = np.cross([0.0, 0.0, 1.0], v - surface) / R  # contact point moves with the table
    p = spheres(start[None], np.full(1, R), v=v[None], omega=spin[None])
    p = replace(p, x=start[None] - [0, 0, p.mass[0] * 9.81 / KN])
    one = Scene(
        BOX, p, 1, 2e-5, walls=(Wall("table", Plane((0.0, 0.0, 1.0), 0.0, omega=(0.0, 0.0, table)), rolls),), forces=(Gravity((0.0, 0.0, -9.81)),),
        integrate=(NveSphere(),),
    )  # fmt: skip
    simulation = started(one)
    angles = [0.0]
    for _ in range(8):
        simulation.advance(5000)
        angles.append(float(np.arctan2(simulation.bodies.v[0, 1], simulation.bodies.v[0, 0])))
    rate = np.polyfit(0.1 * np.arange(9), np.unwrap(angles), 1)[0]
    # the overlap (2e-5 R) shortens the lever, and spring and dashpot let the contact creep: parts in a thousand
    assert rate == pytest.approx(2.0 / 7.0 * table, rel=3e-3)
    assert np.linalg.norm(simulation.bodies.v[0, :2]) == pytest.approx(speed, rel=3e-3)


def test_both_sides_are_felt_alike() -> None:
    """Law: the mirrored sphere feels the mirrored force; the centre in the plane feels nothing."""
    x = np.array([[0.1, 0.0, 0.7 * R], [0.2, 0.0, -0.7 * R], [0.3, 0.0, 0.0]])
    f = started(scene(Plane((0.0, 0.0, 2.0), 0.0), x, free=False)).bodies.force
    assert f[0, 2] > 0.0
    assert np.array_equal(f[1], -f[0])
    assert not f[2].any()


def test_a_plane_pushes_with_twice_its_speed() -> None:
    """Law: an elastic plane of speed V throws a sphere at rest off with 2 V, and gives it 2 m V^2, which the budget has as driven."""
    speed, dt = 0.3, 1e-6
    one = scene(Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, 0.0, speed)), np.array([0.0, 0.0, 1.001 * R]), dt=dt)
    simulation = started(one, 6000)
    b, budget = simulation.bodies, simulation.energy_budget()
    # the ends of the contact fall between steps: (omega dt)^2 = (KN/m) dt^2 = 8e-6
    assert b.v[0, 2] == pytest.approx(2.0 * speed, rel=1e-5)
    assert budget.driven == pytest.approx(2.0 * b.mass[0] * speed**2, rel=1e-5)
    assert budget.damped == budget.rubbed == budget.rolled == 0.0


def test_the_budget_of_driven_walls_closes_with_the_square_of_the_step() -> None:
    """Law: held plus taken less driven stays put, of order dt^2, with walls that move, turn, slide, damp, rub and resist rolling."""
    steps, drifts = (2e-5, 1e-5, 5e-6), []
    for dt in steps:
        simulation = started(walled(MOVING, dt=dt))
        start = simulation.energy_budget()
        totals = []
        for _ in range(40):
            simulation.advance(round(2e-4 / dt))
            totals.append(simulation.energy_budget().total - start.total)
        drifts.append(float(np.sqrt(np.mean(np.square(totals)))))
        end = simulation.energy_budget()
        assert end.rolled > 0.0
    order = np.polyfit(np.log(steps), np.log(drifts), 1)[0]
    # contacts that begin and end between steps scatter about the order 2; work by the wrong velocity (of the step's end) has order 1
    assert order > 1.6, f"order {order:.2f}, {drifts}"
    assert end.driven > 500.0 * drifts[-1]  # and the walls do matter


def test_spin_against_a_turning_plane_is_what_rolls() -> None:
    """Law: rolling resistance acts against the spin relative to the plane: none for a sphere that spins as the plane turns."""
    omega = np.array([1.0, -2.0, 3.0])
    for spin, factor in ((omega, 0.0), (omega + np.array([0.0, 0.0, 5.0]), 1.0)):
        plane = Plane((0.0, 0.0, 1.0), 0.0, omega=_three(omega))
        what = scene(plane, np.array([0.1, 0.0, 0.9 * R]), law=contact(rolling_friction=0.2), omega=spin[None], free=False)
        torque = started(what).bodies.torque[0]
        assert torque == pytest.approx([0.0, 0.0, -factor * 0.2 * R * 0.1 * KN * R], rel=1e-12)
        p = what.particles
        assert forces(what, p.x, p.v, p.omega, {}, False)[1][0] == pytest.approx(torque)


@pytest.mark.parametrize("moves", [{"velocity": (0.2, 0.0, 0.3)}, {"omega": (1.0, 3.0, 2.0), "pivot": (0.02, 0.0, 0.0)}])
def test_the_next_run_finds_the_plane_where_it_is(moves: dict) -> None:
    """Law: two runs of 30 steps are one of 60 where set-up changes nothing (no damping): the plane goes on from where it stands."""
    plane = Plane((0.0, 0.1, 1.0), 0.0, **moves)
    one = scene(plane, np.array([[0.01, 0.0, 0.9 * R], [0.03, 0.01, 1.05 * R]]), v=np.array([[0.0, 0.0, -0.1]] * 2))
    whole, first = started(one, 60), started(one, 30)
    second = first.continue_with(replace(one, particles=first.particles()))
    second.setup()
    assert np.array_equal(second.bodies.force, first.bodies.force)
    second.advance(30)
    assert np.array_equal(whole.bodies.x, second.bodies.x)
    elsewhere = replace(one, particles=first.particles(), walls=(replace(one.walls[0], shape=replace(plane, offset=1e-4)),))
    again = first.continue_with(elsewhere)
    again.setup()
    assert np.array_equal(again.bodies.force, started(elsewhere).bodies.force)  # a plane of other words starts where they say
    assert not np.array_equal(again.bodies.force, second.bodies.force)


def test_the_next_run_may_slide_its_walls_faster() -> None:
    """Law: a wall's surface velocity is that of the run's own scene, not that of the run before."""
    base = scene(Plane((0.0, 0.0, 1.0), 0.0), np.array([0.1, 0.0, 0.9 * R]), law=VISCOUS, free=False)
    slow, fast = (replace(base, walls=(replace(base.walls[0], velocity=(speed, 0.0, 0.0)),)) for speed in (1.0, 2.0))
    first = started(slow, 1)
    second = first.continue_with(fast)
    second.setup()
    assert second.bodies.force[0, 0] == pytest.approx(2.0 * first.bodies.force[0, 0])


def test_gravity_holds_a_sphere_on_a_lift() -> None:
    """Law: on a plane that sinks steadily a resting sphere sinks with it, and gravity's work goes into the plane: driven is negative."""
    mass = 2500.0 * 4 / 3 * np.pi * R**3
    x = np.array([0.0, 0.0, R - mass * 9.81 / KN])
    lift = scene(Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, 0.0, -0.2)), x, v=np.array([[0.0, 0.0, -0.2]]), g=9.81)
    simulation = started(lift, 2000)
    assert simulation.bodies.x[0, 2] == pytest.approx(x[2] - 0.2 * 0.02, abs=1e-12)
    assert simulation.energy_budget().driven == pytest.approx(-mass * 9.81 * 0.2 * 0.02, rel=1e-9)


def test_a_plane_that_squeezes_pays_for_the_spring() -> None:
    """Law: driven against a sphere that nothing moves is what the spring gained; by the trapezoid rule exact for a force linear in time."""
    held = scene(Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, 0.0, 0.3)), np.array([0.0, 0.0, 0.9 * R]), dt=1e-6, free=False)
    budget = started(held, 100).energy_budget()
    overlap = 0.1 * R + 0.3 * 1e-4
    assert budget.driven == pytest.approx(0.5 * KN * (overlap**2 - (0.1 * R) ** 2), rel=1e-9)
    assert budget.elastic_normal == pytest.approx(0.5 * KN * overlap**2, rel=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_one_sided_plane_is_felt_where_its_normal_points(side: float) -> None:
    """Law: of a one-sided plane only the side of its normal is felt, in the loop and in the plain sum; there it is the two-sided one."""
    x = np.array([[0.1, 0.0, 0.7 * R], [0.2, 0.0, -0.7 * R], [0.3, 0.0, 0.0]])
    both = scene(Plane((0.0, 0.0, side), 0.0), x, free=False)
    one = replace(both, walls=(replace(both.walls[0], shape=Plane((0.0, 0.0, side), 0.0, one_sided=True)),))
    f, of_both = started(one).bodies.force, started(both).bodies.force
    seen = x[:, 2] * side > 0.0
    assert np.array_equal(f[seen], of_both[seen])
    assert f[seen].any()
    assert not f[~seen].any()
    p = one.particles
    assert forces(one, p.x, p.v, p.omega, {}, False)[0] == pytest.approx(f)


WRONG = (
    Plane((0.0, 0.0, 0.0), 1.0), Plane((np.nan, 0.0, 1.0), 0.0), Plane((np.inf, 0.0, 0.0), 0.0), Plane((0.0, 0.0, 1.0), np.nan),
    Plane((0.0, 0.0, 1.0), 0.0, velocity=(0.0, np.nan, 0.0)), Plane((0.0, 0.0, 1.0), 0.0, omega=(np.inf, 0.0, 0.0)),
)  # fmt: skip


@pytest.mark.parametrize("plane", WRONG)
def test_a_plane_needs_a_normal_and_finite_numbers(plane: Plane) -> None:
    """Law: a plane without a direction, place or motion is refused with its name and the numbers."""
    with pytest.raises(ValueError, match=r"wall plane: normal must not be zero and all numbers finite, got Plane\("):
        Simulation(scene(plane, np.zeros(3) + 0.1))

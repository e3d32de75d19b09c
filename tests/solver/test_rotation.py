"""Cylinders that turn about their axes: the velocity of their surface, what rolling knows of it, and the work they do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, ContactLaw, Cylinder, Gravity, Neighbor, NveSphere, Rotation, Scene, Simulation, Slab, Wall
from demsolver.bind_walls import walls_source
from demsolver.reference import forces
from tests.support.scenes import law, spheres

KN, R, RC, RATE, GAMMAT, OVERLAP = 1e4, 0.005, 0.03, 7.0, 40.0, 1e-5
BOX = Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))
MASS = 2500.0 * 4 / 3 * np.pi * R**3
AT = ("surface", "center")


def contact(**given: float) -> ContactLaw:
    """An elastic spring, viscous friction -gammat m vt below mu |Fn|, and rolling resistance."""
    values = {"kn": KN, "gamman": 0.0, "gammat": GAMMAT, "mu": 1e9, "rolling_friction": 0.0} | given
    return ContactLaw("hooke", "mass_velocity", "none", "mass", "no_history", {k: np.full(1, v) for k, v in values.items()}, rolling="primer")


def scene(shape: Cylinder | Slab, x: np.ndarray, *, law: ContactLaw | None = None, free: bool = False, **motion: np.ndarray) -> Scene:
    """Spheres of radius R and one wall."""
    p = spheres(np.atleast_2d(x), np.full(len(np.atleast_2d(x)), R), **motion)
    return Scene(BOX, p, 1, 1e-5, walls=(Wall("drum", shape, law or contact()),), integrate=(NveSphere(),) if free else ())


def started(what: Scene, steps: int = 0) -> Simulation:
    """A simulation that has run."""
    simulation = Simulation(what, budget=True)
    simulation.setup()
    simulation.advance(steps)
    return simulation


def place(axis: int, off: float, angle: float = 0.7) -> np.ndarray:
    """A point at this distance from the line along `axis` through (0.01, -0.02) of the other two."""
    x = np.zeros(3)
    x[[(axis + 1) % 3, (axis + 2) % 3]] = 0.01 + off * np.cos(angle), -0.02 + off * np.sin(angle)
    return x


def drum(axis: int = 2, **rotation: object) -> Cylinder:
    """The cylinder about that line."""
    return Cylinder(axis, (0.01, -0.02), RC, rotation=Rotation(RATE, **rotation))  # type: ignore[arg-type]


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("at", AT)
@pytest.mark.parametrize("off", [RC - R + OVERLAP, RC + R - OVERLAP])
def test_a_sphere_at_rest_is_dragged_along(axis: int, at: str, off: float) -> None:
    """Law: friction is gammat m (W x r), r from the axis to the surface or to the centre, inside and outside; the sphere is turned by -R n x F."""
    x = place(axis, off)
    simulation = started(scene(drum(axis, at=at), x))
    outward = (x - place(axis, 0.0)) / off
    drag = GAMMAT * MASS * RATE * (RC if at == "surface" else off) * np.cross(np.eye(3)[axis], outward)
    normal = -np.sign(off - RC) * -outward
    assert simulation.bodies.force[0] - (simulation.bodies.force[0] @ outward) * outward == pytest.approx(drag, rel=1e-12, abs=1e-15)
    assert simulation.bodies.torque[0] == pytest.approx(-R * np.cross(normal, drag), rel=1e-12, abs=1e-18)


@pytest.mark.parametrize("at", AT)
def test_the_axis_is_no_trouble(at: str) -> None:
    """Law: a sphere on the axis of a cylinder that it does not touch, or fills, feels nothing, whatever turns."""
    for radius in (RC, 0.8 * R):
        simulation = started(scene(replace(drum(at=at), radius=radius), place(2, 0.0)), 3)
        assert not simulation.bodies.force.any()
        assert not simulation.bodies.torque.any()


def test_a_wide_cylinder_is_a_sliding_plane() -> None:
    """Law: with Rc to infinity at W Rc = V the surface is a plane that slides with V: forces differ by the curvature, R/Rc."""
    wide, speed = 1e6 * R, 0.3
    motion = {"v": np.array([[0.1, -0.02, 0.05]]), "omega": np.array([[1.0, 20.0, -3.0]])}
    turning = Cylinder(2, (0.0, wide), wide, rotation=Rotation(speed / wide))
    belt = replace(scene(Slab(1, lo=0.0), np.array([0.0, R - OVERLAP, 0.0]), **motion))
    belt = replace(belt, walls=(replace(belt.walls[0], velocity=(speed, 0.0, 0.0)),))
    a, b = started(scene(turning, np.array([0.0, R - OVERLAP, 0.0]), **motion)), started(belt)
    assert a.bodies.force == pytest.approx(b.bodies.force, rel=1e-5)
    assert a.bodies.torque == pytest.approx(b.bodies.torque, rel=1e-5, abs=1e-12)


def test_at_setup_the_wall_may_be_still() -> None:
    """Law: with still_at_setup the first force is that of a cylinder that does not turn, every later one that of one that does."""
    x, still = place(2, RC - R + OVERLAP), replace(drum(), rotation=None)
    late, turning, resting = (started(scene(shape, x)) for shape in (drum(still_at_setup=True), drum(), still))
    assert np.array_equal(late.bodies.force, resting.bodies.force)
    late.advance(1)
    turning.advance(1)
    assert np.array_equal(late.bodies.force, turning.bodies.force)
    assert late.bodies.force[0] != pytest.approx(resting.bodies.force[0])


def test_rolling_may_know_the_spin_of_the_wall() -> None:
    """Law: a sphere that turns with the wall meets no rolling resistance where `rolls`, and meets it where only its own spin counts."""
    x, spin = place(2, RC - R + OVERLAP), np.array([[0.0, 0.0, RATE]])
    torques = []
    for rolls in (True, False):
        both = (started(scene(drum(rolls=rolls), x, law=contact(rolling_friction=mu, gammat=0.0), omega=spin)) for mu in (0.0, 0.1))
        torques.append(np.subtract(*(s.bodies.torque for s in both))[0])
    assert not torques[0].any()
    assert torques[1][2] == pytest.approx(0.1 * KN * OVERLAP * R, rel=0.01)


@pytest.mark.parametrize("side", ["in", "out"])
def test_one_side(side: str) -> None:
    """Law: of two spheres in touch, one inside and one outside, a cylinder of one side is felt by one alone."""
    x = np.array([place(2, RC - R + OVERLAP), place(2, RC + R - OVERLAP, 2.0)])
    what = scene(replace(drum(), side=side), x)
    felt = started(what).bodies.force.any(axis=1)
    assert felt.tolist() == [side == "in", side == "out"]
    p = what.particles
    assert forces(what, p.x, p.v, p.omega, {}, False)[0].any(axis=1).tolist() == felt.tolist()


def crowd(**rotation: object) -> Scene:
    """27 spheres thrown about in a turning cylinder with damping, frictional springs and rolling resistance."""
    rng = np.random.default_rng(12)
    x = (np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) - 1.0) * 0.0125
    p = spheres(x, rng.uniform(0.0055, 0.006, 27), v=rng.normal(0, 0.4, (27, 3)), omega=rng.normal(0, 40, (27, 3)))
    sticky = law((1,), friction="rotated_history")
    sticky = replace(sticky, rolling="primer", coefficients={**sticky.coefficients, "rolling_friction": np.full(1, 0.1)})
    shape = Cylinder(2, (0.0, 0.0), 0.0232, "curved", rotation=Rotation(RATE, **rotation))  # type: ignore[arg-type]
    walls = (Wall("drum", shape, sticky, velocity=(0.0, 0.0, 0.1)),)
    pair, fields = law((1, 1), friction="rotated_history"), (Gravity((0.0, -9.81, 0.0)),)
    return Scene(BOX, p, 1, 1e-5, pair=pair, walls=walls, forces=fields, integrate=(NveSphere(),), neighbor=Neighbor(0.002))


@pytest.mark.parametrize("at", AT)
@pytest.mark.parametrize("rolls", [True, False])
def test_the_loop_is_the_plain_sum(at: str, rolls: bool) -> None:
    """Law: force and torque of the compiled loop are the plain reference's to 1e-12 of the largest, at set-up and over three steps that remember."""
    what = crowd(at=at, rolls=rolls, still_at_setup=rolls)
    simulation = Simulation(what)
    simulation.setup()
    p, dt, history = what.particles, what.timestep, {}
    x, v, w, mass = p.x.copy(), p.v.copy(), p.omega.copy(), p.mass[:, None]
    inertia = 0.4 * mass * p.radius[:, None] ** 2
    f = t = np.zeros_like(x)
    for step in range(4):
        if step:
            v, w = v + dt / 2 * f / mass, w + dt / 2 * t / inertia
            x = x + dt * v
            simulation.advance(1)
        f, t, history = forces(what, x, v, w, history, step > 0)
        f = f + mass * np.array([0.0, -9.81, 0.0])
        found = simulation.bodies
        order = np.argsort(simulation.id)
        assert np.abs(found.force[order] - f).max() <= 1e-12 * np.abs(f).max()
        assert np.abs(found.torque[order] - t).max() <= 1e-12 * np.abs(t).max()
        if step:
            v, w = v + dt / 2 * f / mass, w + dt / 2 * t / inertia
    assert any(key[0] == "drum" for key in history)


@pytest.mark.parametrize("at", AT)
@pytest.mark.parametrize("rolls", [True, False])
def test_the_account_of_energy_closes(at: str, rolls: bool) -> None:
    """Law: held plus taken less what the wall gives stays put, to dt^2; the wall gives something."""
    drift, given = [], 0.0
    for dt, steps in ((1e-5, 400), (5e-6, 800)):
        simulation = started(replace(crowd(at=at, rolls=rolls), timestep=dt))
        first = simulation.energy_budget()
        simulation.advance(steps)
        last = simulation.energy_budget()
        size = first.kinetic + first.rotational
        drift.append(abs(last.total - first.total) / size)
        given = last.driven / size
    assert abs(given) > 0.01
    assert drift[1] < 1e-4
    assert drift[1] < 0.4 * drift[0]  # a quarter, if collisions began and ended with the steps


def test_work_of_the_wall_on_a_sphere_held_fast() -> None:
    """Law: a held sphere that slips takes W times the torque about the axis, F Rc per time; it all goes into friction."""
    simulation = started(scene(drum(), place(2, RC - R + OVERLAP)), 100)
    power = GAMMAT * MASS * (RATE * RC) ** 2
    budget = simulation.energy_budget()
    assert budget.driven == pytest.approx(power * 100 * 1e-5, rel=1e-10)
    assert budget.rubbed == pytest.approx(budget.driven, rel=1e-10)


def test_a_cylinder_that_does_not_turn_costs_nothing() -> None:
    """Law: without a rotation the generated code of the walls knows none."""
    assert "rate" not in walls_source(scene(replace(drum(), rotation=None), place(2, 0.0))).replace("integrate", "")


def test_an_infinite_rate_is_refused() -> None:
    """Law: what is not a number is named."""
    with pytest.raises(ValueError, match="wall drum: rate must be a finite number, got inf"):
        Simulation(scene(replace(drum(), rotation=Rotation(np.inf)), place(2, 0.0)))

"""Contact laws and the account of energy with clumps in the scene."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest

from demsolver import EnergyBudget, NveClumps, NveSphere, NveSuperquadric, Particles, Scene, Simulation, Superquadrics, contact
from demsolver.reference import forces
from demsolver.scene import Integrator
from demsolver.shapes import superquadric
from demsolver.superquadric import bounding_radius
from tests.support.clumps import heap, no_shapes, scene_of, with_clumps
from tests.support.laws import every_law
from tests.support.scenes import law, spheres

LAWS: list[tuple[contact.Family, str]] = [
    ("normal", "hertz"), ("friction", "liggghts_history"), ("friction", "mindlin_rescale_force"), ("rolling", "epsd"), ("rolling", "sds"),
    ("twisting", "marshall"), ("cohesion", "sjkr"),
]  # fmt: skip
"""One of each family and of each way of remembering."""
ALL: tuple[Integrator, ...] = (NveSphere(), NveClumps())


def dumbbells(seed: int) -> Particles:
    """Four clumps of two spheres that do not overlap, and two spheres, some touching, thrown together; members carry the mass of the whole."""
    rng = np.random.default_rng(seed)
    x = np.array([(i, j, k) for i in range(2) for j in range(2) for k in range(3)][:10], float) * 0.0099 + rng.uniform(-5e-5, 5e-5, (10, 3))
    x[:, 2] += 0.00495
    body = np.array([0, 1, 2, 1, 0, 3, -1, 2, -1, 3])  # partners lie across from each other
    p = spheres(x, np.full(10, 0.005), v=rng.normal(0.0, 0.1, (10, 3)), omega=rng.normal(0.0, 20.0, (10, 3)))
    return with_clumps(p, body, members_weigh=False, v=rng.normal(0.0, 0.1, (4, 3)), omega=rng.normal(0.0, 10.0, (4, 3)))


@pytest.mark.parametrize(("family", "name"), LAWS)
def test_laws_see_the_mass_of_the_whole_and_their_account_closes(family: contact.Family, name: str) -> None:
    """Law: at set-up every member's force and torque are the plain reference's for a sphere of the mass of its clump; over 600 steps the account of
    energy closes to 1e-3."""
    p = dumbbells(3)
    scene = scene_of(p, pair=every_law(family, name), dt=2e-6, skin=0.02)
    simulation = Simulation(scene, budget=True, on_instability="off")
    simulation.setup()
    assert p.clumps is not None
    x, inside = simulation.particles().x, p.clumps.body
    plain = replace(scene, particles=replace(p, clumps=None), integrate=(NveSphere(),), forces=())
    apart = np.linalg.norm(x[:, None] - x[None], axis=2)[(inside[:, None] == inside[None]) & (inside[:, None] >= 0) & ~np.eye(10, dtype=bool)]
    assert apart.min() > 0.01  # nothing inside for the reference to find
    f, t, _ = forces(plain, p.x, p.v, p.omega, {}, False)
    weight = np.where(inside < 0, p.mass, 0.0)[:, None] * np.array([0.0, 0.0, -9.81])
    found = simulation.forces()
    assert np.abs(f).max() > 0.1
    assert np.abs(found[0] - f - weight).max() < 1e-12 * np.abs(f).max()
    assert np.abs(found[1] - t).max() < 1e-12 * max(np.abs(t).max(), 1e-3 * np.abs(f).max())
    first = simulation.energy_budget()
    simulation.advance(600)
    last = simulation.energy_budget()
    assert abs(last.total - first.total) < 1e-3 * (first.kinetic + first.rotational + first.elastic)


def company(seed: int, *, members_weigh: bool) -> Scene:
    """Clumps, spheres and superquadrics under gravity on a floor, with damping and friction."""
    p = heap(seed, 3, 4, inward=40.0, spacing=0.0145, members_weigh=members_weigh)
    n, shaped = len(p.id), np.array([12, 13])
    shapes, radius, mass = no_shapes(n), p.radius.copy(), p.mass.copy()
    axes, blockiness = np.array([[6e-3, 5e-3, 4e-3], [5e-3, 5e-3, 6e-3]]), np.array([[2.0, 2.0], [3.0, 2.5]])
    shapes.axes[shaped], shapes.blockiness[shaped] = axes, blockiness
    radius[shaped] = bounding_radius(axes, blockiness)
    mass[shaped] = 2500.0 * superquadric.volume(axes, blockiness)
    shapes.inertia[shaped] = mass[shaped, None] * superquadric.inertia_per_mass(axes, blockiness)
    shapes.angmom[shaped] = shapes.inertia[shaped] * p.omega[shaped]
    mask = np.where(np.isin(np.arange(n), shaped), 3, 5)
    both = replace(p, superquadrics=Superquadrics(shapes.axes, shapes.blockiness, shapes.quat, shapes.inertia, shapes.angmom))
    both = replace(both, radius=radius, mass=mass, mask=mask)
    integrate = (NveSphere(2), NveSuperquadric(1), NveClumps())
    pair = replace(law((1, 1)), surface_arm="contact", torque_arm="contact")
    return replace(scene_of(both, integrate=integrate, pair=pair), contact_point="gauge")  # whose normal force has an energy


def drift(scene: Scene, time: float, dt: float) -> tuple[float, EnergyBudget]:
    """Of the total, over the energy in motion and contacts at the start; the last account."""
    simulation = Simulation(replace(scene, timestep=dt), budget=True, on_instability="off")
    simulation.setup()
    first = simulation.energy_budget()
    simulation.advance(round(time / dt))
    last = simulation.energy_budget()
    return (last.total - first.total) / (first.kinetic + first.rotational + first.elastic), last


@pytest.mark.parametrize("members_weigh", [True, False])
def test_the_account_of_all_shapes_together_closes_with_the_square_of_the_step(members_weigh: bool) -> None:
    """Law: clumps, spheres and superquadrics that collide under gravity with damping, friction and a floor: what total and dissipated energy drift
    together falls as dt^2, order 1.5 or more between 8 and 2 us (rms of six scenes), and is below 2e-5 there."""
    seeds = range(6)
    scenes = [company(seed, members_weigh=members_weigh) for seed in seeds]
    coarse, fine = ([drift(scene, 8e-3, dt) for scene in scenes] for dt in (8e-6, 2e-6))
    rms = [float(np.sqrt(np.mean([found[0] ** 2 for found in runs]))) for runs in (coarse, fine)]
    assert min(found[1].damped for found in fine) > 1e-6
    assert max(found[1].rubbed for found in fine) > 1e-7
    assert rms[1] < 2e-5
    assert log(rms[0] / rms[1], 4) > 1.5, rms


def test_kinetic_and_rotational_energy_are_those_of_the_whole() -> None:
    """Law: a clump has 1/2 M V^2 and 1/2 L.w, its members nothing of their own; together the sum over its spheres, overlaps counted twice."""
    p = heap(5, 2, 1)
    simulation = Simulation(scene_of(p), budget=True, on_instability="off")
    simulation.setup()
    found, c = simulation.energy_budget(), p.clumps
    assert c is not None
    free = c.body < 0
    kinetic = 0.5 * (c.mass @ (c.v**2).sum(axis=1) + p.mass[free] @ (p.v[free] ** 2).sum(axis=1))
    turning = 0.5 * np.sum(c.angmom * c.omega) + 0.2 * (p.mass * p.radius**2)[free] @ (p.omega[free] ** 2).sum(axis=1)
    assert found.kinetic == pytest.approx(kinetic, rel=1e-14)
    assert found.rotational == pytest.approx(turning, rel=1e-14)
    spheres_alone = 0.5 * p.mass @ (p.v**2).sum(axis=1) + 0.2 * (p.mass * p.radius**2) @ (p.omega**2).sum(axis=1)
    assert kinetic + turning == pytest.approx(spheres_alone, rel=1e-13)
    whole = Simulation(scene_of(heap(5, 2, 1, members_weigh=False)), budget=True, on_instability="off")
    whole.setup()
    theirs = whole.energy_budget()
    assert (theirs.kinetic, theirs.gravitational) == pytest.approx((found.kinetic, found.gravitational), rel=1e-13)

"""The compiled loop against the plain sum, and against what no contact may change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import Enforce2D, Freeze, Gravity, LostParticles, Neighbor, NveSphere, Scene, SetForce, Simulation, Unstable, Viscous
from demsolver.computes import Population, angular_momentum, erotate, erotate_sphere, ke, momentum
from demsolver.reference import forces
from demsolver.state import inertia_of
from tests.support.scenes import bed, cluster, law, spheres

ROUNDING = 1e-13  # of the largest force: a few roundings of 24 overlapping spheres, overlaps of 1e-3 of the coordinates


def plain(scene: Scene, simulation: Simulation, advance: bool = False):
    """Force and torque of the reference at the simulation's state, gravity added."""
    b = simulation.bodies
    force, torque, _ = forces(scene, b.x, b.v, b.omega, {}, advance)
    g = np.array(scene.forces[0].acceleration) if scene.forces else 0.0
    return force + b.mass[:, None] * g, torque


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), periodic=st.booleans())
def test_forces_equal_the_plain_sum(seed: int, periodic: bool) -> None:
    """Law: the compiled loop with its neighbour list gives the sum over all pairs and walls, box periodic or not."""
    scene = cluster(np.random.default_rng(seed), periodic=periodic)
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    force, torque = plain(scene, simulation)
    assert np.abs(simulation.bodies.force - force).max() <= ROUNDING * np.abs(force).max()
    assert np.abs(simulation.bodies.torque - torque).max() <= ROUNDING * max(np.abs(torque).max(), 1e-2 * np.abs(force).max() * 0.008)


def test_a_trajectory_equals_the_plain_integration() -> None:
    """Law: 50 steps of velocity Verlet written out in numpy, history and all, end where the compiled loop ends."""
    scene = cluster(np.random.default_rng(5), periodic=False)
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    simulation.advance(50)
    p, dt, history = scene.particles, scene.timestep, {}
    x, v, w, mass = p.x.copy(), p.v.copy(), p.omega.copy(), p.mass[:, None]
    inertia = 0.4 * mass * p.radius[:, None] ** 2
    g = mass * np.array([0.0, 0.0, -9.81])
    f, t, history = forces(scene, x, v, w, history, False)
    for _ in range(50):
        v, w = v + dt / 2 * (f + g) / mass, w + dt / 2 * t / inertia
        x = x + dt * v
        f, t, history = forces(scene, x, v, w, history, True)
        v, w = v + dt / 2 * (f + g) / mass, w + dt / 2 * t / inertia
    b = simulation.bodies
    # rounding grows with the collisions of 50 steps; a wrong rule is off by 1e-6 and more
    assert np.abs(b.x - x).max() < 1e-12 * np.abs(x).max()
    assert np.abs(b.omega - w).max() < 1e-10 * np.abs(w).max()


def test_where_a_run_is_cut_does_not_matter() -> None:
    """Law: advance(30) is advance(7), advance(23), bit for bit: outputs between steps cost no accuracy."""
    whole, parts = (Simulation(cluster(np.random.default_rng(3)), on_instability="off") for _ in range(2))
    whole.setup()
    parts.setup()
    whole.advance(30)
    parts.advance(7)
    parts.advance(23)
    assert np.array_equal(whole.bodies.x, parts.bodies.x)
    assert np.array_equal(whole.bodies.omega, parts.bodies.omega)


@pytest.mark.parametrize("skin", [1e-5, 1e-4, 5e-3])
def test_the_skin_changes_no_force(skin: float) -> None:
    """Law: how often the list is rebuilt (every step, or never) does not show in a law whose history ends with the contact."""
    scene = cluster(np.random.default_rng(11))
    wide = Simulation(replace(scene, neighbor=Neighbor(2e-3)), on_instability="off")
    other = Simulation(replace(scene, neighbor=Neighbor(skin)), on_instability="off")
    for simulation in (wide, other):
        simulation.setup()
        simulation.advance(60)
    # wrapping happens at rebuilds, so positions differ by box lengths, whose rounding grows over the steps
    assert np.abs(wide.bodies.force - other.bodies.force).max() < 1e-9 * np.abs(wide.bodies.force).max()


def test_contacts_keep_momentum_and_angular_momentum() -> None:
    """Law: without gravity and walls, pair forces keep linear momentum, and (arms R - overlap/2) angular momentum, to rounding."""
    base = cluster(np.random.default_rng(21), periodic=False)
    contact = replace(law((1, 1)), surface_arm="contact", torque_arm="contact")
    scene = replace(base, walls=(), forces=(), pair=contact)
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    p, inertia = scene.particles, inertia_of(scene)
    start = momentum(p.mass, p.v), angular_momentum(p.mass, p.x, p.v, inertia, p.omega)
    simulation.advance(200)
    b = simulation.bodies
    scale = (p.mass * np.linalg.norm(b.v, axis=1)).sum()
    assert np.abs(momentum(b.mass, b.v) - start[0]).max() < 1e-13 * scale
    assert np.abs(angular_momentum(b.mass, b.x, b.v, inertia, b.omega) - start[1]).max() < 1e-12 * scale * 0.05


def test_gravity_alone_is_exact() -> None:
    """Law: free fall is a parabola, which velocity Verlet integrates exactly."""
    p = spheres(np.array([[0.0, 0.0, 10.0]]), np.array([0.01]), v=np.array([[1.0, 0.0, 0.0]]))
    scene = Scene(bed(1e-3).box, p, 1, 1e-3, forces=(Gravity((0.0, 0.0, -9.81)),), integrate=(NveSphere(),), lost="ignore")
    scene = replace(scene, box=replace(scene.box, hi=np.array([10.0, 10.0, 20.0])))
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    simulation.advance(1000)
    assert simulation.bodies.x[0] == pytest.approx([1.0, 0.0, 10.0 - 9.81 / 2], rel=1e-12)


def test_fields_act_in_their_order() -> None:
    """Law: gravity, then setforce, then freeze: the last one on a particle wins; drag is -gamma v; enforce2d clears z."""
    n = 4
    x = np.array([[0.02 * k + 0.01, 0.05, 0.05] for k in range(n)])
    p = replace(spheres(x, np.full(n, 0.005), v=np.full((n, 3), 2.0)), mask=np.array([1 | 2, 1 | 4, 1 | 8, 1]))
    fields = (Gravity((0.0, 0.0, -9.81)), SetForce((1.0, None, None), 1), Freeze(2), Viscous(np.array([0.5]), 3), Enforce2D(1))
    simulation = Simulation(Scene(bed(1e-5).box, p, 1, 1e-5, forces=fields, integrate=(NveSphere(),)), on_instability="off")
    simulation.setup()
    f, mg = simulation.bodies.force, 9.81 * p.mass[0]
    assert f[0] == pytest.approx([1.0, 0.0, 0.0])
    assert f[1] == pytest.approx([0.0, 0.0, 0.0])
    assert f[2] == pytest.approx([-1.0, -1.0, -1.0 - mg])
    assert f[3] == pytest.approx([0.0, 0.0, -mg])


def test_lost_particles_stop_the_run_or_go() -> None:
    """Law: what leaves through a fixed face is an error; with lost ignore it is gone and the others go on."""
    p = spheres(np.array([[0.05, 0.05, 0.01], [0.05, 0.05, 0.05]]), np.full(2, 0.004), v=np.array([[0, 0, -5.0], [0, 0, 0]]))
    scene = Scene(bed(1e-4).box, p, 1, 1e-4, integrate=(NveSphere(),), neighbor=Neighbor(0.001))
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    with pytest.raises(LostParticles, match=r"1 particles left the box by step 1\d, the first with id 1"):
        simulation.advance(100)
    careless = Simulation(replace(scene, lost="ignore"), on_instability="off")
    careless.setup()
    careless.advance(100)
    assert careless.id.tolist() == [2]


def test_an_unstable_step_is_an_error() -> None:
    """Law: numbers that leave the range of floats end in Unstable, never in NaN that goes on."""
    stiff = law((1, 1), kn=1e300)
    p = spheres(np.array([[0.05, 0.05, 0.05], [0.052, 0.05, 0.05]]), np.full(2, 0.004))
    simulation = Simulation(
        Scene(bed(1.0).box, p, 1, 1.0, pair=stiff, integrate=(NveSphere(),), neighbor=Neighbor(0.001), lost="ignore"), on_instability="off"
    )
    simulation.setup()
    with pytest.raises(Unstable, match="the timestep 1 is too long"):
        simulation.advance(200)


def test_particles_far_away_cost_nothing() -> None:
    """Law: the list finds the same pairs, and as fast, when one particle has flown 1e12 boxes off."""
    scene = cluster(np.random.default_rng(2), periodic=False)
    x = scene.particles.x.copy()
    x[3] = 5e10
    away = replace(scene, particles=replace(scene.particles, x=x), box=replace(scene.box, boundary=("mm", "mm", "mm")))
    simulation = Simulation(away, on_instability="off")
    simulation.setup()
    i, j = np.triu_indices(len(x), 1)
    reach = scene.particles.radius[i] + scene.particles.radius[j] + scene.neighbor.skin
    assert len(simulation.pairs.i) == int((np.linalg.norm(x[i] - x[j], axis=1) < reach).sum())


def test_computes_of_known_motion() -> None:
    """Law: ke = m v^2/2, erotate = I omega^2/2 with I = 2/5 m R^2, and erotate of spheres is erotate/sphere."""
    p = spheres(np.zeros((1, 3)), np.array([0.5]), v=np.array([[3.0, 0.0, 4.0]]), omega=np.array([[0.0, 2.0, 0.0]]), density=6 / np.pi)
    assert p.mass[0] == pytest.approx(1.0)
    assert ke(p.mass, p.v) == pytest.approx(12.5)
    assert erotate_sphere(p.mass, p.radius, p.omega).sum() == pytest.approx(0.5 * 0.4 * 0.25 * 4.0)
    assert erotate(Population(p.id, p.mass, p.radius, p.omega)) == erotate_sphere(p.mass, p.radius, p.omega).sum()

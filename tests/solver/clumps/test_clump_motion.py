"""How clumps move: as one, by the forces on their members, and as a sphere where they are one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, Gravity, LostParticles, NveClumps, NveSphere, Scene, Simulation
from demsolver.scene import Clumps
from demsolver.shapes.rotation import to_space
from demsolver.state import Floats
from tests.support.clumps import CENTRE, RADIUS, heap, scene_of, with_clumps
from tests.support.scenes import spheres

STEPS = 400


def begun(scene: Scene, steps: int = 0, **settings: object) -> Simulation:
    simulation = Simulation(scene, **{"on_instability": "off", **settings})  # type: ignore[arg-type]
    simulation.setup()
    simulation.advance(steps)
    return simulation


def momenta(simulation: Simulation) -> tuple[Floats, Floats]:
    """Total momentum, and angular momentum about the origin, (3,) each."""
    p = simulation.particles()
    assert p.clumps is not None
    c, free = p.clumps, p.clumps.body < 0
    x = np.concatenate([p.x[free], c.x])
    linear = np.concatenate([p.mass[free, None] * p.v[free], c.mass[:, None] * c.v])
    spin = (0.4 * p.mass * p.radius**2)[free, None] * p.omega[free]
    return linear.sum(axis=0), np.cross(x, linear).sum(axis=0) + spin.sum(axis=0) + c.angmom.sum(axis=0)


def clumps_of(simulation: Simulation) -> Clumps:
    found = simulation.particles().clumps
    assert found is not None
    return found


@pytest.mark.parametrize("members_weigh", [True, False])
def test_members_stay_where_they_are_in_their_clump(members_weigh: bool) -> None:
    """Law: after 400 steps of a heap every member is at X + Q d with velocity V + w x Q d and spin w, to rounding."""
    simulation = begun(scene_of(heap(1, members_weigh=members_weigh)), STEPS)
    p, c = simulation.particles(), clumps_of(simulation)
    member = c.body >= 0
    who = c.body[member]
    arm = to_space(c.quat[who], c.offset[member])
    assert np.abs(p.x[member] - c.x[who] - arm).max() < 1e-17
    assert np.abs(p.v[member] - c.v[who] - np.cross(c.omega[who], arm)).max() < 1e-15
    assert (p.omega[member] == c.omega[who]).all()
    assert np.abs(np.linalg.norm(c.quat, axis=1) - 1.0).max() < 1e-15
    along = to_space(c.quat * [1.0, -1.0, -1.0, -1.0], c.angmom) / c.inertia
    assert np.abs(to_space(c.quat, along) - c.omega).max() < 1e-12 * np.abs(c.omega).max()


def test_force_and_torque_on_a_clump_are_the_sums_over_its_members() -> None:
    """Law: F = sum of f (+ M g where members do not weigh), T = sum of (x - X) x f + t, and both ways of weighing give the same F and T."""
    found = []
    for members_weigh in (True, False):
        simulation = begun(scene_of(heap(2, members_weigh=members_weigh, inward=60.0, spacing=0.016)), 550)
        c, (f, t), (force, torque) = clumps_of(simulation), simulation.forces(), simulation.clump_forces()
        x = simulation.particles().x
        assert np.abs(f).max() > 0.05  # some touch
        for k in range(len(c.id)):
            own = c.body == k
            weight = np.zeros(3) if members_weigh else c.mass[k] * np.array([0.0, 0.0, -9.81])
            assert np.abs(f[own].sum(axis=0) + weight - force[k]).max() < 1e-13 * np.abs(f).max()
            assert np.abs((np.cross(x[own] - c.x[k], f[own]) + t[own]).sum(axis=0) - torque[k]).max() < 1e-15 * np.abs(f).max()
        found.append((c.x, c.v, c.omega))
    for ours, theirs in zip(*found, strict=True):
        assert np.abs(ours - theirs).max() < 1e-9 * np.abs(ours).max()  # the axes have other names, and gravity another place


def test_no_contact_inside_a_clump() -> None:
    """Law: members of one clump overlap by millimetres and are neither listed nor feel a force."""
    scene = scene_of(heap(3, clumps=2, free=1, speed=0.0, spacing=0.05))
    simulation = begun(replace(scene, forces=(), neighbor=replace(scene.neighbor, skin=0.2)))
    pairs, c = simulation.pairs, clumps_of(simulation)
    assert len(pairs.i) == 4 * 4 + 2 * 4  # of the clumps with each other and with the sphere, none inside
    assert not ((c.body[pairs.i] == c.body[pairs.j]) & (c.body[pairs.i] >= 0)).any()
    assert not simulation.forces()[0].any()


@pytest.mark.parametrize("partner", ["clump", "sphere", "unmoved sphere", "wall"])
def test_who_touches_a_clump_pushes_it_back(partner: str) -> None:
    """Law: members touch other clumps, free, unmoved and frozen spheres and walls; with an undamped spring the force is kn times the overlap."""
    kn, overlap = 1e4, 1e-4
    centre = np.array([0.0, 0.0, 0.1])
    x = np.concatenate([centre + CENTRE, centre + CENTRE + [0.0, 0.0, 0.05], centre[None] + [0.0, -0.05, 0.0]])
    radius = np.concatenate([RADIUS, RADIUS, [5e-3]])
    top = 3  # the member that is highest
    if partner == "clump":
        x[4:8] = centre + CENTRE + [0.0, 0.0, CENTRE[3, 2] + 3e-3 + 5e-3 - overlap] + [CENTRE[3, 0], CENTRE[3, 1], 0.0]
    elif partner == "wall":
        x[:, 2] -= x[0, 2] - 5e-3 + overlap
        top = 0
    else:
        x[8] = centre + CENTRE[3] + [0.0, 0.0, 8e-3 - overlap]
    p = with_clumps(spheres(x, radius), np.array([0] * 4 + [1] * 4 + [-1]))
    integrate = (NveClumps(),) if partner == "unmoved sphere" else (NveSphere(), NveClumps())
    simulation = begun(replace(scene_of(p, integrate=integrate), forces=()))
    force = simulation.forces()[0]
    sign = 1.0 if partner == "wall" else -1.0
    assert force[top, 2] == pytest.approx(sign * kn * overlap, rel=1e-9)
    assert simulation.clump_forces()[0][0, 2] == pytest.approx(sign * kn * overlap, rel=1e-9)
    assert np.abs(force[:4][np.arange(4) != top]).max() < 1e-12


def test_momentum_and_angular_momentum_stay_where_nothing_else_acts() -> None:
    """Law: clumps and spheres that collide with damping and friction keep the sums of momentum and of angular momentum to rounding."""
    p = heap(4, clumps=4, free=4, inward=40.0)
    scene = replace(scene_of(p, pair=replace(scene_of(p).pair, torque_arm="contact")), forces=(), walls=())  # type: ignore[arg-type, type-var]
    simulation = Simulation(scene, budget=True, on_instability="off")
    simulation.setup()
    first, kinetic = momenta(simulation), simulation.energy_budget().kinetic
    simulation.advance(2000)
    linear, angular = momenta(simulation)
    assert simulation.energy_budget().damped > 0.05 * kinetic
    assert np.abs(linear - first[0]).max() < 1e-14 * np.abs(p.mass[:, None] * p.v).sum()
    assert np.abs(angular - first[1]).max() < 1e-12 * np.abs(first[1]).max()


def test_a_clump_of_one_sphere_moves_as_that_sphere() -> None:
    """Law: of a heap of spheres each is made a clump of one; places, velocities and spins over 1,000 steps are those of free spheres to rounding."""
    rng = np.random.default_rng(5)
    x = np.array([[0.0, 0.0, 0.006], [0.009, 0.002, 0.007], [0.001, 0.009, 0.011]])
    p = spheres(x, np.array([0.005, 0.0045, 0.004]), v=rng.normal(0.0, 0.2, (3, 3)), omega=rng.normal(0.0, 20.0, (3, 3)))
    whole = with_clumps(p, np.arange(3), v=p.v, omega=p.omega)
    free, clumped = (begun(scene_of(one), 1000) for one in (with_clumps(p, np.array([0, -1, -1]), v=p.v[:1], omega=p.omega[:1]), whole))
    plain = begun(replace(scene_of(p), integrate=(NveSphere(),)), 1000)
    want = plain.particles()
    for simulation in (free, clumped):
        found = simulation.particles()
        for name in ("x", "v", "omega"):
            a, b = getattr(found, name), getattr(want, name)
            assert np.abs(a - b).max() < 1e-10 * np.abs(b).max(), name


@pytest.mark.parametrize("scheme", ["exact", "no_squish", "richardson"])
def test_a_free_clump_keeps_what_its_scheme_keeps(scheme: str) -> None:
    """Law: without forces angular momentum stays to the last bit (no_squish: rounding); over 100,000 steps the exact scheme keeps the energy to a
    tenth of a rounding a step, the others to dt^2."""
    p = heap(6, clumps=1, free=0)
    scene = replace(scene_of(p, integrate=(NveClumps(scheme=scheme),), dt=1e-4), forces=(), walls=())
    still = replace(scene, particles=replace(p, v=np.zeros_like(p.v)))
    assert p.clumps is not None
    p.clumps.v[:] = 0.0
    simulation = begun(still)
    first = clumps_of(simulation)
    simulation.advance(100_000)
    last = clumps_of(simulation)
    assert np.abs(last.angmom - first.angmom).max() <= (1e-10 if scheme == "no_squish" else 0.0) * np.abs(first.angmom).max()
    before, after = float(np.sum(first.angmom * first.omega)), float(np.sum(last.angmom * last.omega))
    assert abs(after / before - 1.0) < {"exact": 3e-12, "no_squish": 1e-4, "richardson": 1e-2}[scheme]
    assert (last.x == first.x).all()


@pytest.mark.parametrize("members_weigh", [True, False])
def test_clumps_that_nothing_integrates_stand_still(members_weigh: bool) -> None:
    """Law: without NveClumps members keep their places and velocities, and spheres bounce off them."""
    p = heap(7, clumps=2, free=2, speed=0.0, spacing=0.011, members_weigh=members_weigh)
    simulation = begun(scene_of(p, integrate=(NveSphere(),)), STEPS)
    found, c = simulation.particles(), clumps_of(simulation)
    member = c.body >= 0
    assert p.clumps is not None
    assert np.abs(found.x[member] - p.x[member]).max() < 1e-17
    assert (c.x == p.clumps.x).all()
    assert (c.quat == p.clumps.quat).all()
    assert not found.v[member].any()
    assert found.v[~member].any()


def test_a_clump_falls_as_a_whole() -> None:
    """Law: a free clump falls along the parabola of its centre of mass, whichever way gravity is counted, and its spin is not touched."""
    for members_weigh in (True, False):
        p = heap(8, clumps=1, free=0, members_weigh=members_weigh)
        assert p.clumps is not None
        scene = replace(scene_of(p, dt=1e-5), walls=())
        simulation = begun(scene, 1000)
        t, c = 1e-2, clumps_of(simulation)
        assert np.abs(c.x - p.clumps.x - p.clumps.v * t - 0.5 * np.array([0.0, 0.0, -9.81]) * t * t).max() < 1e-15
        assert np.abs(c.angmom - p.clumps.angmom).max() < 1e-12 * np.abs(p.clumps.angmom).max()


def test_a_lost_member_ends_the_run() -> None:
    """Law: a clump goes on without no member: where one leaves through a fixed face the run ends and names it, though lost spheres may go."""
    p = heap(9, clumps=1, free=0, speed=0.0)
    scene = scene_of(p, box=Box(np.array([-0.1, -0.1, -0.1]), np.array([0.1, 0.1, 0.1]), ("ff", "ff", "ff")))
    scene = replace(scene, forces=(Gravity((2000.0, 0.0, 0.0)),), lost="ignore")
    simulation = begun(scene)
    with pytest.raises(LostParticles, match=r"left the box by step \d+, the first with id \d"):
        simulation.advance(3000)

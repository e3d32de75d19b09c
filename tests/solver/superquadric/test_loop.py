"""The step loop with superquadrics: equal to the plain engine, to spheres where they are spheres, with spheres among them, and over restarts."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from demsolver import Box, NveSphere, Particles, Scene, Simulation, Unstable
from demsolver.superquadric.reference import Planes, Shaped, forces, step
from tests.support.superquadric_decks import scene_of
from tests.support.superquadrics import lattice, particles

DT = 4e-5


@cache
def laws() -> Scene:
    """Hertz with friction and rolling (epsd), pairs and the plane z = -0.9."""
    return scene_of("roll_epsd")


def heap(shape: tuple[int, int, int], seed: int = 1) -> Scene:
    """Random bodies that overlap each other, and the plane below."""
    p = lattice(np.random.default_rng(seed), shape)
    return replace(laws(), particles=replace(p, x=p.x + np.array([0.0, 0.0, -0.9 + 0.022])))


def shaped(p: Particles) -> Shaped:
    """The same bodies for the plain engine."""
    assert p.superquadrics
    s = p.superquadrics
    return Shaped(p.x, p.v, s.quat, s.angmom, p.omega, s.axes, s.blockiness, p.mass, s.inertia)


def test_the_loop_is_the_plain_engine() -> None:
    """Law (simple == fast): friction, rolling, damping, pairs and planes: forces, torques and motion are equal to what the contact points are
    converged to, over 30 steps."""
    scene = heap((3, 2, 2))
    assert scene.pair
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    planes = (Planes("w0", 2, -0.9, scene.walls[0].law),)
    plain = shaped(scene.particles)
    force, torque, history = forces(plain, scene.pair, planes, {}, DT, False)
    assert len(history) > 8
    assert any(name == "w0" for name, _, _ in history)
    for _ in range(30):
        f, t = simulation.forces()
        assert np.abs(f - force).max() <= 1e-11 * np.abs(force).max()
        assert np.abs(t - torque).max() <= 1e-10 * np.abs(torque).max()
        plain, force, torque, history = step("no_squish", plain, force, torque, scene.pair, planes, history, DT, np.zeros(3))
        simulation.advance(1)
    now = simulation.particles()
    assert now.superquadrics
    assert now.x == pytest.approx(plain.x, abs=1e-14)
    assert now.omega == pytest.approx(plain.omega, rel=1e-9, abs=1e-9)
    assert now.superquadrics.quat == pytest.approx(plain.quat, abs=1e-13)


def balls(apart: float = 0.0395) -> Particles:
    """Eight spheres on a cube, overlapping, moving and spinning; as rows of zeros among superquadrics."""
    rng = np.random.default_rng(5)
    x = apart * np.array(list(np.ndindex(2, 2, 2)), dtype=float) + np.array([0.0, 0.0, -0.9 + 0.0195])
    v, omega = rng.normal(0.0, 0.1, (8, 3)), rng.normal(0.0, 20.0, (8, 3))
    return particles(x, np.zeros((8, 3)), np.full((8, 2), 0.02), np.tile([1.0, 0.0, 0.0, 0.0], (8, 1)), v, omega)


def alone() -> Scene:
    """They in a scene of spheres."""
    return replace(laws(), particles=replace(balls(), superquadrics=None), integrate=(NveSphere(),))


def test_spheres_among_superquadrics_are_spheres() -> None:
    """Law: a row of zeros in `axes` is a sphere: its contacts with spheres and planes, with friction and rolling, and its motion are those of a
    scene of spheres alone, though superquadrics collide beside it."""
    there = lattice(np.random.default_rng(2), (2, 2, 1))
    both = balls()
    shapes = there.superquadrics
    assert shapes
    assert both.superquadrics
    names, inner = ("type", "x", "v", "omega", "radius", "mass", "mask", "image"), ("axes", "blockiness", "quat", "inertia", "angmom")
    mixed = {name: np.concatenate([getattr(both, name), getattr(there, name)]) for name in names}
    mixed["x"][8:] = 0.3 + 0.88 * there.x
    joined = {name: np.concatenate([getattr(both.superquadrics, name), getattr(shapes, name)]) for name in inner}
    p = Particles(id=np.arange(1, 13), **mixed, superquadrics=type(shapes)(**joined))
    one, other = Simulation(replace(laws(), particles=p), on_instability="off"), Simulation(alone(), on_instability="off")
    one.setup(), other.setup()
    busy = []
    for steps in (0, 1, 100):
        one.advance(steps), other.advance(steps)
        for mine, theirs in zip(one.forces(), other.forces(), strict=True):
            assert np.abs(mine[:8] - theirs).max() <= 1e-12 * np.abs(theirs).max()
        busy.append(np.abs(one.forces()[0][8:]).max() > 1.0)
    assert any(busy)
    mine, theirs = one.particles(), other.particles()
    assert mine.x[:8] == pytest.approx(theirs.x, abs=1e-15)
    assert mine.omega[:8] == pytest.approx(theirs.omega, rel=1e-11)


def test_equal_axes_feel_the_forces_of_spheres() -> None:
    """Law: superquadrics with equal axes and exponents 2, at rest, have the normal forces of spheres; and so has a sphere that touches one."""
    still = replace(balls(), v=np.zeros((8, 3)), omega=np.zeros((8, 3)))
    shapes = still.superquadrics
    assert shapes
    plain = Simulation(replace(alone(), particles=replace(still, superquadrics=None)), on_instability="off")
    plain.setup()
    wanted = plain.forces()[0]
    for rows in (np.arange(8), np.arange(4)):
        axes = shapes.axes.copy()
        axes[rows] = 0.02
        radius = np.where(axes[:, 0] > 0.0, 0.02 * 1.0001, 0.02)
        p = replace(still, radius=radius, superquadrics=replace(shapes, axes=axes, angmom=np.zeros((8, 3))))
        simulation = Simulation(replace(laws(), particles=p), on_instability="off")
        simulation.setup()
        force, torque = simulation.forces()
        assert np.abs(force - wanted).max() <= 1e-10 * np.abs(wanted).max()
        assert np.abs(torque).max() <= 1e-10 * 0.02 * np.abs(wanted).max()


def halves(scene: Scene, steps: int) -> tuple[Simulation, Simulation]:
    """A simulation that has run through, and one half way."""
    whole, half = Simulation(scene, on_instability="off"), Simulation(scene, on_instability="off")
    whole.setup(), half.setup()
    whole.advance(steps // 2), half.advance(steps // 2)
    return whole, half


def same(one: Simulation, other: Simulation) -> bool:
    """Whether two simulations are in one state, to the last bit."""
    p, q = one.particles(), other.particles()
    assert p.superquadrics
    assert q.superquadrics
    pairs = [(getattr(p, name), getattr(q, name)) for name in ("x", "v", "omega")]
    pairs += [(getattr(p.superquadrics, name), getattr(q.superquadrics, name)) for name in ("quat", "angmom")]
    return all(np.array_equal(a, b) for a, b in [*pairs, *zip(one.forces(), other.forces(), strict=True)])


def test_a_second_run_and_what_contacts_remember() -> None:
    """Law: `continue_with` goes on as a deck's second run does, and a simulation that recalls the memories of another does the same to the last bit;
    without them springs and dashpots of rolling begin anew, and it does not."""
    scene = heap((3, 2, 2))
    whole, half = halves(scene, 60)
    later = replace(scene, particles=half.particles())
    second, recalled, forgot = half.continue_with(later), Simulation(later, on_instability="off"), Simulation(later, on_instability="off")
    recalled.recall(half.memories())
    ways = [second, recalled, forgot]
    for way in ways:
        way.setup(), way.advance(30)
    third = whole.continue_with(replace(scene, particles=whole.particles()))
    third.setup(), third.advance(30)
    assert same(second, third)
    assert same(recalled, second)
    assert not same(forgot, second)


def test_lists_may_be_renewed_at_any_time() -> None:
    """Law: the neighbour list is made anew in every step, or hardly ever: forces are the same to what contact points are converged to."""
    scene = heap((3, 2, 2), seed=3)
    often = replace(scene, neighbor=replace(scene.neighbor, every=1, delay=0, check=False))
    one, other = Simulation(scene, on_instability="off"), Simulation(often, on_instability="off")
    one.setup(), other.setup()
    one.advance(100), other.advance(100)
    assert other._lists > one._lists + 50
    for mine, theirs in zip(one.forces(), other.forces(), strict=True):
        assert np.abs(mine - theirs).max() <= 1e-9 * np.abs(theirs).max()


def test_bodies_touch_across_periodic_faces() -> None:
    """Law: shifted in a periodic box by any way, bodies feel the same forces and move alike."""
    p = replace(lattice(np.random.default_rng(4), (3, 3, 3), 0.05), image=np.zeros((27, 3), dtype=np.int64))
    box = Box(np.zeros(3), np.full(3, 0.15), ("pp", "pp", "pp"))
    found = []
    for way in (0.01, 0.06):
        moved = replace(p, x=(p.x + way) % 0.15)
        simulation = Simulation(replace(laws(), box=box, particles=moved, walls=()), on_instability="off")
        simulation.setup()
        simulation.advance(60)
        found.append((*simulation.forces(), simulation.particles().omega))
    assert np.abs(found[0][0]).max() > 1.0
    for mine, theirs in zip(*found, strict=True):
        assert np.abs(mine - theirs).max() <= 1e-9 * np.abs(theirs).max()
    assert np.abs(found[0][0].sum(axis=0)).max() <= 1e-11 * np.abs(found[0][0]).max()


def test_any_number_of_threads_gives_the_same_bits() -> None:
    """Law: 1,100 bodies, more than one chunk of rows, that are sorted on the way: results are the same bits on one thread and on two."""
    p = lattice(np.random.default_rng(6), (11, 10, 10))
    scene = replace(laws(), box=replace(laws().box, lo=np.full(3, -2.0), hi=np.full(3, 3.0)), particles=p, walls=())
    one, two = (Simulation(scene, threads=threads, on_instability="off") for threads in (1, 2))
    for simulation in (one, two):
        simulation.setup()
        simulation.advance(15)
    assert two._has.THREADED
    assert (one.pairs.touching & 1).sum() > 500
    assert same(one, two)


def test_what_has_no_contact_point_ends_the_run() -> None:
    """Law: where a centre lies so deep in another body that no point has equal potentials, the run ends with one line; by gauge it goes on."""
    scene = scene_of("deep")
    with pytest.raises(Unstable, match=r"^7 ") as caught:
        Simulation(scene, on_instability="off").setup()
    assert "\n" not in str(caught.value)


def test_what_is_too_blunt_is_told() -> None:
    """Law: two boxes with exponents of 300 push each other away; where they have 1000, the run ends with one line that names it."""
    x, axes = np.array([[0.0, 0.0, 0.0], [0.003, 0.001, 0.048]]), np.full((2, 3), 0.02)
    quat = np.array([[1.0, 0.0, 0.0, 0.0], np.array([1.0, 0.4, 0.0, 0.2]) / np.sqrt(1.2)])
    scenes = [replace(laws(), particles=particles(x, axes, np.full((2, 2), exponent), quat)) for exponent in (300.0, 1000.0)]
    fine, blunt = (Simulation(scene, on_instability="off") for scene in scenes)
    fine.setup()
    assert fine.forces()[0][1, 2] > 1.0
    with pytest.raises(Unstable, match=r"^1 contacts .*: a blockiness of 1000 leaves rounding alone of its equations; make it 300 at most, or"):
        blunt.setup()

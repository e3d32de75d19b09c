"""Clumps and the neighbour list: faces of the box, sorted rows, threads, runs one after the other, and what contacts remember."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, NveClumps, NveSphere, Scene, Simulation
from demsolver.simulate import SORT_FROM
from demsolver.state import Floats
from tests.support.clumps import heap, scene_of

STEPS = 600


def begun(scene: Scene, steps: int = 0, **settings: object) -> Simulation:
    simulation = Simulation(scene, **{"on_instability": "off", **settings})  # type: ignore[arg-type]
    simulation.setup()
    simulation.advance(steps)
    return simulation


def state(simulation: Simulation) -> list[Floats]:
    """Everything that moves, particles by particles and clumps by clumps."""
    p = simulation.particles()
    assert p.clumps is not None
    c = p.clumps
    return [p.x, p.v, p.omega, *simulation.forces(), c.x, c.v, c.quat, c.angmom, c.omega]


def alike(first: Simulation, second: Simulation) -> bool:
    return all((a == b).all() for a, b in zip(state(first), state(second), strict=True))


def packed(seed: int, clumps: int, free: int) -> Scene:
    """A heap that is dense enough for contacts from the begin on."""
    return scene_of(heap(seed, clumps, free, spacing=0.0145, inward=40.0))


@pytest.mark.parametrize("members_weigh", [True, False])
def test_a_clump_across_a_periodic_face_moves_as_in_a_wide_box(members_weigh: bool) -> None:
    """Law: a heap whose clumps lie across periodic faces, and go through them, moves as the same heap in a wide box, images counted, to 1e-10."""
    p = heap(11, 3, 2, spacing=0.0145, inward=40.0, members_weigh=members_weigh)
    assert p.clumps is not None
    p.clumps.v[:, 0] += 30.0
    p.v[:, 0] += 30.0
    wide = scene_of(p)
    start = float(p.clumps.x[0, 0])  # through the first clump
    lo, hi = np.array([start, -0.5, -0.5]), np.array([start + 0.12, 0.5, 0.5])
    turns = np.floor((p.x[:, 0] - lo[0]) / 0.12).astype(int)
    x, image = p.x.copy(), p.image.copy()
    x[:, 0], image[:, 0] = x[:, 0] - 0.12 * turns, turns
    narrow = replace(wide, box=Box(lo, hi, ("pp", "ff", "ff")), particles=replace(p, x=x, image=image))
    a, b = begun(wide, 400), begun(narrow, 400)
    assert a.forces()[0][:, :2].any()
    assert b.image[:, 0].max() >= 1
    assert len(np.unique(narrow.particles.image[:4, 0])) > 1
    unwrapped = b.particles().x + b.image * (hi - lo)
    assert np.abs(unwrapped - a.particles().x).max() < 1e-10
    for ours, theirs in zip(state(a)[1:], state(b)[1:], strict=True):
        assert np.abs(ours - theirs).max() < 1e-7 * np.abs(ours).max()
    assert (b.particles().x >= lo - 1e-3).all()
    assert (b.particles().x < hi + 1e-3).all()


def test_contacts_reach_through_a_periodic_face() -> None:
    """Law: of two clumps that touch through a face the forces are those of the two side by side."""
    p = heap(12, 2, 0, spacing=0.011, speed=0.0)
    side = begun(replace(scene_of(p), forces=(), walls=()))
    assert side.forces()[0].any()
    between = 0.5 * float(p.x[:4, 0].mean() + p.x[4:, 0].mean())
    x, image = p.x.copy(), p.image.copy()
    image[:, 0] = np.floor((x[:, 0] - between) / 0.2)
    x[:, 0] -= 0.2 * image[:, 0]
    box = Box(np.array([between, -0.5, -0.5]), np.array([between + 0.2, 0.5, 0.5]), ("pp", "ff", "ff"))
    through = begun(replace(scene_of(replace(p, x=x, image=image), box=box), forces=(), walls=()))
    size = np.abs(side.forces()[0]).max()
    for ours, theirs in zip((*side.forces(), *side.clump_forces()), (*through.forces(), *through.clump_forces()), strict=True):
        assert np.abs(ours - theirs).max() < 1e-11 * size


def test_the_order_of_rows_and_the_cadence_of_lists_change_nothing() -> None:
    """Law: with 1,300 members rows are sorted in space; particles given in another order, and lists made in every step, move alike to 1e-10."""
    scene = packed(13, 320, 40)
    n = len(scene.particles.id)
    assert n > SORT_FROM
    rng = np.random.default_rng(1)
    order = rng.permutation(n)
    mixed = replace(scene, particles=scene.particles.rows(order))
    eager = replace(scene, neighbor=replace(scene.neighbor, check=False))
    plain = begun(scene, 150)
    assert np.abs(plain.forces()[0]).max() > 1.0
    place = np.argsort(order)
    for other, rows in ((begun(mixed, 150), place), (begun(eager, 150), np.arange(n))):
        for a, b in zip(state(plain)[:5], state(other)[:5], strict=True):
            assert np.abs(a - b[rows]).max() < 1e-10 * np.abs(a).max()


def test_threads_give_the_same_bits() -> None:
    """Law: 1,300 members and 40 spheres move to the same bits with one thread and with two."""
    scene = packed(13, 320, 40)
    assert alike(begun(scene, 150), begun(scene, 150, threads=2))


def test_runs_go_on_where_they_stood() -> None:
    """Law: `continue_with` the same scene is one run but for its set-up: clumps and what contacts remember go on, as with `recall`, to the bit."""
    scene = packed(14, 3, 3)
    simulation = begun(scene, 100)
    on = simulation.continue_with(replace(scene, particles=simulation.particles(), box=simulation.box()))
    again = Simulation(replace(scene, particles=simulation.particles(), box=simulation.box()), on_instability="off")
    again.recall(simulation.memories())
    again.step = simulation.step
    assert simulation.pairs.memory.any()
    for one in (on, again):
        one.setup()
        one.advance(500)
    assert on.step == 600
    assert alike(on, again)
    whole = begun(scene, 600)
    assert np.abs(on.particles().x - whole.particles().x).max() < 1e-5  # a set-up sees full-step velocities: of first order in dt


def test_a_run_may_begin_and_end_without_an_integrator() -> None:
    """Law: clumps that stood in one run move in the next, and the other way round."""
    scene = scene_of(heap(15, 2, 1, spacing=0.03, speed=0.0))
    still = begun(replace(scene, integrate=(NveSphere(),)), 50)
    first = still.particles()
    moving = still.continue_with(replace(scene, particles=first))
    moving.setup()
    moving.advance(50)
    now = moving.particles()
    assert now.clumps is not None
    assert first.clumps is not None
    assert (now.clumps.x[:, 2] < first.clumps.x[:, 2]).all()
    stopped = moving.continue_with(replace(scene, particles=now, integrate=(NveSphere(),)))
    stopped.setup()
    stopped.advance(50)
    last = stopped.particles()
    assert last.clumps is not None
    assert (last.clumps.x == now.clumps.x).all()


def test_mixed_precision_is_close() -> None:
    """Law: forces summed from float32 vectors move a heap of clumps within 1e-4 of the way it goes."""
    scene = packed(16, 3, 3)
    double, mixed = begun(scene, STEPS), begun(scene, STEPS, precision="mixed")
    way = np.abs(double.particles().x - scene.particles.x).max()
    assert np.abs(double.particles().x - mixed.particles().x).max() < 1e-4 * way


def test_only_clumps() -> None:
    """Law: a scene without a free sphere needs no NveSphere, and moves as with one."""
    p = heap(17, 3, 0, spacing=0.0145)
    assert alike(begun(scene_of(p, integrate=(NveClumps(),)), STEPS), begun(scene_of(p), STEPS))

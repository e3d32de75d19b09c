"""What contacts remember, taken out of one simulation and taken up by another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import Box, NveSphere, Scene, Simulation, Slab, Wall
from demsolver.memories import Memories
from tests.support.laws import contact_law
from tests.support.scenes import cluster, law, spheres

LAWS = {
    "rotated": {},
    "projected": {"friction": "classic_history"},
    "rolling and twisting": {"rolling": "sds", "twisting": "sds"},
    "no memory": {"friction": "none"},
}


def scene_with(names: dict[str, str], seed: int, *, periodic: bool = True) -> Scene:
    scene = cluster(np.random.default_rng(seed), periodic=periodic)
    walls = (Wall("slab", scene.walls[0].shape, contact_law((1,), **names)),)
    return replace(scene, pair=contact_law(**names), walls=walls, timestep=1e-6)


def begun(scene: Scene, steps: int = 20, **settings: object) -> Simulation:
    simulation = Simulation(scene, **settings, on_instability="off")
    simulation.setup()
    simulation.advance(steps)
    return simulation


def state(simulation: Simulation) -> list[np.ndarray]:
    found = simulation.memories()
    p, forces = simulation.particles(), simulation.forces()
    walls = [part for wall in found.walls.values() for part in (wall.memory, wall.touching)]
    return [p.x, p.v, p.omega, p.image, *forces, found.i, found.j, found.shift, found.touching, found.memory, *walls]


def both_ways(first: Simulation, steps: int = 20) -> tuple[Simulation, Simulation]:
    """The simulation continued, and a new one that recalls its memories; each set up and run on."""
    scene = replace(first.scene, particles=first.particles(), box=first.box())
    again = Simulation(scene, on_instability="off")
    again.recall(first.memories())
    again.step = first.step
    on = first.continue_with(scene)
    for one in (on, again):
        one.setup()
        one.advance(steps)
    return on, again


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("name", LAWS)
def test_what_is_recalled_goes_on_to_the_last_bit(name: str, periodic: bool) -> None:
    """Law: state and memories are all there is: from them the motion is the same, bit for bit."""
    first = begun(scene_with(LAWS[name], 1, periodic=periodic))
    on, again = both_ways(first)
    assert name == "no memory" or np.abs(first.memories().memory).max() > 0.0
    assert all(np.array_equal(a, b) for a, b in zip(state(on), state(again), strict=True))


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.sampled_from(["rotated", "rolling and twisting"]))
def test_any_state_can_be_recalled(seed: int, steps: int, name: str) -> None:
    """Law: the same, of any state; and what is taken out again at once is what was put in."""
    first = begun(scene_with(LAWS[name], seed), steps)
    found = first.memories()
    fresh = Simulation(replace(first.scene, particles=first.particles(), box=first.box()), on_instability="off")
    fresh.recall(found)
    for a, b in zip(vars(found).values(), vars(fresh.memories()).values(), strict=True):
        assert isinstance(a, dict | tuple) or np.array_equal(a, b)
    on, again = both_ways(first)
    assert all(np.array_equal(a, b) for a, b in zip(state(on), state(again), strict=True))


def test_the_order_of_particles_does_not_matter_to_what_is_remembered() -> None:
    """Law: memories belong to ids: with the particles listed backwards the motion is the same to rounding, signs of exchange included."""
    first = begun(scene_with(LAWS["rolling and twisting"], 5))
    p = first.particles()
    backwards = p.rows(np.arange(len(p.id))[::-1])
    other = Simulation(replace(first.scene, particles=backwards, box=first.box()), on_instability="off")
    found = first.memories()
    other.recall(replace(found, rows=found.rows[::-1].copy()))
    other.step = first.step
    on, _ = both_ways(first)
    other.setup()
    other.advance(20)
    moved = np.abs(on.particles().x - p.x).max()
    assert np.abs(other.particles().x[::-1] - on.particles().x).max() < 1e-10 * moved
    without = Simulation(replace(first.scene, particles=p, box=first.box()), on_instability="off")
    without.setup()
    without.advance(20)
    assert np.abs(without.particles().x - on.particles().x).max() > 1e-7 * moved


def test_particles_that_are_gone_take_their_memories_along() -> None:
    """Law: contacts of those that are left go on; nothing is remembered of others."""
    first = begun(scene_with(LAWS["rotated"], 2))
    p = first.particles()
    keep = np.arange(len(p.id)) % 3 > 0
    fewer = p.rows(keep)
    other = Simulation(replace(first.scene, particles=fewer, box=first.box()), on_instability="off")
    other.recall(first.memories())
    was, now = first.memories(), other.memories()
    stays = np.isin(was.i, fewer.id) & np.isin(was.j, fewer.id)

    def rows(m: Memories, chosen: np.ndarray) -> set[tuple[float, ...]]:
        return {(float(min(i, j)), float(max(i, j)), *np.abs(v)) for i, j, v in zip(m.i[chosen], m.j[chosen], m.memory[chosen], strict=True)}

    assert rows(now, np.ones(len(now.i), dtype=bool)) == rows(was, stays)
    assert np.array_equal(now.walls["slab"].memory, was.walls["slab"].memory[keep])


def test_walls_are_known_by_name() -> None:
    """Law: a wall of another name starts without memory."""
    first = begun(scene_with(LAWS["rotated"], 3))
    scene = replace(first.scene, particles=first.particles(), walls=(replace(first.scene.walls[0], name="other"),))
    other = Simulation(scene, on_instability="off")
    other.recall(first.memories())
    assert np.abs(first.memories().walls["slab"].memory).max() > 0.0
    assert not other.memories().walls["other"].memory.any()


def test_the_energy_account_goes_on() -> None:
    """Law: what was dissipated before counts afterwards; the total is that of the continued run."""
    first = begun(scene_with(LAWS["rotated"] | {"damping": "mass_velocity"}, 4), budget=True)
    again = Simulation(replace(first.scene, particles=first.particles(), box=first.box()), budget=True, on_instability="off")
    again.recall(first.memories())
    on = first.continue_with(again.scene)
    for one in (on, again):
        one.setup()
        one.advance(20)
    assert again.energy_budget() == on.energy_budget()
    assert again.energy_budget().damped > 0.0


@pytest.mark.parametrize("where", ["pairs", "wall slab"])
def test_memory_of_another_law_is_refused(where: str) -> None:
    """Law: columns mean what the law that wrote them says; another law must not read them."""
    first = begun(scene_with(LAWS["rolling and twisting"], 1))
    changed = {"pair": contact_law()} if where == "pairs" else {"walls": (Wall("slab", first.scene.walls[0].shape, contact_law((1,))),)}
    with pytest.raises(ValueError, match=f"^{where}: contacts remember friction rotated_history, rolling sds, twisting sds, and cannot go on with"):
        Simulation(replace(first.scene, **changed), on_instability="off").recall(first.memories())


def test_those_that_move_may_change_between_runs() -> None:
    """Law: only particles of the integrated group move, also where another group did in the run before."""
    x = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.1, 0.0, 0.0]])
    p = replace(spheres(x, np.full(3, 0.005), v=np.ones((3, 3)) * [1.0, 0.0, 0.0]), mask=np.array([3, 3, 5]))
    box = Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))
    for pair in (None, law((1, 1))):
        scene = Scene(box, p, 1, 1e-3, pair=pair, walls=(Wall("floor", Slab(2, lo=-0.5), law((1,))),), integrate=(NveSphere(1),))
        first = begun(scene, 10)
        second = first.continue_with(replace(scene, particles=first.particles(), integrate=(NveSphere(2),)))
        second.setup()
        second.advance(10)
        assert second.particles().x[:, 0] == pytest.approx([0.01, 0.06, 0.11], abs=1e-12)

"""Islands at rest sleep without being asked to do anything, and wake before anything touches them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, Gravity, Neighbor, NveSphere, Plane, Scene, Simulation, Slab, Sleep, Wall
from demsolver.specialise import features
from tests.support.scenes import law, spheres

RADIUS, DT = 0.005, 1e-5
SPEED = 1e-4
SLEEP = Sleep(SPEED, 50)
DOWN = Gravity((0.0, 0.0, -9.81))
BASE = [(i, j, 1.0) for i in (0.0, 2.0, 4.0) for j in (0.0, 2.0, 4.0)]
HEAP = [(i, j, 1.0 + np.sqrt(2.0)) for i in (1.0, 3.0) for j in (1.0, 3.0)] + [(2.0, 2.0, 1.0 + 2.0 * np.sqrt(2.0))]
FIRST, SECOND, BALL = slice(9, 14), slice(23, 28), 28


def heaps(x: float = 30.0, z: float = 1.0, v: float = 0.0) -> Scene:
    """Two pyramids, of five balls each on nine that nothing moves, and a ball at (x, 7, z) radii that moves at v along z, over a floor."""
    base = np.array(BASE + HEAP)
    places = np.vstack([base + np.array([shift, 5.0, 0.0]) for shift in (5.0, 18.0)] + [np.array([[x, 7.0, z]])]) * RADIUS
    speed = np.zeros((len(places), 3))
    speed[BALL, 2] = v
    p = spheres(places, np.full(len(places), RADIUS), v=speed)
    still = np.arange(len(places)) % 14 < 9
    still[BALL] = False
    p = replace(p, mask=np.where(still, 1, 3))
    box = Box(np.zeros(3), np.full(3, 40 * RADIUS), ("ff", "ff", "ff"))
    floor = Wall("floor", Slab(2, lo=0.0), law((1,)))
    return Scene(box, p, 1, DT, pair=law((1, 1)), walls=(floor,), forces=(DOWN,), integrate=(NveSphere(1),), neighbor=Neighbor(0.2 * RADIUS))


def run(scene: Scene, steps: int, **settings: object) -> Simulation:
    """A scene so many steps later."""
    simulation = Simulation(scene, **settings, on_instability="off")  # type: ignore[arg-type]
    simulation.setup()
    simulation.advance(steps)
    return simulation


def entries(simulation: Simulation) -> int:
    """Near pairs, which the steps go over."""
    chunks = simulation._near.chunks
    return int((chunks[:, 1] - chunks[:, 0] + chunks[:, 3] - chunks[:, 2]).sum())


def test_heaps_at_rest_fall_asleep() -> None:
    """Law: who sleeps has no velocity, no net force and no pair in the steps, stands where it stood, and keeps what its contacts remember; what
    nothing moves anyway is no sleeper."""
    simulation = run(heaps(), 4000, sleep=SLEEP)
    assert np.array_equal(simulation.asleep, simulation.scene.particles.mask == 3)
    before, memory = simulation.particles(), simulation.pairs.memory
    simulation.advance(1000)
    after, (force, torque) = simulation.particles(), simulation.forces()
    assert entries(simulation) == 0
    assert np.array_equal(before.x, after.x)
    assert not np.any([after.v, after.omega, force * simulation.asleep[:, None], torque * simulation.asleep[:, None]])
    assert np.any(memory)
    assert np.array_equal(simulation.pairs.memory, memory)


def test_the_error_is_bounded() -> None:
    """Law: positions are off by less than speed times the time of the run."""
    steps = 4000
    awake, asleep = run(heaps(), steps), run(heaps(), steps, sleep=SLEEP)
    assert asleep.asleep.any()
    assert np.linalg.norm(asleep.particles().x - awake.particles().x, axis=1).max() < SPEED * steps * DT


def test_an_island_wakes_whole_and_alone() -> None:
    """Law: a ball that comes down on a heap wakes all of it before they touch: both go on as if nobody had slept; the other heap sleeps on."""
    scene = heaps(7.0, 38.5, -1.5)
    awake, sleepy = run(scene, 0), run(scene, 0, sleep=SLEEP)
    slept, steps = 0, 0
    while steps < 12_000 and not (slept and not sleepy.asleep[FIRST].any() and sleepy.forces()[0][BALL, 2] > 0.0):
        for simulation in (awake, sleepy):
            simulation.advance(50)
        slept += int(sleepy.asleep[FIRST].all())
        steps += 50
    assert 20 < slept < steps // 50 < 200  # until the ball was there
    assert sleepy.asleep[SECOND].all()
    for simulation in (awake, sleepy):
        simulation.advance(100)
    apart = np.linalg.norm(awake.particles().x - sleepy.particles().x, axis=1)
    pushed = np.linalg.norm(sleepy.particles().x - scene.particles.x, axis=1)[FIRST]
    assert pushed.min() > 100 * apart.max()


def test_who_flies_never_sleeps() -> None:
    """Law: a ball at the top of its flight is slow but touches nothing, and goes on to fall as if nobody looked."""
    steps = 700
    simulation = run(heaps(30.0, 20.0, 1e-5), steps, sleep=Sleep(1.0, 1))
    assert simulation.asleep[FIRST].all()
    assert not simulation.asleep[BALL]
    assert simulation.particles().v[BALL, 2] == pytest.approx(1e-5 - 9.81 * steps * DT, rel=1e-12)


def test_a_new_run_wakes_all() -> None:
    """Law: what has changed between two runs is felt: without its floor a sleeping ball falls."""
    simulation = run(heaps(), 4000, sleep=SLEEP)
    assert simulation.asleep[BALL]
    other = simulation.continue_with(replace(simulation.scene, particles=simulation.particles(), walls=()))
    assert not other.asleep.any()
    other.setup()
    other.advance(100)
    assert other.particles().v[BALL, 2] == pytest.approx(-9.81 * 100 * DT, rel=1e-12)


def test_off_by_default() -> None:
    """Law: nobody sleeps unless asked to, and then the loop knows nothing of it; asked for in vain it changes no bit."""
    plain, sleepless = run(heaps(), 2000), run(heaps(), 2000, sleep=Sleep(1e-30))
    assert not plain.asleep.any()
    assert not features(heaps()).SLEEPS
    for name in ("x", "v", "omega"):
        assert np.array_equal(getattr(plain.particles(), name), getattr(sleepless.particles(), name))


@pytest.mark.parametrize(
    ("change", "settings", "message"),
    [
        ({}, {"budget": True}, "the energy budget and the virial need every contact"),
        ({}, {"virial": True}, "the energy budget and the virial need every contact"),
        ({}, {"sleep": Sleep(0.0)}, "sleep needs a speed above 0 and steps between looks, not speed 0 every 100"),
        ({}, {"sleep": Sleep(1.0, 0)}, "sleep needs a speed above 0 and steps between looks, not speed 1 every 0"),
        ({"walls": (Wall("lid", Plane((0.0, 0.0, -1.0), 0.1, velocity=(0.0, 0.0, 1.0)), law((1,))),)}, {}, "wall lid moves"),
    ],
)  # fmt: skip
def test_what_cannot_sleep_is_refused(change: dict[str, object], settings: dict[str, object], message: str) -> None:
    """Law: who needs every contact in every step is told so in a line."""
    with pytest.raises(ValueError, match=message):
        Simulation(replace(heaps(), **change), **{"sleep": SLEEP, **settings}, on_instability="off")  # type: ignore[arg-type]

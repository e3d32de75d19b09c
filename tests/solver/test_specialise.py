"""Only what a scene has is there, what is not there changes no bit, and neither do threads, chunks, order and the near list."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, ContactLaw, Freeze, Gravity, LostParticles, Neighbor, NveSphere, Particles, Scene, Simulation, Slab, Wall
from demsolver.specialise import CHUNK, features, source
from tests.support.scenes import law, spheres

RADIUS = 0.005


def gas(n: int = 60, *, seed: int = 1, size: float = 0.06, speed: float = 1.0, friction: str = "none", periodic: bool = False) -> Scene:
    """Equal spheres on a jittered grid in a box, flying at random. Contacts last some 40 steps."""
    rng = np.random.default_rng(seed)
    cells = int(np.ceil(n ** (1 / 3)))
    grid = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[rng.permutation(cells**3)[:n]]
    x = (grid + 0.5) * size / cells + rng.uniform(-0.1, 0.1, (n, 3)) * (size / cells - 2 * RADIUS)
    p = spheres(x, np.full(n, RADIUS), v=rng.normal(0, speed, (n, 3)))
    box = Box(np.zeros(3), np.full(3, size), ("pp", "pp", "pp")) if periodic else Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))
    return Scene(box, p, 1, 1e-5, pair=law((1, 1), friction=friction), integrate=(NveSphere(),), neighbor=Neighbor(0.001))


def after(scene: Scene, steps: int = 200, **settings: object) -> Particles:
    """The particles of a scene so many steps later."""
    simulation = Simulation(scene, **settings, on_instability="off")  # type: ignore[arg-type]
    simulation.setup()
    simulation.advance(steps)
    return simulation.particles()


def same(a: Particles, b: Particles) -> bool:
    """Whether the first particles of b are those of a, bit for bit."""
    n = len(a.id)
    return all(np.array_equal(getattr(a, name), getattr(b, name)[:n]) for name in ("x", "v"))


def test_what_a_scene_lacks_is_not_there() -> None:
    """Law: a frictionless gas of equal spheres has no torques, spins, histories, codes, tables; walls and fields are empty in its loop."""
    scene = gas()
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    b, near = simulation._bodies, simulation._near
    assert (len(b.omega), len(b.torque), len(b.spin), len(b.aside), len(b.kick)) == (0, 0, 0, 0, 1)
    assert simulation._pairs.memory.shape[1] == 0
    assert (len(simulation._pairs.code), len(near.code), len(near.kept_action)) == (0, 0, 0)
    assert isinstance(simulation._coefficients, tuple)
    has = features(scene)
    assert has.FREE  # whoever touches nothing is not looked at
    assert not any((has.FRICTION, has.ROLLING, has.ROTATES, has.BUDGET, has.VIRIAL, has.PERIODIC, has.FROZEN, has.MOVING, has.THREADED))
    text = source(scene, has)
    assert "def wall_forces(i, b, walls, dt, advance, tally):\n    pass\n" in text
    assert "def field_forces(i, b, fields, dt, advance, tally):\n    pass\n" in text
    full = features(replace(scene, pair=law((1, 1)), forces=(Gravity((0.0, 0.0, -1.0)),)), budget=True)
    assert full.FRICTION
    assert full.ROTATES
    assert not full.FREE
    assert full.BASE == 3


EXTRA = {
    "friction of mu 0": lambda s: replace(s, pair=law((1, 1), mu=0.0)),
    "gravity 0": lambda s: replace(s, forces=(Gravity((0.0, 0.0, 0.0)),)),
    "a wall far away": lambda s: replace(s, walls=(Wall("floor", Slab(2, lo=-0.9), law((1,))),)),
    "a frozen group without members": lambda s: replace(s, forces=(Freeze(5),)),
    "periodic faces far away": lambda s: replace(s, box=Box(np.full(3, -1.0), np.full(3, 1.0), ("pp", "pp", "pp"))),
    "another size far away": lambda s: _with_another(s, 2 * RADIUS, 1),
    "another law far away": lambda s: _with_another(s, RADIUS, 2),
    "a particle that nothing moves": lambda s: _with_another(s, RADIUS, 1, mask=1),
}


def _with_another(scene: Scene, radius: float, kind: int, mask: int = 3) -> Scene:
    """One more sphere in a corner, of its own size or type; group 1 moves, and holds all but a sphere of mask 1."""
    p, extra = scene.particles, spheres(np.full((1, 3), 0.5), np.array([radius]))
    both = {name: np.concatenate([getattr(p, name), getattr(extra, name)]) for name in Particles.__dataclass_fields__ if getattr(p, name) is not None}
    both["id"][-1], both["type"][-1] = len(both["id"]), kind
    both["mask"][:], both["mask"][-1] = 3, mask
    pair = scene.pair
    assert pair is not None
    if kind == 2:
        wide = {name: np.array([[value[0, 0], 2 * value[0, 0]], [2 * value[0, 0], 3 * value[0, 0]]]) for name, value in pair.coefficients.items()}
        pair = replace(pair, coefficients=wide)
    return replace(scene, particles=Particles(**both), ntypes=kind, pair=pair, integrate=(NveSphere(1),))


@pytest.mark.parametrize("extra", EXTRA)
def test_the_lean_loop_gives_the_bits_of_the_full_one(extra: str) -> None:
    """Law: parts that do nothing in a scene, but must be compiled for it, change no bit of its motion."""
    lean, full = gas(), EXTRA[extra](gas())
    assert source(lean, features(lean)) != source(full, features(full)) or extra == "a particle that nothing moves"
    assert same(after(lean), after(full))


@pytest.mark.parametrize("keep", ["budget", "virial"])
def test_books_change_no_bit(keep: str) -> None:
    """Law: keeping the energy budget or the virial changes no bit of the motion."""
    scene = gas(friction="classic_history")
    assert same(after(scene), after(scene, **{keep: True}))


def pile(n: int = 3 * CHUNK + 100, friction: str = "classic_history", *, outlives: bool = False) -> Scene:
    """Unequal spheres falling in a periodic box with a floor and some that are held fast: several chunks, all kinds of pairs."""
    rng = np.random.default_rng(4)
    cells = int(np.ceil((n / 3) ** (1 / 3)))
    grid = np.stack(np.meshgrid(np.arange(cells), np.arange(cells), np.arange(3 * cells), indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[np.argsort(grid[:, 2], kind="stable")][:n]
    radius = rng.uniform(0.7, 1.0, n) * RADIUS
    pitch = 1.9 * RADIUS
    p = spheres((grid + 0.5) * pitch + rng.uniform(-1, 1, (n, 3)) * 0.1 * RADIUS, radius, v=rng.normal(0, 0.2, (n, 3)))
    p = replace(p, mask=np.where(rng.random(n) < 0.1, 5, 3))
    box = Box(np.zeros(3), np.array([cells * pitch, cells * pitch, 1.0]), ("pp", "pp", "ff"))
    return Scene(
        box, p, 1, 2e-5, pair=law((1, 1), friction=friction), walls=(Wall("floor", Slab(2, lo=0.0), law((1,))),),
        forces=(Gravity((0.0, 0.0, -9.81)), Freeze(2)), integrate=(NveSphere(1),), neighbor=Neighbor(0.001), history_outlives_contact=outlives,
    )  # fmt: skip


def test_a_frozen_base_is_not_looked_at() -> None:
    """Law: pairs of two frozen particles at rest are not listed, unless books need them, and that changes no bit: not while they are frozen, and not
    when they are set free."""
    ends, scene = [], pile()
    scene.particles.v[scene.particles.mask == 5] = 0.0
    for virial in (False, True):
        simulation = Simulation(scene, virial=virial, on_instability="off")
        simulation.setup()
        pairs, frozen = simulation.pairs, simulation.bodies.frozen
        assert (frozen[pairs.i] & frozen[pairs.j]).any() == virial
        simulation.advance(100)
        free = replace(simulation.scene, particles=simulation.particles(), forces=simulation.scene.forces[:1], integrate=(NveSphere(),))
        simulation = simulation.continue_with(free)
        simulation.setup()
        simulation.advance(100)
        ends.append(simulation.particles())
    assert same(*ends)


def test_what_frozen_contacts_remember_is_kept() -> None:
    """Law: who is frozen while touching goes on from the same springs when set free, however many lists were made meanwhile."""
    scene = pile()
    simulation = Simulation(replace(scene, forces=scene.forces[:1], integrate=(NveSphere(),)), on_instability="off")
    simulation.setup()
    simulation.advance(60)
    every = replace(scene, particles=simulation.particles(), forces=(Gravity((0.0, 0.0, -9.81)), Freeze(0)), integrate=(NveSphere(),))
    every.particles.v[:], every.particles.omega[:] = 0.0, 0.0
    simulation = simulation.continue_with(every)
    springs = []
    for _ in range(3):
        simulation.setup()
        simulation.advance(10)  # the first of these steps brings the springs to the friction limit of contacts at rest
        pairs = simulation.pairs
        springs.append(np.sort(np.linalg.norm(pairs.memory[pairs.touching == 1], axis=1)))
    assert springs[0].max() > 1e-6
    assert np.allclose(springs[0], springs[-1], rtol=1e-12, atol=0.0)  # springs are turned into the tangent plane in every step


THREADED = {
    "pile": pile,
    "pile, LIGGGHTS' histories": lambda: pile(outlives=True),
    "gas": lambda: gas(2 * CHUNK + 100, size=0.156, speed=3.0, friction="classic_history", periodic=True),
}


@pytest.mark.parametrize("name", THREADED)
def test_any_number_of_threads_gives_the_same_bits(name: str) -> None:
    """Law: one, two and three threads leave the same bits, over list renewals, across chunks and periodic faces."""
    scene = THREADED[name]()
    one, two, three = (after(scene, 120, threads=threads) for threads in (1, 2, 3))
    for other in (two, three):
        assert np.array_equal(one.x, other.x)
        assert np.array_equal(one.omega, other.omega)


def test_a_scene_of_one_chunk_is_not_shared_out() -> None:
    """Law: threads cost a scene nothing that is too small for them; it goes on with them when it grows."""
    small, large = pile(CHUNK), pile(CHUNK + 1)
    assert features(small, 2) == features(small, 1)
    assert features(large, 2).THREADED
    simulation = Simulation(small, threads=2, on_instability="off")
    assert simulation.threads == 1
    assert simulation.continue_with(large).threads == 2


def test_the_budget_is_the_same_on_threads() -> None:
    """Law: the account of energy has the same bits on two threads."""
    found = []
    for threads in (1, 2):
        simulation = Simulation(pile(2 * CHUNK + 50), threads=threads, budget=True, on_instability="off")
        simulation.setup()
        simulation.advance(60)
        found.append(simulation.energy_budget())
    assert found[0] == found[1]


@pytest.mark.parametrize("speed", [1.0, 5.0, 30.0])
@pytest.mark.parametrize("periodic", [False, True])
def test_the_near_list_misses_no_contact(speed: float, periodic: bool) -> None:
    """Law: pairs left out of the near list could not have touched: one long run is 400 runs of one step, which renew it every time, bit for bit."""
    scene = gas(80, speed=speed, friction="classic_history", periodic=periodic)
    one = Simulation(scene, on_instability="off")
    one.setup()
    for _ in range(400):
        one.advance(1)
    assert not np.array_equal(one.particles().v, scene.particles.v)
    assert same(one.particles(), after(scene, 400))


def test_outside_the_order_is_the_scenes() -> None:
    """Law: the scene's order of particles is kept outside whatever order is used inside: shuffled particles move alike."""
    scene = pile()
    n = len(scene.particles.id)
    shuffle = np.random.default_rng(9).permutation(n)
    shuffled = replace(scene, particles=scene.particles.rows(shuffle))
    simulation = Simulation(shuffled, on_instability="off")
    simulation.setup()
    first = Simulation(scene, on_instability="off")
    first.setup()
    assert np.array_equal(simulation.id, scene.particles.id[shuffle])
    scale = np.abs(first.bodies.force).max()  # sums of a few forces in another order
    assert np.abs(simulation.bodies.force - first.bodies.force[shuffle]).max() < 1e-13 * scale
    assert np.array_equal(simulation.bodies.radius, scene.particles.radius[shuffle])
    assert np.array_equal(simulation.image, first.image[shuffle])


def test_the_lost_are_named_rightly() -> None:
    """Law: who leaves a box of several chunks is named by its own id, and the others stay who they are."""
    scene = pile()
    v = np.zeros_like(scene.particles.v)
    v[1234] = (0.0, 0.0, 1000.0)
    up = replace(scene, particles=replace(scene.particles, v=v, mask=np.full(len(v), 3)), forces=())
    simulation = Simulation(up, on_instability="off")
    simulation.setup()
    with pytest.raises(LostParticles, match=r"1 particles left the box .* with id 1235$"):
        simulation.advance(100)
    careless = Simulation(replace(up, lost="ignore"), on_instability="off")
    careless.setup()
    careless.advance(100)
    assert np.array_equal(careless.id, np.delete(scene.particles.id, 1234))
    assert np.array_equal(careless.bodies.radius, np.delete(scene.particles.radius, 1234))


def test_a_run_goes_on_where_another_left_off() -> None:
    """Law: a run in two parts with continue_with between is the whole run but for the renewal of lists: contacts keep what they remember."""
    scene = pile()
    whole = Simulation(scene, on_instability="off")
    whole.setup()
    whole.advance(60)
    part = Simulation(scene, on_instability="off")
    part.setup()
    part.advance(30)
    rest = part.continue_with(replace(scene, particles=part.particles(), box=part.box()))
    contacts = part.pairs
    assert np.array_equal(rest.pairs.memory, contacts.memory)
    assert np.array_equal(rest.pairs.i, contacts.i)
    rest.advance(0)
    rest.setup()
    rest.advance(30)
    # set-up gives contact forces whole velocities for once, as the engines do
    assert np.abs(rest.bodies.x - whole.bodies.x).max() < 1e-3 * np.abs(whole.bodies.x - part.bodies.x).max()


def test_frozen_contacts_keep_what_they_remember() -> None:
    """Law: a contact that is frozen and set free again goes on with the spring that it had stretched."""
    p = spheres(np.array([[0.0, 0.0, 0.0], [1.99 * RADIUS, 0.0, 0.0]]), np.full(2, RADIUS), v=np.array([[0.0, 0.0, 0.0], [0.0, 1e-3, 0.0]]))
    free = replace(gas(2, friction="classic_history"), particles=p)
    first = Simulation(free, on_instability="off")
    first.setup()
    first.advance(20)
    memory = first.pairs.memory
    still = replace(first.particles(), v=np.zeros((2, 3)), omega=np.zeros((2, 3)))
    held = first.continue_with(replace(free, particles=still, forces=(Freeze(),), integrate=()))
    held.setup()
    held.advance(10)
    assert np.abs(memory).max() > 0.0
    again = held.continue_with(replace(free, particles=held.particles()))
    again.setup()
    assert again.pairs.memory == pytest.approx(memory, rel=1e-12)  # turned with a normal that rounding alone turns


def test_empty_scenes_and_single_particles_run() -> None:
    """Law: no particle, one particle, and one with its own image run."""
    for n in (0, 1):
        scene = gas(n) if n else replace(gas(1), particles=gas(1).particles.rows(np.arange(0)))
        assert len(after(scene, 10).id) == n
    tiny = replace(gas(1, size=2.2 * RADIUS), box=Box(np.zeros(3), np.full(3, 2.2 * RADIUS), ("pp", "pp", "pp")), neighbor=Neighbor(1e-4))
    assert len(after(tiny, 50).id) == 1


def test_laws_without_a_table_run() -> None:
    """Law: a law that is the same for all types gives what the table gives."""
    pair: ContactLaw = law((2, 2))
    scene = replace(gas(friction="classic_history"), ntypes=2, pair=pair)
    p = replace(scene.particles, type=np.where(np.arange(60) % 2, 1, 2))
    one = replace(scene, particles=p)
    table = {name: value * np.array([[1.0, 1.0], [1.0, 1.0 + 1e-15]]) for name, value in pair.coefficients.items()}
    other = replace(one, pair=replace(pair, coefficients=table))
    assert features(one).ONE_LAW
    assert not features(other).ONE_LAW
    a, b = after(one, 100), after(other, 100)
    assert np.abs(a.x - b.x).max() < 1e-13  # coefficients of one pair of types differ by four roundings

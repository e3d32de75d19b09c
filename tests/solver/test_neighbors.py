"""The neighbour list against every pair tried out, and what a list hands to the next."""

from __future__ import annotations

import time
import tracemalloc
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import Box, Freeze, Neighbor, Scene, neighbor_few, neighbors
from demsolver.neighbors import HOME, PARTNER_FEELS, SHIFTS
from demsolver.state import Bodies, Pairs, bodies_of
from tests.support.scenes import law, spheres

NAMES = ("pp", "ff")
SEEDS = st.integers(0, 2**32 - 1)


def scene_of(x, radius, lo, hi, *, periodic=(False, False, False), skin=0.1, types=None, bits=None, frozen=None, **neighbor) -> Scene:
    """Spheres at x; types (n,) from 1, bits (n,) a group 1 or none; frozen: bit of the frozen group."""
    p = spheres(np.asarray(x, float), np.asarray(radius, float))
    p = replace(p, type=p.type if types is None else types, mask=p.mask if bits is None else p.mask | bits << 1)
    box = Box(np.array(lo, float), np.array(hi, float), tuple(NAMES[not axis] for axis in periodic))
    forces = () if frozen is None else (Freeze(frozen),)
    return Scene(box, p, 3, 1e-3, pair=law((3, 3)), forces=forces, neighbor=Neighbor(skin, **neighbor))


@pytest.fixture(autouse=True, scope="module")
def cells_for_all():
    """Few particles are listed by cells too, but where a test says otherwise."""
    few, neighbors.FEW = neighbors.FEW, 0
    yield
    neighbors.FEW = few


def build(scene: Scene, columns: int = 0, *, frozen_pairs: bool = True, bodies: Bodies | None = None, threads: int = 1) -> Pairs:
    """The list of a scene at its own positions."""
    bodies = bodies or bodies_of(scene, aside=False)
    unseen = neighbors.exclusions(scene, bodies.mask, bodies.kind, None if frozen_pairs else bodies.frozen)
    return neighbors.build(scene, bodies, scene.box.lo, scene.box.hi, columns, unseen, threads)


def entries(pairs: Pairs) -> np.ndarray:
    """(m, 3) row, partner and code of every entry."""
    code = pairs.code.astype(int) if len(pairs.code) else np.full(len(pairs.partner), HOME)
    assert np.array_equal(pairs.row, np.repeat(np.arange(len(pairs.first) - 1), np.diff(pairs.first)))
    return np.column_stack([pairs.row.astype(int), pairs.partner.astype(int), code])


def felt(pairs: Pairs) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Who feels every entry, the other, and the row of SHIFTS of the other."""
    row, partner, code = entries(pairs).T
    turned = code >= PARTNER_FEELS
    return np.where(turned, partner, row), np.where(turned, row, partner), code % PARTNER_FEELS


def every_pair(scene: Scene, *, frozen_pairs: bool) -> np.ndarray:
    """`entries` of all pairs near enough, by trying out every pair and every image. A pair across a face is measured once: seen from the
    other side, rounding may decide otherwise when it stands exactly within reach."""
    p, box, skin = scene.particles, scene.box, scene.neighbor.skin
    unseen = np.zeros((len(p.x), len(p.x)), dtype=bool)
    rules = [((p.mask >> a) & 1 == 1, (p.mask >> b) & 1 == 1) for a, b in scene.neighbor.exclude]
    rules += [(p.type == a, p.type == b) for a, b in scene.neighbor.exclude_types]
    frozen = bodies_of(scene, aside=False).frozen
    for a, b in rules + ([] if frozen_pairs else [(frozen, frozen)]):
        unseen |= np.outer(a, b) | np.outer(b, a)
    found = []
    for s in range(HOME, 27):
        if any(SHIFTS[s][axis] and not box.periodic[axis] for axis in range(3)):
            continue
        d = p.x[:, None] - (p.x[None] + SHIFTS[s] * (box.hi - box.lo))
        near = ((d[..., 0] ** 2 + d[..., 1] ** 2 + d[..., 2] ** 2) < (p.radius[:, None] + p.radius[None] + skin) ** 2) & ~unseen
        for i, j in zip(*np.nonzero(near), strict=True):
            if s != HOME:
                found += [(min(i, j), max(i, j), s + PARTNER_FEELS * (i > j)), (min(i, j), max(i, j), 26 - s + PARTNER_FEELS * (j > i))]
            elif i < j:
                found.append((i, j, s))
    return np.array(sorted(found), dtype=int).reshape(-1, 3)


RADII = {
    "equal": lambda rng, n: np.full(n, 0.5),
    "two to one": lambda rng, n: rng.uniform(0.25, 0.5, n),
    "a thousand to one": lambda rng, n: 0.5 * 10.0 ** rng.uniform(-3.0, 0.0, n),
    "points": lambda rng, n: np.zeros(n),
    "points among spheres": lambda rng, n: rng.choice([0.0, 1e-9, 0.01, 0.5], n),
}


def random_scene(seed: int, sizes: str, periodic: tuple[bool, bool, bool], skin: float) -> Scene:
    """Spheres at random, or on a coarse lattice so that many touch exactly; the box at least about as long as the reach."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 50))
    radius = RADII[sizes](rng, n)
    reach = 2.0 * radius.max() + skin or 0.1
    lo = rng.uniform(-5.0, 5.0, 3) * reach  # so that rounding leaves the box as long as it is said to be
    length = reach * rng.choice([1.0 + 1e-9, 1.05, 2.0, 3.5, 30.0], 3)
    places = rng.uniform(0.0, 1.0, (n, 3)) if rng.random() < 0.8 else rng.integers(0, 4, (n, 3)) / 4
    frozen = rng.integers(0, 2, n)
    rules = {"exclude": ((1, 1),), "exclude_types": ((1, 2), (3, 3))} if rng.random() < 0.5 else {}
    types = rng.integers(1, 4, n)
    return scene_of(lo + places * length, radius, lo, lo + length, periodic=periodic, skin=skin, types=types, bits=frozen, frozen=1, **rules)


@settings(max_examples=150, deadline=None)
@given(
    seed=SEEDS, sizes=st.sampled_from(list(RADII)), periodic=st.tuples(*[st.booleans()] * 3), skin=st.sampled_from([0.0, 0.05, 0.3]),
    frozen_pairs=st.booleans(), threads=st.integers(1, 3),
)  # fmt: skip
def test_the_list_is_every_pair_within_reach(
    seed: int, sizes: str, periodic: tuple[bool, bool, bool], skin: float, frozen_pairs: bool, threads: int
) -> None:
    """Law: the list is exactly the pairs that trying all out finds, self images included, each once at home and twice across a face, in the row
    of its lower index, partners ascending and ties by code; however many search."""
    scene = random_scene(seed, sizes, periodic, skin)
    pairs = build(scene, 2, frozen_pairs=frozen_pairs, threads=threads)
    assert np.array_equal(entries(pairs), every_pair(scene, frozen_pairs=frozen_pairs))
    assert (pairs.first.dtype, pairs.partner.dtype, pairs.code.dtype) == (np.int64, np.uint32, np.uint8)
    assert len(pairs.code) == (len(pairs.partner) if any(periodic) else 0)
    assert pairs.memory.shape == (len(pairs.partner), 2)
    assert not pairs.memory.any()
    assert not pairs.touching.any()


@pytest.mark.parametrize("periodic", [(False, False, False), (True, True, False), (True, True, True)])
@pytest.mark.parametrize("small", [0.2, 0.1, 0.01, 0.0])
def test_small_spheres_about_large_ones(small: float, periodic: tuple[bool, bool, bool]) -> None:
    """Law: the same for large spheres in several cells each way, hundreds of small ones about them, just within or just out of reach."""
    rng = np.random.default_rng(6)
    large = rng.uniform(0.0, 6.0, (40, 3))
    away = rng.normal(size=(800, 3))
    distance = 0.5 + small + 0.05 + rng.uniform(-0.02, 0.02, 800)
    x = np.concatenate([large, large[rng.integers(0, 40, 800)] + away * (distance / np.linalg.norm(away, axis=1))[:, None]])
    lo, hi = np.zeros(3), np.full(3, 6.0)
    neighbors.wrap(x, lo, hi, periodic)
    scene = scene_of(x, np.where(np.arange(840) < 40, 0.5, small), lo, hi, periodic=periodic, skin=0.05)
    assert np.array_equal(entries(build(scene)), every_pair(scene, frozen_pairs=True))


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, sizes=st.sampled_from(list(RADII)))
def test_the_list_is_of_the_pairs_not_of_their_order(seed: int, sizes: str) -> None:
    """Law: particles in another order are the same pairs under other numbers; so the order may be changed between lists."""
    scene = random_scene(seed, sizes, (True, False, True), 0.1)
    order = np.random.default_rng(seed).permutation(len(scene.particles.id))
    p = scene.particles
    shuffled = replace(scene, particles=p.rows(order))
    seen, other, shift = felt(build(scene))
    again, other_again, shift_again = felt(build(shuffled))
    pairs = sorted(zip(seen.tolist(), other.tolist(), shift.tolist(), strict=True))
    home = [(i, j) for i, j, s in pairs if s == HOME]
    named = list(zip(order[again].tolist(), order[other_again].tolist(), shift_again.tolist(), strict=True))
    assert sorted((i, j, s) for i, j, s in named if s != HOME) == [pair for pair in pairs if pair[2] != HOME]
    assert sorted((min(i, j), max(i, j)) for i, j, s in named if s == HOME) == home


def test_a_crowd_is_listed_whole() -> None:
    """Law: the list grows with the pairs, here all 300 * 299 / 2 of particles in one place, in rows as long as the list."""
    x = np.random.default_rng(0).uniform(0.0, 0.1, (300, 3))
    pairs = build(scene_of(x, np.full(300, 0.5), (0, 0, 0), (1, 1, 1)))
    assert np.array_equal(np.diff(pairs.first), np.arange(299, -1, -1))
    assert np.array_equal(pairs.partner, np.concatenate([np.arange(i + 1, 300) for i in range(300)]))


@pytest.mark.parametrize("n", [0, 1])
def test_one_particle_or_none(n: int) -> None:
    """Law: nobody meets nobody; one particle meets at most its own images."""
    x = np.zeros((n, 3))
    assert len(build(scene_of(x, np.full(n, 0.5), (0, 0, 0), (1, 1, 1))).partner) == 0
    lone = build(scene_of(x, np.full(n, 0.5), (0, 0, 0), (2, 1.1, 2), periodic=(True, True, True), skin=0.1))
    assert len(lone.first) == n + 1
    # of a box exactly as long as the reach no image is nearer than the reach; rounding decides, but for both alike
    assert len(lone.partner) in ((0, 2) if n else (0,))


def test_a_box_shorter_than_the_reach_is_refused() -> None:
    """Law: what could touch an image of the next but one box is refused, with the axis, both lengths, in one line."""
    scene = scene_of(np.zeros((2, 3)), [0.5, 0.2], (0, 0, 0), (5, 1.05, 5), periodic=(True, True, False), skin=0.1)
    with pytest.raises(ValueError, match=r"^the periodic box is 1.05 long in y, shorter than the reach 1.1 of a contact, skin included$"):
        build(scene)


@pytest.mark.parametrize("offset", [0.0, 1e9])
@pytest.mark.parametrize("size", [1.0, 1e-4])
def test_far_from_the_origin_and_far_apart(size: float, offset: float) -> None:
    """Law: neither where the box stands nor empty space of a million diameters, or ten thousand million, changes who meets whom, as far as
    coordinates tell."""
    rng = np.random.default_rng(3)
    places = np.array([[0, 0, 0], [1e6, 0, 0], [3e5, 1e6, 7e5], [3e5, 1e6, 7e5 + 5 * size], [5e5, 5e5, 1e6]])
    x = np.repeat(places, 20, axis=0) + rng.uniform(0, 2 * size, (100, 3)) + offset
    lo, hi = np.full(3, offset), np.full(3, offset + 1e6 + 2)
    scene = scene_of(x, size * rng.uniform(0.2, 0.5, 100), lo, hi, periodic=(True, True, True), skin=0.1 * size)
    listed = entries(build(scene))
    assert np.array_equal(listed, every_pair(scene, frozen_pairs=True))
    assert 100 < len(listed) < 5 * 20 * 19


@pytest.mark.parametrize("far", [1e300, 1.5e308])
def test_positions_at_the_end_of_the_numbers(far: float) -> None:
    """Law: a particle as far off as numbers go hides no pair of the others and meets nobody."""
    x = np.array([[0.0, 0, 0], [0.9, 0, 0], [far, far, far], [-far, 0, 0]])
    assert entries(build(scene_of(x, np.full(4, 0.5), (-far,) * 3, (far,) * 3))).tolist() == ([[0, 1, HOME]])


def test_a_contact_that_goes_on_beyond_touch_is_listed() -> None:
    """Law: to the skin comes what the law can bridge: for jkr [3 pi^2 R* g^2/(16 E*^2)]^(1/3) of the largest two particles."""
    base = law((3, 3))
    one = np.ones((3, 3))
    jkr = replace(base, normal="jkr", damping="none", friction="none", coefficients={"yeff": 1e5 * one, "surface_energy": 50.0 * one})
    gap = (3 * np.pi**2 * 0.25 * 50.0**2 / (16 * 1e5**2)) ** (1 / 3)
    for beyond, listed in ((0.99, 1), (1.01, 0)):
        scene = scene_of([[0, 0, 0], [1.05 + beyond * gap, 0, 0]], [0.5, 0.5], (-1, -1, -1), (3, 3, 3), skin=0.05)
        assert len(build(replace(scene, pair=jkr)).partner) == listed


def test_many_exclusions() -> None:
    """Law: as many rules as one likes; each takes out its pairs and no others."""
    rng = np.random.default_rng(1)
    types = rng.integers(1, 20, 60)
    rules = tuple((int(a), int(b)) for a, b in rng.integers(1, 20, (45, 2)))
    scene = replace(scene_of(rng.uniform(0, 3, (60, 3)), np.full(60, 0.5), (0,) * 3, (3,) * 3, types=types, exclude_types=rules), ntypes=20)
    listed = entries(build(scene))
    assert np.array_equal(listed, every_pair(scene, frozen_pairs=True))
    assert 0 < len(listed) < len(entries(build(replace(scene, neighbor=Neighbor(0.1)))))


@pytest.mark.parametrize("rule", [{"exclude": ((0, 0),)}, {"exclude_types": ((1, 1),)}, {"frozen": 0}])
def test_all_left_out(rule: dict) -> None:
    """Law: when every particle is of the class that does not see itself, nobody meets anybody."""
    x = np.random.default_rng(1).uniform(0, 2, (30, 3))
    assert len(build(scene_of(x, np.full(30, 0.5), (0,) * 3, (2,) * 3, **rule), frozen_pairs=False).partner) == 0


def cubes(gap: float, side: int = 14) -> Scene:
    """Two cubes of touching spheres, `gap` apart in all three directions."""
    cube = np.array(list(product(range(side), repeat=3)), float)
    x = np.concatenate([cube, cube + side + gap])
    return scene_of(x + np.random.default_rng(0).uniform(0, 0.1, x.shape), np.full(len(x), 0.5), x.min(0) - 1, x.max(0) + 1)


def quickest(scene: Scene) -> float:
    """Seconds of the quickest of some builds, so that neither compilation nor a busy machine counts."""
    bodies = bodies_of(scene, aside=False)
    times = []
    for _ in range(9):
        begin = time.perf_counter()
        build(scene, bodies=bodies)
        times.append(time.perf_counter() - begin)
    return min(times)


def test_empty_space_costs_nothing() -> None:
    """Law: two clusters a million diameters apart cost what they cost side by side, in time and in memory. Longer keys take more passes to sort, a
    fifth of the time; a grid over the void would take 1e18 cells."""
    near, far = cubes(0.0), cubes(1e6)
    peaks = []
    for scene in (near, far):
        bodies = bodies_of(scene, aside=False)
        build(scene, bodies=bodies)
        tracemalloc.start()
        build(scene, bodies=bodies)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]
    assert peaks[1] < 200 * len(near.particles.id)
    assert quickest(far) < 3.0 * quickest(near)


def test_small_among_large_costs_per_pair() -> None:
    """Law: the same volume of spheres in two sizes, ten to one, costs per particle as much as equal ones within a factor of 5 (measured: 2). Cells of
    the large ones alone would try a thousand small ones for each of the nine they have about them."""
    rng = np.random.default_rng(2)
    n = 10_000
    sizes = np.where(np.arange(n) < n // 1000, 0.5, 0.05)
    lengths = [(1.2 * np.sum(8 * r**3)) ** (1 / 3) for r in (sizes, np.full(n, 0.05))]
    times = [quickest(scene_of(rng.uniform(0, length, (n, 3)), r, (0,) * 3, (length,) * 3, skin=0.005))
             for r, length in zip((sizes, np.full(n, 0.05)), lengths, strict=True)]  # fmt: skip
    assert times[0] < 5.0 * times[1]


SIGNS = np.array([-1.0, 1.0, -1.0, -1.0])
BUDGET = 19  # three columns each: damping force, tangential force, its torque on either side, rolling torque on either side; one more


def as_the_other_feels(memory: np.ndarray) -> np.ndarray:
    """A contact's memory when the particles change places: the law's columns by their signs, forces turned round, torques of both sides exchanged."""
    own, budget = memory[: len(SIGNS)], memory[len(SIGNS) :]
    force, torque, rolling, rest = budget[:6], budget[6:12].reshape(2, 3), budget[12:18].reshape(2, 3), budget[18:]
    return np.concatenate([SIGNS * own, -force, torque[::-1].ravel(), rolling[::-1].ravel(), rest])


def known(pairs: Pairs, image: np.ndarray, number: np.ndarray, *, directed: bool) -> dict[tuple[int, ...], tuple[int, np.ndarray]]:
    """Touch and memory by what stays the same when particles are wrapped and renumbered: who feels it, the other, and by how many boxes the
    other would have to be shifted if nothing had ever been wrapped. directed: with pairs at home as the partner feels them too."""
    table = {}
    for k, (i, j, s) in enumerate(zip(*felt(pairs), strict=True)):
        apart = SHIFTS[s] + image[i] - image[j]
        table[(number[i], number[j], *apart)] = (int(pairs.touching[k]), pairs.memory[k])
        if directed and s == HOME:
            table[(number[j], number[i], *-apart)] = (int(pairs.touching[k]), as_the_other_feels(pairs.memory[k]))
    return table


def moved_on(seed: int, periodic: tuple[bool, bool, bool]) -> tuple[Scene, Scene, np.ndarray, np.ndarray]:
    """A scene, and the same after its particles moved a little, were wrapped and put in another order; wraps by old row; where each row is now."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 40))
    radius = rng.uniform(0.3, 0.5, n)
    lo, hi = np.zeros(3), rng.choice([1.31, 2.0, 3.0], 3)
    old = scene_of(rng.uniform(lo, hi, (n, 3)), radius, lo, hi, periodic=periodic, skin=0.3)
    x = old.particles.x + rng.uniform(-0.05, 0.05, (n, 3))
    x = np.where(periodic, x, np.clip(x, lo, hi - 1e-9))
    wraps = neighbors.wrap(x, lo, hi, periodic)
    order = rng.permutation(n)
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    return old, scene_of(x[order], radius[order], lo, hi, periodic=periodic, skin=0.3), wraps, place


def carried(old: Pairs, scene: Scene, wraps: np.ndarray, place: np.ndarray, *, outlives: bool = False) -> Pairs:
    """The list of `scene` with the memory of an older one."""
    bodies = bodies_of(scene, aside=False)
    new = build(scene, old.memory.shape[1], bodies=bodies)
    shifts = SHIFTS * (np.array(scene.box.hi) - scene.box.lo)
    columns = neighbors.columns_of(SIGNS, old.memory.shape[1] - len(SIGNS))
    neighbors.carry(neighbors.remembered(old), new, wraps, outlives, columns, bodies, shifts, place)
    return new


@settings(max_examples=80, deadline=None)
@given(seed=SEEDS, periodic=st.tuples(*[st.booleans()] * 3))
def test_a_contact_keeps_its_memory(seed: int, periodic: tuple[bool, bool, bool]) -> None:
    """Law: what a particle remembers of another, however often either was wrapped and whatever rows they stand in, is what it remembers after the
    next list, columns of law and budget, signs and sides; what did not touch is forgotten, and so is who would be more than a box away."""
    old_scene, scene, wraps, place = moved_on(seed, periodic)
    rng = np.random.default_rng(seed)
    if rng.random() < 0.3:  # wraps that no motion in one list would bring about
        wraps += rng.integers(-1, 2, wraps.shape) * periodic
    old = build(old_scene, len(SIGNS) + BUDGET)
    old.memory[:] = rng.normal(size=old.memory.shape)
    old.touching[:] = rng.integers(0, 2, len(old.touching))
    new = carried(old, scene, wraps, place)
    n = len(place)
    number = np.empty(n, dtype=int)
    number[place] = np.arange(n)
    image = np.zeros((n, 3), dtype=int)
    image[place] = wraps
    before = known(old, np.zeros((n, 3), dtype=int), np.arange(n), directed=True)
    after = known(new, image, number, directed=False)
    for key, (touching, memory) in after.items():
        touched, remembered = before.get(key, (0, None))
        assert touching == touched
        assert np.array_equal(memory, remembered if touched else np.zeros(old.memory.shape[1]))


def test_a_wrap_there_and_back() -> None:
    """Law: a contact at home that two wraps carry across a face and back home, its particles changing rows, ends with the memory it began with."""
    lo, hi = np.zeros(3), np.full(3, 4.0)
    home = scene_of([[1.0, 1, 1], [1.9, 1, 1], [3.0, 3, 3]], np.full(3, 0.5), lo, hi, periodic=(True, True, True))
    across = scene_of([[3.9, 1, 1], [0.8, 1, 1], [3.0, 3, 3]], np.full(3, 0.5), lo, hi, periodic=(True, True, True))
    old = build(home, len(SIGNS) + BUDGET)
    old.memory[:] = np.arange(1.0, old.memory.shape[1] + 1)
    old.touching[:] = 1
    wraps = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 0]])
    there = carried(old, across, wraps, np.arange(3))
    assert there.touching.tolist() == [1, 1]
    assert entries(there).tolist() == [[0, 1, HOME + 9], [0, 1, HOME - 9 + PARTNER_FEELS]]
    swapped = scene_of([[1.9, 1, 1], [1.0, 1, 1], [3.0, 3, 3]], np.full(3, 0.5), lo, hi, periodic=(True, True, True))
    back = carried(there, swapped, -wraps, np.array([1, 0, 2]))
    assert np.array_equal(back.memory, [as_the_other_feels(old.memory[0])])
    again = carried(back, home, 0 * wraps, np.array([1, 0, 2]))
    assert np.array_equal(again.memory, old.memory)


@pytest.mark.parametrize(("gap", "touching", "kept", "history"), [
    (-0.01, 1, 1, True), (-0.01, 2, 2, True), (-0.01, 3, 3, True), (0.01, 1, 1, False), (0.01, 2, 0, False), (0.01, 3, 1, False),
])  # fmt: skip
@pytest.mark.parametrize("turned", [False, True])
def test_history_that_outlives_the_contact(gap: float, touching: int, kept: int, history: bool, turned: bool) -> None:
    """Law (LIGGGHTS): with `outlives` what has touched since the last list goes over; its tangential history only if the two overlap now.
    Otherwise it has only touched if it did at the last step, and the budget still knows the forces of that step."""
    x, place = [[0.0, 0, 0], [1.0 + gap, 0, 0]], np.arange(2)
    if turned:
        x, place = x[::-1], place[::-1].copy()
    scene = scene_of(x, [0.5, 0.5], (-1, -1, -1), (3, 3, 3))
    old = build(scene, len(SIGNS) + BUDGET)
    old.memory[:] = np.arange(1.0, old.memory.shape[1] + 1)
    old.touching[:] = touching
    new = carried(old, scene, np.zeros((2, 3), dtype=np.int64), place, outlives=True)
    expected = as_the_other_feels(old.memory[0]) if turned else old.memory[0].copy()
    if not history:
        expected[: len(SIGNS)] = 0.0
    assert new.touching.tolist() == [kept]
    assert np.array_equal(new.memory, [expected])


def test_lists_of_boxes_with_other_faces() -> None:
    """Law: when faces stop being periodic, or become so, contacts at home keep their memory, and those across the faces end. Here two particles touch
    both ways."""
    x = [[0.2, 1, 1], [1.2, 1, 1]]
    open_box, closed = (scene_of(x, np.full(2, 0.52), (0, 0, 0), (2, 4, 4), periodic=(p, p, p)) for p in (False, True))
    old = build(closed, len(SIGNS))
    old.touching[:] = 1
    old.memory[:] = np.arange(1.0, old.memory.size + 1).reshape(old.memory.shape)
    at_home = entries(old)[:, 2] == HOME
    assert at_home.tolist() == [False, True, False]
    new = carried(old, open_box, np.zeros((2, 3), dtype=np.int64), np.arange(2))
    assert np.array_equal(new.memory, old.memory[at_home])
    back = carried(new, closed, np.zeros((2, 3), dtype=np.int64), np.arange(2))
    assert back.touching.tolist() == [0, 1, 0]


@settings(max_examples=50, deadline=None)
@given(seed=SEEDS, periodic=st.tuples(*[st.booleans()] * 3))
def test_wrap_moves_particles_by_boxes(seed: int, periodic: tuple[bool, bool, bool]) -> None:
    """Law: x_old = x_new + wraps * length; along periodic axes everything within a box of the box ends in it, along others nothing moves."""
    rng = np.random.default_rng(seed)
    lo = rng.uniform(-2, 2, 3)
    hi = lo + rng.uniform(0.5, 3, 3)
    old = rng.uniform(lo - 0.99 * (hi - lo), hi + 0.99 * (hi - lo), (40, 3))
    old[0], old[1] = lo, hi
    x = old.copy()
    wraps = neighbors.wrap(x, lo, hi, periodic)
    assert np.allclose(x + wraps * (hi - lo), old, rtol=0.0, atol=1e-14)  # one rounding of lengths below 10
    for axis in range(3):
        if periodic[axis]:
            assert ((x[:, axis] >= lo[axis]) & (x[:, axis] < hi[axis])).all()
        else:
            assert np.array_equal(x[:, axis], old[:, axis])


def test_morton_order_keeps_neighbours_near() -> None:
    """Law: it is a permutation, and neighbours in space stand near each other in it: half of the listed pairs within 16 places of 8,000, where at
    random they are 2,300 apart."""
    rng = np.random.default_rng(4)
    x = np.array(list(product(range(20), repeat=3)), float)[rng.permutation(8000)]
    order = neighbors.morton_order(x, x.min(axis=0), 1.0)
    assert np.array_equal(np.sort(order), np.arange(8000))
    row, partner, _ = entries(build(scene_of(x[order], np.full(8000, 0.5), (-1,) * 3, (21,) * 3))).T
    assert np.median(partner - row) <= 16
    row, partner, _ = entries(build(scene_of(x, np.full(8000, 0.5), (-1,) * 3, (21,) * 3))).T
    assert np.median(partner - row) > 1000


@pytest.mark.parametrize("bits", [2, 9, 21])
def test_morton_order_is_the_order_of_interleaved_bits(bits: int) -> None:
    """Law: the order of x0 y0 z0 x1 y1 z1 ..., lowest bits first, of the cells; particles of one cell in the order they come."""
    cell = np.random.default_rng(5).integers(0, 1 << bits, (200, 3))
    code = sum(((cell[:, axis] >> bit) & 1) << (3 * bit + axis) for bit in range(bits) for axis in range(3))
    assert np.array_equal(neighbors.morton_order(cell + 0.5, np.zeros(3), 1.0), np.argsort(code, kind="stable"))


@pytest.mark.parametrize("size", [0.0, 1e-300, 1.0, np.inf])
@pytest.mark.parametrize("far", [0.0, 1.0, 1e300])
def test_morton_order_of_anything(size: float, far: float) -> None:
    """Law: points of no size, all in one place, or at the end of the numbers have an order too."""
    x = np.zeros((5, 3))
    x[3] = far
    assert sorted(neighbors.morton_order(x, np.zeros(3), size)) == [0, 1, 2, 3, 4]
    assert len(neighbors.morton_order(x[:0], np.zeros(3), size)) == 0


@settings(max_examples=50, deadline=None)
@given(seed=SEEDS, n=st.integers(0, 40))
def test_few_particles_have_the_list_of_many(seed: int, n: int) -> None:
    """Law: looking at every pair gives the list that cells give, entry by entry, with groups and types that do not see each other."""
    rng = np.random.default_rng(seed)
    scene = scene_of(
        rng.uniform(0, 3, (n, 3)), rng.uniform(0.1, 0.6, n), (0,) * 3, (3,) * 3, types=rng.integers(1, 4, n), bits=rng.integers(0, 2, n),
        exclude=((0, 1),) if seed % 2 else (), exclude_types=((1, 2),),
    )  # fmt: skip
    by_cells = build(scene, 3)
    bodies = bodies_of(scene, aside=False)
    few = neighbor_few.few_rows(bodies.x, bodies.radius, scene.neighbor.skin, 3, neighbors.exclusions(scene, bodies.mask, bodies.kind))
    assert np.array_equal(entries(few), entries(by_cells))
    assert few.memory.shape == by_cells.memory.shape
    assert not few.touching.any()

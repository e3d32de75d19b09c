"""The implicit step of normal_discrete_gradient: energy and momenta kept to rounding at any step, closed forms of one contact, order two."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import (
    Box,
    ContactLaw,
    Cylinder,
    EulerSphere,
    Freeze,
    Gravity,
    Neighbor,
    NveSphere,
    Plane,
    Scene,
    SetForce,
    Simulation,
    Slab,
    Unstable,
    Wall,
)  # fmt: skip
from demsolver.contact.normal_discrete_gradient import energy, solve
from tests.support.scenes import spheres

KN = 1e4


def law(shape: tuple[int, ...], *, friction: str = "none", damping: str = "none", normal: str = "discrete_gradient") -> ContactLaw:
    """The implicit spring, with friction and damping where asked."""
    one = np.ones(shape)
    values = {"kn": KN * one, "gamman": 50.0 * one, "shear_stiffness": 2 / 7 * KN * one, "xt": 0.5 * one, "mu": 0.4 * one}
    return ContactLaw(normal, damping, "constant", "scaled", friction, values)


def box(size: float, faces: str = "ff") -> Box:
    """A cube about the origin."""
    return Box(np.full(3, -size), np.full(3, size), (faces, faces, faces))


def contact_time(scene: Scene) -> float:
    """Half a period of the lightest pair."""
    return pi * sqrt(0.5 * float(scene.particles.mass.min()) / KN)


def heap(rng: np.random.Generator, step: float, *, n: int = 40, periodic: bool = False, **kinds: str) -> Scene:
    """Spheres of several sizes thrown together, some overlapping at the start; the step in contact times. Walled on all sides unless periodic."""
    radius = rng.uniform(0.004, 0.006, n)
    places = np.stack(np.meshgrid(*[np.arange(4)] * 3), axis=-1).reshape(-1, 3)[:n] * 0.0107 + 0.006 + rng.uniform(-3e-4, 3e-4, (n, 3))
    p = spheres(places, radius, v=rng.normal(0.0, 0.5, (n, 3)), omega=rng.normal(0.0, 20.0, (n, 3)))
    size = 0.045
    walls = () if periodic else tuple(Wall(f"w{a}", Slab(a, 0.0, size), law((1,), **kinds)) for a in range(3))
    faces = "pp" if periodic else "ff"
    scene = Scene(
        Box(np.zeros(3), np.full(3, size), (faces,) * 3), p, 1, 1.0, pair=law((1, 1), **kinds), walls=walls, integrate=(NveSphere(),),
        forces=() if periodic else (Gravity((0.0, 0.0, -9.81)),), neighbor=Neighbor(0.006),
    )  # fmt: skip
    return replace(scene, timestep=step * contact_time(scene))


@settings(max_examples=300, deadline=None)
@given(
    d=st.integers(-(10**9), 10**9).map(lambda k: k * 1e-9),
    approach=st.integers(-(10**9), 10**9).map(lambda k: 3e-9 * k),
    compliance=st.floats(1e-6, 1e3),
)
def test_mean_force_is_the_slope_of_energy(d: float, approach: float, compliance: float) -> None:
    """Law: with s = approach - compliance F, F s is the gain of the spring's energy; no force without touch; never a pull."""
    force = solve(d, approach, compliance, 1.0)
    s = approach - compliance * force
    gain = energy(max(d + s, 0.0), 1.0) - energy(max(d, 0.0), 1.0)
    size = abs(d) + abs(approach) + compliance * abs(force) + 1e-300
    assert force >= 0.0
    # s is a difference of terms as large as `size`, so it and the energies are known to rounding of size (squared)
    assert force * s == pytest.approx(gain, abs=2e-14 * (1.0 + force / size) * size**2 + 1e-300)
    assert (force > 0.0) == (d > 0.0 or d + s > 0.0)


@pytest.mark.parametrize("step", [0.02, 0.3, 1.0, 3.0])
def test_one_contact_keeps_its_energy_at_any_step(step: float) -> None:
    """Law: a sphere thrown at a wall comes back as fast as it went, from whatever phase of the step it hit."""
    n = 50
    x = np.zeros((n, 3))
    x[:, 0], x[:, 2] = 0.03 * np.arange(n), 0.006 + 0.01 * np.linspace(0.0, 1.0, n)
    scene = Scene(
        Box(np.array([-0.1, -0.1, -0.1]), np.array([2.0, 0.1, 0.5]), ("ff",) * 3), spheres(x, np.full(n, 0.005), v=np.tile([0.0, 0.0, -1.0], (n, 1))),
        1, 1.0, walls=(Wall("floor", Slab(2, lo=0.0), law((1,))),), integrate=(NveSphere(),), neighbor=Neighbor(0.02),
    )  # fmt: skip
    period = pi * sqrt(scene.particles.mass[0] / KN)
    simulation = Simulation(replace(scene, timestep=step * period), on_instability="off")
    simulation.setup()
    simulation.advance(int(0.02 / (step * period)) + 8)
    assert np.abs(simulation.bodies.v[:, 2] - 1.0).max() < 1e-12  # rounding of the position (1e-18 m) over the overlap of a contact (1e-4 m)


@pytest.mark.parametrize("step", [0.02, 0.1, 0.3, 1.0])
def test_many_contacts_keep_energy(step: float) -> None:
    """Law: 40 spheres between walls under gravity, several contacts at once: less than 1e-12 of the energy in motion a step, all in all 1e-11."""
    scene = heap(np.random.default_rng(3), step)
    simulation = Simulation(scene, budget=True, on_instability="off")
    simulation.setup()
    first = simulation.energy_budget()
    totals = []
    for _ in range(10):
        simulation.advance(100)
        totals.append(simulation.energy_budget().total)
    # rounding: a thousand steps of some 100 contacts, each wrong by 1e-18 m of 1e-5 m of overlap
    assert np.abs(np.array(totals) - first.total).max() < 1e-11 * (first.kinetic + first.elastic)


@pytest.mark.parametrize("step", [0.1, 1.0])
def test_momenta_stay(step: float) -> None:
    """Law: without walls and gravity linear and angular momentum stay, though the contacts of a step are solved together."""
    scene = replace(heap(np.random.default_rng(4), step), walls=(), forces=(), box=box(10.0))
    simulation = Simulation(scene, on_instability="off")
    mass = scene.particles.mass[:, None]
    simulation.setup()

    def momenta() -> np.ndarray:
        b = simulation.bodies
        return np.array([(mass * b.v).sum(axis=0), np.cross(b.x, mass * b.v).sum(axis=0)])

    before = momenta()
    simulation.advance(200)
    scale = np.abs(mass * simulation.bodies.v).sum(axis=0).max() * np.array([[1.0], [0.05]])
    assert (np.abs(momenta() - before) < 1e-13 * scale).all()


def test_a_periodic_box_keeps_energy() -> None:
    """Law: pairs across the faces are solved once, and keep the energy too."""
    scene = heap(np.random.default_rng(5), 0.5, periodic=True)
    simulation = Simulation(scene, budget=True, on_instability="off")
    simulation.setup()
    first = simulation.energy_budget().total
    simulation.advance(500)
    assert simulation.energy_budget().total == pytest.approx(first, rel=1e-12)
    assert simulation.energy_budget().kinetic != pytest.approx(first, rel=1e-3)  # there were collisions


@pytest.mark.parametrize("shape", [Cylinder(2, (0.0, 0.0), 0.02), Plane((1.0, 2.0, -2.0), 0.02), Slab(1, -0.02, 0.02)])
def test_every_wall_keeps_energy(shape: Cylinder | Plane | Slab) -> None:
    """Law: whatever the wall's shape, the mean force does exactly the spring's work."""
    rng = np.random.default_rng(6)
    x = rng.uniform(-0.008, 0.008, (12, 3)) + np.array([-0.001, -0.001, 0.01])
    p = spheres(x, np.full(12, 0.003), v=rng.normal(0.0, 1.0, (12, 3)))
    scene = Scene(
        box(1e3), p, 1, 1.0, pair=None, walls=(Wall("w", shape, law((1,))), Wall("back", Slab(0, -0.05, 0.05), law((1,)))), integrate=(NveSphere(),),
        neighbor=Neighbor(0.1),
    )  # fmt: skip
    simulation = Simulation(replace(scene, timestep=0.4 * contact_time(scene)), budget=True, on_instability="off")
    simulation.setup()
    first = simulation.energy_budget().total
    touched = 0.0
    for _ in range(60):
        simulation.advance(10)
        touched = max(touched, simulation.energy_budget().elastic)
    assert touched > 1e-3 * first
    assert simulation.energy_budget().total == pytest.approx(first, rel=1e-12)


def test_friction_and_damping_are_second_order() -> None:
    """Law: with springs solved and friction and damping kicked, total plus dissipated drifts with the square of the step."""

    def drift(step: float) -> float:
        scene = heap(np.random.default_rng(7), step, friction="rotated_history", damping="velocity")
        scene = replace(scene, pair=gentle(scene.pair), walls=tuple(replace(w, law=gentle(w.law)) for w in scene.walls))
        simulation = Simulation(scene, budget=True, on_instability="off")
        simulation.setup()
        first = simulation.energy_budget()
        simulation.advance(round(3.0 / step))
        last = simulation.energy_budget()
        assert min(last.damped, last.rubbed) > 0.01 * first.total
        return abs(last.total - first.total) / first.total

    def gentle(one: ContactLaw | None) -> ContactLaw:
        assert one
        one_each = np.ones_like(one.coefficients["kn"])
        return replace(one, coefficients={**one.coefficients, "gamman": 0.5 * one_each, "mu": 1e3 * one_each})

    coarse, fine = drift(0.02), drift(0.005)
    assert fine < coarse / 8.0  # 16 in the limit; contacts begin and end within steps
    assert coarse < 1e-2


def test_it_comes_to_the_same_as_verlet() -> None:
    """Law: at a hundredth of a contact time the implicit spring and velocity Verlet with the same spring end at the same place."""
    scene = heap(np.random.default_rng(8), 0.002, n=12)
    hooke = replace(scene, pair=law((1, 1), normal="hooke"), walls=tuple(replace(w, law=law((1,), normal="hooke")) for w in scene.walls))
    ends = []
    for one in (scene, hooke):
        simulation = Simulation(one, on_instability="off")
        simulation.setup()
        simulation.advance(1000)
        ends.append(simulation.bodies.x.copy())
    assert np.abs(ends[0] - scene.particles.x).max() > 1e-4
    assert np.abs(ends[0] - ends[1]).max() < 1e-7  # of a way of 1e-3 m, steps of 1/500 contact


def test_a_one_sided_plane_does_nothing_behind_it() -> None:
    """Law: a sphere behind a plane that is felt from one side flies on, also where the step is solved."""
    p = spheres(np.array([[0.0, 0.0, -0.004]]), np.array([0.005]), v=np.array([[0.1, 0.0, 0.2]]))
    for one_sided in (True, False):
        wall = Wall("w", Plane((0.0, 0.0, 1.0), 0.0, one_sided=one_sided), law((1,)))
        simulation = Simulation(Scene(box(1.0), p, 1, 1e-5, walls=(wall,), integrate=(NveSphere(),), neighbor=Neighbor(0.01)), on_instability="off")
        simulation.setup()
        simulation.advance(3)
        assert np.array_equal(simulation.bodies.v, p.v) is one_sided


def test_frozen_spheres_stay() -> None:
    """Law: a frozen sphere neither moves nor takes energy from what hits it."""
    p = spheres(np.array([[0.0, 0, 0], [0.0, 0.0, 0.012]]), np.full(2, 0.005), v=np.array([[0.0, 0, 0], [0.0, 0.0, -1.0]]))
    p = replace(p, mask=np.array([3, 1]))
    scene = Scene(
        box(1.0), p, 1, 2e-5, pair=law((1, 1)), forces=(Freeze(1),), integrate=(NveSphere(),), neighbor=Neighbor(0.01),
    )  # fmt: skip
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    simulation.advance(600)
    assert not simulation.bodies.v[0].any()
    assert np.allclose(simulation.bodies.v[1], [0.0, 0.0, 1.0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("normal", ["discrete_gradient", "fujioka2006"])
def test_threads_change_nothing(normal: str) -> None:
    """Law: with any number of threads the same motion, bit for bit, although such laws set sums aside."""
    one_each = {"kn": KN * np.ones((1, 1)), "restitution": 0.7 * np.ones((1, 1))}
    scene = replace(heap(np.random.default_rng(10), 0.2), walls=(), forces=(), box=box(10.0))
    scene = replace(scene, pair=ContactLaw(normal, "none", "none", "none", "none", one_each))
    ends = []
    for threads in (1, 2):
        simulation = Simulation(scene, threads=threads, on_instability="off")
        simulation.setup()
        simulation.advance(50)
        ends.append(simulation.bodies.x.copy())
    assert np.array_equal(*ends)


def test_what_it_cannot_hold_is_refused() -> None:
    """Law: other normal laws, Euler, setforce, and a skin shorter than a step are refused in words."""
    scene = heap(np.random.default_rng(9), 0.1, n=8)
    with pytest.raises(ValueError, match="can have no other: all pairs and walls, not hooke"):
        Simulation(replace(scene, pair=law((1, 1), normal="hooke")), on_instability="off")
    with pytest.raises(ValueError, match="not semi-implicit Euler"):
        Simulation(replace(scene, integrate=(EulerSphere(),)), on_instability="off")
    with pytest.raises(ValueError, match="setforce"):
        Simulation(replace(scene, forces=(SetForce((0.0, None, None)),)), on_instability="off")
    simulation = Simulation(replace(scene, neighbor=Neighbor(1e-9)), on_instability="off")
    simulation.setup()
    with pytest.raises(Unstable, match="more than half the skin 1e-09"):
        simulation.advance(10)

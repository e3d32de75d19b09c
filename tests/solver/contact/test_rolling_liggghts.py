"""LIGGGHTS' rolling models alone: limits, springs, what they take and where they give, and a ball that rolls to rest."""

from __future__ import annotations

import inspect
from dataclasses import dataclass, field, replace
from math import exp, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from demsolver import Box, ContactLaw, Scene, Slab, Wall, contact
from demsolver.reference import History, forces
from tests.support.scenes import spheres

Floats = NDArray[np.float64]
SPRINGS = ("epsd", "epsd2")
NAMES = ("cdt", *SPRINGS)
X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Contact:
    """What a rolling law is told; n a unit normal, w (3,) the relative spin, r (3,) the memory. The values suit spheres of 5 mm."""

    w: Floats = field(default_factory=lambda: 20.0 * X)
    n: Floats = field(default_factory=lambda: Z)
    r: Floats = field(default_factory=lambda: np.zeros(3))
    normal_elastic: float = 0.5
    stiffness: float = 1e4
    kt: float = 3e3
    critical_force: float = 0.4
    reff: float = 2.5e-3
    radius: float = 5e-3
    overlap: float = 5e-5
    partner_curvature: float = 200.0
    rolling_inertia: float = 2e-8
    arm_ratio: float = 1.0
    rolling_friction: float = 0.2
    rolling_damping_ratio: float = 0.0
    torsion: float = 0.0
    dt: float = 1e-5
    advance: bool = True

    @property
    def limit(self) -> float:
        """rolling_friction R* |F|."""
        return self.rolling_friction * self.reff * self.critical_force

    def kr(self, name: str) -> float:
        """Stiffness of the spring of torque: epsd 2.25 kn rolling_friction^2 R*^2, epsd2 kt R*^2."""
        return 2.25 * self.stiffness * (self.rolling_friction * self.reff) ** 2 if name == "epsd" else self.kt * self.reff**2

    @property
    def u(self) -> Floats:
        """The spin that the springs feel."""
        return self.arm_ratio * (self.w - (1.0 - self.torsion) * (self.w @ self.n) * self.n)


def call(name: str, c: Contact, function: str = "torque") -> tuple[float, ...] | float:
    """One function of a law."""
    law = getattr(contact.law("rolling", name), function)
    known = {key: getattr(c, key) for key in c.__dataclass_fields__}
    for letter, vector in (("n", c.n), ("w", c.w), ("r", c.r)):
        known |= {letter + axis: float(value) for axis, value in zip("xyz", vector, strict=True)}
    return law(*(known[parameter] for parameter in inspect.signature(law).parameters))  # type: ignore[no-any-return]


def torque(name: str, c: Contact) -> tuple[Floats, Floats]:
    """Torque on the particle and the new memory."""
    result = np.array(call(name, c))
    return result[:3], result[3:] if len(result) > 3 else np.zeros(3)


def energy(name: str, c: Contact) -> float:
    """What the spring holds."""
    value = call(name, c, "energy")
    assert isinstance(value, float)
    return value


vectors = st.tuples(*[st.integers(-1000, 1000).map(lambda k: k / 1000.0)] * 3).map(np.array)


@st.composite
def contacts(draw: st.DrawFn, torsions: tuple[float, ...] = (0.0, 1.0)) -> Contact:
    """Springs short and long against their limit, at pairs and at walls."""
    n = draw(vectors)
    assume(np.linalg.norm(n) > 0.1)
    wall = draw(st.booleans())
    return Contact(
        w=100.0 * draw(vectors),
        n=n / np.linalg.norm(n),
        r=draw(vectors) * draw(st.sampled_from([0.0, 1e-5, 1e-4, 1e-3])),
        critical_force=draw(st.sampled_from([0.0, 1e-3, 0.4])),
        rolling_friction=draw(st.sampled_from([0.01, 0.2, 2.0])),
        rolling_damping_ratio=draw(st.sampled_from([0.0, 0.3])),
        torsion=draw(st.sampled_from(torsions)),
        arm_ratio=(5e-3 - 2.5e-5) / (5e-3 - 5e-5) if wall else 1.0,
        partner_curvature=0.0 if wall else 200.0,
        dt=draw(st.sampled_from([1e-6, 1e-3])),
    )


# Constant torque ----------------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(c=contacts())
def test_cdt_is_constant_but_for_the_twist(c: Contact) -> None:
    """Law: T = -rolling_friction R* F_elastic w/|w| with torsion; without, its part in the tangent plane, smaller by |w_t|/|w|."""
    spin = np.linalg.norm(c.w)
    wanted = -c.rolling_friction * c.reff * c.normal_elastic * c.u / c.arm_ratio / (spin or 1.0)
    assert torque("cdt", c)[0] == pytest.approx(wanted, rel=1e-12, abs=1e-18)


@settings(deadline=None)
@given(c=contacts())
def test_cdt_never_drives(c: Contact) -> None:
    """Law: T.w <= 0, to the rounding of T |w|."""
    assert torque("cdt", c)[0] @ c.w <= 1e-15 * c.rolling_friction * c.reff * c.normal_elastic * np.linalg.norm(c.w)


def test_cdt_turns_a_small_spin_round() -> None:
    """Law: in steps a spin s < T dt/I goes on as s, s - T dt/I, s, ...: every other step gives energy, up to (T dt)^2/(2 I)."""
    c = Contact()
    kick = c.rolling_friction * c.reff * c.normal_elastic * c.dt / c.rolling_inertia
    spins = [0.2 * kick]
    for _ in range(4):
        spins.append(spins[-1] + float(torque("cdt", replace(c, w=spins[-1] * X))[0] @ X) * c.dt / c.rolling_inertia)
    assert spins == pytest.approx([0.2 * kick, -0.8 * kick] * 2 + [0.2 * kick])
    assert max(np.square(spins)) <= kick**2


# Springs of torque --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SPRINGS)
@settings(deadline=None)
@given(c=contacts())
def test_a_spring_is_cut_at_its_limit(name: str, c: Contact) -> None:
    """Law: h + dt kr u, cut to rolling_friction R* |F|; T = -h where it is cut, else -h - 2 damping sqrt(I kr) u (epsd only)."""
    h = c.r + c.dt * c.kr(name) * c.u
    size = float(np.linalg.norm(h))
    assume(abs(size - c.limit) > 1e-9 * size)  # not where rounding decides
    damper = 2.0 * c.rolling_damping_ratio * sqrt(c.rolling_inertia * c.kr(name)) if name == "epsd" else 0.0
    cut = size > c.limit
    found, memory = torque(name, c)
    assert memory == pytest.approx(h * (c.limit / size if cut else 1.0), rel=1e-12, abs=1e-20)
    assert found == pytest.approx(-memory if cut else -memory - damper * c.u, rel=1e-12, abs=1e-20)


@pytest.mark.parametrize("name", SPRINGS)
@settings(deadline=None)
@given(c=contacts())
def test_set_up_takes_one_increment_and_keeps_the_memory(name: str, c: Contact) -> None:
    """Law: forces of a set-up are those of a step, the torque's dt kr u included; h stays as it was."""
    step, start = torque(name, c), torque(name, replace(c, advance=False))
    assert start[0] == pytest.approx(step[0])
    assert np.array_equal(start[1], c.r)


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None)
@given(c=contacts())
def test_exchanged_particles_feel_the_opposite(name: str, c: Contact) -> None:
    """Law: with n, w and memory seen from the partner (MEMORY: all signs -1), torque and memory are the opposite, the energy the same."""
    assert set(contact.memory("rolling", name).values()) <= {-1}
    other = replace(c, n=-c.n, w=-c.w, r=-c.r)
    for one, two in zip(torque(name, c), torque(name, other), strict=True):
        assert np.array_equal(one, -two)
    assert energy(name, c) == energy(name, other)


def test_the_dashpot_of_epsd_is_outside_the_limit() -> None:
    """Law: a fresh contact is damped by 2 damping sqrt(I kr) u, however far that is above rolling_friction R* |F|."""
    c = Contact(w=400.0 * X, rolling_damping_ratio=0.5, dt=1e-9)
    assert abs(torque("epsd", c)[0][0]) == pytest.approx(400.0 * sqrt(c.rolling_inertia * c.kr("epsd")), rel=1e-3)
    assert abs(torque("epsd", c)[0][0]) > 10.0 * c.limit


def test_one_is_critical_damping() -> None:
    """Law: with damping 1 and below the limit, I w' = T from a spin w0 turns by w0 t exp(-t sqrt(kr/I))."""
    c = Contact(rolling_damping_ratio=1.0, critical_force=1e3, dt=1e-6)
    rate = sqrt(c.kr("epsd") / c.rolling_inertia)
    w, angle = 20.0, 0.0
    for _ in range(round(2.0 / rate / c.dt)):
        found, memory = torque("epsd", replace(c, w=w * X))
        angle += w * c.dt
        w += found[0] * c.dt / c.rolling_inertia
        c = replace(c, r=memory)
    t = round(2.0 / rate / c.dt) * c.dt
    assert memory[0] == pytest.approx(c.kr("epsd") * angle)
    assert angle == pytest.approx(20.0 * t * exp(-rate * t), rel=5.0 * rate * c.dt)  # first order in the step


# Energy -------------------------------------------------------------------------------------------------------------------


def taken(name: str, path: list[Contact]) -> float:
    """Work against the torque at the end of every step, less what the spring has gained, from the memory of the first contact on."""
    memory, work = path[0].r, 0.0
    start = energy(name, path[0])
    for c in path:
        found, memory = torque(name, replace(c, r=memory))
        work -= float(found @ c.w) * c.dt
    return work - (energy(name, replace(path[-1], r=memory)) - start)


def largest(name: str, path: list[Contact]) -> float:
    """The work if spin and torque were along each other all the time, the spin along n included, in which rounding lies."""
    turns = [float(np.linalg.norm(c.w)) * c.dt for c in path]
    torques = [float(np.linalg.norm(path[0].r)) + path[0].kr(name) * sum(turns) + float(np.linalg.norm(torque(name, c)[0])) for c in path]
    return sum(size * turn for size, turn in zip(torques, turns, strict=True)) + energy(name, path[0])


@pytest.mark.parametrize("name", SPRINGS)
@settings(deadline=None)
@given(c=contacts((0.0,)), spins=st.lists(vectors, min_size=1, max_size=8), limits=st.lists(st.sampled_from([0.0, 1e-3, 0.4]), min_size=8))
def test_a_spring_never_gives_while_n_and_stiffness_stay(name: str, c: Contact, spins: list[Floats], limits: list[float]) -> None:
    """Law: whatever the spin and the limit do, what is taken is not negative: cut springs lose, dashpots take."""
    across = c.r - (c.r @ c.n) * c.n
    path = [replace(c, r=across, w=100.0 * w, critical_force=limit) for w, limit in zip(spins, limits, strict=False)]
    assert taken(name, path) >= -1e-12 * largest(name, path)


@pytest.mark.parametrize("name", SPRINGS)
@settings(deadline=None)
@given(c=contacts((1.0,)), turns=st.lists(st.tuples(vectors, vectors), min_size=1, max_size=8))
def test_with_torsion_a_turning_normal_is_free(name: str, c: Contact, turns: list[tuple[Floats, Floats]]) -> None:
    """Law: with torsion 1 the spring is one of space: it never gives, however n turns."""
    path = [replace(c, w=100.0 * w, n=n) for w, n in turns]
    assert taken(name, path) >= -1e-12 * largest(name, path)


@pytest.mark.parametrize("name", SPRINGS)
@pytest.mark.parametrize("wall", [False, True])
def test_the_energy_is_the_work_that_wound_the_spring(name: str, wall: bool) -> None:
    """Law: below the limit, winding a spring takes h^2/(2 kr), at a wall divided by arm_ratio: by the trapezoid rule exactly."""
    ratio = (5e-3 - 2.5e-5) / (5e-3 - 5e-5) if wall else 1.0
    c = Contact(arm_ratio=ratio, partner_curvature=0.0 if wall else 200.0, critical_force=1e3)
    memory, last, work = np.zeros(3), np.zeros(3), 0.0
    for _ in range(10):
        found, memory = torque(name, replace(c, r=memory))
        work -= 0.5 * float((found + last) @ c.w) * c.dt
        last = found
    assert energy(name, replace(c, r=memory)) == pytest.approx(work, rel=1e-12)
    assert work == pytest.approx(float(memory @ memory) / (2.0 * c.kr(name) * ratio), rel=1e-12)


@pytest.mark.parametrize("name", SPRINGS)
def test_a_softer_spring_holds_more(name: str) -> None:
    """Law: wound in a stiff contact and unwound in one half as stiff, the spring gives twice what it took: energy from nothing."""
    stiff = Contact(critical_force=1e3)
    soft = replace(stiff, stiffness=0.5 * stiff.stiffness, kt=0.5 * stiff.kt)
    path = [stiff] * 10 + [replace(soft, w=-soft.w)] * 20
    wound = energy(name, replace(stiff, r=10 * stiff.dt * stiff.kr(name) * stiff.u))
    gained = -taken(name, path)
    # forces at the ends of 10 and of 20 steps see 11/10 of what goes in and 19/20 of what comes out
    assert gained == pytest.approx((2.0 * 19 / 20 - 11 / 10) * wound)


@pytest.mark.parametrize("name", SPRINGS)
def test_a_spring_left_along_the_normal_drives_for_ever(name: str) -> None:
    """Law: h does not turn with n. Come to lie along n, it drives the twist, and without torsion does not run down; with torsion it does."""
    c = Contact(r=1e-4 * Z, w=-20.0 * Z, critical_force=1e3)
    found, memory = torque(name, c)
    assert found == pytest.approx(-1e-4 * Z)
    assert memory == pytest.approx(1e-4 * Z)
    assert taken(name, [c] * 100) == pytest.approx(-100 * 1e-4 * 20.0 * c.dt)
    assert taken(name, [replace(c, torsion=1.0)] * 100) >= 0.0


@pytest.mark.parametrize("name", SPRINGS)
def test_no_stiffness_stores_nothing(name: str) -> None:
    """Law: without stiffness, or without friction against rolling, torque and energy are finite zeros."""
    for c in (Contact(rolling_friction=0.0), Contact(stiffness=0.0, kt=0.0)):
        assert not np.abs(torque(name, c)[0]).any()
        assert energy(name, replace(c, r=1e-6 * X) if name == "epsd" else Contact(kt=0.0)) == 0.0


# A ball on a plane --------------------------------------------------------------------------------------------------------


def rolled(rolling: str, *, rolling_friction: float, steps: int) -> float:
    """Speed of a ball of 5 mm after rolling at 0.3 m/s over a plane, under its weight."""
    values = {
        "kn": 1e4,
        "gamman": 300.0,
        "shear_stiffness": 3e3,
        "xt": 0.5,
        "mu": 0.8,
        "rolling_friction": rolling_friction,
        "torsion": 0.0,
        "rolling_damping_ratio": 0.0,
    }
    law = ContactLaw(
        "hooke", "mass_velocity", "constant", "scaled", "liggghts_history", {k: np.array([v]) for k, v in values.items()}, "contact", "contact",
        rolling=rolling,
    )  # fmt: skip
    p = spheres(np.array([[0.0, 0.0, 0.005]]), np.array([0.005]))
    g = np.array([0.0, 0.0, -9.81])
    mass, inertia, dt = p.mass[0], 0.4 * p.mass[0] * 0.005**2, 2e-5
    x, v = p.x + g * mass / 1e4, np.array([[0.3, 0.0, 0.0]])
    w = np.array([[0.0, 0.3 / 0.005, 0.0]])
    scene = Scene(Box(np.full(3, -1.0), np.full(3, 1.0), ("ff",) * 3), p, 1, dt, walls=(Wall("floor", Slab(2, lo=0.0), law),))
    history: History = {}
    for _ in range(steps):
        force, torque, history = forces(scene, x, v, w, history, True)
        v, w = v + dt * (force / mass + g), w + dt * torque / inertia
        x = x + dt * v
    return float(v[0, 0])


@pytest.mark.parametrize("rolling", NAMES)
def test_a_rolling_ball_slows_down_by_five_sevenths(rolling: str) -> None:
    """Law: at the limit, M = mu_r R m g slows a rolling ball by (5/7) mu_r g; levers R - overlap/2 change that by overlap/R = 3e-5."""
    rolling_friction, steps = 0.1, 1500
    wanted = 0.3 - 5.0 / 7.0 * rolling_friction * 9.81 * steps * 2e-5
    # winding the spring up to its limit takes some of that time: an angle of limit/kr = 4e-5 (epsd), 4e-4 (epsd2), 1e-3 of the way
    assert rolled(rolling, rolling_friction=rolling_friction, steps=steps) == pytest.approx(wanted, abs=2e-3 * (0.3 - wanted))

"""Mindlin's spring in its variants: how it follows the contact radius, Coulomb's bound, and which of them can give energy from nothing."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from demsolver import contact
from tests.support.calls import call, exchanged, numbers, spread, unit, vectors
from tests.support.turns import rotation

Floats = NDArray[np.float64]
VARIANTS = ("mindlin_force", "mindlin_rescale", "mindlin_rescale_force")
NAMES = ("rotated_history", *VARIANTS)  # rotated_history is LAMMPS' mindlin without a suffix
SHEAR = 1e7  # kt = SHEAR times the contact radius
SMALL, LARGE = 1e-4, 2e-4  # contact radii
STEPS = 400


def law_of(name: str) -> ModuleType:
    """The module of a friction law."""
    return contact.law("friction", name)


def known(radius: float, v: Floats, memory: dict[str, float], **changes: Any) -> dict[str, Any]:
    """A contact along z that no limit cuts."""
    start = {"critical_force": 1e9, "contact_radius": radius, "kt": SHEAR * radius, "gt": 0.0, "mu": 0.5, "dt": 1e-6, "advance": True}
    return start | spread("n", np.array([0.0, 0.0, 1.0])) | spread("vt", v) | memory | changes


class Contact:
    """One contact led by hand: what it did, what it holds."""

    def __init__(self, name: str) -> None:
        self.law = law_of(name)
        self.memory = dict.fromkeys(self.law.MEMORY, 0.0)
        self.force, self.radius, self.work = np.zeros(3), SMALL, 0.0

    def step(self, radius: float, way: Floats) -> None:
        """Moves the surfaces by `way` (3,) against each other at a new contact radius; the work is by the trapezoid rule."""
        result = call(self.law.force, known(radius, way / 1e-6, self.memory))
        self.memory = dict(zip(self.memory, result[3:], strict=True))
        last, self.force, self.radius = self.force, np.array(result[:3]), radius
        self.work -= 0.5 * float((last + self.force) @ way)

    def lead(self, radius: float, x: float) -> None:
        """In small steps to another contact radius and by x along the x axis."""
        for r in np.linspace(self.radius, radius, STEPS + 1)[1:]:
            self.step(float(r), np.array([x / STEPS, 0.0, 0.0]))

    @property
    def stored(self) -> float:
        """Energy of the spring."""
        return float(call(self.law.energy, known(self.radius, np.zeros(3), self.memory)))


@pytest.mark.parametrize("name", VARIANTS)
def test_at_one_contact_radius_they_are_one(name: str) -> None:
    """Law: while the contact radius stays, increments of force and increments of displacement are the same spring, slip and all."""
    rng, first, other = np.random.default_rng(1), Contact("rotated_history"), Contact(name)
    for _ in range(200):
        way = np.array([*rng.normal(0.0, 1e-5, 2), 0.0])
        for contact_ in (first, other):
            contact_.step(SMALL, way)
        assert other.force == pytest.approx(first.force, rel=1e-10, abs=1e-12)
        assert other.stored == pytest.approx(first.stored, rel=1e-10)


# F after the contact radius went from `first` to `second` at a spring that does not move, over F before
FOLLOWS = {"rotated_history": (0.5, 2.0), "mindlin_force": (1.0, 1.0), "mindlin_rescale": (0.25, 2.0), "mindlin_rescale_force": (0.5, 1.0)}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("closing", [False, True], ids=["opening", "closing"])
def test_how_the_force_follows_the_contact(name: str, closing: bool) -> None:
    """Law: with the contact radius halved (doubled) a spring of displacement pulls half (twice), that of force all; rescaled as it opens
    a quarter and half (twice and all)."""
    one = Contact(name)
    first, second = (SMALL, LARGE) if closing else (LARGE, SMALL)
    one.lead(first, 0.0)
    one.lead(first, 1e-6)
    before = one.force
    one.lead(second, 0.0)
    assert one.force == pytest.approx(FOLLOWS[name][closing] * before, rel=1e-12)


# Energy gained in a closed cycle of displacement, over kt s^2/2 at the small radius: loaded at one radius by s, unloaded at the other until F = 0.
CYCLES = {
    "rotated_history": {"loaded small": 1.0, "loaded large": -1.0},  # +-(2 - 1)
    "mindlin_force": {"loaded small": -0.5, "loaded large": 2.0},  # 1/2 - 1; 4 - 2
    "mindlin_rescale": {"loaded small": 1.0, "loaded large": -1.75},  # 2 - 1; 1/4 - 2
    "mindlin_rescale_force": {"loaded small": -0.5, "loaded large": -1.0},  # 1/2 - 1; 1 - 2
}


@pytest.mark.parametrize("loaded", ["loaded small", "loaded large"])
@pytest.mark.parametrize("name", NAMES)
def test_cycles(name: str, loaded: str) -> None:
    """Law: loaded at kt_1 and unloaded at kt_2, a cycle gives what the docstrings say: out of nothing in every variant but one."""
    one, s = Contact(name), 1e-6
    first, second = (SMALL, LARGE) if loaded == "loaded small" else (LARGE, SMALL)
    one.lead(first, 0.0)
    one.lead(first, s)
    one.lead(second, 0.0)
    one.lead(second, one.force[0] / (SHEAR * second))
    assert one.stored == pytest.approx(0.0, abs=1e-20)
    # the trapezoid rule is exact where kt stays, and nothing moves where it does not
    assert -one.work == pytest.approx(CYCLES[name][loaded] * 0.5 * SHEAR * SMALL * s**2, rel=1e-9)


path = st.lists(st.tuples(numbers(0.5, 1.5), vectors), min_size=1, max_size=30)


@settings(deadline=None)
@given(path)
def test_rescaled_force_gives_nothing(steps: list[tuple[float, Floats]]) -> None:
    """Law (Thornton): whatever way a mindlin_rescale/force contact is led, what it holds is no more than what was put in: in every step
    E' - E <= work, the work that of the force after the contact opened or closed, and then moved."""
    one = Contact("mindlin_rescale_force")
    for factor, way in steps:
        radius, move = SMALL * factor, 1e-6 * np.array([way[0], way[1], 0.0])
        before = one.stored
        one.step(radius, np.zeros(3))
        scale = before + SHEAR * radius * float(move @ move)
        assert one.stored <= before + 1e-14 * scale
        before, work = one.stored, one.work
        one.step(radius, move)
        assert one.stored - before == pytest.approx(one.work - work, abs=1e-12 * scale)


@st.composite
def contacts(draw: st.DrawFn, name: str) -> dict[str, Any]:
    """Sticking and sliding contacts, opening and closing; the spring may lean out of the tangent plane."""
    n, v, w = draw(vectors), draw(vectors), draw(vectors)
    assume(np.linalg.norm(n) > 0.1)
    n = unit(n)
    spring = np.cross(n, w) + draw(numbers(-2.0, 2.0)) * np.linalg.norm(np.cross(n, w)) * n
    size = draw(st.sampled_from([0.0, 1e-2, 1.0, 10.0])) * (1.0 if "force" in name else 1e-3)
    memory = spread("elastic_" if "force" in name else "s", size * spring) | {"last_radius": draw(st.sampled_from([0.0, 1e-4, 1.5e-4]))}
    changes = {
        "critical_force": draw(numbers(0.0, 5.0)), "gt": draw(numbers(0.0, 5.0)), "mu": draw(numbers(0.0, 1.0)), "advance": draw(st.booleans()),
    }  # fmt: skip
    return known(1.2e-4, v - (v @ n) * n, {key: memory[key] for key in law_of(name).MEMORY}, **spread("n", n), **changes)


@pytest.mark.parametrize("name", VARIANTS)
@settings(deadline=None)
@given(data=st.data())
def test_force_obeys_coulomb(name: str, data: st.DataObject) -> None:
    """Law: |Ft| <= mu |Fn|, damping included; the spring left behind is the force less its damping."""
    one = data.draw(contacts(name))
    result = call(law_of(name).force, one)
    limit = one["mu"] * one["critical_force"]
    assert np.linalg.norm(result[:3]) <= limit * (1.0 + 1e-12)
    slips = np.linalg.norm(result[:3]) >= limit * (1.0 - 1e-12) > 0.0
    spring = np.array(result[3:6]) * (1.0 if "force" in name else -one["kt"])
    if slips:
        assert spring - one["gt"] * np.array([one["vtx"], one["vty"], one["vtz"]]) == pytest.approx(np.array(result[:3]), abs=1e-9)


@pytest.mark.parametrize("name", VARIANTS)
def test_a_stuck_contact(name: str) -> None:
    """Law: a spring tilted out of the tangent plane is turned into it at its length, grows by the way of the step, and the dashpot adds -gt vt."""
    law, tilted, v = law_of(name), np.array([3.0, 4.0, 12.0]), np.array([0.2, -0.1, 0.0])
    kt = SHEAR * SMALL
    stored = tilted if "force" in name else -tilted / kt
    memory = dict(zip(law.MEMORY, [*stored, SMALL], strict=False))
    result = np.array(call(law.force, known(SMALL, v, memory, gt=5.0)))
    spring = 13.0 / 5.0 * np.array([3.0, 4.0, 0.0]) - kt * 1e-6 * v
    assert result[:3] == pytest.approx(spring - 5.0 * v, rel=1e-12)
    assert result[3:6] * (1.0 if "force" in name else -kt) == pytest.approx(spring, rel=1e-12)


@pytest.mark.parametrize("name", VARIANTS)
def test_turning_the_contact_turns_the_answer(name: str) -> None:
    """Law: no direction of space is special, opening and slipping included."""
    law, turn = law_of(name), rotation(np.array([1.0, -2.0, 0.5]), 0.7)
    n, v, spring = np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.1, 0.0]), np.array([1.0, -2.0, 0.7]) * (1.0 if "force" in name else 1e-3)
    for mu in (1.0, 1e-12):
        answers = []
        for matrix in (np.eye(3), turn):
            memory = dict(zip(law.MEMORY, [*(matrix @ spring), 2.0 * SMALL], strict=False))
            result = np.array(call(law.force, known(SMALL, matrix @ v, memory, gt=2.0, mu=mu, **spread("n", matrix @ n))))
            answers.append(np.concatenate([matrix.T @ result[:3], matrix.T @ result[3:6], result[6:]]))
        assert answers[1] == pytest.approx(answers[0], rel=1e-12, abs=1e-14 * np.abs(answers[0]).max())


@pytest.mark.parametrize("name", VARIANTS)
@settings(deadline=None)
@given(data=st.data())
def test_seen_from_the_partner(name: str, data: st.DataObject) -> None:
    """Law: with the particles exchanged, memory turned by its signs, the force and the new memory are turned too."""
    law, one = law_of(name), data.draw(contacts(name))
    mine, theirs = call(law.force, one), call(law.force, exchanged(one, law.MEMORY))
    assert np.array_equal(-np.array(mine[:3]), theirs[:3])
    assert np.array_equal(np.array(mine[3:]) * list(law.MEMORY.values()), theirs[3:])


@pytest.mark.parametrize("name", VARIANTS)
def test_set_up_leaves_the_memory(name: str) -> None:
    """Law: forces at set-up come from the memory as it is; only what opening takes is taken, as LAMMPS does it."""
    law, v = law_of(name), np.array([0.1, 0.0, 0.0])
    one = Contact(name)
    one.lead(SMALL, 1e-6)
    again = call(law.force, known(SMALL, v, one.memory, advance=False))
    assert list(again[3:]) == pytest.approx(list(one.memory.values()), rel=1e-14)
    assert again[0] == pytest.approx(-SHEAR * SMALL * 1e-6, rel=1e-9)
    opened = call(law.force, known(SMALL / 2, v, one.memory, advance=False))
    assert opened[0] == pytest.approx(FOLLOWS[name][False] * again[0], rel=1e-9)

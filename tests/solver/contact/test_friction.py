"""Friction laws: Coulomb's bound as each engine has it, histories, set-up, and that no direction of space is special."""

from __future__ import annotations

import inspect
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from demsolver import contact
from tests.support.turns import rotation

Floats = NDArray[np.float64]
WITH_HISTORY = ("classic_history", "liggghts_history", "rotated_history")  # of the displacement; other memories have tests of their own
NAMES = (*WITH_HISTORY, "no_history")
BOUND_ON_THE_SUM = tuple(name for name in NAMES if name != "liggghts_history")


@dataclass(frozen=True)
class Contact:
    """What a friction law is told. n: unit normal; vt: (3,) tangential velocity; s: (3,) history."""

    n: Floats
    vt: Floats
    s: Floats
    critical_force: float = 3.0
    kt: float = 1e4
    gt: float = 2.0
    mu: float = 0.5
    dt: float = 1e-5
    advance: bool = True

    @property
    def limit(self) -> float:
        """mu |Fn|."""
        return self.mu * self.critical_force


def apply(name: str, c: Contact) -> tuple[Floats, Floats]:
    """Tangential force and new history."""
    function = contact.law("friction", name).force
    known: dict[str, Any] = {key: getattr(c, key) for key in ("critical_force", "kt", "gt", "mu", "dt", "advance")}
    for letter, vector in (("n", c.n), ("vt", c.vt), ("s", c.s)):
        known |= {letter + axis: float(value) for axis, value in zip("xyz", vector, strict=True)}
    result = np.array(function(*(known[p] for p in inspect.signature(function).parameters)))
    return result[:3], result[3:] if len(result) > 3 else c.s


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of six decimals: far from underflow."""
    return st.integers(round(low * 1e6), round(high * 1e6)).map(lambda k: k * 1e-6)


vectors = st.tuples(*[numbers(-1.0, 1.0)] * 3).map(np.array)


@st.composite
def contacts(draw: st.DrawFn) -> Contact:
    """Sticking and sliding contacts; the history may lean out of the tangent plane, but not up to n."""
    n, v, w = draw(vectors), draw(vectors), draw(vectors)
    assume(np.linalg.norm(n) > 0.1)
    n = n / np.linalg.norm(n)
    s = np.cross(n, w)
    s = s + draw(numbers(-2.0, 2.0)) * np.linalg.norm(s) * n
    return Contact(
        n=n,
        vt=v - (v @ n) * n,
        s=s * draw(st.sampled_from([0.0, 1e-6, 1e-4, 1e-2])),
        critical_force=draw(numbers(0.0, 5.0)),
        gt=draw(numbers(0.0, 5.0)),
        mu=draw(numbers(0.0, 1.0)),
        advance=draw(st.booleans()),
    )


@pytest.mark.parametrize("name", BOUND_ON_THE_SUM)
@settings(deadline=None)
@given(c=contacts())
def test_force_obeys_coulomb(name: str, c: Contact) -> None:
    """|Ft| <= mu |Fn|, damping included."""
    force, _ = apply(name, c)
    assert np.linalg.norm(force) <= c.limit * (1.0 + 1e-12)


@settings(deadline=None)
@given(c=contacts())
def test_liggghts_bounds_the_spring_alone(c: Contact) -> None:
    """kt |s| <= mu |Fn| after an advance; the force is that spring, and all of the damping in stick, none in slip."""
    force, s = apply("liggghts_history", replace(c, advance=True))
    spring = c.kt * np.linalg.norm(s)
    assert spring <= c.limit * (1.0 + 1e-12)
    damping = force + c.kt * s
    slips = spring >= c.limit * (1.0 - 1e-9)
    assert np.allclose(damping, -c.gt * c.vt, rtol=0, atol=1e-9) or (slips and np.allclose(damping, 0.0, atol=1e-9))


def test_liggghts_damping_exceeds_the_bound() -> None:
    """A fresh LIGGGHTS contact is damped without limit, even without friction: Ft = -gt vt at set-up with mu = 0."""
    c = Contact(np.array([0.0, 0, 1]), np.array([2.0, 0, 0]), np.zeros(3), mu=0.0, advance=False)
    force, s = apply("liggghts_history", c)
    assert force == pytest.approx([-4.0, 0.0, 0.0])
    assert not s.any()


@pytest.mark.parametrize("name", ["classic_history", "rotated_history"])
def test_lammps_drops_a_fresh_contact_over_the_bound(name: str) -> None:
    """A LAMMPS contact without history whose damping exceeds mu |Fn| feels no tangential force at set-up, not mu |Fn|."""
    c = Contact(np.array([0.0, 0, 1]), np.array([2.0, 0, 0]), np.zeros(3), advance=False)
    assert c.gt * 2.0 > c.limit
    force, s = apply(name, c)
    assert not force.any()
    assert not s.any()
    stuck, _ = apply(name, replace(c, gt=0.5))
    assert stuck == pytest.approx([-1.0, 0.0, 0.0])


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(c=contacts(), axis=vectors, angle=numbers(0.1, 6.0))
def test_turning_the_contact_turns_the_answer(name: str, c: Contact, axis: Floats, angle: float) -> None:
    """Rotated normal, velocity and history give the rotated force and history."""
    assume(np.linalg.norm(axis) > 0.1)
    size = c.limit + c.gt + c.kt * np.linalg.norm(c.s)
    less, more = (apply(name, replace(c, mu=c.mu * factor))[0] for factor in (1.0 - 1e-9, 1.0 + 1e-9))
    assume(np.allclose(less, more, rtol=0, atol=1e-6 * size))  # not where rounding decides between stick and slip
    along = np.linalg.norm(c.s - (c.s @ c.n) * c.n)
    assume(not c.s.any() or along > 1e-6 * np.linalg.norm(c.s) > 1e-30)  # nor where it decides whether there is a spring at all
    turn = rotation(axis / np.linalg.norm(axis), angle)
    turned = replace(c, n=turn @ c.n, vt=turn @ c.vt, s=turn @ c.s)
    (force, s), (force_turned, s_turned) = apply(name, c), apply(name, turned)
    assert np.allclose(force_turned, turn @ force, rtol=0, atol=1e-9 * size + 1e-12)
    assert np.allclose(c.kt * s_turned, c.kt * (turn @ s), rtol=0, atol=1e-9 * size + 1e-12)


@pytest.mark.parametrize("name", WITH_HISTORY)
def test_history_grows_only_when_it_advances(name: str) -> None:
    """A sticking contact adds dt vt to s at a step and nothing at set-up."""
    c = Contact(np.array([0.0, 0, 1]), np.array([0.1, 0.2, 0]), np.array([1e-5, 0, 0]))
    assert apply(name, c)[1] == pytest.approx([1e-5 + 1e-6, 2e-6, 0.0])
    assert apply(name, replace(c, advance=False))[1] == pytest.approx(c.s)


@pytest.mark.parametrize(("name", "resets"), [("classic_history", True), ("rotated_history", True), ("liggghts_history", False)])
def test_slip_at_setup(name: str, resets: bool) -> None:
    """An overstretched spring pulls with mu |Fn| at set-up too; LAMMPS then shortens it there, LIGGGHTS at the next step."""
    c = Contact(np.array([0.0, 0, 1]), np.zeros(3), np.array([1e-2, 0, 0]), advance=False)
    force, s = apply(name, c)
    assert force == pytest.approx([-c.limit, 0.0, 0.0])
    assert s == pytest.approx([c.limit / c.kt if resets else 1e-2, 0.0, 0.0])


@pytest.mark.parametrize("name", WITH_HISTORY)
def test_slip_shortens_the_spring_to_the_bound(name: str) -> None:
    """At a step, gross sliding without damping leaves kt |s| = mu |Fn|, against the sliding direction."""
    c = Contact(np.array([0.0, 0, 1]), np.array([1.0, 0, 0]), np.array([1e-2, 0, 0]), gt=0.0)
    force, s = apply(name, c)
    assert force == pytest.approx([-c.limit, 0.0, 0.0])
    assert c.kt * s == pytest.approx([c.limit, 0.0, 0.0])


def test_spring_turns_with_the_contact() -> None:
    """Of a history tilted by 60 degrees pair granular keeps the length in the tangent plane, the two other laws half of it."""
    s = 1e-6 * np.array([0.5, 0.0, 0.75**0.5])
    c = Contact(np.array([0.0, 0, 1]), np.zeros(3), s)
    assert apply("rotated_history", c)[1] == pytest.approx([1e-6, 0.0, 0.0])
    for name in ("classic_history", "liggghts_history"):
        assert apply(name, c)[1] == pytest.approx([0.5e-6, 0.0, 0.0])


def test_spring_turns_only_when_it_matters() -> None:
    """pair granular leaves s alone while kt |s.n| is below 1e-10 of the bound."""
    small = 0.5e-10 * 1.5 / 1e4
    c = Contact(np.array([0.0, 0, 1]), np.zeros(3), np.array([1e-6, 0.0, small]))
    assert apply("rotated_history", c)[1][2] == small
    assert apply("rotated_history", replace(c, s=np.array([1e-6, 0.0, 4.0 * small])))[1][2] == 0.0


@pytest.mark.parametrize("name", WITH_HISTORY)
def test_no_spring_leaves_no_infinities(name: str) -> None:
    """kt = 0 is friction by damping alone, with finite force and history."""
    c = Contact(np.array([0.0, 0, 1]), np.array([1.0, 0, 0]), np.array([1e-6, 0, 0]), kt=0.0)
    force, s = apply(name, c)
    assert np.isfinite([*force, *s]).all()
    assert abs(force[0]) == pytest.approx(min(c.limit, 2.0) if name != "liggghts_history" else 2.0)


@settings(deadline=None)
@given(c=contacts())
def test_no_history_opposes_the_motion(c: Contact) -> None:
    """Ft = -min(gt |vt|, mu |Fn|) vt/|vt|."""
    force, _ = apply("no_history", c)
    speed = float(np.linalg.norm(c.vt))
    assert np.linalg.norm(force) == pytest.approx(min(c.gt * speed, c.limit), rel=1e-12, abs=1e-300)
    assert float(force @ c.vt) == pytest.approx(-np.linalg.norm(force) * speed, rel=1e-9, abs=1e-300)

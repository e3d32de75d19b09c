"""The linear answer of a contact law: its stiffness and damping for small motions, by differentiating the law as the loop runs it.

A contact answers to four motions: normal, tangential (a shift of the contact point), rolling and twisting. For each, force (or torque) is
-stiffness * displacement - damping * velocity, found by differences of the chained laws of `demsolver.contact`; so a new law needs nothing here.
A law whose force jumps with the direction of motion (Coulomb friction without a spring, constant directional torque) has no linear answer: it is
bounded and limits no step. A step law (`demsolver.contact`) has no force at a state, and its normal answer is nothing; an implicit law solves
for its spring, and only its damper answers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from demsolver.bind_law import STORED, coefficient_table, contact_source, is_implicit, is_step_law, law_functions, memory_signs
from demsolver.scene import ContactLaw
from demsolver.state import Floats

MOTIONS = ("normal", "tangential", "rolling", "twisting")
SMALL = 1e-5
"""Relative step of the difference in the overlap: its own error is SMALL^2, that of rounding 1e-16/SMALL."""
TINY = 1e-30
"""Displacement in overlaps a step: below every Coulomb limit; the springs start at rest, so nothing is lost to rounding."""
LARGE = 1e100
"""Stands for what is larger or overflows; its square is still a number."""
MANY = 20_000
"""From so many states on, compiling pays (some 3 s against 0.2 ms a state)."""


class Encounter(NamedTuple):
    """The state of one contact as its law sees it. row: of the coefficient table (type pair, or type for a wall). partner_radius: inf for a wall.
    reff, meff: effective radius and mass of the law; rolling_inertia as in `demsolver.contact`."""

    row: int
    overlap: float
    radius: float
    partner_radius: float
    reff: float
    meff: float
    rolling_inertia: float


@dataclass(frozen=True)
class Answers:
    """Of m states. force: (m,) elastic and cohesive normal force, positive when it pushes. stiffness, damping: (m, 4), a column for each of MOTIONS;
    force/length and force time/length for the first two, torque and torque time for the others."""

    force: Floats
    stiffness: Floats
    damping: Floats


class LinearLaw:
    """A ContactLaw made ready for questions. dt: the scene's step, which only step laws look at."""

    def __init__(self, law: ContactLaw, dt: float) -> None:
        """Raises ValueError for an unknown law, a missing coefficient, laws that do not go together."""
        self.law = law
        self._form = tuple((name, getattr(law, name)) for name in ContactLaw.__dataclass_fields__ if name != "coefficients")
        self.step_law, self.implicit = is_step_law(law), is_implicit(law)
        self._dt = dt
        self._coefficients = coefficient_table(law)

    def answers(self, states: Floats | Sequence[Encounter]) -> Answers:
        """Stiffness and damping at these states, (m, 7) rows of Encounter; rolling and twisting are zero where the law has none."""
        many = len(states) >= MANY
        contact, _, columns = _form(self._form, compiled=many)
        given, out = np.asarray(states, dtype=float), np.zeros((len(states), 9))
        with np.errstate(all="ignore"):
            fill, normal = njit(_fill) if many else _fill, (not (self.step_law or self.implicit), not self.step_law)
            fill(contact, given, self._coefficients, self._dt, columns, *normal, out)
        out = np.clip(np.nan_to_num(out, nan=0.0), -LARGE, LARGE)  # of numbers near the largest there are
        return Answers(out[:, 0], out[:, 1:5], out[:, 5:])

    def energy(self, state: Encounter, overlap: float) -> float:
        """Elastic and cohesive energy of the normal law at another overlap."""
        _, stored, columns = _form(self._form, compiled=False)
        known = {
            **state._asdict(), "row": int(state.row), "overlap": overlap, "partner_curvature": 1.0 / state.partner_radius, "vn": 0.0,
            "memory": np.zeros((1, columns)), "k": 0, "dt": self._dt, "coefficients": self._coefficients,
        }  # fmt: skip
        with np.errstate(all="ignore"):
            return float(stored(*[known[name] for name in STORED.split(", ")])[0])

    def linear_in_overlap(self, state: Encounter) -> bool:
        """Whether stiffness and damping stay what they are at half the overlap."""
        found = self.answers((state, state._replace(overlap=0.5 * state.overlap)))
        return bool(np.allclose(found.stiffness[0], found.stiffness[1], rtol=1e-6) and np.allclose(found.damping[0], found.damping[1], rtol=1e-6))

    def overlap_of(self, state: Encounter, energy: float) -> float:
        """The overlap at which the normal law has stored `energy` more than at first touch: the largest of an impact without damping.

        inf when it never does."""
        high = SMALL * state.reff
        while self.energy(state, high) < energy:
            high *= 2.0
            if high > 1e6 * state.reff:
                return inf
        low = 0.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.energy(state, middle) >= energy else (middle, high)
        return high


@cache
def _form(names: tuple[tuple[str, Any], ...], *, compiled: bool) -> tuple[Callable[..., Any], Callable[..., Any], int]:
    """Of a law without its coefficients: the chained law and its energy as the loop has them, and how many values it stores."""
    law = ContactLaw(**dict(names), coefficients={})
    ready: Callable[[Callable[..., Any]], Callable[..., Any]] = njit(error_model="numpy") if compiled else lambda function: function
    space: dict[str, Any] = {"compiled": ready, "inlined": ready, "sqrt": sqrt, **{name: ready(f) for name, f in law_functions("law", law).items()}}
    exec(compile(contact_source("law", law), "<contact law>", "exec"), space)  # noqa: S102  (our own text)
    return space["law_contact"], space["law_stored"], len(memory_signs(law))


@register_jitable
def _ask(contact: Any, state: Any, overlap: float, vn: float, speed: float, dt: float, coefficients: Any, memory: Any) -> Any:
    """The law at another overlap, approach speed and speed of all other motions, from rest. The normal is x, the motions are along y."""
    memory[:] = 0.0
    radius, partner = state[2], state[3]
    ratio = (radius - 0.5 * overlap) / (radius - overlap) if partner == np.inf and radius != overlap else 1.0
    return contact(
        memory, 0, overlap, radius, 1.0 / partner, state[4], state[5], state[6], ratio, vn, 1.0, 0.0, 0.0, 0.0, speed, 0.0, speed, speed, 0.0,
        dt, True, 1.0, coefficients, int(state[0]),
    )  # fmt: skip


@register_jitable
def _linear(still: float, moved: float, less: float, size: float, dt: float) -> tuple[float, float]:
    """(stiffness, damping) of a motion: what opposed it at one speed for no time, for a step, and at half the speed for a step.

    A bound turns a motion into a constant, whatever its size: then there is no linear answer."""
    if abs(moved - 2.0 * less) > 1e-6 * abs(moved):
        return 0.0, 0.0
    return (still - moved) / size, 0.0 - still * dt / size


def _fill(contact: Any, states: Any, coefficients: Any, dt: float, columns: int, spring: bool, damper: bool, out: Any) -> None:
    """Rows of out: force; stiffness of the four motions; damping of the four. Python, or compiled when there are many. spring, damper: whether the
    normal law has them at a state."""
    memory = np.zeros((1, columns))
    for k in range(len(states)):
        state = states[k]
        overlap, size = state[1], TINY * abs(state[1])
        force = _ask(contact, state, overlap, 0.0, 0.0, dt, coefficients, memory)[0]
        out[k, 0] = force
        if spring:
            h = SMALL * abs(overlap)
            more = _ask(contact, state, overlap + h, 0.0, 0.0, dt, coefficients, memory)[0]
            less = _ask(contact, state, overlap - h, 0.0, 0.0, dt, coefficients, memory)[0]
            out[k, 1] = (more - less) / (2.0 * h)
        if damper:
            slow = max(1e-4 * sqrt(abs(force * overlap) / state[5]), TINY)  # no law here damps more at a higher speed
            out[k, 5] = _ask(contact, state, overlap, -slow, 0.0, dt, coefficients, memory)[1] / slow
        still = _ask(contact, state, overlap, 0.0, size / dt, 0.0, coefficients, memory)
        moved = _ask(contact, state, overlap, 0.0, size / dt, dt, coefficients, memory)
        half = _ask(contact, state, overlap, 0.0, 0.5 * size / dt, dt, coefficients, memory)
        out[k, 2], out[k, 6] = _linear(still[3], moved[3], half[3], size, dt)
        out[k, 3], out[k, 7] = _linear(still[6], moved[6], half[6], size, dt)
        out[k, 4], out[k, 8] = _linear(still[5], moved[5], half[5], size, dt)

"""The reconstruction of the model of Fujioka & Ushijima (2005): what the words of their next paper ask of it."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from demsolver import EulerSphere, NveSphere
from tests.solver.contact.fujioka import STEPS, collide, head_on, law_of, on_walls

NAME = "fujioka2005"
EXACT = 1e-12  # a few hundred roundings
stiffnesses = st.floats(-3.0, 2.0).map(lambda power: 10.0**power)


@settings(max_examples=300, deadline=None)
@given(a=stiffnesses, e=st.floats(0.05, 1.0), phase=st.floats(1e-6, 1.0))
def test_restitution_is_exact_in_its_range(a: float, e: float, phase: float) -> None:
    """Law: restitution is e where s >= 1/e or e^2 s^2 >= a/(1 + a), s = 1/phase; elsewhere sqrt(a/(1 + a)) phase, the least it can leave."""
    least = sqrt(a / (1.0 + a)) * phase
    assert collide(NAME, a, e, phase).restitution == pytest.approx(max(e, least), rel=EXACT)


@settings(max_examples=200, deadline=None)
@given(a=stiffnesses, e=st.floats(0.05, 1.0), phase=st.floats(1e-6, 1.0))
def test_below_the_line_it_is_over_in_one_step(a: float, e: float, phase: float) -> None:
    """Law: a contact that begins at s >= 1/e lasts one step, any other more."""
    assume(abs(phase - e) > 1e-9)  # on the line rounding decides
    assert (collide(NAME, a, e, phase).steps == 1) == (phase < e)


@settings(max_examples=100, deadline=None)
@given(a=stiffnesses, e=st.floats(0.05, 1.0), phase=st.floats(1e-6, 1.0))
def test_the_overlap_is_kept(a: float, e: float, phase: float) -> None:
    """Law: unlike the model of 2006 it discards no position."""
    assert law_of(NAME).step(phase, -1.0, 1.0, 1.0, a, e)[1] == 0.0


def test_it_takes_fewer_steps_than_the_model_of_2006() -> None:
    """Law: at e = 0.7 and a = (pi/10)^2 most contacts take one step, and the mean is less than that of the model of 2006 (table 2: 1 or 2, and 3)."""
    a, phases = (np.pi / 10) ** 2, np.linspace(1e-3, 1.0, 500)
    older, newer = ([collide(name, a, 0.7, float(phase)).steps for phase in phases] for name in (NAME, "fujioka2006"))
    assert np.median(older) == 1
    assert np.mean(older) < np.mean(newer) - 1.0


rng = np.random.default_rng(6)
A, E, PHASE = 10.0 ** rng.uniform(-3.0, 2.0, 80), rng.uniform(0.05, 1.0, 80), rng.uniform(1e-3, 1.0, 80)
WANTED = np.maximum(E, np.sqrt(A / (1.0 + A)) * PHASE)


def test_restitution_of_spheres_on_a_wall() -> None:
    """Law: through Simulation a sphere leaves a wall as the law alone says."""
    simulation = on_walls(NAME, A, E, PHASE, EulerSphere())
    before = -simulation.bodies.v[:, 2]
    simulation.setup()
    simulation.advance(STEPS)
    assert simulation.bodies.v[:, 2] / before == pytest.approx(WANTED, rel=EXACT)


def test_restitution_of_unequal_pairs() -> None:
    """Law: so do two unequal spheres, under velocity Verlet."""
    simulation = head_on(NAME, A, E, PHASE, NveSphere())
    before = simulation.bodies.v[::2, 0]
    simulation.setup()
    simulation.advance(STEPS)
    b = simulation.bodies
    assert (b.v[1::2, 0] - b.v[::2, 0]) / before == pytest.approx(WANTED, rel=EXACT)

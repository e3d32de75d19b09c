"""Normal laws that only push: force is the slope of energy, pushes, grows, and vanishes at touch."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from math import pi, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver import contact

NAMES = ("hertz", "hooke", "impact_hooke")
SCALES = {"overlap": (1e-6, 1e-3), "reff": (1e-3, 1e-1), "meff": (1e-6, 1.0), "characteristic_velocity": (1e-2, 10.0)}
STENCIL = ((1, 4.0 / 5.0), (2, -1.0 / 5.0), (3, 4.0 / 105.0), (4, -1.0 / 280.0))  # central difference of order 8


def numbers(name: str) -> st.SearchStrategy[dict[str, float]]:
    """Positive values for all parameters of a law but contact_radius, which follows from the others."""
    names = {"overlap", "reff", *contact.parameters("normal", name)} - {"contact_radius"}
    return st.fixed_dictionaries({n: st.floats(*SCALES.get(n, (1e3, 1e9))) for n in sorted(names)})


def evaluate(function: Callable[..., float], values: dict[str, float], overlap: float) -> float:
    """The law's function at another overlap."""
    known = values | {"overlap": overlap, "contact_radius": sqrt(values["reff"] * overlap)}
    return function(*(known[name] for name in inspect.signature(function).parameters))


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=50, deadline=None)
@given(data=st.data())
def test_force_is_the_slope_of_energy(name: str, data: st.DataObject) -> None:
    """F = dE/d(overlap), by a difference of order 8."""
    law, values = contact.law("normal", name), data.draw(numbers(name))
    at, h = values["overlap"], 0.02 * values["overlap"]
    slope = sum(w * (evaluate(law.energy, values, at + k * h) - evaluate(law.energy, values, at - k * h)) for k, w in STENCIL) / h
    assert slope == pytest.approx(evaluate(law.force, values, at), rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=50, deadline=None)
@given(data=st.data())
def test_force_pushes_and_grows(name: str, data: st.DataObject) -> None:
    """The elastic force is positive, grows with overlap, and vanishes with it, as does the energy."""
    law, values = contact.law("normal", name), data.draw(numbers(name))
    at = values["overlap"]
    force = evaluate(law.force, values, at)
    assert 0.0 < force < evaluate(law.force, values, 1.01 * at)
    assert evaluate(law.force, values, 1e-200) < 1e-90 * force
    assert evaluate(law.energy, values, 0.0) == 0.0


def test_hertz_force_of_steel_balls() -> None:
    """F = 4/3 E* sqrt(R*) overlap^(3/2): R* 1 cm, E* 115 GPa, overlap 1 um give 4/3 1.15e11 0.1 1e-9 N = 15.33 N."""
    overlap, reff = 1e-6, 1e-2
    force = contact.law("normal", "hertz").force(overlap, sqrt(reff * overlap), 4.0 / 3.0 * 1.15e11)
    assert force == pytest.approx(4.0 / 3.0 * 11.5, rel=1e-14)


@given(
    reff=st.floats(1e-3, 1e-1),
    meff=st.floats(1e-6, 1.0),
    yeff=st.floats(1e5, 1e11),
    speed=st.floats(1e-2, 10.0),
)
def test_impact_hooke_equals_a_hertz_impact(reff: float, meff: float, yeff: float, speed: float) -> None:
    """At the overlap where a Hertz contact has taken the energy m V^2/2 of an impact at V, the linear spring has too."""
    deepest = (15.0 * meff * speed**2 / (16.0 * sqrt(reff) * yeff)) ** 0.4  # from 8/15 sqrt(R*) E* d^(5/2) = m V^2/2
    energy = contact.law("normal", "impact_hooke").energy(deepest, reff, meff, yeff, speed)
    hertz = contact.law("normal", "hertz").energy(deepest, sqrt(reff * deepest), 4.0 / 3.0 * yeff)
    assert hertz == pytest.approx(0.5 * meff * speed**2, rel=1e-12)
    assert energy == pytest.approx(hertz, rel=1e-12)


def test_hooke_period() -> None:
    """A linear spring holds 1/2 k d^2: the half period pi sqrt(m/k) follows from k = 2 E/d^2."""
    energy = contact.law("normal", "hooke").energy(1e-3, 1e4)
    assert pi * sqrt(1e-3 / (2.0 * energy / 1e-6)) == pytest.approx(pi * sqrt(1e-3 / 1e4), rel=1e-15)

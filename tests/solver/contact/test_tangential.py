"""Tangential stiffness and damping laws against their formulas."""

from __future__ import annotations

from math import log, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import contact

POSITIVE = st.floats(1e-6, 1e6)


@given(POSITIVE, st.floats(1e-6, 1e-2))
def test_mindlin_grows_with_the_contact_radius(shear_stiffness: float, radius: float) -> None:
    """kt = 8 G* a is linear in the contact radius; the constant stiffness is not."""
    mindlin = contact.law("tangential_stiffness", "mindlin").stiffness
    assert mindlin(2.0 * radius, shear_stiffness) == pytest.approx(2.0 * mindlin(radius, shear_stiffness))
    assert contact.law("tangential_stiffness", "constant").stiffness(shear_stiffness) == shear_stiffness


@given(POSITIVE, st.floats(0.0, 2.0))
def test_ratio(normal: float, ratio: float) -> None:
    """kt is the given multiple of the normal secant stiffness."""
    assert contact.law("tangential_stiffness", "ratio").stiffness(normal, ratio) == ratio * normal


def test_no_spring_no_damping() -> None:
    """The laws called none are zero."""
    assert contact.law("tangential_stiffness", "none").stiffness() == 0.0
    assert contact.law("tangential_damping", "none").coefficient() == 0.0


@given(POSITIVE, POSITIVE, st.floats(1e-6, 1e-2), POSITIVE)
def test_damping_factors(meff: float, gammat: float, radius: float, gn: float) -> None:
    """gammat times 1, the mass, mass and contact radius; or a multiple of gn."""
    assert contact.law("tangential_damping", "absolute").coefficient(gammat) == gammat
    assert contact.law("tangential_damping", "mass").coefficient(meff, gammat) == gammat * meff
    assert contact.law("tangential_damping", "mass_radius").coefficient(meff, radius, gammat) == pytest.approx(
        gammat * meff * radius
    )
    assert contact.law("tangential_damping", "scaled").coefficient(gn, 0.5) == 0.5 * gn


def test_fraction_against_measured_values() -> None:
    """LIGGGHTS hertz, radii 5 and 7 mm, densities 2500 and 1800, e = 0.7: at kn 2755.7684647 and kt 3467.6765468 N/m it was
    measured to damp with gn 0.39037545558 and gt 0.35754836797 kg/s. Fractions sqrt(5) b and 2 sqrt(5/6) b,
    b = -ln e/sqrt(ln^2 e + pi^2)."""
    masses = [4.0 / 3.0 * pi * 2500.0 * 0.005**3, 4.0 / 3.0 * pi * 1800.0 * 0.007**3]
    meff = masses[0] * masses[1] / sum(masses)
    loss = -log(0.7) / sqrt(log(0.7) ** 2 + pi**2)
    gn = contact.law("damping", "fraction").coefficient(meff, 2755.7684647, sqrt(5.0) * loss)
    gt = contact.law("tangential_damping", "fraction").coefficient(meff, 3467.6765468, 2.0 * sqrt(5.0 / 6.0) * loss)
    assert gn == pytest.approx(0.39037545558, rel=1e-10)
    assert gt == pytest.approx(0.35754836797, rel=1e-8)

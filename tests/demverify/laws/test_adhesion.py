"""Closed forms of sticky contacts, on curves drawn point by point."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from demverify.frames import Frame
from demverify.laws import adhesive_contact, sjkr_contact
from tests.support.impact_frames import frame, ratios
from tests.support.law_frames import off

YOUNG, NU, ENERGY = 1e8, 0.3, 1.0
E = YOUNG / (2.0 * (1.0 - NU**2))
RADIUS = (0.005, 0.015)
R = 0.00375


def drawn(points: list[tuple[float, float]], radius: tuple[float, ...] = RADIUS) -> list[Frame]:
    """Frames of (overlap, force)."""
    if len(radius) == 1:
        return [frame(k, [radius[0] - d], [0.0], [f], radius, [1.0]) for k, (d, f) in enumerate(points)]
    return [frame(k, [sum(radius) - d, 0.0], [0.0, 0.0], [f, -f], radius, [1.0, 1.0]) for k, (d, f) in enumerate(points)]


def test_jkr() -> None:
    """Law: the curve of JKR, drawn by its radius of contact from touch to beyond; nothing behind the greatest pull. Half the energy shows."""
    touch = (4.0 * pi * ENERGY * R**2 / E) ** (1.0 / 3.0)
    edge = (9.0 * pi * ENERGY * R**2 / (4.0 * E)) ** (1.0 / 3.0)
    radii = [touch, 2.0 * touch, 1.2 * touch, 0.95 * touch, 1.0001 * edge]
    curve = [
        (a**2 / R - 2.0 * sqrt(pi * ENERGY * a / E), 4.0 * E * a**3 / (3.0 * R) - 2.0 * pi * a**2 * sqrt(4.0 * ENERGY * E / (pi * a))) for a in radii
    ]
    assert curve[0][1] == pytest.approx(-8.0 / 3.0 * pi * ENERGY * R)
    assert curve[-1][1] == pytest.approx(-3.0 * pi * ENERGY * R, rel=1e-6)
    curve[0] = (0.0, curve[0][1])
    curve.append((-1.001 * edge**2 / (3.0 * R), 0.0))
    assert max(off(adhesive_contact.measure(drawn(curve), "jkr", YOUNG, NU, ENERGY)).values()) < 1e-9
    assert ratios(adhesive_contact.measure(drawn(curve), "jkr", YOUNG, NU, 0.5 * ENERGY))["force at touch"] == pytest.approx(2.0)
    held = [*curve, (curve[-1][0], curve[-2][1])]
    assert off(adhesive_contact.measure(drawn(held), "jkr", YOUNG, NU, ENERGY))["force over overlap"] == pytest.approx(1.0, rel=1e-5)


def test_dmt() -> None:
    """Law: Hertz less 4 pi g R*, ending at touch; that of JKR is two thirds of it."""
    pull = 4.0 * pi * ENERGY * R
    curve = [(1e-15, -pull), (1e-5, 4.0 / 3.0 * E * sqrt(R) * 1e-5**1.5 - pull), (-1e-9, 0.0)]
    assert max(off(adhesive_contact.measure(drawn(curve), "dmt", YOUNG, NU, ENERGY)).values()) < 1e-9
    assert ratios(adhesive_contact.measure(drawn(curve), "jkr", YOUNG, NU, ENERGY))["force at touch"] == pytest.approx(1.5)


@pytest.mark.parametrize("radius", [RADIUS, (0.005,)])
def test_sjkr(radius: tuple[float, ...]) -> None:
    """Law: the area is that of the circle in which the two spheres, or sphere and plane, cut each other. Twice the energy density shows."""
    reduced = float(1.0 / (1.0 / np.array(radius)).sum())
    curve = [(-1e-5, 0.0)]
    for overlap in (1e-6, 1e-5, 1e-4):
        r = sum(radius) - overlap
        reach = (r**2 + radius[0] ** 2 - radius[1] ** 2) / (2.0 * r) if len(radius) == 2 else r  # from the first centre to the plane of the circle
        curve.append((overlap, 4.0 / 3.0 * E * sqrt(reduced) * overlap**1.5 - 1e6 * pi * (radius[0] ** 2 - reach**2)))
    assert curve[1][1] < 0.0 < curve[3][1]
    assert max(off(sjkr_contact.measure(drawn(curve, radius), YOUNG, NU, 1e6)).values()) < 1e-9
    assert off(sjkr_contact.measure(drawn(curve, radius), YOUNG, NU, 2e6))["force over overlap"] > 0.1

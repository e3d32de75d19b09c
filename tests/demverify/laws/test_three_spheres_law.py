"""Law of the sphere that slides down between two others, against an integration of the rigid motion."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from demverify.frames import Frame
from demverify.laws import three_spheres

RADIUS, G = 0.02, 9.80665


def _frame(step: int, vx: tuple[float, float, float]) -> Frame:
    columns = {"vx": np.array(vx), "mass": np.full(3, 0.1), "radius": np.full(3, RADIUS)}
    return Frame(step, np.zeros((3, 2)), ("f", "f", "f"), columns)


def _rigid_speed() -> float:
    """The greatest speed that energy and the constraint give a lower sphere on the way down: there the force between ends."""
    k = np.linspace(1e-6, sqrt(3.0) / 2.0, 2_000_001)
    fall = 2.0 * RADIUS * (sqrt(3.0) / 2.0 - k)
    return float(np.sqrt(G * fall / (1.0 + (1.0 - k * k) / (2.0 * k * k))).max())


def test_three_spheres() -> None:
    """Law: the lower spheres part with the greatest speed of the rigid motion; 3 % more shows as 3 %, a lopsided push too."""
    speed = _rigid_speed()
    right = three_spheres.measure([_frame(0, (0.0, 0.0, 0.0)), _frame(9, (-speed, speed, 0.0))], G)
    assert [one.measured for one in right] == pytest.approx([one.expected for one in right], rel=1e-9, abs=1e-12)
    wrong = three_spheres.measure([_frame(0, (0.0, 0.0, 0.0)), _frame(9, (-1.03 * speed, speed, 0.0))], G)
    assert wrong[0].measured / wrong[0].expected == pytest.approx(1.03)
    assert abs(wrong[3].measured) > 0.009 * float(wrong[3].scale or 0.0)

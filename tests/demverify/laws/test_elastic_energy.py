"""Energy of undamped scenes."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.elastic_energy import measure
from tests.support.law_frames import frame, off


def swing(normal: str, extra: float = 0.0):
    """Two unit masses pressed together by d, with the kinetic energy that is left of 1."""
    frames = []
    for k, d in enumerate((0.0, 0.02, 0.05, 0.0)):
        stored = 400.0 * (0.5 * d * d if normal == "hooke" else 0.4 * np.sqrt(0.25) * d**2.5)
        v = np.sqrt(1.0 - stored + extra * k)
        frames.append(frame(k, [[0, 0, 0], [1.0 - d, 0, 0]], [[v, 0, 0], [-v, 0, 0]]))
    return frames


@pytest.mark.parametrize("normal", ["hooke", "hertz"])
def test_springs_take_and_give(normal):
    """Law: E = sum m v^2/2 + k d^2/2, or (2/5) k sqrt(R*) d^(5/2)."""
    assert max(off(measure(swing(normal), normal, 400.0, 0.0, 0.0, 0.0, 1.0)).values()) < 1e-14


def test_energy_out_of_nothing_is_seen():
    """Law: 3 % more at the end are 3 % more."""
    assert off(measure(swing("hooke", 0.01), "hooke", 400.0, 0.0, 0.0, 0.0, 1.0))["energy at the end"] == pytest.approx(0.03)


def test_gravity_counts():
    """Law: what a falling sphere gains it has lost in height."""
    frames = [frame(k, [0, 0, -2.5 * t * t], [1.0, 0, -5.0 * t]) for k, t in enumerate((0.0, 0.3, 0.7))]
    assert max(off(measure(frames, "hooke", 1.0, 5.0, 0.0, 0.0, -1.0)).values()) < 1e-14

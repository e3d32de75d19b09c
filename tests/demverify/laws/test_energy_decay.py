"""Energy of damped scenes."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.energy_decay import measure
from tests.support.law_frames import frame, off


def fading(values):
    return [frame(k, [0, 0, 0], [np.sqrt(2.0 * e), 0, 0]) for k, e in enumerate(values)]


def test_energy_may_fall():
    """Law: dE/dt <= 0."""
    found = off(measure(fading([1.0, 0.9, 0.5, 0.5]), "hooke", 1.0, 0.4))
    assert found == pytest.approx({"growth of the energy": 0.0, "energy lost": 0.0}, abs=1e-15)


def test_energy_may_not_grow():
    """Law: a rise of 5 % in between is 5 % too much."""
    assert off(measure(fading([1.0, 0.6, 0.65, 0.5]), "hooke", 1.0, 0.4))["growth of the energy"] == pytest.approx(0.05)


def test_damping_that_is_not_there_is_seen():
    """Law: at least the share that is asked for must be gone."""
    assert off(measure(fading([1.0, 0.9]), "hooke", 1.0, 0.4))["energy lost"] == pytest.approx(0.75)

"""Spring and dashpot, head on."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.laws.spring_dashpot_collision import measure
from tests.support.law_frames import frame, off

K, C, V, DT = 1e4, 20.0, 0.5, 1e-3


def impact(mass2: float = 3.0, reduced: float = 0.75, c: float = C, sticky: float = 1.0):
    """Exact motion of the overlap; the first sphere (1 kg) has all of it, its partner of `mass2` stands still."""
    b = 0.5 * c
    w = np.sqrt(K / reduced - b * b)
    end = np.pi / w
    frames = []
    for k in range(120):
        s = k * DT - 0.02
        d, rate = V * s, V
        if s > end:
            d, rate = -V * np.exp(-b * end) * (s - end) * sticky, -V * np.exp(-b * end) * sticky
        elif s > 0.0:
            d = V / w * np.exp(-b * s) * np.sin(w * s)
            rate = V * np.exp(-b * s) * (np.cos(w * s) - b / w * np.sin(w * s))
        frames.append(frame(k, [[d - 1.0, 0, 0], [0, 0, 0]], [[rate, 0, 0], [0, 0, 0]], mass=[1.0, mass2]))
    return frames


@pytest.mark.parametrize(("partner", "reduced", "share"), [("free", 0.75, 1.0), ("frozen", 1.0, 1.0), ("held", 1.0, 0.75)])
def test_overlap_over_time(partner, reduced, share):
    """Law: d = (v/w) exp(-b s) sin(w s); the mass is that of the partner's kind, and so is the dashpot."""
    assert max(off(measure(impact(reduced=reduced, c=share * C), DT, K, C, partner)).values()) < 1e-12


def test_another_restitution_is_seen():
    """Law: 2 % less speed afterwards are 2 % less restitution."""
    assert off(measure(impact(sticky=0.98), DT, K, C, "free"))["restitution"] == pytest.approx(0.02)

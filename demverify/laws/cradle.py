"""Newton's cradle: hard, equal, elastic spheres on a line swap their velocities at every impact, so that in the end they stand sorted, the
fastest in front (Maupertuis; Herrmann & Seitz 1982, doi:10.1119/1.12936). Soft spheres do so as long as no sphere is in two contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import velocities


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Velocities along x at the end, ids in the order of the row, against those of the start, sorted; relative to the largest."""
    before, after = velocities(frames[0])[:, 0], velocities(frames[-1])[:, 0]
    size = float(np.abs(before).max())
    return [Measured("velocities passed on", frames[-1].step, float(np.abs(after - np.sort(before)).max()), 0.0, size)]

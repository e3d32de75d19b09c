"""A deck goes on, goes back to a file it wrote in mid-contact (`write_restart`, `clear`, `read_restart`), and goes on again: the same state under
the same forces moves alike (uniqueness of solutions, e.g. Arnold, Ordinary Differential Equations, par. 7), so the second time is the first.

The state of a granular contact is more than positions and velocities: springs along the surface, of rolling and of twisting have lengths of
their own, and a file without them gives another motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, spins, velocities


def measure(frames: Sequence[Frame]) -> list[Measured]:
    """Frames after the return against those of the same step before it: largest difference. Positions relative to the largest radius,
    velocities and spins to their largest. The last way back counts where there are several.

    Raises LookupError where the steps never go back, or no frame has a partner."""
    turn = max((k for k in range(1, len(frames)) if frames[k].step < frames[k - 1].step), default=0)
    if not turn:
        message = "the steps never go back: no read_restart of an earlier step, or one frame only after it"
        raise LookupError(message)
    first = {frame.step: frame for frame in frames[:turn]}
    pairs = [(first[frame.step], frame) for frame in frames[turn:] if frame.step in first]
    if not pairs:
        message = "no step comes twice"
        raise LookupError(message)
    found = []
    for name, values in (("position", positions), ("velocity", velocities), ("spin", spins)):
        off = [float(np.abs(values(again) - values(before)).max()) for before, again in pairs]
        largest = max(float(np.abs(values(before)).max()) for before, _ in pairs)
        size = float(frames[0].columns["radius"].max()) if name == "position" else largest
        if size > 0.0:
            found.append(largest_miss(f"{name} the second time", [again for _, again in pairs], off, size))
    return found

"""A sphere on a plane, normal impact: v' = -e v along the plane's normal, nothing else moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], restitution: float, axis: Literal["x", "y", "z"]) -> list[Measured]:
    """Rebound over impact speed of the first particle along `axis` (x, y, z)."""
    first, last = frames[0], frames[-1]
    before, after = (float(frame.columns[f"v{axis}"][0]) for frame in (first, last))
    return [Measured("restitution", last.step, -after / before, restitution)]

"""Frames made by hand for the closed forms: spheres on a line, or one above the plane z = 0."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured

Curve = Callable[[float], tuple[float, float, float]]
"""Time since touch -> overlap, its rate, force; while the contact lasts."""


def frame(step: int, z: Sequence[float], vz: Sequence[float], fz: Sequence[float], radius: Sequence[float], mass: Sequence[float]) -> Frame:
    """Spheres on the z axis."""
    names = ("x", "y", "vx", "vy", "fx", "fy", "omegax", "omegay", "omegaz")
    columns = {name: np.zeros(len(z)) for name in names} | {"id": np.arange(1.0, len(z) + 1)}
    columns |= {n: np.array(v, dtype=float) for n, v in (("z", z), ("vz", vz), ("fz", fz), ("radius", radius), ("mass", mass))}
    return Frame(step, np.array([[-1.0, 1.0]] * 3), ("ff", "ff", "ff"), columns)


def impact(curve: Curve, duration: float, radius: Sequence[float], mass: Sequence[float], steps: int = 400) -> tuple[list[Frame], float]:
    """Frames of an impact, one a step, and the time step: free flight, the contact, free flight. One sphere: onto the plane z = 0."""
    timestep, lead = duration / (steps - 0.5), 10.25  # steps of flight before touch
    speed, leaving = curve(0.0)[1], curve(duration)[1]
    frames = []
    for step in range(steps + 30):
        time = (step - lead) * timestep
        if time < 0.0:
            seen = (speed * time, speed, 0.0)
        elif time <= duration:
            seen = curve(time)
        else:
            seen = (leaving * (time - duration), leaving, 0.0)
        overlap, rate, force = seen
        if len(radius) == 1:
            frames.append(frame(step, [radius[0] - overlap], [-rate], [force], radius, mass))
        else:
            frames.append(frame(step, [sum(radius) - overlap, 0.0], [-rate, 0.0], [force, -force], radius, mass))
    return frames, timestep


def ratios(found: Sequence[Measured]) -> dict[str, float]:
    """Quantity -> measured over expected."""
    return {one.quantity: one.measured / one.expected for one in found if one.expected}

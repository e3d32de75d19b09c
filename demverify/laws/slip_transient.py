"""A ball thrown along a plane without spin, while it slips: u = u0 - mu g t, omega = 5/2 mu g t/R, until t = 2 u0/(7 mu g).

(MFIX-DEM V&V, DEM-04.) Exact but for the winding of the tangential spring at first, mu m g/(kt u0) of time.
"""

from __future__ import annotations

from collections.abc import Sequence

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.laws.oblique_mindlin import state


def measure(frames: Sequence[Frame], friction: float, gravity: float, timestep: float) -> list[Measured]:
    """Speed and spin in the middle of the slip and near its end, and the time at which the line through both ends, of the first
    particle: plane z = const, speed along x. timestep: of the run."""
    first = frames[0]
    u0, radius, slowing = float(first.columns["vx"][0]), state(first)[0], friction * gravity
    until = 2.0 * u0 / (7.0 * slowing)
    found = []
    for part in (0.5, 0.95):
        frame = min(frames, key=lambda one: abs((one.step - first.step) * timestep - part * until))
        t = (frame.step - first.step) * timestep
        found.append(Measured(f"speed at {part} of the slip", frame.step, float(frame.columns["vx"][0]), u0 - slowing * t))
        found.append(Measured(f"spin at {part} of the slip", frame.step, float(frame.columns["omegay"][0]), 2.5 * slowing * t / radius))
    early, late = (min(frames, key=lambda one: abs((one.step - first.step) * timestep - part * until)) for part in (0.5, 0.95))
    fall = (state(early)[3] - state(late)[3]) / (late.step - early.step)
    ends = (late.step - first.step + state(late)[3] / fall) * timestep
    return [*found, Measured("end of the slip", late.step, ends, until)]

"""A ball that lies on a plane and spins is slowed by a constant torque: omega = omega0 - 5/2 mu_r g t/R, until it stands.

Rolling resistance M = mu_r R N about an axis along the plane (Y. C. Zhou et al., Physica A 269 (1999) 536, model A), with
2/5 m R^2 omega' = -M, N = m g. Twisting resistance about the normal does the same with mu_r R its length; with Marshall's,
M = 2/3 mu a N, a = sqrt(R d), it is mu_r = 2/3 mu a/R (J. S. Marshall, J. Comput. Phys. 228 (2009) 1541, eq. 34).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from demverify.frames import Frame
from demverify.laws import Measured


def measure(
    frames: Sequence[Frame], axis: Literal["x", "y", "z"], torque: float, gravity: float, timestep: float
) -> list[Measured]:
    """Spin of the first particle about `axis` at half and at 0.9 of the time it takes to stop, or of the run if that is shorter, and of
    the run's end where it stands then. torque: M/(N R), mu_r."""
    first, last = frames[0], frames[-1]
    column = f"omega{axis}"
    w0, radius = float(first.columns[column][0]), float(first.columns["radius"][0])
    rate = 2.5 * torque * gravity / radius
    stops = abs(w0) / rate
    end = (last.step - first.step) * timestep
    found = []
    for part in (0.5, 0.9):
        frame = min(frames, key=lambda one: abs((one.step - first.step) * timestep - part * min(stops, end)))
        left = abs(w0) - rate * (frame.step - first.step) * timestep
        found.append(Measured(f"spin at {part}", frame.step, float(frame.columns[column][0]), left * (1.0 if w0 > 0 else -1.0), abs(w0)))
    if end > 1.05 * stops:
        found.append(Measured("spin at rest", last.step, float(last.columns[column][0]), 0.0, abs(w0)))
    return found

"""A ball that lies on a plane on a linear spring and spins about the normal, slowed by Marshall's twisting resistance in slip.

M = 2/3 mu a N, a = sqrt(R d), d = N/k, so omega = omega0 - 5/3 mu a g t/R^2 (J. S. Marshall, J. Comput. Phys. 228 (2009) 1541,
doi:10.1016/j.jcp.2008.10.020, eq. 34).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from demverify.frames import Frame
from demverify.laws import Measured, spin_decay


def measure(frames: Sequence[Frame], friction: float, stiffness: float, gravity: float, timestep: float) -> list[Measured]:
    """Spin about z of the first particle at half and at 0.9 of the time. stiffness: of the normal spring."""
    mass, radius = float(frames[0].columns["mass"][0]), float(frames[0].columns["radius"][0])
    contact_radius = sqrt(radius * mass * gravity / stiffness)
    return spin_decay.measure(frames, "z", 2.0 / 3.0 * friction * contact_radius / radius, gravity, timestep)

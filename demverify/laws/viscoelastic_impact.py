"""A straight impact on a Hertz spring with a dashpot that grows with the contact radius (viscoelastic spheres; Brilliantov et al. 1996,
doi:10.1103/PhysRevE.53.5382): the faster, the less they rebound.

    m* d'' = -a (k d + g m* d'),  a = sqrt(R* d),  until d = 0 again

LAMMPS gran/hertz/history and damping viscoelastic, LIGGGHTS hertz/stiffness. No closed form; the ordinary equation is integrated to 1e-10.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from demverify.frames import Floats, Frame
from demverify.impact import Impact, peak
from demverify.laws import Measured


def measure(frames: Sequence[Frame], stiffness: float, damping: float, timestep: float) -> list[Measured]:
    """Restitution, contact time and greatest overlap of two spheres, or of one and the plane z = 0.

    stiffness k [pressure], damping g [1/(time length)]."""
    from scipy.integrate import solve_ivp

    impact = Impact.of(frames)
    time, length = _scales(impact, stiffness)
    loss = damping * sqrt(impact.radius * length) * time

    def move(_: float, y: Floats) -> tuple[float, float]:
        root = sqrt(max(y[0], 0.0))
        return y[1], -root * (y[0] + loss * y[1])

    def apart(t: float, y: Floats) -> float:
        return float(y[0]) if t > 0.0 else 1.0

    def turn(_: float, y: Floats) -> float:
        return float(y[1])

    apart.terminal, apart.direction = True, -1  # type: ignore[attr-defined]
    start = (0.0, impact.speed * time / length)
    found = solve_ivp(move, (0.0, 100.0), start, events=(apart, turn), rtol=1e-10, atol=1e-14, method="DOP853", max_step=0.02)
    (end,), (last,), deepest = found.t_events[0], found.y_events[0], float(found.y_events[1][0][0])
    return [
        Measured("restitution", frames[-1].step, impact.restitution, float(-last[1] / start[1])),
        Measured("contact time", frames[-1].step, impact.duration(timestep), float(end) * time),
        Measured("peak overlap", frames[impact.deepest].step, peak(impact.overlap), deepest * length),
    ]


def _scales(impact: Impact, stiffness: float) -> tuple[float, float]:
    """Time and length that make the equation of the elastic impact d'' = -d^(3/2) with d' = 1 at the start."""
    rate = stiffness * np.sqrt(impact.radius) / impact.mass
    length = float((impact.speed**2 / rate) ** 0.4)
    return length / impact.speed, length

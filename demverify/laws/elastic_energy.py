"""Without damping and friction, kinetic energy + springs + gravity stay: E = sum m v^2/2 + I w^2/2 + U(d) - M g.R, with U = k d^2/2 of a
linear spring, U = (2/5) k sqrt(R*) d^(5/2) of Hertz (force k sqrt(R*) d^(3/2)). Velocity Verlet wanders by (w dt)^2/8 of what a contact
holds and comes back (Hairer, Lubich & Wanner, Geometric Numerical Integration, ch. I.4 and IX.8)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import center, kinetic_energy, spring_energy


def measure(
    frames: Sequence[Frame], normal: Literal["hooke", "hertz"], stiffness: float, gravity: float, x: float, y: float, z: float
) -> list[Measured]:
    """Largest change of the energy over all frames and the one left at the end, relative to the kinetic energy at the start.

    stiffness: k above. gravity along (x, y, z)."""
    along = np.array([x, y, z])
    g = gravity * along / np.linalg.norm(along)
    mass, power = float(frames[0].columns["mass"].sum()), 1.0 if normal == "hooke" else 1.5
    energies = [
        kinetic_energy(frame, 0.4) + spring_energy(frame, stiffness, power) - mass * float(g @ (center(frame)[0] - center(frames[0])[0]))
        for frame in frames
    ]
    off = [abs(energy - energies[0]) for energy in energies]
    at, size = int(np.argmax(off)), kinetic_energy(frames[0], 0.4)
    return [
        Measured("energy in between", frames[at].step, off[at], 0.0, size),
        Measured("energy at the end", frames[-1].step, energies[-1], energies[0], size),
    ]

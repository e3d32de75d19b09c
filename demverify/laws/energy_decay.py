"""Damping and friction only take: kinetic energy + normal springs never grow, dE/dt = -c (dd/dt)^2 - F_t v_t <= 0 (second law; Goldstein,
Classical Mechanics, eq. 1-67, Rayleigh's dissipation). With frictionless or springless friction everything stored is in E."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import kinetic_energy, spring_energy


def measure(frames: Sequence[Frame], normal: Literal["hooke", "hertz"], stiffness: float, least: float) -> list[Measured]:
    """Largest growth from frame to frame, relative to the energy at the start, and whether at least the share `least` of it is gone
    in the end. stiffness: force over overlap, or over sqrt(R*) overlap^1.5."""
    power = 1.0 if normal == "hooke" else 1.5
    energies = np.array([kinetic_energy(frame, 0.4) + spring_energy(frame, stiffness, power) for frame in frames])
    growth = np.maximum(np.diff(energies), 0.0)
    at = int(np.argmax(growth))
    lost = float(1.0 - energies[-1] / energies[0])
    return [
        Measured("growth of the energy", frames[at + 1].step, float(growth[at]), 0.0, float(energies[0])),
        Measured("energy lost", frames[-1].step, min(lost, least), least),
    ]

"""A sphere in a gas falls, in the end, so fast against it that drag and buoyancy carry its weight (Schiller & Naumann 1935; MFIX-DEM V&V, DEM-06):

g (rs - rg) d^2/(18 mu) = s (1 + 0.15 Re^0.687),   Re = rg d s/mu

The slip s is found as a root, to rounding. How the steps are made has no say in it: where nothing changes any more every scheme is exact.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.laws.schiller_naumann import EXPONENT, FACTOR
from demverify.mechanics import velocities


def measure(frames: Sequence[Frame], gravity: float, gas_density: float, viscosity: float, ux: float, uy: float, uz: float) -> list[Measured]:
    """Slip of every particle in the last frame, of the gas against it. gravity along -z; (ux, uy, uz): velocity of the gas."""
    last = frames[-1]
    slip = np.array([ux, uy, uz]) - velocities(last)
    found = []
    for k, (mass, radius) in enumerate(zip(last.columns["mass"], last.columns["radius"], strict=True)):
        density = mass / (4.0 / 3.0 * np.pi * radius**3)
        expected = terminal_slip(density, 2.0 * radius, gravity, gas_density, viscosity)
        found.append(Measured(f"slip of particle {k + 1}", last.step, float(slip[k, 2]), expected))
        found.append(Measured(f"slip of particle {k + 1} across", last.step, float(np.hypot(slip[k, 0], slip[k, 1])), 0.0, abs(expected)))
    return found


def terminal_slip(density: float, diameter: float, gravity: float, gas_density: float, viscosity: float) -> float:
    """Velocity of the gas against the sphere at which nothing changes any more; below zero for one that rises."""
    stokes = gravity * (density - gas_density) * diameter**2 / (18.0 * viscosity)
    reynolds = gas_density * diameter / viscosity
    if stokes == 0.0:
        return 0.0  # as dense as the gas: it stays

    def missing(s: float) -> float:
        return float(s * (1.0 + FACTOR * (reynolds * s) ** EXPONENT) - abs(stokes))

    root = brentq(missing, 0.0, abs(stokes), xtol=1e-16 * abs(stokes), rtol=1e-15)
    return float(np.copysign(root, stokes))

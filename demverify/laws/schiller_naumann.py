"""Spheres in a steady gas of velocity u under gravity, buoyancy and the drag of Schiller & Naumann (1935), as MFIX-DEM V&V DEM-06 has it:

dv/dt = -g (rs - rg)/rs + 3/4 rg/(rs d) Cd |u - v| (u - v),   Cd = 24/Re (1 + 0.15 Re^0.687),   Re = rg d |u - v|/mu

The path is that of scipy's DOP853, good to 1e-11; the spin stays. For Re to 0 the drag is that of Stokes, see laws/linear_drag. rs is the density
of the sphere as its mass and radius say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp

from demverify.frames import Floats, Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, spins, times, velocities

EXPONENT, FACTOR = 0.687, 0.15
Acceleration = Callable[[Floats], Floats]


def measure(
    frames: Sequence[Frame], dt: float, gravity: float, gas_density: float, viscosity: float, ux: float, uy: float, uz: float
) -> list[Measured]:
    """Every particle: largest misses over all frames, relative to the largest speed and the largest path. gravity along -z; (ux, uy, uz): velocity
    of the gas."""
    first, t = frames[0], times(frames, dt)
    rates = acceleration(first.columns["mass"], first.columns["radius"], gravity, gas_density, viscosity, np.array([ux, uy, uz]))
    place, speed = path(positions(first), velocities(first), t, rates)
    turning, way = spins(first), float(np.abs(place - place[0]).max())
    return [
        largest_miss("velocity", frames, [np.abs(velocities(f) - v).max() for f, v in zip(frames, speed, strict=True)], float(np.abs(speed).max())),
        largest_miss("path", frames, [np.abs(positions(f) - x).max() for f, x in zip(frames, place, strict=True)], way),
        largest_miss("spin", frames, [np.abs(spins(f) - turning).max() for f in frames], max(1.0, float(np.abs(turning).max()))),
    ]


def acceleration(mass: Floats, radius: Floats, gravity: float, gas_density: float, viscosity: float, gas: Floats) -> Acceleration:
    """dv/dt (n, 3) of spheres of mass and radius (n,) in a gas of velocity (3,), as a function of their velocities (n, 3)."""
    stokes = (6.0 * np.pi * viscosity * radius / mass)[:, None]
    reynolds = (2.0 * gas_density * radius / viscosity)[:, None]
    weight = gravity * (1.0 - gas_density * 4.0 / 3.0 * np.pi * radius**3 / mass)[:, None] * np.array([0.0, 0.0, -1.0])

    def of(v: Floats) -> Floats:
        slip = gas - v
        re = reynolds * np.linalg.norm(slip, axis=1, keepdims=True)
        return np.asarray(weight + stokes * (1.0 + FACTOR * re**EXPONENT) * slip)

    return of


def path(x: Floats, v: Floats, t: Floats, change_of: Acceleration) -> tuple[Floats, Floats]:
    """Positions and velocities (m, n, 3) at the times t (m,), from x, v (n, 3) at t[0]."""
    n, lasts = len(x), float(t[-1] - t[0])
    scale = max(float(np.abs(v).max()), lasts * float(np.abs(change_of(v)).max()))

    def change(_: float, state: Floats) -> Floats:
        speed = state.reshape(2, n, 3)[1]
        return np.concatenate([speed.ravel(), change_of(speed).ravel()])

    start = np.concatenate([np.zeros(3 * n), v.ravel()])
    found = solve_ivp(change, (t[0], t[-1]), start, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-14 * scale * min(1.0, lasts))
    way, speed = found.y.T.reshape(len(t), 2, n, 3).transpose(1, 0, 2, 3)
    return x + way, speed

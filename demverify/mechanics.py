"""Momenta, energies and paths of spheres, for closed forms, whatever engine wrote the frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured, largest_miss


def times(frames: Sequence[Frame], dt: float) -> Floats:
    """Time of each frame since the first."""
    return np.array([(frame.step - frames[0].step) * dt for frame in frames])


def positions(frame: Frame) -> Floats:
    """(n, 3)."""
    return frame.vectors("x", "y", "z")


def velocities(frame: Frame) -> Floats:
    """(n, 3)."""
    return frame.vectors("vx", "vy", "vz")


def spins(frame: Frame) -> Floats:
    """(n, 3)."""
    return frame.vectors("omegax", "omegay", "omegaz")


def largest_misses_of_paths(frames: Sequence[Frame], dt: float, expected: Callable[[float], tuple[Floats, Floats]]) -> list[Measured]:
    """Of all particles and frames, relative to the largest speed, path and spin. expected: time since the first frame -> velocities and
    displacements since then, (n, 3) each; the spins must stay as they are at first."""
    where, turning = positions(frames[0]), spins(frames[0])
    misses = []
    for frame, t in zip(frames, times(frames, dt), strict=True):
        velocity, path = expected(float(t))
        apart = velocities(frame) - velocity, positions(frame) - where - path, spins(frame) - turning
        misses.append([np.abs(off).max() for off in apart])
    scales = (
        max(float(np.abs(velocities(frame)).max()) for frame in frames),
        max(float(np.abs(positions(frame) - where).max()) for frame in frames),
        max(float(np.abs(turning).max()), 1.0),
    )
    columns = zip(("velocity", "path", "spin"), np.array(misses).T, scales, strict=True)
    return [largest_miss(name, frames, column, scale) for name, column, scale in columns]


def momentum(frame: Frame) -> Floats:
    """Sum of m v, (3,)."""
    return np.asarray(frame.columns["mass"] @ velocities(frame))


def center(frame: Frame) -> tuple[Floats, Floats]:
    """Position and velocity of the centre of mass."""
    mass = frame.columns["mass"]
    return np.asarray(mass @ positions(frame) / mass.sum()), np.asarray(momentum(frame) / mass.sum())


def angular_momentum(frame: Frame, inertia: float) -> tuple[Floats, Floats, Floats]:
    """Parts of the angular momentum about the origin, (3,) each: of the centre of mass M R x V; orbital about the centre, sum of m r' x v';
    spin, sum of I w with I = inertia m r^2, of superquadrics their own."""
    mass, radius = frame.columns["mass"], frame.columns["radius"]
    where, speed = center(frame)
    orbital = mass @ np.cross(positions(frame) - where, velocities(frame) - speed)
    each = (inertia * mass * radius**2)[:, None] * spins(frame)
    if "shapex" in frame.columns:
        each = np.where(frame.columns["shapex"][:, None] > 0.0, frame.vectors("angmomx", "angmomy", "angmomz"), each)
    spin = each.sum(axis=0)
    return np.asarray(mass.sum() * np.cross(where, speed)), np.asarray(orbital), np.asarray(spin)


def kinetic_energy(frame: Frame, inertia: float) -> float:
    """Of translation and rotation."""
    mass, radius = frame.columns["mass"], frame.columns["radius"]
    turning = inertia * mass * radius**2 * (spins(frame) ** 2).sum(axis=1)
    if "shapex" in frame.columns:
        own = (frame.vectors("angmomx", "angmomy", "angmomz") * spins(frame)).sum(axis=1)
        turning = np.where(frame.columns["shapex"] > 0.0, own, turning)
    return float(0.5 * (mass * (velocities(frame) ** 2).sum(axis=1) + turning).sum())


def spring_energy(frame: Frame, stiffness: float, power: float) -> float:
    """Elastic energy of all pairs that overlap: force stiffness d of a linear spring (power 1), stiffness sqrt(R*) d^1.5 of Hertz (1.5)."""
    x, radius, total = positions(frame), frame.columns["radius"], 0.0
    for i, j in combinations(range(frame.n), 2):
        overlap = radius[i] + radius[j] - float(np.linalg.norm(x[i] - x[j]))
        if overlap > 0.0:
            curvature = np.sqrt(radius[i] * radius[j] / (radius[i] + radius[j])) if power > 1.0 else 1.0
            total += stiffness * curvature * overlap ** (power + 1.0) / (power + 1.0)
    return total

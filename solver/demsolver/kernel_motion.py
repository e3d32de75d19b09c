"""Kicks, drifts and how far and fast particles are: a template like kernel.py, compiled once for all scenes with the same constants."""

# ruff: noqa: F821
from math import sqrt

import numpy as np


@shared
def kick(low, high, again, flat):
    """The acceleration of a step (Verlet: half a step) for the particles low..high; again: 1.0 for twice, else 0.0."""
    for e in range(np.uint64(3 * low), np.uint64(3 * high)):
        g = flat.kick[np.uint64(0) if UNIFORM else e] * flat.force[e]
        flat.v[e] = flat.v[e] + g + again * g
    if ROTATES:
        for e in range(np.uint64(3 * low), np.uint64(3 * high)):
            g = flat.spin[np.uint64(0) if UNIFORM else e] * flat.torque[e]
            flat.omega[e] = flat.omega[e] + g + again * g


@shared
def drift(low, high, flat, dt):
    """A step of motion."""
    for e in range(np.uint64(3 * low), np.uint64(3 * high)):
        flat.x[e] += dt * flat.v[e]
        if SHIFTING:
            flat.x[e] += flat.aside[e]


@shared
def clear(low, high, b):
    """No force yet at the new positions."""
    b.force[low:high] = 0.0
    if ROTATES:
        b.torque[low:high] = 0.0
    if SHIFTING or IMPLICIT:
        b.aside[low:high] = 0.0


@shared
def top_speed(movers, b):
    """Largest speed of those that move."""
    most = 0.0
    for i in range(movers):
        most = max(most, b.v[i, 0] ** 2 + b.v[i, 1] ** 2 + b.v[i, 2] ** 2)
    return sqrt(most)


@shared
def most_haste(movers, b, guard):
    """Largest speed over radius of those that move, as seen by guard[1:4]."""
    most = 0.0
    for i in range(movers):
        if b.radius[i] > 0.0:
            square = (b.v[i, 0] - guard[1]) ** 2 + (b.v[i, 1] - guard[2]) ** 2 + (b.v[i, 2] - guard[3]) ** 2
            most = max(most, square / b.radius[i] ** 2)
    return sqrt(most)


@shared
def farthest(b):
    """Largest squared way of a particle since the list was built."""
    most = 0.0
    for i in range(b.x.shape[0]):
        most = max(most, (b.x[i, 0] - b.held[i, 0]) ** 2 + (b.x[i, 1] - b.held[i, 1]) ** 2 + (b.x[i, 2] - b.held[i, 2]) ** 2)
    return most

"""Kicks, drifts and how far and fast particles are: a template like kernel.py, compiled once for all scenes with the same constants."""

# ruff: noqa: F821
from math import sqrt


@shared
def kick(low, high, again, b):
    """The acceleration of a step (Verlet: half a step) for the particles low..high; again: 1.0 for twice, else 0.0."""
    v, f = b.v[low:high].reshape(-1), b.force[low:high].reshape(-1)
    m = b.kick[0:1].reshape(-1) if UNIFORM else b.kick[low:high].reshape(-1)
    for e in range(v.size):
        g = (m[0] if UNIFORM else m[e]) * f[e]
        v[e] = v[e] + g + again * g
    if ROTATES:
        w, t = b.omega[low:high].reshape(-1), b.torque[low:high].reshape(-1)
        m = b.spin[0:1].reshape(-1) if UNIFORM else b.spin[low:high].reshape(-1)
        for e in range(w.size):
            g = (m[0] if UNIFORM else m[e]) * t[e]
            w[e] = w[e] + g + again * g


@shared
def drift(low, high, b, dt):
    """A step of motion."""
    x, v = b.x[low:high].reshape(-1), b.v[low:high].reshape(-1)
    for e in range(x.size):
        x[e] += dt * v[e]
    if SHIFTING:
        a = b.aside[low:high].reshape(-1)
        for e in range(x.size):
            x[e] += a[e]


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
def farthest(b):
    """Largest squared way of a particle since the list was built."""
    most = 0.0
    for i in range(b.x.shape[0]):
        most = max(most, (b.x[i, 0] - b.held[i, 0]) ** 2 + (b.x[i, 1] - b.held[i, 1]) ** 2 + (b.x[i, 2] - b.held[i, 2]) ** 2)
    return most

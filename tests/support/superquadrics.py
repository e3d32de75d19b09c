"""Random superquadrics."""

from __future__ import annotations

import numpy as np

from demsolver import rotation
from demsolver.scene import Particles, Superquadrics
from demsolver.shapes import superquadric
from demsolver.superquadric import Body, Floats, body, bounding_radius, surface

EXPONENTS = (2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0)


def drawn(rng: np.random.Generator, x: Floats) -> Body:
    """A body of any orientation, aspect ratios up to 5."""
    q = rng.normal(size=4)
    return body(x, q / np.linalg.norm(q), rng.uniform(0.01, 0.05, 3), rng.choice(EXPONENTS, 2))


def near(seed: int) -> tuple[Body, Body]:
    """Two bodies whose surfaces overlap by a tenth of the smallest semi-axis on the line between their centres; the first at the origin."""
    rng = np.random.default_rng(seed)
    i, way = drawn(rng, np.zeros(3)), rng.normal(size=3)
    way /= np.linalg.norm(way)
    j = drawn(rng, np.zeros(3))
    reach = surface.leaves((0.0, 0.0, 0.0), tuple(way), i) + surface.leaves((0.0, 0.0, 0.0), tuple(-way), j)
    apart = reach - 0.1 * min(*i.axes, *j.axes)
    return i, Body(tuple(apart * way), *j[1:])


def particles(
    x: Floats, axes: Floats, blockiness: Floats, quat: Floats, v: Floats | None = None, omega: Floats | None = None, density: float = 2500.0
) -> Particles:
    """Superquadrics; a row of zeros in `axes` is a sphere, of the radius that the first number of its `blockiness` says."""
    n = len(x)
    v, omega = (np.zeros((n, 3)) if one is None else one for one in (v, omega))
    shaped = axes.any(axis=1)
    radius, size, blocks = blockiness[:, 0].copy(), np.where(shaped[:, None], axes, blockiness[:, :1]), np.where(shaped[:, None], blockiness, 2.0)
    radius[shaped] = bounding_radius(axes[shaped], blockiness[shaped])
    mass = density * superquadric.volume(size, blocks)
    inertia = mass[:, None] * superquadric.inertia_per_mass(size, blocks)
    state = rotation.turning(quat, omega, inertia)
    shapes = Superquadrics(axes, blocks, state.quat, inertia, np.where(shaped[:, None], state.angmom, 0.0))
    one = np.ones(n, dtype=np.int64)
    return Particles(np.arange(1, n + 1), one, x, v, omega, radius, mass, one, np.zeros((n, 3), dtype=np.int64), superquadrics=shapes)


def lattice(rng: np.random.Generator, shape: tuple[int, int, int], apart: float = 0.05, spin: float = 20.0) -> Particles:
    """Random bodies on a cubic lattice from the origin on, most of which overlap their neighbours a little, moving and spinning."""
    x = apart * np.array(list(np.ndindex(*shape)), dtype=float)
    n = len(x)
    axes, blockiness = apart * rng.uniform(0.4, 0.5, (n, 3)), rng.choice(EXPONENTS, (n, 2))
    quat = rng.normal(size=(n, 4))
    return particles(x, axes, blockiness, quat / np.linalg.norm(quat, axis=1)[:, None], rng.normal(0.0, 0.1, (n, 3)), rng.normal(0.0, spin, (n, 3)))

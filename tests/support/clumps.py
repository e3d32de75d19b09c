"""Clumps for the solver's tests: made of spheres, thrown together, with others beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demsolver import Box, ContactLaw, Gravity, Neighbor, NveClumps, NveSphere, Particles, Scene, Slab, Wall
from demsolver.scene import Clumps, Force, Integrator, Superquadrics
from demsolver.shapes.principal import first_quaternion, principal
from demsolver.shapes.rotation import matrix
from demsolver.shapes.union import steiner
from demsolver.state import Floats, Ints
from tests.support.scenes import law, spheres

CENTRE = np.array([[0.0, 0.0, 0.0], [6.0, 1.0, 0.0], [-4.0, 5.0, 2.0], [1.0, -4.0, 5.0]]) * 1e-3
RADIUS = np.array([5.0, 4.0, 3.5, 3.0]) * 1e-3
"""Four spheres that overlap, without symmetry."""


def turned(rng: np.random.Generator) -> Floats:
    """A rotation matrix at random."""
    q = rng.normal(size=4)
    return np.asarray(matrix((q / np.linalg.norm(q))[None])[0])


def with_clumps(p: Particles, body: Ints, *, members_weigh: bool = True, v: Floats | None = None, omega: Floats | None = None) -> Particles:
    """Spheres of one number 0, 1, ... in `body` become a clump, those of -1 stay free. v, omega: (m, 3) of the clumps; else as the spheres move."""
    m = int(body.max()) + 1
    offset, members = np.zeros((len(p.id), 3)), np.ones(len(p.id))
    x, quat, angmom, inertia, mass = np.zeros((m, 3)), np.zeros((m, 4)), np.zeros((m, 3)), np.zeros((m, 3)), np.zeros(m)
    v, omega = np.zeros((m, 3)) if v is None else v, np.zeros((m, 3)) if omega is None else omega
    for k in range(m):
        own = np.flatnonzero(body == k)
        mass[k], x[k], tensor = steiner(p.mass[own], p.x[own], p.radius[own])
        inertia[k], axes = principal(tensor, ascending=members_weigh)
        offset[own], quat[k] = (p.x[own] - x[k]) @ axes, first_quaternion(axes)
        angmom[k] = axes @ (inertia[k] * (axes.T @ omega[k]))
        members[own] = mass[k]
    made = Clumps(body, offset, np.arange(1, m + 1), x, v.copy(), quat, angmom, omega.copy(), mass, inertia, np.ones(m, dtype=int), members_weigh)
    own_v, own_w, where = p.v.copy(), p.omega.copy(), body >= 0
    own_v[where] = v[body[where]] + np.cross(omega[body[where]], (p.x - x[body])[where])
    own_w[where] = omega[body[where]]
    return replace(p, v=own_v, omega=own_w, mass=p.mass if members_weigh else np.where(where, members, p.mass), clumps=made)


def heap(
    seed: int, clumps: int = 3, free: int = 3, *, members_weigh: bool = True, speed: float = 0.3, spacing: float = 0.02, inward: float = 0.0
) -> Particles:
    """Clumps and spheres on a grid above z = 0, turned at random, moving and turning. inward: towards the middle of
    the grid, velocity over distance."""
    rng = np.random.default_rng(seed)
    n = clumps + free
    side = int(np.ceil(n ** (1 / 3)))
    places = spacing * np.array([(i, j, k) for k in range(n) for j in range(side) for i in range(side)][:n], dtype=float) + [0.0, 0.0, 0.012]
    parts = [places[k] + (CENTRE - CENTRE.mean(axis=0)) @ turned(rng).T for k in range(clumps)]
    x = np.concatenate([*parts, places[clumps:]]) if free else np.concatenate(parts)
    radius = np.concatenate([np.tile(RADIUS, clumps), rng.uniform(4e-3, 6e-3, free)])
    body = np.concatenate([np.repeat(np.arange(clumps), len(RADIUS)), np.full(free, -1)])
    middle = places.mean(axis=0)
    v = rng.normal(0.0, speed, x.shape) - inward * (x - middle)
    p = spheres(x, radius, v=v, omega=rng.normal(0.0, 100.0 * speed, x.shape))
    moves = rng.normal(0.0, speed, (clumps, 3)) - inward * (places[:clumps] - middle), rng.normal(0.0, 100.0 * speed, (clumps, 3))
    return with_clumps(p, body, members_weigh=members_weigh, v=moves[0], omega=moves[1])


def scene_of(
    p: Particles, *, dt: float = 1e-5, pair: ContactLaw | None = None, forces: tuple[Force, ...] | None = None,
    integrate: tuple[Integrator, ...] = (NveSphere(), NveClumps()), box: Box | None = None, skin: float = 0.002,
) -> Scene:  # fmt: skip
    """The particles on a floor under gravity, with linear springs, damping and friction."""
    pair = pair or law((1, 1))
    floor = replace(pair, coefficients={name: np.ravel(table)[:1] for name, table in pair.coefficients.items()})
    weight = (Gravity((0.0, 0.0, -9.81)),) if forces is None else forces
    box = box or Box(np.full(3, -0.5), np.full(3, 0.5), ("ff", "ff", "ff"))
    walls = (Wall("floor", Slab(2, lo=0.0), floor),)
    return Scene(box, p, 1, dt, pair=pair, walls=walls, forces=weight, integrate=integrate, neighbor=Neighbor(skin))


def no_shapes(n: int) -> Superquadrics:
    """Of n spheres."""
    quat = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    return Superquadrics(np.zeros((n, 3)), np.full((n, 2), 2.0), quat, np.zeros((n, 3)), np.zeros((n, 3)))

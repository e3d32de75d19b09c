"""Volume and moments of a union of spheres by nested one-dimensional integrals: planes, lines in them, segments of the lines.

Shares no formula with demsolver.shapes.union. Between the places where something in the picture changes (tops of spheres and discs,
circles where two meet, points where three do) the integrands are analytic but for square roots at the ends, which t = sin(theta) removes,
so Gauss-Legendre converges exponentially.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def by_slices(centre: Floats, radius: Floats, nodes: int = 40) -> tuple[float, Floats, Floats]:
    """Volume, first moments (3,) and second moments (3, 3) about the origin. centre (k, 3), radius (k,), nodes: a piece of an integral."""
    total = np.zeros(10)
    for z, weight in zip(*_nodes(_heights(centre, radius), nodes), strict=True):
        square = radius**2 - (z - centre[:, 2]) ** 2
        there = square > 0
        total += weight * _plane(centre[there, :2], np.sqrt(square[there]), nodes) @ _with_height(z)
    v, x, y, z, xx, xy, xz, yy, yz, zz = total
    return float(v), np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def inertia_by_slices(centre: Floats, radius: Floats, nodes: int = 40) -> tuple[float, Floats, Floats]:
    """Volume, centroid (3,) and inertia about it (3, 3) at unit density."""
    volume, first, second = by_slices(centre, radius, nodes)
    spread = second - np.outer(first, first) / volume
    return volume, first / volume, np.trace(spread) * np.eye(3) - spread


def _with_height(z: float) -> Floats:
    """(6, 10): 1 x y xx xy yy of a plane -> 1 x y z xx xy xz yy yz zz of the body."""
    table = np.zeros((6, 10))
    table[0, [0, 3, 9]] = 1, z, z * z
    table[1, [1, 6]] = 1, z
    table[2, [2, 8]] = 1, z
    table[3, 4] = table[4, 5] = table[5, 7] = 1
    return table


def _nodes(breaks: Floats, nodes: int) -> tuple[Floats, Floats]:
    """Positions and weights over all pieces between sorted breaks."""
    theta, weight = np.polynomial.legendre.leggauss(nodes)
    theta, weight = theta * np.pi / 2, weight * np.pi / 2
    breaks = np.unique(breaks)
    middle, half = (breaks[1:] + breaks[:-1]) / 2, (breaks[1:] - breaks[:-1]) / 2
    return (middle[:, None] + half[:, None] * np.sin(theta)).ravel(), (half[:, None] * np.cos(theta) * weight).ravel()


def _heights(centre: Floats, radius: Floats) -> Floats:
    """z of tops and bottoms, of the ends of the circles where two spheres meet, of the points where three do."""
    found = [*(centre[:, 2] - radius), *(centre[:, 2] + radius)]
    for i, j in combinations(range(len(radius)), 2):
        arm = centre[j] - centre[i]
        apart = np.linalg.norm(arm)
        along = (apart**2 + radius[i] ** 2 - radius[j] ** 2) / (2 * apart)
        if abs(along) < radius[i]:
            tilt = np.sqrt((radius[i] ** 2 - along**2) * (1 - (arm[2] / apart) ** 2))
            middle = centre[i, 2] + along * arm[2] / apart
            found += [middle - tilt, middle + tilt]
    for triple in combinations(range(len(radius)), 3):
        found += _corners(centre[list(triple)], radius[list(triple)])
    return np.array(found)


def _corners(centre: Floats, radius: Floats) -> list[float]:
    """z of the points where three spheres meet: |x - c_i|^2 = r_i^2 minus the first is linear."""
    planes = 2 * (centre[1:] - centre[0])
    right = (centre[1:] ** 2).sum(1) - (centre[0] ** 2).sum() + radius[0] ** 2 - radius[1:] ** 2
    line = np.cross(*planes)
    if np.linalg.norm(line) < 1e-12:
        return []
    foot = np.linalg.solve(np.vstack([planes, line]), np.append(right, line @ centre[0])) - centre[0]
    left = radius[0] ** 2 - foot @ foot
    if left <= 0:
        return []
    return [centre[0, 2] + foot[2] + sign * np.sqrt(left) * line[2] / np.linalg.norm(line) for sign in (-1, 1)]


def _plane(centre: Floats, radius: Floats, nodes: int) -> Floats:
    """Area and moments 1 x y xx xy yy of a union of discs."""
    y, weight = _nodes(_levels(centre, radius), nodes)
    square = radius**2 - (y[:, None] - centre[:, 1]) ** 2
    half = np.sqrt(np.maximum(square, 0))
    start = np.where(square > 0, centre[:, 0] - half, np.inf)
    end = np.where(square > 0, centre[:, 0] + half, -np.inf)
    order = np.argsort(start, axis=1)
    start, end = np.take_along_axis(start, order, 1), np.take_along_axis(end, order, 1)
    reached = np.maximum.accumulate(np.hstack([np.full((len(y), 1), -np.inf), end[:, :-1]]), axis=1)
    low = np.maximum(start, reached)
    covered = end > low
    low, high = np.where(covered, low, 0), np.where(covered, end, 0)
    one, x, xx = ((high ** (n + 1) - low ** (n + 1)).sum(1) / (n + 1) for n in range(3))
    return np.array([weight @ column for column in (one, x, y * one, xx, y * x, y * y * one)])


def _levels(centre: Floats, radius: Floats) -> Floats:
    """y of tops and bottoms of discs and of the points where two circles meet."""
    found = [*(centre[:, 1] - radius), *(centre[:, 1] + radius)]
    for i, j in combinations(range(len(radius)), 2):
        arm = centre[j] - centre[i]
        apart = np.linalg.norm(arm)
        along = (apart**2 + radius[i] ** 2 - radius[j] ** 2) / (2 * apart) if apart > 0 else np.inf
        if abs(along) < radius[i]:
            across = np.sqrt(radius[i] ** 2 - along**2) * arm[0] / apart
            middle = centre[i, 1] + along * arm[1] / apart
            found += [middle - across, middle + across]
    return np.array(found)

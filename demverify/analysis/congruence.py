"""Which template a body is, and how it lies in space: centres of spheres fitted to centres of spheres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demsolver.shapes.multisphere import Template
from demverify.frames import Floats

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Placed:
    """Bodies of one template. rows: (b,) which they are. rotation: (b, 3, 3), template to space. middle: (b, 3) mean of the centres."""

    template: Template
    rows: Ints
    rotation: Floats
    middle: Floats

    def points(self, point: Floats) -> Floats:
        """Where a point of the template, (3,), is in space, (b, 3)."""
        return np.asarray(self.middle + self.rotation @ (point - self.template.centre.mean(axis=0)))

    def tensors(self, tensor: Floats) -> Floats:
        """A tensor of the template, (3, 3), in space, (b, 3, 3)."""
        return np.asarray(self.rotation @ tensor @ np.swapaxes(self.rotation, 1, 2))


@dataclass(frozen=True)
class Tolerance:
    """What equal lengths may differ by. length: of positions; radius: relative, of radii."""

    length: float
    radius: float


@dataclass(frozen=True)
class _Fit:
    """How a template lies in space, (m, ...), and how far from its place a sphere is at most, (m,)."""

    rotation: Floats
    middle: Floats
    apart: Floats

    def rows(self, mine: Mask) -> _Fit:
        """Some of the bodies."""
        return _Fit(self.rotation[mine], self.middle[mine], self.apart[mine])


class _Found:
    """For each of m bodies the template that fits it best so far."""

    def __init__(self, m: int) -> None:
        self.which = np.full(m, -1)
        self._fit = _Fit(np.empty((m, 3, 3)), np.empty((m, 3)), np.full(m, np.inf))

    def add(self, rows: Ints, number: int, fit: _Fit) -> None:
        """Keeps a fit where it is closer than what was there."""
        closer = fit.apart < self._fit.apart[rows]
        rows, fit = rows[closer], fit.rows(closer)
        self.which[rows] = number
        self._fit.rotation[rows], self._fit.middle[rows], self._fit.apart[rows] = fit.rotation, fit.middle, fit.apart

    def placed(self, templates: tuple[Template, ...]) -> list[Placed]:
        """The bodies of each template that has some."""
        rows = [np.flatnonzero(self.which == number) for number in range(len(templates))]
        return [Placed(templates[i], mine, self._fit.rotation[mine], self._fit.middle[mine]) for i, mine in enumerate(rows) if len(mine)]


def by_template(x: Floats, radius: Floats, templates: tuple[Template, ...], tolerance: Tolerance) -> tuple[list[Placed], Ints]:
    """The bodies of each template, and the rows that fit none. x: (m, k, 3), radius: (m, k); of several templates the closest.

    Members are taken in their order; where they fit no template so, in whatever order radii and distances allow.
    """
    found = _Found(len(x))
    for search in (_in_order, _in_any_order):
        left = np.flatnonzero(found.which < 0)
        for number, template in enumerate(templates):
            if len(template.radius) == radius.shape[1]:
                for rows, fit in search(x[left], radius[left], template, tolerance):
                    found.add(left[rows], number, fit)
    return found.placed(templates), np.flatnonzero(found.which < 0)


def alike(x: Floats, radius: Floats, tolerance: Tolerance) -> list[Placed]:
    """The bodies sorted by shape: the first of each is the template of its kind, which the others equal within the tolerance."""
    kinds: list[Placed] = []
    left = np.arange(len(x))
    while len(left):
        first = Template(x[left[0]] - x[left[0], 0], radius[left[0]])
        kinds.append(Placed(first, left[:1], np.eye(3)[None], x[left[:1]].mean(axis=1)))
        left = left[1:]
        for rows, fit in _in_order(x[left], radius[left], first, tolerance):
            kinds.append(Placed(first, left[rows], fit.rotation, fit.middle))
            left = np.delete(left, rows)
    return kinds


def _in_order(x: Floats, radius: Floats, template: Template, tolerance: Tolerance) -> Iterator[tuple[Ints, _Fit]]:
    """Bodies that are the template, member by member."""
    rows = _candidates(x, radius, template, tolerance)
    fit = _fit(x[rows], template.centre)
    good = _fits(fit, radius[rows], template, tolerance)
    yield rows[good], fit.rows(good)


def _in_any_order(x: Floats, radius: Floats, template: Template, tolerance: Tolerance) -> Iterator[tuple[Ints, _Fit]]:
    """Bodies that are the template when their members are put into the order that fits the first of those left."""
    left = _candidates(x, radius, template, tolerance)
    while len(left):
        order = next(_orders(x[left[0]], radius[left[0]], template, tolerance), None)
        first, left = left[:1], left[1:]
        if order is not None:
            yield first, _fit(x[first][:, order], template.centre)
            for rows, fit in _in_order(x[left][:, order], radius[left][:, order], template, tolerance):
                yield left[rows], fit
                left = np.delete(left, rows)


def _candidates(x: Floats, radius: Floats, template: Template, tolerance: Tolerance) -> Ints:
    """Bodies whose radii, in order of size, and whose spread are those of the template."""
    radii = np.abs(np.sort(radius, axis=1) - np.sort(template.radius)) <= tolerance.radius * template.radius.max()
    spread, wanted = _spread(x), _spread(template.centre)
    return np.flatnonzero(radii.all(axis=1) & (np.abs(spread - wanted) <= tolerance.length))


def _spread(x: Floats) -> Floats:
    """Root mean square distance of the centres (..., k, 3) from their mean."""
    return np.asarray(np.sqrt(((x - x.mean(axis=-2, keepdims=True)) ** 2).sum(axis=-1).mean(axis=-1)))


def _fits(fit: _Fit, radius: Floats, template: Template, tolerance: Tolerance) -> Mask:
    radii = (np.abs(radius - template.radius) <= tolerance.radius * template.radius).all(axis=1)
    return np.asarray(radii & (fit.apart <= tolerance.length))


def _fit(x: Floats, centre: Floats) -> _Fit:
    """Centres (k, 3) turned and shifted to be closest to x (m, k, 3); mirror images are not allowed.

    Source: W. Kabsch, Acta Cryst. A32 (1976) 922, doi:10.1107/S0567739476001873.
    """
    middle, arms = x.mean(axis=1), centre - centre.mean(axis=0)
    own = x - middle[:, None]
    u, _, vt = np.linalg.svd(np.einsum("mki,kj->mij", own, arms))
    u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    rotation = u @ vt
    apart = np.sqrt(((own - arms @ np.swapaxes(rotation, 1, 2)) ** 2).sum(axis=2)).max(axis=1)
    return _Fit(rotation, middle, apart)


def _orders(x: Floats, radius: Floats, template: Template, tolerance: Tolerance) -> Iterator[Ints]:
    """Orders of a body's members (k,) in which radii and all distances are those of the template, and that are no mirror image of it."""
    wanted = np.sqrt(((template.centre[:, None] - template.centre) ** 2).sum(axis=2))
    found = np.sqrt(((x[:, None] - x) ** 2).sum(axis=2))
    same = np.abs(radius[None] - template.radius[:, None]) <= tolerance.radius * template.radius[:, None]
    for order in _extended([], same, wanted, found, 2.0 * tolerance.length):
        members = np.array(order)
        if _fits(_fit(x[None, members], template.centre), radius[None, members], template, tolerance)[0]:
            yield members


def _extended(order: list[int], same: Mask, wanted: Floats, found: Floats, length: float) -> Iterator[list[int]]:
    """All ways to go on with an order that is right so far."""
    i = len(order)
    if i == len(wanted):
        yield order
        return
    for j in np.flatnonzero(same[i]).tolist():
        if j not in order and (np.abs(found[j, order] - wanted[i, :i]) <= length).all():
            yield from _extended([*order, j], same, wanted, found, length)

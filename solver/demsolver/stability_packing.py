"""The longest stable step of a whole packing: all contacts at once.

With M, C, K the masses, the damping and the stiffness of all contacts as they are, mass-weighted: K' = M^-1/2 K M^-1/2, C' likewise. Both integrators
(see stability.py) make x(n+1) - 2 x(n) + x(n-1) + H (x(n) - x(n-1)) + dt^2 K' x(n) = 0 with H = dt C'. For symmetric K' >= 0 and C' >= 0, taking the
product with a mode y shows |lambda| <= 1 wherever y.(4 - dt^2 K' - 2 dt C') y > 0; and where that form is negative for some y there is a real
lambda < -1. So the step is stable exactly while the largest eigenvalue of dt^2 K' + 2 dt C' is below 4: K + 2 H < 4 of one contact, in matrices.

A contact has a normal row, two tangential rows (the motion of the contact point, spins included; every contact taken as sticking), two rolling
rows and a twisting row; and where it pushes with F at distance L of the centres, two rows of stiffness -F/L: a normal force that turns with the
contact. Left out: that tangential springs turn too; levers that differ between spin and torque are taken at their geometric mean.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from demsolver.scene import Scene, Viscous
from demsolver.stability import combined_limit, damper_limit, rolling_share, spring_limit
from demsolver.stability_contacts import PAIR, Contacts, arms, encounters, law_of, mobility
from demsolver.stability_laws import LinearLaw
from demsolver.state import Floats, Ints, selected

if TYPE_CHECKING:
    from scipy.sparse import csr_array

DENSE = 600
"""Up to so many degrees of freedom all eigenvalues are taken; above it, the largest one by Lanczos iteration."""
ROUGH = 1e-4
"""Relative error of that eigenvalue, so half of it in the step; large packings have hundreds of modes nearer to each other than that."""


@dataclass(frozen=True)
class PackingLimit:
    """contacts: how many. undamped: 2/omega_max, the springs alone. combined: springs, dampers and drag. inf where nothing limits. law: names of
    the normal laws."""

    contacts: int
    undamped: float
    combined: float
    law: str = ""


def packing_limit(scene: Scene, contacts: Contacts) -> PackingLimit:
    """The longest stable step of the scene's contacts as they are."""
    packing = _Packing(scene, contacts)
    undamped = spring_limit(1.0, packing.largest(packing.stiffness)[0])
    laws = sorted({law_of(scene, number).normal for number in np.unique(contacts.law).tolist()})
    return PackingLimit(len(contacts), undamped, packing.combined(undamped), ", ".join(laws))


def buckling_rate(scene: Scene, contacts: Contacts) -> float:
    """How fast the scene's contacts, held in equilibrium, give way by themselves, whatever the step: 1/time in which a departure grows e-fold; 0
    where they are stable, and for packings too large for all eigenvalues (DENSE).

    Spheres pressed in a row without friction buckle: the rows -F/L are negative stiffness."""
    packing = _Packing(scene, contacts)
    if packing.rows.shape[1] > DENSE:
        return 0.0
    least = -packing.largest(-packing.stiffness)[0]
    return float(np.sqrt(max(-least, 0.0)))


def packing_bound(scene: Scene, contacts: Contacts) -> float:
    """A step that is certainly stable for the packing, at hardly any cost; in dense packings two to five times shorter than the limit.

    An eigenvalue of a sum over pairs is at most twice the largest sum at one particle, to which each contact gives its stiffest motion. Every
    contact is taken as stiff as the stiffest of its pair of types: at their largest overlap, radii and masses, with which all laws here stiffen."""
    moves = mobility(scene)
    ease, turn = moves.translation.max(axis=1), moves.rotation.max(axis=1)
    stiffness, damping = np.zeros(len(ease)), _gamma(scene) * ease
    for law, chosen, stiffest, strongest in _stiffest(scene, contacts):
        for i in (contacts.i[chosen], contacts.j[chosen][contacts.j[chosen] >= 0]):
            for total, k in ((stiffness, stiffest), (damping, strongest)):
                motions = (k[0] * ease[i], k[1] * (ease[i] + scene.particles.radius[i] ** 2 * turn[i]), max(k[2], k[3]) * turn[i])
                np.add.at(total, i, (1.0 if law != PAIR else 2.0) * np.maximum.reduce(motions))
    return combined_limit(1.0, float(stiffness.max(initial=0.0)), float(damping.max(initial=0.0)))


def _stiffest(scene: Scene, contacts: Contacts) -> Iterator[tuple[int, Ints, Floats, Floats]]:
    """For each law and pair of types: its contacts, and (4,) stiffness and damping of the stiffest they might be."""
    if not len(contacts):
        return
    kind = scene.particles.type - 1
    a, b = kind[contacts.i], np.where(contacts.j >= 0, kind[contacts.j], 0)
    code = ((contacts.law + 1) * scene.ntypes + np.minimum(a, b)) * scene.ntypes + np.maximum(a, b)
    laws = {number: LinearLaw(law_of(scene, number), scene.timestep) for number in np.unique(contacts.law).tolist()}
    for each in np.flatnonzero(np.bincount(code)):
        chosen = np.flatnonzero(code == each)
        number = int(contacts.law[chosen[0]])
        states = encounters(scene, *(getattr(contacts, name)[chosen] for name in ("i", "j", "overlap", "reff")))
        found = laws[number].answers(states.max(axis=0, keepdims=True))
        yield number, chosen, found.stiffness[0], found.damping[0]


class _Packing:
    """Rows (r, f) of the motions of all contacts, mass-weighted, over the f freedoms they touch; their stiffness and damping (r,)."""

    def __init__(self, scene: Scene, contacts: Contacts) -> None:
        """Raises ValueError for wrong laws."""
        found = [*_contact_rows(scene, contacts), *_drag_rows(scene)]
        self.stiffness, self.damping = (np.concatenate([part[k] for part in found]) for k in (1, 2))
        moves = mobility(scene)
        ease = np.sqrt(np.concatenate([moves.translation.ravel(), moves.rotation.ravel()]))
        self.rows = _stacked([part[0] for part in found], ease)
        self._back = self.rows.T.tocsr()
        self._start = np.random.default_rng(1).normal(size=self.rows.shape[1])

    def largest(self, weights: Floats) -> tuple[float, Floats]:
        """Largest eigenvalue and its mode of the sum of weights times row times row; 0 without rows."""
        from scipy.sparse.linalg import LinearOperator, eigsh

        n = self.rows.shape[1]
        if n == 0 or not weights.any():
            return 0.0, np.zeros(n)
        if n <= DENSE:
            dense = self.rows.toarray()
            values, modes = np.linalg.eigh(dense.T @ (weights[:, None] * dense))
            return float(values[-1]), modes[:, -1]
        operator = LinearOperator((n, n), matvec=lambda y: self._back @ (weights * (self.rows @ np.ravel(y))), dtype=float)
        values, modes = eigsh(operator, k=1, which="LA", v0=self._start, tol=ROUGH)
        return float(values[0]), modes[:, 0]

    def combined(self, undamped: float) -> float:
        """The step at which the largest eigenvalue of dt^2 K' + 2 dt C' is 4: each mode found gives a step too long, nearer to the limit."""
        dt = undamped
        if not self.damping.any():
            return dt
        if dt == inf:
            return damper_limit(1.0, self.largest(self.damping)[0])
        for _ in range(20):
            _, y = self.largest(dt * dt * self.stiffness + 2.0 * dt * self.damping)
            moved = (self.rows @ y) ** 2
            shorter = combined_limit(1.0, float(self.stiffness @ moved), float(self.damping @ moved))
            if shorter > (1.0 - 1e-5) * dt:
                break
            dt = shorter
        return dt


@dataclass(frozen=True)
class _Block:
    """One row a contact: how the particles' freedoms make up a motion. columns, values: (m, c)."""

    columns: Ints
    values: Floats


def _stacked(blocks: list[_Block], ease: Floats) -> csr_array:
    """Blocks under one another, mass-weighted, without the columns that are nowhere."""
    from scipy.sparse import csr_array

    lengths = [len(block.columns) for block in blocks]
    row = np.repeat(np.arange(sum(lengths)), np.repeat([b.columns.shape[1] for b in blocks], lengths))
    column = np.concatenate([block.columns.ravel() for block in blocks])
    value = np.concatenate([block.values.ravel() for block in blocks]) * ease[column]
    kept = value != 0.0
    used, column = np.unique(column[kept], return_inverse=True)
    return csr_array((value[kept], (row[kept], column)), shape=(sum(lengths), len(used)))


def _contact_rows(scene: Scene, contacts: Contacts) -> Iterator[tuple[_Block, Floats, Floats]]:
    """Each motion that has stiffness or damping anywhere, with both."""
    force, stiffness, damping = _answers(scene, contacts)
    n = contacts.n
    across = np.cross(n, np.eye(3)[np.argmin(np.abs(n), axis=1)])
    across /= np.linalg.norm(across, axis=1)[:, None]
    tangents = (across, np.cross(n, across))
    levers, shares = _levers(scene, contacts)
    turn = 3 * len(scene.particles.id)
    none = np.zeros(len(contacts))
    yield _block(contacts, [(0, n, (1.0, -1.0))]), stiffness[:, 0], damping[:, 0]
    for t in tangents:
        yield _block(contacts, [(0, t, (1.0, -1.0))]), -force / contacts.distance, none
        if stiffness[:, 1].any() or damping[:, 1].any():
            both = [(0, t, (1.0, -1.0)), (turn, -np.cross(n, t), levers)]
            yield _block(contacts, both), stiffness[:, 1], damping[:, 1]
    for k, axes in ((2, tangents), (3, (n,))):
        if stiffness[:, k].any() or damping[:, k].any():
            for axis in axes:
                yield _block(contacts, [(turn, axis, (shares[0], -shares[1]))]), stiffness[:, k], damping[:, k]


def _block(contacts: Contacts, parts: list[tuple[int, Floats, tuple[Any, Any]]]) -> _Block:
    """parts: (first column, vectors (m, 3), factors of i and of j, each a number or (m,))."""
    columns, values = [], []
    for offset, vector, factors in parts:
        for rows, factor in zip((contacts.i, contacts.j), factors, strict=True):
            columns.append(offset + 3 * np.maximum(rows, 0)[:, None] + np.arange(3))
            values.append(vector * np.where(rows >= 0, factor, 0.0)[:, None])
    return _Block(np.concatenate(columns, axis=1), np.concatenate(values, axis=1))


def _levers(scene: Scene, contacts: Contacts) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Of both particles: lever of the tangential motion, and the square root of the part of the rolling torque they feel."""
    lever, share = np.ones((2, len(contacts))), np.ones((2, len(contacts)))
    for number in np.unique(contacts.law):
        law, chosen = law_of(scene, int(number)), contacts.law == number
        for side, rows in enumerate((contacts.i, contacts.j)):
            lever[side, chosen] = arms(law, scene.particles.radius[rows[chosen]], contacts.overlap[chosen])
        if number == PAIR:
            share[1, chosen] = np.sqrt(rolling_share(law, scene.particles.radius[np.array([contacts.i, contacts.j])[:, chosen]])[1])
    return (lever[0], lever[1]), (share[0], share[1])


def _answers(scene: Scene, contacts: Contacts) -> tuple[Floats, Floats, Floats]:
    """force (m,), stiffness (m, 4), damping (m, 4) of all contacts."""
    force, stiffness, damping = np.zeros(len(contacts)), np.zeros((len(contacts), 4)), np.zeros((len(contacts), 4))
    for number in np.unique(contacts.law).tolist():
        chosen = np.flatnonzero(contacts.law == number)
        states = encounters(scene, *(getattr(contacts, name)[chosen] for name in ("i", "j", "overlap", "reff")))
        found = LinearLaw(law_of(scene, number), scene.timestep).answers(states)
        force[chosen], stiffness[chosen], damping[chosen] = found.force, found.stiffness, found.damping
    return force, stiffness, damping


def _drag_rows(scene: Scene) -> Iterator[tuple[_Block, Floats, Floats]]:
    gamma = np.repeat(_gamma(scene), 3)
    held = np.flatnonzero(gamma)
    if len(held):
        yield _Block(held[:, None], np.ones((len(held), 1))), np.zeros(len(held)), gamma[held]


def _gamma(scene: Scene) -> Floats:
    """(n,) drag coefficients of the particles, summed over the drags of the scene."""
    total = np.zeros(len(scene.particles.id))
    for force in scene.forces:
        if isinstance(force, Viscous):
            members = np.flatnonzero(selected(scene.particles.mask, force.bit))
            total[members] += force.gamma[scene.particles.type[members] - 1]
    return total

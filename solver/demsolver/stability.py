"""How long a step may be: the limits of every contact a scene can have, from its own laws.

One contact is a mass m on a spring k and a damper eta. With K = k dt^2/m and H = eta dt/m both integrators of this solver, semi-implicit Euler and
velocity Verlet with forces from half-step velocities (as LAMMPS and LIGGGHTS compute them), take the state (x, v dt) to

    [[1 - K, 1 - H], [-K, 1 - H]] (x, v dt),    trace 2 - K - H, determinant 1 - H

and both roots of lambda^2 - (2 - K - H) lambda + 1 - H lie in the unit circle exactly if K > 0, 0 < H < 2 and K + 2 H < 4 (Jury). So

    spring alone   dt < 2 sqrt(m/k)                                  DEM primer (2.24); at the limit lambda = -1, below it |lambda| = 1
    damper alone   dt < 2 m/eta                                      DEM primer (2.30)
    both           dt < 4 m / (eta + sqrt(eta^2 + 4 k m))            from K + 2 H = 4; the primer's (2.31), the smaller of the two, is too long

The mass of a motion: 1/m = 1/m_i + 1/m_j for the normal one; each gains a^2/I for the tangential one (a lever of the contact point), which makes
it 2/7 of that for solid spheres; rolling and twisting have 1/(1/I_i + 1/I_j). Walls, frozen and unmoved particles have no inverse mass.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, product
from math import hypot, inf, sqrt

import numpy as np

from demsolver import contact, neighbors
from demsolver.expression import Number
from demsolver.reference import added
from demsolver.scene import AddForce, ContactLaw, Cylinder, Particles, Scene, Slab, Viscous, Wall
from demsolver.stability_contacts import PAIR, Contacts, Mobility, arms, encounters, mobility, wall_radius
from demsolver.stability_laws import MOTIONS, Encounter, LinearLaw
from demsolver.state import Floats, selected

_NO_SPRING = {False: "a step law: no limit", True: "solved for: no limit from the spring"}
SLIGHT = 1e-3
"""Overlap over the sum of radii at which a law is asked whether it is linear."""


def spring_limit(mass: float, stiffness: float) -> float:
    """Longest step for a spring alone; inf without one."""
    return 2.0 * sqrt(mass / stiffness) if stiffness > 0.0 else inf


def damper_limit(mass: float, damping: float) -> float:
    """Longest step for a damper alone; inf without one."""
    return 2.0 * mass / damping if damping > 0.0 else inf


def combined_limit(mass: float, stiffness: float, damping: float) -> float:
    """Longest step for spring and damper together; a spring that pulls apart (stiffness < 0) limits nothing."""
    reach = damping + hypot(damping, 2.0 * sqrt(max(stiffness, 0.0)) * sqrt(mass))
    return 4.0 * mass / reach if reach > 0.0 else inf


@dataclass(frozen=True)
class ContactLimit:
    """The longest stable steps of one motion of one contact, in the deck's unit of time; inf where nothing limits.

    between: "types 1 and 2", "type 1 and wall floor". motion: one of MOTIONS, or "drag". law: names of its laws. mass: of the motion, a moment of
    inertia for rolling and twisting. stiffness, damping: at `overlap` (None where it does not matter); `at` says why there.
    """

    between: str
    motion: str
    law: str
    mass: float
    stiffness: float
    damping: float
    overlap: float | None
    at: str

    @property
    def spring(self) -> float:
        """2 sqrt(m/k), (2.24)."""
        return spring_limit(self.mass, self.stiffness)

    @property
    def damper(self) -> float:
        """2 m/eta, (2.30)."""
        return damper_limit(self.mass, self.damping)

    @property
    def apart(self) -> float:
        """The smaller of both, (2.31)."""
        return min(self.spring, self.damper)

    @property
    def combined(self) -> float:
        """What holds: K + 2 H < 4."""
        return combined_limit(self.mass, self.stiffness, self.damping)


def contact_limits(scene: Scene, contacts: Contacts) -> tuple[ContactLimit, ...]:
    """Limits of every pair of types and every type and wall that can meet, of their lightest particles; then of viscous drag
    and of added forces, as far as these go against velocity or place of the lightest and the fastest particle of each type as it moves now.

    A law that answers alike at any overlap is taken as it is. Any other is taken at the largest overlap there is now between the two, or at that
    which their largest closing speed would reach without damping, if that is larger.
    """
    meetings = _Meetings(scene, contacts)
    return (*meetings.limits(), *_drag_limits(scene, meetings.mobility), *_added_limits(scene, meetings.mobility))


class _Meetings:
    """Who can meet in a scene, and what its law answers."""

    def __init__(self, scene: Scene, contacts: Contacts) -> None:
        self.scene = scene
        self.contacts = contacts
        self.mobility = mobility(scene)
        self._ease = self.mobility.translation.max(axis=1)
        self._kind = scene.particles.type - 1

    def limits(self) -> Iterator[ContactLimit]:
        if self.scene.pair is not None:
            law = LinearLaw(self.scene.pair, self.scene.timestep)
            for i, j in self._lightest_pairs():
                a, b = sorted((int(self._kind[i]), int(self._kind[j])))
                speed = _closing(self.scene.particles.v[self._kind == a], self.scene.particles.v[self._kind == b])
                ri, rj = self.scene.particles.radius[[i, j]].tolist()
                if ri + rj > 0.0:
                    yield from self._limits(law, i, j, f"types {a + 1} and {b + 1}", self._largest(PAIR, a, b), speed, ri * rj / (ri + rj))
        for number, wall in enumerate(self.scene.walls):
            law = LinearLaw(wall.law, self.scene.timestep)
            members = selected(self.scene.particles.mask, wall.bit)
            for kind in np.unique(self._kind[members]):
                rows = np.flatnonzero(members & (self._kind == kind))
                i = int(rows[np.argmax(self._ease[rows])])
                if self._ease[i] > 0.0 and self.scene.particles.radius[i] > 0.0:
                    speed = float(_wall_speeds(self.scene, wall)[rows].max())
                    reff = wall_radius(self.scene, number, i)
                    yield from self._limits(law, i, -1, f"type {kind + 1} and wall {wall.name}", self._largest(number, int(kind)), speed, reff)

    def _lightest_pairs(self) -> Iterator[tuple[int, int]]:
        """For each pair of types that can meet and move, its two lightest particles."""
        excluded, classes, _ = neighbors.exclusions(self.scene, self.scene.particles.mask, self._kind)
        order = np.argsort(-self._ease, kind="stable")
        code = self._kind[order] * len(excluded) + classes[order]
        first = {int(c): order[code == c][:2].tolist() for c in np.unique(code)}
        for a, b in combinations_with_replacement(sorted({c // len(excluded) for c in first}), 2):
            members = [[c for c in first if c // len(excluded) == kind] for kind in (a, b)]
            allowed = [(c, d) for c, d in product(*members) if not excluded[c % len(excluded), d % len(excluded)]]
            found = [(i, j) for c, d in allowed for i, j in product(first[c], first[d]) if i != j and self._ease[i] + self._ease[j] > 0.0]
            if found:
                yield max(found, key=lambda pair: float(self._ease[pair[0]] + self._ease[pair[1]]))

    def _largest(self, law: int, a: int, b: int | None = None) -> float:
        """Largest overlap now; 0 where nothing touches."""
        c, kind = self.contacts, self._kind
        of = (c.law == law) & ((kind[c.i] == a) if b is None else (np.minimum(kind[c.i], kind[c.j]) == a) & (np.maximum(kind[c.i], kind[c.j]) == b))
        return float(c.overlap[of].max(initial=0.0))

    def _limits(self, law: LinearLaw, i: int, j: int, between: str, now: float, speed: float, reff: float) -> Iterator[ContactLimit]:
        state = Encounter(*encounters(self.scene, np.array([i]), np.array([j]), np.array([SLIGHT * self._size(i, j)]), np.array([reff]))[0].tolist())
        masses = self._masses(law.law, i, j, state.overlap)
        overlap, at = _overlap(law, state, now, speed, masses[0])
        answer = law.answers([state._replace(overlap=overlap) if overlap else state])
        for k, motion in enumerate(MOTIONS):
            stiffness, damping = (0.0, 0.0) if overlap == 0.0 else (float(answer.stiffness[0, k]), float(answer.damping[0, k]))
            if motion == "normal" or stiffness > 0.0 or damping > 0.0:
                found = (None, _NO_SPRING[law.implicit]) if motion == "normal" and (law.step_law or law.implicit) else (overlap, at)
                yield ContactLimit(between, motion, _law_name(law.law, motion), masses[k], stiffness, damping, *found)

    def _size(self, i: int, j: int) -> float:
        """Sum of the radii."""
        return float(self.scene.particles.radius[[i, j] if j >= 0 else [i]].sum())

    def _masses(self, law: ContactLaw, i: int, j: int, overlap: float) -> tuple[float, float, float, float]:
        """Of the four motions; the rotation about the axis that is freest."""
        turn = self.mobility.rotation.max(axis=1)
        rows = [i, j] if j >= 0 else [i]
        lever = arms(law, self.scene.particles.radius[rows], np.full(len(rows), overlap))
        share = rolling_share(law, self.scene.particles.radius[rows])
        ease = float(self._ease[rows].sum())
        slide, roll = ease + float((lever**2 * turn[rows]).sum()), float((share * turn[rows]).sum())
        return 1.0 / ease, 1.0 / slide, 1.0 / roll if roll else inf, 1.0 / roll if roll else inf


def rolling_share(law: ContactLaw, radius: Floats) -> Floats:
    """(1,) or (2,) part of the rolling torque that each side of a contact feels."""
    scales = law.rolling != "none" and getattr(contact.law("rolling", law.rolling), "SCALES_WITH_RADIUS", False)
    found: Floats = radius / radius[0] if scales else np.ones(len(radius))
    return found


def _overlap(law: LinearLaw, state: Encounter, now: float, speed: float, mass: float) -> tuple[float | None, str]:
    """The overlap at which a law is asked, and why there; None for any."""
    if law.linear_in_overlap(state):
        return None, "any overlap"
    reached = 0.0 if law.step_law or law.implicit else law.overlap_of(state, 0.5 * mass * speed * speed) if speed > 0.0 else 0.0
    if now == reached == 0.0:
        return 0.0, "nothing touches or closes in"
    return (now, "the largest now") if now >= reached else (reached, f"closing in at {speed:.3g}")


def _law_name(law: ContactLaw, motion: str) -> str:
    if motion == "normal":
        return " + ".join([law.normal, *(name for name in (law.damping, law.cohesion) if name != "none")])
    if motion == "tangential":
        parts = [name for name in (law.tangential_stiffness, law.tangential_damping) if name != "none"]
        return f"{law.friction} ({' + '.join(parts)})"
    return str(getattr(law, motion))


def _closing(a: Floats, b: Floats) -> float:
    """No two particles of two sets of velocities (n, 3) close in faster than this; exact for one and one."""
    return hypot(*np.maximum(a.max(axis=0) - b.min(axis=0), b.max(axis=0) - a.min(axis=0)).tolist())


def _wall_speeds(scene: Scene, wall: Wall) -> Floats:
    """(n,) how fast each particle may close in on a wall."""
    p, shape = scene.particles, wall.shape
    v = p.v - np.array(wall.velocity)
    if isinstance(shape, Slab):
        return np.asarray(np.abs(v[:, shape.axis]))
    if isinstance(shape, Cylinder):
        return np.asarray(np.hypot(v[:, (shape.axis + 1) % 3], v[:, (shape.axis + 2) % 3]))
    normal = np.array(shape.normal) / np.linalg.norm(shape.normal)
    return np.asarray(np.abs((v - np.array(shape.velocity) - np.cross(shape.omega, p.x - np.array(shape.pivot))) @ normal))


def _drag_limits(scene: Scene, moves: Mobility) -> Iterator[ContactLimit]:
    ease, kind = moves.translation.max(axis=1), scene.particles.type
    for force in scene.forces:
        if isinstance(force, Viscous):
            rows = selected(scene.particles.mask, force.bit) & (ease > 0.0)
            for a in np.unique(kind[rows]):
                mass, damping = 1.0 / float(ease[rows & (kind == a)].max()), float(force.gamma[a - 1])
                if damping > 0.0:
                    yield ContactLimit(f"type {a} and the medium", "drag", "viscous drag", mass, 0.0, damping, None, "any place")



def _added_limits(scene: Scene, moves: Mobility) -> Iterator[ContactLimit]:
    p, ease = scene.particles, moves.translation.max(axis=1)
    for force in scene.forces:
        if not isinstance(force, AddForce) or all(isinstance(component, Number) for component in force.force):
            continue
        rows = np.flatnonzero(selected(p.mask, force.bit) & (ease > 0.0))
        for a in np.unique(p.type[rows]):
            of_type = rows[p.type[rows] == a]
            chosen = {int(of_type[np.argmax(ease[of_type])]), int(of_type[np.argmax((p.v[of_type] ** 2).sum(axis=1))])}
            for i in sorted(chosen):
                stiffness, damping = _slopes(scene, force, i)
                if stiffness > 0.0 or damping > 0.0:
                    mass, at = 1.0 / float(ease[i]), "as it moves now"
                    yield ContactLimit(f"type {a} and the medium", "drag", "added force", mass, stiffness, damping, None, at)


def _slopes(scene: Scene, force: AddForce, i: int) -> tuple[float, float]:
    """Largest -dF/dx and -dF/dv of an added force on particle i along an axis; 0 where the formula has no value."""
    p = scene.particles
    names = ("id", "type", "x", "v", "omega", "radius", "mass", "mask", "image")
    one = replace(scene, particles=Particles(**{name: getattr(p, name)[[i]] for name in names}), forces=(force,))
    length = 1e-6 * (float(p.radius[i]) or float((scene.box.hi - scene.box.lo).max()))
    speed = 1e-6 * max(float(np.abs(p.v[i]).max()), 1e3 * length / scene.timestep)
    found = np.zeros((2, 3))
    for c, way in enumerate(np.eye(3)):
        for k, (dx, dv) in enumerate(((length, 0.0), (0.0, speed))):
            up, down = (added(one, p.x[[i]] + side * dx * way, p.v[[i]] + side * dv * way)[0, c] for side in (1.0, -1.0))
            found[k, c] = (down - up) / (2.0 * (dx + dv))
    largest = np.nan_to_num(found, nan=0.0).max(axis=1)
    return float(largest[0]), float(largest[1])

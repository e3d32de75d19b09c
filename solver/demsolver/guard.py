"""Tells when a run goes wrong, before its numbers are believed: on by default, Simulation(scene, on_instability="stop").

    speed    a particle moves more than FARTHEST of its radius in a step: it could pass through another unseen. Looked at in every step.
    overlap  a contact is deeper than DEEPEST of the smaller radius, or of how far a superquadric reaches from its centre along the normal: a centre
             may come to the wrong side. Looked at in every step.
    energy   the energy has grown by more than GROWTH of what kinetic and elastic energy there was, and nothing drives it. Every `every` steps.
    numbers  a position, velocity, spin, force or torque is no number any more. Every `every` steps, and wherever a list is made.
    place    positions are no finer than COARSEST of the smallest radius, so far from the origin: contacts are rounded away. Every `every` steps.

Speeds are those against walls and particles at rest, or, where there are none, against the mean of all: a gas that drifts as a whole is as good as
one at rest. While a particle moves half its radius in a step at most, two cannot change places without a step in which they overlap, and no centre
reaches a wall; that contact is then deep, or it is seen as any other.

Energy is kinetic, elastic and potential energy of gravity. It is not looked at where motion or a force is prescribed (a wall that moves, `setforce`,
`addforce`, particles that move and are integrated by nobody): there it may grow. The elastic part is asked for where it can matter: when kinetic and
potential energy alone are far from what the total was. `Simulation.look` looks at once, whatever is due: at the end of a run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from demsolver import neighbors
from demsolver.listed import Listed
from demsolver.scene import AddForce, Cylinder, Plane, Scene, SetForce, Wall
from demsolver.specialise import DEEPEST
from demsolver.stability_contacts import centred, contacts_in
from demsolver.state import Floats, Shaped, moved, shaped_of
from demsolver.superquadric.depths import pair_depth, plane_depths
from demsolver.trouble import Unstable

if TYPE_CHECKING:
    from demsolver.simulate import Simulation

OnInstability = Literal["stop", "warn", "off"]
FARTHEST = 0.5
_NONE = np.zeros(0, dtype=np.int64)
_NOBODY = Listed(_NONE, _NONE, _NONE, np.zeros(0, dtype=np.uint8), np.zeros((0, 0)))
GROWTH = 1.0
COARSEST = 1e-3
"""Of a radius. A contact is a hundredth deep, and in each of its steps a place is rounded."""
LEAST_EVERY, LOOK_COSTS = 1000, 20_000
"""A look costs about as much as one step of the particles there are, and as much as LOOK_COSTS steps of a single one."""
FORGETS = 0.9
"""Part of the energy scale that is left after a look: what a run once had says little of what it has now."""
VISIBLE = 0.5
"""Part of the energy scale by which kinetic and potential energy may differ from the known total before all of it is computed."""
ROUNDING = 1e-9
"""Of the magnitudes that the energy is the difference of."""


@dataclass(frozen=True)
class Good:
    """A state in which all was well. id: (n,) in no order; x, v, omega: (n, 3); image: (n, 3) periodic wraps; lo, hi: (3,) of the box."""

    step: int
    id: np.ndarray
    x: Floats
    v: Floats
    omega: Floats
    image: np.ndarray
    lo: Floats
    hi: Floats


@dataclass
class Guard:
    """The guard of one simulation. tell: called with one line for each kind of trouble, once, where the run is to go on ("warn")."""

    scene: Scene
    stops: bool
    tell: Callable[[str], object]
    good: Good | None = None
    _told: set[str] = field(default_factory=set)
    _floor: float = np.inf  # least total energy so far
    _total: float = np.inf  # the last that is known
    _scale: float = 0.0  # kinetic and elastic energy that there lately was
    _before: tuple[int, float] = (0, 0.0)
    _start: int = 0
    _next: int = 0

    def __post_init__(self) -> None:
        p = self.scene.particles
        self.every = max(LEAST_EVERY, LOOK_COSTS // max(1, len(p.id)))
        self.driven = _driven(self.scene)
        movers = moved(self.scene) & (p.radius > 0.0)
        still = bool(self.scene.walls) or not moved(self.scene).all()
        frame = np.zeros(3) if still or not len(p.id) else p.v.mean(axis=0)
        lonely = len(p.id) < 2 and not self.scene.walls
        limit = FARTHEST / self.scene.timestep if movers.any() and not lonely and self.scene.timestep > 0.0 else np.inf
        self._meets = bool(movers.any()) and not lonely
        self.numbers = np.array([limit, *frame, p.radius[movers].min() if movers.any() else 1.0, 1.0])
        """What the loop reads: speed over radius that is too fast, whose frame (3), the smallest radius, whether depth is looked at."""

    def steps_to_look(self, step: int) -> int:
        """From this step to the next look: soon at first, later every `every` steps."""
        return max(1, self._next - step)

    def begin(self, simulation: Simulation) -> None:
        """At a run that has been set up: speeds and overlaps. Raises Unstable where it is to stop."""
        self._start = self._next = simulation.step
        self._walls()
        self.suspect(simulation)

    def look(self, simulation: Simulation, *, now: bool = False) -> None:
        """At a state whose numbers are finite, when it is time or `now`: its energy. Keeps it as the last good one if all is well.

        Raises Unstable where the run is to stop."""
        step = simulation.step
        if step < self._next and not now:
            return
        self._place(simulation)
        self._next = step + min(self.every, max(LEAST_EVERY, step - self._start))
        if not self.driven:
            self._energy(simulation)
        if not self._told:
            self.good = simulation.here()

    def suspect(self, simulation: Simulation) -> None:
        """Looks at speeds and overlaps now. Raises Unstable where the run is to stop."""
        if self.numbers[0] < np.inf:
            self.too_fast(simulation)
        if self.numbers[5] != 0.0 and simulation.deep:
            self.too_deep(simulation)

    def sees(self, simulation: Simulation) -> bool:
        """Whether a speed or an overlap is to be told after the next step: where a list is due in every step, the loop never comes to say so."""
        return bool(self.numbers[5] != 0.0 and simulation.deep) or bool(self.numbers[0] < np.inf and (self._ways(simulation) > FARTHEST).any())

    def _ways(self, simulation: Simulation) -> Floats:
        """(n,) ways in a step over the radius, of those that move."""
        b = simulation.bodies
        moves = b.moving & (b.radius > 0.0)
        way = np.linalg.norm(b.v - self.numbers[1:4], axis=1) * self.scene.timestep
        return np.asarray(np.where(moves, way, 0.0) / np.where(moves, b.radius, 1.0))

    def too_fast(self, simulation: Simulation) -> None:
        """Says who moves too far in a step, if anybody does. Raises Unstable where the run is to stop."""
        dt, part = self.scene.timestep, self._ways(simulation)
        worst = int(np.argmax(part)) if len(part) else 0
        if not len(part) or part[worst] <= FARTHEST:
            return
        self.numbers[0] = np.inf
        self._say(
            "speed",
            f"particle {simulation.id[worst]} moves {part[worst]:.3g} of its radius in step {simulation.step} (limit {FARTHEST:g}) and could pass "
            f"through others unseen: shorten the timestep {dt:g} to {0.9 * dt * FARTHEST / part[worst]:.2g}, or look at what made it so fast",
        )

    def too_deep(self, simulation: Simulation) -> None:
        """Says whose contact is too deep. Raises Unstable where the run is to stop."""
        self.numbers[5] = 0.0
        overlap, who = deepest(simulation)
        found = f"{who} overlap by {overlap:.3g} of the smaller radius" if overlap > DEEPEST else "two that have parted since overlapped too far"
        self._say(
            "overlap",
            f"{found} in step {simulation.step} (limit {DEEPEST:g}): start them apart, make the contact stiffer, or shorten the timestep "
            f"{self.scene.timestep:g}",
        )

    def lost(self, simulation: Simulation) -> None:
        """Particles have left the box: whether for a reason that should be told. Raises Unstable where the run is to stop."""
        self.suspect(simulation)
        if not self.driven:
            self._energy(simulation)

    def _walls(self) -> None:
        """Says which wall moves too far in a step: as a particle that does, it could pass through others unseen."""
        smallest, dt = self.numbers[4], self.scene.timestep
        for wall in self.scene.walls if self._meets else ():
            if isinstance(wall.shape, Plane) and wall.shape.moving:
                shape = wall.shape
                arms = np.linalg.norm(self.scene.particles.x - np.array(shape.pivot), axis=1).max()
                way = dt * float(np.linalg.norm(shape.velocity) + np.linalg.norm(shape.omega) * arms)
                if way > FARTHEST * smallest:
                    self._say(
                        "speed of a wall",
                        f"wall {wall.name} moves {way / smallest:.3g} of the smallest radius in a step (limit {FARTHEST:g}) and could pass through "
                        f"particles unseen: shorten the timestep {dt:g} to {0.9 * dt * FARTHEST * smallest / way:.2g}",
                    )

    def _place(self, simulation: Simulation) -> None:
        """Says that positions are too coarse."""
        if not self._meets or not len(simulation.id):
            return
        grain = float(np.spacing(simulation.farthest()))
        if grain > COARSEST * self.numbers[4]:
            self._say(
                "place",
                f"so far from the origin positions are no finer than {grain / self.numbers[4]:.2g} of the smallest radius by step {simulation.step} "
                f"(limit {COARSEST:g}), and contacts are lost to rounding: move the scene nearer to the origin",
            )

    def forget_energy(self) -> None:
        """Particles have left, and their energy with them."""
        self._floor = self._total = np.inf

    def _energy(self, simulation: Simulation) -> None:
        kinetic, potential, weight = simulation.visible_energy()
        near = abs(kinetic + potential - self._total) <= VISIBLE * self._scale
        if self._total < np.inf and near:
            self._before, self._scale = (simulation.step, kinetic), max(FORGETS * self._scale, kinetic)
            return
        elastic = simulation.elastic_energy() if simulation.touches else 0.0
        total, lively = kinetic + elastic + potential, kinetic + abs(elastic)  # what sticks together has elastic energy below 0
        (step, before), grown = self._before, total - self._floor
        # What gravity has given since counts as energy that there was.
        limit = GROWTH * max(self._scale, lively - grown) + ROUNDING * (weight + lively)
        self._total = total
        self._before, self._floor, self._scale = (simulation.step, lively), min(self._floor, self._total), max(FORGETS * self._scale, lively)
        if grown > limit:
            fastest = int(simulation.id[np.argmax(np.sum(simulation.bodies.v**2, axis=1))])
            self._say(
                "energy",
                f"the energy grew by {grown:.3g} by step {simulation.step}, which is more than there was in step {step} ({before:.3g} kinetic "
                f"and elastic), and nothing drives it; the fastest is particle {fastest}: shorten the timestep {self.scene.timestep:g}",
            )

    def _say(self, kind: str, line: str) -> None:
        if self.stops:
            raise Unstable(line)
        if kind not in self._told:
            self._told.add(kind)
            self.tell(line)


def deepest(simulation: Simulation) -> tuple[float, str]:
    """The deepest contact now: its overlap over the smaller radius (of superquadrics as above), and who they are; -inf if nobody can touch."""
    b, pairs = simulation.bodies, simulation.pairs
    d = b.x[pairs.i] - b.x[pairs.j] - neighbors.SHIFTS[pairs.shift] * (simulation.box_hi - simulation.box_lo)
    shaped = shaped_of(b)
    radius, overlap = np.minimum(b.radius[pairs.i], b.radius[pairs.j]), b.radius[pairs.i] + b.radius[pairs.j] - np.linalg.norm(d, axis=1)
    part = _among_superquadrics(simulation.scene, shaped, pairs, d, overlap) if shaped else overlap / np.where(radius > 0.0, radius, np.nan)
    found, who = -np.inf, "nobody"
    if not np.isnan(part).all():
        worst = int(np.nanargmax(part))
        i, j = sorted(int(simulation.id[side[worst]]) for side in (pairs.i, pairs.j))
        found, who = float(part[worst]), f"particles {i} and {j}"
    contacts = contacts_in(simulation.scene, b, _NOBODY, simulation.box_hi - simulation.box_lo)
    at_wall = contacts.overlap / b.radius[contacts.i]
    if shaped:
        at_wall = plane_depths(shaped, contacts.i, contacts.n, b.radius[contacts.i] - contacts.overlap)
    if len(at_wall) and at_wall.max() > found:
        worst = int(np.argmax(at_wall))
        found, who = float(at_wall[worst]), f"particle {simulation.id[contacts.i[worst]]} and wall {simulation.scene.walls[contacts.law[worst]].name}"
    for number, wall in enumerate(simulation.scene.walls):
        if found < 1.0 and len(rows := centred(simulation.scene, number, b)):
            found, who = 1.0, f"particle {simulation.id[rows[0]]} and wall {wall.name}"
    return found, who


def _among_superquadrics(scene: Scene, b: Shaped, pairs: Listed, d: Floats, bound: Floats) -> Floats:
    """(m,) depths of listed pairs; bound: overlaps of their bounding spheres."""
    return np.array([pair_depth(scene, b, *who) if most > 0.0 else -np.inf for *who, most in zip(pairs.i, pairs.j, d, bound, strict=True)])


def _driven(scene: Scene) -> bool:
    """Whether something may do work on the particles of which no account is kept here."""
    stands = ~moved(scene)
    return (
        any(_moves(wall) for wall in scene.walls)
        or any(isinstance(force, SetForce | AddForce) for force in scene.forces)
        or bool(scene.particles.v[stands].any() or scene.particles.omega[stands].any())
    )


def _moves(wall: Wall) -> bool:
    shape = wall.shape
    turns = isinstance(shape, Cylinder) and shape.rotation is not None
    return any(wall.velocity) or turns or (isinstance(shape, Plane) and shape.moving)

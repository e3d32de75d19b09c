"""Simulation(scene).advance(n): the scene in motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demsolver import contact, neighbors
from demsolver.bind_law import coefficient_table, memory_signs
from demsolver.bind_walls import PLACE, wall_geometry
from demsolver.check import check_scene
from demsolver.scene import Box, Gravity, Particles, Plane, Scene, SetForce, Viscous, Wall
from demsolver.specialise import BUDGET_COLUMNS, implicit, shifting, specialise
from demsolver.state import Bodies, Floats, Ints, Pairs, bodies_of, inertia_of, selected

_SAID = {"x": "positions", "v": "velocities", "omega": "spins", "force": "forces", "torque": "torques"}
BEGIN, MIDDLE, SETUP = 0, 1, 2  # where kernel.run_steps starts
NOT_SOLVED = -2  # what an implicit step may answer; else -1: out of the list


class LostParticles(RuntimeError):
    """Particles left the box through a fixed face, or went off to infinity."""


class Unstable(RuntimeError):
    """A position, velocity or force became infinite or NaN."""


@dataclass(frozen=True)
class EnergyBudget:
    """Where the energy is, in units of the deck. Work taken out is positive.

    kinetic, rotational: of all particles. elastic_normal (cohesion included), elastic_tangential, elastic_rolling: in the contacts.
    gravitational: -sum m g.x, of unwrapped positions, relative to the origin. damped, rubbed, rolled, dragged: taken since the start by normal
    damping, by the tangential forces (their damping and their slip), by rolling and twisting torques, and by viscous drag, all of motion
    against the surface that is touched. driven: given by walls that move. `total`, held plus taken less given, is what must stay put.
    """

    kinetic: float
    rotational: float
    elastic_normal: float
    elastic_tangential: float
    elastic_rolling: float
    gravitational: float
    damped: float
    rubbed: float
    rolled: float
    dragged: float
    driven: float

    @property
    def elastic(self) -> float:
        """What the contacts store."""
        return self.elastic_normal + self.elastic_tangential + self.elastic_rolling

    @property
    def mechanical(self) -> float:
        """What the scene holds now."""
        return self.kinetic + self.rotational + self.elastic + self.gravitational

    @property
    def total(self) -> float:
        """What it holds plus what it lost, less what it was given."""
        return self.mechanical + self.damped + self.rubbed + self.rolled + self.dragged - self.driven


class Simulation:
    """A scene in motion.

    `setup()` computes the forces of the current state with full-step velocities and leaves histories alone, as the engines do at
    every `run`; `advance(n)` runs n steps. Scenes with step laws or implicit laws run on one thread. `budget=True` also keeps the
    account of dissipated energy, `virial=True` the virial of the pairs.
    """

    def __init__(self, scene: Scene, *, threads: int = 1, budget: bool = False, virial: bool = False) -> None:
        check_scene(scene)
        self.scene = scene
        self.step = 0
        self.box_lo, self.box_hi = np.array(scene.box.lo, dtype=float), np.array(scene.box.hi, dtype=float)
        self.image: Ints = np.array(scene.particles.image, dtype=np.int64)
        self.id: Ints = np.array(scene.particles.id, dtype=np.int64)
        self._budget = budget
        self.virial = virial
        aside = shifting(scene) or implicit(scene)
        threads = 1 if aside else threads  # what is set aside is summed in one array
        self._threads = threads
        self._kernel = specialise(scene, threads, budget=budget, virial=virial)
        self._extra = BUDGET_COLUMNS if budget else 0
        self._signs = memory_signs(scene.pair)
        self._columns = len(self._signs) + self._extra
        self.bodies: Bodies = bodies_of(scene, aside=aside)
        self.pairs: Pairs = neighbors.empty_pairs(len(self.id), self._columns)
        self._walls = tuple(self._wall_arrays(wall) for wall in scene.walls)
        self._fields = self._field_arrays()
        self._coefficients = coefficient_table(scene.pair) if scene.pair else np.zeros((1, 1))
        self._parts = np.zeros((threads, 2, len(self.id) if threads > 1 else 0, 3))
        self._tallies = np.zeros((threads, 6))
        self._age = 0
        self._margin = 1e-4 * (self.box_hi - self.box_lo) if scene.box.margin is None else scene.box.margin

    def setup(self) -> None:
        """Wraps, rebuilds the list, and computes forces with the velocities as they are, without growing any history."""
        self._relist()
        self._run(SETUP, 0)
        self._check_finite()

    def advance(self, steps: int) -> None:
        """Runs `steps` steps. Raises Unstable or LostParticles."""
        done, due = self._run(BEGIN, steps)
        while due:
            self._relist()
            more, due = self._run(MIDDLE, steps - done)
            done += more
        self._check_finite()

    def energy_budget(self) -> EnergyBudget:
        """The account of energy now; needs budget=True."""
        if not self._budget:
            message = "the energy budget was not kept: make the Simulation with budget=True"
            raise ValueError(message)
        b = self.bodies
        normal, tangential, rolling = self._kernel.stored(
            b, self.pairs, self._shifts(), self._coefficients, self.scene.ntypes, self._walls, self.scene.timestep
        )
        spent = -self._tallies.sum(axis=0)
        return EnergyBudget(
            kinetic=0.5 * float(np.sum(b.mass * np.sum(b.v**2, axis=1))),
            rotational=0.5 * float(np.sum(inertia_of(self._now()) * np.sum(b.omega**2, axis=1))),
            elastic_normal=normal,
            elastic_tangential=tangential,
            elastic_rolling=rolling,
            gravitational=self._gravitational(),
            damped=float(spent[0]),
            rubbed=float(spent[1]) - tangential,
            rolled=float(spent[4]) - rolling,
            dragged=float(spent[2]),
            driven=-float(spent[5]),
        )

    def pair_virial(self) -> float:
        """Sum of r.F over the pairs at the last force evaluation; needs virial=True."""
        if not self.virial:
            message = "the virial was not kept: make the Simulation with virial=True"
            raise ValueError(message)
        return float(self._tallies[:, 3].sum())

    def _now(self) -> Scene:
        return replace(self.scene, particles=self.particles())

    def particles(self) -> Particles:
        """The particles as they are now."""
        b = self.bodies
        return Particles(
            id=self.id.copy(), type=b.kind + 1, x=b.x.copy(), v=b.v.copy(), omega=b.omega.copy(), radius=b.radius.copy(),
            mass=b.mass.copy(), mask=b.mask.copy(), image=self.image.copy(),
        )  # fmt: skip

    def box(self) -> Box:
        """The box as it is now: shrink-wrapped faces follow the particles at every list rebuild."""
        return Box(self.box_lo.copy(), self.box_hi.copy(), self.scene.box.boundary, self._margin)

    def continue_with(self, scene: Scene, *, virial: bool | None = None) -> Simulation:
        """The next run of a deck: `scene` holds changed settings and the present particles; contact histories go on where the same
        particles touch under a law of the same name, and a plane whose words are the same goes on from where it is. virial: None to leave
        it as it is."""
        virial = self.virial if virial is None else virial
        other = Simulation(scene, threads=self._threads, budget=self._budget, virial=virial)
        other.step = self.step
        if len(other.id) == len(self.id) and np.array_equal(other.id, self.id) and _same_law(scene, self.scene):
            other.pairs = self.pairs
            other._tallies[0] = self._tallies.sum(axis=0)
        kept = {wall.name: (wall, arrays) for wall, arrays in zip(self.scene.walls, self._walls, strict=True)}
        for wall, (geometry, _, _, memory, touching) in zip(scene.walls, other._walls, strict=True):
            if wall.name not in kept:
                continue
            old, (old_geometry, _, _, old_memory, old_touching) = kept[wall.name]
            if isinstance(wall.shape, Plane) and wall.shape == old.shape:
                geometry[PLACE] = old_geometry[PLACE]
            if old_memory.shape == memory.shape:
                memory[:], touching[:] = old_memory, old_touching
        return other

    def _rhythm(self) -> tuple[int, int, bool, float]:
        n = self.scene.neighbor
        return n.every, n.delay, n.check, (0.5 * n.skin) ** 2

    def _shifts(self) -> Floats:
        shifts: Floats = neighbors.SHIFTS * (self.box_hi - self.box_lo)
        return shifts

    def _run(self, start: int, steps: int) -> tuple[int, bool]:
        done, self._age, due = self._kernel.run_steps(
            start, steps, self._age, self._rhythm(), self.bodies, self.pairs, self._shifts(), self._coefficients, self.scene.ntypes,
            self._walls, self._fields, self.scene.timestep, self._parts, self._tallies,
        )  # fmt: skip
        if done < 0:
            raise Unstable(self._refused(done))
        self.step += done
        return done, due

    def _refused(self, code: int) -> str:
        if code == NOT_SOLVED:
            return f"the contacts of step {self.step + 1} could not be solved together: shorten the timestep {self.scene.timestep:g}"
        return (
            f"a particle moves more than half the skin {self.scene.neighbor.skin:g} of the neighbour list in step {self.step + 1}: "
            f"make the skin longer, or shorten the timestep {self.scene.timestep:g}"
        )

    def _relist(self) -> None:
        """What the engines do when the list is due: wrap, shrink the box, drop the lost, list the pairs, carry their memory."""
        self._check_finite("x")
        wraps = neighbors.wrap(self.bodies.x, self.box_lo, self.box_hi, self.scene.box.periodic)
        self.image += wraps
        self._shrink()
        self._check_lost()
        self.bodies.held[:] = self.bodies.x
        self._age = 0
        if self.scene.pair:
            old, self.pairs = self.pairs, neighbors.build(self.scene, self.bodies, self.box_lo, self.box_hi, self._columns)
            neighbors.carry(old, self.pairs, wraps, self.scene.history_outlives_contact, self._signs, self.bodies, self._shifts())

    def _check_finite(self, *names: str) -> None:
        """Raises Unstable; looks at everything that moves, or only at `names`."""
        for name in names or ("x", "v", "omega", "force", "torque"):
            if not np.isfinite(getattr(self.bodies, name)).all():
                message = (
                    f"{_SAID[name]} became infinite by step {self.step}: the timestep {self.scene.timestep:g} is too long, "
                    "or particles overlap too far"
                )
                raise Unstable(message)

    def _shrink(self) -> None:
        x = self.bodies.x
        for axis, faces in enumerate(self.scene.box.boundary):
            if not len(x):
                return
            low, high = float(x[:, axis].min()) - self._margin[axis], float(x[:, axis].max()) + self._margin[axis]
            first, second = faces[0], faces[1]
            if first in "sm":
                self.box_lo[axis] = low if first == "s" else min(low, self.scene.box.lo[axis])
            if second in "sm":
                self.box_hi[axis] = high if second == "s" else max(high, self.scene.box.hi[axis])

    def _check_lost(self) -> None:
        x = self.bodies.x
        gone = np.zeros(len(x), dtype=bool)
        for axis, faces in enumerate(self.scene.box.boundary):
            if faces[0] == "f":
                gone |= x[:, axis] < self.box_lo[axis]
            if faces[1] == "f":
                gone |= x[:, axis] >= self.box_hi[axis]
        if gone.any():
            if self.scene.lost == "error":
                message = f"{int(gone.sum())} particles left the box by step {self.step}, the first with id {int(self.id[gone].min())}"
                raise LostParticles(message)
            self._delete(gone)

    def _delete(self, gone: np.ndarray) -> None:
        keep = ~gone
        self.bodies = Bodies(*(np.ascontiguousarray(array[keep] if len(array) else array) for array in self.bodies))
        self.id, self.image = self.id[keep], self.image[keep]
        self._walls = tuple((g, bit, c, memory[keep], touching[keep]) for g, bit, c, memory, touching in self._walls)
        numbers, bits, gammas, drag = self._fields
        self._fields = (numbers, bits, gammas, np.ascontiguousarray(drag[:, keep]))
        if self._threads > 1:
            self._parts = np.zeros((self._threads, 2, len(self.id), 3))
        self.pairs = _without(self.pairs, keep)

    def _wall_arrays(self, wall: Wall) -> tuple[Floats, int, Floats, Floats, np.ndarray]:
        n, columns = len(self.id), len(memory_signs(wall.law)) + self._extra
        return wall_geometry(wall), wall.bit, coefficient_table(wall.law), np.zeros((n, columns)), np.zeros(n, dtype=np.uint8)

    def _field_arrays(self) -> tuple[Floats, Ints, Floats, Floats]:
        forces = self.scene.forces
        drags = [f for f in forces if isinstance(f, Viscous)]
        return (
            np.array([_field_numbers(f) for f in forces]).reshape(-1, 3),
            np.array([f.bit for f in forces], dtype=np.int64),
            np.array([d.gamma for d in drags], dtype=float).reshape(len(drags), self.scene.ntypes if drags else 0),
            np.zeros((len(drags), len(self.id), 3)),
        )

    def _gravitational(self) -> float:
        b = self.bodies
        unwrapped = b.x + self.image * (self.box_hi - self.box_lo)
        fields = [f for f in self.scene.forces if isinstance(f, Gravity)]
        moving = b.drift > 0.0
        return -sum(
            float(np.sum((b.mass * (unwrapped @ np.array(f.acceleration)))[selected(b.mask, f.bit) & moving & ~b.frozen])) for f in fields
        )


def _field_numbers(force: object) -> tuple[float, float, float]:
    if isinstance(force, Gravity):
        return force.acceleration
    if isinstance(force, SetForce):
        x, y, z = (0.0 if c is None else c for c in force.force)
        return x, y, z
    return 0.0, 0.0, 0.0


def _same_law(a: Scene, b: Scene) -> bool:
    """Whether the contacts of one scene mean the same in the other: laws that remember the same."""
    if a.pair is None or b.pair is None:
        return a.pair is b.pair
    return all(getattr(a.pair, family) == getattr(b.pair, family) for family in contact.REMEMBERING)


def _without(pairs: Pairs, keep: np.ndarray) -> Pairs:
    """The list without the particles that are gone, rows renumbered."""
    number = np.cumsum(keep) - 1
    row = np.repeat(np.arange(len(keep)), np.diff(pairs.first))
    kept = keep[row] & keep[pairs.partner]
    counts = np.bincount(row[kept], minlength=len(keep))[keep]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return Pairs(first, number[pairs.partner[kept]], pairs.shift[kept], pairs.touching[kept], np.ascontiguousarray(pairs.memory[kept]))

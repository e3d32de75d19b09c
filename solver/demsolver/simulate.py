"""Simulation(scene).advance(n): the scene in motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal
from warnings import warn

import numpy as np
from numpy.typing import NDArray

from demsolver import memories, neighbors
from demsolver.bind_law import memory_signs
from demsolver.bind_scene import field_arrays, pair_coefficients, wall_arrays
from demsolver.bind_walls import PLACE
from demsolver.check import check_scene
from demsolver.guard import Guard, OnInstability
from demsolver.listed import without
from demsolver.memories import Memories
from demsolver.near import START_LEEWAY, near_of
from demsolver.neighbor_grid import bounds_of
from demsolver.observe import ACCOUNT, LOST_POINTS, TALLIES, Observed
from demsolver.scene import NveClumps, Plane, Scene
from demsolver.sleep import Sleep, Sleepers, check_sleep
from demsolver.specialise import CHUNK, GEOMETRY, compiling, features, specialise
from demsolver.state import Bodies, Floats, Ints, Pairs, Rigid, bodies_of, clumped_of, flat_of, movers_first, of_each, placed, rigid_of
from demsolver.threads import use_threads
from demsolver.trouble import LostParticles, Unstable, check_finite, check_flight, lost_points, refused

SORT_FROM = CHUNK
"""Fewer particles than this fit a core's cache in any order."""
SORT_EVERY = 24
"""Lists between two sortings: neighbours drift apart slowly."""
BEGIN, MIDDLE, SETUP = 0, 1, 2  # where kernel.run_steps starts
DUE, TOO_FAST, TOO_DEEP = 1, 2, 3  # why it ends before its steps are done
UNGUARDED = np.array([np.inf, 0.0, 0.0, 0.0, 1.0, 0.0])


Precision = Literal["double", "mixed"]


class Simulation(Observed):
    """A scene in motion.

    `setup()` computes the forces of the current state with full-step velocities and leaves histories alone, as the engines do at
    every `run`; `advance(n)` runs n steps. Results are the same bits for any number of threads; scenes with step laws or implicit laws, and
    those too small to share out (specialise.CHUNK), run on one. `budget=True` also keeps the account of dissipated energy, `virial=True` the
    virial of the pairs. precision "mixed" takes the vector between two particles, their velocities against each other and the force between
    them as float32; positions, velocities, sums and memories stay float64. sleep: leaves islands at rest out of the steps (sleep.py states the
    error); everybody wakes in `continue_with`. on_instability: what a guard does that finds the run going wrong (guard.py): "stop" raises
    Unstable, "warn" calls `tell` with one line for each kind of trouble and goes on, "off" does not look, but for what is no number.

    Inside, particles stand in rows of their own order, sorted in space. Outside they stand in the scene's: `bodies`, `pairs`, `image` and
    `particles()` are copies, made when asked for. id: (n,), of the particles that are left.
    """

    def __init__(
        self, scene: Scene, *, threads: int = 1, budget: bool = False, virial: bool = False, precision: Precision = "double",
        sleep: Sleep | None = None, on_instability: OnInstability = "stop", tell: Callable[[str], object] = warn,
    ) -> None:  # fmt: skip
        check_scene(scene)
        if sleep:
            check_sleep(sleep, scene, books=budget or virial)
        self.scene = scene
        self.step = 0
        self.box_lo, self.box_hi = np.array(scene.box.lo, dtype=float), np.array(scene.box.hi, dtype=float)
        self.id: Ints = np.asarray(scene.particles.id, dtype=np.int64)
        self.virial = virial
        self._budget, self._precision = budget, precision
        self._has = features(scene, threads, budget=budget, virial=virial, sleeps=sleep is not None, guard=on_instability != "off")
        self._on_instability: OnInstability = on_instability
        self._guard = Guard(scene, on_instability == "stop", tell) if on_instability != "off" else None
        self._asked, self._threads = threads, threads if self._has.THREADED else 1
        self._kernel = specialise(scene, self._has)
        self._extra = self._has.BOOKS if budget else 0
        self._columns = neighbors.columns_of(memory_signs(scene.pair), self._extra, GEOMETRY if self._has.SHAPES else 0)
        self._order: Ints = np.arange(len(self.id))
        self._image: NDArray[np.int32] = np.array(scene.particles.image, dtype=np.int32)
        aside = self._has.SHIFTING or self._has.IMPLICIT
        self._bodies: Bodies = bodies_of(scene, aside=aside, rotates=self._has.ROTATES, uniform=self._has.UNIFORM)
        self._still: Floats = np.array(scene.particles.omega[: 0 if self._has.ROTATES else len(self.id)], dtype=float)
        self._walls = tuple(wall_arrays(wall, len(self.id), self._extra) for wall in scene.walls)
        self._fields = field_arrays(scene)
        self._coefficients = pair_coefficients(scene, one=self._has.ONE_LAW)
        self._equal = (float(scene.particles.radius[0]), float(scene.particles.mass[0])) if self._has.UNIFORM else (0.0, 0.0)
        self._tallies = np.zeros((0, TALLIES))
        self._scale = np.array([scene.particles.radius.mean() if len(self.id) else 0.0, 0.0, START_LEEWAY])
        self._rigid: Rigid = rigid_of(scene)
        placed(self._rigid, self._bodies)
        self._movers = int(self._bodies.moving.sum())
        self._carried = len(self._rigid.member) if any(isinstance(one, NveClumps) for one in scene.integrate) else 0
        self._sleepers = Sleepers(sleep, len(self.id)) if sleep else None
        self._unseen: dict[bool, neighbors.Unseen] = {}  # by whether two frozen particles see each other
        self._sort(movers_first(self._bodies, np.arange(len(self.id))))
        self._allot(neighbors.empty_pairs(len(self.id), len(self._columns.sign)))
        self._age = self._lists = 0
        self._margin = 1e-4 * (self.box_hi - self.box_lo) if scene.box.margin is None else scene.box.margin

    def setup(self) -> None:
        """Wraps, rebuilds the list, and computes forces with the velocities as they are, without growing any history."""
        with compiling():
            self._relist()
            self._run(SETUP, 0)
        if self._guard:
            self._guard.begin(self)
        self._look()

    def advance(self, steps: int) -> None:
        """Runs `steps` steps. Raises Unstable or LostParticles."""
        if self._sleepers is None:
            self._advance(steps)
            return
        while steps > 0:
            portion = min(steps, self._sleepers.steps_to_look(self.step))
            self._advance(portion)
            steps -= portion
            if self.step % self._sleepers.sleep.every == 0:
                touching = [wall[-1] for wall in self._walls]
                if self._sleepers.look(self._bodies, self._pairs, touching, self.scene.timestep):
                    self._relist()

    def _advance(self, steps: int) -> None:
        while steps > 0:
            portion = steps if self._guard is None else min(steps, self._guard.steps_to_look(self.step))
            steps -= self._stretch(portion)
            self._look()

    def _stretch(self, steps: int) -> int:
        """At most so many steps; returns how many: fewer where the guard has something to say."""
        done, why = self._run(BEGIN, steps)
        while why == DUE:
            self._relist()
            more, why = self._run(MIDDLE, 1 if self._guard and self._guard.sees(self) else steps - done)
            done += more
        if self._guard and why == TOO_FAST:
            self._guard.too_fast(self)
        elif self._guard and why == TOO_DEEP:
            self._guard.too_deep(self)
        return done

    def look(self) -> None:
        """Has the guard look at the state now, whether it is time or not: at the end of a run. Raises Unstable."""
        self._check()
        if self._guard:
            self._guard.look(self, now=True)

    def _look(self) -> None:
        self._check()
        if self._guard:
            self._guard.look(self)

    def _check(self) -> None:
        check_finite(self._bodies, self.step, self.scene)
        if lost := int(self._tallies[:, LOST_POINTS].sum()):
            raise Unstable(lost_points(lost, self.step, self.scene))

    def continue_with(self, scene: Scene, *, virial: bool | None = None) -> Simulation:
        """The next run of a deck: `scene` holds changed settings and the present particles; contact histories go on where the same
        particles touch under a law of the same name, and a plane whose words are the same goes on from where it is. virial: None to leave
        it as it is."""
        virial = self.virial if virial is None else virial
        sleep = None
        if self._sleepers:
            sleep = self._sleepers.sleep
            if self._sleepers.wake_all(self._bodies):  # whatever has changed, they may feel it
                self._relist()
        other = Simulation(
            scene, threads=self._asked, budget=self._budget, virial=virial, precision=self._precision, sleep=sleep,
            on_instability=self._on_instability, tell=self._guard.tell if self._guard else warn,
        )  # fmt: skip
        other.step = self.step
        if not np.array_equal(other.id, self.id):
            return other
        rows = np.argsort(other._order)[self._order]
        alike = np.array_equal(movers_first(other._bodies, rows), rows)  # else others move now, and stand elsewhere
        if not alike:
            other._take_up(self.memories())
        else:
            other._sort(rows)
            if memories.same_law(scene, self.scene):
                other._allot(self._pairs)
                other._tallies[0, :ACCOUNT] = self._account()
        kept = {wall.name: (wall, arrays) for wall, arrays in zip(self.scene.walls, self._walls, strict=True)}
        for wall, (geometry, _, _, memory, touching) in zip(scene.walls, other._walls, strict=True):
            if wall.name not in kept:
                continue
            old, (old_geometry, _, _, old_memory, old_touching) = kept[wall.name]
            if isinstance(wall.shape, Plane) and wall.shape == old.shape:
                geometry[PLACE] = old_geometry[PLACE]
            if alike and old_memory.shape == memory.shape:
                memory[:], touching[:] = old_memory, old_touching
        return other

    def memories(self) -> Memories:
        """What the contacts remember now, by the ids of the particles: copies."""
        rows = self.id[self._order]
        walls = memories.walls_remembered(self.scene.walls, self._walls, self._order)
        return Memories(
            self.id.copy(), rows, memories.remembering(self.scene.pair), *memories.pairs_remembered(self._pairs, rows), walls,
            self._account(),
        )  # fmt: skip

    def recall(self, found: Memories) -> None:
        """Takes up what contacts remembered, before the first `setup`: of the particles and walls that are there, walls by name. With the
        particles as they were then, the motion goes on to the last bit as if the simulation had been continued.

        Raises ValueError naming the wall, or the pairs, whose laws are not those that remembered."""
        memories.check_laws(found, self.scene)
        self._take_up(found)

    def _take_up(self, found: Memories) -> None:
        """The order of rows, as far as those that move now still stand first, and memories of laws that are the same."""
        self._sort(movers_first(self._bodies, memories.rows_as_then(found, self.id, self._order)))
        rows = self.id[self._order]
        if found.laws == memories.remembering(self.scene.pair):
            self._allot(memories.pairs_recalled(found, rows, self._columns, periodic=any(self.scene.box.periodic)))
            self._tallies[0, :ACCOUNT] = found.tally
        memories.recall_walls(found, self.scene.walls, self._walls, rows, self._extra)

    def _rhythm(self) -> tuple[int, int, bool, float]:
        n = self.scene.neighbor
        return n.every, n.delay, n.check, (0.5 * n.skin) ** 2

    def _run(self, start: int, steps: int) -> tuple[int, int]:
        use_threads(self._threads)
        done, self._age, why = self._kernel.run_steps(
            start, steps, self._age, self._rhythm(), self._bodies, flat_of(self._bodies), self._movers - self._carried,
            self._movers, self._rigid if self._has.CLUMPS else (), self._pairs, self._near, self._shifts(),
            self._equal, self._coefficients, self.scene.ntypes, self._flat_walls(), self._fields, self.scene.timestep, self._tallies, self._paces,
            self._guard.numbers if self._guard else UNGUARDED,
        )  # fmt: skip
        if done < 0:
            raise Unstable(refused(done, self.step, self.scene))
        self.step += done
        return done, why

    def _relist(self) -> None:
        """What the engines do when the list is due: wrap, shrink the box, drop the lost, list the pairs, carry their memory."""
        check_finite(self._bodies, self.step, self.scene, "x")
        b = self._bodies
        low, high = bounds_of(b.x)
        if self.step > 0:
            check_flight(low, high, self.box_lo, self.box_hi, self.step, self.scene)
        wraps = neighbors.wrap(b.x, self.box_lo, self.box_hi, self.scene.box.periodic)
        self._image += wraps
        self._rigid.home[:] -= wraps[self._rigid.member] * (self.box_hi - self.box_lo)
        self._shrink(low, high)
        wraps = self._without_lost(wraps)
        self._age = 0
        if self._has.PAIRS:
            columns = self._pairs.memory.shape[1]
            old = neighbors.remembered(self._pairs, self._threads)
            del self._pairs, self._near  # the old list makes room
            keep_frozen = self.virial or self._budget or (columns > 0 and neighbors.frozen_remember(old, b))
            place, b = self._resort(), self._bodies
            if keep_frozen not in self._unseen:
                members = clumped_of(b)
                clump = members.clump if members else None
                self._unseen[keep_frozen] = neighbors.exclusions(self.scene, b.mask, b.kind, None if keep_frozen else b.frozen, clump)
            new = neighbors.build(self.scene, b, self.box_lo, self.box_hi, columns, self._unseen[keep_frozen], self._threads)
            neighbors.carry(old, new, wraps, self.scene.history_outlives_contact, self._columns, b, self._shifts(), place, self._threads)
            del old
            self._allot(new)
            if self._sleepers and self._sleepers.wake(self._bodies, new):
                self._relist()
        self._bodies.held[:] = self._bodies.x

    def _resort(self) -> Ints:
        """Every so many lists, sorts the rows in space. Returns (n,) where each row stands now, (0,) when they are as they were."""
        n, b = len(self.id), self._bodies
        movers = int(b.moving.sum())
        self._lists += 1
        if movers == self._movers and (n <= SORT_FROM or self._lists % SORT_EVERY != 1):
            return np.zeros(0, dtype=np.int64)
        self._movers = movers
        rows = movers_first(b, neighbors.morton_order(b.x, bounds_of(b.x)[0], 2.0 * float(b.radius.max())))
        self._sort(rows)
        place = np.empty(n, dtype=np.int64)
        place[rows] = np.arange(n)
        return place

    def _sort(self, rows: Ints) -> None:
        """Row k becomes what row rows[k] was."""
        n = len(self.id)
        if len(rows) == n:  # in place: no second copy of everything
            for array in self._bodies:
                if len(array) == n:
                    array[:] = array[rows]
        else:
            self._bodies = of_each(self._bodies, lambda array: array[rows] if len(array) == n else array)
        self._image, self._order = self._image[rows], self._order[rows]
        self._unseen.clear()
        place = np.zeros(n, dtype=np.int64)
        place[rows] = np.arange(len(rows))
        self._rigid.member[:] = place[self._rigid.member]
        if self._sleepers:
            self._sleepers.sort(rows)
        self._walls = tuple((g, bit, c, memory[rows], touching[rows]) for g, bit, c, memory, touching in self._walls)
        numbers, bits, gammas, drag = self._fields
        self._fields = (numbers, bits, gammas, np.ascontiguousarray(drag[:, rows]))

    def _allot(self, pairs: Pairs) -> None:
        """The arrays that go with a list of pairs."""
        self._pairs = pairs
        self._near = near_of(
            pairs, self._scale, self._has.CHUNK, self._threads,
            turns=self._has.FRICTION or self._has.ROLLING, mixed=self._precision == "mixed",
        )  # fmt: skip
        chunks = len(self._near.chunks)
        if len(self._tallies) != chunks:
            spent = self._tallies.sum(axis=0)
            self._tallies, self._paces = np.zeros((chunks, TALLIES)), np.zeros(chunks)
            self._tallies[0] = spent

    def _shrink(self, lows: Floats, highs: Floats) -> None:
        """Fits faces that follow the particles; lows, highs: (3,) outermost coordinates, which wrapping has not changed on such axes."""
        if not len(self._bodies.x):
            return
        for axis, faces in enumerate(self.scene.box.boundary):
            low, high = float(lows[axis]) - self._margin[axis], float(highs[axis]) + self._margin[axis]
            first, second = faces[0], faces[1]
            if first in "sm":
                self.box_lo[axis] = low if first == "s" else min(low, self.scene.box.lo[axis])
            if second in "sm":
                self.box_hi[axis] = high if second == "s" else max(high, self.scene.box.hi[axis])

    def _without_lost(self, wraps: neighbors.Wraps) -> neighbors.Wraps:
        """Drops what left through a fixed face, or raises LostParticles. Returns the rows of wraps (n, 3) that stayed."""
        x = self._bodies.x
        gone = np.zeros(len(x), dtype=bool)
        for axis, faces in enumerate(self.scene.box.boundary):
            if faces[0] == "f":
                gone |= x[:, axis] < self.box_lo[axis]
            if faces[1] == "f":
                gone |= x[:, axis] >= self.box_hi[axis]
        if gone.any():
            if self._guard:
                self._guard.lost(self)
            members = clumped_of(self._bodies)
            clumped = members.clump[gone] >= 0 if members else np.zeros(0, dtype=bool)
            if self.scene.lost == "error" or clumped.any():  # no clump goes on without a member
                first = int(self.id[self._order[gone]].min())
                message = f"{int(gone.sum())} particles left the box by step {self.step}, the first with id {first}"
                raise LostParticles(message)
            self._delete(~gone)
            if self._guard:
                self._guard.forget_energy()
            return wraps[~gone]
        return wraps

    def _delete(self, keep: np.ndarray) -> None:
        stays = np.zeros(len(self.id), dtype=bool)
        stays[self._order[keep]] = True
        pairs = without(self._pairs, keep)
        self._sort(np.flatnonzero(keep))
        self.id = self.id[stays]
        self._still = self._still[stays] if len(self._still) else self._still
        self._order = (np.cumsum(stays) - 1)[self._order]
        self._movers = int(self._bodies.moving.sum())
        self._allot(pairs)

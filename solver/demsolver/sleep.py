"""Islands at rest, left out of the steps until something comes near. Off unless asked for: Simulation(scene, sleep=Sleep(speed)).

An island is what hangs together by the neighbour list. It falls asleep when all of its particles were at rest at two looks in a row: slower
than `speed`, spin times radius too, touching something, and under no force that would make them faster by the next look. Its velocities
become zero then, its net forces count as zero, and no step does its pairs; what its contacts remember stays. It wakes, all of it, when the neighbour
list pairs one of its particles with one that is awake, which is before they touch.

The error: an island that falls asleep loses less than 0.7 m speed^2 of energy for each particle, and a particle that would have crept on is out of
place by less than speed times the time asleep. Contacts wake with the forces they fell asleep with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import Plane, Scene
from demsolver.specialise import implicit, shifting
from demsolver.state import Bodies, Ints, Pairs

Flags = NDArray[np.bool_]
LOOKS = 2
"""Looks in a row at which an island must be at rest: a particle is slow for a moment wherever it turns round."""


@dataclass(frozen=True)
class Sleep:
    """speed: below which a particle is at rest, length over time. every: steps between two looks."""

    speed: float
    every: int = 100


def check_sleep(sleep: Sleep, scene: Scene, *, books: bool) -> None:
    """Raises ValueError for what cannot be left out of the steps. books: whether the energy budget or the virial is kept."""
    message = ""
    if not (np.isfinite(sleep.speed) and sleep.speed > 0.0 and sleep.every > 0):
        message = f"sleep needs a speed above 0 and steps between looks, not speed {sleep.speed:g} every {sleep.every}"
    elif books:
        message = "the energy budget and the virial need every contact in every step: not with sleep"
    elif scene.particles.superquadrics is not None or scene.particles.clumps is not None:
        message = "superquadrics and clumps do not sleep"
    elif shifting(scene) or implicit(scene):
        message = "step laws and implicit laws need every contact in every step: not with sleep"
    elif moving := [wall.name for wall in scene.walls if isinstance(wall.shape, Plane) and wall.shape.moving]:
        message = f"wall {moving[0]} moves, and would not wake what it comes to: not with sleep"
    if message:
        raise ValueError(message)


class Sleepers:
    """Who sleeps, by row. asleep: (n,). looks: (n,) at how many looks in a row a particle was at rest."""

    def __init__(self, sleep: Sleep, n: int) -> None:
        """All are awake."""
        self.sleep = sleep
        self.asleep: Flags = np.zeros(n, dtype=bool)
        self.looks: Ints = np.zeros(n, dtype=np.int64)

    def sort(self, rows: Ints) -> None:
        """Row k becomes what row rows[k] was."""
        self.asleep, self.looks = self.asleep[rows], self.looks[rows]

    def steps_to_look(self, step: int) -> int:
        """Steps to the next look."""
        return self.sleep.every - step % self.sleep.every

    def look(self, b: Bodies, pairs: Pairs, wall_touching: list[NDArray[np.uint8]], dt: float) -> bool:
        """Puts islands at rest to sleep: nothing moves them. Returns whether any fell asleep."""
        self.looks = np.where(at_rest(b, pairs, wall_touching, self.sleep, dt), self.looks + 1, 0)
        restless = b.moving & (self.looks < LOOKS)
        island = islands(pairs, b.moving)
        tired = b.moving & ~np.isin(island, island[restless])
        for array in (b.v, b.omega):
            array[tired[: len(array)]] = 0.0
        b.moving[tired] = False
        self.asleep |= tired
        return bool(tired.any())

    def wake(self, b: Bodies, pairs: Pairs) -> bool:
        """Wakes islands that the list pairs with one that moves. Returns whether any woke."""
        row, partner = pairs.row, pairs.partner
        called = np.concatenate([row[self.asleep[row] & b.moving[partner]], partner[self.asleep[partner] & b.moving[row]]])
        if not len(called):
            return False
        island = islands(pairs, self.asleep)
        self._rouse(b, self.asleep & np.isin(island, island[called]))
        return True

    def wake_all(self, b: Bodies) -> bool:
        """Returns whether any slept."""
        slept = bool(self.asleep.any())
        self._rouse(b, self.asleep.copy())
        return slept

    def _rouse(self, b: Bodies, who: Flags) -> None:
        b.moving[who] = True
        self.asleep[who] = False
        self.looks[who] = 0


def at_rest(b: Bodies, pairs: Pairs, wall_touching: list[NDArray[np.uint8]], sleep: Sleep, dt: float) -> Flags:
    """(n,) which rows are at rest now."""
    slow: Flags = (b.v**2).sum(axis=1) < sleep.speed**2
    if len(b.omega):
        slow &= (b.omega**2).sum(axis=1) * b.radius**2 < sleep.speed**2
    slow &= np.sqrt((b.force**2).sum(axis=1)) * sleep.every * dt < sleep.speed * b.mass
    touches = np.zeros(len(b.x), dtype=bool)
    for rows in (pairs.row, pairs.partner):
        touches[rows[pairs.touching & 1 != 0]] = True
    for touching in wall_touching:
        touches |= touching != 0
    slow &= touches
    return slow


def islands(pairs: Pairs, members: Flags) -> Ints:
    """(n,) number of the island of each row: those of `members` that the list connects."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(members)
    both = members[pairs.row] & members[pairs.partner]
    graph = coo_array((np.ones(int(both.sum()), dtype=np.uint8), (pairs.row[both], pairs.partner[both])), shape=(n, n))
    found: Ints = connected_components(graph, directed=False)[1].astype(np.int64)
    return found

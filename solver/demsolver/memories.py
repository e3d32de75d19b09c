"""What the contacts of a simulation remember, apart from the arrays of the run: to be kept in a file and taken up by another simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from demsolver import contact
from demsolver.bind_law import in_use
from demsolver.neighbor_rows import turn
from demsolver.neighbors import HOME, PARTNER_FEELS, Columns, remembered
from demsolver.scene import ContactLaw, Scene, Wall
from demsolver.state import Floats, Ints, Pairs, outside


class WallMemory(NamedTuple):
    """Of one wall: the laws that remember, memory (n, c) and touching (n,) by particle, as `Memories.id` names them."""

    laws: tuple[str, ...]
    memory: Floats
    touching: NDArray[np.uint8]


@dataclass(frozen=True)
class Memories:
    """What contacts remember, by the ids of particles.

    id: (n,) in the scene's order; rows: (n,) in the order in which sums are taken, which decides their last bits. laws: the pair laws that
    remember, as `remembering` gives them. i, j: (m,) ids: particle i feels the image of j shifted by row `shift` of neighbors.SHIFTS; a pair with no
    periodic face between is there once, felt by both. touching: (m,). memory: (m, c) as i feels it. walls: by name. tally: (6,) what the
    energy account has summed up so far.
    """

    id: Ints
    rows: Ints
    laws: tuple[str, ...]
    i: Ints
    j: Ints
    shift: Ints
    touching: NDArray[np.uint8]
    memory: Floats
    walls: Mapping[str, WallMemory] = field(default_factory=dict)
    tally: Floats = field(default_factory=lambda: np.zeros(6))


def remembering(law: ContactLaw | None) -> tuple[str, ...]:
    """The laws of a contact that remember from step to step, as `family law`: what the columns of its memory mean."""
    names = [(family, getattr(law, family)) for family in in_use(law)] if law else []
    return tuple(f"{family} {name}" for family, name in names if contact.memory(family, name))


def pairs_remembered(pairs: Pairs, ids: Ints) -> tuple[Ints, Ints, Ints, NDArray[np.uint8], Floats]:
    """i, j, shift, touching and memory of the entries that have something to remember. ids: (n,) of the rows."""
    old = remembered(pairs)
    row, partner = ids[old.row], ids[old.partner]
    code = old.code.astype(np.int64) if len(old.code) else np.full(len(row), HOME)
    turned = code >= PARTNER_FEELS
    return np.where(turned, partner, row), np.where(turned, row, partner), code - PARTNER_FEELS * turned, old.touching, old.memory


def pairs_recalled(found: Memories, ids: Ints, columns: Columns, *, periodic: bool) -> Pairs:
    """A neighbour list of the entries between particles that are still there. ids: (n,) of the rows. columns: of memory; what is stored beyond
    the law's, for the energy account, is taken up where both keep one."""
    a, b = places(found.i, ids), places(found.j, ids)
    kept = (a >= 0) & (b >= 0)
    a, b, shift, memory = a[kept], b[kept], found.shift[kept], fitted(found.memory[kept], len(columns.sign), columns.law)
    turned = a > b
    home = shift == HOME
    turn(memory, np.flatnonzero(turned & home), columns)
    code = np.where(turned & ~home, shift + PARTNER_FEELS, shift)
    row, partner = np.minimum(a, b), np.maximum(a, b)
    order = np.lexsort((code, partner, row))
    first = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(ids)))]).astype(np.int64)
    codes = code[order].astype(np.uint8) if periodic else np.zeros(0, dtype=np.uint8)
    return Pairs(
        first, row[order].astype(np.uint32), partner[order].astype(np.uint32), codes, found.touching[kept][order].astype(np.uint8),
        np.ascontiguousarray(memory[order]),
    )  # fmt: skip


def walls_remembered(walls: Sequence[Wall], arrays: Sequence[tuple[Any, ...]], order: Ints) -> dict[str, WallMemory]:
    """By name. arrays: as bind_scene.wall_arrays, in rows. order: (n,) number of the particle in each row."""
    return {
        wall.name: WallMemory(remembering(wall.law), outside(memory, order), outside(touching, order))
        for wall, (_, _, _, memory, touching) in zip(walls, arrays, strict=True)
    }


def recall_walls(found: Memories, walls: Sequence[Wall], arrays: Sequence[tuple[Any, ...]], ids: Ints, extra: int) -> None:
    """Fills memory and touching of the walls that are known by name and law, in place. ids: (n,) of the rows. extra: columns behind the law's."""
    was = places(ids, found.id)
    there = was >= 0
    for wall, (_, _, _, memory, touching) in zip(walls, arrays, strict=True):
        old = found.walls.get(wall.name)
        if old and old.laws == remembering(wall.law):
            memory[there] = fitted(old.memory[was[there]], memory.shape[1], memory.shape[1] - extra)
            touching[there] = old.touching[was[there]]


def check_laws(found: Memories, scene: Scene) -> None:
    """Raises ValueError where the memory of one law would be read as that of another."""
    laws = [("pairs", found.laws, remembering(scene.pair))]
    laws += [(f"wall {wall.name}", found.walls[wall.name].laws, remembering(wall.law)) for wall in scene.walls if wall.name in found.walls]
    for name, then, now in laws:
        if then and now and then != now:
            message = f"{name}: contacts remember {', '.join(then)}, and cannot go on with {', '.join(now)}"
            raise ValueError(message)


def rows_as_then(found: Memories, ids: Ints, order: Ints) -> Ints:
    """(n,) rows of now in the order of then, new particles last. ids: (n,) in the scene's order; order: (n,) number of the particle in each row."""
    here = places(found.rows, ids)
    row = np.empty(len(ids), dtype=np.int64)
    row[order] = np.arange(len(ids))
    known = row[here[here >= 0]]
    return np.concatenate([known, np.setdiff1d(np.arange(len(ids)), known)])


def fitted(memory: Floats, columns: int, base: int) -> Floats:
    """(m, columns) of (m, c): all where as many are kept, else the `base` columns of the law, and zeros."""
    found = np.zeros((len(memory), columns))
    width = columns if memory.shape[1] == columns else base
    found[:, :width] = memory[:, :width]
    return found


def places(wanted: Ints, ids: Ints) -> Ints:
    """(m,) where each wanted id stands in `ids`, -1 for one that is not there."""
    order = np.argsort(ids, kind="stable")
    at = np.minimum(np.searchsorted(ids, wanted, sorter=order), len(ids) - 1) if len(ids) else np.zeros(len(wanted), dtype=np.int64)
    return np.where(ids[order[at]] == wanted, order[at], -1) if len(ids) else at - 1


def same_law(a: Scene, b: Scene) -> bool:
    """Whether the contacts of one scene mean the same in the other: laws that remember the same."""
    if a.pair is None or b.pair is None:
        return a.pair is b.pair
    return all(getattr(a.pair, family) == getattr(b.pair, family) for family in contact.REMEMBERING)

"""Rows of many frames put in order: restarts, and the bodies of clumps that come in files of their own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from demverify.analysis.energies import Row
from demverify.errors import InputError
from demverify.frames import Floats

_NAMED = 3  # steps a note names


@dataclass(frozen=True)
class Series:
    """Rotational energy over time.

    rows: one a frame, steps ascending. notes: what a reader should know of them, a sentence each.
    """

    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Floats:
        """A column over all rows, (n,): step, time, n, erotate, a shape, or ke; NaN where it is not known.

        Raises KeyError for another name."""
        return np.array([row.as_dict()[name] for row in self.rows], dtype=np.float64)


class Rows:
    """Gathers rows in the order in which the run wrote them.

    A step that is not beyond the last one belongs to a run that was restarted there, or is the end of one `run` and the beginning of
    the next: it takes the place of that frame and of all later ones.
    """

    def __init__(self) -> None:
        """Empty."""
        self.rows: list[tuple[Row, str]] = []
        self._replaced: dict[int, None] = {}

    def add(self, row: Row, source: str) -> None:
        """Takes a row from the file `source`. Raises InputError when two files hold the same step of different particles."""
        last = self.rows[-1] if self.rows else None
        if last and row.step < last[0].step:
            self._replaced[row.step] = None
        while self.rows and self.rows[-1][0].step >= row.step:
            before, where = self.rows.pop()
            if before.step == row.step and where != source and before.particles != row.particles:
                message = (
                    f"{where} ({before.n} particles) and {source} ({row.n}) both hold step {row.step}, of different particles: "
                    "parts of one frame, or two runs? Give the files of one of them"
                )
                raise InputError(message)
        self.rows.append((row, source))

    def series(self, notes: Iterable[str] = ()) -> Series:
        """What was gathered."""
        told = [f"the run went back to step {step}: its earlier frames from there on are replaced" for step in self._replaced]
        return Series(tuple(row for row, _ in self.rows), (*dict.fromkeys(notes), *told))


def with_bodies(particles: Series, bodies: Series) -> Series:
    """The free particles of one series and the clumps of another, where both have the step. n counts the particles.

    Raises InputError when they have no step in common.
    """
    of_step = {row.step: row for row in bodies.rows}
    both = [(row, of_step[row.step]) for row in particles.rows if row.step in of_step]
    if particles.rows and not both:
        message = f"the dump of bodies has none of the steps of the particles (those start at {particles.rows[0].step})"
        raise InputError(message)
    notes = [*particles.notes, *bodies.notes]
    notes += _alone([row.step for row in particles.rows if row.step not in of_step], "particles", "bodies")
    steps = {row.step for row in particles.rows}
    notes += _alone([row.step for row in bodies.rows if row.step not in steps], "bodies", "particles")
    return Series(tuple(_sum(a, b) for a, b in both), tuple(notes))


def _alone(steps: Sequence[int], have: str, lack: str) -> list[str]:
    if not steps:
        return []
    named = " ".join(map(str, steps[:_NAMED])) + (" ..." if len(steps) > _NAMED else "")
    return [f"{len(steps)} steps with {have} but no {lack} are left out: {named}"]


def _sum(particles: Row, bodies: Row) -> Row:
    by_shape = {shape: energy + bodies.by_shape[shape] for shape, energy in particles.by_shape.items()}
    ke = None if particles.ke is None or bodies.ke is None else particles.ke + bodies.ke
    return replace(particles, by_shape=by_shape, ke=ke, time=bodies.time if particles.time is None else particles.time)

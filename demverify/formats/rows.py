"""Which columns of a file a reading wants, and its rows in the order of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.reading import Reading
from demverify.frames import Floats


@dataclass(frozen=True)
class Picked:
    """The columns of a file to look at.

    at: where they are in the file, in order. names: what they are called in the frame, None for ids that serve to sort alone.
    ids: where in `at` the ids are, None where rows stay in the order of the file.
    """

    at: list[int]
    names: list[str | None]
    ids: int | None

    def joined(self, pieces: Sequence[Floats]) -> Floats:
        """A table of its own from pieces of it, (len(at), some rows) each."""
        table = np.empty((len(self.at), sum(piece.shape[1] for piece in pieces)))
        return np.concatenate(pieces, axis=1, out=table) if pieces else table

    def columns(self, table: Floats, place: Place) -> dict[str, Floats]:
        """The columns of a frame: rows of the table (len(at), rows), which is sorted in place. Raises InputError as `sort_by_id` does."""
        from demverify.formats.sorting import sort_by_id

        if self.ids is not None:
            sort_by_id(table, self.ids, place)
        return {name: column for name, column in zip(self.names, table, strict=True) if name is not None}


def pick(found: Sequence[str], reading: Reading, place: Place, *, local: bool = False) -> Picked:
    """The columns of a file that has those `found`. local: rows stay as they are.

    Raises InputError as `Reading.called` does, and for particles without an id.
    """
    called = reading.called(found, place)
    given = [reading.names.get(name, name) for name in reading.columns or found]
    if local:
        at = [j for j, name in enumerate(called) if name is not None]
        return Picked(at, [called[j] for j in at], None)
    if "id" not in given:
        message = f"expected distinct columns with an id among them, got: {' '.join(given)}"
        raise InputError(message, place)
    ids = given.index("id")
    at = [j for j, name in enumerate(called) if name is not None or j == ids]
    return Picked(at, [called[j] for j in at], at.index(ids))

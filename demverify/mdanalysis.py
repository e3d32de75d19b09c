"""Rotational energy as an MDAnalysis analysis, for those who work with Universes.

    >>> import MDAnalysis
    >>> from demverify.mdanalysis import Erotate
    >>> universe = MDAnalysis.Universe("run.dump", format="LAMMPSDUMP", topology_format="LAMMPSDUMP", additional_columns=True)
    >>> Erotate(universe, density=2500.0).run(backend="multiprocessing", n_workers=4).results.erotate

Limits, those of MDAnalysis:
- Positions, velocities and forces are float32: ke and half-step energies are good to some 1e-7, clumps by their members to that times the size of
  the box over that of the clump. The additional columns, such as omegax, radius and mass, are float64, and so are the energies made of them.
- The number of particles must be the same in all frames.
- Dumps with ITEM: UNITS or ITEM: TIME cannot be opened, nor binary ones and those of `dump local`. Half a frame at the end is passed over
  without a word, and a last row that lost digits is taken as it is.
- Without `additional_columns=True` there are no spins. Boundary flags are not kept: clumps across a periodic face need xu yu zu.
- Nothing tells who wrote a dump: shapex, and the inertia of clumps in LAMMPS' convention, need the deck.
`demverify.erotate` reads the files itself and has none of these limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase
from MDAnalysis.analysis.results import Results, ResultsGroup

from demverify.analysis.clumps import Inertia
from demverify.analysis.energies import SHAPES, Row, Wanted
from demverify.analysis.erotate import energies_as_written
from demverify.analysis.options import meanings_from
from demverify.errors import InputError
from demverify.formats.universe import frame_of, hides_columns

if TYPE_CHECKING:
    from MDAnalysis import Universe

COLUMNS = ("step", "time", "n", "erotate", *SHAPES, "ke")


class Erotate(AnalysisBase):  # type: ignore[misc]
    """Rotational energy per frame of a Universe, in total and per shape; backends serial, multiprocessing and dask.

    After `run()`: results.table, (frames, columns) float64, one row a frame, NaN: not known, with the columns results.columns = step time n
    erotate sphere multisphere superquadric ke; each of these as an array, results.erotate (frames,) and so on; and results.notes, what a
    reader should know of them, a sentence each (nan and inf with step, column and id).
    Raises InputError where the columns do not tell what is needed.
    Positions and velocities are float32, and the number of particles must not change: see the limits in demverify.mdanalysis.
    """

    _analysis_algorithm_is_parallelizable = True

    @classmethod
    def get_supported_backends(cls) -> tuple[str, ...]:
        """The backends of MDAnalysis that this analysis can use."""
        return ("serial", "multiprocessing", "dask")

    def __init__(
        self,
        universe: Universe,
        *,
        deck: str | Path | None = None,
        templates: Sequence[str | Path] = (),
        density: float | None = None,
        timestep: float | None = None,
        inertia: Inertia | None = None,
        halfstep: bool = False,
        **options: Any,
    ) -> None:
        """deck ... halfstep: as in demverify.erotate. options: of AnalysisBase (verbose)."""
        super().__init__(universe.trajectory, **options)
        meanings, self._notes = meanings_from(Path(deck) if deck else None, None, [Path(path) for path in templates], density, timestep)
        self._universe = universe
        self._wanted = Wanted(meanings, halfstep, inertia=inertia)

    def _prepare(self) -> None:
        self.results = Results(table=[], notes=[])  # without what an earlier run left

    def _single_frame(self) -> None:
        try:
            found = energies_as_written(frame_of(self._universe), self._wanted)
        except InputError as error:
            if not hides_columns(self._universe):
                raise
            message = f"{error.message}; with additional_columns=True MDAnalysis shows what else is in it"
            raise InputError(message) from None
        self.results.table.append(_numbers(found.row))
        self.results.notes += found.notes

    def _get_aggregator(self) -> ResultsGroup:
        return ResultsGroup(lookup=dict.fromkeys(("table", "notes"), ResultsGroup.flatten_sequence))

    def _conclude(self) -> None:
        self.results.table = np.array(self.results.table, dtype=np.float64).reshape(-1, len(COLUMNS))
        self.results.notes = [*self._notes, *self.results.notes]
        self.results.columns = COLUMNS
        for name, values in zip(COLUMNS, self.results.table.T, strict=True):
            self.results[name] = values


def _numbers(row: Row) -> list[float]:
    return [np.nan if value is None else float(value) for value in row.as_dict().values()]

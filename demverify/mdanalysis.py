"""Rotational energy as an MDAnalysis analysis, for those who work with Universes.

    >>> import MDAnalysis
    >>> from demverify.mdanalysis import Erotate
    >>> universe = MDAnalysis.Universe("run.dump", format="LAMMPSDUMP", additional_columns=True)
    >>> Erotate(universe, density=2500.0).run().results.erotate

Limits, those of MDAnalysis: it keeps positions and velocities in float32 (energies that need them, ke and clumps by their members, are good
to some 1e-7; additional columns such as omegax, radius and mass are float64), it refuses dumps whose number of particles changes and
those with ITEM: UNITS or ITEM: TIME, and it needs `additional_columns=True` to see spins. `demverify.erotate` reads the files itself and
has none of these limits.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase
from MDAnalysis.analysis.results import ResultsGroup

from demverify.analysis.energies import SHAPES, Row, Wanted, energies_of
from demverify.analysis.options import meanings_from
from demverify.formats.universe import frame_of

if TYPE_CHECKING:
    from MDAnalysis import Universe

COLUMNS = ("step", "time", "n", "erotate", *SHAPES, "ke")


class Erotate(AnalysisBase):  # type: ignore[misc]
    """Rotational energy per frame of a Universe; backends serial, multiprocessing and dask.

    After `run()`: results.table (frames, columns) float64 with the columns results.columns = step time n erotate sphere multisphere
    superquadric ke (NaN: not known), and each of these as an array: results.erotate (frames,), ...
    Raises InputError where the columns do not tell what is needed.
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
        density: float | None = None,
        halfstep: bool = False,
        **options: Any,
    ) -> None:
        """deck, density, halfstep: as in demverify.erotate. options: of AnalysisBase (verbose ...)."""
        super().__init__(universe.trajectory, **options)
        self._universe = universe
        self._wanted = Wanted(meanings_from(Path(deck) if deck else None, density=density)[0], halfstep)

    def _prepare(self) -> None:
        self.results.table = []

    def _single_frame(self) -> None:
        row = energies_of(frame_of(self._universe), self._wanted).row
        self.results.table.append(_numbers(row))

    def _get_aggregator(self) -> ResultsGroup:
        return ResultsGroup(lookup={"table": ResultsGroup.ndarray_vstack})

    def _conclude(self) -> None:
        self.results.table = np.array(self.results.table, dtype=np.float64).reshape(-1, len(COLUMNS))
        self.results.columns = COLUMNS
        for name, values in zip(COLUMNS, self.results.table.T, strict=True):
            self.results[name] = values


def _numbers(row: Row) -> list[float]:
    values = row.as_dict()
    return [np.nan if values[name] is None else float(values[name] or 0) for name in COLUMNS]

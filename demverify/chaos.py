"""The chaos envelope: how far a run parts from itself when it starts one unit in the last place away.

Colliding spheres amplify any disturbance exponentially, and rounding is a disturbance. Two engines that compute the
very same law in another order of operations therefore part, sooner or later, as two runs of one engine do. The envelope
measures that, instead of guessing.

How much larger than the envelope may the engines' difference be, and still be chaos? The envelope starts from 1 unit in
the last place (ulp) once; the engines disagree anew at every step, by some ulp of the overlap. Such a disagreement
moves a particle by (w dt)^2 ulp a step, w the frequency of a contact: 0.016 ulp at the usual 50 steps a contact. It
adds up over one e-folding of the growth, some hundreds of steps, to 1..10 ulp; later ones are overtaken by what the
first have become. Hence FACTOR = 10, on a logarithmic axis a shift of 2.3 e-foldings. Measured on 125 spheres in a box
(two codes of one law, 8 runs, 4000 steps): the engines' difference was 0.1 to 2.3 envelopes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demverify.differences import (
    QUANTITIES,
    Difference,
    Figure,
    Scales,
    bulk,
    bulk_spread,
    difference,
    ids_apart,
    scalar_difference,
)
from demverify.frames import Floats, Frame, Thermo, by_step

FACTOR = 10.0
"""The engines' pointwise difference is chaos up to this many envelopes (argued above)."""

BULK_FACTOR = 5.0
"""A bulk figure may be five standard deviations (`differences.bulk_spread`) apart: of thousands of checks, none is wrong by
chance. Measured on the chaotic map of tests/demverify/compare/test_chaos.py: 180 runs of 60 steps, none failed."""

_PAIR = ("native", "native one ulp away")


@dataclass(frozen=True)
class Envelope:
    """steps: (k,) ascending. relative: quantity -> (k,) relative differences, normalised as the engines' own; inf: not
    comparable."""

    steps: NDArray[np.int64]
    relative: Mapping[str, Floats]

    @classmethod
    def from_frames(cls, native: Sequence[Frame], perturbed: Sequence[Frame]) -> Envelope:
        """The envelope of a run and of the same run started from nudged positions, over their common steps."""
        a, b = by_step(native), by_step(perturbed)
        steps = sorted(a.keys() & b.keys())
        rows, scales, floors = [], Scales(), dict[str, float]()
        for step in steps:
            scales = scales | Scales.of(a[step]) | Scales.of(b[step])
            figures = bulk(a[step]), bulk(b[step])
            raise_floors(floors, *figures)
            rows.append(_pointwise(a[step], b[step], scales) | _bulk(*figures, floors))
        return cls._of_rows(steps, rows)

    @classmethod
    def from_thermo(cls, native: Thermo, perturbed: Thermo) -> Envelope:
        """The same for two thermo tables of one engine, column by column, over the common steps."""
        a, b = thermo_rows(native), thermo_rows(perturbed)
        steps = sorted(a.keys() & b.keys())
        rows = [
            {name: thermo_difference(name, a[s][name], b[s][name], 0.0, _PAIR).max_rel for name in native.columns} for s in steps
        ]
        return cls._of_rows(steps, rows)

    @classmethod
    def _of_rows(cls, steps: Sequence[int], rows: Sequence[Mapping[str, float]]) -> Envelope:
        names = sorted({name for row in rows for name in row})
        return cls(np.array(steps, dtype=np.int64), {name: np.array([row.get(name, 0.0) for row in rows]) for name in names})

    def at(self, quantity: str, step: int) -> float:
        """The largest envelope of the younger half of the run so far: steps s with s - first > (step - first)/2, s <= step.

        A maximum, because a difference that grows also swings (a contact that opens a step earlier), and no two runs
        swing together. Over half the run, because an accident (two spheres placed to touch exactly) must not excuse all
        that follows. 0 where nothing was measured, and where the run itself was not finite: nothing is excused then.
        """
        if quantity not in self.relative or not len(self.steps) or step < self.steps[0]:
            return 0.0
        end = int(np.searchsorted(self.steps, step, side="right"))
        begin = int(np.searchsorted(self.steps, self.steps[0] + (step - self.steps[0]) / 2, side="right"))
        window = self.relative[quantity][min(begin, end - 1) : end]
        return float(np.max(np.where(np.isnan(window), 0.0, window)))


def nudge(positions: Floats, seed: int = 0) -> Floats:
    """(n, 3) positions, each coordinate moved one unit in the last place, up or down at random; a coordinate of exactly 0 stays.

    Up and down, because moving all the same way is a translation, which parts nothing.
    """
    signs = np.random.default_rng(seed).choice([-np.inf, np.inf], size=positions.shape)
    return np.where(positions == 0.0, positions, np.nextafter(positions, signs))


def thermo_rows(thermo: Thermo) -> dict[int, dict[str, float]]:
    """Step -> column -> value; of rows with one step the last wins. Raises ValueError if there is no column Step."""
    if "Step" not in thermo.columns:
        raise ValueError(f"a thermo table without the column Step: {' '.join(thermo.columns)}")
    rows = (dict(zip(thermo.columns, map(float, row), strict=True)) for row in thermo.values)
    return {int(row["Step"]): row for row in rows}


def thermo_difference(name: str, a: float, b: float, floor: float, engines: tuple[str, str]) -> Difference:
    """How far one thermo value is apart, relative to the larger of the two, and to `floor` at least."""
    return scalar_difference(name, a, b, max(abs(a), abs(b), floor), engines)


def raise_floors(floors: dict[str, float], *figures: Mapping[str, Figure]) -> None:
    """Keep, for every bulk figure, the largest floor seen so far (in place)."""
    for frame in figures:
        for name, figure in frame.items():
            floors[name] = max(floors.get(name, 0.0), figure.floor if np.isfinite(figure.floor) else 0.0)


def _pointwise(a: Frame, b: Frame, scales: Scales) -> dict[str, float]:
    if apart := ids_apart(a, b, _PAIR):
        return {"ids": apart.max_rel} | dict.fromkeys(QUANTITIES, np.inf)
    if not a.n:
        return {}
    found = {name: difference(a, b, name, getattr(scales, name), _PAIR) for name in QUANTITIES}
    return {name: item.max_rel for name, item in found.items() if item is not None}


def _bulk(a: Mapping[str, Figure], b: Mapping[str, Figure], floors: Mapping[str, float]) -> dict[str, float]:
    return {name: bulk_spread(a[name], b[name], floors[name]) for name in a.keys() & b.keys()}

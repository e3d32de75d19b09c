"""Two series and a tolerance -> verdicts. Arrays in, checks out; nothing is run, read or written here.

Three tiers, by how long the runs have gone their own ways since their first common step:

1. the set-up: one state, one evaluation of the forces. Nothing but the order of operations may differ.
2. up to 200 steps: contact history has built up, rounding has been fed back.
3. beyond: a chaotic run parts exponentially. Differences are still judged one by one while they exceed what one unit in
   the last place has grown to (`demverify.chaos`); bulk figures and energies are judged at every step.

Whatever is not a finite number, not there, or not the same particles fails; nothing passes because a comparison with
NaN is false.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, Protocol

import numpy as np

from demverify.chaos import BULK_FACTOR, FACTOR, Envelope, raise_floors, thermo_difference, thermo_rows
from demverify.differences import (
    QUANTITIES,
    Difference,
    Figure,
    Scales,
    bulk,
    bulk_difference,
    difference,
    ids_apart,
    scalar_difference,
)
from demverify.frames import Frame, Thermo, by_step

Outcome = Literal["pass", "fail", "skipped", "crashed"]
Engines = tuple[str, str]
Series = Mapping[int, object]

TIER1 = 1e-12
"""Of the largest force. One evaluation on the same state: some 10 contacts a particle, each a few roundings (2e-16) of
an overlap, and an overlap of 1e-3 radii is known to 2e-13 of itself. Any other law, parameter or convention is off by
1e-6 and more."""

TIER2 = 1e-9
"""Of the largest force over the trajectory so far. 200 steps feed rounding back through history and position; stiff
collisions grow it by up to 1e3. A term of the wrong order in dt, or a history turned another way, shows at 1e-6 and
more."""

TIER3 = 1e-2
"""Relative, for bulk figures and energies: what two runs that parted still share. Of 1,000 particles, fluctuations
average out to a few per cent or less; the limit is widened by the measured envelope of the same figure."""

TIER2_STEPS = 200
"""Steps after the first common one that tier 2 covers."""

KNOWN = "known difference, accepted: "
"""How the reason of a check begins that was not judged because the user lives with what is known."""

_TIMINGS = {"step", "cpu", "t/cpu", "s/cpu", "cpuleft", "cpuremain", "elapsed", "elaplong"}
_NAN = float("nan")


@dataclass(frozen=True)
class Check:
    """One verdict on one quantity at one step.

    engines: the two compared; for kind "law", an engine and the closed form. max_abs in the quantity's units, max_rel
    relative to its scale; NaN where nothing was measured (skipped, crashed, values not finite). tolerance limits
    max_rel. kind "engine" is engine against engine, "law" engine against closed form: their tolerances are never mixed.
    """

    quantity: str
    engines: Engines
    step: int
    max_abs: float
    max_rel: float
    tolerance: float
    outcome: Outcome
    reason: str = ""
    tier: Literal[1, 2, 3] = 1
    kind: Literal["engine", "law"] = "engine"

    @property
    def closeness(self) -> float:
        """The difference over its limit, 1 at it; the difference itself where the limit is zero, -1 where nothing was measured."""
        if not self.max_rel >= 0.0:
            return -1.0
        return self.max_rel / self.tolerance if self.tolerance else self.max_rel


def nearest(checks: Iterable[Check]) -> Check | None:
    """The check nearest to its limit, or farthest beyond; the first of equals, None of none."""
    return max(checks, key=lambda check: check.closeness, default=None)


@dataclass(frozen=True)
class Tolerances:
    """The limits of the three tiers; the reasons stand with the constants."""

    tier1: float = TIER1
    tier2: float = TIER2
    bulk: float = TIER3
    tier2_steps: int = TIER2_STEPS
    chaos_factor: float = FACTOR
    bulk_factor: float = BULK_FACTOR

    def pointwise(self, tier: int) -> float:
        """The limit of a difference at one particle; in tier 3 that of tier 2, for as long as there is no chaos."""
        return self.tier1 if tier == 1 else self.tier2


class Entry(Protocol):
    """What `explain` needs of an entry of the register of known deviations."""

    @property
    def id(self) -> str:
        """Short name of the entry."""

    @property
    def what(self) -> str:
        """What the engine does, in one sentence."""


class _Stage(NamedTuple):
    """Whose difference is judged, and how late in the run."""

    engines: Engines
    step: int
    tier: Literal[1, 2, 3]


class _Excuse(NamedTuple):
    """A difference up to `limit` says nothing, and `skipped` says why; above it, `failed` says why it was not excused."""

    limit: float = 0.0
    skipped: str = ""
    failed: str = ""


_NO_EXCUSE = _Excuse()


def compare_state(
    a: Frame, b: Frame, engines: Engines, tolerance: float = TIER1, tier: Literal[1, 2, 3] = 1, scales: Scales | None = None
) -> list[Check]:
    """Judge force, torque, position, velocity and omega of two frames, frozen particles included.

    scales: what differences are relative to; the larger of both frames' if not given. A quantity that one frame does not hold is
    skipped by name; frames with other particles, or numbers that are not finite, fail.
    """
    excuses = dict.fromkeys([*QUANTITIES, "ids"], _NO_EXCUSE)
    return _state(a, b, _Stage(engines, a.step, tier), tolerance, scales or Scales.of(a) | Scales.of(b), excuses)


def compare_series(
    a: Sequence[Frame],
    b: Sequence[Frame],
    engines: Engines,
    envelope: Envelope | None = None,
    tolerances: Tolerances | None = None,
) -> list[Check]:
    """Judge every common step of two series, tier by tier. A step that only one series holds fails, as does an empty series.

    Scales are the largest values of either series so far. Past tier 1, a difference above its tolerance is skipped as
    chaos when it is at most `chaos_factor` envelopes; bulk figures are judged at that step then, and at every step of
    tier 3. Without an envelope, no difference is excused in tier 2, and tier 3 judges bulk figures alone.
    """
    limits, left, right = tolerances or Tolerances(), by_step(a), by_step(b)
    checks, steps = _steps_apart(left, right, engines), sorted(left.keys() & right.keys())
    scales, floors = Scales(), dict[str, float]()
    for step in steps:
        p, q, stage = left[step], right[step], _Stage(engines, step, _tier(step - steps[0], limits))
        scales, figures = scales | Scales.of(p) | Scales.of(q), (bulk(p), bulk(q))
        raise_floors(floors, *figures)
        excuses = {name: _chaos(envelope, name, stage, limits) for name in [*QUANTITIES, "ids"]}
        found = _state(p, q, stage, limits.pointwise(stage.tier), scales, excuses)
        checks += found
        excused = any(check.outcome == "skipped" and check.max_rel > 0 for check in found)
        if (stage.tier == 3 and max(p.n, q.n)) or excused:
            checks += _bulk_checks(figures, floors, stage, envelope, limits)
    return checks


def compare_scalars(
    a: Thermo,
    b: Thermo,
    engines: Engines,
    columns: Mapping[str, tuple[str, str]] | None = None,
    floors: Mapping[str, float] | None = None,
    envelope: Envelope | None = None,
    tolerances: Tolerances | None = None,
) -> list[Check]:
    """Judge two thermo tables row by row, matched by the column Step, with the tolerance of bulk figures.

    columns: quantity -> (column of a, column of b); by default every column of either, by its name, timings left out.
    Differences are relative to the larger of the two values, and to floors[quantity] at least: give one where a column
    is zero by physics and holds but rounding (erotate of a frictionless scene: REST x ke). envelope: of either
    kind, looked up under the quantity (`Envelope.from_frames`: ke, erotate) and a's column (`Envelope.from_thermo`).
    """
    limits, left, right = tolerances or Tolerances(), thermo_rows(a), thermo_rows(b)
    pairs = columns or {n: (n, n) for n in dict.fromkeys((*a.columns, *b.columns)) if n.lower() not in _TIMINGS}
    checks, steps = _steps_apart(left, right, engines), sorted(left.keys() & right.keys())
    for name, (in_a, in_b) in pairs.items():
        if in_a not in a.columns or in_b not in b.columns:
            engine, column = (engines[0], in_a) if in_a not in a.columns else (engines[1], in_b)
            checks.append(not_judged(name, engines, "skipped", f"{engine} printed no column {column}", tier=3))
            continue
        for step in steps:
            found = thermo_difference(name, left[step][in_a], right[step][in_b], (floors or {}).get(name, 0.0), engines)
            stage = _Stage(engines, step, _tier(step - steps[0], limits))
            grown = max(envelope.at(name, step), envelope.at(in_a, step)) if envelope else 0.0
            checks.append(_judge_bulk(name, stage, found, grown, limits))
    return checks


def compare_law(
    quantity: str, engine: str, measured: float, expected: float, tolerance: float, step: int = 0, scale: float | None = None
) -> Check:
    """Judge an engine's number against a closed form; relative to |expected|, or to `scale` where the expected value is zero."""
    pair = (engine, "closed form")
    found = scalar_difference(quantity, measured, expected, abs(expected) if scale is None else scale, pair)
    return replace(_judge(quantity, _Stage(pair, step, 1), found, tolerance), kind="law")


def not_judged(
    quantity: str, engines: Engines, outcome: Outcome, reason: str, step: int = 0, tier: Literal[1, 2, 3] = 1
) -> Check:
    """A check without numbers: an engine that is missing ("skipped") or died ("crashed"), and why."""
    return Check(quantity, engines, step, _NAN, _NAN, _NAN, outcome, reason, tier)


def verdict(checks: Iterable[Check]) -> Literal["pass", "fail"]:
    """Pass if something was judged and nothing failed or crashed. Skipped checks alone are no agreement (see `summary`)."""
    outcomes = {check.outcome for check in checks}
    return "pass" if "pass" in outcomes and not outcomes & {"fail", "crashed"} else "fail"


def summary(checks: Sequence[Check]) -> str:
    """The verdict in one plain sentence: how many checks, what failed first, or why nothing was judged."""
    of = {outcome: [check for check in checks if check.outcome == outcome] for outcome in ("pass", "fail", "skipped", "crashed")}
    counts = f"{len(of['pass'])} of {len(of['pass']) + len(of['fail'])} checks agree"
    if of["crashed"]:
        return f"{of['crashed'][0].reason.splitlines()[0] or 'An engine crashed'}; {counts}."
    if of["fail"]:
        first = min(of["fail"], key=lambda check: (check.step, check.tier))
        return f"{counts}; first off at step {first.step}: {first.quantity} of {' and '.join(first.engines)}."
    if not of["pass"]:
        reasons = "; ".join(dict.fromkeys(check.reason for check in of["skipped"][:3] if check.reason))
        return f"Nothing was judged, so nothing agrees{': ' + reasons if reasons else ''}."
    worst = max(of["pass"], key=lambda check: check.closeness)
    known = sum(check.reason.startswith(KNOWN) for check in of["skipped"])
    gaps = [f"{count} {what}" for count, what in ((known, "known differences accepted"), (len(of["skipped"]) - known, "skipped")) if count]
    skipped = ", " + ", ".join(gaps) if gaps else ""
    return f"All {len(of['pass'])} checks agree{skipped}; closest to its limit: {worst.quantity} at step {worst.step}."


def exit_status(checks: Sequence[Check]) -> int:
    """0 agree, 1 disagree, 3 an engine crashed (which leaves the comparison unfinished, so it goes before 1)."""
    if any(check.outcome == "crashed" for check in checks):
        return 3
    return 0 if verdict(checks) == "pass" else 1


def explain(checks: Iterable[Check], entries: Sequence[Entry]) -> list[Check]:
    """Name, in the reason of each failing check of engine against engine, the known deviations that lie between the two
    (`demverify.register.applying` finds them). An explained check still fails."""
    known = "; ".join(f"explained by {entry.id}: {entry.what}" for entry in entries)
    return [
        replace(check, reason="; ".join(filter(None, [check.reason, known])))
        if (check.outcome, check.kind) == ("fail", "engine") and check.quantity not in ("ids", "steps")
        else check
        for check in checks
    ]


def _tier(steps: int, limits: Tolerances) -> Literal[1, 2, 3]:
    return 1 if steps == 0 else 2 if steps <= limits.tier2_steps else 3


def _judge(quantity: str, stage: _Stage, found: Difference, tolerance: float, excuse: _Excuse = _NO_EXCUSE) -> Check:
    """One check from one measured difference. NaN compares false with every limit, and so fails."""
    outcome: Outcome = "pass" if found.max_rel <= tolerance else "skipped" if found.max_rel <= excuse.limit else "fail"
    reasons = {"pass": "", "skipped": excuse.skipped, "fail": "; ".join(filter(None, [found.note, excuse.failed]))}
    engines, step, tier = stage
    return Check(quantity, engines, step, found.max_abs, found.max_rel, tolerance, outcome, reasons[outcome], tier)


def _state(a: Frame, b: Frame, stage: _Stage, tolerance: float, scales: Scales, excuses: Mapping[str, _Excuse]) -> list[Check]:
    if apart := ids_apart(a, b, stage.engines):
        return [_judge("ids", stage, apart, 0.0, excuses["ids"])]
    if not a.n:
        return [_gap("ids", stage, "no particles in either")]
    checks = []
    for name in QUANTITIES:
        found = difference(a, b, name, getattr(scales, name), stage.engines)
        if found is None:
            checks.append(_gap(name, stage, _missing(name, a, b, stage.engines)))
        else:
            checks.append(_judge(name, stage, found, tolerance, excuses[name]))
    return checks


def _gap(quantity: str, stage: _Stage, reason: str) -> Check:
    return not_judged(quantity, stage.engines, "skipped", reason, stage.step, stage.tier)


def _missing(quantity: str, a: Frame, b: Frame, engines: Engines) -> str:
    """Which engine wrote which columns of this quantity not."""
    gaps = {engine: [c for c in QUANTITIES[quantity] if c not in f.columns] for engine, f in zip(engines, (a, b), strict=True)}
    return "; ".join(f"{engine} wrote no {' '.join(columns)}" for engine, columns in gaps.items() if columns)


def _chaos(envelope: Envelope | None, quantity: str, stage: _Stage, limits: Tolerances) -> _Excuse:
    """How far rounding alone could have grown by this step. Never an excuse in tier 1: nothing has moved yet."""
    if envelope is None and stage.tier == 3 and quantity != "ids":
        return _Excuse(np.inf, "chaos: its envelope was not measured, so only bulk figures are judged this late")
    if envelope is None or stage.tier == 1:
        return _NO_EXCUSE
    grown = envelope.at(quantity, stage.step)
    size = f"one unit in the last place has grown to {grown:.1e} here"
    return _Excuse(limits.chaos_factor * grown, f"chaos: {size}, the difference says nothing", f"not chaos: {size}")


def _judge_bulk(quantity: str, stage: _Stage, found: Difference, grown: float, limits: Tolerances) -> Check:
    """One check of a bulk figure, its tolerance widened to its own envelope; one of 100 % would pass anything: skipped."""
    widened = max(limits.bulk, limits.bulk_factor * grown)
    if widened < 1:
        return _judge(quantity, stage, found, widened)
    return _judge(quantity, stage, found, limits.bulk, _Excuse(widened, f"chaos: alone, it has parted by {grown:.1e} here"))


def _bulk_checks(
    figures: tuple[Mapping[str, Figure], Mapping[str, Figure]],
    floors: Mapping[str, float],
    stage: _Stage,
    envelope: Envelope | None,
    limits: Tolerances,
) -> list[Check]:
    checks, (a, b) = [], figures
    for name in [name for name in a if name in b]:
        apart = bulk_difference(name, a[name], b[name], floors[name], stage.engines)
        checks.append(_judge_bulk(name, stage, apart, envelope.at(name, stage.step) if envelope else 0.0, limits))
    return checks


def _steps_apart(a: Series, b: Series, engines: Engines) -> list[Check]:
    """One failing check for each engine that lacks steps which the other has, and for two empty series."""
    if not a and not b:
        return [Check("steps", engines, 0, _NAN, _NAN, 0.0, "fail", "neither engine left a frame")]
    gaps = [(name, sorted(other.keys() - own.keys())) for name, own, other in ((engines[0], a, b), (engines[1], b, a))]
    total, checks = len(a.keys() | b.keys()), []
    for name, steps in gaps:
        if steps:
            reason = f"{name} has no step {_listed(steps)}"
            checks.append(Check("steps", engines, steps[0], len(steps), len(steps) / total, 0.0, "fail", reason))
    return checks


def _listed(steps: Sequence[int], most: int = 5) -> str:
    more = f" and {len(steps) - most} more" if len(steps) > most else ""
    return ", ".join(map(str, steps[:most])) + more


__all__ = [
    "TIER1", "TIER2", "TIER2_STEPS", "TIER3", "Check", "Envelope", "Tolerances", "compare_law", "compare_scalars",
    "compare_series", "compare_state", "exit_status", "explain", "nearest", "not_judged", "summary", "verdict",
]  # fmt: skip

"""What a report says, before it is written as html or json: plain data, made by the orchestration."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from demverify.compare import Check, Engines, Entry
from demverify.frames import Floats


@dataclass(frozen=True)
class EngineInfo:
    """An engine and how it fared. wall_s [s] and particle_steps_per_s are None where it did not run; `reason` says why."""

    version: str
    wall_s: float | None = None
    particle_steps_per_s: float | None = None
    status: Literal["ran", "skipped", "crashed"] = "ran"
    reason: str = ""


class Deviation(Entry, Protocol):
    """What the page tells of a known deviation: an entry of `demverify.register`."""

    @property
    def engine(self) -> str:
        """Who has it."""

    @property
    def version(self) -> str:
        """In which version it was shown."""

    @property
    def size(self) -> str:
        """How large it is."""

    @property
    def link(self) -> str:
        """Where it is discussed or written."""


@dataclass(frozen=True)
class EnergySeries:
    """Energies of one engine, in the deck's units. step, time: (k,); values: name -> (k,), e.g. ke, erotate, dissipated."""

    step: Floats
    time: Floats
    values: Mapping[str, Floats]


@dataclass(frozen=True)
class DifferenceCurve:
    """Relative difference of one quantity: of two engines, or of the native run and its nudged twin. step, value: (k,)."""

    engines: Engines
    quantity: str
    step: Floats
    value: Floats


@dataclass(frozen=True)
class Report:
    """Everything on the page.

    title: the deck or case. settings: one row a setting (deck, engine A, engine B, what it means in the scene), headed by
    `settings_head`. entries: known deviations that apply. command: what to type to get this report again, one command a line.
    """

    title: str
    verdict: Literal["pass", "fail"]
    checks: Sequence[Check]
    engines: Mapping[str, EngineInfo]
    series: Mapping[str, EnergySeries] = field(default_factory=dict)
    differences: Sequence[DifferenceCurve] = ()
    envelope: Sequence[DifferenceCurve] = ()
    settings: Sequence[tuple[str, str, str, str]] = ()
    settings_head: tuple[str, str, str, str] = ("Deck", "LAMMPS", "LIGGGHTS", "In the scene")
    entries: Sequence[Deviation] = ()
    command: str = ""


def difference_curves(checks: Iterable[Check]) -> list[DifferenceCurve]:
    """One curve for each engine pair and quantity that was measured, from the checks of engine against engine."""
    points: dict[tuple[Engines, str], list[tuple[int, float]]] = {}
    for check in checks:
        if check.kind == "engine" and np.isfinite(check.max_rel) and check.quantity not in ("ids", "steps"):
            points.setdefault((check.engines, check.quantity), []).append((check.step, check.max_rel))
    return [DifferenceCurve(*key, *np.array(sorted(rows), dtype=float).T) for key, rows in points.items()]

"""How far the native solver is from an engine on one deck: the deck goes through both, as a user's would."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from demverify.chaos import nudge
from demverify.engines.base import Job
from demverify.frames import Frame, by_step
from demverify.runs import Run, execute
from tests.cases.law_matrix import LAWS, STEPS, State, deck

FORCE, TORQUE = ("fx", "fy", "fz"), ("tqx", "tqy", "tqz")


@dataclass(frozen=True)
class Difference:
    """Largest difference of a particle's force (torque) over the engine's largest force (torque): at set-up, after STEPS steps.

    Where the engine has no torque at all: the largest torque of the native solver over the largest force, 0 when all is well.
    chaos_force, chaos_torque: the same after STEPS steps between two native runs whose positions are one unit in the last place apart at the
    start; 0 where not asked for.
    """

    force_0: float
    torque_0: float
    force: float
    torque: float
    chaos_force: float = 0.0
    chaos_torque: float = 0.0


def difference(native: Mapping[int, Frame], engine: Mapping[int, Frame], nudged: Mapping[int, Frame] | None = None) -> Difference:
    """Of the frames at set-up and at the end. Raises ValueError when the particles are not the same."""
    parts = [_relative(native[step], engine[step], names) for step in (0, STEPS) for names in (FORCE, TORQUE)]
    chaos = [_relative(native[STEPS], nudged[STEPS], names) for names in (FORCE, TORQUE)] if nudged else []
    return Difference(*parts, *chaos)


def _relative(native: Frame, engine: Frame, names: tuple[str, str, str]) -> float:
    if not np.array_equal(native.columns["id"], engine.columns["id"]):
        message = f"step {engine.step}: {native.n} particles here, {engine.n} in the engine, or others"
        raise ValueError(message)
    found, wanted = native.vectors(*names), engine.vectors(*names)
    scale = _largest(wanted) or _largest(engine.vectors(*FORCE))
    return _largest(found - wanted) / scale


def _largest(vectors: np.ndarray) -> float:
    return float(np.sqrt(np.max(np.sum(vectors**2, axis=1))))


def run(engine: str, text: str, folder: Path, **settings: Any) -> dict[int, Frame]:
    """Frames by step of a deck run in an engine; settings: those of `execute`. Raises RuntimeError when it is not here or crashed."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "in.deck"
    path.write_text(text)
    done: Run = execute(engine, engine, Job(path, folder / engine, every=STEPS, timeout_s=300.0), keep=True, **settings)
    if done.outcome.status != "ok":
        message = f"{engine} {done.outcome.status}: {done.outcome.reason}"
        raise RuntimeError(message)
    return by_step(done.frames)


def measure(name: str, state: State, folder: Path) -> Difference:
    """The difference of one law of the matrix on one state."""
    law = LAWS[name]
    text = deck(law, state)
    nudged = run("native", text, folder / "nudged", nudge=nudge) if law.chatters else None
    return difference(run("native", text, folder), run(law.dialect, text, folder), nudged)


@contextmanager
def measured(jobs: Iterable[tuple[str, State]], folder: Path) -> Iterator[dict[tuple[str, State], Future[Difference]]]:
    """Measures many (law, state) at once, one process a core, for compiling takes longest. Gives (law, state) -> its future."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(os.cpu_count(), mp_context=context) as pool:
        yield {(name, state): pool.submit(measure, name, state, folder / f"{k}") for k, (name, state) in enumerate(jobs)}
        pool.shutdown(cancel_futures=True)

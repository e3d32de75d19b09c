"""Work shared out among threads: each does a run of it and writes no place of another's, so that results are the same bits for any number."""

from __future__ import annotations

from typing import Any

import numpy as np

from demsolver.state import Ints


def shares(m: int, threads: int) -> Ints:
    """(t + 1,) thread t does share[t] to share[t + 1] of m things."""
    return np.arange(threads + 1) * m // threads


def use_threads(threads: int) -> None:
    """For the compiled loops that follow; before the first of them it also chooses what they are made by."""
    if threads == 1:
        return
    import numba

    numba.config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]  # type: ignore[attr-defined]  # OpenMP's threads wait awake
    numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))  # type: ignore[attr-defined]


def do(one: Any, in_threads: Any, share: Ints, *rest: Any) -> None:
    """One thread does what share[0]:share[1] names, several do a part each: one(t, share[t], share[t + 1], ...)."""
    if len(share) == 2:
        one(0, share[0], share[1], *rest)
    else:
        use_threads(len(share) - 1)
        in_threads(share, *rest)

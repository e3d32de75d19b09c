"""The assertion of a register entry: the engine does what the entry claims, and that is not what the law says."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def assert_deviates(entry: str, measured: ArrayLike, *, engine_rule: ArrayLike, law: ArrayLike, rtol: float) -> None:
    """`measured` equals `engine_rule`, and `law` lies at least ten tolerances away; relative to the largest number of both.

    Fails when the engine was mended: then the register is out of date. Raises AssertionError.
    """
    scale = max(np.max(np.abs(engine_rule)), np.max(np.abs(law)))
    apart = np.max(np.abs(np.subtract(engine_rule, law))) / scale
    assert apart > 10 * rtol, f"this test cannot tell {entry} from the law: the two are {apart:.2e} apart"
    off = np.max(np.abs(np.subtract(measured, engine_rule))) / scale
    assert off <= rtol, (
        f"register entry {entry} is out of date: measured {measured!r}, the entry claims {engine_rule!r} (off by {off:.2e}),"
        f" the law says {law!r}"
    )


def assert_nan(entry: str, values: ArrayLike) -> None:
    """All values are NaN, as the entry says. Raises AssertionError when the engine was mended."""
    assert np.all(np.isnan(values)), f"register entry {entry} is out of date: the engine now gives {values!r}, not NaN"

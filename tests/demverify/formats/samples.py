"""Frames for the tests of formats: made by hand, or drawn by hypothesis with every kind of double."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from demverify.deck.setup import DumpSpec
from demverify.errors import Place
from demverify.frames import Floats, Frame

DATA = Path(__file__).parents[2] / "data" / "dumps"
BOX = np.array([[-0.1, 0.123456789012], [0.0, 0.1], [0.0, 1.0 / 3.0]])
EXACT = {"float": "%.17g"}
NAMES = ("id", "type", "x", "y", "z", "fx")

any_double = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)


def frame(n: int = 3, step: int = 0, names: tuple[str, ...] = NAMES) -> Frame:
    """n particles with irrational numbers; type 1 and 2 in turn; ids from 1."""
    rng = np.random.default_rng(n + step)
    columns: dict[str, Floats] = {name: rng.normal(size=n) for name in names}
    columns["id"] = np.arange(1.0, n + 1.0)
    if "type" in names:
        columns["type"] = 1.0 + np.arange(n, dtype=np.float64) % 2
    return Frame(step, BOX, ("pp", "fs", "mm"), columns)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    """A frame of 0 to 6 particles: ids up to 2**53, columns x and fx of any doubles."""
    ids = sorted(draw(st.lists(st.integers(1, 2**53), unique=True, max_size=6)))
    doubles = st.lists(any_double, min_size=len(ids), max_size=len(ids)).map(np.array)
    columns = {"id": np.array(ids, dtype=np.float64), "x": draw(doubles).astype(float), "fx": draw(doubles).astype(float)}
    return Frame(draw(st.integers(0, 2**40)), BOX, ("pp", "fs", "mm"), columns)


def spec(file: str, columns: tuple[str, ...] = NAMES, **modify: object) -> DumpSpec:
    """A dump command with its dump_modify settings."""
    return DumpSpec("d", "all", "custom", 1, file, columns, Place(Path("in.deck"), 7), **modify)  # type: ignore[arg-type]


def assert_same(got: Frame, expected: Frame) -> None:
    """Bit for bit the same frame (any NaN equals any NaN)."""
    assert (got.step, got.boundary, set(got.columns)) == (expected.step, expected.boundary, set(expected.columns))
    np.testing.assert_array_equal(got.box, expected.box)
    for name, values in expected.columns.items():
        assert got.columns[name].dtype == np.float64
        np.testing.assert_array_equal(got.columns[name], values, err_msg=name)
        finite = ~np.isnan(values)
        assert (np.signbit(got.columns[name]) == np.signbit(values))[finite].all(), name

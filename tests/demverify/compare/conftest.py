"""Frames made by hand: a small packing with forces, torques and spins of known size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from demverify.frames import Frame

VECTORS = {
    "x": ("x", "y", "z"),
    "v": ("vx", "vy", "vz"),
    "f": ("fx", "fy", "fz"),
    "w": ("omegax", "omegay", "omegaz"),
    "t": ("tqx", "tqy", "tqz"),
}


def packing(
    step: int = 0, n: int = 20, seed: int = 1, boundary: tuple[str, str, str] = ("ff", "ff", "ff"), **vectors: object
) -> Frame:
    """n spheres of about 1 mm in a box of 1 m: forces about 1 N, torques about 1e-4 N m; keywords replace whole vectors."""
    rng = np.random.default_rng(seed)
    sizes = {"x": 0.3, "v": 1.0, "f": 1.0, "w": 100.0, "t": 1e-4}
    columns = {"id": np.arange(1.0, n + 1), "radius": rng.uniform(0.9e-3, 1e-3, n), "mass": rng.uniform(1e-6, 2e-6, n)}
    for key, names in VECTORS.items():
        values = rng.normal(0, sizes[key], (n, 3))
        values = np.asarray(vectors.get(key, values), dtype=float)
        columns |= dict(zip(names, values.T, strict=True))
    return Frame(step, np.array([[0.0, 1.0]] * 3), boundary, columns)


def with_column(frame: Frame, **columns: object) -> Frame:
    """The frame with some columns replaced; None takes a column away."""
    merged = frame.columns | columns
    return Frame(
        frame.step, frame.box, frame.boundary, {k: np.asarray(v, dtype=float) for k, v in merged.items() if v is not None}
    )


@pytest.fixture(scope="session")
def make() -> Callable[..., Frame]:
    """`packing` as a fixture."""
    return packing


@pytest.fixture(scope="session")
def replaced() -> Callable[..., Frame]:
    """`with_column` as a fixture."""
    return with_column

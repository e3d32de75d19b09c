"""Calling one function of a contact law with what its parameters name."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from hypothesis import strategies as st


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of six decimals: far from underflow."""
    return st.integers(round(low * 1e6), round(high * 1e6)).map(lambda k: k * 1e-6)


vectors = st.tuples(*[st.integers(-1000, 1000)] * 3).map(lambda v: np.array(v) * 1e-3)


def call(function: Callable[..., Any], known: Mapping[str, Any]) -> Any:
    """The function with what it asks for."""
    return function(*(known[name] for name in inspect.signature(function).parameters))


def spread(prefix: str, vector: np.ndarray) -> dict[str, float]:
    """A vector as the parameters <prefix>x, <prefix>y, <prefix>z."""
    return {prefix + axis: float(value) for axis, value in zip("xyz", vector, strict=True)}


def unit(vector: np.ndarray) -> np.ndarray:
    """A vector of length 1."""
    return np.asarray(vector / np.linalg.norm(vector))


def exchanged(known: Mapping[str, Any], memory: Mapping[str, int]) -> dict[str, Any]:
    """The same contact as the partner feels it."""
    odd = {name: -known[name] for name in known if name.rstrip("xyz") in ("n", "vt", "w") and len(name) > 1 and name != "mu"}
    return {**known, **odd, **{name: sign * known[name] for name, sign in memory.items()}}

"""Closed forms that a case can name, one a file: `measure(frames, ...) -> list[Measured]`.

`frames`: every frame of one engine's run, in steps; the other parameters are those of the case's [[law]] table, by name. A law reads the
outcome off the frames (positions, velocities, spins) and states what the closed form gives for the state of the first frame.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from importlib import import_module
from math import isfinite
from pkgutil import iter_modules
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np

from demverify.errors import InputError, Place
from demverify.frames import Floats, Frame


class Measured(NamedTuple):
    """One number of a run and what the closed form says. scale: what their difference is relative to; None: |expected|."""

    quantity: str
    step: int
    measured: float
    expected: float
    scale: float | None = None


def largest_miss(quantity: str, frames: Sequence[Frame], misses: Sequence[float] | Floats, scale: float) -> Measured:
    """Of misses, one a frame and in size, the largest and its step; NaN, where there is one."""
    at = int(np.argmax(misses))
    return Measured(quantity, frames[at].step, float(misses[at]), 0.0, scale)


def listing() -> tuple[str, ...]:
    """Names of the laws, read off the folder."""
    return tuple(sorted(module.name for module in iter_modules(__path__)))


def check(name: str, parameters: Mapping[str, Any], place: Place) -> None:
    """Whether a law can be applied with these parameters. Raises InputError for an unknown law, and a missing, unknown or wrong parameter."""
    if name not in listing():
        message = f"law {name!r} is not one of {', '.join(listing())}"
        raise InputError(message, place)
    wanted = _parameters(name)
    if set(parameters) != set(wanted):
        message = f"law {name} takes {', '.join(wanted) or 'no parameters'}; got {', '.join(parameters) or 'none'}"
        raise InputError(message, place)
    for key, kind in wanted.items():
        if not _fits(parameters[key], kind):
            expected = "a number" if kind is float else f"one of {', '.join(get_args(kind))}"
            message = f"law {name}: {key} must be {expected}, got {parameters[key]!r}"
            raise InputError(message, place)


def _parameters(name: str) -> dict[str, Any]:
    """Parameter -> its annotation: float, or a Literal of texts."""
    function = import_module(f"{__name__}.{name}").measure
    hints = get_type_hints(function)
    return {key: hints[key] for key in tuple(inspect.signature(function).parameters)[1:]}


def _fits(value: Any, kind: Any) -> bool:
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    return value in get_args(kind)


def measure(name: str, frames: Sequence[Frame], parameters: Mapping[str, Any], place: Place) -> list[Measured]:
    """Applies a law. Raises InputError as `check` does, and for frames that the law cannot read: too few particles, nothing that moves."""
    check(name, parameters, place)
    law = import_module(f"{__name__}.{name}").measure
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # where a run has NaN or Inf, so has what is measured, and that is no agreement
            found: list[Measured] = law(frames, **parameters)
    except (LookupError, ArithmeticError) as error:
        message = f"law {name} does not fit this case: {type(error).__name__}: {error}"
        raise InputError(message, place) from None
    return found

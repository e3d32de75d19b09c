"""Closed forms that a case can name, one a file: `measure(frames, ...) -> list[Measured]`.

`frames`: every frame of one engine's run, in steps; the other parameters are those of the case's [[law]] table, by name. A law reads the
outcome off the frames (positions, velocities, spins) and states what the closed form gives for the state of the first frame.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, NamedTuple

from demverify.errors import InputError, Place
from demverify.frames import Frame


class Measured(NamedTuple):
    """One number of a run and what the closed form says. scale: what their difference is relative to; None: |expected|."""

    quantity: str
    step: int
    measured: float
    expected: float
    scale: float | None = None


def listing() -> tuple[str, ...]:
    """Names of the laws, read off the folder."""
    return tuple(sorted(module.name for module in iter_modules(__path__)))


def measure(name: str, frames: Sequence[Frame], parameters: Mapping[str, Any], place: Place) -> list[Measured]:
    """Applies a law. Raises InputError for an unknown law or parameter."""
    if name not in listing():
        message = f"law {name!r} is not one of {', '.join(listing())}"
        raise InputError(message, place)
    law = import_module(f"{__name__}.{name}").measure
    wanted = tuple(inspect.signature(law).parameters)[1:]
    if set(parameters) != set(wanted):
        message = f"law {name} takes {', '.join(wanted) or 'no parameters'}; got {', '.join(parameters) or 'none'}"
        raise InputError(message, place)
    found: list[Measured] = law(frames, **parameters)
    return found

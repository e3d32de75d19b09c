"""Axes of a picture: from numbers to places between 0 and 1, and the ticks to label. No drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from demverify.frames import Floats

TIMES, MINUS, DASH = "\N{MULTIPLICATION SIGN}", "\N{MINUS SIGN}", "\N{EN DASH}"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LONG_RUN = 1000  # steps; beyond, the first 200 of them would be a sliver on a linear axis
_BEND = 50.0  # steps; a long run's axis is linear up to about here and logarithmic after


@dataclass(frozen=True)
class Axis:
    """place: values (k,) -> (k,) in 0..1. ticks: (place, label) pairs. unit: a power of ten to print at the axis, or empty."""

    place: Callable[[Floats], Floats]
    ticks: tuple[tuple[float, str], ...]
    unit: str = ""


def power(exponent: int) -> str:
    """10 to an integer, as text: 10⁻⁹."""
    return "10" + str(exponent).translate(_SUPERSCRIPT)


def scientific(value: float, digits: int = 2) -> str:
    """A number for people: 0, 3.2e-13 with a real superscript, 0.25; a dash for what was not measured. digits: of a mantissa."""
    if not np.isfinite(value):
        return "∞" if np.isinf(value) else DASH
    if value == 0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.3g}".replace("-", MINUS)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    head = "" if mantissa == "1" else mantissa.replace("-", MINUS) + f" {TIMES} "
    return head + power(int(exponent))


def linear(lo: float, hi: float) -> Axis:
    """An axis of round numbers from lo to hi; large and small ones carry a power of ten as unit."""
    lo, hi = (lo, hi) if hi > lo else (lo - (abs(lo) or 1.0) / 2, lo + (abs(lo) or 1.0) / 2)
    exponent = int(np.floor(np.log10(max(abs(lo), abs(hi)))))
    unit = 3 * (exponent // 3) if exponent >= 4 or exponent < -2 else 0
    spacing = _round_up((hi - lo) / 5)
    values = np.arange(np.ceil(lo / spacing - 1e-9), np.floor(hi / spacing + 1e-9) + 1) * spacing
    # The first factor is split off so that 10.0**-unit does not overflow for values near the ends of a double's range.
    labels = [f"{round(v / spacing) * (spacing / 10.0**unit):.4g}".replace("-", MINUS) for v in values]
    ticks = tuple(((v - lo) / (hi - lo), label) for v, label in zip(values, labels, strict=True))
    return Axis(lambda x: (x - lo) / (hi - lo), ticks, f"{TIMES} {power(unit)}" if unit else "")


def decades(lowest: int, highest: int) -> Axis:
    """A logarithmic axis from 10^lowest to 10^highest. Exact zeros, and what is smaller, lie on its foot, labelled 0."""
    stride = max(1, round((highest - lowest) / 6))
    marks = [e for e in range(highest, lowest, -1) if (highest - e) % stride == 0]
    ticks = [((e - lowest) / (highest - lowest), power(e)) for e in marks]

    def place(x: Floats) -> Floats:
        exponents = np.log10(np.maximum(x, 10.0**lowest))
        return np.asarray(np.minimum((exponents - lowest) / (highest - lowest), 1.0))

    return Axis(place, ((0.0, "0"), *ticks))


def logarithmic(lo: float, hi: float) -> Axis:
    """A logarithmic axis from lo to hi, both above 0, labelled at powers of ten; over less than two decades at 2 and 5 times these too."""
    low, high = float(np.log10(lo)), float(np.log10(hi))
    low, high = (low, high) if high > low else (low - 0.5, high + 0.5)
    stride = max(1, round((high - low) / 7))
    whole = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    marks = [(float(e), power(e)) for e in whole if (int(np.floor(high)) - e) % stride == 0]
    if high - low < 2:
        marks += [(e + float(np.log10(m)), f"{m} {TIMES} {power(e)}") for e in whole for m in (2, 5)]
    ticks = tuple(sorted(((e - low) / (high - low), label) for e, label in marks if low - 1e-9 <= e <= high + 1e-9))

    def place(x: Floats) -> Floats:
        known = np.where(np.asarray(x) > 0.0, x, np.nan)
        return np.asarray((np.log10(known) - low) / (high - low))

    return Axis(place, ticks)


def steps(last: float) -> Axis:
    """Steps since the set-up: linear in a short run; in a long one bent, so that all three tiers are seen."""
    if last <= _LONG_RUN:
        return linear(0.0, max(last, 1.0))
    top = np.log1p(last / _BEND)
    factors = (1, 3) if last < 1e6 else (1,)
    marks = [0, 200, *(m * 10**k for k in range(3, 19) for m in factors if m * 10**k <= last)]
    return Axis(lambda x: np.log1p(x / _BEND) / top, tuple((float(np.log1p(m / _BEND) / top), _count(m)) for m in marks))


def _count(value: int) -> str:
    return f"{value:,}".replace(",", " ") if value < 1e6 else scientific(float(value))


def _round_up(value: float) -> float:
    """The next 1, 2 or 5 times a power of ten."""
    base = 10.0 ** np.floor(np.log10(value))
    return float(next(m * base for m in (1, 2, 5, 10) if m * base >= value * (1 - 1e-9)))

"""The printf formats of `dump_modify format` and `thermo_modify format`: which column gets which, and rows of text."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from demverify.errors import InputError, Place

_CONVERSION = re.compile(r"[^%]*%[-+ #0]*\d*(?:\.\d*)?(?:ll|l|L)?(?P<letter>[A-Za-z])[^%]*")
_LETTERS = {True: "di", False: "fFeEgG"}
_ROWS_AT_ONCE = 4096


def column_formats(
    names: Sequence[str],
    integer: Sequence[bool],
    user: Mapping[str, str],
    defaults: tuple[str, str],
    place: Place | None = None,
) -> list[str]:
    """One printf format a column.

    names, integer: the columns and which of them count. defaults: the formats of (counting, measuring) columns.
    user: what the deck asked for: "line" (one format a column, in a row), "int", "float", and a column by its number from 1, its
    number from the end (-1 the last), or its name. A column beats int and float, they beat line, as in LAMMPS.
    Raises InputError for a format that does not fit its column, a line that is too short, a column that is not there.
    """
    line = _line_formats(user.get("line"), len(names), place)
    by_column = _by_column(names, user, place)
    chosen = []
    for i, name in enumerate(names):
        default = defaults[0] if integer[i] else defaults[1]
        fmt = by_column.get(i) or user.get("int" if integer[i] else "float") or line[i] or default
        chosen.append(_checked(fmt, name, integer[i], place))
    return chosen


def _line_formats(line: str | None, n: int, place: Place | None) -> list[str | None]:
    words: list[str | None] = list(line.split()) if line else [None] * n
    if len(words) < n:
        message = f"format line {line!r} has {len(words)} formats for {n} columns"
        raise InputError(message, place)
    return words


def _by_column(names: Sequence[str], user: Mapping[str, str], place: Place | None) -> dict[int, str]:
    n = len(names)
    index = {str(i + 1): i for i in range(n)} | {str(i - n): i for i in range(n)} | {name: i for i, name in enumerate(names)}
    wanted = {key: fmt for key, fmt in user.items() if key not in ("line", "int", "float")}
    for key in wanted:
        if key not in index:
            message = f"format for column {key!r}, but the columns are 1 to {n}: {' '.join(names)}"
            raise InputError(message, place)
    return {index[key]: fmt for key, fmt in wanted.items()}


def _checked(fmt: str, name: str, integer: bool, place: Place | None) -> str:
    match = _CONVERSION.fullmatch(fmt)
    letters = _LETTERS[integer]
    if match is None or match["letter"] not in letters:
        message = f"format {fmt!r} of column {name} is not a printf format with one of {' '.join('%' + c for c in letters)}"
        raise InputError(message, place)
    return fmt


def format_rows(line: str, columns: Sequence[list[int] | list[float]]) -> bytes:
    """Rows of text: `line` (k formats and the newline) filled from k columns of n values each."""
    k, n = len(columns), len(columns[0])
    flat: list[int | float] = [0] * (n * k)
    for j, column in enumerate(columns):
        flat[j::k] = column
    step = _ROWS_AT_ONCE * k
    pieces = (flat[i : i + step] for i in range(0, n * k, step))
    return b"".join((line * (len(piece) // k) % tuple(piece)).encode() for piece in pieces)

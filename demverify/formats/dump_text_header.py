"""The header of a frame in a text dump, its items in any order before that of the rows."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from demverify.errors import InputError
from demverify.formats.cell import general, orthogonal, tilted
from demverify.formats.reading import HalfWrittenError
from demverify.formats.words import number, shown
from demverify.frames import Floats

if TYPE_CHECKING:
    from demverify.formats.text import Text

ITEM = b"ITEM: "
_NUMBER_OF = "NUMBER OF "
_BOX = "BOX BOUNDS"
_ONE_LINE = re.compile(rf"TIMESTEP|TIME|UNITS|LABEL|{_NUMBER_OF}.+")
_COUNT = re.compile(r"\d{1,18}")
_BOUND_OF_LAMMPS = re.compile(rb"-?\d\.\d{16}e[-+]\d\d\d?")  # %-1.16e; LIGGGHTS and old LAMMPS have %g
_NUMBERS = {"": 2, "xy xz yz": 3, "abc origin": 4}  # in a row of BOX BOUNDS


@dataclass(frozen=True)
class Box:
    """bounds, cell and flags as in Frame. exact: the bounds are written as LAMMPS does."""

    bounds: Floats
    cell: Floats | None
    flags: tuple[str, str, str]
    exact: bool


@dataclass(frozen=True)
class Header:
    """What stands before the n rows of a frame. names: of the columns; the rest as in Frame."""

    step: int
    n: int
    box: Box
    time: float | None
    units: str | None
    dialect: Literal["lammps", "liggghts"] | None
    local: bool
    names: list[str]


def read_header(text: Text) -> Header | None:
    """The header that comes next; None at the end of the file. Raises InputError, and HalfWrittenError where the file ends in it."""
    values: dict[str, Any] = {}
    while line := text.line():
        item = _item(line, text)
        key = _BOX if item.startswith(_BOX) else item
        kind = item.partition(" ")[0]
        if key in values:
            message = f"'ITEM: {item}' stands twice in the header of a frame"
            raise InputError(message, text.place())
        if key == _BOX:
            values[key] = _read_box(item.split()[2:], text)
        elif _ONE_LINE.fullmatch(item):
            values[key] = _value(item, _whole_line(text).strip(), text)
        elif kind in ("ATOMS", "ENTRIES") or _NUMBER_OF + kind in values:
            return _complete(values, line, text)
        else:
            message = f"'ITEM: {item}' is no part of a dump of particles or local rows"
            raise InputError(message, text.place())
    if values:
        raise _half_header(text)
    return None


def starts_frame(before: bytes) -> bool:
    """Whether a line `ITEM: ...` is the first of its header, by the lines before it: a header item has at most three lines of values."""
    for line in reversed(before.split(b"\n")[-5:-1]):
        if line.startswith(ITEM):
            item = line.decode("utf-8", "backslashreplace").strip().removeprefix("ITEM: ")
            return not (_ONE_LINE.fullmatch(item) or item.startswith(_BOX))
    return True


def _item(line: bytes, text: Text) -> str:
    """A header line without `ITEM: `."""
    if not line.startswith(ITEM[: len(line)]):
        message = f"expected 'ITEM: ...', got {shown(line)!r}"
        raise InputError(message, text.place())
    if not line.endswith(b"\n"):
        raise _half_header(text)
    return line.decode("utf-8", "backslashreplace").strip().removeprefix("ITEM: ")


def _whole_line(text: Text) -> bytes:
    line = text.line()
    if not line.endswith(b"\n"):
        raise _half_header(text)
    return line


def _half_header(text: Text) -> HalfWrittenError:
    return HalfWrittenError("the file ends inside a frame's header", text.place())


def _value(item: str, word: bytes, text: Text) -> int | float | str:
    """What the line below an item says."""
    if item == "TIME":
        return _finite(word, "ITEM: TIME", text)
    shown_word = word.decode("utf-8", "backslashreplace")
    if item in ("UNITS", "LABEL"):
        return shown_word
    if not _COUNT.fullmatch(shown_word):
        message = f"ITEM: {item} expects a count, got {shown(word)!r}"
        raise InputError(message, text.place())
    return int(shown_word)


def _complete(values: dict[str, Any], line: bytes, text: Text) -> Header:
    """The header that ends with this line, ITEM: ATOMS or the like."""
    kind, *names = line.decode("utf-8", "backslashreplace").split()[1:]
    for item in ("TIMESTEP", _NUMBER_OF + kind, _BOX):
        if item not in values:
            message = f"a frame without ITEM: {item}"
            raise InputError(message, text.place())
    blank = line.rstrip(b"\r\n").endswith(b" ")  # LIGGGHTS and older LAMMPS
    dialect: Literal["lammps", "liggghts"] | None = "lammps" if values[_BOX].exact else "liggghts" if blank else None
    step, n, box = values["TIMESTEP"], values[_NUMBER_OF + kind], values[_BOX]
    return Header(step, n, box, values.get("TIME"), values.get("UNITS"), dialect, kind != "ATOMS", names)


def _finite(word: bytes, what: str, text: Text) -> float:
    try:
        value = number(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        message = f"{what} expects a number, got {shown(word)!r}"
        raise InputError(message, text.place())
    return value


def _read_box(words: list[str], text: Text) -> Box:
    kind, flags = " ".join(words[:-3]), words[-3:]
    if kind not in _NUMBERS or len(flags) != 3 or any(len(flag) != 2 or set(flag) - set("pfsm") for flag in flags):
        message = f"expected three boundary flags such as 'pp ff fs', 'xy xz yz' or 'abc origin' before them or nothing, got {' '.join(words)!r}"
        raise InputError(message, text.place())
    exact, rows = zip(*(_box_row(_NUMBERS[kind], text) for _ in range(3)), strict=True)
    numbers = np.array(rows)
    bounds, place, cell = numbers[:, :2], text.place(), None
    if kind == "abc origin":
        bounds, cell = general(numbers[:, :3], numbers[:, 3], place)
    elif kind:
        bounds, cell = tilted(bounds, numbers[:, 2], place)
    else:
        bounds = orthogonal(bounds, place)
    return Box(bounds, cell, (flags[0], flags[1], flags[2]), all(exact))


def _box_row(n: int, text: Text) -> tuple[bool, list[float]]:
    """Whether it is written as LAMMPS does, and its n numbers."""
    words = _whole_line(text).split()
    if len(words) != n:
        message = f"expected {n} numbers in a row of {_BOX}, got {shown(b' '.join(words))!r}"
        raise InputError(message, text.place())
    return all(map(_BOUND_OF_LAMMPS.fullmatch, words)), [_finite(word, _BOX, text) for word in words]

"""Logs of LAMMPS and LIGGGHTS: the thermo tables (styles one, custom, multi), and why a run stopped."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from demverify.errors import InputError, Place
from demverify.frames import Thermo

_BEFORE_TABLE = ("Per MPI rank memory allocation", "Memory usage per processor")
_AFTER_TABLE = "Loop time of"
_INTERRUPTIONS = ("WARNING", "INFO", "igrpu", "ERROR")
_MULTI = re.compile(r"-+ Step\s+(\d+) -+ CPU =\s*(\S+) \(sec\) -+")
_PAIR = re.compile(r"(\S+)\s*=\s*(\S+)")


class _Tables:
    """Takes the lines of a log one by one and gathers its tables."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.done: list[Thermo] = []
        self._head: list[str] = []
        self._rows: list[list[float]] = []
        self._multi: list[dict[str, float]] = []
        self._expecting = False  # the next line that is no interruption is a header
        self._odd = Place(path), ""  # the last line in a table that is no row

    def take(self, number: int, line: str) -> None:
        if line.startswith(_BEFORE_TABLE):
            self.close()
            self._expecting = True
        elif line.startswith(_AFTER_TABLE):
            self.close(ended=True)
        elif match := _MULTI.match(line):
            self._expecting = False
            self._multi.append({"Step": float(match[1]), "CPU": float(match[2])})
        elif line.split() and not line.startswith(_INTERRUPTIONS):
            self._words(line.split(), line, Place(self.path, number))

    def _words(self, words: list[str], line: str, place: Place) -> None:
        if words == ["---"] and self._expecting:
            message = "a table of thermo_style yaml; expected one, custom or multi"
            raise InputError(message, place)
        if self._expecting or words[0] == "Step":
            self.close()
            self._head, self._expecting = words, False
        elif self._multi:
            for name, value in _PAIR.findall(line):
                self._multi[-1].setdefault(name, _number(value))
        elif self._head and not self._row(words):
            self._odd = place, line.strip()

    def _row(self, words: list[str]) -> bool:
        """Adds a row. False for a line that only interrupts: other words, or a step that does not go on."""
        if len(words) != len(self._head):
            return False
        row = [_number(word) for word in words]
        if any(word.lstrip("-+").lower() != "nan" and np.isnan(value) for word, value in zip(words, row, strict=True)):
            return False
        if "Step" in self._head:
            at = self._head.index("Step")
            if not row[at].is_integer() or (self._rows and row[at] <= self._rows[-1][at]):
                return False
        self._rows.append(row)
        return True

    def close(self, *, ended: bool = False) -> None:
        """The table is over; ended: by the engine's own word."""
        if self._multi:
            columns = tuple(self._multi[0])
            rows = [[row[name] for name in columns] for row in self._multi if len(row) == len(columns)]
            self.done.append(Thermo(columns, np.array(rows, dtype=np.float64)))
        elif self._rows:
            self.done.append(Thermo(tuple(self._head), np.array(self._rows, dtype=np.float64)))
        elif self._head and ended:
            place, line = self._odd
            message = f"a thermo table with columns {' '.join(self._head)} has no row of numbers, but {line!r}"
            raise InputError(message, place)
        self._head, self._rows, self._multi = [], [], []
        self._expecting = False


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return float("nan")


def _lines(path: Path) -> list[str]:
    """Whole lines only: a last one without newline may have lost digits."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        message = f"cannot be read: {error.strerror}"
        raise InputError(message, Place(path)) from None
    return text.split("\n")[:-1]


def read_thermo(path: Path) -> list[Thermo]:
    """One table per `run`, numbers as printed, columns named as the engine prints them (style multi: Step and CPU first).

    Lines that interrupt a table (warnings, LIGGGHTS' INFO and `igrpu: all`, prints) are passed over; a log that stops inside a
    table gives the whole rows. Raises InputError where there is no table at all, or one without numbers.
    """
    tables = _Tables(path)
    for number, line in enumerate(_lines(path), start=1):
        tables.take(number, line)
    tables.close()
    if not tables.done:
        message = "no thermo table in it; expected a log of LAMMPS or LIGGGHTS with a run"
        raise InputError(message, Place(path))
    return tables.done


def merge_runs(tables: Sequence[Thermo]) -> Thermo:
    """One table with the columns that all have, in the order of the first.

    The step at which one run ends and the next begins is printed twice: the later row stays, as in frames.by_step.
    Raises InputError when there is no table, or no column in common.
    """
    common = [name for name in tables[0].columns if all(name in table.columns for table in tables)] if tables else []
    if not common:
        message = "no columns common to the tables: " + " | ".join(" ".join(table.columns) for table in tables)
        raise InputError(message)
    parts = [np.column_stack([table[name] for name in common]) for table in tables]
    if "Step" in common:
        at = common.index("Step")
        parts = [
            part[:-1] if later is not None and part[-1, at] == later[0, at] else part
            for part, later in zip(parts, [*parts[1:], None], strict=True)
        ]
    return Thermo(tuple(common), np.concatenate(parts))


def last_error(path: Path) -> str | None:
    """The last ERROR line of a log, with the input line that LAMMPS shows under it; None if there is none."""
    lines = _lines(path)
    places = [i for i, line in enumerate(lines) if line.startswith("ERROR")]
    if not places:
        return None
    after = [line for line in lines[places[-1] + 1 :][:1] if line.startswith("Last ")]
    return " | ".join(line.strip() for line in [lines[places[-1]], *after])


def warnings_in(path: Path) -> list[str]:
    """The WARNING lines of a log, each once, in order."""
    return list(dict.fromkeys(line.strip() for line in _lines(path) if line.startswith("WARNING")))

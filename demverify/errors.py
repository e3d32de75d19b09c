"""Errors a user can mend: one line that says what, where, what was expected and what exists. The CLI prints them and exits with 2."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Place:
    """Where in the user's input: a file and a line (1-based; 0 when the file as a whole is meant)."""

    file: Path
    line: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" if self.line else str(self.file)


class InputError(ValueError):
    """Bad input: a deck, a data file, a dump, an option. `str(error)` is one line, ending with the place when it is known."""

    def __init__(self, message: str, place: Place | None = None) -> None:
        self.message = message
        self.place = place
        super().__init__(f"{place}: {message}" if place else message)

    def __reduce__(self) -> tuple[Any, ...]:
        """Message and place survive the way from one process to another."""
        return type(self), (self.message, self.place)

"""What both dialects need to read contact laws off a deck: a cursor over words, numbers with a place, tables per type pair."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, isfinite

import numpy as np

from demverify.deck.setup import Floats, Setup, Spec
from demverify.errors import InputError, Place

AXES = ("x", "y", "z")


class Words:
    """The words of one command, taken from left to right. `what` names the command in messages."""

    def __init__(self, words: Iterable[str], what: str, place: Place | None) -> None:
        """A cursor in front of the first word."""
        self._words = list(words)
        self.what = what
        self.place = place

    def __bool__(self) -> bool:
        """Whether words are left."""
        return bool(self._words)

    def peek(self) -> str:
        """The next word, or "" at the end."""
        return self._words[0] if self._words else ""

    def take(self, wanted: str) -> str:
        """The next word. Raises InputError at the end, naming what was wanted."""
        if not self._words:
            raise self.error(f"ends where {wanted} was expected")
        return self._words.pop(0)

    def skip(self, word: str) -> bool:
        """Takes the next word if it is `word`."""
        if self.peek() != word:
            return False
        self._words.pop(0)
        return True

    def choice(self, wanted: str, known: Iterable[str]) -> str:
        """The next word, which must be one of `known`."""
        word, known = self.take(wanted), tuple(known)
        if word not in known:
            raise self.error(f"{wanted} {word!r} is not one of {', '.join(known)}")
        return word

    def number(self, wanted: str, low: float = -inf, high: float = inf) -> float:
        """The next word as a finite number of [low, high]."""
        word = self.take(wanted)
        try:
            value = inf if "_" in word else float(word)
        except ValueError:
            value = inf
        if not isfinite(value):
            raise self.error(f"{wanted} must be a number, got {word!r}")
        return self.within(wanted, value, low, high)

    def positive(self, wanted: str) -> float:
        """The next word as a finite number above zero."""
        value = self.number(wanted)
        if value <= 0.0:
            raise self.error(f"{wanted} must be positive, got {value:g}")
        return value

    def number_or(self, wanted: str, default: float, low: float = -inf, high: float = inf) -> float:
        """As `number`, with NULL standing for `default`."""
        return default if self.skip("NULL") else self.number(wanted, low, high)

    def integer(self, wanted: str, low: float = -inf, high: float = inf) -> int:
        """The next word as a whole number of [low, high]."""
        word = self.take(wanted)
        try:
            value = int("no" if "_" in word else word)
        except ValueError:
            raise self.error(f"{wanted} must be a whole number, got {word!r}") from None
        return int(self.within(wanted, value, low, high))

    def within(self, wanted: str, value: float, low: float, high: float) -> float:
        """`value` if it lies in [low, high], else an InputError."""
        if low <= value <= high:
            return value
        bounds = f"at least {low:g}" if high == inf else f"from {low:g} to {high:g}"
        raise self.error(f"{wanted} must be {bounds}, got {value:g}")

    def end(self) -> None:
        """Raises InputError when words are left."""
        if self._words:
            raise self.error(f"does not know {self._words[0]!r} at this point")

    def error(self, message: str) -> InputError:
        """An InputError about this command."""
        return InputError(f"{self.what} {message}", self.place)


def group_bit(setup: Setup, spec: Spec) -> int:
    """The bit of a fix's group."""
    if spec.group not in setup.groups:
        message = f"fix {spec.id}: group {spec.group!r} is not one of {', '.join(setup.groups)}"
        raise InputError(message, spec.place)
    return setup.groups[spec.group]


def shear(words: Words) -> tuple[int, float]:
    """`DIM V` behind the word shear: axis and number."""
    return AXES.index(words.choice("shear direction", AXES)), words.number("shear velocity")


def pair_tables(ntypes: int, pairs: dict[tuple[int, int], dict[str, float]]) -> dict[str, Floats]:
    """Per coefficient a symmetric (ntypes, ntypes) table, from the coefficients of the type pairs i <= j, counted from 1."""
    tables = {name: np.empty((ntypes, ntypes)) for name in pairs[1, 1]}
    for (i, j), coefficients in pairs.items():
        for name, table in tables.items():
            table[i - 1, j - 1] = table[j - 1, i - 1] = coefficients[name]
    return tables

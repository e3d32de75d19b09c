"""A command about to be executed, and the table of the commands there are."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from demverify.deck.materials_common import Words
from demverify.errors import Place

if TYPE_CHECKING:
    from demverify.deck.interpreter import Interpreter


class Command(Words):
    """One command with its variables substituted: a cursor over its arguments that knows the whole line too.

    name: first word. args: the words after it. text: the line. place: where it was written."""

    place: Place

    def __init__(self, name: str, args: Sequence[str], text: str, place: Place) -> None:
        """`args`: the words after the name."""
        super().__init__(args, name, place)
        self.name = name
        self.args = tuple(args)
        self.text = text

    def rest(self) -> tuple[str, ...]:
        """All words that are left."""
        words = []
        while self:
            words.append(self.take("a word"))
        return tuple(words)

    def positive(self, wanted: str) -> float:
        """The next word as a finite number above zero."""
        value = self.number(wanted)
        if value <= 0.0:
            raise self.error(f"{wanted} must be above zero, got {value:g}")
        return value

    def vector(self, *wanted: str) -> tuple[float, ...]:
        """The next words as numbers."""
        return tuple(self.number(name) for name in wanted)

    def yes(self, wanted: str) -> bool:
        """The next word as yes/no, or on/off, or true/false."""
        return self.choice(wanted, ("yes", "no", "on", "off", "true", "false")) in ("yes", "on", "true")


@dataclass(frozen=True)
class Executed:
    """A command that has been executed, with its variables substituted: what `convert` writes out again."""

    words: tuple[str, ...]
    text: str
    place: Place


Handler = Callable[["Interpreter", Command], None]
_HANDLERS: dict[str, Handler] = {}


def command(*names: str) -> Callable[[Handler], Handler]:
    """Registers a function as what the commands `names` do."""

    def register(handler: Handler) -> Handler:
        _HANDLERS.update(dict.fromkeys(names, handler))
        return handler

    return register


def handlers() -> dict[str, Handler]:
    """Every command there is, by name: all of `demverify.deck.commands` is imported."""
    package = importlib.import_module("demverify.deck.commands")
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"demverify.deck.commands.{module.name}")
    return _HANDLERS

"""Executes a deck command by command and fills a Setup. What needs a simulation is asked of a backend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from demverify.deck.command import Command, Executed, Handler, handlers
from demverify.deck.lexer import Line, parse_deck, read_deck, split_words
from demverify.deck.setup import Dialect, Setup
from demverify.deck.variables import Variables
from demverify.errors import InputError, Place

if TYPE_CHECKING:
    from demsolver.memories import Memories
    from demverify.deck.restart import Restart

_CONTROL = ("include", "jump", "label", "next", "if", "quit")  # unrolled: `executed` holds what they led to, not them
_MOST_COMMANDS = 100_000  # more than any deck needs; a `jump` without an end stops here
_MOST_FILES = 16  # nested includes, as LAMMPS


class Backend(Protocol):
    """What runs the simulation while a deck is read."""

    def run(self, setup: Setup, steps: int) -> None:
        """Runs and brings setup.atoms, .step and .time (and .box where faces shrink) up to date."""

    def value(self, setup: Setup, keyword: str) -> float:
        """A value for a formula: a thermo keyword, c_ID, c_ID[i], f_ID, a group function as `mass(all)`, a particle's as `x[3]`.

        `demverify.deck.state_values.state_value` knows those that follow from the setup. Raises InputError for others."""

    def memories(self, setup: Setup) -> Memories | None:
        """What the contacts remember now; None before the first run."""

    def keep(self, state: Restart, name: str) -> None:
        """Keeps a state under a file name. Raises InputError where no such file can be."""

    def kept(self, name: str, folder: Path) -> Restart:
        """The state under a name (`*`: that of the largest step), kept by this deck or else a file in `folder`. Raises InputError."""

    def cleared(self) -> None:
        """The deck said clear: no simulation goes on."""


class Quit(Exception):
    """The deck said quit."""


class _Cursor:
    """A file being executed, and the next line of it."""

    def __init__(self, path: Path, lines: list[Line]) -> None:
        self.path = path
        self.lines = lines
        self.at = 0


class Interpreter:
    """Runs decks of one dialect.

    variables: name -> values given on the command line. setup: the state so far. executed: every command with its variables
    substituted, loops unrolled. ignored: the commands that cannot change the physics. printed: what print commands said.
    """

    def __init__(
        self, dialect: Dialect, variables: Mapping[str, Sequence[str]] | None = None, backend: Backend | None = None
    ) -> None:
        """A deck starts from an empty setup; without a backend runs are only noted (DryBackend)."""
        from demverify.deck.dry import DryBackend

        self.backend: Backend = backend or DryBackend()
        self.setup = Setup(dialect=dialect)
        self.variables = Variables(self._live, variables)
        self.setup.variables = self.variables
        self.executed: list[Executed] = []
        self.ignored: list[Executed] = []
        self.printed: list[str] = []
        self.folder = Path()  # relative names in a deck are looked up here, as if the engine ran in the deck's folder
        self.skip_jump = False
        self._cursors: list[_Cursor] = []
        self._handlers: dict[str, Handler] = handlers()
        self._count = 0
        self._place = Place(Path())

    def run_deck(self, path: Path) -> Setup:
        """Executes a whole deck. Raises InputError at the first command that is wrong or not supported."""
        self.folder = self.setup.folder = path.parent
        self._start(_Cursor(path, read_deck(path)))
        return self.setup

    def run_text(self, text: str, file: Path = Path("deck")) -> Setup:
        """Executes a deck given as text; `file` names it in messages."""
        self._start(_Cursor(file, parse_deck(text, file)))
        return self.setup

    def include(self, name: str, place: Place) -> None:
        """Executes another file now."""
        if len(self._cursors) >= _MOST_FILES:
            raise InputError(f"more than {_MOST_FILES} files include each other", place)
        self._execute(_Cursor(self.find_file(name), self._read(name, place)))

    def jump(self, name: str, label: str | None, place: Place) -> None:
        """Goes on at a label of a file (SELF: this one), or at its start."""
        cursor = self._cursors[-1]
        lines, path = (cursor.lines, cursor.path) if name == "SELF" else (self._read(name, place), self.find_file(name))
        self._cursors[-1].lines, self._cursors[-1].path = lines, path
        cursor.at = 0 if label is None else _label_index(lines, label, path, place)

    def one(self, line: Line) -> None:
        """Executes one command."""
        self._count += 1
        if self._count > _MOST_COMMANDS:
            raise InputError(f"the deck ran {_MOST_COMMANDS} commands without coming to an end", line.place)
        self._place = line.place
        text = self.variables.substitute(line.text, line.place)
        words = split_words(text, line.place)
        if words:
            self._dispatch(Command(words[0], words[1:], text, line.place))

    def ignore(self, cmd: Command) -> None:
        """Notes that a command was read and has no effect on the physics."""
        self.ignored.append(Executed((cmd.name, *cmd.args), cmd.text, cmd.place))

    def find_file(self, name: str) -> Path:
        """The path a name in the deck means."""
        return self.folder / Path(name).expanduser()

    def _dispatch(self, cmd: Command) -> None:
        handler = self._handlers.get(cmd.name)
        if handler is None:
            known = ", ".join(sorted(self._handlers))
            raise InputError(f"command {cmd.name!r} is not supported; supported: {known}", cmd.place)
        if cmd.name not in _CONTROL:
            self.executed.append(Executed((cmd.name, *cmd.args), cmd.text, cmd.place))
        try:
            handler(self, cmd)
        except InputError as error:
            raise error if error.place else type(error)(error.message, cmd.place) from None

    def _start(self, cursor: _Cursor) -> None:
        try:
            self._execute(cursor)
        except Quit:
            return

    def _execute(self, cursor: _Cursor) -> None:
        self._cursors.append(cursor)
        while cursor.at < len(cursor.lines):
            cursor.at += 1
            self.one(cursor.lines[cursor.at - 1])
        self._cursors.pop()

    def _read(self, name: str, place: Place) -> list[Line]:
        path = self.find_file(name)
        if not path.is_file():
            raise InputError(f"the file {name!r} does not exist (looked for {path})", place)
        return read_deck(path)

    def _live(self, keyword: str) -> float:
        try:
            return self.backend.value(self.setup, keyword)
        except InputError as error:
            raise type(error)(error.message, self._place) from None


def _label_index(lines: list[Line], label: str, path: Path, place: Place) -> int:
    for index, line in enumerate(lines):
        words = line.text.split()
        if words[0] == "label" and words[1:2] == [label]:
            return index
    raise InputError(f"label {label!r} is not in {path}", place)

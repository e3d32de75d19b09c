"""The commands of any deck, each once and from top to bottom, with what is known of their variables.

Not the order in which an engine executes them: a loop is read once, an `if` is decided where its test is known, and where not its
commands come marked as uncertain. What cannot be followed is noted, and reading goes on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from demverify.deck.command import Command
from demverify.deck.lexer import Line, read_deck, split_words
from demverify.deck.variables import STYLES, Variables
from demverify.errors import InputError, Place

UNKNOWN = "\0"
"""Stands in a word for a value that is not known. No text file holds this character."""
_MOST_COMMANDS = 100_000
_MOST_FILES = 16  # nested, as LAMMPS
_MOST_TIMES = 100  # that one file is read
_FIRST_WINS = ("index", "loop", "world", "universe", "uloop", "file")
_LONGEST = 10_000  # characters of a variable; a string that doubles itself line by line stops here


class _Ended(Exception):
    """Nothing of the deck is left to read."""


class Spoken(Command):
    """A command as far as it is known. certain: False inside an `if` whose test is not known. unknown: why words are not known."""

    place: Place

    def __init__(self, words: Sequence[str], text: str, place: Place, *, certain: bool, unknown: Sequence[str]) -> None:
        """words: with the name of the command first."""
        super().__init__(words[0], words[1:], text, place)
        self.certain = certain
        self.unknown = tuple(unknown)

    @property
    def where(self) -> str:
        """Its place in short."""
        return f"{self.place.file.name}:{self.place.line}"

    def take(self, wanted: str) -> str:
        """The next word. Raises InputError at the end, and for a word that is not known."""
        word = super().take(wanted)
        if UNKNOWN in word:
            raise self.error(f"{wanted} is not known: {'; '.join(dict.fromkeys(self.unknown))}")
        return word

    def sure(self) -> None:
        """Raises InputError unless it is certain that the command is executed."""
        if not self.certain:
            raise self.error("stands in an `if` whose test is not known")

    def after(self, keyword: str) -> Spoken:
        """A cursor behind the first argument that is `keyword`. Raises InputError when there is none."""
        if keyword not in self.args:
            raise self.error(f"has no keyword {keyword}")
        words = (self.name, *self.args[self.args.index(keyword) + 1 :])
        return Spoken(words, self.text, self.place, certain=self.certain, unknown=self.unknown)


class KnownVariables(Variables):
    """The variables whose value can be told without running. In `substitute` the others become UNKNOWN, and `unknown` says why."""

    def __init__(self, initial: Mapping[str, Sequence[str]]) -> None:
        """initial: values from the command line."""
        super().__init__(_only_a_run_knows, initial)
        self.unknown: list[str] = []
        self._why: dict[str, str] = {}
        self._moving: set[str] = set()
        self._chosen = {name for name, values in initial.items() if len(values) == 1}

    def text(self, name: str, place: Place) -> str:
        """What ${name} stands for. Raises InputError for a value that is not known."""
        if name in self._moving:
            raise InputError(f"variable {name} takes several values in turn", place)
        if name in self._why:
            raise InputError(self._why[name], place)
        value = super().text(name, place)
        if len(value) > _LONGEST:
            raise InputError(f"the text of variable {name} is longer than {_LONGEST} characters", place)
        return value

    def moves(self, names: Iterable[str]) -> None:
        """`next` gives the variables one value after another: with which of them a file was written is not known."""
        self._moving.update(set(names) - self._chosen)

    def learn(self, cmd: Spoken) -> None:
        """Executes a `variable` command. What it cannot tell makes the variable unknown."""
        name, style = (*cmd.args, "", "")[:2]
        if style in _FIRST_WINS and (name in self._table or name in self._why):
            return
        try:
            if not cmd.certain or style not in STYLES or UNKNOWN in "".join(cmd.args):
                raise cmd.error("is not known")
            args = [self.substitute(word, cmd.place) for word in cmd.args[2:]] if style == "string" else cmd.args[2:]
            self.define(name, style, args, cmd.place)
        except InputError:
            self._why[name] = f"variable {name}, set in {cmd.where}, is not known"
        else:
            self._why.pop(name, None)

    def _expand(self, text: str, at: int, place: Place) -> tuple[str, int]:
        try:
            return super()._expand(text, at, place)
        except InputError as error:
            self.unknown.append(error.message)
            return UNKNOWN, _end_of_reference(text, at)


def _only_a_run_knows(keyword: str) -> float:
    message = f"only a run knows {keyword}"
    raise InputError(message)


def _end_of_reference(text: str, at: int) -> int:
    """The index behind what follows a $, in a text where it may have no end."""
    pair = {"{": "{}", "(": "()"}.get(text[at : at + 1], "")
    depth = 0
    for index in range(at, len(text) if pair else at):
        depth += (text[index] == pair[0]) - (text[index] == pair[1])
        if depth == 0:
            return index + 1
    return len(text) if pair else min(at + 1, len(text))


class Script:
    """A deck and the files it includes. folder: where relative names in it are looked up. passed_over: what could not be followed."""

    def __init__(self, path: Path, variables: Mapping[str, Sequence[str]]) -> None:
        """Raises InputError for a deck that cannot be read at all."""
        self.folder = path.parent
        self.variables = KnownVariables(variables)
        self.passed_over: list[str] = []
        self._files: dict[Path, list[Line]] = {}
        self._path = path
        self._lines(path)
        self._jumped = {path}
        self._times: Counter[Path] = Counter()
        self._open: list[Path] = []
        self._count = 0
        self._after_next = False

    def commands(self) -> Iterator[Spoken]:
        """Every command but those that only steer. `include` and `jump` come through when their file cannot be read."""
        try:
            yield from self._follow(self._path, certain=True)
        except _Ended:
            return

    def find_file(self, name: str) -> Path:
        """The path that a name in the deck means."""
        return self.folder / name

    def note(self, error: InputError, place: Place) -> None:
        """Notes that something was passed over, once; of a fault in another file also where in that file."""
        other = error.place is not None and error.place.file != place.file
        text = str(InputError(str(error) if other else error.message, place))
        if text not in self.passed_over:
            self.passed_over.append(text)

    def _lines(self, path: Path) -> list[Line]:
        if path not in self._files:
            self._files[path] = read_deck(path)
            for line in self._files[path]:
                words = line.text.split()
                self.variables.moves(words[1:] if words[0] == "next" else ())
        return self._files[path]

    def _follow(self, path: Path, *, certain: bool) -> Iterator[Spoken]:
        lines = self._lines(path)
        self._open.append(path)
        at = 0
        while at < len(lines):
            waiting = [(lines[at], certain)]
            at += 1
            while waiting:
                cmd = self._hear(*waiting.pop(0))
                if cmd is None:
                    continue
                if cmd.name == "if":
                    waiting[:0] = self._branches(cmd)
                elif cmd.name == "jump":
                    at = yield from self._jump(cmd, at)
                else:
                    yield from self._one(cmd)
        self._open.pop()

    def _hear(self, line: Line, certain: bool) -> Spoken | None:
        self._count += 1
        if self._count > _MOST_COMMANDS:
            self.note(InputError(f"the deck goes on after {_MOST_COMMANDS} commands"), line.place)
            raise _Ended
        self.variables.unknown.clear()
        try:
            text = self.variables.substitute(line.text, line.place)
            words = split_words(text, line.place)
        except InputError as error:
            self.note(error, line.place)
            return None
        return Spoken(words, text, line.place, certain=certain, unknown=self.variables.unknown) if words else None

    def _one(self, cmd: Spoken) -> Iterator[Spoken]:
        if cmd.name == "next":
            self._after_next = True
        elif cmd.name == "quit" and cmd.certain:
            raise _Ended
        elif cmd.name == "include":
            yield from self._include(cmd)
        elif cmd.name == "partition" and len(cmd.args) > 2:
            yield Spoken(cmd.args[2:], cmd.text, cmd.place, certain=False, unknown=cmd.unknown)
        else:
            if cmd.name == "variable":
                self.variables.learn(cmd)
            yield cmd

    def _include(self, cmd: Spoken) -> Iterator[Spoken]:
        path = self._readable(cmd)
        if path is None:
            yield cmd
        else:
            yield from self._follow(path, certain=cmd.certain)

    def _jump(self, cmd: Spoken, at: int) -> Generator[Spoken, None, int]:
        """Forward to a label, or once to another file; never back. Returns the line to go on with."""
        looping, self._after_next = self._after_next, False  # such a jump is skipped in the end
        target = None if cmd.peek() == "SELF" else self._readable(cmd)
        if target is None and cmd.peek() != "SELF":
            yield cmd
        elif target is None or target == self._open[-1]:
            return at if looping or not cmd.certain else _forward(self._lines(self._open[-1]), at, cmd.args[-1])
        elif target not in self._jumped:
            self._jumped.add(target)
            yield from self._follow(target, certain=cmd.certain)
            if cmd.certain and not looping:
                raise _Ended
        return at

    def _readable(self, cmd: Spoken) -> Path | None:
        """The file that a command leads to, or None when it cannot be read."""
        try:
            path = self.find_file(cmd.take("a file"))
            self._lines(path)
            self._times[path] += 1
            if len(self._open) >= _MOST_FILES or self._times[path] > _MOST_TIMES:
                raise cmd.error(f"leads to {path.name} more than {_MOST_FILES} deep or {_MOST_TIMES} times")
        except InputError as error:
            self.note(error, cmd.place)
            return None
        return path

    def _branches(self, cmd: Spoken) -> list[tuple[Line, bool]]:
        """The commands of an `if` that are executed, or may be, and whether they are."""
        groups: list[list[str]] = []
        for word in ("elif", *cmd.args[:1], *cmd.args[2:]):
            if word in ("elif", "else"):
                groups.append(["1"] if word == "else" else [])
            else:
                groups[-1].append(word)
        found: list[tuple[Line, bool]] = []
        certain = cmd.certain
        for test, *commands in filter(None, groups):
            holds = self._holds(test, cmd.place)
            certain = certain and holds is not None
            if holds is not False:
                found += [(Line(text, cmd.place), certain) for text in commands]
            if holds:
                break
        return found

    def _holds(self, test: str, place: Place) -> bool | None:
        """The test of an `if`; None: not known."""
        try:
            text = self.variables.substitute(test, place)
            return None if UNKNOWN in text else self.variables.condition(text, place)
        except InputError:
            return None


def _forward(lines: list[Line], at: int, label: str) -> int:
    """The index of a label further down, or `at`."""
    return next((i for i in range(at, len(lines)) if lines[i].text.split()[:2] == ["label", label]), at)

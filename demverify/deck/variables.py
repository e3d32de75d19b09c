"""Variables of a deck and their substitution: ${name}, $x, $(formula), $(formula:%.3f). Numbers become text as the engines do it:
%.15g for ${name} of an equal-style variable and for v_name inside a formula, %.20g for $(...) (measured on both engines)."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy, deepcopy
from dataclasses import dataclass

from demsolver.expression import Expression, Number
from demverify.deck.atom_formula import read_atom_formula, steady_value
from demverify.deck.formula import FormulaError, Names, evaluate, evaluate_condition
from demverify.deck.setup import Setup
from demverify.errors import InputError, Place

STYLES = ("index", "loop", "string", "equal", "atom", "format", "delete")
_QUOTE = re.compile(r'"""|"|\'|\$')
_IMMEDIATE_FORMAT = re.compile(r"^(.*):(%[^:]*)$", re.DOTALL)
_PRINTF = re.compile(r"%[-+ 0#]*\d{0,3}(\.\d{1,3})?[eEfFgG]")


@dataclass
class _Values:
    """index (moves on by `next`) and string (one value)."""

    style: str
    values: tuple[str, ...]
    at: int = 0


@dataclass
class _Loop:
    at: int
    last: int
    width: int = 0
    style: str = "loop"


@dataclass
class _Formula:
    """equal: a formula. atom: one of each particle. format: the name of another variable, and how to print it."""

    style: str
    text: str
    printf: str = "%.15g"


class Variables:
    """The variables of one deck.

    live: values that belong to the simulation (`step`, `c_ID[2]`, `mass(all)`, `x[3]`), asked for when a formula needs them.
    initial: name -> values from the command line; such a variable wins over `variable NAME index` in the deck, as -var does."""

    def __init__(self, live: Callable[[str], float], initial: Mapping[str, Sequence[str]] | None = None) -> None:
        """A table that holds the variables of the command line."""
        self._live = live
        self._table: dict[str, _Values | _Loop | _Formula] = {}
        self._open: list[str] = []  # equal-style variables being evaluated, to see a circle
        for name, values in (initial or {}).items():
            self._table[name] = _Values("index", tuple(values))

    def define(self, name: str, style: str, args: Sequence[str], place: Place) -> None:
        """Executes `variable name style args...`. Raises InputError."""
        if not re.fullmatch(r"\w+", name, re.ASCII):
            raise InputError(f"variable name {name!r} may hold letters, digits and underscores only", place)
        if style not in STYLES:
            raise InputError(f"variable style {style!r} is not supported; supported: {', '.join(STYLES)}", place)
        if style == "delete":
            self._table.pop(name, None)
        elif style in ("index", "loop") and name in self._table:
            return  # set first wins
        else:
            self._check_style(name, style, place)
            self._table[name] = _new(name, style, args, place)

    def _check_style(self, name: str, style: str, place: Place) -> None:
        if name in self._table and self._table[name].style != style:
            raise InputError(f"variable {name} is of style {self._table[name].style} and cannot become {style}", place)

    def next(self, names: Sequence[str], place: Place) -> bool:
        """Moves index and loop variables on. True when one ran out; such a variable is deleted."""
        if not names:
            raise InputError("next expects the name of a variable", place)
        exhausted = False
        for name in names:
            variable = self._find(name, place)
            if isinstance(variable, _Formula) or variable.style == "string":
                raise InputError(f"next works on index and loop variables; {name} is of style {variable.style}", place)
            variable.at += 1
            if variable.at > (variable.last if isinstance(variable, _Loop) else len(variable.values) - 1):
                del self._table[name]
                exhausted = True
        return exhausted

    def text(self, name: str, place: Place) -> str:
        """What ${name} stands for. Raises InputError."""
        variable = self._find(name, place)
        if variable.style == "atom":
            raise InputError(f"variable {name} is of style atom: it has a value for each particle, not one", place)
        if isinstance(variable, _Values):
            return variable.values[variable.at]
        if isinstance(variable, _Loop):
            return f"{variable.at:0{variable.width}d}"
        if variable.style == "format":
            return variable.printf % self.number(variable.text, place)
        return variable.printf % self._formula_of(name, variable.text, place)

    def number(self, name: str, place: Place) -> float:
        """The value of v_name: its text as a number, hence 15 digits of an equal-style variable, as in the engines."""
        text = self.text(name, place)
        try:
            return float(text)
        except ValueError:
            raise InputError(f"variable {name} is not a number: {text!r}", place) from None

    def exact(self, name: str, place: Place) -> float:
        """The value of an equal-style variable in all digits, as in thermo columns; others as `number`."""
        variable = self._find(name, place)
        if isinstance(variable, _Formula) and variable.style == "equal":
            return self._formula_of(name, variable.text, place)
        return self.number(name, place)

    def is_of_particles(self, name: str, place: Place) -> bool:
        """Whether the variable has a value for each particle. Raises InputError where there is none of that name."""
        return self._find(name, place).style == "atom"

    def at(self, clock: Mapping[str, float]) -> Variables:
        """The same variables at another time: of the simulation they know these values alone, and say so of others."""

        def live(name: str) -> float:
            if name not in clock:
                raise FormulaError(f"{name} is not one of {', '.join(clock)}, on which alone it may depend here")
            return clock[name]

        other = copy(self)
        other._live = live
        return other

    def expression(self, name: str, setup: Setup, place: Place) -> Expression:
        """What v_name stands for in each step of a run, of an equal-style or atom-style variable. Raises InputError."""
        variable = self._find(name, place)
        if variable.style not in ("equal", "atom"):
            raise InputError(f"variable {name} is of style {variable.style}; expected equal or atom", place)
        steady = copy(self)
        steady._live = lambda keyword: steady_value(keyword, setup.dt, setup.dialect)
        if variable.style == "equal":
            return Number(steady.exact(name, place))
        return steady._expression_of(name, setup, place)

    def _expression_of(self, name: str, setup: Setup, place: Place) -> Expression:
        variable = self._find(name, place)
        if not (isinstance(variable, _Formula) and variable.style == "atom"):
            return Number(self.number(name, place))
        with self._opened(name, place):
            try:
                return read_atom_formula(variable.text, setup.dialect, lambda inner: self._expression_of(inner, setup, place), self._live)
            except FormulaError as error:
                raise InputError(f"variable {name}, formula {variable.text!r}: {error}", place) from None

    def snapshot(self) -> Variables:
        """The variables as they are now: what the deck defines later does not change them."""
        kept = copy(self)
        kept._table = deepcopy(self._table)
        return kept

    def evaluate(self, formula: str, place: Place) -> float:
        """The value of a formula. Raises InputError naming the formula and what is wrong with it."""
        try:
            return evaluate(formula, self._names(place))
        except FormulaError as error:
            raise InputError(f"formula {formula!r}: {error}", place) from None

    def condition(self, text: str, place: Place, *, of_numbers: bool = False) -> bool:
        """The test of an `if` command. of_numbers: one of strings is refused, as LIGGGHTS does. Raises InputError."""
        try:
            return evaluate_condition(text, self._names(place), of_numbers=of_numbers)
        except FormulaError as error:
            raise InputError(f"condition {text!r}: {error}", place) from None

    def substitute(self, text: str, place: Place) -> str:
        """The text with every $ outside quotes replaced. Raises InputError for a variable that does not exist."""
        out = []
        at, quote = 0, ""
        while found := _QUOTE.search(text, at):
            out.append(text[at : found.start()])
            at = found.end()
            if found[0] == "$" and not quote:
                value, at = self._expand(text, at, place)
                out.append(value)
                continue
            quote = "" if found[0] == quote else quote or (found[0] if found[0] != "$" else "")
            out.append(found[0])
        return "".join(out) + text[at:]

    def _expand(self, text: str, at: int, place: Place) -> tuple[str, int]:
        """The value of what follows a $, and the index behind it."""
        if text.startswith("{", at):
            end = text.find("}", at)
            if end < 0:
                raise InputError("expected } to close ${", place)
            return self.text(text[at + 1 : end], place), end + 1
        if text.startswith("(", at):
            end = _closing(text, at, place)
            return self._immediate(text[at + 1 : end], place), end + 1
        if at >= len(text) or text[at].isspace():
            raise InputError("expected a variable name after $", place)
        return self.text(text[at], place), at + 1

    def _immediate(self, inside: str, place: Place) -> str:
        found = _IMMEDIATE_FORMAT.match(inside)
        formula, printf = (found[1], found[2]) if found else (inside, "%.20g")
        if not _PRINTF.fullmatch(printf):
            raise InputError(f"$({inside}): expected a format for one number such as %.3f, got {printf!r}", place)
        return printf % self.evaluate(formula, place)

    def _formula_of(self, name: str, formula: str, place: Place) -> float:
        with self._opened(name, place):
            return self.evaluate(formula, place)

    @contextmanager
    def _opened(self, name: str, place: Place) -> Iterator[None]:
        if name in self._open:
            raise InputError(f"variable {name} is defined by itself: {' -> '.join([*self._open, name])}", place)
        self._open.append(name)
        try:
            yield
        finally:
            self._open.pop()

    def _names(self, place: Place) -> Names:
        return Names(lambda name: self.number(name, place), self._live)

    def _find(self, name: str, place: Place) -> _Values | _Loop | _Formula:
        if name not in self._table:
            raise InputError(f"variable {name!r} is not defined; defined: {', '.join(sorted(self._table)) or 'none'}", place)
        return self._table[name]


def _new(name: str, style: str, args: Sequence[str], place: Place) -> _Values | _Loop | _Formula:
    if style == "loop":
        return _new_loop(name, list(args), place)
    if not args:
        raise InputError(f"variable {name} {style} expects a value", place)
    if style in ("equal", "atom"):
        return _Formula(style, " ".join(args))
    if style == "index":
        return _Values(style, tuple(args))
    if style == "string" and len(args) == 1:
        return _Values(style, (args[0],))
    if style == "format" and len(args) == 2 and _PRINTF.fullmatch(args[1]):
        return _Formula(style, args[0], args[1])
    expected = "one value; put quotes around blanks" if style == "string" else "the name of a variable and a format such as %.3f"
    raise InputError(f"variable {name} {style} expects {expected}, got {' '.join(args)!r}", place)


def _new_loop(name: str, args: list[str], place: Place) -> _Loop:
    padded = bool(args) and args[-1] == "pad"
    numbers = args[:-1] if padded else args
    if len(numbers) not in (1, 2) or not all(re.fullmatch(r"[-+]?\d{1,18}", number) for number in numbers):
        raise InputError(f"variable {name} loop expects N, or N1 N2, whole numbers, got {' '.join(args)!r}", place)
    first, last = (1, int(numbers[0])) if len(numbers) == 1 else (int(numbers[0]), int(numbers[1]))
    if first > last or last <= 0:
        raise InputError(f"variable {name} loop: {first} to {last} is empty", place)
    return _Loop(first, last, len(str(last)) if padded else 0)


def _closing(text: str, at: int, place: Place) -> int:
    """Index of the parenthesis that closes the one at `at`."""
    depth = 0
    for index in range(at, len(text)):
        depth += {"(": 1, ")": -1}.get(text[index], 0)
        if depth == 0:
            return index
    raise InputError("expected ) to close $(", place)

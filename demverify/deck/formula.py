"""Formulas of variables, read as LAMMPS does: every binary operator binds to the left (2^3^2 = 64) and the unary
minus binds tighter than the power (-2^2 = 4). Measured on LAMMPS of 22 July 2025, see tests/demverify/deck/test_formula.py."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from demsolver.expression import FUNCTIONS, call

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z]\w*)|(?P<op>\|\||&&|\|\^|==|!=|<=|>=|[-+*/^%<>!()\[\],]))"
)
_LEVELS = (("||", "|^"), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/", "%"), ("^",))  # loosest first
_PRECEDENCE = {operator: level for level, operators in enumerate(_LEVELS, start=1) for operator in operators}
_CONSTANTS = {"PI": math.pi, "yes": 1.0, "no": 0.0, "on": 1.0, "off": 0.0, "true": 1.0, "false": 0.0}
_RUN_FUNCTIONS = ("ramp", "stagger", "logfreq", "logfreq2", "logfreq3", "stride", "stride2", "vdisplace", "swiggle", "cwiggle")
_RANDOM_FUNCTIONS = ("random", "normal")
_GROUP_FUNCTIONS = ("count", "mass", "xcm", "vcm", "fcm", "ke", "bound", "angmom", "omega", "gyration", "torque", "inertia")
_FUNCTIONS = {name: count for name, (count, _) in FUNCTIONS.items() if name.isalnum() and name != "negate"}


class FormulaError(ValueError):
    """A formula that cannot be evaluated. The message names the part at fault, not the place."""


@dataclass(frozen=True)
class Names:
    """Where a formula finds what it names.

    variable: name -> value of v_name. live: `step`, `c_ID`, `c_ID[2]`, `mass(all)`, `x[3]` ... -> value of the simulation."""

    variable: Callable[[str], float]
    live: Callable[[str], float]


T = TypeVar("T")


class Meaning(Protocol[T]):
    """What the parts of a formula become as it is read. function: a name of demsolver.expression.FUNCTIONS. Each may raise FormulaError."""

    def number(self, value: float) -> T:
        """A constant."""

    def variable(self, name: str) -> T:
        """v_name."""

    def live(self, keyword: str) -> T:
        """Any other name, as in Names."""

    def index(self, value: T) -> int:
        """What stands in brackets, as in x[3]."""

    def call(self, function: str, arguments: list[T]) -> T:
        """A function or an operator of what was read."""


def read(text: str, meaning: Meaning[T]) -> T:
    """What a formula becomes. Raises FormulaError."""
    parser = _Parser(_tokens(text), meaning)
    try:
        found = parser.expression(1)
    except RecursionError:
        raise FormulaError("it is nested too deeply") from None
    parser.expect_end()
    return found


def evaluate(text: str, names: Names) -> float:
    """The finite value of a formula. Raises FormulaError."""
    return _finite(read(text, _Numbers(names)), text)


@dataclass(frozen=True)
class _Numbers:
    """Formulas whose parts are numbers at once."""

    names: Names

    def number(self, value: float) -> float:
        return value

    def variable(self, name: str) -> float:
        return self.names.variable(name)

    def live(self, keyword: str) -> float:
        return self.names.live(keyword)

    def index(self, value: float) -> int:
        return round(value)

    def call(self, function: str, arguments: list[float]) -> float:
        return apply(function, arguments)


def evaluate_condition(text: str, names: Names, *, of_numbers: bool = False) -> bool:
    """The test of an `if` command: a formula, or two strings compared by == or !=.

    of_numbers: as in LIGGGHTS, which has no strings there and no exclusive or (measured on 3.8.0). Raises FormulaError."""
    if of_numbers:
        _refuse_strings(text)
    strings = re.fullmatch(r"\s*([^\s=!<>|&()]+)\s*(==|!=)\s*([^\s=!<>|&()]+)\s*", text)
    if strings and not (_is_number(strings[1]) and _is_number(strings[3])):
        return (strings[1] == strings[3]) == (strings[2] == "==")
    return evaluate(text, names) != 0.0


def _refuse_strings(text: str) -> None:
    if word := re.search(r"(?<![\w.])[A-Za-z_][^\s=!<>|&()]*", text):
        raise FormulaError(f"LIGGGHTS compares numbers only, not strings such as {word[0]!r}")
    if "|^" in text:
        raise FormulaError("LIGGGHTS has no |^; it has ==, !=, <, <=, >, >=, && and ||")


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    start: int
    end: int


def _tokens(text: str) -> list[_Token]:
    tokens = []
    at = 0
    body = text.rstrip()
    while at < len(body):
        found = _TOKEN.match(body, at)
        if found is None:
            raise FormulaError(f"cannot read {body[at:].strip()!r}")
        kind = found.lastgroup or ""
        tokens.append(_Token(kind, found[kind], found.start(kind), found.end()))
        at = found.end()
    return tokens


class _Parser(Generic[T]):
    """Precedence climbing that gives everything its meaning while it reads."""

    def __init__(self, tokens: list[_Token], meaning: Meaning[T]) -> None:
        self.tokens = tokens
        self.meaning = meaning
        self.at = 0

    def expression(self, lowest: int) -> T:
        value = self.operand()
        while (precedence := _PRECEDENCE.get(self.peek(), 0)) >= lowest:
            operator = self.take()
            value = self.meaning.call(operator, [value, self.expression(precedence + 1)])
        return value

    def operand(self) -> T:
        token = self.take()
        if token == "-":
            return self.meaning.call("negate", [self.operand()])
        if token == "!":
            return self.meaning.call("!", [self.operand()])
        if token == "(":
            value = self.expression(1)
            self.expect(")")
            return value
        kind = self.tokens[self.at - 1].kind
        if kind == "number":
            return self.meaning.number(float(token))
        if kind == "name":
            return self.named(token)
        raise FormulaError(f"expected a number or a name, got {token!r}")

    def named(self, name: str) -> T:
        if self.peek() == "(":
            return self.function(name)
        if name in _CONSTANTS:
            return self.meaning.number(_CONSTANTS[name])
        if name.startswith("v_") and self.peek() != "[":
            return self.meaning.variable(name[2:])
        return self.meaning.live(name + self.indices())

    def indices(self) -> str:
        text = ""
        while self.peek() == "[":
            self.take()
            text += f"[{self.meaning.index(self.expression(1))}]"
            self.expect("]")
        return text

    def function(self, name: str) -> T:
        if name in _GROUP_FUNCTIONS:
            return self.meaning.live(f"{name}({','.join(self.raw_arguments())})")
        _refuse_function(name)
        count, values = _FUNCTIONS[name], self.arguments()
        if len(values) != count:
            raise FormulaError(f"{name}() expects {count} argument{'s' * (count > 1)}, got {len(values)}")
        return self.meaning.call(name, values)

    def arguments(self) -> list[T]:
        self.expect("(")
        values = [self.expression(1)]
        while self.peek() == ",":
            self.take()
            values.append(self.expression(1))
        self.expect(")")
        return values

    def raw_arguments(self) -> list[str]:
        """Arguments that are names (groups, directions), not numbers."""
        self.expect("(")
        arguments = [""]
        while (token := self.take()) != ")":
            if token == ",":
                arguments.append("")
            else:
                arguments[-1] += token
        return arguments

    def peek(self) -> str:
        return self.tokens[self.at].text if self.at < len(self.tokens) else ""

    def take(self) -> str:
        if self.at == len(self.tokens):
            raise FormulaError("it ends too early")
        self.at += 1
        return self.tokens[self.at - 1].text

    def expect(self, token: str) -> None:
        if self.at == len(self.tokens) or self.take() != token:
            raise FormulaError(f"expected {token!r}")

    def expect_end(self) -> None:
        if self.at < len(self.tokens):
            raise FormulaError(f"expected an operator, got {self.peek()!r}")


def _refuse_function(name: str) -> None:
    if name in _RUN_FUNCTIONS:
        raise FormulaError(f"{name}() depends on the steps of a run and is not supported")
    if name in _RANDOM_FUNCTIONS:
        raise FormulaError(f"{name}() draws random numbers and is not supported")
    if name not in _FUNCTIONS:
        raise FormulaError(f"{name}() is not one of {', '.join([*_FUNCTIONS, *_GROUP_FUNCTIONS])}")


def apply(function: str, values: list[float]) -> float:
    """A function or an operator of numbers. Raises FormulaError where it has no finite value."""
    if function in ("/", "%") and values[1] == 0.0:
        raise FormulaError("division by zero" if function == "/" else "modulo zero")
    found = call(function, *values)
    if not math.isfinite(found):
        shown = [f"{value:g}" for value in values]
        text = function.join(shown) if function in _PRECEDENCE else f"{function}({', '.join(shown)})"
        raise FormulaError(f"{text} has no finite value")
    return found


def _is_number(text: str) -> bool:
    return re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", text) is not None


def _finite(value: float, text: str) -> float:
    if not math.isfinite(value):
        raise FormulaError(f"{text.strip()!r} has no finite value")
    return value

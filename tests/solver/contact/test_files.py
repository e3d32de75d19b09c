"""What every law file must be: a pure function of scalars that says by its parameter names what it wants."""

from __future__ import annotations

import inspect
import math
from types import ModuleType

import pytest

from demsolver import contact

LAWS = [(family, name) for family in contact.FAMILIES for name in contact.listing(family)]


def functions(family: contact.Family, name: str) -> list[object]:
    """The functions of a law file."""
    return [getattr(contact.law(family, name), function) for function in contact.functions(family, name)]


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


REMEMBERING = [(family, name) for family in contact.REMEMBERING for name in contact.listing(family)]


@pytest.mark.parametrize(("family", "name"), REMEMBERING)
def test_a_memory_has_signs(family: contact.Family, name: str) -> None:
    """MEMORY gives every stored name the sign +1 or -1 on exchange; no other family stores under the same name."""
    found = contact.memory(family, name)
    assert set(found.values()) <= {1, -1}
    others = {stored for other, law in REMEMBERING if other != family for stored in contact.memory(other, law)}
    assert not others & set(found)


@pytest.mark.parametrize("family", contact.FAMILIES)
def test_an_unknown_law_is_refused_by_name(family: contact.Family) -> None:
    """The error names the family, the word, and what exists."""
    with pytest.raises(ValueError, match=f"{family} law 'hurtz' is not one of {', '.join(contact.listing(family))}"):
        contact.law(family, "hurtz")

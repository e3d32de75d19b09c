"""LIGGGHTS `fix property/global`: material properties read as tables, with the limits that LIGGGHTS 3.8.0 sets."""

from __future__ import annotations

from math import inf

import numpy as np

from demverify.deck.materials_common import Words
from demverify.deck.setup import Floats, Setup, Spec
from demverify.errors import InputError, Place

KINDS = {
    "scalar": "scalar",
    "vector": "vector",
    "peratomtype": "peratomtype",
    "atomtype": "peratomtype",
    "matrix": "matrix",
    "peratomtypepair": "peratomtypepair",
    "atomtypepair": "peratomtypepair",
}
SOFTEST = {"si": 5e6, "cgs": 5e7}  # bounds of youngsModulus; soft_particles yes, hard_particles yes lift them
HARDEST = {"si": 1e9, "cgs": 1e10}


class Properties:
    """The properties of a deck, asked for by one contact model (`user`), whose `place` is reported when one is missing."""

    def __init__(self, setup: Setup, user: str, place: Place | None) -> None:
        """Reads the names; values are read when they are asked for."""
        self.ntypes = setup.ntypes
        self._setup = setup
        self._user = user
        self._place = place
        self._fixes = _by_name(setup)

    def pairs(self, name: str, low: float = -inf, high: float = inf, *, above: bool = False) -> Floats:
        """Symmetric (ntypes, ntypes) table within [low, high], or (low, high] with `above`."""
        words = self._words(name, "peratomtypepair", ("peratomtypepair", "matrix"))
        if words.integer("number of columns", 1) != self.ntypes:
            raise words.error(f"must have {self.ntypes} columns, one a type")
        table = _values(words, self.ntypes**2).reshape(self.ntypes, self.ntypes)
        if (table != table.T).any():
            i, j = np.argwhere(table != table.T)[0]
            raise words.error(f"must be symmetric: {i + 1} {j + 1} has {table[i, j]:g}, {j + 1} {i + 1} has {table[j, i]:g}")
        _check(words, table, low, high, above)
        return table

    def types(self, name: str, low: float = -inf, high: float = inf) -> Floats:
        """(ntypes,) values within [low, high]."""
        words = self._words(name, "peratomtype", ("peratomtype", "vector"))
        values = _values(words, self.ntypes)
        _check(words, values, low, high)
        return values

    def characteristic_velocity(self) -> float:
        """characteristicVelocity; at least 1e-2 in SI units."""
        words = self._words("characteristicVelocity", "scalar", ("scalar",))
        value = _values(words, 1)
        _check(words, value, 1e-2 if self._setup.units == "si" else 0.0, inf)
        return float(value[0])

    def effective_young(self) -> Floats:
        """E* of every pair: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j."""
        young, nu = self.elastic()
        compliance = (1.0 - nu**2) / young
        return np.asarray(1.0 / (compliance[:, None] + compliance[None, :]))

    def effective_shear(self) -> Floats:
        """G* of every pair: 1/G* = 2 (2 - nu_i)(1 + nu_i)/E_i + the same of j."""
        young, nu = self.elastic()
        compliance = 2.0 * (2.0 - nu) * (1.0 + nu) / young
        return np.asarray(1.0 / (compliance[:, None] + compliance[None, :]))

    def elastic(self) -> tuple[Floats, Floats]:
        """Young's modulus and Poisson's ratio, (ntypes,) each, within LIGGGHTS' bounds."""
        low = 0.0 if self._setup.soft_particles else SOFTEST.get(self._setup.units, 0.0)
        high = inf if self._setup.hard_particles else HARDEST.get(self._setup.units, inf)
        young = self.types("youngsModulus", low, high)
        if (young == 0.0).any():
            raise self._words("youngsModulus", "peratomtype", ("peratomtype", "vector")).error("must be positive")
        return young, self.types("poissonsRatio", 0.0, 0.5)

    def _words(self, name: str, wanted: str, kinds: tuple[str, ...]) -> Words:
        """The words behind `property/global NAME KIND`. Raises InputError when there is no such fix, or its kind is another."""
        if name not in self._fixes:
            given = ", ".join(self._fixes) or "none"
            message = f"{self._user} needs the property {name} (fix ID all property/global {name} {wanted} ...); given: {given}"
            raise InputError(message, self._place)
        fix = self._fixes[name]
        words = Words(fix.args[1:], f"fix {fix.id} property/global {name}", fix.place)
        if KINDS[words.choice("kind", KINDS)] not in kinds:
            raise words.error(f"must be {wanted} for {self._user}, got {fix.args[1]}")
        return words


def _by_name(setup: Setup) -> dict[str, Spec]:
    found: dict[str, Spec] = {}
    for fix in setup.fixes.values():
        if fix.style == "property/global":
            name = Words(fix.args, f"fix {fix.id} property/global", fix.place).take("property name")
            if name in found:
                message = f"fix {fix.id} property/global: {name} is already set by fix {found[name].id}"
                raise InputError(message, fix.place)
            found[name] = fix
    return found


def _values(words: Words, count: int) -> Floats:
    """All remaining words as numbers; there must be `count`."""
    values = []
    while words:
        values.append(words.number("value"))
    if len(values) != count:
        raise words.error(f"must have {count} value{'s' if count > 1 else ''}, got {len(values)}")
    return np.array(values)


def _check(words: Words, values: Floats, low: float, high: float, above: bool = False) -> None:
    wrong = values[(values < low) | (values > high) | (above & (values == low))]
    if wrong.size:
        bounds = f"{'>' if above else '>='} {low:g}" + ("" if high == inf else f" and <= {high:g}")
        raise words.error(f"must be {bounds}, got {wrong[0]:g}{_hint(words, wrong[0], low)}")


def _hint(words: Words, value: float, low: float) -> str:
    if not words.what.endswith("youngsModulus"):
        return ""
    return f" ({'soft' if value < low else 'hard'}_particles yes lifts this bound of LIGGGHTS)"

"""Bookkeeping of densities without particles: lots of particles of one type, and the densities that some of each may have.

A command that reaches a whole lot replaces its densities, one that may reach a part adds to them. What is asked for in the end is
what the lots had while files were written, hence `observe`. A type has a known density if all its lots had the same one.
"""

from __future__ import annotations

from dataclasses import dataclass, field

Values = dict[float | None, str]
"""Density -> the place that gave it; None: one that is not known."""


@dataclass(eq=False)
class Lot:
    """Particles that came by one command.

    kind: their type; None: any type but those in `without`. source: the densities of those still to come.
    """

    kind: int | None
    values: Values
    source: Values = field(default_factory=dict)
    without: set[int] = field(default_factory=set)

    def may_be(self, kind: int) -> bool:
        """Whether particles of a type are among them."""
        return kind == self.kind or (self.kind is None and kind not in self.without)


Choice = list[tuple[Lot, bool]]
"""Lots, and whether all of their particles are meant; if not, some may be."""


_Seen = tuple[int | None, tuple[tuple[float | None, str], ...], frozenset[int]]
_MOST_TYPES = 10_000
_SHOWN = 3  # densities of one type in a note


class Densities:
    """All lots. types: number of particle types, 0: not known."""

    def __init__(self) -> None:
        """No particles."""
        self.types = 0
        self._numbered: dict[int, Lot] = {}  # single particles by id
        self._others: list[Lot] = []
        self._groups: dict[str, tuple[dict[Lot, bool], set[Lot]]] = {}
        self._last_id: int | None = 0
        self._seen: dict[bool, set[_Seen]] = {True: set(), False: set()}

    @property
    def _lots(self) -> list[Lot]:
        return [*self._numbered.values(), *self._others]

    def create(self, kind: int, values: Values, *, single: bool = False) -> None:
        """Particles come into being: a single one, or an unknown number of them."""
        lot = Lot(kind, dict(values))
        if single and self._last_id is not None:
            self._last_id += 1
            self._numbered[self._last_id] = lot
        else:
            self._last_id = None
            self._others.append(lot)

    def insert(self, kind: int, values: Values) -> None:
        """Particles are going to come while runs go on."""
        self._last_id = None
        self._others.append(Lot(kind, dict(values), source=dict(values)))

    def unknown(self, why: str) -> None:
        """Particles of any type may have any density."""
        self._last_id = None
        self._others.append(Lot(None, {None: why}))

    def forget_ids(self) -> None:
        """Particles are numbered anew."""
        self._last_id = None
        self._others, self._numbered = self._lots, {}

    def everything(self) -> Choice:
        """All that are there."""
        return [(lot, True) for lot in self._lots]

    def something(self) -> Choice:
        """Some of those that are there."""
        return [(lot, False) for lot in self._lots]

    def of_types(self, kinds: range) -> Choice:
        """Those of some types. A lot of any type is parted from them."""
        some: Choice = []
        for lot in [lot for lot in self._lots if lot.kind is None]:
            if len(kinds) > _MOST_TYPES:
                some.append((lot, False))
                continue
            parted = [kind for kind in kinds if lot.may_be(kind)]
            self._others += [Lot(kind, dict(lot.values)) for kind in parted]
            lot.without.update(parted)
        return some + [(lot, True) for lot in self._lots if lot.kind is not None and lot.kind in kinds]

    def of_ids(self, ids: range) -> Choice:
        """Those with the ids of a range."""
        numbered = [self._numbered[i] for i in (ids if len(ids) < len(self._numbered) else self._numbered) if i in ids and i in self._numbered]
        return [(lot, True) for lot in numbered] + [(lot, False) for lot in self._others]

    def group(self, name: str, choice: Choice) -> None:
        """Adds a choice to a group. It holds for the lots that are there now; of those that came meanwhile, some may belong to it."""
        old, known = self._groups.get(name, ({}, set(self._lots)))
        chosen = {lot: old.get(lot, False) for lot in self._lots if lot in old or lot not in known}
        for lot, whole in choice:
            chosen[lot] = whole or chosen.get(lot, False)
        self._groups[name] = chosen, set(self._lots)

    def ungroup(self, name: str) -> None:
        """Nothing is known of a group any more."""
        self._groups.pop(name, None)

    def of_group(self, name: str) -> Choice:
        """Those of a group. Of lots that came after it, some may belong to it."""
        if name == "all":
            return self.everything()
        chosen, known = self._groups.get(name, ({}, set()))
        return [(lot, chosen.get(lot, False)) for lot in self._lots if lot in chosen or lot not in known]

    def put(self, choice: Choice, values: Values) -> None:
        """Gives particles a density."""
        for lot, whole in choice:
            lot.values = {**(lot.source if whole else lot.values), **values}

    def retype(self, choice: Choice, kind: int) -> Choice:
        """Makes particles those of another type. Returns the choice again, with the lots that came of it."""
        parted: Choice = []
        for lot, whole in choice:
            if whole and not lot.source:
                lot.kind, lot.without = kind, set()
            elif lot.kind != kind:
                parted.append((Lot(kind, dict(lot.values)), True))
        self._others += [lot for lot, _ in parted]
        return choice + parted

    def observe(self, *, dumping: bool) -> None:
        """A run goes over the particles as they are now. dumping: and writes files of them."""
        self._seen[dumping].update(self._now())

    def _now(self) -> set[_Seen]:
        return {(lot.kind, tuple(lot.values.items()), frozenset(lot.without)) for lot in self._lots}

    def result(self) -> tuple[dict[int, float], list[str]]:
        """Type -> density while files were written, else during runs, else at the end; and why other types have none."""
        seen = self._seen[True] or self._seen[False] or self._now()
        kinds = {kind for kind, _, _ in seen if kind is not None}
        if any(kind is None for kind, _, _ in seen) and self.types <= _MOST_TYPES:
            kinds |= set(range(1, self.types + 1))
        densities: dict[int, float] = {}
        notes: dict[str, list[str]] = {}
        for kind in [*sorted(kinds), None]:
            values = _of_kind(kind, seen)
            known = [value for value in values if value is not None]
            if kind is not None and len(values) == len(known) == 1:
                densities[kind] = known[0]
            elif values:
                notes.setdefault(_shown(values), []).append("any other type" if kind is None else f"type {kind}")
        return densities, [f"the density of {', '.join(of)} is not known: {why}" for why, of in notes.items()]


def _of_kind(kind: int | None, seen: set[_Seen]) -> Values:
    """The densities that particles of a type may have. None: of any type but those that are named."""
    return {v: why for of, items, without in sorted(seen, key=str) if of == kind or (of is None and kind not in without) for v, why in items}


def _shown(values: Values) -> str:
    given = [why if value is None else f"{value:g} ({why})" for value, why in values.items()]
    return "; ".join(given[:_SHOWN]) + (f"; and {len(given) - _SHOWN} more" if len(given) > _SHOWN else "")

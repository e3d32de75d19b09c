"""The register of known engine deviations: `register.toml`, and which of its entries can explain a difference between engines.

An entry says what one engine does that a closed form, the manual or the other engine does not, how large it is, and which test
shows it by running the engine. The same tests fail when the engine is mended, so that the register does not go stale.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field, fields
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, get_args

from demverify.deck.forces import FORCES, RIGID
from demverify.deck.rotating import region_of
from demverify.deck.setup import Dialect, Setup, Spec
from demverify.errors import InputError, Place

FILE = Path(__file__).with_name("register.toml")
Words = frozenset[str]
Engine = Literal["lammps", "liggghts", "both"]
Kind = Literal["defect", "convention", "trap"]
ENGINES = ("native", "lammps", "liggghts", "law")


@dataclass(frozen=True)
class Features:
    """What a deck uses, as words of its dialect, and what follows from them.

    pair_styles, wall_styles: "granular", "gran/hooke/history", "hooke/history" ...; LIGGGHTS "gran" and "model"; "region" walls.
    normal: hooke, hertz, hertz/material, hooke/stiffness, hertz/stiffness. damping: LAMMPS' words; "restitution" for LIGGGHTS
    hooke and hertz, "gamma" for its stiffness models; "none" when the coefficient is zero. tangential: off, no_history, history.
    rolling: cdt, epsd, epsd2 (LIGGGHTS), sds (LAMMPS). twisting: marshall, sds (LAMMPS).
    switches: limit_damping (LIGGGHTS limitForce), viscous, ktToKnUser. cylinders: axes x y z. computes, fixes: styles.
    thermo: columns.
    friction: some coefficient is not zero. tangential_damping: some law has it.
    undamped_wall: a wall without normal damping. two_planes: a LAMMPS wall of two planes. turning: a cylinder. discs: spheres integrated as discs.
    short_dumps: a dump without a format of its own. restart: read_restart made the box; pair_of_the_file: and the pair style.
    late_forces: a fix that pushes spheres stands behind that of the clumps. runs: number of `run` commands. particles: their number.
    """

    pair_styles: Words = frozenset()
    wall_styles: Words = frozenset()
    normal: Words = frozenset()
    damping: Words = frozenset()
    tangential: Words = frozenset()
    rolling: Words = frozenset()
    twisting: Words = frozenset()
    switches: Words = frozenset()
    cylinders: Words = frozenset()
    computes: Words = frozenset()
    fixes: Words = frozenset()
    thermo: Words = frozenset()
    friction: bool = False
    tangential_damping: bool = False
    frozen: bool = False
    undamped_wall: bool = False
    two_planes: bool = False
    turning: bool = False
    discs: bool = False
    short_dumps: bool = False
    restart: bool = False
    pair_of_the_file: bool = False
    late_forces: bool = False
    runs: int = 1
    particles: int = 0
    dimension: int = 3


NEEDS: dict[str, Callable[[Features], bool]] = {
    "pairs": lambda f: bool(f.pair_styles),
    "walls": lambda f: bool(f.wall_styles),
    "cylinder": lambda f: bool(f.cylinders),
    "friction": lambda f: f.friction,
    "resistance to turning": lambda f: bool(f.rolling | f.twisting),
    "tangential damping": lambda f: f.tangential_damping,
    "frozen": lambda f: f.frozen,
    "damping": lambda f: bool(f.damping - {"none"}),
    "unlimited damping": lambda f: bool(f.damping - {"none"}) and "limit_damping" not in f.switches,
    "undamped wall": lambda f: f.undamped_wall,
    "two planes": lambda f: f.two_planes,
    "turning cylinder": lambda f: f.turning,
    "restart": lambda f: f.restart,
    "pair style of the restart file": lambda f: f.pair_of_the_file,
    "forces behind the fix of clumps": lambda f: f.late_forces,
    "several runs": lambda f: f.runs > 1,
    "one particle": lambda f: f.particles == 1,
    "two dimensions": lambda f: f.dimension == 2,
    "discs": lambda f: f.discs,
    "short dumps": lambda f: f.short_dumps,
}
WORD_LISTS = (
    "pair_styles",
    "wall_styles",
    "normal",
    "damping",
    "tangential",
    "rolling",
    "twisting",
    "switches",
    "cylinders",
    "computes",
    "fixes",
    "thermo",
)


@dataclass(frozen=True)
class Conditions:
    """When an entry touches a deck: of each list given here the deck has at least one word, and it has everything in `needs`.

    styles: of pairs or walls. dialects: of the deck. needs: words of NEEDS. The other lists: those of Features."""

    dialects: Words = frozenset()
    styles: Words = frozenset()
    needs: Words = frozenset()
    lists: tuple[tuple[str, Words], ...] = ()

    def met(self, dialect: Dialect, features: Features) -> bool:
        """Whether a deck of this dialect with these features is touched."""
        return (
            (not self.dialects or dialect in self.dialects)
            and (not self.styles or bool(self.styles & (features.pair_styles | features.wall_styles)))
            and all(NEEDS[need](features) for need in self.needs)
            and all(words & getattr(features, name) for name, words in self.lists)
        )


@dataclass(frozen=True)
class Entry:
    """One deviation. engine, version: who has it. what: for a DEM user. size: as measured. how: the test that shows it. link:
    where it is discussed or written. kind: "defect", "convention" (engines follow different rules) or "trap" (easy to misread).
    applies: None when it changes no number, e.g. a lost error message."""

    id: str
    engine: Engine
    version: str
    what: str
    size: str
    how: str
    link: str
    kind: Kind
    applies: Conditions | None = field(default=None)

    def parts(self, engines: Collection[str], dialect: Dialect) -> bool:
        """Whether the deviation lies between some two of `engines` (words of ENGINES; "law": a closed form).

        The native engine keeps the conventions of the deck's dialect, and no defect."""
        owners = {"lammps", "liggghts"} if self.engine == "both" else {self.engine}
        if self.kind == "convention" and dialect in owners:
            owners = owners | {"native"}
        shared_trap = self.kind == "trap" and self.engine == "both"
        return bool(owners & set(engines)) and (shared_trap or bool(set(engines) - owners))


def load(path: Path = FILE) -> tuple[Entry, ...]:
    """All entries, in the order of the file. Raises InputError on a malformed file."""
    try:
        return _load(path, path.stat().st_mtime_ns)
    except OSError as error:
        raise InputError(f"no readable register: {error}", Place(path)) from error


@cache
def _load(path: Path, changed: int) -> tuple[Entry, ...]:  # changed: so that a new register is read anew
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8")).get("entry", [])
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise InputError(f"no readable register: {error}", Place(path)) from error
    if not isinstance(tables, list) or not tables:
        raise InputError("no entries; expected tables [[entry]]", Place(path))
    entries = tuple(_entry(table, number, path) for number, table in enumerate(tables, 1))
    _require_unique(entries, path)
    return entries


def applying(dialect: Dialect, features: Features, engines: Collection[str]) -> tuple[Entry, ...]:
    """The entries that can explain a difference between `engines` (two or more words of ENGINES) on a deck of this dialect.

    Raises InputError when a name is not one of ENGINES."""
    for engine in engines:
        _one_of(engine, ENGINES, "engine", None)
    return tuple(
        entry for entry in load() if entry.applies and entry.parts(engines, dialect) and entry.applies.met(dialect, features)
    )


def _entry(table: dict[str, Any], number: int, path: Path) -> Entry:
    place, name = Place(path), f"entry {table.get('id', number)}"
    texts = [f.name for f in fields(Entry) if f.name != "applies"]
    _known(table, [*texts, "applies"], name, place)
    for key in texts:
        if not isinstance(table.get(key), str) or not table[key].strip():
            raise InputError(f"{name}: {key} is missing or not a text; expected all of {', '.join(texts)}", place)
    _one_of(table["engine"], get_args(Engine), f"{name}: engine", place)
    _one_of(table["kind"], get_args(Kind), f"{name}: kind", place)
    applies = _conditions(table["applies"], name, place) if "applies" in table else None
    return Entry(**{key: table[key] for key in texts}, applies=applies)


def _conditions(table: Any, name: str, place: Place) -> Conditions:
    allowed = ("dialects", "styles", "needs", *WORD_LISTS)
    if not isinstance(table, dict) or not table:
        raise InputError(
            f"{name}: applies must be a table with some of {', '.join(allowed)}; leave it out if no number changes", place
        )
    _known(table, allowed, f"{name}: applies", place)
    words = {key: _words(value, f"{name}: {key}", place) for key, value in table.items()}
    for key, choices in (("dialects", get_args(Dialect)), ("needs", NEEDS)):
        for word in sorted(words.get(key, ())):
            _one_of(word, choices, f"{name}: {key}", place)
    single = {key: words[key] for key in ("dialects", "styles", "needs") if key in words}
    return Conditions(**single, lists=tuple((key, words[key]) for key in WORD_LISTS if key in words))


def _words(value: Any, name: str, place: Place) -> Words:
    if not isinstance(value, list) or not value or not all(isinstance(word, str) for word in value):
        raise InputError(f"{name} must be a list of words, got {value!r}", place)
    return frozenset(value)


def _known(table: dict[str, Any], names: Iterable[str], what: str, place: Place) -> None:
    for key in table:
        _one_of(key, tuple(names), f"{what}: key", place)


def _one_of(word: str, choices: Iterable[str], what: str, place: Place | None) -> None:
    if word not in choices:
        raise InputError(f"{what} {word!r} is not one of {', '.join(choices)}", place)


def _require_unique(entries: tuple[Entry, ...], path: Path) -> None:
    seen: set[str] = set()
    for entry in entries:
        if entry.id in seen:
            raise InputError(f"two entries have the id {entry.id!r}; expected one each", Place(path))
        seen.add(entry.id)


def features_of(setup: Setup, runs: int) -> Features:
    """The features of a deck at its last run; `runs`: how many `run` commands it has."""
    laws = [*_pair_laws(setup), *(law for fix in _walls(setup) for law in _wall_laws(fix))]
    integrators = [fix for fix in setup.fixes.values() if fix.style == "nve/sphere"]
    return Features(
        pair_styles=frozenset(setup.pair_style[:1] if setup.pair_style else ()) - {"none"},
        wall_styles=frozenset(_wall_style(fix) for fix in _walls(setup)),
        normal=frozenset(law.normal for law in laws),
        damping=frozenset(law.damping for law in laws),
        tangential=frozenset(law.tangential for law in laws),
        rolling=frozenset(law.rolling for law in laws) - {"none", "off"},
        twisting=frozenset(law.twisting for law in laws) - {"none", "off"},
        switches=frozenset[str]().union(*(law.switches for law in laws)),
        cylinders=frozenset(_cylinder(setup, fix)[0] for fix in _walls(setup)) - {""},
        computes=frozenset(compute.style for compute in setup.computes.values()),
        fixes=frozenset(fix.style for fix in setup.fixes.values()),
        thermo=frozenset(setup.thermo.columns),
        friction=any(law.mu != 0 for law in laws) or _liggghts_property(setup, "coefficientFriction"),
        tangential_damping=any(law.rubs for law in laws) and (setup.dialect == "lammps" or _liggghts_rubs(setup)),
        frozen=any(fix.style == "freeze" for fix in setup.fixes.values()),
        undamped_wall=any(law.damping == "none" for fix in _walls(setup) for law in _wall_laws(fix)),
        turning=any(_cylinder(setup, fix)[1] for fix in _walls(setup)),
        two_planes=any(_two_planes(fix.args) for fix in _walls(setup)),
        discs=any("disc" in fix.args or (setup.dialect, setup.dimension) == ("liggghts", 2) for fix in integrators),
        short_dumps=any(not dump.format for dump in setup.dumps.values()),
        restart=setup.restored is not None,
        pair_of_the_file=setup.restored is not None and setup.pair_place is setup.restored,
        late_forces=_late_forces(setup),
        runs=runs,
        particles=setup.atoms.n if setup.atoms else 0,
        dimension=setup.dimension,
    )


def _late_forces(setup: Setup) -> bool:
    styles = [fix.style for fix in setup.fixes.values()]
    clumps = next((k for k, style in enumerate(styles) if style in (*RIGID, "multisphere")), len(styles))
    pushes = FORCES.keys() - ({"gravity"} if setup.dialect == "liggghts" else set())  # LIGGGHTS' weight pulls at the clump itself (measured)
    return any(style.startswith("wall/gran") or style in pushes for style in styles[clumps:])


@dataclass(frozen=True)
class _Law:
    """One contact law of a deck, in the words of Features."""

    normal: str
    damping: str
    tangential: str
    mu: float = 0.0
    switches: Words = frozenset()
    rubs: bool = False  # has tangential damping
    rolling: str = "off"
    twisting: str = "off"


def _pair_laws(setup: Setup) -> list[_Law]:
    style = setup.pair_style or ("none",)
    if style[0] == "granular":
        return [_granular(words[2:]) for words, _ in setup.pair_coeffs]
    if style[0] == "gran":
        return [_liggghts(style[1:])]
    return [_legacy(style[0].removeprefix("gran/"), style[1:])] if style[0].startswith("gran/") else []


def _walls(setup: Setup) -> list[Spec]:
    return [fix for fix in setup.fixes.values() if fix.style in ("wall/gran", "wall/gran/region") and fix.args]


def _wall_style(fix: Spec) -> str:
    return "region" if fix.style == "wall/gran/region" else fix.args[0]


def _cylinder(setup: Setup, fix: Spec) -> tuple[str, bool]:
    """Axis of a wall that is a cylinder, "" for another, and whether it turns."""
    if fix.style == "wall/gran/region":
        region = setup.regions.get(region_of(fix))
        return ("xyz"[region.tube.axis], bool(region.angle)) if region and region.tube else ("", False)
    axis = next((word[0] for word in fix.args if word.endswith("cylinder")), "")
    sheared = fix.args[fix.args.index("shear") + 1 :][:1] if "shear" in fix.args else ()
    return axis, bool(axis and sheared and sheared != (axis,))


def _two_planes(words: tuple[str, ...]) -> bool:
    """`zplane LO HI` with neither NULL, which LIGGGHTS does not have."""
    at = next((k for k, word in enumerate(words) if word.endswith("plane")), len(words))
    return len(words) > at + 2 and "model" not in words and "NULL" not in words[at + 1 : at + 3]


def _wall_laws(fix: Spec) -> list[_Law]:
    style, rest = fix.args[0], fix.args[1:]
    if style in ("granular", "model"):
        return [_granular(rest) if style == "granular" else _liggghts(fix.args)]
    return [_legacy(style, rest)]


def _legacy(style: str, numbers: tuple[str, ...]) -> _Law:
    """`hooke`, `hooke/history`, `hertz/history` with kn kt gamma_n gamma_t mu dampflag [limit_damping]."""
    normal, _, memory = style.partition("/")
    damping = "none" if _number(numbers, 2) == 0 else "mass_velocity" if normal == "hooke" else "viscoelastic"
    switches = frozenset({"limit_damping"}) & frozenset(numbers)
    gammat = _number(numbers, 2) if numbers[3:4] == ("NULL",) else _number(numbers, 3)
    rubs = gammat != 0 and _number(numbers, 5) == 1
    return _Law(normal, damping, "history" if memory else "no_history", _number(numbers, 4), switches, rubs)


def _granular(words: tuple[str, ...]) -> _Law:
    """`NORMAL numbers [tangential KIND [kt] xt mu] [damping KIND] [rolling KIND ...] [twisting KIND ...] [limit_damping]`."""
    tangential = _after(words, "tangential", "none")
    memory = {"none": "off", "linear_nohistory": "no_history"}.get(tangential, "history")
    mu_at = words.index(tangential) + (2 if memory == "no_history" else 3) if memory != "off" else len(words)
    damping = "none" if len(words) > 2 and _number(words, 2) == 0 else _after(words, "damping", "viscoelastic")
    rubs = damping != "none" and _number(words, mu_at - 1) != 0 and memory != "off"
    limit = frozenset({"limit_damping"}) & frozenset(words)
    return _Law(words[0], damping, memory, _number(words, mu_at), limit, rubs, _after(words, "rolling", "off"), _after(words, "twisting", "off"))


def _liggghts(words: tuple[str, ...]) -> _Law:
    """`model NORMAL [tangential KIND] ... [rolling_friction KIND] ... [SWITCH on|off]`; friction stands in a fix property/global."""
    normal = _after(words, "model", "hooke")
    on = {name for name, state in pairwise(words) if state == "on"}
    switches = {"limit_damping" if name == "limitForce" else name for name in on}
    damping = "gamma" if normal.endswith("/stiffness") else "restitution"
    tangential = _after(words, "tangential", "off")
    rubs = tangential != "off" and _after(words, "tangential_damping", "on") == "on"
    return _Law(normal, damping, tangential, 0.0, frozenset(switches), rubs, _after(words, "rolling_friction", "off"))


def _liggghts_property(setup: Setup, name: str, zero: float = 0.0) -> bool:
    """Whether a property is given and any of its numbers is not `zero`."""
    properties = [fix.args for fix in setup.fixes.values() if fix.style == "property/global"]
    return any(_number(args, k) != zero for args in properties if args[:1] == (name,) for k in range(3, len(args)))


def _liggghts_rubs(setup: Setup) -> bool:
    """Models hooke and hertz damp by their restitution, the stiffness models by gammat."""
    return any(_liggghts_property(setup, name) for name in ("gammat", "gammat_abs")) or _liggghts_property(setup, "coefficientRestitution", 1.0)


def _after(words: tuple[str, ...], keyword: str, default: str) -> str:
    """The word behind a keyword."""
    return words[words.index(keyword) + 1] if keyword in words[:-1] else default


def _number(words: tuple[str, ...], index: int) -> float:
    """The number at a place; 0 when it is absent, NULL or off the end."""
    try:
        return float(words[index])
    except (IndexError, ValueError):
        return 0.0

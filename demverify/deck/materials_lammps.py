"""LAMMPS contact styles -> ContactLaw and Wall: pair_style gran/* and granular, fix wall/gran.

The rules are those of the documentation, checked against the wheel of 22 July 2025. Walls of style hooke/history and
hertz/history follow the documentation where the wheel does not (see the register of engine deviations).
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from demsolver.scene import Arm, ContactLaw, Cylinder, Plane, Slab, Wall
from demverify.deck import materials_granular as granular
from demverify.deck.materials_common import AXES, Words, group_bit, pair_tables, shear
from demverify.deck.materials_granular_words import parse
from demverify.deck.planes import check_across, checked, moving_plane, region_shape
from demverify.deck.setup import Floats, Setup, Spec
from demverify.errors import InputError, Place

CLASSIC = {  # style -> laws; pairs are called gran/<style>
    "hooke": ("hooke", "mass_velocity", "none", "mass", "no_history"),
    "hooke/history": ("hooke", "mass_velocity", "constant", "mass", "classic_history"),
    "hertz/history": ("hertz", "viscoelastic", "mindlin", "mass_radius", "classic_history"),
}
PAIR_STYLES = (*(f"gran/{style}" for style in CLASSIC), "granular")
WALL_STYLES = ("granular", *CLASSIC)
PLANES = tuple(f"{axis}plane" for axis in AXES)
SHAPES = (*PLANES, "zcylinder", "region", "plane")  # plane: of the native engine alone


def pair_law(setup: Setup) -> ContactLaw | None:
    """The law between particles; None without a pair style. Raises InputError for an unknown style, wrong or missing numbers."""
    if setup.pair_style in (None, ("none",)):
        return None
    words = Words(setup.pair_style or (), "pair_style", setup.pair_place)
    style = words.choice("style", PAIR_STYLES)
    words.what = f"pair_style {style}"
    if style == "granular":
        if words:
            raise words.error(f"with a cutoff ({words.peek()}) is not supported yet; leave it out")
        return _granular_pairs(setup)
    law = _classic(words, style.removeprefix("gran/"), (setup.ntypes, setup.ntypes))
    words.end()
    _check_classic_pairs(setup)
    return law


def walls(setup: Setup) -> tuple[Wall, ...]:
    """The walls of all `fix wall/gran` and `fix wall/gran/region`, in the order of the deck."""
    return tuple(_wall(setup, fix) for fix in setup.fixes.values() if fix.style in ("wall/gran", "wall/gran/region"))


def elastic(setup: Setup) -> tuple[Floats, Floats]:
    """Young's modulus and Poisson's ratio, (ntypes,) each, as `pair_coeff I I` gives them to a material; NaN for a type without them."""
    young, poisson = np.full(setup.ntypes, np.nan), np.full(setup.ntypes, np.nan)
    for coeffs, place in setup.pair_coeffs if (setup.pair_style or ("",))[0] == "granular" else ():
        words = Words(coeffs, "pair_coeff", place)
        own = [i - 1 for i, j in _pairs(words, setup.ntypes) if i == j]
        model = parse(words)
        material = model.normal in granular.MATERIALS
        young[own], poisson[own] = (model.normal_numbers[0], model.poisson) if material else (np.nan, np.nan)
    return young, poisson


def _classic(words: Words, style: str, shape: tuple[int, ...]) -> ContactLaw:
    """`kn kt gamman gammat mu dampflag [limit_damping]` of the styles before `granular`; one set for all types."""
    kn = words.number("kn", 0.0)
    kt = words.number_or("kt", 2.0 / 7.0 * kn, 0.0)
    gamman = words.number("gamma_n", 0.0)
    gammat = words.number_or("gamma_t", 0.5 * gamman, 0.0)
    mu = words.number("mu", 0.0, 10000.0)
    if words.integer("dampflag", 0, 1) == 0:
        gammat = 0.0
    normal, damping, stiffness, tangential_damping, friction = CLASSIC[style]
    values = {"kn": kn, "gamman": gamman, "gammat": gammat, "mu": mu}
    if stiffness != "none":
        values["shear_stiffness"] = kt
    return ContactLaw(
        normal=normal,
        damping=damping,
        tangential_stiffness=stiffness,
        tangential_damping=tangential_damping,
        friction=friction,
        coefficients={name: np.full(shape, value) for name, value in values.items()},
        limit_damping=words.skip("limit_damping"),
    )


def _check_classic_pairs(setup: Setup) -> None:
    """`pair_coeff I J` takes no numbers here, but must name every type."""
    seen: set[tuple[int, int]] = set()
    for coeffs, place in setup.pair_coeffs:
        words = Words(coeffs, "pair_coeff", place)
        seen.update(_pairs(words, setup.ntypes))
        words.end()
    _require_all_types(setup, seen)


def _require_all_types(setup: Setup, seen: set[tuple[int, int]]) -> None:
    missing = [i for i in range(1, setup.ntypes + 1) if (i, i) not in seen]
    if missing:
        style = (setup.pair_style or ("",))[0]
        message = f"pair_style {style}: no pair_coeff for type {missing[0]}; give pair_coeff {missing[0]} {missing[0]}, or * *"
        raise InputError(message, setup.pair_place)


def _pairs(words: Words, ntypes: int) -> list[tuple[int, int]]:
    """The type pairs i <= j that the next two words name."""
    first, second = words.take("type"), words.take("type")
    if first.isdecimal() and second.isdecimal() and int(first) > int(second):
        first, second = second, first
    pairs = [(i, j) for i in _types(words, first, ntypes) for j in _types(words, second, ntypes) if i <= j]
    if not pairs:
        raise words.error(f"{first} {second} names no pair of types I <= J")
    return pairs


def _types(words: Words, word: str, ntypes: int) -> range:
    """Types of `n`, `*`, `n*`, `*n` or `m*n`."""
    low, star, high = word.partition("*")
    if not star:
        high = low
    if not all(part.isdecimal() or (part == "" and star) for part in (low, high)):
        raise words.error(f"type {word!r} is neither a number nor a range like 1*3")
    first, last = int(low or 1), int(high or ntypes)
    if not 1 <= first <= last <= ntypes:
        raise words.error(f"type {word} is outside 1 to {ntypes}")
    return range(first, last + 1)


def _granular_pairs(setup: Setup) -> ContactLaw:
    given: dict[tuple[int, int], granular.Model] = {}
    place = setup.pair_place
    for coeffs, place in setup.pair_coeffs:
        words = Words(coeffs, "pair_coeff", place)
        pairs = _pairs(words, setup.ntypes)
        given.update(dict.fromkeys(pairs, parse(words)))
    _require_all_types(setup, set(given))
    laws = {
        (i, j): granular.laws(given.get((i, j)) or _mixed(given[i, i], given[j, j], (i, j), place))
        for i in range(1, setup.ntypes + 1)
        for j in range(i, setup.ntypes + 1)
    }
    _require_one_form(laws, place)
    tables = pair_tables(setup.ntypes, {pair: law.coefficients for pair, law in laws.items()})
    return _granular_law(laws[1, 1], tables, "contact")


def _mixed(a: granular.Model, b: granular.Model, pair: tuple[int, int], place: Place | None) -> granular.Model:
    if a.form != b.form:
        message = f"pair_coeff {pair[0]} {pair[1]} is missing and cannot be mixed: {' '.join(a.form)} is not {' '.join(b.form)}"
        raise InputError(message, place)
    if a.poisson * b.poisson < 0.0:
        message = (
            f"pair_coeff {pair[0]} {pair[1]} is missing and cannot be mixed: the Poisson's ratios {a.poisson:g} and {b.poisson:g}"
            " have no geometric mean"
        )
        raise InputError(message, place)
    return granular.mix(a, b)


def _require_one_form(laws: dict[tuple[int, int], granular.Laws], place: Place | None) -> None:
    for (i, j), law in laws.items():
        if law.law != laws[1, 1].law:
            message = (
                f"pair_coeff {i} {j} has other models than pair_coeff 1 1, which is not supported yet;"
                " supported: one model, with numbers of its own for each pair of types"
            )
            raise InputError(message, place)


def _granular_law(laws: granular.Laws, coefficients: dict[str, Floats], torque_arm: Arm) -> ContactLaw:
    return replace(laws.law, coefficients=coefficients, torque_arm=torque_arm)


def _wall(setup: Setup, fix: Spec) -> Wall:
    words = Words(fix.args, f"fix {fix.id} {fix.style}", fix.place)
    law = _wall_law(words, words.choice("style", WALL_STYLES), setup.ntypes)
    if fix.style == "wall/gran/region":
        return Wall(fix.id, checked(words, region_shape(words, setup), setup), law, group_bit(setup, fix))
    shape = _shape(words, setup)
    velocity = (0.0, 0.0, 0.0)
    if isinstance(shape, Plane):
        return Wall(fix.id, checked(words, shape, setup), law, group_bit(setup, fix))
    while words:
        option = words.choice("option", ("shear", "contacts", "wiggle"))
        if option == "wiggle":
            raise words.error("option wiggle is not supported yet; supported: shear, contacts")
        if option == "shear":
            velocity = _shear(words, shape)
    return Wall(fix.id, shape, law, group_bit(setup, fix), velocity)


def _shear(words: Words, shape: Slab | Cylinder) -> tuple[float, float, float]:
    axis, speed = shear(words)
    if isinstance(shape, Slab) and axis == shape.axis:
        raise words.error(f"cannot shear along {AXES[axis]}, the wall's own normal")
    if isinstance(shape, Cylinder) and axis != shape.axis:
        message = (
            f"shear {AXES[axis]} should turn the cylinder, but in LAMMPS leaves its surface at rest in places (lammps-cylinder-shear);"
            " what turns one: region ID cylinder ... rotate, with fix wall/gran/region"
        )
        raise words.error(message)
    return tuple(speed if k == axis else 0.0 for k in range(3))  # type: ignore[return-value]


def _wall_law(words: Words, style: str, ntypes: int) -> ContactLaw:
    if style != "granular":
        return _classic(words, style, (ntypes,))
    laws = granular.laws(parse(words, SHAPES))
    return _granular_law(laws, {name: np.full(ntypes, value) for name, value in laws.coefficients.items()}, "radius")


def _shape(words: Words, setup: Setup) -> Slab | Cylinder | Plane:
    word = words.choice("wall", SHAPES)
    if word == "region":
        raise words.error("takes a region as fix wall/gran/region alone")
    if word == "plane":
        return moving_plane(words)
    axis = AXES.index(word[0])
    check_across(words, (axis,) if word in PLANES else (0, 1), word, setup)
    if word in PLANES:
        return Slab(axis, words.number_or("lower plane", -inf), words.number_or("upper plane", inf))
    return Cylinder(axis, (0.0, 0.0), words.positive("radius"), "curved")

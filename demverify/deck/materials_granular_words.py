"""The words of LAMMPS' granular models (pair_coeff of pair_style granular, fix wall/gran granular) -> Model.

A normal law that exists as `demsolver/contact/normal_<word>.py` needs nothing here: its coefficients are read from the deck in the order of
its signature, then the damping coefficient, unless it is a step law, which has none.
"""

from __future__ import annotations

from typing import Any

from demsolver import contact
from demverify.deck.materials_common import Words
from demverify.deck.materials_granular import COHESIVE, MATERIALS, TANGENTIAL, Model

RESISTANCE = ("k", "gamma", "mu")
SUB_MODELS: dict[str, dict[str, tuple[str, ...]]] = {  # keyword -> model -> its numbers
    "rolling": {"none": (), "sds": RESISTANCE, "primer": ("mu_r",)},  # primer: of the native engine alone
    "twisting": {"none": (), "marshall": (), "sds": RESISTANCE},
}
RESTITUTION = ("coeff_restitution", "tsuji")  # damping models whose number is a restitution
KEYWORDS = ("damping", "tangential", *SUB_MODELS, "limit_damping", "cutoff")


def normal_words() -> tuple[str, ...]:
    """Normal models a deck may name: every normal law with plain coefficients, and those of materials."""
    return (*(name for name in contact.listing("normal") if name not in COHESIVE), *MATERIALS)


def damping_words() -> tuple[str, ...]:
    """Damping models a deck may name: every damping law with at most one coefficient, and those that derive it from a restitution."""
    plain = (name for name in contact.listing("damping") if len(contact.coefficients("damping", name)) <= 1)
    return (*plain, *RESTITUTION)


def parse(words: Words, stop: tuple[str, ...] = ()) -> Model:
    """Reads a model up to the end, or to a word of `stop`. Raises InputError."""
    normal = words.choice("normal model", normal_words())
    steps = normal not in MATERIALS and contact.is_step_law(normal)
    parts: dict[str, Any] = {"damping": "none" if steps else "viscoelastic", "limit_damping": False}
    numbers = _normal_numbers(words, normal, steps)
    while words and words.peek() not in stop:
        keyword = words.choice("keyword", KEYWORDS)
        if keyword == "damping":
            parts["damping"] = words.choice("damping model", damping_words())
        elif keyword == "tangential":
            parts |= _tangential(words, normal)
        elif keyword == "limit_damping":
            parts["limit_damping"] = True
        elif keyword == "cutoff":
            raise words.error("keyword cutoff is not supported yet; leave it out, particles interact when they touch")
        else:
            parts |= _sub_model(words, keyword)
    if "tangential" not in parts:
        raise words.error(f"needs a tangential model: tangential {' | '.join(TANGENTIAL)}")
    model = Model(normal, numbers, **parts)
    _check_damping(words, model, steps)
    return model


def _normal_numbers(words: Words, normal: str, steps: bool) -> tuple[float, ...]:
    if normal in MATERIALS:
        young, damping = words.positive("Young's modulus"), words.number("damping coefficient", 0.0)
        return young, damping, words.number("Poisson's ratio", -0.99, 0.5), *(words.number(name, 0.0) for name in MATERIALS[normal][1])
    names = contact.coefficients("normal", normal)
    return tuple(_coefficient(words, name) for name in (names if steps else (*names, "damping coefficient")))


def _coefficient(words: Words, name: str) -> float:
    """A restitution lies in (0, 1], any other coefficient is at least 0."""
    if name != "restitution":
        return words.number(name, 0.0)
    value = words.positive(name)
    return words.within(name, value, 0.0, 1.0)


def _tangential(words: Words, normal: str) -> dict[str, Any]:
    """tangential, kt or None, xt, mu."""
    model = words.choice("tangential model", TANGENTIAL)
    kt = None
    if TANGENTIAL[model][0] == "mindlin" and words.skip("NULL"):
        if normal not in MATERIALS:
            raise words.error(f"kt NULL needs a normal model with material constants: {', '.join(MATERIALS)}")
    elif model != "linear_nohistory":
        kt = words.number("kt", 0.0)
    return {"tangential": model, "kt": kt, "xt": words.number("xt", 0.0), "mu": words.number("mu", 0.0)}


def _sub_model(words: Words, keyword: str) -> dict[str, Any]:
    """The model behind `rolling` or `twisting`, and its numbers."""
    model = words.choice(f"{keyword} model", SUB_MODELS[keyword])
    numbers = tuple(words.number(f"{name} of {keyword} {model}", 0.0) for name in SUB_MODELS[keyword][model])
    return {keyword: model, f"{keyword}_numbers": numbers}


def _check_damping(words: Words, model: Model, steps: bool) -> None:
    """Raises InputError for damping that does not go with the normal model."""
    if steps:
        _check_step_law(words, model)
    elif model.damping == "none" and (model.normal in MATERIALS or not contact.is_implicit(model.normal)):
        raise words.error("damping none is for laws of this solver alone; LAMMPS wants a damping model here: give it the damping coefficient 0")
    if model.normal in COHESIVE and (model.limit_damping or model.damping in RESTITUTION):
        wrong = "limit_damping" if model.limit_damping else f"damping {model.damping}"
        raise words.error(f"{wrong} does not go with the cohesive normal model {model.normal}, as in LAMMPS")
    if model.damping in RESTITUTION:
        what, value = f"restitution of damping {model.damping}", model.damping_number
        if model.damping == "coeff_restitution" and not 0.0 < value <= 1.0:
            raise words.error(f"{what} must be above 0 and at most 1, got {value:g}")
        words.within(what, value, 0.0, 1.0)


def _check_step_law(words: Words, model: Model) -> None:
    """A step law holds all damping itself."""
    if model.damping != "none":
        raise words.error(f"normal model {model.normal} holds all damping in its step: damping must be none, got {model.damping}")
    if model.limit_damping or model.xt:
        wrong = "limit_damping" if model.limit_damping else f"xt = {model.xt:g} of the tangential model"
        raise words.error(f"normal model {model.normal} holds all damping in its step, so there is none for {wrong}")

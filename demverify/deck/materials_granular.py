"""The words of LAMMPS' granular models (pair_style granular, fix wall/gran granular) -> contact laws and their coefficients.

A normal law that exists as `demsolver/contact/normal_<word>.py` needs nothing here: its coefficients are read from the deck in
the order of its signature, then the damping coefficient. Mixing and material rules were measured on the wheel of 22 July 2025.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi, sqrt

from demsolver import contact
from demsolver.scene import ContactLaw
from demverify.deck.materials_common import Words

MATERIAL = "hertz/material"
TANGENTIAL = {  # deck word -> tangential_stiffness, friction
    "linear_nohistory": ("none", "no_history"),
    "linear_history": ("constant", "rotated_history"),
    "mindlin": ("mindlin", "rotated_history"),
}
ABSENT = ("rolling", "twisting")  # models that the deck may switch off by name


@dataclass(frozen=True)
class Model:
    """One granular model as the deck wrote it.

    normal_numbers: the normal law's coefficients, then the damping number; for hertz/material E, damping number, Poisson's ratio.
    kt: None where the deck has NULL or the law has no spring. mixed: two materials were mixed, E is already E*.
    """

    normal: str
    normal_numbers: tuple[float, ...]
    damping: str
    tangential: str
    kt: float | None
    xt: float
    mu: float
    limit_damping: bool
    mixed: bool = False

    @property
    def form(self) -> tuple[str, str, str]:
        """Names of the sub-models; only equal forms mix."""
        return self.normal, self.damping, self.tangential

    @property
    def damping_number(self) -> float:
        """The damping coefficient of the normal model."""
        return self.normal_numbers[1 if self.normal == MATERIAL else -1]


@dataclass(frozen=True)
class Laws:
    """A model as contact laws: the ContactLaw without its coefficients, and the coefficients of one type pair."""

    law: ContactLaw
    coefficients: dict[str, float]


def damping_words() -> tuple[str, ...]:
    """Damping models a deck may name: every damping law with one coefficient, and the two that derive it from a restitution."""
    plain = (name for name in contact.listing("damping") if len(contact.coefficients("damping", name)) == 1)
    return (*plain, "coeff_restitution", "tsuji")


def parse(words: Words, stop: tuple[str, ...] = ()) -> Model:
    """Reads a model up to the end, or to a word of `stop`. Raises InputError."""
    normal = words.choice("normal model", (*contact.listing("normal"), MATERIAL))
    numbers = _normal_numbers(words, normal)
    damping, limit = "viscoelastic", False
    tangential: tuple[str, float | None, float, float] | None = None
    while words and words.peek() not in stop:
        keyword = words.choice("keyword", ("damping", "tangential", *ABSENT, "limit_damping", "cutoff"))
        if keyword == "damping":
            damping = words.choice("damping model", damping_words())
        elif keyword == "tangential":
            tangential = _tangential(words, normal)
        elif keyword == "limit_damping":
            limit = True
        elif keyword == "cutoff":
            raise words.error("keyword cutoff is not supported yet; leave it out, particles interact when they touch")
        elif words.take(f"{keyword} model") != "none":
            raise words.error(f"{keyword} models are not supported yet; supported: {keyword} none")
    if tangential is None:
        raise words.error(f"needs a tangential model: tangential {' | '.join(TANGENTIAL)}")
    model = Model(normal, numbers, damping, *tangential, limit)
    _check_restitution(words, model)
    return model


def _normal_numbers(words: Words, normal: str) -> tuple[float, ...]:
    if normal == MATERIAL:
        young, damping = words.positive("Young's modulus"), words.number("damping coefficient", 0.0)
        return young, damping, words.number("Poisson's ratio", -0.99, 0.5)
    names = (*contact.coefficients("normal", normal), "damping coefficient")
    return tuple(words.number(name, 0.0) for name in names)


def _tangential(words: Words, normal: str) -> tuple[str, float | None, float, float]:
    """(model, kt or None, xt, mu)."""
    model = words.choice("tangential model", TANGENTIAL)
    kt = None
    if model == "mindlin" and words.skip("NULL"):
        if normal != MATERIAL:
            raise words.error(f"kt NULL needs a normal model with material constants: {MATERIAL}")
    elif model != "linear_nohistory":
        kt = words.number("kt", 0.0)
    return model, kt, words.number("xt", 0.0), words.number("mu", 0.0)


def _check_restitution(words: Words, model: Model) -> None:
    if model.damping in ("tsuji", "coeff_restitution"):
        low = 0.0 if model.damping == "tsuji" else 1e-300
        words.within(f"restitution of damping {model.damping}", model.damping_number, low, 1.0)


def mix(a: Model, b: Model) -> Model:
    """The model of two types whose pair has no coefficients of its own; a.form == b.form. Everything mixes geometrically, except
    E and nu of hertz/material, which give E*."""
    numbers = tuple(sqrt(p * q) for p, q in zip(a.normal_numbers, b.normal_numbers, strict=True))
    if a.normal == MATERIAL:
        (young_a, _, nu_a), (young_b, _, nu_b) = a.normal_numbers, b.normal_numbers
        numbers = (effective_young(young_a, nu_a, young_b, nu_b), *numbers[1:])
    kt = None if a.kt is None or b.kt is None else sqrt(a.kt * b.kt)
    xt, mu = sqrt(a.xt * b.xt), sqrt(a.mu * b.mu)
    return Model(*a.form[:1], numbers, *a.form[1:], kt, xt, mu, a.limit_damping or b.limit_damping, mixed=True)


def laws(model: Model) -> Laws:
    """Names and coefficients of the contact laws that a model stands for."""
    normal, coefficients = _normal_law(model)
    damping, damping_coefficients = _damping_law(model)
    stiffness, friction = TANGENTIAL[model.tangential]
    tangential = {"xt": model.xt, "mu": model.mu}
    if model.tangential != "linear_nohistory":
        tangential["shear_stiffness"] = _shear_stiffness(model)
    law = ContactLaw(normal, damping, stiffness, "scaled", friction, {}, limit_damping=model.limit_damping)
    return Laws(law, coefficients | damping_coefficients | tangential)


def _normal_law(model: Model) -> tuple[str, dict[str, float]]:
    if model.normal != MATERIAL:
        return model.normal, dict(zip(contact.coefficients("normal", model.normal), model.normal_numbers, strict=False))
    young, _, nu = model.normal_numbers
    return "hertz", {"kn": 4.0 / 3.0 * (young if model.mixed else effective_young(young, nu, young, nu))}


def _damping_law(model: Model) -> tuple[str, dict[str, float]]:
    number = model.damping_number
    if model.damping == "tsuji":
        return "fraction", {"damping_fraction": tsuji_fraction(number)}
    if model.damping == "coeff_restitution":
        return "fraction", {"damping_fraction": restitution_fraction(number, linear=model.normal == "hooke")}
    return model.damping, {contact.coefficients("damping", model.damping)[0]: number}


def _shear_stiffness(model: Model) -> float:
    """kt, or 8 G* where the deck has NULL. For mixed materials the wheel puts E* in the place of E here (measured)."""
    if model.kt is not None:
        return model.kt
    young, _, nu = model.normal_numbers
    return 8.0 * effective_shear(young, nu, young, nu)


def effective_young(young_i: float, nu_i: float, young_j: float, nu_j: float) -> float:
    """E*: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j."""
    return 1.0 / ((1.0 - nu_i**2) / young_i + (1.0 - nu_j**2) / young_j)


def effective_shear(young_i: float, nu_i: float, young_j: float, nu_j: float) -> float:
    """G*: 1/G* = 2 (2 - nu_i)(1 + nu_i)/E_i + 2 (2 - nu_j)(1 + nu_j)/E_j."""
    return 1.0 / (2.0 * (2.0 - nu_i) * (1.0 + nu_i) / young_i + 2.0 * (2.0 - nu_j) * (1.0 + nu_j) / young_j)


def tsuji_fraction(restitution: float) -> float:
    """Damping fraction of `damping tsuji`: the polynomial of J. S. Marshall, J. Comput. Phys. 228 (2009) 1541, eq. 53, as
    the wheel codes it. A factor sqrt(2) is missing, by its definition of the effective mass: a nominal 0.5 acts as 0.616."""
    powers = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    return sum(c * restitution**k for k, c in enumerate(powers))


def restitution_fraction(restitution: float, *, linear: bool) -> float:
    """Damping fraction with which a linear (else a Hertz) spring rebounds with `restitution` in (0, 1]."""
    log_e = log(restitution)
    return -(2.0 if linear else sqrt(5.0)) * log_e / sqrt(pi**2 + log_e**2)

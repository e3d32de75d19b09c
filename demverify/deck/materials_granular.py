"""LAMMPS' granular models (pair_style granular, fix wall/gran granular) -> contact laws and their coefficients.

Read from the deck by materials_granular_words. Mixing and material rules were measured on the wheel of 22 July 2025.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi, sqrt

from demsolver import contact
from demsolver.scene import ContactLaw

MATERIALS = {  # deck word of a normal model with material constants -> law, what stands behind E, damping number and Poisson's ratio
    "dmt": ("dmt", ("surface energy",)),
    "jkr": ("jkr", ("surface energy",)),
    "hertz/material": ("hertz", ()),
}
COHESIVE = ("dmt", "jkr")
TANGENTIAL = {  # deck word -> tangential_stiffness, friction
    "linear_nohistory": ("none", "no_history"),
    "linear_history": ("constant", "rotated_history"),
    "mindlin": ("mindlin", "rotated_history"),
    "mindlin/force": ("mindlin", "mindlin_force"),
    "mindlin_rescale": ("mindlin", "mindlin_rescale"),
    "mindlin_rescale/force": ("mindlin", "mindlin_rescale_force"),
    "primer": ("constant", "primer"),  # of the native engine alone
}


@dataclass(frozen=True)
class Model:
    """One granular model as the deck wrote it.

    normal_numbers: the normal law's coefficients, then the damping number if there is one; of MATERIALS E, damping number, Poisson's ratio,
    and the rest. damping "none": a step law, which has no damping number. kt: None where the deck has NULL or the law has no spring.
    rolling_numbers, twisting_numbers: k, gamma, mu where the model has them. mixed: two materials were mixed, E is already E*.
    """

    normal: str
    normal_numbers: tuple[float, ...]
    damping: str
    tangential: str
    kt: float | None
    xt: float
    mu: float
    limit_damping: bool
    rolling: str = "none"
    rolling_numbers: tuple[float, ...] = ()
    twisting: str = "none"
    twisting_numbers: tuple[float, ...] = ()
    mixed: bool = False

    @property
    def form(self) -> tuple[str, ...]:
        """Names of the sub-models; only equal forms mix."""
        return self.normal, self.damping, self.tangential, self.rolling, self.twisting

    @property
    def damping_number(self) -> float:
        """The damping coefficient of the normal model."""
        return self.normal_numbers[1 if self.normal in MATERIALS else -1]

    @property
    def poisson(self) -> float:
        """Poisson's ratio; 0 where the model has none."""
        return self.normal_numbers[2] if self.normal in MATERIALS else 0.0


@dataclass(frozen=True)
class Laws:
    """A model as contact laws: the ContactLaw without its coefficients, and the coefficients of one type pair."""

    law: ContactLaw
    coefficients: dict[str, float]


def mix(a: Model, b: Model) -> Model:
    """The model of two types whose pair has no coefficients of its own; a.form == b.form. Everything mixes geometrically, except
    E and nu of a material, which give E*. The two Poisson's ratios must be of one sign."""
    numbers = _geometric(a.normal_numbers, b.normal_numbers)
    if a.normal in MATERIALS:
        (young_a, _, nu_a), (young_b, _, nu_b) = a.normal_numbers[:3], b.normal_numbers[:3]
        numbers = (effective_young(young_a, nu_a, young_b, nu_b), *numbers[1:])
    return Model(
        a.normal,
        numbers,
        a.damping,
        a.tangential,
        None if a.kt is None or b.kt is None else sqrt(a.kt * b.kt),
        sqrt(a.xt * b.xt),
        sqrt(a.mu * b.mu),
        a.limit_damping or b.limit_damping,
        a.rolling,
        _geometric(a.rolling_numbers, b.rolling_numbers),
        a.twisting,
        _geometric(a.twisting_numbers, b.twisting_numbers),
        mixed=True,
    )


def _geometric(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(sqrt(p * q) for p, q in zip(a, b, strict=True))


def laws(model: Model) -> Laws:
    """Names and coefficients of the contact laws that a model stands for."""
    normal, coefficients = _normal_law(model)
    damping, damping_coefficients = _damping_law(model)
    stiffness, friction = TANGENTIAL[model.tangential]
    tangential_damping = "none" if model.damping == "none" else "scaled"
    tangential = {"xt": model.xt, "mu": model.mu}
    if model.tangential != "linear_nohistory" or model.twisting == "marshall":
        tangential["shear_stiffness"] = _shear_stiffness(model)
    law = ContactLaw(
        normal,
        damping,
        stiffness,
        tangential_damping,
        friction,
        {},
        limit_damping=model.limit_damping,
        rolling=model.rolling,
        twisting=model.twisting,
    )
    against_turning = _named("rolling", model.rolling, model.rolling_numbers) | _named("twisting", model.twisting, model.twisting_numbers)
    return Laws(law, coefficients | damping_coefficients | tangential | against_turning)


def _named(family: contact.Family, law: str, numbers: tuple[float, ...]) -> dict[str, float]:
    """The numbers by the names of the law's own coefficients; a law without numbers takes those of its neighbours."""
    return dict(zip(contact.coefficients(family, law), numbers, strict=True)) if numbers else {}


def _normal_law(model: Model) -> tuple[str, dict[str, float]]:
    if model.normal not in MATERIALS:
        return model.normal, dict(zip(contact.coefficients("normal", model.normal), model.normal_numbers, strict=False))
    young, _, nu, *rest = model.normal_numbers
    young = young if model.mixed else effective_young(young, nu, young, nu)
    stiffness = {"yeff": young} if model.normal == "jkr" else {"kn": 4.0 / 3.0 * young}
    return MATERIALS[model.normal][0], stiffness | dict(zip(("surface_energy",), rest, strict=False))


def _damping_law(model: Model) -> tuple[str, dict[str, float]]:
    if model.damping == "none":
        return "none", {}
    number = model.damping_number
    if model.damping == "tsuji":
        return "fraction", {"damping_fraction": tsuji_fraction(number)}
    if model.damping == "coeff_restitution":
        return "fraction", {"damping_fraction": restitution_fraction(number, linear=model.normal == "hooke")}
    return model.damping, {contact.coefficients("damping", model.damping)[0]: number}


def _shear_stiffness(model: Model) -> float:
    """kt, or 8 G* where the deck has NULL; 0 without a spring. For mixed materials the wheel puts E* in the place of E here (measured)."""
    if model.tangential == "linear_nohistory":
        return 0.0
    if model.kt is not None:
        return model.kt
    young, _, nu = model.normal_numbers[:3]
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

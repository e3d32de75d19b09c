"""Force fixes: from the words of a fix to demsolver.scene."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, sin, sqrt

import numpy as np

from demsolver.expression import Expression, Number
from demsolver.scene import (
    AddForce,
    Enforce2D,
    EulerSphere,
    Force,
    Freeze,
    Gravity,
    Integrator,
    NveClumps,
    NveSphere,
    NveSuperquadric,
    SetForce,
    Viscous,
)
from demverify.deck.materials_common import Words, group_bit
from demverify.deck.setup import Setup, Spec
from demverify.errors import InputError


def _words(spec: Spec) -> Words:
    return Words(spec.args, f"fix {spec.id} {spec.style}", spec.place)


def _number(words: Words, wanted: str) -> float:
    if words.peek().startswith("v_"):
        raise words.error(f"{wanted} as a variable ({words.peek()}) is not supported: expected a number")
    return words.number(wanted)


def gravity(setup: Setup, spec: Spec) -> Gravity:
    """fix gravity: chute A tilts by A degrees from -z towards +x; spherical PHI THETA in degrees; vector x y z is normalised.

    In two dimensions the vertical is y (measured on both engines)."""
    words = _words(spec)
    magnitude = _number(words, "magnitude")
    style = words.choice("style", ("vector", "chute", "spherical"))
    if style == "vector":
        direction = _vector(setup, words)
    else:
        phi = 0.0 if style == "chute" else _number(words, "phi")
        theta = 180.0 - _number(words, "angle") if style == "chute" else _number(words, "theta")
        direction = _spherical(setup, phi * (pi / 180.0), theta * (pi / 180.0))
    words.end()
    x, y, z = (magnitude * component for component in direction)
    return Gravity((x, y, z), group_bit(setup, spec))


def _spherical(setup: Setup, phi: float, theta: float) -> tuple[float, float, float]:
    if setup.dimension == 2:
        return sin(theta), cos(theta), 0.0
    return sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)


def _vector(setup: Setup, words: Words) -> tuple[float, float, float]:
    x, y, z = (_number(words, axis) for axis in "xyz")
    if setup.dimension == 2:
        z = 0.0
    length = sqrt(x * x + y * y + z * z)
    if length == 0.0:
        raise words.error("the vector must not be zero")
    return x / length, y / length, z / length


def freeze(setup: Setup, spec: Spec) -> Freeze:
    """fix freeze"""
    _words(spec).end()
    return Freeze(group_bit(setup, spec))


def enforce2d(setup: Setup, spec: Spec) -> Enforce2D:
    """fix enforce2d"""
    words = _words(spec)
    words.end()
    if setup.dimension != 2:
        raise words.error("needs dimension 2")
    return Enforce2D(group_bit(setup, spec))


def setforce(setup: Setup, spec: Spec) -> SetForce:
    """fix setforce fx fy fz, NULL leaves a component alone."""
    words = _words(spec)
    fx, fy, fz = (None if words.skip("NULL") else _number(words, f"f{axis}") for axis in "xyz")
    words.end()
    return SetForce((fx, fy, fz), group_bit(setup, spec))


def viscous(setup: Setup, spec: Spec) -> Viscous:
    """fix viscous gamma [scale TYPE RATIO]..."""
    words = _words(spec)
    drag = _number(words, "gamma")
    gamma = np.full(setup.ntypes, drag)
    while words:
        words.choice("keyword", ("scale",))
        which = words.integer("type", 1, setup.ntypes) - 1
        gamma[which] = drag * words.number("ratio")
    return Viscous(gamma, group_bit(setup, spec))


def _added_words(setup: Setup, spec: Spec) -> tuple[str, str, str]:
    """The words of fix addforce: three numbers or v_names, which may be defined up to the run."""
    words = _words(spec)
    x, y, z = (words.take("a variable") if words.peek().startswith("v_") else repr(words.number(f"f{axis}")) for axis in "xyz")
    if words:
        raise words.error(f"keyword {words.peek()!r} (every, region, energy ...) is not supported: the force acts in every step and everywhere")
    return x, y, z


def addforce(setup: Setup, spec: Spec) -> AddForce:
    """fix addforce fx fy fz: numbers, or v_NAME of equal-style or atom-style variables as they are at the begin of the run."""
    x, y, z = (_component(setup, spec, word) for word in _added_words(setup, spec))
    return AddForce((x, y, z), group_bit(setup, spec))


def _component(setup: Setup, spec: Spec, word: str) -> Expression:
    if not word.startswith("v_"):
        return Number(float(word))
    try:
        found: Expression = setup.variables.expression(word[2:], setup, spec.place)
    except InputError as error:
        raise InputError(f"fix {spec.id} {spec.style}: {error.message}", spec.place) from None
    return found


RIGID = {"rigid/small": "richardson", "rigid": "richardson", "rigid/nve/small": "no_squish", "rigid/nve": "no_squish"}
"""LAMMPS' fixes of rigid bodies, and how they turn."""


def rigid_integrator(setup: Setup, spec: Spec) -> NveClumps:
    """fix rigid[/nve][/small] molecule [mol ID] [reinit yes]; fix multisphere."""
    words = _words(spec)
    if spec.style == "multisphere":
        words.end()
        return NveClumps(group_bit(setup, spec))
    words.choice("body style", ("molecule",))
    while words:
        if words.choice("keyword", ("mol", "reinit")) == "mol":
            words.take("a molecule")
        else:
            words.choice("reinit", ("yes",))
    return NveClumps(group_bit(setup, spec), RIGID[spec.style])


def property_atom(_: Setup, spec: Spec) -> None:
    """fix property/atom mol [ghost yes|no]: spheres get a molecule number."""
    words = _words(spec)
    words.choice("property", ("mol",))
    while words:
        words.choice("keyword", ("ghost",))
        words.choice("ghost", ("yes", "no"))


SCHEMES = ("richardson", "no_squish", "midpoint", "woodem")
"""LIGGGHTS' integration_scheme 0 to 3."""


def superquadric_integrator(setup: Setup, spec: Spec) -> NveSuperquadric:
    """fix nve/superquadric [integration_scheme 0|1|2|3]; 1 where nothing is said."""
    words = _words(spec)
    scheme = 1
    while words:
        words.choice("keyword", ("integration_scheme",))
        scheme = words.integer("integration_scheme", 0, len(SCHEMES) - 1)
    if setup.atom_style != "superquadric":
        raise words.error("needs atom_style superquadric")
    return NveSuperquadric(group_bit(setup, spec), SCHEMES[scheme])


def integrator(setup: Setup, spec: Spec) -> NveSphere | EulerSphere:
    """fix nve/sphere [disc]: discs, I = m R^2/2, are what LIGGGHTS takes in two dimensions (measured) and LAMMPS when asked.

    fix euler/sphere [disc], of the native engine alone: semi-implicit Euler."""
    words = _words(spec)
    if setup.atom_style == "superquadric":
        raise words.error("moves spheres: superquadrics need fix nve/superquadric")
    disc = setup.dialect == "liggghts" and setup.dimension == 2
    while words:
        words.choice("keyword", ("disc",) if setup.dialect == "lammps" else ())
        if setup.dimension != 2:
            raise words.error("disc needs dimension 2")
        disc = True
    return (NveSphere if spec.style == "nve/sphere" else EulerSphere)(group_bit(setup, spec), 0.5 if disc else 0.4)


FORCES: dict[str, Callable[[Setup, Spec], Force]] = {
    "gravity": gravity,
    "freeze": freeze,
    "enforce2d": enforce2d,
    "setforce": setforce,
    "viscous": viscous,
    "addforce": addforce,
}
INTEGRATORS: dict[str, Callable[[Setup, Spec], Integrator]] = {
    "nve/sphere": integrator,
    "euler/sphere": integrator,
    "nve/superquadric": superquadric_integrator,
    "multisphere": rigid_integrator,
    **dict.fromkeys(RIGID, rigid_integrator),
}
CHECKS: dict[str, Callable[[Setup, Spec], object]] = {**FORCES, "addforce": _added_words, "property/atom": property_atom, **INTEGRATORS}

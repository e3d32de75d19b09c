"""LIGGGHTS contact models -> ContactLaw and Wall: pair_style gran, fix property/global, fix wall/gran with primitives.

The rules are those of LIGGGHTS 3.8.0 as measured (tests/demverify/deck_materials/test_against_liggghts.py).
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from math import inf, pi, sqrt
from typing import Literal

import numpy as np

from demsolver.scene import ContactLaw, Cylinder, Rotation, Slab, Wall
from demverify.deck.materials_common import AXES, Words, group_bit, shear
from demverify.deck.properties_liggghts import Properties
from demverify.deck.setup import Floats, Setup, Spec
from demverify.errors import Place

FRICTION = {"off": "none", "no_history": "no_history", "history": "liggghts_history"}
COMMON = ("tangential_damping", "limitForce")
SWITCHES = {
    "hooke": (*COMMON, "viscous", "ktToKnUser"),
    "hertz": COMMON,
    "hooke/stiffness": (*COMMON, "absolute_damping"),
    "hertz/stiffness": COMMON,
}
ON_BY_DEFAULT = ("tangential_damping",)
COHESION = {"off": "none", "sjkr": "sjkr"}
ROLLING = {"off": "none", "cdt": "cdt", "epsd": "epsd", "epsd2": "epsd2"}
SURFACE = ("default", "superquadric")
CURVATURES = {"meanCurvature": "mean", "gaussianCurvature": "gaussian"}
PART_OF = {"tangential_reduce": "cohesion", "torsionTorque": "rolling_friction"}
TWO_SEVENTHS = 0.285714286  # as LIGGGHTS writes it
PLANES = tuple(f"{axis}plane" for axis in AXES)
CYLINDERS = tuple(f"{axis}cylinder" for axis in AXES)


@dataclass(frozen=True)
class Model:
    """`model M tangential T cohesion C rolling_friction R` with the switches that are on."""

    normal: str
    tangential: str
    cohesion: str
    rolling: str
    surface: str = "default"
    on: frozenset[str] = frozenset()
    curvature: Literal["volume", "mean", "gaussian"] = "volume"
    curvature_limit: float = inf
    contact_point: Literal["potential", "gauge"] = "potential"
    place: Place | None = None

    @property
    def switches(self) -> tuple[str, ...]:
        """The switches that these models have."""
        there = {"cohesion": self.cohesion != "off", "rolling_friction": self.rolling != "off"}
        return (*SWITCHES[self.normal], *(name for name, part in PART_OF.items() if there[part]))


@dataclass(frozen=True)
class Parts:
    """Law names and coefficient tables (ntypes, ntypes) that a normal model brings."""

    normal: str
    damping: str
    stiffness: str
    tangential_damping: str
    tables: dict[str, Floats]


def pair_law(setup: Setup) -> ContactLaw | None:
    """The law between particles; None without a pair style. Raises InputError for an unknown or unsupported model, a wrong
    keyword order, a missing or wrong property."""
    if setup.pair_style in (None, ("none",)):
        return None
    words = Words(setup.pair_style or (), "pair_style", setup.pair_place)
    words.choice("style", ("gran",))
    words.what = "pair_style gran"
    model = _model(words)
    model = _switches(words, model)
    _check_surface(setup, words, model)
    _check_pair_coeff(setup)
    return _law(setup, model)


def walls(setup: Setup) -> tuple[Wall, ...]:
    """The walls of all `fix wall/gran`, in the order of the deck."""
    return tuple(_wall(setup, fix) for fix in setup.fixes.values() if fix.style == "wall/gran")


def _model(words: Words) -> Model:
    """`model M [tangential T] [cohesion C] [rolling_friction R] [surface default]`; in this order only."""
    if not words.skip("model"):
        raise words.error(f"must begin with model {' | '.join(SWITCHES)}")
    normal = words.choice("model", SWITCHES)
    tangential = words.choice("tangential model", FRICTION) if words.skip("tangential") else "off"
    cohesion, rolling = _part(words, "cohesion", COHESION), _part(words, "rolling_friction", ROLLING)
    return Model(normal, tangential, cohesion, rolling, _part(words, "surface", SURFACE), place=words.place)


def _part(words: Words, keyword: str, supported: Collection[str]) -> str:
    """`KEYWORD NAME`, or the first of `supported`."""
    name = words.take(f"{keyword} model") if words.skip(keyword) else next(iter(supported))
    if name not in supported:
        raise words.error(f"{keyword} {name} is not supported yet; supported: {keyword} {' | '.join(supported)}")
    return name


def _switches(words: Words, model: Model) -> Model:
    on = set(ON_BY_DEFAULT)
    order = "model, tangential, cohesion, rolling_friction, surface, then switches"
    while words:
        if words.peek() in ("tangential", "cohesion", "rolling_friction", "surface"):
            raise words.error(f"has {words.peek()} too late; the order is {order}")
        if model.surface == "superquadric" and words.peek() in SURFACE_SWITCHES:
            model = _surface_switch(words, model)
            continue
        if (part := PART_OF.get(words.peek())) and words.peek() not in model.switches:
            raise words.error(f"has {words.peek()} without a {part} model, whose switch it is")
        name = words.choice(f"switch of model {model.normal}", model.switches)
        state = words.choice(f"switch {name}", ("on", "off"))
        on = on | {name} if state == "on" else on - {name}
    return replace(model, on=frozenset(on))


SURFACE_SWITCHES = ("curvatureLimitFactor", *CURVATURES, "contactPoint")


def _surface_switch(words: Words, model: Model) -> Model:
    """curvatureLimitFactor L, meanCurvature yes|no, gaussianCurvature yes|no; contactPoint potential|gauge is the native engine's own."""
    name = words.take("a switch of surface superquadric")
    if name == "curvatureLimitFactor":
        return replace(model, curvature_limit=words.positive(name))
    if name == "contactPoint":
        return replace(model, contact_point=words.choice(name, ("potential", "gauge")))  # type: ignore[arg-type]
    if words.choice(name, ("yes", "no")) == "no":
        return model
    if model.curvature != "volume":
        raise words.error("has meanCurvature and gaussianCurvature: one of them")
    return replace(model, curvature=CURVATURES[name])  # type: ignore[arg-type]


def _check_surface(setup: Setup, words: Words, model: Model) -> None:
    """Raises InputError where particles and surface model do not go together."""
    if (model.surface == "superquadric") != (setup.atom_style == "superquadric"):
        raise words.error(f"surface {model.surface} does not go with atom_style {setup.atom_style}: superquadric needs superquadric")
    if model.curvature != "volume" and model.curvature_limit == inf:
        raise words.error("meanCurvature and gaussianCurvature need curvatureLimitFactor")
    if model.curvature != "volume" and model.contact_point == "gauge":
        raise words.error("meanCurvature and gaussianCurvature go with contactPoint potential only: the force of gauge would have no energy")
    if model.cohesion != "off" and model.surface == "superquadric":
        raise words.error(f"cohesion {model.cohesion} is known for spheres only, not with surface superquadric")


def contact_point(setup: Setup) -> Literal["potential", "gauge"]:
    """What defines the contact of two superquadrics."""
    if setup.pair_style in (None, ("none",)):
        return "potential"
    words = Words((setup.pair_style or ())[1:], "pair_style gran", setup.pair_place)
    return _switches(words, _model(words)).contact_point


def _check_pair_coeff(setup: Setup) -> None:
    """LIGGGHTS wants `pair_coeff * *` without numbers."""
    for coeffs, place in setup.pair_coeffs:
        words = Words(coeffs, "pair_coeff", place)
        words.take("type"), words.take("type")
        words.end()
    if ("*", "*") not in [coeffs for coeffs, _ in setup.pair_coeffs]:
        raise Words((), "pair_style gran", setup.pair_place).error("needs the line: pair_coeff * *")


def _law(setup: Setup, model: Model) -> ContactLaw:
    """The law with tables (ntypes, ntypes)."""
    properties = Properties(setup, f"model {model.normal}", model.place)
    parts = PARTS[model.normal](properties, model.on)
    friction, tables = FRICTION[model.tangential], dict(parts.tables)
    if friction != "none":
        tables["mu"] = properties.pairs("coefficientFriction", 0.0)
    return ContactLaw(
        normal=parts.normal,
        damping=parts.damping,
        tangential_stiffness=parts.stiffness if friction != "none" or model.rolling == "epsd2" else "none",
        tangential_damping=parts.tangential_damping if friction != "none" and "tangential_damping" in model.on else "none",
        friction=friction,
        coefficients=tables | _cohesion(setup, model) | _rolling(setup, model),
        surface_arm="contact",
        torque_arm="contact",
        limit_damping="limitForce" in model.on,
        cohesion=COHESION[model.cohesion],
        rolling=ROLLING[model.rolling],
        tangential_reduce="tangential_reduce" in model.on,
        curvature=model.curvature,
        curvature_limit=model.curvature_limit,
    )


def _cohesion(setup: Setup, model: Model) -> dict[str, Floats]:
    if model.cohesion == "off":
        return {}
    properties = Properties(setup, f"cohesion {model.cohesion}", model.place)
    return {"cohesion_energy_density": properties.pairs("cohesionEnergyDensity", 0.0)}


def _rolling(setup: Setup, model: Model) -> dict[str, Floats]:
    if model.rolling == "off":
        return {}
    properties = Properties(setup, f"rolling_friction {model.rolling}", model.place)
    tables = {"rolling_friction": properties.pairs("coefficientRollingFriction", 0.0)}
    tables["torsion"] = np.full_like(tables["rolling_friction"], "torsionTorque" in model.on)
    if model.rolling == "epsd":
        tables["rolling_damping_ratio"] = properties.pairs("coefficientRollingViscousDamping", 0.0)
    return tables


def _hooke(properties: Properties, on: frozenset[str]) -> Parts:
    shape = (properties.ntypes, properties.ntypes)
    tables = {
        "yeff": properties.effective_young(),
        "characteristic_velocity": np.full(shape, properties.characteristic_velocity()),
        "stiffness_ratio": np.full(shape, TWO_SEVENTHS if "ktToKnUser" in on else 1.0),
        "xt": np.ones(shape),
    }
    if "viscous" in on:
        tables["log_restitution"] = np.log(properties.pairs("MaximumRestitution", 0.0, 1.0, above=True))
        tables["critical_stokes"] = properties.pairs("CriticalStokes", 0.0, inf, above=True)
        tables["fluid_viscosity"] = properties.pairs("FluidViscosity", 0.0, inf, above=True)
        return Parts("impact_hooke", "stokes", "ratio", "scaled", tables)
    tables["damping_fraction"] = 2.0 * _loss(properties)
    return Parts("impact_hooke", "fraction", "ratio", "scaled", tables)


def _hertz(properties: Properties, on: frozenset[str]) -> Parts:
    loss = _loss(properties)
    tables = {
        "kn": 4.0 / 3.0 * properties.effective_young(),
        "shear_stiffness": 8.0 * properties.effective_shear(),
        "damping_fraction": sqrt(5.0) * loss,
        "tangential_fraction": 2.0 * sqrt(5.0 / 6.0) * loss,
    }
    return Parts("hertz", "fraction", "mindlin", "fraction", tables)


def _loss(properties: Properties) -> Floats:
    """-L/sqrt(L^2 + pi^2), L = ln(coefficientRestitution): 0 for an elastic contact."""
    logs = np.log(properties.pairs("coefficientRestitution", 0.05, 1.0, above=True))
    return np.abs(logs) / np.sqrt(logs**2 + pi**2)


def _hooke_stiffness(properties: Properties, on: frozenset[str]) -> Parts:
    if "absolute_damping" not in on:
        return Parts("hooke", "mass_velocity", "constant", "mass", _springs(properties, ""))
    return Parts("hooke", "velocity", "constant", "absolute", _springs(properties, "_abs"))


def _hertz_stiffness(properties: Properties, on: frozenset[str]) -> Parts:
    return Parts("hertz", "viscoelastic", "mindlin", "mass_radius", _springs(properties, ""))


def _springs(properties: Properties, suffix: str) -> dict[str, Floats]:
    names = {"kn": "kn", "shear_stiffness": "kt", "gamman": f"gamman{suffix}", "gammat": f"gammat{suffix}"}
    return {name: properties.pairs(given, 0.0) for name, given in names.items()}


PARTS: dict[str, Callable[[Properties, frozenset[str]], Parts]] = {
    "hooke": _hooke,
    "hertz": _hertz,
    "hooke/stiffness": _hooke_stiffness,
    "hertz/stiffness": _hertz_stiffness,
}


def _wall(setup: Setup, fix: Spec) -> Wall:
    """`model ... primitive type N SHAPE ... [shear DIM V] [switches]`."""
    words = Words(fix.args, f"fix {fix.id} wall/gran", fix.place)
    model = _model(words)
    if words.peek() == "mesh":
        raise words.error("mesh walls are not supported yet; supported: primitive")
    if not words.skip("primitive") or not words.skip("type"):
        raise words.error(f"needs primitive type N {' | '.join((*PLANES, *CYLINDERS))} behind the model, got {words.peek()!r}")
    wall_type = words.integer("wall type", 1, setup.ntypes)
    shape = _shape(words)
    if isinstance(shape, Cylinder) and setup.atom_style == "superquadric":
        raise words.error("a cylinder is no wall for superquadrics yet: use planes")
    velocity = (0.0, 0.0, 0.0)
    if isinstance(shape, Cylinder):
        shape, velocity = _moving_cylinder(words, shape)
    while words.skip("shear"):  # of several the last counts
        axis, speed = shear(words)
        velocity = _along(axis, speed)
    model = _switches(words, model)
    _check_surface(setup, words, model)
    law = _law(setup, model)
    column = {name: np.ascontiguousarray(table[:, wall_type - 1]) for name, table in law.coefficients.items()}
    return Wall(fix.id, shape, replace(law, coefficients=column), group_bit(setup, fix), velocity, touch_closed=True)


def _moving_cylinder(words: Words, shape: Cylinder) -> tuple[Cylinder, tuple[float, float, float]]:
    """`shear DIM V`: velocity V along the axis; any other DIM turns the cylinder with V, radian per time, right-handed about its axis, the velocity
    taken at the centre of the sphere; rolling friction does not know of it (all measured)."""
    if not words.skip("shear"):
        return shape, _along(shape.axis, 0.0)
    axis, speed = shear(words)
    if words.peek() == "shear":
        raise words.error("a cylinder takes one shear: of several LIGGGHTS keeps one")
    if axis == shape.axis:
        return shape, _along(axis, speed)
    if shape.axis == 1:
        raise words.error("a ycylinder is not turned by shear, but strained (liggghts-ycylinder-shear); supported: xcylinder, zcylinder")
    return replace(shape, rotation=Rotation(speed, "center", rolls=False)), _along(shape.axis, 0.0)


def _along(axis: int, speed: float) -> tuple[float, float, float]:
    return tuple(speed if k == axis else 0.0 for k in range(3))  # type: ignore[return-value]


def _shape(words: Words) -> Slab | Cylinder:
    """Plane position, or cylinder radius and centre; the centre comes in cyclic order (ycylinder: z x)."""
    word = words.choice("primitive", (*PLANES, *CYLINDERS))
    axis = AXES.index(word[0])
    if word in PLANES:
        return Slab(axis, lo=words.number("position"))
    radius = words.positive("radius")
    center = [words.number(f"{AXES[(axis + k) % 3]} of the centre") for k in (1, 2)]
    return Cylinder(axis, (center[0], center[1]), radius, "flat")

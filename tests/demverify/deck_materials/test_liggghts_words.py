"""The words of LIGGGHTS contact models and properties: what they become, and the one-line errors of those that are wrong."""

from __future__ import annotations

from math import inf, log, pi, sqrt

import numpy as np
import pytest

from demsolver.scene import ContactLaw, Cylinder, Rotation, Slab
from demverify.deck import materials_liggghts
from demverify.deck.setup import Setup
from demverify.errors import InputError
from tests.support.contact_cases import setup_of

ROLLING = {
    "coefficientRollingFriction": "peratomtypepair 2 0.1 0.2 0.2 0.3",
    "coefficientRollingViscousDamping": "peratomtypepair 2 0.4 0.5 0.5 0.6",
    "cohesionEnergyDensity": "peratomtypepair 2 1e5 2e5 2e5 3e5",
}
MATERIAL = {
    "youngsModulus": "peratomtype 5e6 1.2e7",
    "poissonsRatio": "peratomtype 0.3 0.22",
    "coefficientRestitution": "peratomtypepair 2 0.6 0.5 0.5 0.8",
    "coefficientFriction": "peratomtypepair 2 0.5 0.3 0.3 0.2",
    "characteristicVelocity": "scalar 0.5",
}
HERTZ = "model hertz tangential history"


def lines(style: str = HERTZ, /, **changed: str | None) -> list[str]:
    """A pair style behind the properties; changed: other words, or None to leave a property out."""
    values = {name: words for name, words in (MATERIAL | changed).items() if words is not None}
    fixes = [f"fix m{k} all property/global {name} {words}" for k, (name, words) in enumerate(values.items())]
    return [f"pair_style gran {style}", "pair_coeff * *", *fixes]


def law(style: str = HERTZ, /, **changed: str | None) -> ContactLaw:
    """The pair law of `lines`."""
    found = materials_liggghts.pair_law(setup_of(lines(style, **changed), "liggghts"))
    assert found is not None
    return found


def test_no_pair_style_is_no_law() -> None:
    """Without a pair style particles do not see each other, and properties are not asked for."""
    assert materials_liggghts.pair_law(Setup("liggghts")) is None
    assert materials_liggghts.walls(Setup("liggghts")) == ()


def test_hertz_constants() -> None:
    """kn = 4/3 Y*, kt = 8 G*, compliances in series; between likes Y* = Y/(2(1 - nu^2)), G* = Y/(4(2 - nu)(1 + nu))."""
    found = law().coefficients
    assert found["kn"][0, 0] == pytest.approx(4 / 3 * 5e6 / (2 * (1 - 0.09)), rel=1e-14)
    assert found["shear_stiffness"][1, 1] == pytest.approx(8 * 1.2e7 / (4 * 1.78 * 1.22), rel=1e-14)
    assert 1 / found["kn"][0, 1] == pytest.approx((1 / found["kn"][0, 0] + 1 / found["kn"][1, 1]) / 2, rel=1e-14)
    assert found["damping_fraction"][0, 1] == pytest.approx(-sqrt(5) * log(0.5) / sqrt(pi**2 + log(0.5) ** 2), rel=1e-14)


def test_defaults() -> None:
    """Left out: tangential off, tangential_damping on, limitForce off."""
    plain, rubbing = law("model hertz"), law()
    assert (plain.friction, plain.tangential_stiffness, plain.limit_damping) == ("none", "none", False)
    assert "mu" not in plain.coefficients
    assert rubbing.tangential_damping == "fraction"
    assert law(f"{HERTZ} tangential_damping off limitForce on").tangential_damping == "none"
    assert law(f"{HERTZ} tangential_damping off limitForce on").limit_damping
    assert (rubbing.surface_arm, rubbing.torque_arm) == ("contact", "contact")


@pytest.mark.parametrize(
    ("words", "names", "own"),
    [
        ("rolling_friction cdt", ("none", "cdt"), {"rolling_friction", "torsion"}),
        ("rolling_friction epsd torsionTorque on", ("none", "epsd"), {"rolling_friction", "torsion", "rolling_damping_ratio"}),
        ("rolling_friction epsd2", ("none", "epsd2"), {"rolling_friction", "torsion"}),
        ("cohesion sjkr tangential_reduce on", ("sjkr", "none"), {"cohesion_energy_density"}),
        (
            "cohesion sjkr rolling_friction cdt surface default limitForce on", ("sjkr", "cdt"),
            {"rolling_friction", "torsion", "cohesion_energy_density"},
        ),
    ],
)
def test_rolling_friction_and_cohesion(words: str, names: tuple[str, str], own: set[str]) -> None:
    """Law: each model brings its law, the tables of its properties and its switch; torsionTorque and tangential_reduce are off by default."""
    found, plain = law(f"{HERTZ} {words}", **ROLLING), law()
    assert (found.cohesion, found.rolling, found.twisting) == (*names, "none")
    assert set(found.coefficients) - set(plain.coefficients) == own
    tables = {"rolling_friction": [0.1, 0.2, 0.3], "rolling_damping_ratio": [0.4, 0.5, 0.6], "cohesion_energy_density": [1e5, 2e5, 3e5]}
    tables["torsion"] = [float("torsionTorque on" in words)] * 3
    for name in own:
        assert found.coefficients[name][[0, 0, 1], [0, 1, 1]].tolist() == tables[name]
    assert found.tangential_reduce == ("tangential_reduce on" in words)
    assert (found.friction, found.limit_damping) == (plain.friction, "limitForce on" in words)


def test_properties_are_asked_for_by_the_model_that_needs_them() -> None:
    """Law: a property that no model of the deck uses may be missing; a missing one is named with its user."""
    needs = {
        "rolling_friction cdt": "coefficientRollingFriction",
        "rolling_friction epsd2": "coefficientRollingFriction",
        "rolling_friction epsd": "coefficientRollingViscousDamping",
        "cohesion sjkr": "cohesionEnergyDensity",
    }
    for words, name in needs.items():
        with pytest.raises(InputError, match=rf"^in.case:1: {words} needs the property {name} \(fix ID all property/global {name} peratomtypepair"):
            law(f"{HERTZ} {words}", **(ROLLING | {name: None}))
    assert law(f"{HERTZ} rolling_friction cdt", coefficientRollingFriction=ROLLING["coefficientRollingFriction"]).rolling == "cdt"


@pytest.mark.parametrize("name", ROLLING)
def test_properties_are_not_negative(name: str) -> None:
    """Law: a negative one would drive what it is to brake, or push where it is to pull; the line says which value and what is allowed."""
    wrong = ROLLING | {name: "peratomtypepair 2 1 1 1 -2"}
    with pytest.raises(InputError, match=f"property/global {name} must be >= 0, got -2$"):
        law(f"{HERTZ} cohesion sjkr rolling_friction epsd", **wrong)


def test_epsd2_has_its_spring_without_friction() -> None:
    """Law: epsd2 takes kt, so the stiffness is there although tangential is off; the other models do without."""
    assert law("model hertz rolling_friction epsd2", **ROLLING).tangential_stiffness == "mindlin"
    assert law("model hertz rolling_friction epsd", **ROLLING).tangential_stiffness == "none"


def test_last_switch_wins_and_off_parts_are_accepted() -> None:
    """A switch may be repeated; cohesion off, rolling_friction off and surface default say what is so anyway."""
    assert not law(f"{HERTZ} limitForce on limitForce off").limit_damping
    assert law(f"{HERTZ} cohesion off rolling_friction off surface default").friction == "liggghts_history"


def test_elastic_contacts_do_not_damp() -> None:
    """e = 1 gives no damping at all."""
    assert not law(coefficientRestitution="peratomtypepair 2 1 1 1 1").coefficients["damping_fraction"].any()


def test_hooke_needs_no_restitution_when_viscous() -> None:
    """viscous on asks for FluidViscosity, CriticalStokes and MaximumRestitution instead of coefficientRestitution."""
    wet = {
        "FluidViscosity": "peratomtypepair 2 1e-3 1e-3 1e-3 1e-3",
        "CriticalStokes": "peratomtypepair 2 10 10 10 10",
        "MaximumRestitution": "peratomtypepair 2 0.9 0.9 0.9 0.9",
    }
    found = law("model hooke viscous on", coefficientRestitution=None, **wet)
    assert found.damping == "stokes"
    assert found.coefficients["log_restitution"] == pytest.approx(np.full((2, 2), log(0.9)))


def test_soft_and_hard_particles_lift_the_bounds() -> None:
    """5e6 <= youngsModulus <= 1e9 in SI units, unless soft_particles or hard_particles says yes."""
    for young, switch in (("1e5 1e5", "soft_particles"), ("1e10 1e10", "hard_particles")):
        deck = lines(youngsModulus=f"peratomtype {young}")
        assert materials_liggghts.pair_law(setup_of([*deck, f"{switch} yes"], "liggghts")) is not None
        with pytest.raises(InputError, match=f"{switch} yes lifts this bound"):
            materials_liggghts.pair_law(setup_of([*deck, f"{switch} no"], "liggghts"))


def test_bounds_depend_on_the_units() -> None:
    """cgs: 5e7 to 1e10; lj: no bounds, and no least characteristic velocity."""
    setup = setup_of(lines("model hooke", characteristicVelocity="scalar 1e-3"), "liggghts")
    setup.units = "lj"
    assert materials_liggghts.pair_law(setup) is not None
    setup.units = "cgs"
    with pytest.raises(InputError, match=r"youngsModulus must be >= 5e\+07"):
        materials_liggghts.pair_law(setup)


def test_walls() -> None:
    """One plane; cylinders of any axis, centre in cyclic order, no curvature; contact at zero gap; material of the type."""
    deck = [
        *lines(**ROLLING),
        f"fix a all wall/gran {HERTZ} primitive type 2 xplane 0.5 shear y 0.3 limitForce on",
        f"fix b all wall/gran {HERTZ} cohesion sjkr rolling_friction cdt primitive type 1 ycylinder 5 1 2 torsionTorque on tangential_reduce on",
        f"fix c all wall/gran {HERTZ} primitive type 1 xcylinder 5 1 2 shear z -3 limitForce on",
        f"fix d all wall/gran {HERTZ} primitive type 1 ycylinder 5 1 2 shear y -3",
    ]
    plane, cylinder, turning, sliding = materials_liggghts.walls(setup_of(deck, "liggghts"))
    assert plane.shape == Slab(0, 0.5, inf)
    assert (plane.velocity, plane.touch_closed, plane.law.limit_damping) == ((0.0, 0.3, 0.0), True, True)
    assert cylinder.shape == sliding.shape == Cylinder(1, (1.0, 2.0), 5.0, "flat")
    assert turning.shape == Cylinder(0, (1.0, 2.0), 5.0, "flat", rotation=Rotation(-3.0, "center", rolls=False))
    assert (turning.velocity, sliding.velocity) == ((0.0, 0.0, 0.0), (0.0, -3.0, 0.0))
    assert plane.law.coefficients["mu"].tolist() == [0.3, 0.2]
    assert cylinder.law.coefficients["mu"].tolist() == [0.5, 0.3]
    assert (plane.law.rolling, plane.law.cohesion) == ("none", "none")
    assert (cylinder.law.rolling, cylinder.law.cohesion, cylinder.law.tangential_reduce) == ("cdt", "sjkr", True)
    assert cylinder.law.coefficients["rolling_friction"].tolist() == [0.1, 0.2]
    assert cylinder.law.coefficients["torsion"].tolist() == [1.0, 1.0]


WRONG_STYLES = {
    "hertz": r"^in.case:1: pair_style gran must begin with model hooke \|",
    "model hurtz": r"^in.case:1: pair_style gran model 'hurtz' is not one of hooke, hertz, hooke/stiffness, hertz/stiffness$",
    "model hertz tangential sticky": "tangential model 'sticky' is not one of off, no_history, history",
    "model hertz rolling_friction epsd3": r"rolling_friction epsd3 is not supported yet; supported: rolling_friction off \| cdt \| epsd \| epsd2$",
    "model hertz cohesion sjkr2": r"cohesion sjkr2 is not supported yet; supported: cohesion off \| sjkr$",
    "model hertz surface superquadric": "surface superquadric does not go with atom_style sphere",
    "model hertz rolling_friction cdt cohesion sjkr": "has cohesion too late; the order is model, tangential, cohesion, rolling_friction",
    "model hertz cohesion sjkr tangential history": "has tangential too late",
    "model hertz torsionTorque on rolling_friction cdt": "has torsionTorque without a rolling_friction model, whose switch it is",
    "model hertz rolling_friction cdt tangential_reduce on": "has tangential_reduce without a cohesion model, whose switch it is",
    "model hertz rolling_friction off torsionTorque off": "has torsionTorque without a rolling_friction model",
    "model hertz rolling_friction cdt torsionTorque 1": "switch torsionTorque '1' is not one of on, off",
    "model hertz rolling_friction cdt torsion on": "switch of model hertz 'torsion' is not one of tangential_damping, limitForce, torsionTorque$",
    "model hertz cohesion sjkr rolling_friction": "ends where rolling_friction model was expected",
    "model hertz rolling_friction off tangential history": "has tangential too late; the order is model, tangential, cohesion",
    "model hertz limitForce on tangential history": "has tangential too late",
    "model hertz viscous on": "switch of model hertz 'viscous' is not one of tangential_damping, limitForce$",
    "model hertz limitForce yes": "switch limitForce 'yes' is not one of on, off",
    "model hertz limitForce": "ends where switch limitForce was expected",
    "model hertz tangential": "ends where tangential model was expected",
}


@pytest.mark.parametrize("style", WRONG_STYLES)
def test_wrong_models(style: str) -> None:
    """One line with the place, what is wrong, and what was expected."""
    with pytest.raises(InputError, match=WRONG_STYLES[style]) as caught:
        law(style)
    assert "\n" not in str(caught.value)


WRONG_PROPERTIES = {
    (
        "youngsModulus",
        None,
    ): r"^in.case:1: model hertz needs the property youngsModulus \(fix ID all property/global youngsModulus peratomtype",
    ("coefficientFriction", None): "model hertz needs the property coefficientFriction .*given: youngsModulus, poissonsRatio",
    ("youngsModulus", "peratomtype 5e6"): r"^in.case:3: fix m0 property/global youngsModulus must have 2 values, got 1$",
    ("youngsModulus", "scalar 5e6"): "must be peratomtype for model hertz, got scalar",
    ("youngsModulus", "pertype 5e6 5e6"): "kind 'pertype' is not one of scalar, vector, peratomtype",
    ("youngsModulus", "peratomtype 5e6 stiff"): "value must be a number, got 'stiff'",
    ("youngsModulus", "peratomtype 5e6 0"): "must be >= 5e.06 and <= 1e.09, got 0",
    ("poissonsRatio", "peratomtype 0.3 0.6"): "must be >= 0 and <= 0.5, got 0.6",
    ("coefficientRestitution", "peratomtypepair 2 0.6 0.5 0.5 0.05"): "must be > 0.05 and <= 1, got 0.05",
    ("coefficientRestitution", "peratomtypepair 2 0.6 0.5 0.4 0.8"): "must be symmetric: 1 2 has 0.5, 2 1 has 0.4",
    ("coefficientRestitution", "peratomtypepair 2 0.6 0.5 0.5"): "must have 4 values, got 3",
    ("coefficientRestitution", "peratomtypepair 1 0.6"): "must have 2 columns, one a type",
    ("coefficientRestitution", "peratomtypepair two 0.6"): "number of columns must be a whole number, got 'two'",
    ("coefficientFriction", "peratomtypepair 2 0.5 -0.3 -0.3 0.2"): "must be >= 0, got -0.3",
}


@pytest.mark.parametrize(("name", "words"), WRONG_PROPERTIES)
def test_wrong_properties(name: str, words: str | None) -> None:
    """A missing property is named with the model that needs it; a wrong one with its own line."""
    with pytest.raises(InputError, match=WRONG_PROPERTIES[name, words]) as caught:
        law(**{name: words})
    assert "\n" not in str(caught.value)


def test_slow_characteristic_velocity() -> None:
    """characteristicVelocity is at least 1e-2 in SI units, and asked for by model hooke alone."""
    with pytest.raises(InputError, match=r"characteristicVelocity must be >= 0.01, got 0.001"):
        law("model hooke", characteristicVelocity="scalar 1e-3")
    assert law("model hertz", characteristicVelocity=None).normal == "hertz"


def test_a_property_is_set_once() -> None:
    """Two fixes for one property are an error naming both."""
    with pytest.raises(InputError, match="fix again property/global: youngsModulus is already set by fix m0"):
        setup = setup_of([*lines(), "fix again all property/global youngsModulus peratomtype 5e6 5e6"], "liggghts")
        materials_liggghts.pair_law(setup)


def test_pair_coeff_is_needed() -> None:
    """LIGGGHTS wants pair_coeff * *, without numbers."""
    deck = lines()
    with pytest.raises(InputError, match=r"^in.case:1: pair_style gran needs the line: pair_coeff \* \*"):
        materials_liggghts.pair_law(setup_of([deck[0], *deck[2:]], "liggghts"))
    with pytest.raises(InputError, match=r"^in.case:2: pair_coeff does not know '1'"):
        materials_liggghts.pair_law(setup_of([deck[0], "pair_coeff * * 1", *deck[2:]], "liggghts"))


WRONG_WALLS = {
    "primitive type 3 zplane 0": "wall type must be from 1 to 2, got 3",
    "primitive zplane 0": "needs primitive type N xplane",
    "zplane 0": "needs primitive type N xplane .* got 'zplane'",
    "mesh n_meshes 1 meshes cad": "mesh walls are not supported yet; supported: primitive",
    "primitive type 1 general_plane 0 0 1": "primitive 'general_plane' is not one of xplane, yplane, zplane, xcylinder",
    "primitive type 1 zplane": "ends where position was expected",
    "primitive type 1 ycylinder 1 2": "ends where x of the centre was expected",
    "primitive type 1 zcylinder 0 0 0": "radius must be positive",
    "primitive type 1 zcylinder 1 0 0 shear x 3 shear z 1": "a cylinder takes one shear: of several LIGGGHTS keeps one",
    "primitive type 1 ycylinder 1 0 0 shear z 3": "a ycylinder is not turned by shear, but strained",
    "primitive type 1 zcylinder 1 0 0 shear x fast": "shear velocity must be a number, got 'fast'",
    "primitive type 1 zplane 0 limitForce": "ends where switch limitForce was expected",
    "primitive type 1 zplane 0 limitForce on shear x 1": "switch of model hertz 'shear' is not one of",
}


@pytest.mark.parametrize("words", WRONG_WALLS)
def test_wrong_walls(words: str) -> None:
    """One line with the place, what is wrong, and what was expected."""
    with pytest.raises(InputError, match=WRONG_WALLS[words]) as caught:
        materials_liggghts.walls(setup_of([*lines(), f"fix w all wall/gran {HERTZ} {words}"], "liggghts"))
    assert str(caught.value).startswith("in.case:8: fix w wall/gran ")
    assert "\n" not in str(caught.value)

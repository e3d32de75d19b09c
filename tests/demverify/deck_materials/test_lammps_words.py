"""The words of LAMMPS contact styles: what they become, and the one-line errors of those that are wrong."""

from __future__ import annotations

from math import inf, log, pi, sqrt

import numpy as np
import pytest

from demsolver.scene import ContactLaw, Cylinder, Slab
from demverify.deck import materials_lammps
from demverify.deck.setup import Setup
from demverify.errors import InputError
from tests.support.contact_cases import setup_of

HERTZ = "hertz 2e6 5e5 tangential linear_history 5e5 0.7 0.5"
CLASSIC = ("pair_style gran/hooke/history 2e5 NULL 50 NULL 0.5 1", "pair_coeff * *")


def law(*lines: str) -> ContactLaw:
    """The pair law of these lines."""
    found = materials_lammps.pair_law(setup_of(lines, "lammps"))
    assert found is not None
    return found


def test_no_pair_style_is_no_law() -> None:
    """Without a pair style, or with `none`, particles do not see each other."""
    assert materials_lammps.pair_law(Setup("lammps")) is None
    assert materials_lammps.pair_law(setup_of(["pair_style none"], "lammps")) is None
    assert materials_lammps.walls(Setup("lammps")) == ()


def test_classic_defaults() -> None:
    """NULL stands for kt = 2/7 kn and gamma_t = gamma_n/2; dampflag 0 for gamma_t = 0."""
    found = law(*CLASSIC)
    assert found.coefficients["shear_stiffness"] == pytest.approx(np.full((2, 2), 2e5 * 2 / 7))
    assert (found.coefficients["gammat"] == 25.0).all()
    assert not found.limit_damping
    undamped = law("pair_style gran/hertz/history 2e5 1e5 50 20 0.5 0 limit_damping", "pair_coeff * *")
    assert not undamped.coefficients["gammat"].any()
    assert undamped.limit_damping
    assert undamped.normal == "hertz"


def test_arms() -> None:
    """The lever is R everywhere, but R - overlap/2 in the torque of pair granular."""
    granular = law("pair_style granular", f"pair_coeff * * {HERTZ}")
    wall = materials_lammps.walls(setup_of([f"fix w all wall/gran granular {HERTZ} zplane 0 NULL"], "lammps"))[0].law
    arms = [(a.surface_arm, a.torque_arm) for a in (law(*CLASSIC), granular, wall)]
    assert arms == [("radius", "radius"), ("radius", "contact"), ("radius", "radius")]


def test_geometric_mixing() -> None:
    """Pairs without numbers of their own get geometric means, friction and damping too."""
    other = "hertz 8e6 2e6 tangential linear_history 2e6 0.7 0.02"
    found = law("pair_style granular", f"pair_coeff 1 1 {HERTZ}", f"pair_coeff 2 2 {other}").coefficients
    mixed = {name: table[0, 1] for name, table in found.items()}
    assert mixed == pytest.approx({"kn": 4e6, "gamman": 1e6, "shear_stiffness": 1e6, "xt": 0.7, "mu": 0.1})
    assert all((table == table.T).all() for table in found.values())


def test_material_constants() -> None:
    """kn = 4/3 E*, for walls too; kt NULL is 8 G*. E = 1e7, nu = 0.3: E* = 1e7/1.82, G* = 1e7/8.84."""
    model = "hertz/material 1e7 0.5 0.3 damping coeff_restitution tangential mindlin NULL 1.0 0.5"
    pair = law("pair_style granular", f"pair_coeff * * {model}")
    wall = materials_lammps.walls(setup_of([f"fix w all wall/gran granular {model} zplane 0 NULL"], "lammps"))[0].law
    for found in (pair, wall):
        assert found.coefficients["kn"] == pytest.approx(4 / 3 * 1e7 / 1.82, rel=1e-14)
        assert found.coefficients["shear_stiffness"] == pytest.approx(8e7 / 8.84, rel=1e-14)
        assert found.coefficients["damping_fraction"] == pytest.approx(-sqrt(5) * log(0.5) / sqrt(pi**2 + log(0.5) ** 2))
    assert wall.coefficients["kn"].shape == (2,)


def test_tsuji_misses_its_restitution() -> None:
    """damping tsuji, nominal e = 0.5, acts as exp(-pi b/sqrt(1 - b^2)) = 0.616, b = fraction/sqrt(5) (measured)."""
    found = law("pair_style granular", "pair_coeff * * hertz 1e6 0.5 damping tsuji tangential linear_history 1 1 1")
    b = found.coefficients["damping_fraction"][0, 0] / sqrt(5)
    assert np.exp(-pi * b / sqrt(1 - b * b)) == pytest.approx(0.616, abs=5e-4)


def test_walls() -> None:
    """Planes lo to hi, NULL for none; cylinders about the z axis with curvature; `shear` is a velocity; the group's bit."""
    style = "wall/gran hooke 1e4 NULL 500 NULL 0.5 1"
    setup = setup_of([f"fix a all {style} yplane NULL 2.0 shear z 0.3", f"fix b bed {style} zcylinder 5 contacts"], "lammps")
    setup.groups["bed"] = 3
    plane, cylinder = materials_lammps.walls(setup)
    assert plane.shape == Slab(1, -inf, 2.0)
    assert (plane.velocity, plane.bit, plane.touch_closed) == ((0.0, 0.0, 0.3), 0, False)
    assert cylinder.shape == Cylinder(2, (0.0, 0.0), 5.0, "curved")
    assert (cylinder.name, cylinder.bit) == ("b", 3)


WRONG_PAIRS = {
    "pair_style gran/hurtz 1 1": r"^in.case:1: pair_style style 'gran/hurtz' is not one of gran/hooke, .*granular$",
    "pair_style gran/hooke 1e5 NULL 50": r"^in.case:1: pair_style gran/hooke ends where gamma_t was expected$",
    "pair_style gran/hooke 1e5 NULL fifty NULL 0.5 1": "gamma_n must be a number, got 'fifty'",
    "pair_style gran/hooke nan NULL 50 NULL 0.5 1": "kn must be a number, got 'nan'",
    "pair_style gran/hooke -1 NULL 50 NULL 0.5 1": "kn must be at least 0, got -1",
    "pair_style gran/hooke 1e5 NULL 50 NULL 0.5 2": "dampflag must be from 0 to 1, got 2",
    "pair_style gran/hooke 1e5 NULL 50 NULL 0.5 1.5": "dampflag must be a whole number, got '1.5'",
    "pair_style gran/hooke 1e5 NULL 50 NULL 20000 1": "mu must be from 0 to 10000, got 20000",
    "pair_style gran/hooke 1e5 NULL 50 NULL 0.5 1 quick": "does not know 'quick' at this point",
    "pair_style granular 0.1": "cutoff",
    "pair_style gran/hooke 1e5 NULL 50 NULL 0.5 1": "no pair_coeff for type 1; give pair_coeff 1 1, or",
}
WRONG_COEFFS = {
    "3 3": "type 3 is outside 1 to 2",
    "1 b": "type 'b' is neither a number nor a range",
    "1": "ends where type was expected",
    "* * hurtz 1 1": r"^in.case:2: pair_coeff normal model 'hurtz' is not one of .*hertz, hooke, .*hertz/material$",
    "* * hertz 1e6": "ends where damping coefficient was expected",
    "* * hertz 1e6 0.5": r"needs a tangential model: tangential linear_nohistory \| linear_history \| mindlin \| mindlin/force",
    "* * hertz 1e6 0.5 damping sloppy": "damping model 'sloppy' is not one of .*viscoelastic.*tsuji",
    "* * hertz 1e6 0.5 tangential mindlin NULL 1 0.5": "kt NULL needs a normal model with material constants: dmt, jkr, hertz/material",
    "* * hertz 1e6 0.5 tangential linear_history NULL 1 0.5": "kt must be a number, got 'NULL'",
    f"* * {HERTZ} cutoff 0.1": "cutoff is not supported yet",
    f"* * {HERTZ} heat area 0.1": "keyword 'heat' is not one of damping, tangential, rolling, twisting, limit_damping, cutoff",
    "* * hertz 1e6 1.5 damping coeff_restitution tangential linear_history 1 1 0.5": "restitution of damping coeff_restitution",
    "* * hertz 1e6 0 damping coeff_restitution tangential linear_history 1 1 0.5": "got 0",
    "* * hertz/material 0 0.5 0.3 tangential mindlin NULL 1 0.5": "Young's modulus must be positive",
    "* * hertz/material 1e7 0.5 1.0 tangential mindlin NULL 1 0.5": "Poisson's ratio must be",
    f"1 1 {HERTZ}": "no pair_coeff for type 2",
}


@pytest.mark.parametrize("line", WRONG_PAIRS)
def test_wrong_pair_styles(line: str) -> None:
    """One line with the place, what is wrong, and what was expected."""
    with pytest.raises(InputError, match=WRONG_PAIRS[line]) as caught:
        law(line)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("words", WRONG_COEFFS)
def test_wrong_pair_coeffs(words: str) -> None:
    """The same for the coefficients of pair granular."""
    with pytest.raises(InputError, match=WRONG_COEFFS[words]) as caught:
        law("pair_style granular", f"pair_coeff {words}")
    assert "\n" not in str(caught.value)


def test_classic_pair_coeff_takes_no_numbers() -> None:
    """pair_coeff * * 3 is wrong behind gran/*."""
    with pytest.raises(InputError, match=r"^in.case:2: pair_coeff does not know '3'"):
        law(CLASSIC[0], "pair_coeff * * 3")


def test_different_forms() -> None:
    """Models of different form cannot be mixed, and not yet be used side by side."""
    other = HERTZ.replace("hertz", "hooke")
    both = ["pair_style granular", f"pair_coeff 1 1 {HERTZ}", f"pair_coeff 2 2 {other}"]
    with pytest.raises(InputError, match=r"pair_coeff 1 2 is missing and cannot be mixed: hertz viscoelastic .* is not hooke"):
        law(*both)
    with pytest.raises(InputError, match=r"pair_coeff 2 2 has other models than pair_coeff 1 1.*not supported yet"):
        law(*both, f"pair_coeff 1 2 {HERTZ}")
    with pytest.raises(InputError, match="pair_coeff 1 2 has other models"):
        law("pair_style granular", f"pair_coeff 1 1 {HERTZ}", f"pair_coeff 2 2 {HERTZ} limit_damping")


WALL = "fix w all wall/gran hooke 1e4 NULL 500 NULL 0.5 1"
WRONG_WALLS = {
    "fix w all wall/gran hurtz 1": r"^in.case:1: fix w wall/gran style 'hurtz' is not one of granular, hooke, .*hertz/history$",
    f"{WALL}": "ends where wall was expected",
    f"{WALL} wplane 0 NULL": "wall 'wplane' is not one of xplane, yplane, zplane, zcylinder, region",
    f"{WALL} region box": "takes a region as fix wall/gran/region alone",
    f"{WALL} zplane 0": "ends where upper plane was expected",
    f"{WALL} zplane 0 NULL shear z 1": "cannot shear along z, the wall's own normal",
    f"{WALL} zplane 0 NULL wiggle z 1 1": "wiggle is not supported yet; supported: shear",
    f"{WALL} zplane 0 NULL spin 1": "option 'spin' is not one of shear, contacts, wiggle",
    f"{WALL} zcylinder -1": "radius must be positive, got -1",
    f"{WALL} zcylinder 1 shear x 1": "shear x should turn the cylinder, but in LAMMPS leaves its surface at rest in places",
    WALL.replace(" all ", " bed ") + " zplane 0 NULL": "fix w: group 'bed' is not one of all",
    f"fix w all wall/gran granular {HERTZ}": "ends where wall was expected",
}


@pytest.mark.parametrize("line", WRONG_WALLS)
def test_wrong_walls(line: str) -> None:
    """One line with the place, what is wrong, and what was expected."""
    with pytest.raises(InputError, match=WRONG_WALLS[line]) as caught:
        materials_lammps.walls(setup_of([line], "lammps"))
    assert "\n" not in str(caught.value)


def test_walls_need_a_direction_that_ends() -> None:
    """A plane across a periodic direction is refused, as LAMMPS does."""
    setup = setup_of([f"{WALL} zplane 0 NULL"], "lammps")
    setup.boundary = ("ff", "ff", "pp")
    with pytest.raises(InputError, match="zplane cannot stand in the periodic direction z"):
        materials_lammps.walls(setup)

"""From columns to energies: every way a dump can say it, and what it must say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demverify.analysis.energies import Row, Wanted, energies_of
from demverify.analysis.meanings import Meanings
from demverify.analysis.quantities import ANY_TYPE
from demverify.errors import InputError
from demverify.frames import Floats, Frame

R, M, W = 0.01, 0.02, 30.0
ENERGY = 0.5 * 0.4 * M * R**2 * W**2
RHO = M / (4.0 / 3.0 * np.pi * R**3)
SPHERE: dict[str, float] = {"id": 1, "radius": R, "mass": M, "omegax": 0.0, "omegay": W, "omegaz": 0.0, "vx": 0.0, "vy": 3.0, "vz": 4.0}
ELLIPSOID: dict[str, float] = {
    "id": 1, "mass": M, "shapex": 0.03, "shapey": 0.02, "shapez": 0.01, "quat1": 1.0, "quat2": 0.0, "quat3": 0.0, "quat4": 0.0,
    "omegax": W, "omegay": 0.0, "omegaz": 0.0,
}  # fmt: skip


def frame(*rows: dict[str, float], step: int = 100, **changes: object) -> Frame:
    """A frame with these rows; changes: other fields of Frame."""
    columns: dict[str, Floats] = {name: np.array([row[name] for row in rows], dtype=float) for name in rows[0]}
    return replace(Frame(step, np.array([[0.0, 1.0]] * 3), ("pp", "pp", "pp"), columns), **changes)  # type: ignore[arg-type]


def row(shown: Frame, meanings: Meanings | None = None, **wanted: object) -> Row:
    """The row of a frame."""
    return energies_of(shown, Wanted(meanings or Meanings(), **wanted)).row  # type: ignore[arg-type]


def without(what: dict[str, float], *names: str, **more: float) -> dict[str, float]:
    """A particle with columns taken away and others added."""
    return {name: value for name, value in what.items() if name not in names} | more


@pytest.mark.parametrize(
    ("particle", "meanings"),
    [
        (SPHERE, Meanings()),
        (without(SPHERE, "radius", diameter=2 * R), Meanings()),
        (without(SPHERE, "mass", density=RHO), Meanings()),
        (without(SPHERE, "mass"), Meanings(density={ANY_TYPE: RHO})),
        (without(SPHERE, "mass"), Meanings(density={3: RHO})),
        (without(SPHERE, "mass", type=2), Meanings(density={1: 1.0, 2: RHO})),
        (without(SPHERE, "mass", type=2), Meanings(density={ANY_TYPE: RHO, 2: 1.0})),
    ],
)
def test_a_sphere_however_it_is_told(particle: dict[str, float], meanings: Meanings) -> None:
    """Law: E = 1/5 m R^2 omega^2 from radius or diameter, mass or density of the dump, the deck or an option; the dump wins, then the option."""
    got = row(frame(particle), meanings)
    assert got.erotate == pytest.approx(ENERGY, rel=1e-15)  # three roundings
    assert got.by_shape == {"sphere": got.erotate, "multisphere": 0.0, "superquadric": 0.0}
    assert got.ke == pytest.approx(0.5 * M * 25.0, rel=1e-15)


@pytest.mark.parametrize("name", ["radius", "mass", "omegax", "omegaz"])
def test_a_missing_column_is_named_with_what_would_replace_it(name: str) -> None:
    """Law: what cannot be told is an error that names step, column, what is there, and the option; c_ columns are pointed at."""
    expected = {"radius": "radius or diameter", "mass": r"mass or density \(or --density X, --deck DECK\)"}.get(name, "omegax omegay omegaz")
    with pytest.raises(InputError, match=rf"step 100: erotate/sphere needs the columns {expected}; the dump has id .*vx vy vz$"):
        row(frame(without(SPHERE, name)))
    with pytest.raises(InputError, match=r"what c_w\[1\] hold, --deck or --columns can say$"):
        row(frame(without(SPHERE, name) | {"c_w[1]": 0.0}))


def test_an_unknown_density_is_an_error() -> None:
    """Law: a type the deck says nothing of, or several types where the dump does not tell them, is an error, not a guess."""
    with pytest.raises(InputError, match=r"the density of type 3 \(known: 1 2\)"):
        row(frame(without(SPHERE, "mass", type=3)), Meanings(density={1: 1.0, 2: 2.0}))
    with pytest.raises(InputError, match="does not tell one density for all types, and the dump has no column type"):
        row(frame(without(SPHERE, "mass")), Meanings(density={1: 1.0, 2: 2.0}))
    doubtful = Meanings(density={1: 1.0}, unknown_density=("two values",))
    with pytest.raises(InputError, match=r"two values: give --density X"):
        row(frame(without(SPHERE, "mass", type=2)), doubtful)
    with pytest.raises(InputError, match="two values: give --density X"):
        row(frame(without(SPHERE, "mass", type=1)), Meanings(unknown_density=("two values",)))
    assert row(frame(without(SPHERE, type=2)), doubtful).erotate == pytest.approx(ENERGY, rel=1e-15)


def test_points_and_empty_frames_count_nothing() -> None:
    """Law: a particle without radius has no rotational energy, and a frame without particles needs no columns."""
    assert row(frame(SPHERE, SPHERE | {"radius": 0.0, "id": 2})).erotate == pytest.approx(ENERGY, rel=1e-15)
    empty = row(Frame(0, np.zeros((3, 2)), ("pp", "pp", "pp"), {"id": np.empty(0)}))
    assert (empty.n, empty.erotate, empty.ke) == (0, 0.0, 0.0)


def test_velocities_are_not_needed() -> None:
    """Law: without velocities ke is unknown, and the rotational energy is what it is."""
    got = row(frame(without(SPHERE, "vy")))
    assert got.ke is None
    assert got.erotate == pytest.approx(ENERGY, rel=1e-15)


@given(angle=st.floats(0.0, 6.3), axis=st.integers(0, 2))
def test_an_ellipsoid_by_omega_or_by_angmom(angle: float, axis: int) -> None:
    """Law: 1/2 w.I.w from quaternion and omega is 1/2 L.I^-1.L from quaternion and angmom; turning body and omega together changes nothing."""
    inertia = M / 5.0 * np.array([0.02**2 + 0.01**2, 0.03**2 + 0.01**2, 0.03**2 + 0.02**2])
    quat = np.zeros(4)
    quat[[0, 1 + axis]] = np.cos(angle / 2), np.sin(angle / 2)
    turn = np.roll([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]], (axis, axis), (0, 1))
    body = np.array([3.0, -5.0, 7.0])
    omega, angmom = turn @ body, turn @ (inertia * body)
    quats = {f"quat{i + 1}": quat[i] for i in range(4)}
    spin = dict(zip(("omegax", "omegay", "omegaz"), omega, strict=True))
    swing = dict(zip(("angmomx", "angmomy", "angmomz"), angmom, strict=True))
    energy = 0.5 * float(inertia @ body**2)
    bare = without(ELLIPSOID, "omegax", "omegay", "omegaz", **quats)
    for columns in (bare | spin, bare | swing, bare | swing | spin):
        assert row(frame(columns, dialect="liggghts")).by_shape["superquadric"] == pytest.approx(energy, rel=1e-13)  # rotation matrices
    lammps = bare | swing | {f"shape{a}": 2 * bare[f"shape{a}"] for a in "xyz"}
    assert row(frame(lammps, dialect="lammps")).erotate == pytest.approx(energy, rel=1e-13)


def test_who_wrote_shapex_matters() -> None:
    """Law: shapex is a semi-axis in LIGGGHTS and a diameter in LAMMPS; where that cannot be told it is asked, and omega of LAMMPS is not believed."""
    with pytest.raises(InputError, match="semi-axis in LIGGGHTS and a diameter in LAMMPS"):
        row(frame(ELLIPSOID))
    with pytest.raises(InputError, match="LAMMPS keeps no omega"):
        row(frame(ELLIPSOID), Meanings(dialect="lammps"))
    with pytest.raises(InputError, match=r"expected three semi-axes above zero, got 0\.03 0 0\.01"):
        row(frame(without(ELLIPSOID, shapey=0.0)), Meanings(dialect="liggghts"))


def test_spheres_among_ellipsoids() -> None:
    """Law: in a mixed LAMMPS dump the rows that compute property/atom calls 1 1 1 with quaternion 1 0 0 0 and no angmom are spheres or points."""
    ball = without(ELLIPSOID, shapex=1.0, shapey=1.0, shapez=1.0, omegax=W, radius=R, angmomx=0.0, angmomy=0.0, angmomz=0.0)
    body = without(ELLIPSOID, id=2, radius=0.0, angmomx=2e-5, angmomy=0.0, angmomz=0.0)
    got = row(frame(ball, body), Meanings(dialect="lammps")).by_shape
    assert got["sphere"] == pytest.approx(ENERGY, rel=1e-15)
    assert got["superquadric"] == pytest.approx(0.5 * 2e-5**2 / (M / 5.0 * (0.01**2 + 0.005**2)), rel=1e-14)


def test_half_a_step_later() -> None:
    """Law: LIGGGHTS' halfstep takes omega + dt/2 T/I and v + dt/2 f/m; without the step or the torques it is refused."""
    dt, torque = 1e-4, 3e-4
    kicked = without(SPHERE, tqx=0.0, tqy=torque, tqz=0.0, fx=0.0, fy=5.0, fz=0.0)
    later = W + 0.5 * dt * torque / (0.4 * M * R**2)
    got = row(frame(kicked), Meanings(timestep=dt), halfstep=True)
    assert got.erotate == pytest.approx(0.5 * 0.4 * M * R**2 * later**2, rel=1e-14)
    assert got.ke == pytest.approx(0.5 * M * ((3.0 + 0.5 * dt * 5.0 / M) ** 2 + 16.0), rel=1e-14)
    with pytest.raises(InputError, match="needs the time step"):
        row(frame(kicked), halfstep=True)
    with pytest.raises(InputError, match="needs the columns tqx tqy tqz"):
        row(frame(SPHERE), Meanings(timestep=dt), halfstep=True)


@pytest.mark.parametrize("name", ["omegay", "radius", "mass"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_are_told(name: str, value: float) -> None:
    """Law: nan and inf make the energy of their frame unknown, and are reported with step and id; others are not touched."""
    found = energies_of(frame(without(SPHERE, id=8), without(SPHERE, id=9, **{name: value})), Wanted())
    assert np.isnan(found.row.erotate)
    assert found.row.by_shape["superquadric"] == 0.0
    assert found.notes == [f"step 100: {name.removesuffix('y')} of particle 9 is not finite"]
    assert found.by_particle["sphere"].value.tolist() == pytest.approx([ENERGY])


def test_molecules_may_be_rigid_or_not() -> None:
    """Law: `mol` alone does not tell whether molecules are rigid: it is asked; with every particle in one of its own there is no question."""
    pair = [without(SPHERE, id=i, mol=4, x=0.1 * i, y=0.0, z=0.0) for i in (1, 2)]
    with pytest.raises(InputError, match="mol may number rigid bodies or not: give --deck DECK"):
        row(frame(*pair))
    assert row(frame(*pair), Meanings(rigid="none")).by_shape["sphere"] == pytest.approx(2 * ENERGY, rel=1e-15)
    apart = [without(SPHERE, id=i, mol=i) for i in (1, 2)]
    assert row(frame(*apart)).by_shape["sphere"] == pytest.approx(2 * ENERGY, rel=1e-15)


def test_units_and_time() -> None:
    """Law: energies are in the units' own; time is the file's, or step times the deck's step, or unknown."""
    assert row(frame(SPHERE, units="metal")).erotate == pytest.approx(1.0364269e-4 * ENERGY, rel=1e-15)
    assert row(frame(SPHERE, units="si")).erotate == pytest.approx(ENERGY, rel=1e-15)
    assert row(frame(SPHERE)).time is None
    assert row(frame(SPHERE), Meanings(timestep=0.5)).time == 50.0
    assert row(frame(SPHERE, time=7.0), Meanings(timestep=0.5)).time == 7.0


def test_a_body_number_that_was_printed_as_a_float_is_seen() -> None:
    """Law: LIGGGHTS writes one number as mol and id_multisphere; a column that a wrong format spoilt does not win, and fractions are refused."""
    spoilt = [without(SPHERE, id=i, mol=(i + 1) // 2, id_multisphere=2500, x=0.0, y=0.1 * i, z=0.0) for i in (1, 2, 3, 4)]
    found = energies_of(frame(*spoilt, dialect="liggghts"), Wanted(Meanings()))
    assert found.by_particle["multisphere"].id.tolist() == [1, 2]
    assert [note for note in found.notes if "mol and id_multisphere differ" in note]
    with pytest.raises(InputError, match=r"a body has the number 0\.02: expected whole numbers"):
        row(frame(*[without(SPHERE, id=i, id_multisphere=0.02, x=0.1 * i, y=0.0, z=0.0) for i in (1, 2)]))


def test_what_was_taken_for_granted_is_told() -> None:
    """Law: superquadrics without blockiness, shapeless particles without radius and discs that look like spheres are told, and silent where known."""

    def notes(shown: Frame, meanings: Meanings | None = None) -> str:
        return " ".join(energies_of(shown, Wanted(meanings or Meanings())).notes)

    assert "no columns blockiness1 blockiness2" in notes(frame(ELLIPSOID, dialect="liggghts"))
    assert not notes(frame(ELLIPSOID | {"blockiness1": 2.0, "blockiness2": 2.0}, dialect="liggghts"))
    swing = {f"angmom{axis}": 0.0 for axis in "xyz"}
    point = without(ELLIPSOID, shapex=1.0, shapey=1.0, shapez=1.0, **swing)
    assert "are taken for points" in notes(frame(point, dialect="lammps"))
    assert not notes(frame(point, dialect="lammps"), Meanings(atom_style=("ellipsoid",)))
    with pytest.raises(InputError, match="radius or diameter"):
        notes(frame(point, dialect="lammps"), Meanings(atom_style=("hybrid", "ellipsoid", "sphere")))
    disc = without(SPHERE, "mass", density=RHO, omegax=0.0, omegay=0.0, omegaz=W, vz=0.0)
    assert "if the deck says dimension 2" in notes(frame(disc, dialect="liggghts"))
    assert not notes(frame(disc, dialect="liggghts"), Meanings(atom_style=("granular",)))
    assert not notes(frame(disc | {"omegax": W}, dialect="liggghts"))

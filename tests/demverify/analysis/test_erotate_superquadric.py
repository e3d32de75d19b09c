"""`demverify.erotate` and `demverify erotate` on dumps of LIGGGHTS' superquadrics, from what they hold or a part of it, against the energies
that were printed."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from demverify import erotate
from demverify.errors import InputError
from tests.demverify.analysis.printed import ROUNDING, assert_printed, command

DATA = Path(__file__).parents[2] / "data" / "superquadric"
FRAMES = {"free": 6, "collide": 7}
both_runs = pytest.mark.parametrize("name", FRAMES)


def table(name: str) -> dict[int, dict[str, float]]:
    """Step -> column -> what LIGGGHTS printed: rot is erotate/superquadric, kin is ke."""
    head, *rows = [line.split() for line in (DATA / f"{name}.thermo").read_text().splitlines()]
    return {int(row[0]): dict(zip(head, map(float, row), strict=True)) for row in rows}


def columns(name: str, *hidden: str) -> list[str]:
    """The columns of a dump, those that begin with `hidden` under names that mean nothing."""
    with gzip.open(DATA / f"{name}.dump.gz", "rt") as stream:
        found = next(line.split()[2:] for line in stream if line.startswith("ITEM: ATOMS"))
    assert all(any(column.startswith(start) for column in found) for start in hidden)
    return [f"hidden{number}" if column.startswith(hidden) else column for number, column in enumerate(found)] if hidden else found


@both_runs
@pytest.mark.parametrize("hidden", [(), ("angmom", "inertia"), ("omega", "inertia"), ("quat", "inertia"), ("mass",), ("mass", "density", "quat")])
def test_the_printed_energy_comes_back(name: str, hidden: tuple[str, ...]) -> None:
    """Law: from everything, without angmom (quaternion and omega), without omega (quaternion and angmom), without orientations (omega and
    angmom), and with density times the volume of the shape for the mass, the energy is what LIGGGHTS printed at that step."""
    found = erotate(DATA / f"{name}.dump.gz", columns=columns(name, *hidden))
    assert_printed(found, table(name), FRAMES[name], superquadric="rot", erotate="rot")
    assert found.notes == ()
    if "density" not in hidden:
        assert_printed(found, table(name), FRAMES[name], ke="kin")
    else:
        assert {row.ke for row in found.rows} == {None}


@pytest.mark.parametrize("hidden", [("blockiness2", "angmom", "inertia"), ("blockiness1", "blockiness2", "mass")])
def test_shapes_without_exponents_are_told(hidden: tuple[str, ...]) -> None:
    """Law: where an energy asks for exponents that are not both there, superquadrics are taken for ellipsoids, and a note says so."""
    found = erotate(DATA / "collide.dump.gz", columns=columns("collide", *hidden))
    assert found.notes == ("no columns blockiness1 blockiness2 (it takes both): superquadrics are taken for ellipsoids (2 2)",)


@both_runs
def test_the_command_line(name: str, tmp_path: Path) -> None:
    """Law: --columns hides on the command line what it hides in the library."""
    for hidden in (("angmom", "inertia"), ("omega", "inertia")):
        names = columns(name, *hidden)
        rows, said = command(tmp_path, DATA / f"{name}.dump.gz", "--columns", " ".join(names))
        assert said == ""
        assert rows == [row.as_dict() for row in erotate(DATA / f"{name}.dump.gz", columns=names).rows]


@pytest.mark.parametrize("name", ["scheme3", "scheme3_contacts"])
def test_of_both_columns_the_printed_energy_is_taken(name: str) -> None:
    """Law: with omega and angmom there is L . omega / 2, LIGGGHTS' formula, also in scheme 3, where the two belong to orientations one step apart:
    the energy of either alone is off by what turns in one step (angle 4e-3: 2e-5 of the energy at most)."""
    whole, spun, turned = (
        erotate(DATA / f"{name}.dump.gz", columns=columns(name, *hidden))["superquadric"] for hidden in ((), ("angmom",), ("omega",))
    )
    products = erotate(DATA / f"{name}.dump.gz", columns=columns(name, "quat"))["superquadric"]
    assert_allclose(whole, products, rtol=ROUNDING)
    for alone in (spun, turned):
        assert_allclose(alone, whole, rtol=2e-5)
    assert abs(spun / turned - 1).max() > 1e-10


@pytest.mark.parametrize(
    ("hidden", "message"),
    [
        (("omega", "angmom"), "erotate/superquadric needs the columns angmomx angmomy angmomz"),
        (("quat", "angmom"), "erotate/superquadric needs the columns"),
        (("mass", "density", "omega"), r"erotate/superquadric needs the columns mass or density \(or --density X, --deck DECK\)"),
        (("shape",), "angmom, quat, blockiness are not of spheres: expected shapex shapey shapez too"),
    ],
)
def test_what_is_missing_is_named(hidden: tuple[str, ...], message: str) -> None:
    """Law: what the columns do not tell is an error that says which are missing, never the energy of spheres."""
    with pytest.raises(InputError, match=rf"free\.dump\.gz: step 0: .*{message}"):
        erotate(DATA / "free.dump.gz", columns=columns("free", *hidden))

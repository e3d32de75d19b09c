"""Densities, clumps and rigid bodies that a deck tells, against the particles that the deck makes."""

from __future__ import annotations

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from demverify.deck.dictionary import Dictionary, read_dictionary
from demverify.deck.interpreter import Interpreter
from demverify.deck.particles import density_mass
from demverify.deck.setup import Dialect

SPHERES = "units si\natom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 3 b\n"
TWO = f"{SPHERES}create_atoms 1 single 0.1 0.1 0.1\ncreate_atoms 2 single 0.3 0.1 0.1\n"
POUR = "fix 1 all pour 10 1 1234 region b"
TEMPLATE = "fix t all particletemplate/sphere 15485863 atom_type 2 density constant 2500 radius constant 0.01\n"
STONE = "# a stone\n0 0 0 2\n1 0 0 1\n"


@pytest.fixture
def told(tmp_path: Path):
    """told(text, dialect="lammps", **files): the dictionary of a deck in a folder of its own."""

    def read(text: str, dialect: str = "lammps", **files: str) -> Dictionary:
        for file, content in files.items():
            (tmp_path / file.replace("__", ".")).write_text(content)
        (tmp_path / f"in.{dialect}").write_text(text)
        return read_dictionary(tmp_path / f"in.{dialect}")

    return read


# ---- against the interpreter, which has the particles ------------------------------------------------------------------------------

NUMBER = st.sampled_from(["0.5", "2", "1000", "2500.5"])
TYPES = st.sampled_from(["1", "2", "3", "1*2", "2*", "*2", "*"])
WHERE = st.one_of(
    TYPES.map(lambda t: f"type {t}"),
    st.sampled_from(["atom 1", "atom 2", "atom 3", "atom 1*2", "atom 2*", "atom *"]),
    st.sampled_from(["group all", "group g", "group h", "region half"]),
)
CHANGE = st.one_of(
    *(NUMBER.map(lambda x, k=k: f"{k} {x}") for k in ("density", "diameter", "mass", "vx")),
    st.sampled_from(["1", "2", "3"]).map(lambda t: f"type {t}"),
)
COMMAND = st.one_of(
    st.tuples(WHERE, st.lists(CHANGE, min_size=1, max_size=3)).map(lambda x: f"set {x[0]} {' '.join(x[1])}"),
    st.tuples(st.integers(1, 3), st.integers(5, 99)).map(lambda x: f"create_atoms {x[0]} single 0.{x[1]} 0.7 0"),
    st.sampled_from(["group g type 1", "group g type 2:3", "group g type 1:3:2", "group g empty"]),
    st.sampled_from(["group h id 1 3", "group h region half", "group h type 2", "group h clear"]),
)


@settings(deadline=None)
@example("lammps", 3, ["set group h type 3 density 0.5"])
@example("lammps", 3, ["set group h type 2", "group g type 1", "set group g density 0.5"])
@given(st.sampled_from(["lammps", "liggghts"]), st.sampled_from([2, 3]), st.lists(COMMAND, max_size=8))
def test_a_known_density_is_that_of_every_particle(dialect: Dialect, dimension: int, commands: list[str]) -> None:
    """Law: whatever the commands and their order, a density that is told is that of each particle of the type, by its mass and radius."""
    lines = [
        f"dimension {dimension}",
        "units si",
        f"atom_style {'sphere' if dialect == 'lammps' else 'granular'}",
        *("boundary p p p", "region b block 0 1 0 1 -0.5 0.5", "create_box 3 b", "region half block 0 0.3 0 1 -0.5 0.5"),
        *("create_atoms 1 single 0.1 0.1 0", "create_atoms 1 single 0.4 0.1 0", "create_atoms 2 single 0.7 0.1 0"),
        *("group g type 1", "group h id 2"),
        *commands,
    ]
    text = "\n".join(lines) + "\n"
    deck = Interpreter(dialect)
    setup = deck.run_text(text)
    atoms = setup.atoms
    assert atoms is not None
    found = read_text(text, dialect).meanings.density
    for kind, density in found.items():
        mine = atoms.type == kind
        np.testing.assert_allclose(atoms.mass[mine], density_mass(setup, atoms.radius[mine], density), rtol=1e-14)  # three roundings
    if commands and commands[-1] in {f"set {w} density 2500.5" for w in ("group all", "type *", "atom *", "type 1*3")}:
        assert found == dict.fromkeys(np.unique(atoms.type).tolist(), 2500.5)


def read_text(text: str, dialect: Dialect) -> Dictionary:
    """The dictionary of a deck in a folder that vanishes."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"in.{dialect}"
        path.write_text(text)
        return read_dictionary(path)


# ---- where densities come from -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("dialect", "text", "density"),
    [
        ("lammps", TWO, {1: 1.0, 2: 1.0}),  # the default of both engines
        ("liggghts", TWO.replace("sphere", "granular"), {1: 1.0, 2: 1.0}),
        ("lammps", TWO.replace("style sphere", "style hybrid sphere molecular"), {1: 1.0, 2: 1.0}),
        ("lammps", TWO.replace("style sphere", "style ellipsoid"), {}),
        ("lammps", TWO.replace("style sphere", "style atomic"), {}),
        ("lammps", f"{TWO}set type 1 density 5\n", {1: 5.0, 2: 1.0}),
        ("lammps", f"{TWO}set atom 2 density 5\n", {1: 1.0, 2: 5.0}),
        ("lammps", f"{TWO}set atom * density v_x\n", {}),
        ("lammps", f"{TWO}variable x equal 2+3\nset atom * density v_x\n", {1: 5.0, 2: 5.0}),
        ("lammps", f"{TWO}variable x atom 2+3\nset atom * density v_x\n", {}),
        ("lammps", f"{TWO}set region b density 5\n", {}),
        ("lammps", f"{TWO}set group all density 5 diameter 0.1\n", {}),  # LAMMPS keeps the mass (measured, see commands/change.py)
        ("lammps", f"{TWO}set group all diameter 0.1 density 5\n", {1: 5.0, 2: 5.0}),
        ("liggghts", f"{TWO}set group all density 5 diameter 0.1\n", {1: 5.0, 2: 5.0}),
        ("lammps", f"{TWO}set group all type/fraction 3 0.5 1234\n", {1: 1.0, 2: 1.0, 3: 1.0}),
        ("lammps", f"dimension 2\n{TWO}set group all density/disc 5\n", {}),
        ("lammps", f"{TWO}delete_atoms region b\nset atom 1 density 5\n", {}),  # ids may be others now
        ("lammps", f"{SPHERES}create_atoms 1 box basis 2 3\nset type 3 density 7\n", {1: 1.0, 3: 7.0}),
        ("lammps", f"{SPHERES}create_atoms 0 random 10 1234 b mol m 1\n", {}),
        ("lammps", f"{SPHERES}{POUR} dens 3 3\n", {1: 3.0}),
        ("lammps", f"{SPHERES}{POUR} dens 3 4\n", {}),
        ("lammps", f"{SPHERES}{POUR} diam one 0.1\n", {1: 1.0}),
        ("lammps", f"{SPHERES}{POUR} mol m dens 3 3\n", {}),
        ("lammps", f"{SPHERES}{POUR} dens 3 3\nfix 2 all adapt 1 atom diameter v_d\n", {}),
        ("lammps", f"{SPHERES}fix 1 all deposit 10 2 1 1234 region b\n", {2: 1.0}),
        ("liggghts", f"{SPHERES}{TEMPLATE}", {2: 2500.0}),
        ("liggghts", f"{SPHERES}{TEMPLATE.replace('constant 2500', 'gaussian 2500 10')}", {}),
        ("liggghts", f"{SPHERES}{TEMPLATE.replace('2500', '${rho}')}", {}),
        ("liggghts", f"{SPHERES}{TEMPLATE.replace('15485863', '${seed}')}", {2: 2500.0}),
        ("liggghts", f"{SPHERES}{TEMPLATE}{TEMPLATE}", {2: 2500.0}),
        ("liggghts", f"{SPHERES}{TEMPLATE}{TEMPLATE.replace('2500', '2600')}", {}),
        ("liggghts", f"{SPHERES}{TEMPLATE}read_restart r\n", {}),
        ("liggghts", f"{SPHERES}{TEMPLATE}read_restart r\nset type 2 density 2500\n", {2: 2500.0}),
        ("liggghts", f"{SPHERES}{TEMPLATE}set type 2 density 2600\n", {}),  # more of the old density may come
        ("lammps", f"{TWO}if '$a' then 'set type 1 density 5'\n", {}),
        ("lammps", f"{TWO}include missing\n", {}),
        ("lammps", f"{TWO}include missing\nset group all density 4\n", {1: 4.0, 2: 4.0, 3: 4.0}),
        ("lammps", f"{TWO}group g type 2 3\nset group g density 5\n", {1: 1.0, 2: 5.0}),
        ("lammps", f"{TWO}group g region b\ngroup g type 2\nset group g density 5\n", {2: 5.0}),
        ("lammps", f"include missing\n{TWO}set group all density 5\n", {1: 5.0, 2: 5.0, 3: 5.0}),
        ("lammps", f"include missing\n{TWO.replace('atom_style sphere', '')}", {}),
        ("lammps", f"{TWO.replace('atom_style sphere', 'atom_style $s')}", {}),
        ("lammps", f"{TWO}set type $t density 5\n", {}),
        ("lammps", f"{TWO}set type '' density 5\n", {}),
        ("lammps", f"{TWO}set type 123456789012 density 5\n", {}),
        ("lammps", f"{TWO}group g type 1\nif '$a' then 'group g type 2'\nset group g density 5\n", {}),
        ("liggghts", f"{SPHERES}{TEMPLATE}set type 2 type 1\n", {1: 2500.0, 2: 2500.0}),  # and more of type 2 may come
        ("liggghts", f"{SPHERES}{POUR} dens 3 3\nfix 2 all adapt 1 atom diameter v_d\n", {1: 3.0}),
        ("lammps", f"{SPHERES}{POUR} dens 3 3\nfix 2 all adapt 1 pair gran diameter v_d\nfix 3 all adapt 1 atom charge v_q\n", {1: 3.0}),
        ("lammps", f"{TWO}set atom 1 vx ${{v}}\n", {1: 1.0, 2: 1.0}),
    ],
)
def test_densities_of_types(told, dialect: str, text: str, density: dict[int, float]) -> None:
    """Law: a type has a density if all its particles have the same one for certain; if not, a note says what is against it."""
    found = told(text, dialect)
    assert dict(found.meanings.density) == density
    kinds = {1, 2, 3} if "create_atoms 0" in text else {1, 2} if "create_atoms 2" in text else {*density}
    silent = "atomic" in text or not (kinds - set(density))
    assert silent or any("the density of" in note for note in found.passed_over)


@pytest.mark.parametrize(
    ("text", "density"),
    [
        ("set type 1 density 5\nrun 1\nset type 1 density 6\n", 5.0),
        ("dump 1 all custom 1 f id\nset type 1 density 5\nrun 1\nundump 1\nset type 1 density 6\nrun 1\n", 5.0),
        ("set type 1 density 5\nrun 1\nset type 1 density 6\ndump 1 all custom 1 f id\nrun 1\n", 6.0),
        ("set type 1 density 5\ndump 1 all custom 1 f id\nrun 1\nset type 1 density 6\nrun 1\n", None),
        ("set type 1 density 5\nwrite_dump all custom f id\nset type 1 density 6\nrun 1\n", 5.0),
        ("set type 1 density 5\ndump 1 all image 1 f.jpg type type\nrun 1\nundump 1\nset type 1 density 6\ndump 1 all custom 1 f id\nrun 1\n", 6.0),
    ],
)
def test_densities_are_those_of_the_dumps(told, text: str, density: float | None) -> None:
    """Law: what counts is the density while a dump was written, else that of the runs."""
    assert told(TWO + text).meanings.density.get(1) == density


def test_a_conflict_names_both_places(told) -> None:
    """Law: of several densities the first few are named, with file and line."""
    note = told(f"{SPHERES}{TEMPLATE}{TEMPLATE.replace('2500', '2600')}", "liggghts").passed_over[0]
    assert note.endswith("in.liggghts: the density of type 2 is not known: 2500 (in.liggghts:5); 2600 (in.liggghts:6)")


def data_file(rows: str, style: str = "") -> str:
    """A data file with two types."""
    return f"a comment\n\n3 atoms\n2 atom types\n0 1 xlo xhi\n\nMasses\n\n1 99\n\nAtoms{style}\n\n{rows}\nVelocities\n\n1 0 0 0 0 0 0\n"


@pytest.mark.parametrize(
    ("style", "rows", "density"),
    [
        ("sphere", "1 1 0.1 5 0 0 0\n2 2 0.2 6 0 0 0 # a comment\n3 1 0.1 5.0 0 0 0\n", {1: 5.0, 2: 6.0}),
        ("granular", "1 1 0.1 5 0 0 0\n2 2 0.2 6 0 0 0\n3 1 0.1 7 0 0 0\n", {2: 6.0}),
        ("sphere", "1 1 0.1 5 0 0 0\n2 2 0 6 0 0 0\n3 1 0 7 0 0 0\n", {1: 5.0}),  # points: the column is a mass
        ("bpm/sphere", "1 9 1 0.1 5 0 0 0\n2 9 2 0.1 6 0 0 0\n", {1: 5.0, 2: 6.0}),
        ("superquadric", "1 1 5 1 1 1 2 2 0 0 0\n2 2 6 1 1 1 2 2 0 0 0\n", {1: 5.0, 2: 6.0}),
        ("ellipsoid", "1 1 1 5 0 0 0\n2 2 0 6 0 0 0\n", {1: 5.0}),
        ("hybrid sphere molecular", "1 1 0 0 0 0.1 5 9\n2 2 0 0 0 0.1 6 9\n", {1: 5.0, 2: 6.0}),
        ("hybrid molecular sphere", "1 1 0 0 0 9 0.1 5\n2 2 0 0 0 9 0.1 6\n", {1: 5.0, 2: 6.0}),
        ("hybrid bpm/sphere molecular", "1 1 0 0 0 9 0.1 5\n2 2 0 0 0 9 0.1 6\n", {1: 5.0, 2: 6.0}),
        ("molecular", "1 1 1 0 0 0\n", {}),
    ],
)
def test_densities_of_a_data_file(told, style: str, rows: str, density: dict[int, float]) -> None:
    """Law: the density column of each atom style, where it is the same for all of a type; packed files are the same."""
    text = f"units si\natom_style {style}\nread_data x.data\n"
    assert dict(told(text, x__data=data_file(rows)).meanings.density) == density


def test_a_packed_or_shifted_data_file(told, tmp_path: Path) -> None:
    """Law: x.gz stands in for a missing x; the offset of types moves them; a later set replaces what the file said."""
    (tmp_path / "x.data.gz").write_bytes(gzip.compress(data_file("1 1 0.1 5 0 0 0\n").encode()))
    assert dict(told("atom_style sphere\nread_data x.data\n").meanings.density) == {1: 5.0}
    assert dict(told("atom_style sphere\nread_data x.data add append offset 2 0 0 0 0\n").meanings.density) == {3: 5.0}
    assert dict(told("atom_style sphere\nread_data x.data\nset type 1 density 7\n").meanings.density) == {1: 7.0}


@pytest.mark.parametrize(
    ("style", "rows", "why"),
    [
        ("sphere", "1 A 0.1 5 0 0 0\n", r"x\.data:13: expected id type diameter density"),
        ("sphere", "1 1 0.1 nan 0 0 0\n", r"x\.data:13: expected id type diameter density"),
        ("sphere", "1 1 0.1\n", r"x\.data:13: expected id type diameter density"),
        ("$s", "1 1 0.1 5 0 0 0\n", "reads particles whose atom_style is not known"),
        ("hybrid sphere oxdna", "1 1 0.1\n", "the columns of atom_style hybrid sphere oxdna are not known"),
        (None, "", r"gone\.data.*cannot be read"),
    ],
)
def test_a_data_file_that_is_not_understood_is_noted(told, style: str | None, rows: str, why: str) -> None:
    """Law: what is wrong is noted with the lines of the deck and of the data file, and no density is told."""
    text = f"atom_style {style or 'sphere'}\nread_data {'x' if style else 'gone'}.data\n"
    found = told(text, x__data=data_file(rows))
    assert not found.meanings.density
    assert any(re.search(rf"in\.lammps:2: .*{why}", note) for note in found.passed_over)


# ---- clumps and rigid bodies -------------------------------------------------------------------------------------------------------

CLUMP = "fix c all particletemplate/multisphere 15485863 atom_type 1 density constant 2500 nspheres 2 ntry 1000000"


@pytest.mark.parametrize(
    ("more", "before", "factor"),
    [
        ("spheres file stone.ms scale 0.5 type 3", "", 0.5),
        ("spheres file stone.ms scale ${s} type 3", "variable s equal 1/4\n", 0.25),
        ("spheres 0 0 0 2 1 0 0 1 type 3", "", 1.0),
        ("spheres file stone.ms scale 0.5 type 3", "coarsegraining 3 model_check warn\n", 1.5),
        ("spheres 0 0 0 2 1 0 0 1 type 3 fflag on on off", "coarsegraining 2\ncoarsegraining 3\n", 2.0),
    ],
)
def test_clumps(told, more: str, before: str, factor: float) -> None:
    """Law: the spheres of a template, from a file or from the line, scaled, with density and number; they give free spheres no density."""
    found = told(f"{before}{SPHERES}{CLUMP} {more}\nfix 2 all multisphere\n{TEMPLATE}", "liggghts", stone__ms=STONE)
    (template,) = found.meanings.templates
    np.testing.assert_array_equal(template.centre, factor * np.array([[0.0, 0, 0], [1, 0, 0]]))
    np.testing.assert_array_equal(template.radius, factor * np.array([2.0, 1]))
    assert (template.density, template.kind) == (2500.0, 3)
    assert found.meanings.rigid == "multisphere"
    assert dict(found.meanings.density) == {2: 2500.0}
    assert found.passed_over == []


@pytest.mark.parametrize(
    ("before", "clump", "why"),
    [
        ("", f"{CLUMP} spheres file gone.ms scale 1 type 1", "gone.ms: cannot be read"),
        ("", f"{CLUMP} spheres file stone.ms scale ${{s}} type 1", "scale is not known: variable 's' is not defined"),
        ("", f"{CLUMP} spheres file stone.ms scale 1", "has no keyword type"),
        ("", f"{CLUMP} spheres 0 0 0 2 1 0 0 0 type 1", "radius is not above zero"),
        ("", f"{CLUMP} spheres 0 0 0 2 type 1", "x y z r of a sphere must be a number, got 'type'"),
        ("", f"{CLUMP.replace('nspheres 2', 'nspheres 3')} spheres file stone.ms scale 1 type 1", "says nspheres 3, and stone.ms holds 2"),
        ("", f"{CLUMP} spheres file stone.ms scale 1 type 1 mass 1 inertia_tensor 1 0 0 1 0 1 use_volume", "mass and inertia outright"),
        ("coarsegraining ${cg}\n", f"{CLUMP} spheres file stone.ms scale 1 type 1", "coarse grained by a factor that is not known"),
    ],
)
def test_a_clump_that_is_not_understood_is_noted(told, before: str, clump: str, why: str) -> None:
    """Law: a clump whose spheres or inertia are not known is left out, with a note at its line."""
    found = told(f"{before}{SPHERES}{clump}\n", "liggghts", stone__ms=STONE)
    assert found.meanings.templates == ()
    assert any(why in note for note in found.passed_over)


def test_clumps_with_one_number(told) -> None:
    """Law: two clumps that differ cannot have the same number; one that is there twice is one."""
    one = f"{CLUMP} spheres 0 0 0 2 1 0 0 1 type 1\n"
    assert len(told(SPHERES + one + one, "liggghts").meanings.templates) == 1
    both = told(SPHERES + one + one.replace("2500", "2600"), "liggghts")
    assert both.meanings.templates == ()
    assert any("2 different clumps have the number 1" in note for note in both.passed_over)


@pytest.mark.parametrize(
    ("text", "rigid"),
    [
        ("fix 1 all nve/sphere\n", "none"),
        ("fix 1 all rigid molecule\n", "molecule"),
        ("fix 1 all rigid/nve/small molecule mol m\nunfix 1\n", "molecule"),
        ("fix 1 all multisphere\n", "multisphere"),
        ("fix 1 all rigid single\n", None),
        ("fix 1 all rigid group 2 a b\n", None),
        ("fix 1 all rigid/small custom i_body\n", None),
        ("fix 1 all poems molecule\nfix 2 all multisphere\n", None),
        ("include gone.inc\n", None),
        ("if '$a' then 'fix 1 all rigid molecule'\n", None),
    ],
)
def test_how_particles_belong_to_bodies(told, text: str, rigid: str | None) -> None:
    """Law: molecules, multispheres or nothing, if the deck leaves no doubt; if it does, a note says why."""
    found = told(SPHERES + text)
    assert found.meanings.rigid == rigid
    assert bool(found.passed_over) == (rigid is None)


def test_molecules_of_a_group(told) -> None:
    """Law: that only the molecules of a group are rigid is noted, as a dump does not show the group."""
    found = told(f"{SPHERES}fix 1 big rigid molecule\n")
    assert found.meanings.rigid == "molecule"
    assert "in.lammps:5: only molecules of the group big are rigid" in found.passed_over[0]

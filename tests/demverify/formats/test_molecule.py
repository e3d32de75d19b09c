"""Molecule files of LAMMPS: what is read, and what is refused with file and line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from numpy.testing import assert_allclose, assert_array_equal

from demverify.errors import InputError
from demverify.formats.molecule import read_molecule

HEAD = "two spheres\n2 atoms\n"
COORDS = "Coords\n\n1 0 0 0\n2 3 0 0\n"
TYPES = "\nTypes\n\n1 1\n2 2\n"
SIZES = "\nDiameters\n\n1 2\n2 4\n\nMasses\n\n1 5\n2 7\n"
WHOLE = HEAD + COORDS + TYPES + SIZES


def written(folder: Path, text: str) -> Path:
    """A file with this text."""
    path = folder / "clump.mol"
    path.write_text(text)
    return path


def test_sections(tmp_path: Path) -> None:
    """Law: a section is `ID values` by ID; the radius is half the diameter."""
    clump = read_molecule(written(tmp_path, WHOLE))
    assert_array_equal(clump.centre, [[0, 0, 0], [3, 0, 0]])
    assert_array_equal(clump.radius, [1, 2])
    assert_array_equal(clump.mass, [5, 7])
    assert_array_equal(clump.type, [1, 2])
    assert (clump.molecule, clump.total, clump.com, clump.inertia) == (None, None, None, None)


def test_header(tmp_path: Path) -> None:
    """Law: mass, com and inertia (Ixx Iyy Izz Ixy Ixz Iyz) are those of the whole."""
    text = HEAD + "1.5 mass\n 1 2 3 com # of mass\n\n1 2 3 4 5 6 inertia\n0 bonds\n\n" + COORDS + TYPES + "Molecules\n\n1 4\n2 0\n"
    clump = read_molecule(written(tmp_path, text))
    assert clump.total == 1.5
    assert_array_equal(clump.com, [1, 2, 3])
    assert_array_equal(clump.inertia, [[1, 4, 5], [4, 2, 6], [5, 6, 3]])
    assert_array_equal(clump.molecule, [4, 0])


def test_what_the_file_leaves_out(tmp_path: Path) -> None:
    """Law (measured in LAMMPS 22 Jul 2025): diameters are 1, also with `scale`; densities are 1."""
    for scale in (1.0, 2.0):
        clump = read_molecule(written(tmp_path, HEAD + COORDS + TYPES), scale)
        assert_array_equal(clump.radius, [0.5, 0.5])
        assert_allclose(clump.mass, math.pi / 6.0, rtol=1e-15)
    clump = read_molecule(written(tmp_path, HEAD + COORDS + TYPES + "Diameters\n\n1 2\n2 4\n"), 2.0)
    assert_allclose(clump.mass, [32.0 / 3.0 * math.pi, 256.0 / 3.0 * math.pi], rtol=1e-15)


def test_scale(tmp_path: Path) -> None:
    """Law: lengths times scale, masses its cube, moments of inertia its fifth power."""
    text = HEAD + "1.5 mass\n1 2 3 com\n1 2 3 4 5 6 inertia\n" + COORDS + TYPES + SIZES
    clump = read_molecule(written(tmp_path, text), 2.0)
    assert_array_equal(clump.centre, [[0, 0, 0], [6, 0, 0]])
    assert_array_equal(clump.radius, [2, 4])
    assert_array_equal(clump.mass, [40, 56])
    assert clump.total == 12.0
    assert_array_equal(clump.com, [2, 4, 6])
    assert clump.inertia is not None
    assert_array_equal(clump.inertia[0], [32, 128, 160])


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "\n" + SIZES + TYPES + COORDS,
        "# comment\n# more\n\n 2 atoms # of them\n\n" + COORDS.replace("Coords", "# first\n  Coords # x y z") + TYPES + SIZES + "\n# end\n",
        WHOLE.replace("1 0 0 0\n2 3 0 0", "2 3e0 0 0 # right\r\n1\t-0. 0.0 0"),
        WHOLE.rstrip(),
        HEAD + "1 bonds\n" + COORDS + "\nCharges\n\n1 0.5\n2 0.1\n" + TYPES + "\nBonds\n\n1 1 1 2\n" + SIZES,
        HEAD + COORDS + "\nSpecial Bond Counts\n\n1 1 0 0\n2 1 0 0\n\nSpecial Bonds\n\n1 2\n2 1\n" + TYPES + SIZES,
    ],
)
def test_layouts(tmp_path: Path, text: str) -> None:
    """Law: order, comments, blank lines and sections of bonds do not change the spheres."""
    clump = read_molecule(written(tmp_path, text))
    assert_array_equal(clump.centre, [[0, 0, 0], [3, 0, 0]])
    assert_array_equal(clump.radius, [1, 2])
    assert_array_equal(clump.mass, [5, 7])
    assert_array_equal(clump.type, [1, 2])


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("", 0, "N atoms"),
        ("2 atoms\n\n" + COORDS, 0, "the first line, which is a title"),
        ("title\n0 atoms\n" + COORDS, 0, "N of 1 or more"),
        ("title\n2.5 atoms\n", 2, "expected a whole number before atoms, got '2.5'"),
        ("title\n-2 atoms\n", 2, "whole number"),
        ("title\n2 3 atoms\n", 2, "expected 1 number before atoms, got '2 3 atoms'"),
        ("title\n2 atoms\n1 2 com\n", 3, "expected 3 numbers before com"),
        ("title\n2 atoms\n1 2 3 4 5 x inertia\n", 3, "expected 6 numbers before inertia"),
        ("title\n2 atoms\n7 sins\n", 3, "ends with atoms, bonds, .* got '7 sins'"),
        ("title\n2 atoms\n1 2 body\n", 3, "got '1 2 body'"),
        (HEAD, 0, "expected a section Coords, got no section"),
        (HEAD + COORDS, 0, "expected a section Types, got Coords"),
        (HEAD + TYPES, 0, "expected a section Coords, got Types"),
        (HEAD + "coords\n\n", 3, "the name of a section .* got 'coords'"),
        (HEAD + COORDS + "3 6 0 0\n", 7, "the name of a section .* got '3 6 0 0'"),
        (HEAD + COORDS + "# sizes\n" + TYPES, 7, "a line of comment between sections: LAMMPS reads nothing after it"),
        (HEAD + COORDS + COORDS, 7, "a second section Coords"),
        (HEAD + "Coords\n1 0 0 0\n2 3 0 0\n", 4, "a blank line after Coords, which LAMMPS skips, got '1 0 0 0'"),
        (HEAD + "Coords\n\n1 0 0_0 0\n2 3 0 0\n", 5, "expected ID x y z in Coords, got '1 0 0_0 0'"),
        (HEAD + "Coords\n\n1 0 ０ 0\n2 3 0 0\n", 5, "expected ID x y z in Coords"),
        (HEAD + "Coords\n\n¹ 0 0 0\n2 3 0 0\n", 5, "expected ID x y z in Coords"),
        (HEAD + "Coords\n\n1 0 0 0\n", 3, "expected 2 lines of Coords, got the end of the file"),
        (HEAD + "Coords\n\n1 0 0 0\n\n2 3 0 0\n", 3, "expected 2 lines of Coords, got 1"),
        (HEAD + "1 bonds\nBonds\n\n" + COORDS, 8, "the name of a section"),
        (HEAD + "1 bonds\nBonds\n\n", 4, "expected 1 line of Bonds, got the end of the file"),
        (HEAD + "Coords\n\n1 0 0\n2 3 0 0\n", 5, "expected ID x y z in Coords, got '1 0 0'"),
        (HEAD + "Coords\n\n1 0 0 x\n2 3 0 0\n", 5, "expected ID x y z in Coords"),
        (HEAD + "Coords\n\n1 0 0 nan\n2 3 0 0\n", 5, "expected ID x y z in Coords"),
        (HEAD + "Coords\n\na 0 0 0\n2 3 0 0\n", 5, "expected ID x y z in Coords"),
        (HEAD + "Coords\n\n1 0 0 0\n3 3 0 0\n", 6, "expected an ID from 1 to 2 in Coords, got 3"),
        (HEAD + "Coords\n\n0 0 0 0\n1 3 0 0\n", 5, "expected an ID from 1 to 2 in Coords, got 0"),
        (HEAD + "Coords\n\n1 0 0 0\n1 3 0 0\n", 6, "ID 1 a second time in Coords"),
        (HEAD + COORDS + "Types\n\n1 1\n2 0\n", 10, "a whole number of 1 or more in Types, got 0"),
        (HEAD + COORDS + "Types\n\n1 1.5\n2 1\n", 9, "a whole number of 1 or more in Types, got 1.5"),
        (HEAD + COORDS + TYPES + "Molecules\n\n1 1\n2 -1\n", 15, "a whole number of 0 or more in Molecules"),
        (HEAD + COORDS + TYPES + "Diameters\n\n1 1\n2 0\n", 15, "a diameter above zero in Diameters, got 0"),
        (HEAD + COORDS + TYPES + "Masses\n\n1 -1\n2 1\n", 14, "a mass above zero in Masses, got -1"),
    ],
)
def test_what_is_no_molecule(tmp_path: Path, text: str, line: int, says: str) -> None:
    """Law: what LAMMPS refuses or would misread is refused, with its line."""
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=says) as caught:
        read_molecule(path)
    assert caught.value.place is not None
    assert (caught.value.place.file, caught.value.place.line) == (path, line)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_scale_is_positive(tmp_path: Path, scale: float) -> None:
    """Law: LAMMPS wants a scale above zero; so do we."""
    with pytest.raises(InputError, match="scale above zero"):
        read_molecule(written(tmp_path, WHOLE), scale)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    """Law: a missing, a binary file and a folder are one line each."""
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    for name, says in (("none", "No such file"), ("binary", "binary data"), (".", "cannot be read")):
        with pytest.raises(InputError, match=says):
            read_molecule(tmp_path / name)

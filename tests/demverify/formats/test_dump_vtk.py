"""Legacy VTK files: those of LIGGGHTS, and what the format allows."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver.shapes.rotation import matrix
from demverify.errors import InputError
from demverify.formats import dump_vtk
from demverify.formats.dump import read_dump
from demverify.formats.reading import AS_WRITTEN, Block, HalfWrittenError, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import DATA

VTK = DATA / "liggghts" / "vtk"
EXACT = {"ascii10.vtk": 1e-10, "binary10.vtk": 0.0}  # ASCII has 11 digits: half a unit of the last is below 5e-11 of the number
POINTS = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 1 2 3 4 5\nVERTICES 2 4\n1 0\n1 1\n"


def exact(step: int = 10) -> Frame:
    """The text dump of the same run, numbers in full."""
    return next(frame for frame in read_dump(VTK / "exact.txt") if frame.step == step)


def read(path: Path, reading: Reading = AS_WRITTEN) -> Frame:
    """The frame of a file."""
    (frame,) = dump_vtk.read(Block(path), reading)
    return frame


def written(tmp_path: Path, content: str | bytes, name: str = "d10.vtk") -> Path:
    """A file with this content."""
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("name", EXACT)
def test_liggghts_arrays_become_columns(name: str) -> None:
    """Law: v omega tq i, c_pa[1-3] and the scalars are the columns of the same run's text dump; positions in float32."""
    got, expected = read(VTK / name), exact()
    assert (got.step, got.n, got.local, got.dialect, got.time, got.units) == (10, 3, False, "liggghts", None, None)
    lost = {"unknownx", "unknowny", "unknownz"}  # xu yu zu: LIGGGHTS drops their name
    assert set(got.columns) == {*(set(expected.columns) - {"v_speed"}), "speed", *lost}
    for column, values in expected.columns.items():
        # float32 rounds by 2^-24 of a number; in ASCII it has 6 digits
        rtol = (2.0**-24 if name == "binary10.vtk" else 5e-6) if column in "xyz" else EXACT[name]
        np.testing.assert_allclose(got.columns[column.removeprefix("v_")], values, rtol=rtol, atol=0, err_msg=column)
    unwrapped = [got.columns[f"unknown{axis}"] for axis in "xyz"]
    np.testing.assert_allclose(unwrapped, [expected.columns[axis] for axis in "xyz"], rtol=EXACT[name], atol=0)


def test_box_comes_from_the_file_beside() -> None:
    """Law: the bounding box of the same step, ASCII or binary, gives the bounds; boundary flags nobody tells."""
    for name in EXACT:
        got = read(VTK / name)
        np.testing.assert_array_equal(got.box, [[-0.05, 0.05], [-0.05, 0.05], [0, 0.15]])
        assert got.cell is None
        assert got.boundary == ("??", "??", "??")


def test_without_it_bounds_are_not_known(tmp_path: Path) -> None:
    """Law: alone, the file has bounds of NaN."""
    shutil.copy(VTK / "ascii10.vtk", tmp_path)
    assert np.isnan(read(tmp_path / "ascii10.vtk").box).all()


def test_tilted_box() -> None:
    """Law: corners of region prism 0 1 0 1 0 1 0.2 0.1 -0.05 (in float32) become box and cell."""
    got = read(DATA / "liggghts" / "tilted" / "tilted0.vtk")
    assert got.cell is not None
    np.testing.assert_allclose(got.cell, [[1, 0, 0], [0.2, 1, 0], [0.1, -0.05, 1]], rtol=1e-6, atol=0)
    np.testing.assert_allclose(got.box, [[0, 1]] * 3, rtol=1e-6)


def test_a_frame_without_particles() -> None:
    """Law: LIGGGHTS writes no arrays then: no rows, the box all the same; names given with --columns are taken for granted."""
    got = read(VTK / "none10.vtk")
    assert (got.step, got.n, list(got.columns)) == (10, 0, ["x", "y", "z"])
    np.testing.assert_array_equal(got.box[2], [0, 0.15])
    assert list(read(VTK / "none10.vtk", Reading(columns=("x", "y", "z", "id", "radius"))).columns) == ["x", "y", "z", "id", "radius"]


def test_contacts_drawn_as_triangles_count_once() -> None:
    """Law: with a contact point LIGGGHTS writes each contact as three lines with equal data; the frame has two contacts, not six."""
    got = read(VTK / "triangles10.vtk")
    assert (got.local, got.n, got.step) == (True, 2, 10)
    np.testing.assert_array_equal(got.vectors("id1", "id2", "id2"), [[1, 2, 2], [2, 3, 3]])
    assert {"forcex", "forcey", "forcez"} <= set(got.columns)


def test_bounding_box_alone_is_refused() -> None:
    """Law: it has no particles, and the message says what it is."""
    for path in (VTK / "asciiboundingBox_10.vtk", VTK / "binaryboundingBox_10.vtk", DATA / "liggghts" / "tilted" / "tiltedboundingBox_0.vtk"):
        with pytest.raises(InputError, match=r"boundingBox_.*: a box without particles"):
            read(path)


def test_positions_alone_are_no_dump() -> None:
    """Law: a file that ends after its points may be cut off there."""
    with pytest.raises(HalfWrittenError, match="ends inside the points, or dumps positions alone"):
        read(VTK / "bare10.vtk")


def test_patterns_pass_over_bounding_boxes() -> None:
    """Law: a pattern that also fits the companions reads the dumps alone."""
    assert [frame.n for frame in read_dump(VTK / "ascii*.vtk")] == [3]
    with pytest.raises(InputError, match="a box without particles"):
        list(read_dump(VTK / "asciiboundingBox_10.vtk"))


def test_the_step_is_in_the_name(tmp_path: Path) -> None:
    """Law: digits nearest the end; where a pattern run2*.vtk merges them, the bounding box tells them apart; none is an error."""
    for name, step in {"d10.vtk": 10, "run2.00300.vtk": 300, "2d_40_end.vtk": 40, "d7.vtk.gz": 7}.items():
        path = tmp_path / name
        shutil.copy(VTK / "ascii10.vtk", path)
        assert read(path).step == step
    shutil.copy(VTK / "ascii10.vtk", tmp_path / "run210.vtk")
    assert read(tmp_path / "run210.vtk").step == 210
    shutil.copy(VTK / "asciiboundingBox_10.vtk", tmp_path / "run2boundingBox_10.vtk")
    got = read(tmp_path / "run210.vtk")
    assert got.step == 10
    np.testing.assert_array_equal(got.box[2], [0, 0.15])
    with pytest.raises(InputError, match=r"nostep\.vtk: a VTK file does not say its step"):
        read(VTK / "nostep.vtk")


def test_keep_and_names() -> None:
    """Law: columns are renamed and selected, rows sorted by an id that is not kept; what is not wanted is not decoded."""
    got = read(VTK / "ascii10.vtk", Reading(names={"unknownx": "xu", "mass": "m"}, keep=frozenset({"xu", "m"})))
    assert list(got.columns) == ["m", "xu"]


def test_rows_are_sorted_by_id(tmp_path: Path) -> None:
    """Law: rows go by id, also in an old file with SCALARS and VECTORS (pizza.py's vtk tool writes these)."""
    old = "POINT_DATA 2\nSCALARS id int 1\nLOOKUP_TABLE default\n9\n2\nVECTORS v float\n1 2 3 4 5 6\nSCALARS r float\nLOOKUP_TABLE default\n7 8\n"
    got = read(written(tmp_path, POINTS + old))
    assert {name: values.tolist() for name, values in got.columns.items()} == {
        "x": [3, 0], "y": [4, 1], "z": [5, 2], "id": [2, 9], "vx": [4, 1], "vy": [5, 2], "vz": [6, 3], "r": [8, 7],
    }  # fmt: skip
    assert got.dialect is None


def test_metadata_and_fields_of_the_file_are_passed_over(tmp_path: Path) -> None:
    """Law: METADATA blocks after arrays and a FIELD before the points change nothing."""
    field = "POINT_DATA 2\nFIELD FieldData 2\nid 1 2 int\n1 2\nMETADATA\nINFORMATION 1\nNAME L2 LOCATION vtk\nDATA 2 0 1\n\nr%20x 1 2 double\n7 8\n"
    head, rest = POINTS.split("POINTS", 1)
    got = read(written(tmp_path, f"{head}FIELD FieldData 1\nTIME 1 1 double\n0.5\nPOINTS{rest}METADATA\nINFORMATION 0\n\n{field}"))
    assert list(got.columns) == ["x", "y", "z", "id", "r x"]


@given(st.lists(st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.dot(q, q) > 0.01), min_size=1, max_size=5))
def test_tensor_becomes_a_quaternion(quats: list[list[float]]) -> None:
    """Law: the matrix R(q) that LIGGGHTS writes for quat1 to quat4 comes back as q or -q, whichever has quat1 >= 0."""
    rows = np.array(quats) / np.linalg.norm(quats, axis=1)[:, None]
    n = len(rows)
    got = np.column_stack(list(_columns_of_tensor(rows).values()))
    np.testing.assert_allclose(np.linalg.norm(got, axis=1), np.ones(n), rtol=1e-15)
    assert (got[:, 0] >= 0).all()
    # R is good to some ulp, and a component of q is found by dividing by one of at least 1/2
    np.testing.assert_allclose(matrix(got), matrix(rows), atol=1e-14)


def _columns_of_tensor(quats: np.ndarray) -> dict[str, np.ndarray]:
    from demverify.formats.vtk_frame import Array

    array = Array("TENSOR", 9, lambda: matrix(quats).reshape(-1, 9))
    assert array.columns == ["quat1", "quat2", "quat3", "quat4"]
    return dict(zip(array.columns, array.table.T, strict=True))


def test_tensor_tells_the_dialect(tmp_path: Path) -> None:
    """Law: LIGGGHTS alone writes TENSOR, so shapex is a semi-axis; half a turn about z is quat 0 0 0 1."""
    turn = "-1 0 0 0 -1 0 0 0 1"
    got = read(written(tmp_path, f"{POINTS}POINT_DATA 2\nFIELD FieldData 2\nid 1 2 int\n1 2\nTENSOR 9 2 double\n{turn} 1 0 0 0 1 0 0 0 1\n"))
    assert got.dialect == "liggghts"
    np.testing.assert_array_equal([got.columns[f"quat{i}"] for i in (1, 2, 3, 4)], [[0, 1], [0, 0], [0, 0], [1, 0]])


def test_a_mesh_is_no_list_of_contacts(tmp_path: Path) -> None:
    """Law: cells other than lines with data of their own (dump mesh/vtk) are refused."""
    mesh = "# vtk DataFile Version 2.0\nmesh\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n"
    with pytest.raises(InputError, match="a mesh, not contacts"):
        read(written(tmp_path, mesh + "CELL_DATA 1\nSCALARS id float 1\nLOOKUP_TABLE default\n1\n"))


def test_names_of_odd_arrays(tmp_path: Path) -> None:
    """Law: a range of two or four components keeps its name and gets numbers; one of three not in a row gets axes."""
    field = "a 2 2 int\n1 2 3 4\nc_x[1-5] 3 2 int\n1 2 3 4 5 6\nf_y[2-4] 3 2 int\n1 2 3 4 5 6\n"
    got = read(written(tmp_path, f"{POINTS}POINT_DATA 2\nFIELD FieldData 4\nid 1 2 int\n1 2\n{field}"))
    assert list(got.columns)[4:] == ["a[1]", "a[2]", "c_x[1-5]x", "c_x[1-5]y", "c_x[1-5]z", "f_y[2]", "f_y[3]", "f_y[4]"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ASCII", "HEXADECIMAL", "expected ASCII or BINARY in line 3"),
        ("POLYDATA", "STRUCTURED_POINTS", "a VTK file of STRUCTURED_POINTS holds no particles"),
        ("POINTS 2", "POINTS -2", "expected a count, got '-2'"),
        ("POINTS 2", "POINTS 3", "ends inside|is no part|expects numbers"),
        ("POINTS 2", "POINTS 1", "'3 4 5' is no part of a VTK file"),
        ("POINT_DATA 2", "POINT_DATA 3", "expected an array id of 3 rows, got 2"),
        ("FieldData 1", "FieldData 2", "ends inside a list of arrays"),
        ("FieldData 1", f"FieldData {10**17}", "ends inside a list of arrays"),
        ("FieldData 1", f"FieldData {2**60}", "expected a count"),
        ("id 1 2", "id 0 2", "expected an array id of 1 to 99 components, got 0"),
        ("id 1 2", f"id {2**55} 2", "expected an array id of 1 to 99 components"),
        ("id 1 2", f"id 1 {2**59}", "ends inside array id"),
        ("id 1 2 int", "id 1 2 quad", "array id is of type 'quad'"),
        ("id 1 2 int", "id 1 2", "'id 1 2' is no part of a VTK file"),
        ("\n1 2\n", "\n1 x\n", "array id expects numbers, got 'x'"),
        ("\n1 2\n", "\n1 1_0\n", "array id expects numbers, got '1_0'"),
        ("\n1 2\n", "\n1 1\n", "id 1 stands in two rows"),
        ("\n1 2\n", "\n1 2", "ends inside array id"),
        ("id 1 2", "ip 1 2", "an id among them"),
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    """Law: what is wrong, and what was expected, in one line."""
    content = POINTS + "POINT_DATA 2\nFIELD FieldData 1\nid 1 2 int\n1 2\n"
    assert old in content
    with pytest.raises(InputError, match=message) as caught:
        read(written(tmp_path, content.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_words_are_refused_where_they_are_wanted(tmp_path: Path) -> None:
    """Law: an array of words does no harm unless it is wanted."""
    path = written(tmp_path, POINTS + "POINT_DATA 2\nFIELD FieldData 2\nid 1 2 int\n1 2\nelement 1 2 string\nA\nB\n")
    with pytest.raises(InputError, match="array element expects numbers, got 'A'"):
        read(path)
    assert list(read(path, Reading(keep=frozenset({"x"}))).columns) == ["x"]


def test_damaged_companion_is_named(tmp_path: Path) -> None:
    """Law: an error in the bounding box names that file."""
    shutil.copy(VTK / "ascii10.vtk", tmp_path)
    (tmp_path / "asciiboundingBox_10.vtk").write_text((VTK / "asciiboundingBox_10.vtk").read_text().replace("-0.05 0.05", "0.06 0.05"))
    with pytest.raises(InputError, match=r"asciiboundingBox_10\.vtk: expected box bounds lo <= hi"):
        read(tmp_path / "ascii10.vtk")

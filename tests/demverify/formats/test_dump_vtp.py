"""VTK files in XML: those of LIGGGHTS, and what the format allows."""

from __future__ import annotations

import base64
import shutil
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats import dump_vtp
from demverify.formats.dump import read_dump
from demverify.formats.reading import AS_WRITTEN, Block, HalfWrittenError, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import DATA, any_double

VTK = DATA / "liggghts" / "vtk"


def read(path: Path, reading: Reading = AS_WRITTEN) -> Frame:
    """The frame of a file."""
    (frame,) = dump_vtp.read(Block(path), reading)
    return frame


def written(tmp_path: Path, content: str | bytes, name: str = "d10.vtp") -> Path:
    """A file with this content."""
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("name", ["ascii10.vtp", "inline10.vtp", "zlib10.vtu"])
def test_liggghts_arrays_become_columns(name: str) -> None:
    """Law: ascii, base64 and zlib give every bit of the same run's text dump (%.17g); positions are rounded to float32."""
    got, expected = read(VTK / name), next(frame for frame in read_dump(VTK / "exact.txt") if frame.step == 10)
    assert (got.step, got.n, got.local, got.dialect, got.time, got.boundary) == (10, 3, False, None, None, ("??", "??", "??"))
    same = {"id", "type", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "radius", "mass"}
    assert set(got.columns) == same | {"x", "y", "z", "unknownx", "unknowny", "unknownz"}
    for column in same:
        np.testing.assert_array_equal(got.columns[column], expected.columns[column], err_msg=column)
    for axis in "xyz":
        np.testing.assert_array_equal(got.columns[axis], expected.columns[axis].astype(np.float32))
        np.testing.assert_array_equal(got.columns[f"unknown{axis}"], expected.columns[axis])  # xu yu zu, whose name LIGGGHTS drops
    np.testing.assert_array_equal(got.box, [[-0.05, 0.05], [-0.05, 0.05], [0, 0.15]])


def test_contacts() -> None:
    """Law: a file whose cells have the arrays lists contacts, in the order of the file; without a bounding box beside it bounds are NaN."""
    got = read(DATA / "liggghts" / "l10.vtp")
    assert (got.step, got.n, got.local, list(got.columns)) == (10, 2, True, ["id1", "id2", "forcex", "forcey", "forcez", "delta"])
    np.testing.assert_array_equal(got.columns["delta"], [0.0006468067403898291, 0.001970934278573304])
    np.testing.assert_array_equal(got.columns["forcez"], [-3.564457595340519, -13.80001867168856])
    assert np.isnan(got.box).all()


def test_contacts_drawn_as_triangles_count_once() -> None:
    """Law: with a contact point LIGGGHTS writes each contact as three lines with equal data; the frame has two contacts, not six."""
    got = read(VTK / "triangles10.vtp")
    assert (got.local, got.n) == (True, 2)
    np.testing.assert_array_equal([got.columns["id1"], got.columns["id2"]], [[1, 2], [2, 3]])


def test_tilted_box() -> None:
    """Law: corners of region prism 0 1 0 1 0 1 0.2 0.1 -0.05 (in float32) become box and cell."""
    got = read(DATA / "liggghts" / "tilted" / "tilted0.vtp")
    assert got.cell is not None
    np.testing.assert_allclose(got.cell, [[1, 0, 0], [0.2, 1, 0], [0.1, -0.05, 1]], rtol=1e-6, atol=0)
    np.testing.assert_allclose(got.box, [[0, 1]] * 3, rtol=1e-6)


def test_a_frame_without_particles() -> None:
    """Law: no rows, but the columns that LIGGGHTS lists."""
    got = read(VTK / "none10.vtp")
    assert (got.n, list(got.columns)) == (0, ["x", "y", "z", "id", "radius"])


def test_shares_of_processors_are_joined(tmp_path: Path) -> None:
    """Law: a .pvtp has the rows of all files that it names, by id; a share alone is refused, and a share that is missing."""
    share = (VTK / "share10_0.vtp").read_text()
    for i, ids in enumerate(("1 4 3", "7 2 5")):
        (tmp_path / f"share10_{i}.vtp").write_text(share.replace("1 2 3", ids))
    piece = '<Piece Source="share10_0.vtp"/>'
    index = (VTK / "share10.pvtp").read_text().replace(piece, piece + piece.replace("_0", "_1"))
    assert read(written(tmp_path, index, "share10.pvtp")).columns["id"].tolist() == [1, 2, 3, 4, 5, 7]
    with pytest.raises(InputError, match=r"share10_1\.vtp: one processor's share of share10\.pvtp"):
        read(tmp_path / "share10_1.vtp")
    (tmp_path / "share10_1.vtp").unlink()
    with pytest.raises(InputError, match=r"share10_1\.vtp: cannot be read"):
        read(tmp_path / "share10.pvtp")


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (VTK / "asciiboundingBox_10.vtr", "a box without particles"),
        (DATA / "liggghts" / "tilted" / "tiltedboundingBox_0.vtu", "a box without particles"),
        (VTK / "lz10.vtp", "compressor='vtkLZ4DataCompressor'"),
    ],
)
def test_what_holds_no_particles_or_is_not_known(path: Path, message: str) -> None:
    """Law: bounding boxes and a compressor that is not known are refused with the reason."""
    with pytest.raises(InputError, match=message):
        read(path)


def vtp(values: np.ndarray, order: str, header: str, form: str, packed: bool) -> bytes:
    """A file of points at 0 with ids 1 to n and an array `mass`, as the document on VTK's XML formats describes it."""
    size = {"UInt32": "u4", "UInt64": "u8"}[header]
    mark = {"LittleEndian": "<", "BigEndian": ">"}[order]
    appended = b""

    def ints(*numbers: int) -> bytes:
        return np.array(numbers, mark + size).tobytes()

    def blocks(raw: bytes) -> tuple[bytes, bytes]:
        if not packed:
            return ints(len(raw)), raw
        parts = [raw[i : i + 16] for i in range(0, len(raw), 16)]
        squeezed = [zlib.compress(part) for part in parts]
        return ints(len(parts), 16, len(raw) % 16, *map(len, squeezed)), b"".join(squeezed)

    def element(name: str, array: np.ndarray, kind: str, width: int) -> str:
        nonlocal appended
        head, body = blocks(array.astype(mark + kind[0].lower() + str(int(kind[-2:]) // 8)).tobytes())
        text = base64.b64encode(head) + base64.b64encode(body) if packed else base64.b64encode(head + body)
        tag = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}"'
        if form == "binary":
            return f'{tag} format="binary">\n  {text.decode()}\n</DataArray>'
        tag += f' format="appended" offset="{len(appended)}"/>'
        appended += head + body if form == "raw" else text
        return tag

    n = len(values)
    ids, mass = element("id", np.arange(1, n + 1), "Int64", 1), element("mass", values, "Float64", 1)
    points = element("Points", np.zeros(3 * n), "Float32", 3)
    compressor = ' compressor="vtkZLibDataCompressor"' if packed else ""
    head = f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="{order}" header_type="{header}"{compressor}>'
    body = f'<PolyData><Piece NumberOfPoints="{n}"><PointData>{ids}{mass}</PointData><Points>{points}</Points></Piece></PolyData>'
    tail = f'<AppendedData encoding="{"raw" if form == "raw" else "base64"}">\n  _'.encode() + appended + b"\n</AppendedData>" if appended else b""
    return (head + body).encode() + tail + b"</VTKFile>\n"


@given(
    values=st.lists(any_double, min_size=1, max_size=7).map(np.array),
    order=st.sampled_from(["LittleEndian", "BigEndian"]),
    header=st.sampled_from(["UInt32", "UInt64"]),
    form=st.sampled_from(["binary", "raw", "base64"]),
    packed=st.booleans(),
)
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_encoding(tmp_path: Path, values: np.ndarray, order: str, header: str, form: str, packed: bool) -> None:
    """Law: byte order, header type, inline or appended, raw or base64, plain or in several zlib blocks: the doubles are the same."""
    got = read(written(tmp_path, vtp(values.astype(float), order, header, form, packed)))
    np.testing.assert_array_equal(got.columns["mass"], values)
    assert got.columns["id"].tolist() == list(range(1, len(values) + 1))


def test_only_wanted_arrays_are_decoded(tmp_path: Path) -> None:
    """Law: an array that is not wanted may be damaged."""
    content = vtp(np.ones(3), "LittleEndian", "UInt32", "binary", packed=False).replace(b"Float64", b"Float61")
    assert list(read(written(tmp_path, content), Reading(keep=frozenset({"id"}))).columns) == ["id"]
    with pytest.raises(InputError, match="array mass has type 'Float61'"):
        read(written(tmp_path, content))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</VTKFile>", "", "the file ends before </VTKFile>"),
        ("</Points>", "</Point>", "not well-formed XML"),
        ("PolyData", "ImageData", "expected PolyData or UnstructuredGrid, got ImageData"),
        ('type="PolyData"', 'type="UnstructuredGrid"', "and a UnstructuredGrid"),
        ("LittleEndian", "MiddleEndian", "expected byte_order LittleEndian or BigEndian"),
        ("UInt32", "UInt16", "header_type UInt32 or UInt64"),
        ('NumberOfPoints="3"', 'NumberOfPoints="4"', "array Points is damaged: expected 48 bytes, got 36"),
        ('NumberOfPoints="3"', 'NumberOfPoints="-1"', "NumberOfPoints expects a count, got '-1'"),
        ('NumberOfPoints="3"', 'NumberOfPoints="900000000000000000"', "array Points is damaged: expected 10800000000000000000 bytes"),
        ('NumberOfComponents="1"', 'NumberOfComponents="900000000000000000"', "of 1 to 99 components"),
        ('format="binary"', 'format="morse"', "format 'morse'"),
        ("GAAAAA", "GAAAA!", "array id is damaged"),
        ("GAAAAA", "////fw", "array id is damaged: expected 2147483"),
        ("<Points>", "<Pints>", "not well-formed XML"),
        ('Name="id"', 'Name="ip"', "an id among them"),
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    """Law: what is wrong, and what was expected, in one line."""
    content = vtp(np.ones(3), "LittleEndian", "UInt32", "binary", packed=False).decode()
    assert old in content
    with pytest.raises(InputError, match=message) as caught:
        read(written(tmp_path, content.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_a_mesh_is_no_list_of_contacts(tmp_path: Path) -> None:
    """Law: polygons with data of their own (dump mesh to .vtp) are refused."""
    content = vtp(np.ones(3), "LittleEndian", "UInt32", "binary", packed=False).replace(b"PointData>", b"CellData>")
    with pytest.raises(InputError, match="a mesh, not contacts"):
        read(written(tmp_path, content.replace(b'NumberOfPoints="3"', b'NumberOfPoints="3" NumberOfPolys="3"')))


def test_half_a_file_is_half_written(tmp_path: Path) -> None:
    """Law: cut anywhere, the file is told to be half written, and passed over where that is wanted."""
    content = (VTK / "inline10.vtp").read_bytes()
    for cut in range(len(b'<?xml version="1.0"?>\n<VTKFile '), len(content.rstrip()), 97):
        path = written(tmp_path, content[:cut])
        with pytest.raises(HalfWrittenError, match="ends before </VTKFile>"):
            read(path)
        assert list(dump_vtp.read(Block(path), Reading(half_written=bool))) == []


def test_packed_blocks_that_lie_reserve_nothing(tmp_path: Path) -> None:
    """Law: a block that unpacks to a hundred million zeros is not unpacked beyond what was announced."""
    bomb = zlib.compress(bytes(100_000_000))
    head = np.array([1, 16, 8, len(bomb)], "<u4").tobytes()
    text = (base64.b64encode(head) + base64.b64encode(bomb)).decode()
    array = '<DataArray type="Float64" Name="{}" NumberOfComponents="{}" format="binary">{}</DataArray>'
    content = (
        '<VTKFile type="PolyData" byte_order="LittleEndian" compressor="vtkZLibDataCompressor"><PolyData><Piece NumberOfPoints="1">'
        f"<PointData>{array.format('id', 1, text)}</PointData><Points>{array.format('p', 3, '')}</Points></Piece></PolyData></VTKFile>"
    )
    path = written(tmp_path, content)
    tracemalloc.start()
    with pytest.raises(InputError, match="array id is damaged: expected 8 bytes, got 9"):
        read(path, Reading(keep=frozenset({"id"})))
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


def test_a_series_comes_in_order(tmp_path: Path) -> None:
    """Law: files of a pattern are read by step, and companions beside them give their box."""
    for step in (10, 9, 100):
        shutil.copy(VTK / "ascii10.vtp", tmp_path / f"d{step}.vtp")
        shutil.copy(VTK / "asciiboundingBox_10.vtr", tmp_path / f"dboundingBox_{step}.vtr")
    got = list(read_dump(tmp_path / "d*.vt?"))
    assert [frame.step for frame in got] == [9, 10, 100]
    assert all(frame.box[2, 1] == 0.15 for frame in got)

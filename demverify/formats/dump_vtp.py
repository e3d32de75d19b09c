"""VTK files in XML of particles and contacts: LIGGGHTS' `dump custom/vtk` and `dump local/gran/vtk` to .vtp and .vtu, or to .pvtp and
.pvtu (one file a processor, joined here).

    <VTKFile type="PolyData" byte_order=... header_type=... compressor=...>
      <PolyData><Piece NumberOfPoints=...> <PointData> <CellData> <Points>, each of <DataArray type Name NumberOfComponents format>
Arrays are ascii, binary (base64) or appended (raw or base64), plain or compressed with zlib
(https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html; what the columns are called: vtk_frame).

Positions are float32, other numbers have all digits. The companion `*boundingBox_N.vtr` (.vtu when tilted) gives Frame.box; without it
bounds are NaN.
"""

from __future__ import annotations

import base64
import binascii
import re
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from demverify.errors import InputError, Place
from demverify.formats.cell import orthogonal
from demverify.formats.reading import Block, HalfWrittenError, Reading, opened, whole_frames
from demverify.formats.vtk_frame import (
    BOX_ALONE,
    MESH,
    NO_BOX,
    NO_NAME,
    Array,
    Content,
    cell_of_corners,
    checked_width,
    frame_of,
    numbers,
    step_and_boxes,
)
from demverify.frames import Floats, Frame

_TYPES = {f"{kind}{bits}": f"{kind[0].lower()}{bits // 8}" for kind in ("Int", "UInt", "Float") for bits in (8, 16, 32, 64)}
_GRIDS = ("PolyData", "UnstructuredGrid")
_BOXES = ("RectilinearGrid", "PRectilinearGrid")
_ZLIB = "vtkZLibDataCompressor"
_SHARE = re.compile(r"_\d+\.(vt[pu])$")


class _File:
    """One file: its elements, and how its arrays are written."""

    def __init__(self, path: Path) -> None:
        self.place = Place(path)
        with opened(path) as stream:
            data = stream.read()
        head, tag, self._appended = data.partition(b"<AppendedData")
        if tag:
            self._raw = b"raw" in self._appended.partition(b">")[0]
            self._appended = self._appended.partition(b"_")[2]
            head += b"</VTKFile>"
        root = self._parsed(head, data)
        self.type = root.get("type", "")
        self.grid = root.find(self.type)
        order = {"LittleEndian": "<", "BigEndian": ">"}.get(root.get("byte_order", "LittleEndian"))
        header = {"UInt32": "u4", "UInt64": "u8"}.get(root.get("header_type", "UInt32"))
        self._compressor = root.get("compressor", "")
        if order is None or header is None or self.grid is None or self._compressor not in ("", _ZLIB):
            got = " ".join(f"{key}={value!r}" for key, value in root.attrib.items())
            known = f"byte_order LittleEndian or BigEndian, header_type UInt32 or UInt64, no compressor or {_ZLIB}"
            raise self.error(f"expected {known}, and a {self.type or 'type'}; got {got[:200]}")
        self._order, self._header = order, np.dtype(order + header)

    def _parsed(self, head: bytes, data: bytes) -> ET.Element:
        try:
            return ET.fromstring(head)  # noqa: S314  (expat limits entities itself and fetches nothing)
        except (ET.ParseError, ValueError, LookupError) as error:
            if not data.rstrip().endswith(b"</VTKFile>"):
                message = "the file ends before </VTKFile>"
                raise HalfWrittenError(message, self.place) from None
            raise self.error(f"not well-formed XML: {error}") from None

    def error(self, message: str) -> InputError:
        return InputError(message, self.place)

    def count(self, element: ET.Element, attribute: str, default: str = "0") -> int:
        word = element.get(attribute, default)
        if not word.isdecimal() or len(word) > 18:
            raise self.error(f"{attribute} expects a count, got {word[:40]!r}")
        return int(word)

    def array(self, element: ET.Element, n: int) -> Array:
        """An array of n rows; it is decoded when it is wanted."""
        name = element.get("Name", "") or NO_NAME
        width = checked_width(name, self.count(element, "NumberOfComponents", "1"), self.place)
        return Array(name, width, partial(self.values, element, n, width))

    def values(self, element: ET.Element, n: int, width: int) -> Floats:
        """Its numbers, (n, width)."""
        name = element.get("Name", "") or NO_NAME
        form, text = element.get("format", "ascii"), (element.text or "").strip().encode()
        kind = _TYPES.get(element.get("type", ""))
        if kind is None or kind == "f1" or form not in ("ascii", "binary", "appended"):
            known = f"{' '.join(_TYPES)}; ascii binary appended"
            raise self.error(f"array {name} has type {element.get('type')!r}, format {form!r}; known: {known}")
        dtype = np.dtype(self._order + kind)
        if form == "ascii":
            values = numbers(text, name, self.place)
        else:
            values = np.frombuffer(self._decoded(element, name, text, form, n * width * dtype.itemsize), dtype).astype(np.float64)
        if len(values) != n * width:
            raise self.error(f"expected an array {name} of {n} x {width} numbers, got {len(values)}")
        return values.reshape(n, width)

    def _decoded(self, element: ET.Element, name: str, text: bytes, form: str, size: int) -> bytes:
        """The bytes of an array."""
        if form == "appended":
            text = self._appended[self.count(element, "offset") :]
        take = partial(_plain, text) if form == "appended" and self._raw else partial(_from_base64, text)
        try:
            return _of_size(self._blocks(take, size) if self._compressor else self._block(take), size)
        except (ValueError, binascii.Error, zlib.error) as error:
            raise self.error(f"array {name} is damaged: {error}") from None

    def _block(self, take: Callable[[int, int], bytes]) -> bytes:
        header = self._header.itemsize
        return take(0, header + self._ints(take(0, header))[0])[header:]

    def _blocks(self, take: Callable[[int, int], bytes], size: int) -> bytes:
        """Number of blocks, their size, that of the last one (0: as the others), packed sizes; then the blocks."""
        if size == 0:
            return b""
        header = self._header.itemsize
        count, full, last = self._ints(take(0, 3 * header))
        packed = self._ints(take(0, (3 + count) * header)[3 * header :])
        body = take((3 + count) * header, sum(packed))
        parts, at = [], 0
        for i, length in enumerate(packed):
            expected = last if last and i == count - 1 else full
            parts.append(zlib.decompressobj().decompress(body[at : at + length], min(expected, size) + 1))
            at += length
        return b"".join(parts)

    def _ints(self, raw: bytes) -> list[int]:
        return [int(value) for value in np.frombuffer(raw, self._header)]


def _of_size(data: bytes, size: int) -> bytes:
    if len(data) != size:
        message = f"expected {size} bytes, got {len(data)}"
        raise ValueError(message)
    return data


def _plain(data: bytes, start: int, size: int) -> bytes:
    return _of_size(data[start : start + size], size)


def _from_base64(text: bytes, start: int, size: int) -> bytes:
    """`size` bytes that begin a base64 text (start 0), or its second part, after a header of `start` bytes with a padding of its own."""
    skipped, length = -(-start // 3) * 4, -(-size // 3) * 4
    return _plain(base64.b64decode(text[skipped : skipped + length], validate=True), 0, size)


def recognises(head: bytes) -> bool:
    """True when a file that starts so is a VTK file in XML."""
    return head.lstrip().startswith(b"<") and b"<VTKFile" in head


def read(block: Block, reading: Reading) -> Iterator[Frame]:
    """The one frame of a file, rows of particles sorted by id; contacts (cells with arrays) in the order of the file.

    Raises InputError for a file name without a step, for one processor's share of a .pvtp or .pvtu, and for what is no file of
    particles or contacts, such as a bounding box alone.
    """
    return whole_frames(_read_frames(block.path, reading), reading)


def _read_frames(path: Path, reading: Reading) -> Iterator[Frame]:
    whole = _SHARE.sub(r".p\1", path.name)
    if whole != path.name and path.with_name(whole).is_file():
        message = f"one processor's share of {whole}; name that file"
        raise InputError(message, Place(path))
    content = _joined(_contents(_File(path)), Place(path))
    step, boxes = step_and_boxes(path, (".vtr", ".vtu"))
    yield frame_of(path, step, content, reading, _read_box(_File(boxes[0])) if boxes else NO_BOX)


def _contents(file: _File) -> list[Content]:
    """Of every piece of a file, or of the files that it names."""
    assert file.grid is not None
    pieces = file.grid.findall("Piece")
    if file.type in _GRIDS:
        return [_content(file, piece) for piece in pieces]
    if file.type.removeprefix("P") not in _GRIDS:
        raise file.error(BOX_ALONE if file.type in _BOXES else f"expected {' or '.join(_GRIDS)}, got {file.type[:40]}")
    shares = [_File(file.place.file.parent / piece.get("Source", "")) for piece in pieces]
    return [content for share in shares if share.type in _GRIDS for content in _contents(share)]


def _content(file: _File, piece: ET.Element) -> Content:
    n, points = file.count(piece, "NumberOfPoints"), piece.findall("Points/DataArray")
    cells = sum(file.count(piece, f"NumberOf{kind}") for kind in ("Cells", "Verts", "Lines", "Strips", "Polys"))
    of_points = [file.array(element, n) for element in piece.findall("PointData/DataArray")]
    of_cells = [file.array(element, cells) for element in piece.findall("CellData/DataArray")]
    if len(points) != 1:
        raise file.error(f"expected one array of points, got {len(points)}")
    if not of_points and file.count(piece, "NumberOfPolys"):
        raise file.error(MESH)
    if n and not of_points and not of_cells:
        raise file.error(BOX_ALONE if (n, cells) == (8, 1) else "positions alone, without an id, are no dump")
    return Content(Array("", 3, partial(file.values, points[0], n, 3)), n, of_points, cells, of_cells)


def _joined(contents: list[Content], place: Place) -> Content:
    """The rows of all pieces one below the other. Raises InputError unless they have the same arrays."""
    kinds = {tuple((array.name, array.width) for array in (*content.of_points, None, *content.of_cells) if array) for content in contents}
    if len(kinds) != 1:
        message = "expected pieces with the same arrays" if contents else "a file without pieces"
        raise InputError(message, place)

    def rows(arrays: tuple[Array, ...]) -> Array:
        return Array(arrays[0].name, arrays[0].width, lambda: np.concatenate([array.values() for array in arrays]))

    points = rows(tuple(content.points for content in contents))
    of_points = [rows(arrays) for arrays in zip(*(content.of_points for content in contents), strict=True)]
    of_cells = [rows(arrays) for arrays in zip(*(content.of_cells for content in contents), strict=True)]
    return Content(points, sum(c.n for c in contents), of_points, sum(c.cells for c in contents), of_cells)


def _read_box(file: _File) -> tuple[Floats, Floats | None]:
    """Box and cell of a `*boundingBox_N`: a rectilinear grid of two by two by two points, or the corners of a tilted box (float32)."""
    assert file.grid is not None
    if file.type == "UnstructuredGrid":
        corners = [file.values(element, 8, 3) for element in file.grid.findall("Piece/Points/DataArray")]
        return cell_of_corners(np.concatenate([np.empty((0, 3)), *corners]), file.place)
    bounds = [file.values(element, 2, 1)[:, 0] for element in file.grid.findall("Piece/Coordinates/DataArray")]
    if len(bounds) != 3:
        raise file.error(f"expected the bounds of three axes, got {len(bounds)}")
    return orthogonal(np.array(bounds), file.place), None

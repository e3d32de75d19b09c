"""Template files of LIGGGHTS clumps: what is read, and what is refused with file and line."""

from __future__ import annotations

from pathlib import Path

import pytest
from numpy.testing import assert_array_equal

from demverify.errors import InputError
from demverify.formats.template import read_template

DATA = Path(__file__).parents[2] / "data" / "clumps"


def written(folder: Path, text: str) -> Path:
    """A file with this text."""
    path = folder / "clump"
    path.write_text(text)
    return path


def test_a_real_file() -> None:
    """Law: rows are x y z r, in the order of the file; density and kind are those given."""
    template = read_template(DATA / "tetra.ms", density=2500.0, kind=3)
    assert_array_equal(template.centre, [[0, 0, 0], [0.012, 0, 0], [-0.012, 0.004, 0], [0, 0.012, 0.006]])
    assert_array_equal(template.radius, [0.012, 0.01, 0.009, 0.008])
    assert (template.density, template.kind) == (2500.0, 3)


def test_scale(tmp_path: Path) -> None:
    """Law: `scale` multiplies centres and radii."""
    template = read_template(written(tmp_path, "1 2 3 4\n"), scale=0.001)
    assert_array_equal(template.centre, [[0.001, 0.002, 0.003]])
    assert_array_equal(template.radius, [0.004])


@pytest.mark.parametrize(
    "text",
    ["1 2 3 4\n5 6 7 8", "# two\n\n1\t2 3 4 # one\r\n\n5 6 7 8\n", "1 2 &\n3 4\n5 6 7 8\n", "1 2 3 4 1\n5 6 7 8 2\n", "1 2 3 4\n5 6 7 8 &\n"],
)
def test_layouts(tmp_path: Path, text: str) -> None:
    """Law: comments, blank lines, continued lines and a fifth column (type) do not change the spheres."""
    template = read_template(written(tmp_path, text))
    assert_array_equal(template.centre, [[1, 2, 3], [5, 6, 7]])
    assert_array_equal(template.radius, [4, 8])


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("", 0, "one sphere a line"),
        ("# nothing\n", 0, "one sphere a line"),
        ("0 0 0 1\n0 0 0\n", 2, "got 3 words: '0 0 0'"),
        ("0 0 0 1 1 1\n", 1, "got 6 words"),
        ("0 0 0 one\n", 1, "expected numbers"),
        ("0 0 0 1_0\n", 1, "expected numbers"),
        ("0 0 0 １\n", 1, "expected numbers"),
        ("0 0 nan 1\n", 1, "finite"),
        ("0 0 0 1\n\n0 0 0 -1\n", 3, "r above zero"),
        ("0 0 0 0\n", 1, "r above zero"),
        ("0 0 &\n0 x\n", 2, "expected numbers"),
    ],
)
def test_what_is_no_template(tmp_path: Path, text: str, line: int, says: str) -> None:
    """Law: anything but rows of four or five numbers with a radius above zero is refused, with its line."""
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=says) as caught:
        read_template(path)
    assert caught.value.place is not None
    assert (caught.value.place.file, caught.value.place.line) == (path, line)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_scale_is_positive(scale: float) -> None:
    """Law: LIGGGHTS wants a scale above zero; so do we."""
    with pytest.raises(InputError, match="scale above zero"):
        read_template(DATA / "tetra.ms", scale)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    """Law: a missing, a binary file and a folder are one line each."""
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    for name, says in (("none", "No such file"), ("binary", "binary data"), (".", "cannot be read")):
        with pytest.raises(InputError, match=says):
            read_template(tmp_path / name)

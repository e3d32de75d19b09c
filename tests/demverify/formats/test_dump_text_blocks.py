"""Blocks of text dumps: cut anywhere, together they are the file."""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats import dump, dump_text
from demverify.formats.dump_text_writer import text_frame
from demverify.formats.reading import AS_WRITTEN, Block, HalfWrittenError, Reading
from demverify.frames import Frame
from tests.demverify.formats.samples import BOX, DATA, EXACT, NAMES, assert_same, frame

FUZZ = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@st.composite
def files(draw: st.DrawFn) -> bytes:
    """Up to 8 frames of 0 to 9 rows, with units in the first, times, labels and words in a column or not, rows mixed."""
    units, time, label, words, kind = (draw(st.booleans()) for _ in range(5))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    content = b""
    for step, n in enumerate(draw(st.lists(st.integers(0, 9), max_size=8))):
        order = rng.permutation(n)
        one = Frame(step, BOX, ("pp", "fs", "mm"), {name: values[order] for name, values in frame(n, step).columns.items()})
        part = text_frame(one, NAMES, "liggghts" if kind else "lammps", EXACT)
        if words:
            part = part.replace(b" 1 ", b" ITEM ").replace(b" 2 ", b" TIMESTEP ")
        if label:
            part = part.replace(b"ITEM: NUMBER", b"ITEM: LABEL\nrow\nITEM: NUMBER")
        content += b"ITEM: UNITS\nsi\n" * (units and not step) + b"ITEM: TIME\n%g\n" % (0.5 * step) * time + part
    return content


def read_all(blocks: Sequence[Block]) -> list[Frame]:
    """The frames of blocks, one after the other."""
    return [one for block in blocks for one in dump_text.read(block, Reading(keep=frozenset({"id", "x", "y", "z", "fx"})))]


def assert_all_same(got: list[Frame], expected: list[Frame]) -> None:
    """The same frames in the same order, with all that their headers say."""
    for a, b in zip(got, expected, strict=True):
        assert (a.time, a.units, a.dialect) == (b.time, b.units, b.dialect)
        assert_same(a, b)


@given(content=files(), size=st.integers(0, 3000))
@FUZZ
def test_blocks_together_are_the_file(tmp_path: Path, content: bytes, size: int) -> None:
    """Law: whatever size is asked for, one frame or many, the blocks follow one another and hold the frames of the whole file."""
    path = tmp_path / "d.txt"
    path.write_bytes(content)
    blocks = dump_text.split(path, size)
    assert (blocks[0].start, blocks[-1].stop) == (0, None)
    assert [block.stop for block in blocks[:-1]] == [block.start for block in blocks[1:]]
    assert all(block.stop - block.start >= size for block in blocks if block.stop is not None)
    assert_all_same(read_all(blocks), read_all([Block(path)]))


@given(content=files(), data=st.data())
@FUZZ
def test_blocks_cut_at_any_byte_are_the_file(tmp_path: Path, content: bytes, data: st.DataObject) -> None:
    """Law: a block has the frames that start in it, also where it starts or stops inside a frame, a header or a line."""
    path = tmp_path / "d.txt"
    path.write_bytes(content)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(content) + 5), max_size=6)))
    blocks = [Block(path, start, stop, "si" if b"UNITS" in content else None) for start, stop in zip([0, *cuts], [*cuts, None], strict=True)]
    assert_all_same(read_all(blocks), read_all([Block(path)]))


@pytest.mark.parametrize("window", [1, 50, 1 << 20])
def test_frames_are_found_across_pieces(monkeypatch: pytest.MonkeyPatch, window: int) -> None:
    """Law: the search for a frame does not depend on how many bytes are read at a time."""
    monkeypatch.setattr(dump_text, "_WINDOW", window)
    path = DATA / "lammps" / "units.txt"
    assert [block.start for block in dump_text.split(path, 1)] == [0, *(i + 1 for i in _all(path.read_bytes(), b"\nITEM: TIME\n") if i > 100)]


def _all(content: bytes, word: bytes) -> list[int]:
    return [i for i in range(len(content)) if content.startswith(word, i)]


def test_only_plain_text_is_cut(tmp_path: Path) -> None:
    """Law: packed text and other kinds of dump are one block, read whole."""
    (tmp_path / "d.gz").write_bytes(gzip.compress((DATA / "lammps" / "all.txt").read_bytes()))
    for path in (tmp_path / "d.gz", DATA / "lammps" / "all.bin"):
        assert dump.split(path, 1) == [Block(path)]
    assert len(dump.split(DATA / "lammps" / "all.txt", 1)) == 5


def test_faults_in_a_block_have_the_line_of_the_file(tmp_path: Path) -> None:
    """Law: lines are counted from the start of the file, whichever block holds the fault; a half-written end is told as such."""
    path = tmp_path / "d.txt"
    content = b"".join(text_frame(frame(5, step), NAMES, "lammps", EXACT) for step in range(3))  # 14 lines each
    path.write_bytes(content[:-1].replace(b"\n3 1 ", b"\n3 x ").replace(b"\n3 x ", b"\n3 1 ", 1))
    blocks = dump_text.split(path, 1)
    assert len(blocks) == 3
    with pytest.raises(InputError, match=r"d\.txt:26: column type expects a number, got 'x'"):
        list(dump_text.read(blocks[1], AS_WRITTEN))
    path.write_bytes(content[:-1])
    with pytest.raises(HalfWrittenError, match=r"d\.txt:41: the file ends inside a frame: 4 of 5 rows of step 2"):
        list(dump_text.read(blocks[2], AS_WRITTEN))
    path.write_bytes(b"ITEM: TIMESTEP\nnever\n")
    assert dump_text.split(path, 1) == [Block(path)]


def test_a_file_that_shrinks_and_grows(tmp_path: Path) -> None:
    """Law: a run that starts anew while its dump is read gives an error or whole frames, never a crash; one that goes on gives what is there."""
    path = tmp_path / "d.txt"
    big, small = (text_frame(frame(n, n), NAMES, "lammps", EXACT) for n in (40_000, 3))
    path.write_bytes(big + small)
    frames = dump_text.read(Block(path), AS_WRITTEN)
    next(frames)
    with path.open("r+b") as stream:
        stream.truncate(10)
    assert [one.n for one in frames] in ([], [3])  # what has been read ahead
    path.write_bytes(small)
    frames = dump_text.read(Block(path), AS_WRITTEN)
    next(frames)
    with path.open("ab") as stream:
        stream.write(small)
    assert [one.n for one in frames] == [3]

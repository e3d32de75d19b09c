"""LIGGGHTS as Debian packages it: the program `liggghts`, linked against Open MPI."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from demverify.deck.lexer import read_text
from demverify.engines import lammps
from demverify.engines._launch import Program, clean_environment, launch
from demverify.engines.base import Engine, Found, Job, Missing, Outcome, Progress, skipped
from demverify.engines.instrument import SUPERQUADRICS

INSTALL = "apt-get install liggghts"
WITHOUT_SUPERQUADRICS = Missing("this LIGGGHTS is built without superquadrics", 'make, with USE_SUPERQUADRICS = "ON" in its MAKE/Makefile.user')
_VERSION = re.compile(r"Version LIGGGHTS-\w+ ([^,\s]+)")


class Liggghts:
    """LIGGGHTS, run under `stdbuf -oL`: it aborts before it flushes, and its error message would be lost."""

    name = "liggghts"

    def find(self) -> Found | Missing:
        """The `liggghts` on the path, when it starts."""
        program = shutil.which("liggghts")
        if program is None:
            return Missing("no program `liggghts` on the path", INSTALL)
        try:
            said = _help(program, Path(program).stat().st_mtime_ns)
        except (OSError, subprocess.SubprocessError) as error:
            said = str(error)
        version = _VERSION.search(said)
        if version is None:
            return Missing(f"{program} does not start: {said.strip().partition(chr(10))[0]}", INSTALL)
        return Found(version[1], Path(program))

    def run(self, job: Job, progress: Progress | None = None) -> Outcome:
        """Run alone, or under Open MPI's own mpirun where more than one rank is asked."""
        found = self.find()
        if not isinstance(found, Missing) and SUPERQUADRICS.search(read_text(job.deck)) and not _has_superquadrics(found.path):
            found = WITHOUT_SUPERQUADRICS
        if isinstance(found, Missing):
            return skipped(self.name, found, job)
        mpirun = shutil.which("mpirun.openmpi")
        if job.ranks > 1 and mpirun is None:
            return skipped(self.name, Missing("several ranks need Open MPI's mpirun", "apt-get install openmpi-bin"), job)
        start = (str(mpirun), "--allow-run-as-root", "--oversubscribe", "-n", str(job.ranks)) if job.ranks > 1 else ()
        stdbuf = shutil.which("stdbuf")
        unbuffered = (stdbuf, "-oL") if stdbuf else ()
        program = Program(self.name, found, (*start, *unbuffered, str(found.path)), _environment(job.folder.resolve()))
        return launch(program, job, progress)


def _has_superquadrics(program: Path) -> bool:
    """Whether the program knows the atom style."""
    styles = re.search(r"^\* Atom styles:(.*?)^\*", _help(str(program), program.stat().st_mtime_ns), re.MULTILINE | re.DOTALL)
    return styles is not None and "superquadric" in styles[1].split()


def _environment(scratch: Path) -> dict[str, str]:
    """Without MPICH's folder on the loader's path, whose libraries are not Open MPI's; and alone when run alone.

    Started without mpirun, a program has Open MPI start a daemon, in a session of its own, which outlives a killed run a while. Two
    programs started at once trip over each other in Open MPI's common folder in /tmp, so each has its own: `scratch`.
    """
    folder = lammps.library_folder()
    paths = os.environ.get("LD_LIBRARY_PATH", "").split(":")
    kept = [path for path in paths if path and (folder is None or Path(path).resolve() != folder)]
    alone = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_orte_tmpdir_base": str(scratch)}
    return {**clean_environment(), "LD_LIBRARY_PATH": ":".join(kept), **alone}


@cache
def _help(program: str, changed: int) -> str:  # changed: so that a new program is asked anew
    """What `-h` prints. Its exit status is 1 even when all is well; without `-log none` it leaves a log in the user's folder."""
    with tempfile.TemporaryDirectory() as scratch:
        done = subprocess.run(
            [program, "-log", "none", "-h"],
            env=_environment(Path(scratch)),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    return done.stdout + done.stderr


ENGINE: Engine = Liggghts()

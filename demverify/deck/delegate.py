"""Set-up commands that draw random numbers run in the LAMMPS library, in a process of its own: every engine then starts from the
same state.

The particles so far are handed over, not the deck, so this works after a `run` and for LIGGGHTS decks too. Random streams of
LAMMPS depend on seed, ids and positions only (and on the order of particles for `velocity loop local`, which is kept)."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demsolver.scene import Superquadrics
from demverify.deck.command import Command, Executed
from demverify.deck.particles import no_atoms, no_shapes, reshape
from demverify.deck.setup import Atoms, Ints, Setup
from demverify.errors import InputError

if TYPE_CHECKING:
    from demverify.deck.interpreter import Interpreter

_TIME_LIMIT = 300.0  # seconds
_REPLAYED = ("lattice", "region")  # earlier commands that a random one may lean on
_REGION_UNITS = ("block", "cylinder", "sphere")  # in LIGGGHTS their default unit is the box, in LAMMPS the lattice


def delegated(deck: Interpreter, cmd: Command) -> Atoms:
    """The particles after `cmd`, as LAMMPS makes them. Raises InputError with LAMMPS' own message when it refuses."""
    if deck.setup.atoms is not None and deck.setup.atoms.clumps is not None:
        raise cmd.error("is drawn by LAMMPS from spheres on their own: not once there are clumps")
    if deck.setup.atom_style == "superquadric" and "rotate" in cmd.args:
        raise cmd.error("does not turn superquadrics: place them with set ... x, y, z and quat")
    commands = [_as_lammps(line, deck.setup.dialect) for line in deck.executed if line.words[0] in _REPLAYED]
    commands.append(_as_lammps(deck.executed[-1], deck.setup.dialect))
    try:
        return draw(deck.setup, commands)
    except RuntimeError as error:
        raise InputError(f"LAMMPS refuses this command: {error}", cmd.place) from None


def draw(setup: Setup, commands: list[str]) -> Atoms:
    """Runs LAMMPS commands on the particles of a setup. Raises RuntimeError with the engine's message."""
    with tempfile.TemporaryDirectory() as folder:
        task: dict[str, object] = {"head": _head(setup), "groups": _ordered_groups(setup), "commands": commands}
        files = {name: str(Path(folder, f"{name}.npz")) for name in ("before", "after")}
        _save(setup, files["before"])
        _work(task | files)
        with np.load(files["after"]) as arrays:
            return _atoms(setup, {name: arrays[name] for name in arrays.files})


def _work(task: dict[str, object]) -> None:
    worker = Path(__file__).with_name("delegate_worker.py")
    try:
        arguments = [sys.executable, str(worker)]
        done = subprocess.run(arguments, input=json.dumps(task), capture_output=True, text=True, timeout=_TIME_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"no answer within {_TIME_LIMIT:g} s") from None
    if done.returncode:
        last = [line for line in done.stderr.splitlines() if line.strip()][-1:] or [f"exit status {done.returncode}"]
        raise RuntimeError(last[0])


def _head(setup: Setup) -> list[str]:
    """Commands that make the same empty box; created after all faces are known."""
    box = setup.box
    assert box is not None
    bounds = " ".join(f"{lo!r} {hi!r}" for lo, hi in zip(box.lo.tolist(), box.hi.tolist(), strict=True))
    return [
        f"units {setup.units}",
        f"dimension {setup.dimension}",
        f"boundary {' '.join(setup.boundary)}",
        "atom_style sphere",
        "atom_modify map array",
        f"region demverify_box block {bounds} units box",
        f"create_box {setup.ntypes} demverify_box",
    ]


def _as_lammps(line: Executed, dialect: str) -> str:
    """A command of either dialect in LAMMPS' words: the units are spelled out where the defaults differ."""
    words = [f'"{word}"' if any(c.isspace() for c in word) else word for word in line.words]
    scaled = words[0] in ("create_atoms", "displace_atoms", "velocity") or (words[0] == "region" and words[2] in _REGION_UNITS)
    if dialect == "liggghts" and scaled and "units" not in words:
        words += ["units", "box"]
    return " ".join(words)


def _ordered_groups(setup: Setup) -> list[str]:
    return sorted((name for name in setup.groups if name != "all"), key=lambda name: setup.groups[name])


def _translated(mask: Ints, bits: list[tuple[int, int]]) -> Ints:
    """A group mask with each bit `old` moved to `new`."""
    out = np.zeros_like(mask)
    for old, new in bits:
        out |= (mask >> old & 1) << new
    return out


def _bits(setup: Setup) -> list[tuple[int, int]]:
    """(bit in the setup, bit in LAMMPS) of every group: LAMMPS counts them in the order of their making."""
    return [(0, 0), *((setup.groups[name], k) for k, name in enumerate(_ordered_groups(setup), start=1))]


def _save(setup: Setup, path: str) -> None:
    atoms = setup.atoms or no_atoms()
    np.savez(
        path, id=atoms.id, type=atoms.type, x=atoms.x, v=atoms.v, omega=atoms.omega, radius=atoms.radius, mass=atoms.mass,
        mask=_translated(atoms.mask, _bits(setup)), image=atoms.image,
    )  # fmt: skip


def _atoms(setup: Setup, arrays: dict[str, Any]) -> Atoms:
    old = setup.atoms or no_atoms()
    molecule_of = dict(zip(old.id.tolist(), old.molecule.tolist(), strict=True))
    arrays["mask"] = _translated(arrays["mask"], [(new, bit) for bit, new in _bits(setup)])
    arrays["molecule"] = np.array([molecule_of.get(identity, 0) for identity in arrays["id"].tolist()], dtype=np.int64)
    atoms = Atoms(**arrays)
    if setup.atom_style == "superquadric":
        _shape(atoms, old)
    return atoms


def _shape(atoms: Atoms, old: Atoms) -> None:
    """Known particles keep their shapes, new ones are balls of diameter 1 and density 1, in place."""
    atoms.superquadrics = no_shapes(atoms.n)
    new = np.flatnonzero(~np.isin(atoms.id, old.id))
    reshape(atoms, new, 1.0)
    if old.superquadrics is not None and old.n:
        here = np.flatnonzero(np.isin(atoms.id, old.id))
        order = np.argsort(old.id)
        rows = order[np.searchsorted(old.id, atoms.id[here], sorter=order)]
        for f in fields(Superquadrics):
            getattr(atoms.superquadrics, f.name)[here] = getattr(old.superquadrics, f.name)[rows]

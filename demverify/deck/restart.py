"""Restart files of the native engine: the state of a run with all that its contacts remember.

One .npz archive (of any name): `header`, a JSON text with a magic word, the version of the format, the dialect and the settings that the engines
restore, and float64 or int64 arrays: box, particles, and memories of pairs and walls as demsolver.memories has them. What LAMMPS and LIGGGHTS
restore (measured): units, dimension, boundary, box, types, particles, groups, step, the pair style with its coefficients, histories of pairs and,
where a fix of the same ID and style is stated again, of walls; LAMMPS also the time step. Everything else is to be stated again. Shapes of
superquadrics come back with the particles, and the atom style with them; clumps are not kept.
"""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from demsolver.memories import Memories, WallMemory
from demsolver.scene import Box, Superquadrics
from demverify.deck.particles import ARRAYS
from demverify.deck.setup import Atoms, Dialect, Setup
from demverify.errors import InputError, Place
from demverify.formats.atomic import atomic_write

MAGIC, VERSION = "demverify restart", 1
_FOREIGN = "is not a restart file of the native engine (LAMMPS and LIGGGHTS read their own only, too)"
_SETTINGS = ("units", "dimension", "boundary", "ntypes", "groups", "pair_style", "step", "time")
_BROKEN = (
    ValueError, KeyError, TypeError, AttributeError, EOFError, SyntaxError, OverflowError, MemoryError, RuntimeError, struct.error,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What reading a foreign or damaged archive can end in; NotImplementedError is a RuntimeError."""
_PAIR = ("i", "j", "shift", "touching", "memory")
_SHAPES = tuple(f.name for f in fields(Superquadrics))


@dataclass(frozen=True)
class Restart:
    """A state to go on from. settings: those of Setup that are restored, by name. memories: None before the first run."""

    dialect: Dialect
    settings: dict[str, Any]
    box: Box
    atoms: Atoms
    memories: Memories | None


def restart_of(setup: Setup, memories: Memories | None) -> Restart:
    """The state of a deck with what its contacts remember: copies. Raises InputError where there is no box yet, and
    for particles that are not kept."""
    if setup.box is None or setup.atoms is None:
        raise InputError("write_restart needs a simulation box: create_box or read_data must come first")
    if setup.atoms.clumps is not None:
        raise InputError("write_restart keeps spheres and superquadrics, not clumps")
    settings = {name: getattr(setup, name) for name in _SETTINGS}
    settings["atom_style"] = setup.atom_style
    settings |= {"groups": dict(setup.groups), "step": int(setup.step), "time": float(setup.time)}
    settings["pair_coeffs"] = [words for words, _ in setup.pair_coeffs]
    if setup.dialect == "lammps":
        settings["timestep"] = setup.dt
    box = setup.box
    kept = Box(box.lo.copy(), box.hi.copy(), box.boundary, None if box.margin is None else np.array(box.margin, dtype=float))
    return Restart(setup.dialect, settings, kept, deepcopy(setup.atoms), memories)


def restore(setup: Setup, found: Restart, place: Place) -> None:
    """Brings the state into a setup that has no box yet. Raises InputError for a file of the other dialect."""
    if found.dialect != setup.dialect:
        raise InputError(f"the restart file is of a {found.dialect} deck, and this is a {setup.dialect} deck", place)
    s = found.settings
    setup.units, setup.dimension, setup.ntypes = s["units"], s["dimension"], s["ntypes"]
    x, y, z = s["boundary"]
    setup.boundary, setup.groups = (x, y, z), dict(s["groups"])
    setup.atom_style = s.get("atom_style", setup.atom_style)
    setup.pair_style = tuple(s["pair_style"]) if s["pair_style"] else None
    setup.pair_coeffs = [(tuple(words), place) for words in s["pair_coeffs"]]
    setup.pair_place = place if s["pair_style"] else None
    setup.timestep = s.get("timestep")  # None in LIGGGHTS: the default of the units until a timestep command
    setup.step, setup.time = s["step"], s["time"]
    setup.box, setup.memories, setup.restored = found.box, found.memories, place
    setup.atoms = deepcopy(found.atoms)


def write_restart_file(path: Path, state: Restart) -> None:
    """Writes a restart file, whole or not at all. Raises InputError where no file can come to be."""
    header = {"magic": MAGIC, "version": VERSION, "dialect": state.dialect, "settings": state.settings, "faces": state.box.boundary}
    arrays: dict[str, Any] = {"box_lo": state.box.lo, "box_hi": state.box.hi}
    if state.box.margin is not None:
        arrays["box_margin"] = state.box.margin
    arrays |= {f"atoms_{name}": getattr(state.atoms, name) for name in ARRAYS}
    if shapes := state.atoms.superquadrics:
        arrays |= {f"shapes_{name}": getattr(shapes, name) for name in _SHAPES}
    if m := state.memories:
        header |= {"pair_laws": m.laws, "walls": {name: wall.laws for name, wall in m.walls.items()}}
        arrays |= {"memory_id": m.id, "memory_rows": m.rows, "memory_tally": m.tally}
        arrays |= {f"pairs_{name}": getattr(m, name) for name in _PAIR}
        for k, wall in enumerate(m.walls.values()):
            arrays |= {f"wall{k}_memory": wall.memory, f"wall{k}_touching": wall.touching}
    with atomic_write(path) as temporary, temporary.open("wb") as out:
        np.savez(out, header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **arrays)


def newest(name: str, known: Iterable[str]) -> str | None:
    """Of the known names the one meant: a `*` stands for the largest step there is."""
    if "*" not in name:
        return name if name in known else None
    head, _, tail = name.partition("*")
    steps = {other: other[len(head) : len(other) - len(tail)] for other in known if other.startswith(head) and other.endswith(tail)}
    numbered = [other for other, step in steps.items() if step.isdecimal()]
    return max(numbered, key=lambda other: int(steps[other]), default=None)


def find_restart(name: str, folder: Path) -> Path:
    """The file in `folder` that a name means. Raises InputError when there is none."""
    path = folder / Path(name).expanduser()
    if "*" in path.name:
        found = newest(path.name, [one.name for one in path.parent.glob(path.name)])
        path = path.with_name(found) if found else path
    if not path.is_file():
        raise InputError(f"the restart file {name!r} does not exist (looked for {path}), and no write_restart came before that made it")
    return path


def read_restart_file(path: Path) -> Restart:
    """Raises InputError for a file that is not one of ours, of another version, or damaged."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            header = _header(archive, path)
            arrays = {name: archive[name] for name in archive.files if name != "header"}
        return _restart(header, arrays)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {error.strerror or error}") from error
    except _BROKEN as error:
        ours = path.read_bytes()[:4] == b"PK\x03\x04"
        raise InputError(f"{path.name} " + ("is damaged: not a whole restart file" if ours else _FOREIGN)) from error


def _header(archive: Any, path: Path) -> dict[str, Any]:
    if "header" not in archive.files:
        raise InputError(f"{path.name} {_FOREIGN}")
    header = json.loads(bytes(archive["header"]))
    if not isinstance(header, dict) or header.get("magic") != MAGIC:
        raise InputError(f"{path.name} {_FOREIGN}")
    if header.get("version") != VERSION:
        raise InputError(f"{path.name} is a restart file of version {header.get('version')}; this is demverify with version {VERSION}")
    return header


def _restart(header: dict[str, Any], arrays: dict[str, Any]) -> Restart:
    settings, memories = header["settings"], None
    if missing := {*_SETTINGS, "pair_coeffs"} - set(settings):
        raise KeyError(*missing)
    if "memory_id" in arrays:
        walls = {
            name: WallMemory(tuple(laws), arrays[f"wall{k}_memory"], arrays[f"wall{k}_touching"])
            for k, (name, laws) in enumerate(header["walls"].items())
        }
        pairs = {name: arrays[f"pairs_{name}"] for name in _PAIR}
        laws = tuple(header["pair_laws"])
        memories = Memories(arrays["memory_id"], arrays["memory_rows"], laws, **pairs, walls=walls, tally=arrays["memory_tally"])
    x, y, z = header["faces"]
    box = Box(arrays["box_lo"], arrays["box_hi"], (x, y, z), arrays.get("box_margin"))
    shapes = Superquadrics(*(arrays[f"shapes_{name}"] for name in _SHAPES)) if f"shapes_{_SHAPES[0]}" in arrays else None
    atoms = Atoms(**{name: arrays[f"atoms_{name}"] for name in ARRAYS}, superquadrics=shapes)
    return Restart(header["dialect"], settings, box, atoms, memories)

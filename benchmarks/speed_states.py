"""Where the spheres of the speed scenes start: made from a seed, or by a run of LAMMPS that is kept."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from demverify.engines.base import Job
from demverify.runs import execute

Floats = NDArray[np.float64]
Size = tuple[float, float, float]
DENSITY = 6.0 / np.pi  # a sphere of diameter 1 has mass 1, and the volume 1 / DENSITY


@dataclass(frozen=True)
class State:
    """Where spheres start. diameter: (n,); x, v, omega: (n, 3)."""

    diameter: Floats
    x: Floats
    v: Floats
    omega: Floats

    @classmethod
    def moving(cls, x: Floats, diameter: Floats | None = None, v: Sequence[float] = (0.0, 0.0, 0.0)) -> State:
        """Centres (n, 3), of diameter 1 if not given, all with one velocity."""
        return cls(np.ones(len(x)) if diameter is None else diameter, x, np.tile(v, (len(x), 1)), np.zeros((len(x), 3)))


def data_file(state: State, size: Size, title: str) -> str:
    """A data file that both engines read; the box starts at 0."""
    faces = "".join(f"0 {length!r} {axis}lo {axis}hi\n" for axis, length in zip("xyz", size, strict=True))
    rows = np.column_stack([state.diameter, np.full(len(state.x), DENSITY), state.x]).tolist()
    motion = np.hstack([state.v, state.omega]).tolist()
    atoms = [f"{i} 1 {' '.join(map(repr, row))}" for i, row in enumerate(rows, 1)]
    velocities = [f"{i} {' '.join(map(repr, row))}" for i, row in enumerate(motion, 1)]
    head = f"{title}\n\n{len(state.x)} atoms\n1 atom types\n\n{faces}"
    return "\n".join([head, "Atoms\n", *atoms, "\nVelocities\n", *velocities]) + "\n"


def jittered_grid(n: int, sides: tuple[float, float], pitch: float, rng: np.random.Generator) -> Floats:
    """(n, 3) centres on a grid as wide as `sides`, off their places by as much as spheres of diameter 1 allow."""
    columns = np.array([int(side / pitch) for side in sides])
    spacing = np.array([sides[0] / columns[0], sides[1] / columns[1], pitch])
    k = np.arange(n)
    cell = np.column_stack([k % columns[0], k // columns[0] % columns[1], k // columns.prod()])
    return (cell + 0.5) * spacing + rng.uniform(-0.5, 0.5, (n, 3)) * (spacing - 1.0)


def rough_grid(n: int, size: Floats, rng: np.random.Generator) -> Floats:
    """(n, 3) places in a box, no two nearer than 0.6 of its cells: a grid with some cells left empty, each place off its own."""
    shape = np.ceil(size * (n / size.prod()) ** (1 / 3)).astype(int)
    cells = np.sort(rng.choice(shape.prod(), n, replace=False))
    return (np.column_stack(np.unravel_index(cells, shape)) + rng.uniform(0.3, 0.7, (n, 3))) * size / shape


def scattered(n: int, side: float, rng: np.random.Generator) -> Floats:
    """(n, 3) random centres of spheres of diameter 1 in a periodic cube: whoever comes too near an earlier one is drawn again."""
    from scipy.spatial import cKDTree

    x = np.empty((0, 3))
    while len(x) < n:
        x = np.vstack([x, rng.uniform(0.0, side, (n - len(x), 3))])
        pairs = cKDTree(x, boxsize=side).query_pairs(1.0, output_type="ndarray")
        x = np.delete(x, np.unique(pairs.max(axis=1)), axis=0)
    return x


def settled(states: Path, name: str, deck: str, start: State, size: Size, steps: int) -> State:
    """What LAMMPS makes of a state in so many steps; kept in the folder `states` under a digest of all that went in.

    Raises SystemExit where LAMMPS is missing or crashed."""
    data = data_file(start, size, name)
    kept = states / f"{name}-{hashlib.sha256(f'{deck}{data}{steps}'.encode()).hexdigest()[:16]}.npz"
    if kept.is_file():
        with np.load(kept) as found:
            return State(**found)
    states.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "in.lammps"
        path.write_text(deck)
        path.with_name("data").write_text(data)
        run = execute("lammps", "lammps", Job(path, Path(folder) / "run", {"steps": [f"{steps}"], "rows": [f"{steps}"]}, steps), keep=True)
        if run.outcome.status != "ok":
            raise SystemExit(f"the state of the scene {name} needs LAMMPS: {run.outcome.reason}")
        last = run.frames[-1]
        vectors = (last.vectors(*names) for names in (("x", "y", "z"), ("vx", "vy", "vz"), ("omegax", "omegay", "omegaz")))
        state = State(2.0 * last.columns["radius"], *vectors)
    part = kept.with_suffix(f".{os.getpid()}.npz")
    np.savez(part, **vars(state))
    part.replace(kept)
    return state

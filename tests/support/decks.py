"""Tiny decks of a few spheres, the same for both engines: a data file, the engine's preamble, then the test's own lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.support.engines import EngineRun, run_lammps, run_liggghts

Vector = tuple[float, float, float]
COLUMNS = "id type x y z vx vy vz fx fy fz omegax omegay omegaz tqx tqy tqz radius mass"
HALF_BOX = 1.0


@dataclass(frozen=True)
class Ball:
    """One sphere: centre, velocity, spin, radius, density, type; any consistent units."""

    x: Vector
    v: Vector = (0.0, 0.0, 0.0)
    omega: Vector = (0.0, 0.0, 0.0)
    radius: float = 0.01
    density: float = 2500.0
    type: int = 1


@dataclass(frozen=True)
class Material:
    """LIGGGHTS properties, the same for all types: `property/global` name -> value."""

    types: int = 1
    values: dict[str, float] = field(default_factory=dict)

    def lines(self) -> str:
        """The `fix property/global` commands."""
        return "\n".join(
            f"fix m{number} all property/global {name} {self._shape(name, value)}"
            for number, (name, value) in enumerate(self.values.items())
        )

    def _shape(self, name: str, value: float) -> str:
        if name in ("youngsModulus", "poissonsRatio"):
            return "peratomtype " + " ".join([repr(value)] * self.types)
        if name == "characteristicVelocity":
            return f"scalar {value!r}"
        return f"peratomtypepair {self.types} " + " ".join([repr(value)] * self.types**2)


def _write_data(balls: Sequence[Ball], folder: Path, dimension: int) -> None:
    half = (HALF_BOX, HALF_BOX, HALF_BOX if dimension == 3 else 0.001)
    bounds = "\n".join(f"{-size!r} {size!r} {axis}lo {axis}hi" for axis, size in zip("xyz", half, strict=True))
    atoms = "\n".join(f"{n} {b.type} {2 * b.radius!r} {b.density!r} {_words(b.x)}" for n, b in enumerate(balls, 1))
    velocities = "\n".join(f"{n} {_words(b.v)} {_words(b.omega)}" for n, b in enumerate(balls, 1))
    types = max(ball.type for ball in balls)
    folder.mkdir(parents=True, exist_ok=True)
    text = f"spheres\n\n{len(balls)} atoms\n{types} atom types\n{bounds}\n\nAtoms\n\n{atoms}\n\nVelocities\n\n{velocities}\n"
    (folder / "data.spheres").write_text(text)


def _words(vector: Vector) -> str:
    return " ".join(repr(component) for component in vector)


def lammps_deck(balls: Sequence[Ball], body: str, folder: Path, *, dt: float = 1e-6, dimension: int = 3) -> str:
    """A LAMMPS deck: the balls, `body` (pair style, walls, runs ...), every step dumped in full precision to out.dump."""
    _write_data(balls, folder, dimension)
    return f"""units si
dimension {dimension}
atom_style sphere
boundary {"f f f" if dimension == 3 else "f f p"}
newton off
comm_modify vel yes
read_data data.spheres
neighbor 0.01 bin
neigh_modify delay 0
timestep {dt!r}
thermo 1
dump d all custom 1 out.dump {COLUMNS}
dump_modify d sort id format float %.17g
{body}
"""


def liggghts_deck(
    balls: Sequence[Ball], material: Material, body: str, folder: Path, *, dt: float = 1e-6, dimension: int = 3
) -> str:
    """The LIGGGHTS twin of `lammps_deck`, with the material's properties."""
    _write_data(balls, folder, dimension)
    formats = " ".join(["%d %d", *["%.17g"] * (len(COLUMNS.split()) - 2)])
    return f"""units si
dimension {dimension}
atom_style granular
atom_modify map array
boundary {"f f f" if dimension == 3 else "f f p"}
newton off
communicate single vel yes
read_data data.spheres
hard_particles yes
neighbor 0.01 bin
neigh_modify delay 0
{material.lines()}
timestep {dt!r}
thermo 1
dump d all custom 1 out.dump {COLUMNS}
dump_modify d sort id format "{formats}"
{body}
"""


def simulate_lammps(balls: Sequence[Ball], body: str, folder: Path, *, dt: float = 1e-6, dimension: int = 3) -> EngineRun:
    """Writes the LAMMPS deck of these balls in `folder` and runs it."""
    return run_lammps(lammps_deck(balls, body, folder, dt=dt, dimension=dimension), folder)


def simulate_liggghts(
    balls: Sequence[Ball], material: Material, body: str, folder: Path, *, dt: float = 1e-6, dimension: int = 3
) -> EngineRun:
    """Writes the LIGGGHTS deck of these balls in `folder` and runs it."""
    return run_liggghts(liggghts_deck(balls, material, body, folder, dt=dt, dimension=dimension), folder)

"""One state of 17 spheres of two types, plane and cylinder, as a deck for either engine: many contact laws in one process."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demsolver.reference import Key, forces
from demsolver.scene import Box, NveSphere, Particles, Scene
from demverify.deck import materials_lammps, materials_liggghts
from demverify.deck.setup import Dialect, Setup, Spec
from demverify.errors import Place
from demverify.frames import Frame
from tests.support.engines import run_lammps, run_liggghts

Floats = NDArray[np.float64]
STEPS = 12
DT = 4e-6
RING = 0.06  # radius of the cylinder about the z axis
DENSITY = (2500.0, 1800.0)
COLUMNS = "id type x y z vx vy vz fx fy fz omegax omegay omegaz tqx tqy tqz"


@dataclass(frozen=True)
class Case:
    """A contact law as deck lines: pair_style, pair_coeff, fix property/global, fix wall/gran, soft_particles."""

    name: str
    lines: tuple[str, ...]


def spheres() -> tuple[Floats, Floats, Floats, Floats, NDArray[np.int64]]:
    """x, v, omega (n, 3), radius (n,), type (n,): a cluster, a pair, spheres on the plane, at the cylinder, at both; one pair
    about to touch, one about to part, one sphere that just touches the plane."""
    rng = np.random.default_rng(7)
    radius = np.round(rng.uniform(0.004, 0.007, 17), 5)
    kind = np.array([1, 2, 1, 2, 1, 2, 1, 1, 2, 2, 1, 1, 2, 1, 2, 2, 1])
    x = np.zeros((17, 3))
    x[0] = (0.0, 0.0, 0.04)
    for k, way in enumerate(((1, 0.2, 0.1), (-1, 0.3, 0.2), (0.1, 1, -0.3), (0.2, -1, 0.4)), start=1):
        x[k] = x[0] + np.array(way) / np.linalg.norm(way) * (radius[0] + radius[k] - 1e-4 * (k + 1))
    x[5] = (0.03, 0.02, 0.03)
    x[6] = x[5] + np.array((0.6, 0.0, 0.8)) * (radius[5] + radius[6] - 3e-4)
    x[7:10] = [(0.02, -0.03, radius[7] - 1e-4), (-0.02, 0.03, radius[8] - 2e-4), (-0.03, -0.02, radius[9] - 3e-4)]
    for k, angle in ((10, 0.3), (11, 2.1), (12, 4.0), (13, 5.1)):
        off = RING - radius[k] + 1e-4 * (k - 9)
        x[k] = (off * np.cos(angle), off * np.sin(angle), 0.05 if k < 13 else radius[13] - 1.5e-4)
    x[14] = x[7] + np.array((0.0, 0.0, 1.0)) * (radius[7] + radius[14] + 1e-6)  # about to touch
    x[15] = x[8] + np.array((0.0, 0.0, 1.0)) * (radius[8] + radius[15] - 4e-6)  # about to part
    x[16] = (0.0, 0.045, radius[16])  # zero gap: a contact in LIGGGHTS, none in LAMMPS
    v = rng.uniform(-0.35, 0.35, (17, 3))
    omega = rng.uniform(-60.0, 60.0, (17, 3))
    v[14, 2], v[15, 2], v[7, 2], v[8, 2], v[16, 2] = -0.4, 0.5, 0.1, -0.1, -0.3
    return x, v, omega, radius, kind


def data_file() -> str:
    """The spheres as a LAMMPS data file (atom style sphere)."""
    x, v, omega, radius, kind = spheres()
    atoms = [f"{i + 1} {kind[i]} {float(2 * radius[i])!r} {DENSITY[kind[i] - 1]!r} {_row(x[i])}" for i in range(len(x))]
    speeds = [f"{i + 1} {_row(v[i])} {_row(omega[i])}" for i in range(len(x))]
    bounds = "\n".join(f"-0.1 0.1 {axis}lo {axis}hi" for axis in "xyz")
    lines = ["spheres", "", f"{len(x)} atoms", "2 atom types", bounds, "", "Atoms", "", *atoms, "", "Velocities", "", *speeds, ""]
    return "\n".join(lines)


def _row(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in values)


def deck(cases: Sequence[Case], dialect: Dialect) -> str:
    """All cases one after another, with `clear` in between; every step dumped to caseNNN.dump."""
    head = HEAD[dialect]
    formats = 'format float "%.17g"' if dialect == "lammps" else f'format "%d %d {" ".join(["%.17g"] * 15)}"'
    texts = []
    for number, case in enumerate(cases):
        tail = (
            f"fix n all nve/sphere\ntimestep {DT!r}\ndump d all custom 1 case{number:03d}.dump {COLUMNS}\n"
            f"dump_modify d sort id {formats}\nthermo {STEPS}\nrun {STEPS}\n"
        )
        texts.append("\n".join([head, *case.lines, tail]))
    return "clear\n".join(texts)


HEAD: dict[Dialect, str] = {
    "lammps": "units si\natom_style sphere\nboundary f f f\nnewton off\ncomm_modify vel yes\nread_data data.spheres\n"
    "neighbor 0.01 bin\nneigh_modify delay 0",
    "liggghts": "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\n"
    "read_data data.spheres\nneighbor 0.01 bin\nneigh_modify delay 0",
}


def run(cases: Sequence[Case], dialect: Dialect, folder: Path) -> list[list[Frame]]:
    """Per case the frames of steps 0 to STEPS, from one process of the engine in an empty folder."""
    (folder / "data.spheres").write_text(data_file())
    engine = run_lammps if dialect == "lammps" else run_liggghts
    frames = engine(deck(cases, dialect), folder).frames
    assert len(frames) == len(cases) * (STEPS + 1)
    return [list(frames[k : k + STEPS + 1]) for k in range(0, len(frames), STEPS + 1)]


def setup_of(lines: Sequence[str], dialect: Dialect, ntypes: int = 2) -> Setup:
    """What the deck's interpreter would hand to the mapping for these lines."""
    setup = Setup(dialect, units="si", boundary=("ff", "ff", "ff"), ntypes=ntypes)
    for number, line in enumerate(lines, start=1):
        words, place = line.split(), Place(Path("in.case"), number)
        if words[0] == "pair_style":
            setup.pair_style, setup.pair_place = tuple(words[1:]), place
        elif words[0] == "pair_coeff":
            setup.pair_coeffs.append((tuple(words[1:]), place))
        elif words[0] == "fix":
            setup.fixes[words[1]] = Spec(words[1], words[2], words[3], tuple(words[4:]), place)
        else:
            setattr(setup, words[0], words[1] == "yes")
    return setup


def scene_of(case: Case, dialect: Dialect) -> Scene:
    """The scene of a case, through the mapping under test."""
    setup = setup_of(case.lines, dialect)
    mapping = materials_lammps if dialect == "lammps" else materials_liggghts
    x, v, omega, radius, kind = spheres()
    n = len(x)
    mass = 4.0 * np.pi / 3.0 * radius**3 * np.array(DENSITY)[kind - 1]
    particles = Particles(np.arange(1, n + 1), kind, x, v, omega, radius, mass, np.ones(n, int), np.zeros((n, 3), int))
    return Scene(
        box=Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff")),
        particles=particles,
        ntypes=2,
        timestep=DT,
        pair=mapping.pair_law(setup),
        walls=mapping.walls(setup),
        integrate=(NveSphere(),),
        history_outlives_contact=dialect == "liggghts",
    )


def change_pair(**changes: Any) -> Callable[[Scene], Scene]:
    """Exchanges fields of a scene's pair law."""

    def change(scene: Scene) -> Scene:
        assert scene.pair
        return replace(scene, pair=replace(scene.pair, **changes))

    return change


def change_cylinder(**changes: Any) -> Callable[[Scene], Scene]:
    """Exchanges fields of the shape of a scene's last wall."""

    def change(scene: Scene) -> Scene:
        *others, last = scene.walls
        return replace(scene, walls=(*others, replace(last, shape=replace(last.shape, **changes))))

    return change


@dataclass(frozen=True)
class Difference:
    """Largest |difference| of forces and of torques against an engine, over the largest force and torque of the step."""

    force_0: float
    torque_0: float
    force: float
    torque: float

    @property
    def worst(self) -> float:
        """The largest of the four."""
        return max(self.force_0, self.torque_0, self.force, self.torque)


def difference(scene: Scene, frames: Sequence[Frame]) -> Difference:
    """The brute-force sum on a trajectory of its own against an engine's frames: step 0, and the worst of the later steps."""
    found = [
        (_relative(frame, "fx fy fz", force), _relative(frame, "tqx tqy tqz", torque))
        for frame, (force, torque) in zip(frames, _trajectory(scene, len(frames) - 1), strict=True)
    ]
    return Difference(*found[0], max(f for f, _ in found[1:]), max(t for _, t in found[1:]))


def _relative(frame: Frame, columns: str, ours: Floats) -> float:
    theirs = frame.vectors(*columns.split())
    assert np.isfinite(ours).all()
    assert np.isfinite(theirs).all()
    largest = np.abs(theirs).max()
    return float(np.abs(ours - theirs).max() / largest) if largest else float(np.abs(ours).max())


def _trajectory(scene: Scene, steps: int) -> list[tuple[Floats, Floats]]:
    """Force and torque at steps 0 to `steps`; contacts of step n see velocities of step n - 1/2, of step 0 the full ones."""
    p = scene.particles
    x, v, omega = p.x.copy(), p.v.copy(), p.omega.copy()
    half = 0.5 * scene.timestep
    kick, spin = half / p.mass[:, None], half / (0.4 * p.mass * p.radius**2)[:, None]
    history: dict[Key, Floats] = {}
    force, torque, history = forces(scene, x, v, omega, history, False)
    found = [(force, torque)]
    for _ in range(steps):
        v, omega = v + kick * force, omega + spin * torque
        x = x + scene.timestep * v
        force, torque, history = forces(scene, x, v, omega, history, True)
        v, omega = v + kick * force, omega + spin * torque
        found.append((force, torque))
    return found

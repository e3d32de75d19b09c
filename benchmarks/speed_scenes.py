"""The scenes of `speed.py`: each a LAMMPS deck and the LIGGGHTS deck of the same scene, with their data files, made from a seed.

chute: the bench of LAMMPS of that name, 32,000 spheres flowing. bed: 8,000 spheres, sizes 0.5 to 1, rain onto a floor, half of them
settled. gas: 20,000 equal spheres, frictionless and elastic, at a volume fraction of 0.15; also with friction. column: 50,000 equal
spheres, packed, creeping between walls. sphere: one, bouncing. Units lj throughout: diameter 1, mass 1, gravity 1; time steps are a
thirtieth to a seventieth of a contact (of the one sphere less); skins those with which LAMMPS is fastest.

States that need a run (bed, column) are made by LAMMPS, so that they do not hang on the solver that is measured, and kept.
A deck asks for the variables `steps` and `rows` (steps between lines of thermo), and prints c_kin, c_rot and c_top, the mean height.
"""

from __future__ import annotations

import gzip
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.speed_states import DENSITY, Floats, Size, State, data_file, jittered_grid, rough_grid, scattered, settled

CHUTE_DATA = Path(__file__).parent / "data" / "data.chute.gz"
MADE = "made by benchmarks/speed_scenes.py"


@dataclass(frozen=True)
class Scene:
    """What is measured. steps: of a timed run; every: of them, between the frames that are compared.

    n: particles. decks: "lammps", "liggghts", and for the gas "lammps-friction" -> text. data: file name -> text. skin, size of the box,
    periodic (per axis): as in the decks. columns: quantity -> thermo column, of those that are compared.
    """

    name: str
    title: str
    steps: int
    every: int
    decks: Mapping[str, str]
    data: Mapping[str, str]
    n: int
    skin: float
    size: Size
    periodic: tuple[bool, bool, bool]
    columns: Mapping[str, str]

    def write(self, folder: Path) -> dict[str, Path]:
        """Writes decks and data; deck name -> its path. Besides the decks above: the LAMMPS deck with its OpenMP styles, 1 and 2 threads."""
        folder.mkdir(parents=True, exist_ok=True)
        omp = {f"lammps-omp{threads}": f"package omp {threads}\nsuffix omp\n{self.decks['lammps']}" for threads in (1, 2)}
        for name, text in self.data.items():
            (folder / name).write_text(text)
        decks = {**self.decks, **omp}
        for name, text in decks.items():
            (folder / f"in.{name}").write_text(text)
        return {name: folder / f"in.{name}" for name in decks}

    def pairs(self, x: Floats, diameter: Floats) -> tuple[int, int]:
        """How many pairs of centres (n, 3) are within the skin, which any list must hold, and how many touch. Frozen ones with each other too."""
        from scipy.spatial import cKDTree

        size = np.where(self.periodic, self.size, 4.0 * np.array(self.size) + 4.0)
        inside = np.where(self.periodic, x % size, x - x.min(axis=0))
        i, j = cKDTree(inside, boxsize=size).query_pairs(diameter.max() + self.skin, output_type="ndarray").T
        apart = inside[i] - inside[j]
        gap = np.linalg.norm(apart - size * np.round(apart / size), axis=1) - 0.5 * (diameter[i] + diameter[j])
        return int((gap < self.skin).sum()), int((gap < 0.0).sum())


LAMMPS = """\
units lj
atom_style sphere
boundary {boundary}
processors {grid}
newton off
comm_modify vel yes
read_data {data}
"""
LIGGGHTS = """\
units lj
atom_style granular
atom_modify map array
boundary {boundary}
processors {grid}
newton off
communicate single vel yes
read_data {data}
"""
LISTS = """\
pair_coeff * *
neighbor {skin} bin
neigh_modify every 1 delay 0
timestep {dt}
"""
MOTION = """\
fix down all gravity 1.0 vector 0.0 0.0 -1.0
fix move all nve/sphere
"""
CHUTE = """\
group bottom type 2
group active subtract all bottom
neigh_modify exclude group bottom bottom
fix 1 all gravity 1.0 chute 26.0
fix 2 bottom freeze
fix 3 active nve/sphere
"""
OUTPUT = """\
compute kin all ke
compute rot all erotate/sphere
compute top all reduce ave z
thermo_style custom step atoms c_kin c_rot c_top
thermo_modify norm no format float %.15g
thermo ${rows}
run ${steps}
"""
ENERGIES = {"ke": "c_kin", "erotate": "c_rot"}
HEIGHT = ENERGIES | {"com_z": "c_top"}


def heads(boundary: str, grid: str = "* * *") -> tuple[str, str]:
    """The beginnings of both decks."""
    return LAMMPS.format(boundary=boundary, grid=grid, data="data"), LIGGGHTS.format(boundary=boundary, grid=grid, data="data")


def springs(kn: float, gamma: float, mu: float, types: int = 1, gamma_t: float | None = None) -> str:
    """What LAMMPS calls `kn NULL gamma NULL mu`, for LIGGGHTS: kt = 2/7 kn, tangential damping half of the normal one if not given."""
    values = {"kn": kn, "kt": kn * 2 / 7, "gamman": gamma, "gammat": 0.5 * gamma if gamma_t is None else gamma_t, "coefficientFriction": mu}
    rows = {name: " ".join([repr(value)] * types**2) for name, value in values.items()}
    return "".join(f"fix {name} all property/global {name} peratomtypepair {types} {row}\n" for name, row in rows.items())


def chute(_states: Path, *, small: bool) -> Scene:
    """The data of the bench; small: a part of it, without the spheres that would overlap those at its other end."""
    head, _, body = gzip.decompress(CHUTE_DATA.read_bytes()).decode().partition("Atoms")
    atoms, velocities = ([line.split() for line in part.split("\n") if line.strip()] for part in body.split("Velocities"))
    size = (40.0, 20.0, 37.2886)
    if small:
        size = (10.0, 10.0, 37.2886)
        atoms = [row for row in atoms if all(0.5 <= float(place) <= 9.5 for place in row[4:6])]
        kept = {row[0] for row in atoms}
        velocities = [row for row in velocities if row[0] in kept]
        head = f"a part of the chute\n\n{len(atoms)} atoms\n2 atom types\n\n0 10 xlo xhi\n0 10 ylo yhi\n0 37.2886 zlo zhi\n\n"
    parts = {"lammps": atoms, "liggghts": [row[:7] for row in atoms]}  # LIGGGHTS reads no image flags here
    data = {f"data.{name}": f"{head}Atoms\n\n{_lines(rows)}\nVelocities\n\n{_lines(velocities)}" for name, rows in parts.items()}
    rest = LISTS.format(skin=0.1, dt=1e-4) + CHUTE + OUTPUT
    ours = LAMMPS.format(boundary="p p fs", grid="* * 1", data="data.lammps") + "pair_style gran/hooke/history 200000.0 NULL 50.0 NULL 0.5 0\n"
    theirs = LIGGGHTS.format(boundary="p p fm", grid="* * 1", data="data.liggghts") + springs(200000.0, 50.0, 0.5, 2, 0.0)
    decks = {"lammps": ours + rest, "liggghts": f"{theirs}pair_style gran model hooke/stiffness tangential history\n{rest}"}
    title = "flow down a rough chute, gran/hooke/history"
    return Scene("chute", title, 1000, 200, decks, data, len(atoms), 0.1, size, (True, True, False), HEIGHT)


def _lines(rows: list[list[str]]) -> str:
    return "".join(" ".join(row) + "\n" for row in rows)


def bed(states: Path, *, small: bool) -> Scene:
    """Falls at once: a jittered grid that moves down already; made when the shock has gone through half of it."""
    n, side = (800, 7.0) if small else (8000, 16.0)
    kn, gamma, mu, rng = 4.0e6, 5000.0, 0.5, np.random.default_rng(51)
    diameter = rng.uniform(0.5, 1.0, n)
    x = jittered_grid(n, (side, side), 1.08, rng)
    size = (side, side, float(np.ceil(x[:, 2].max() + 2.0)))
    ours, theirs = heads("p p f", "* * 1")
    rest = LISTS.format(skin=0.2, dt=1e-4) + MOTION
    floor = f"fix floor all wall/gran granular hertz {kn} {gamma} tangential mindlin {kn * 2 / 7} 0.5 {mu} damping viscoelastic zplane 0.0 NULL\n"
    their_law = f"{springs(kn, gamma, mu)}pair_style gran model hertz/stiffness tangential history\n"
    their_floor = "fix floor all wall/gran model hertz/stiffness tangential history primitive type 1 zplane 0.0\n"
    decks = {
        "lammps": f"{ours}pair_style gran/hertz/history {kn} NULL {gamma} NULL {mu} 1\n{rest}{floor}{OUTPUT}",
        "liggghts": f"{theirs}{their_law}{rest}{their_floor}{OUTPUT}",
    }
    start = settled(states, "bed", decks["lammps"], State.moving(x, diameter, (0.0, 0.0, -8.0)), size, 13_000 if small else 25_000)
    data = {"data": data_file(start, size, f"spheres, half of them settled; {MADE}")}
    return Scene("bed", "sizes 0.5 to 1 rain onto a floor, gran/hertz/history", 1500, 100, decks, data, n, 0.2, size, (True, True, False), HEIGHT)


def gas(_states: Path, *, small: bool) -> Scene:
    """Scattered at random without overlap, Maxwellian, of no momentum."""
    n = 2000 if small else 20_000
    kn, rng = 1e5, np.random.default_rng(52)
    side = float((n / DENSITY / 0.15) ** (1 / 3))
    v = rng.normal(0.0, 1.0, (n, 3))
    start = State(np.ones(n), scattered(n, side, rng), v - v.mean(axis=0), np.zeros((n, 3)))
    ours, theirs = heads("p p p")
    rubbing = f"pair_style gran/hooke/history {kn} NULL 0.0 NULL 0.5 0\n"
    rest = LISTS.format(skin=0.2, dt=np.pi * np.sqrt(0.5 / kn) / 30) + "fix move all nve/sphere\n" + OUTPUT
    decks = {
        "lammps": f"{ours}pair_style gran/hooke {kn} NULL 0.0 NULL 0.0 0\n{rest}",
        "lammps-friction": f"{ours}{rubbing}{rest}",
        "lammps-friction-field": f"{ours}{rubbing}fix none all gravity 0.0 vector 0.0 0.0 -1.0\n{rest}",
        "liggghts": f"{theirs}{springs(kn, 0.0, 0.0)}pair_style gran model hooke/stiffness tangential off\n{rest}",
    }
    size = (side, side, side)
    data = {"data": data_file(start, size, f"a dilute gas; {MADE}")}
    return Scene("gas", "dilute, elastic, frictionless, gran/hooke", 2000, 200, decks, data, n, 0.2, size, (True, True, True), ENERGIES)


def column(states: Path, *, small: bool) -> Scene:
    """Packed and put between walls, then left to gravity for 4,000 steps."""
    n, side = (2000, 6.0) if small else (50_000, 20.0)
    kn, gamma, mu = 2e5, 100.0, 0.5
    ours, theirs = heads("f f f", "1 1 *")
    rest = LISTS.format(skin=0.1, dt=1e-4) + MOTION
    law = f"granular hooke {kn} {gamma} tangential linear_history {kn * 2 / 7} 0.5 {mu} damping mass_velocity"
    walls = "".join(f"fix {axis} all wall/gran {law} {axis}plane 0.0 {end}\n" for axis, end in (("x", side), ("y", side), ("z", "NULL")))
    their_law = f"{springs(kn, gamma, mu)}pair_style gran model hooke/stiffness tangential history\n"
    planes = ("xplane 0.0", f"xplane {side}", "yplane 0.0", f"yplane {side}", "zplane 0.0")
    their_walls = "".join(
        f"fix w{k} all wall/gran model hooke/stiffness tangential history primitive type 1 {plane}\n" for k, plane in enumerate(planes)
    )
    decks = {
        "lammps": f"{ours}pair_style gran/hooke/history {kn} NULL {gamma} NULL {mu} 1\n{rest}{walls}{OUTPUT}",
        "liggghts": f"{theirs}{their_law}{rest}{their_walls}{OUTPUT}",
    }
    x = packed(states, n, side)
    size = (side, side, float(np.ceil(x[:, 2].max() + 1.0)))
    start = settled(states, "column", decks["lammps"], State.moving(x), size, 4_000)
    data = {"data": data_file(start, size, f"a column of spheres; {MADE}")}
    return Scene("column", "packed, creeping between walls, gran/hooke/history", 300, 100, decks, data, n, 0.1, size, (False, False, False), HEIGHT)


def packed(states: Path, n: int, side: float) -> Floats:
    """(n, 3) centres between walls, on a floor: ten equal blocks, each pushed apart from a rough grid, as dense as where it jams."""
    blocks, corner = 10, np.array([0.5, 0.5, 0.0])
    one = n // blocks + n // 500
    size = np.array([side, side, one / DENSITY / (0.626 - 0.34 / side) / side**2])  # looser along walls
    walls = "".join(
        f"fix {axis} all wall/gran granular hooke 2e5 100.0 tangential linear_nohistory 0.0 0.0 {axis}plane 0.0 {side}\n" for axis in "xy"
    )
    pushed = f"pair_style gran/hooke 2e5 NULL 100.0 NULL 0.0 0\n{LISTS.format(skin=0.1, dt=1e-4)}{walls}"
    deck = f"{heads('f f p')[0]}{pushed}fix drag all viscous 30.0\nfix move all nve/limit 0.005\n{OUTPUT}"
    start = State.moving(corner + rough_grid(one, size - 2.0 * corner, np.random.default_rng(53)))
    block = settled(states, "block", deck, start, (side, side, float(size[2])), 3_000)
    x = np.vstack([block.x + np.array([0.0, 0.0, k * size[2]]) for k in range(blocks)])
    x = x[x[:, 2] > 0.5]
    return x[np.argsort(x[:, 2], kind="stable")[:n]]


def sphere(_states: Path, *, small: bool) -> Scene:
    """Meets the floor within the first steps, then again and again, a fiftieth slower each time.

    Damped, and a contact is 440 steps: with short undamped ones the part of a step at which it lands, and so rounding, decides its path."""
    kn, gamma, size = 5e3, 0.9, (4.0, 4.0, 4.0)
    ours, theirs = heads("f f f")
    rest = LISTS.format(skin=0.1, dt=1e-4) + MOTION
    floor = f"fix floor all wall/gran granular hooke {kn} {gamma} tangential linear_nohistory 0.0 0.0 damping mass_velocity zplane 0.0 NULL\n"
    their_law = f"{springs(kn, gamma, 0.0)}pair_style gran model hooke/stiffness tangential off\n"
    their_floor = "fix floor all wall/gran model hooke/stiffness tangential off primitive type 1 zplane 0.0\n"
    decks = {
        "lammps": f"{ours}pair_style gran/hooke {kn} NULL {gamma} NULL 0.0 0\n{rest}{floor}{OUTPUT}",
        "liggghts": f"{theirs}{their_law}{rest}{their_floor}{OUTPUT}",
    }
    data = {"data": data_file(State.moving(np.array([[2.0, 2.0, 0.501]]), v=(0.0, 0.0, -1.0)), size, f"one sphere; {MADE}")}
    steps = 20_000 if small else 1_000_000
    return Scene("sphere", "bouncing on a floor", steps, steps // 100, decks, data, 1, 0.1, size, (False, False, False), HEIGHT)


SCENES: dict[str, Callable[..., Scene]] = {"chute": chute, "bed": bed, "gas": gas, "column": column, "sphere": sphere}

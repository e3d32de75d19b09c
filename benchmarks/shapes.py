"""How fast superquadrics and clumps are: `python benchmarks/shapes.py [--rounds 5] [--json FILE] [--quick]`.

dense   60 superquadrics settle in a box of five planes, 3,000 steps, tests/data/superquadric/decks/in.dense. A LIGGGHTS built with superquadrics
needed 0.089 ms a step on a machine on which LAMMPS' bench chute ran at 12.1 million particle-steps a second. Both figures are taken anew here, in
        turns, and the native step is held against what LIGGGHTS' step would be here, in proportion.
box     1,000 superquadrics of six shapes that have settled in a box: time of a step, contacts counted, time for each that touches.
clumps  1,000 clumps of four spheres, and 4,000 such spheres on their own, settled in the same box, by turns: rate of a member over that of a sphere.
law     the box again with the contact point by growth, over the one by equal potentials, by turns.

A ratio is the median of its rounds.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.guard import ready, seconds_of
from benchmarks.speed_run import Contender, measure
from benchmarks.speed_scenes import chute as chute_scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from demsolver import Scene, Simulation

    Floats = NDArray[np.float64]

DENSE = Path(__file__).parents[1] / "tests/data/superquadric/decks/in.dense"
LIGGGHTS_MS, CHUTE_RATE = 0.089, 12.1e6
KINDS = ((2.0, 2.0), (4.0, 4.0), (8.0, 2.0), (6.0, 3.0), (3.0, 2.0), (2.5, 3.5))
LEAST_CLUMPS = 0.7
GRAVITY, RADIUS = 9.81, 0.01


def chute(folder: Path) -> float:
    """LAMMPS' rate on its bench chute, particle-steps a second."""
    scene = chute_scene(folder, small=False)
    one = Contender("LAMMPS", "lammps", "lammps")
    return measure(one, one.job(scene.write(folder / "chute"), folder / "run", scene)).rate


def dense(steps: int) -> float:
    """Milliseconds a native step of the deck takes, its loop compiled before."""
    from demsolver import Simulation
    from demverify.runs import plan

    scene = plan(DENSE, {}).runs[0].scene
    ready(scene).advance(2)
    simulation = Simulation(scene)
    simulation.setup()
    return 1e3 * seconds_of(simulation, steps) / steps


def box(count: int, seed: int = 1) -> Scene:
    """So many superquadrics, on a grid, about to fall."""
    from demsolver import Particles
    from demsolver.scene import NveSuperquadric, Superquadrics
    from demsolver.shapes.superquadric import inertia_per_mass, volume
    from demsolver.superquadric import bounding_radius

    rng = np.random.default_rng(seed)
    axes, blockiness = rng.uniform(0.02, 0.028, (count, 3)), np.array(KINDS)[np.arange(count) % len(KINDS)]
    quat = rng.normal(size=(count, 4))
    quat /= np.linalg.norm(quat, axis=1)[:, None]
    mass, radius = 2500.0 * volume(axes, blockiness), bounding_radius(axes, blockiness)
    x, edge = _grid(count, 2.1 * radius.max())
    shapes = Superquadrics(axes, blockiness, quat, mass[:, None] * inertia_per_mass(axes, blockiness), np.zeros((count, 3)))
    particles = Particles(
        id=np.arange(1, count + 1), type=np.ones(count, dtype=np.int64), x=x, v=np.tile([0.0, 0.0, -0.8], (count, 1)), omega=np.zeros((count, 3)),
        radius=radius, mass=mass, mask=np.ones(count, dtype=np.int64), image=np.zeros((count, 3), dtype=np.int64), superquadrics=shapes,
    )  # fmt: skip
    return _in_box(particles, edge, 1e-4, 0.004, (NveSuperquadric(),))


def spheres(count: int, *, clumped: bool, seed: int = 1) -> Scene:
    """So many clumps of four spheres, or as many spheres on their own, about to fall."""
    from demsolver import NveSphere, Particles
    from demsolver.scene import Clumps, NveClumps
    from demsolver.shapes.rotation import to_space
    from demsolver.shapes.union import sum_of_spheres

    rng, n = np.random.default_rng(seed), 4 * count
    offset = 0.6 * RADIUS * np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    quat = rng.normal(size=(count, 4))
    quat /= np.linalg.norm(quat, axis=1)[:, None]
    body = np.repeat(np.arange(count), 4)
    middle, edge = _grid(count, 6.5 * RADIUS)
    mass = 2500.0 * 4.0 / 3.0 * np.pi * RADIUS**3
    solid = sum_of_spheres(offset, np.full(4, RADIUS))
    down = np.array([0.0, 0.0, -0.8])
    clumps = Clumps(
        body=body, offset=np.tile(offset, (count, 1)), id=np.arange(1, count + 1), x=middle, v=np.tile(down, (count, 1)), quat=quat,
        angmom=np.zeros((count, 3)), omega=np.zeros((count, 3)), mass=np.full(count, 4.0 * mass),
        inertia=np.tile(2500.0 * np.diag(solid.inertia), (count, 1)), mask=np.ones(count, dtype=np.int64),
    )  # fmt: skip
    spread = 1.0 if clumped else 2.0
    x = middle[body] + spread * to_space(quat[body], clumps.offset)
    particles = Particles(
        id=np.arange(1, n + 1), type=np.ones(n, dtype=np.int64), x=x, v=np.tile(down, (n, 1)),
        omega=np.zeros((n, 3)), radius=np.full(n, RADIUS), mass=np.full(n, mass), mask=np.ones(n, dtype=np.int64),
        image=np.zeros((n, 3), dtype=np.int64), clumps=clumps if clumped else None,
    )  # fmt: skip
    return _in_box(particles, edge, 2e-5, 0.3 * RADIUS, (NveClumps(),) if clumped else (NveSphere(),))


def _grid(count: int, apart: float) -> tuple[Floats, Floats]:
    """Places (n, 3), twice as many layers as there are rows, and the edges (3,) of the box."""
    rows = int(np.ceil((count / 2.0) ** (1.0 / 3.0)))
    layers = -(-count // rows**2)
    steps = np.indices((layers, rows, rows)).reshape(3, -1)[::-1, :count].T
    return apart * (steps + 0.5), apart * np.array([rows, rows, layers + 1.0])


def _in_box(particles: object, edge: Floats, dt: float, skin: float, integrate: tuple[object, ...]) -> Scene:
    """Walls on five sides, gravity, springs with friction and restitution 0.6."""
    from demsolver import Box, ContactLaw, Gravity, Neighbor, Scene, Slab, Wall

    springs = {"kn": 4e4, "gamman": 2000.0, "shear_stiffness": 1e4, "gammat": 0.0, "mu": 0.4}
    law = ContactLaw(
        "hooke", "mass_velocity", "constant", "mass", "liggghts_history", {name: np.array([[value]]) for name, value in springs.items()},
        surface_arm="contact", torque_arm="contact",
    )  # fmt: skip
    wall = replace(law, coefficients={name: table[0] for name, table in law.coefficients.items()})
    walls = (*(Wall(f"side{axis}", Slab(axis, 0.0, float(edge[axis])), wall) for axis in (0, 1)), Wall("floor", Slab(2, 0.0), wall))
    whole = Box(-0.1 * edge, 1.1 * edge, ("ff", "ff", "ff"))
    return Scene(whole, particles, 1, dt, law, walls, (Gravity((0.0, 0.0, -GRAVITY)),), integrate, Neighbor(skin))  # type: ignore[arg-type]


def settled(scene: Scene, falls: float) -> Simulation:
    """After so many times the fall through the box."""
    simulation = ready(scene)
    height = float(np.asarray(scene.box.hi)[2] - np.asarray(scene.box.lo)[2])
    simulation.advance(int(falls * np.sqrt(2.0 * height / GRAVITY) / scene.timestep))
    return simulation


def touching(simulation: Simulation) -> tuple[int, int]:
    """Pairs that touch, and particles at walls."""
    return int((simulation.pairs.touching & 1).sum()), sum(int(wall[-1].sum()) for wall in simulation._walls)


def main(words: Sequence[str] | None = None) -> int:
    """Measures, prints, and returns 1 where a promise is not kept."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--quick", action="store_true", help="boxes a tenth in size, one round, no chute: to see that all works")
    asked = parser.parse_args(words)
    rounds, count, falls = (1, 100, 0.3) if asked.quick else (asked.rounds, 1000, 1.5)
    found: dict[str, float] = {}
    if not asked.quick:
        found |= _dense(rounds)
    found |= _box(count, falls, rounds) | _clumps(count, falls, rounds)
    if asked.json:
        asked.json.write_text(json.dumps(found))
    return int(found.get("dense_proportion", 0.0) > 1.0 or found["clump_rate"] < LEAST_CLUMPS)


def _dense(rounds: int) -> dict[str, float]:
    with TemporaryDirectory() as folder:
        turns = [(chute(Path(folder) / f"{k}"), dense(3000)) for k in range(rounds)]
    rate, ms = median(rate for rate, _ in turns), median(ms for _, ms in turns)
    share = median(ms / (LIGGGHTS_MS * CHUTE_RATE / rate) for rate, ms in turns)
    print(f"dense: {ms:.4f} ms a step, LAMMPS chute {rate / 1e6:.2f} M particle-steps/s: {share:.2f} of LIGGGHTS' step in proportion", flush=True)
    return {"dense_ms": ms, "chute_rate": rate, "dense_proportion": share}


def _box(count: int, falls: float, rounds: int) -> dict[str, float]:
    steps = 200
    plain = settled(box(count), falls)
    gauge = ready(replace(box(count), particles=plain.particles(), contact_point="gauge"))
    gauge.advance(steps)
    turns = [(seconds_of(plain, steps), seconds_of(gauge, steps)) for _ in range(rounds)]
    ms, ratio = 1e3 * median(a for a, _ in turns) / steps, median(b / a for a, b in turns)
    pairs, walls = touching(plain)
    each = 1e3 * ms / (pairs + walls)
    what = f"{count} superquadrics, {pairs} pair and {walls} wall contacts"
    print(f"box: {what}: {ms:.3f} ms a step, {each:.2f} us a contact; by growth {ratio:.2f} of that", flush=True)
    return {"box_ms": ms, "box_pairs": pairs, "box_walls": walls, "gauge_ratio": ratio}


def _clumps(count: int, falls: float, rounds: int) -> dict[str, float]:
    steps = 200
    clumps, free = (settled(spheres(count, clumped=clumped), falls) for clumped in (True, False))
    turns = [(seconds_of(clumps, steps), seconds_of(free, steps)) for _ in range(rounds)]
    ratio = median(b / a for a, b in turns)
    (a, wa), (b, wb) = touching(clumps), touching(free)
    print(
        f"clumps: {4 * count} members ({a} pair and {wa} wall contacts) at {ratio:.2f} of the rate of as many free spheres ({b}, {wb})", flush=True,
    )  # fmt: skip
    return {"clump_rate": ratio, "clump_pairs": a, "sphere_pairs": b}


if __name__ == "__main__":
    sys.exit(main())

"""How time and memory grow with the number of particles, with sizes, and what mixed precision gives: `python benchmarks/scale.py [N ...]`.

A slightly loosened crystal of equal spheres under gravity between periodic sides, with friction and history, 10,000, 100,000 and 1,000,000 by default
(3 minutes, 1 GB), each in a process of its own. Printed: nanoseconds a particle and step, of steps alone and with the renewals of the neighbour
list that a flow of this speed needs; contacts a particle; bytes a particle at the peak, beyond those of a run of 1,000. The same in mixed
precision, with the largest error of a force relative to the largest force. Then settled beds of equal spheres and of sizes up to ten to one: what a
contact costs.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np

ROOT = Path(__file__).parents[1]
SIZES = (10_000, 100_000, 1_000_000)
BEDS = {"equal": (1.0,), "two sizes, 10:1": (10.0, 1.0), "four sizes, 10:1": (10.0, 4.64, 2.15, 1.0)}
RADIUS, STEP = 0.005, 1e-5


def crystal(n: int):
    """The scene: cubic layers, 1/4 as wide as high, jittered by a hundredth of a radius, moving by some mm/s."""
    from demsolver import Box, ContactLaw, Gravity, Neighbor, NveSphere, Particles, Scene, Slab, Wall

    rng = np.random.default_rng(1)
    side = max(3, round((n / 4) ** (1 / 3)))
    pitch = 1.996 * RADIUS
    k = np.arange(n)
    x = (np.column_stack([k % side, k // side % side, k // side**2]) + 0.5) * pitch + rng.uniform(-0.01, 0.01, (n, 3)) * RADIUS
    one = np.ones(n)
    mass = 2500.0 * 4.0 / 3.0 * np.pi * RADIUS**3 * one
    count = np.arange(1, n + 1)
    flags = np.ones(n, dtype=int)
    p = Particles(count, flags, x, rng.normal(0, 5e-3, (n, 3)), np.zeros((n, 3)), RADIUS * one, mass, flags, np.zeros((n, 3), dtype=int))

    def law(shape: tuple[int, ...]) -> ContactLaw:
        values = {"kn": 1e4, "gamman": 400.0, "shear_stiffness": 3e3, "xt": 0.5, "mu": 0.4}
        return ContactLaw("hooke", "mass_velocity", "constant", "scaled", "classic_history", {name: v * np.ones(shape) for name, v in values.items()})

    box = Box(np.zeros(3), np.array([side * pitch, side * pitch, 1e3]), ("pp", "pp", "ff"))
    return Scene(
        box, p, 1, STEP, pair=law((1, 1)), walls=(Wall("floor", Slab(2, lo=0.0), law((1,))),), forces=(Gravity((0.0, 0.0, -9.81)),),
        integrate=(NveSphere(),), neighbor=Neighbor(0.001),
    )  # fmt: skip


def bed(radii: tuple[float, ...], n: int = 20_000):
    """As much volume of each size (radii in mm), the larger first, each on a lattice of its own where nothing larger is, to be settled by 30 g."""
    from scipy.spatial import cKDTree

    from demsolver import Box, Gravity, Neighbor

    rng = np.random.default_rng(1)
    share = n / sum(1 / r**3 for r in radii) * 1e-9
    side = (4 / 3 * np.pi * share * len(radii) / 0.62) ** (1 / 3)
    x, radius = np.zeros((0, 3)), np.zeros(0)
    for r in (r * 1e-3 for r in radii):
        cells = int(side / (1.998 * r))
        sites = (np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), -1).reshape(-1, 3) + 0.5) * side / cells
        sites = (sites + rng.uniform(-0.5, 0.5, sites.shape) * max(0.0, side / cells - 2 * r)) % side
        free = np.ones(len(sites), dtype=bool)
        for larger in np.unique(radius):
            free &= cKDTree(x[radius == larger], boxsize=side).query(sites)[0] > 0.998 * (larger + r)
        sites = rng.permutation(sites[free])[: round(share / r**3)]
        x, radius = np.vstack([x, sites]), np.append(radius, np.full(len(sites), r))
    scene, order = crystal(len(x)), rng.permutation(len(x))
    mass = 2500.0 * 4.0 / 3.0 * np.pi * radius**3
    particles = replace(scene.particles, x=x[order], radius=radius[order], mass=mass[order], v=np.zeros_like(x))
    return replace(
        scene, particles=particles, box=Box(np.zeros(3), np.array([side, side, 2 * side]), ("pp", "pp", "ff")),
        timestep=float(np.pi * np.sqrt(mass.min() / 2 / 1e4) / 25), neighbor=Neighbor(2e-4), forces=(Gravity((0.0, 0.0, -300.0)),),
    )  # fmt: skip


def measure_bed(name: str) -> dict[str, float]:
    """Nanoseconds a contact and step, lists included, of a settled bed."""
    from demsolver import Simulation

    simulation = Simulation(bed(BEDS[name]))
    simulation.setup()
    simulation.advance(20_000)
    times = []
    for _ in range(5):
        began = time.perf_counter()
        simulation.advance(400)
        times.append((time.perf_counter() - began) / 400 * 1e9)
    touching = int((simulation._pairs.touching & 1).sum())
    return {"n": len(simulation.id), "contacts": touching / len(simulation.id), "contact": median(times) / touching}


def peak_bytes() -> int:
    """The most memory this process has held."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) * 1024


def measure(n: int, precision: str) -> dict[str, float]:
    """Of one size, in this process."""
    from demsolver import Simulation

    small = Simulation(crystal(1000), precision=precision)  # type: ignore[arg-type]
    small.setup()
    small.advance(5)
    base = peak_bytes()
    simulation = Simulation(crystal(n), precision=precision)  # type: ignore[arg-type]
    simulation.setup()
    steps = max(20, 2_000_000 // n)
    simulation.advance(steps)
    times, lists = [], []
    for _ in range(5):
        began = time.perf_counter()
        simulation.advance(steps)
        times.append((time.perf_counter() - began) / steps / n * 1e9)
        began = time.perf_counter()
        simulation._relist()
        lists.append((time.perf_counter() - began) / n * 1e9)
    held = peak_bytes() - base
    touching = int((simulation._pairs.touching & 1).sum())
    return {"step": median(times), "list": median(lists), "contacts": touching / n, "pairs": len(simulation._pairs.partner) / n, "bytes": held / n}


def force_error(n: int = 10_000) -> float:
    """Largest error of a force in mixed precision at set-up, over the largest force."""
    from demsolver import Simulation

    forces = []
    for precision in ("double", "mixed"):
        simulation = Simulation(crystal(n), precision=precision)  # type: ignore[arg-type]
        simulation.setup()
        forces.append(simulation.bodies.force)
    return float(np.abs(forces[1] - forces[0]).max() / np.abs(forces[0]).max())


def main(sizes: list[int]) -> None:
    """Measures each size in a process of its own and prints a table."""
    print("       n  precision  ns/step  contacts  pairs  ns/list  bytes")
    for n in sizes:
        for precision in ("double", "mixed"):
            found = _apart("--one", str(n), precision)
            step, contacts, pairs, listing, held = (found[name] for name in ("step", "contacts", "pairs", "list", "bytes"))
            print(f"{n:8d}  {precision:9s} {step:8.1f} {contacts:9.2f} {pairs:6.2f} {listing:8.0f} {held:6.0f}", flush=True)
    print(f"mixed precision: forces off by up to {force_error():.1e} of the largest")
    for name in BEDS:
        found = _apart("--bed", name)
        print(f"bed, {name}: {found['n']} spheres, {found['contacts']:.2f} contacts each, {found['contact']:.1f} ns a contact and step", flush=True)


def _apart(*words: str) -> dict[str, float]:
    """What this file finds in a process of its own."""
    done = subprocess.run([sys.executable, __file__, *words], check=True, capture_output=True, text=True, cwd=ROOT)
    found: dict[str, float] = json.loads(done.stdout)
    return found


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measure(int(sys.argv[2]), sys.argv[3])))
    elif sys.argv[1:2] == ["--bed"]:
        print(json.dumps(measure_bed(sys.argv[2])))
    else:
        main([int(word) for word in sys.argv[1:]] or list(SIZES))

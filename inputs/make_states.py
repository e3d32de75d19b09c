"""Makes the particle states of the case folders: `python inputs/make_states.py bed silo chute gas loose`. Their data files are what the decks read.

bed: 1,000 spheres of two types dropped into a periodic column, settled, then given small random velocities, so that contacts also
slide and roll. silo: the same spheres in a cylinder of radius 0.05 m about the z axis.
chute: 10,000 spheres settled on a frozen rough base, then flowing down 24 degrees until the flow is developed.
gas: 200 spheres in a periodic box, for the bench. loose: 225 in layers that fall together, for the bench.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.progress import track

from demsolver import (
    Box,
    ContactLaw,
    Cylinder,
    Freeze,
    Gravity,
    Neighbor,
    NveSphere,
    Particles,
    Scene,
    Simulation,
    Slab,
    Wall,
)  # fmt: skip

HERE = Path(__file__).parent


def law(shape: tuple[int, ...], kn: float, gamma_n: float, mu: float) -> ContactLaw:
    """The law of LAMMPS gran/hooke/history with kt = 2/7 kn and gamma_t = gamma_n / 2."""
    one = np.ones(shape)
    values = {"kn": kn * one, "gamman": gamma_n * one, "shear_stiffness": 2 / 7 * kn * one, "xt": 0.5 * one, "mu": mu * one}
    return ContactLaw("hooke", "mass_velocity", "constant", "scaled", "classic_history", values)


def loose(n: int, columns: tuple[int, int], length: tuple[float, float], radius: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Jittered grid (n, 3) without overlaps, `columns` spheres wide."""
    k = np.arange(n)
    pitch = np.array([length[0] / columns[0], length[1] / columns[1], 2.05 * radius.max()])
    cell = np.column_stack([k % columns[0], k // columns[0] % columns[1], k // (columns[0] * columns[1])])
    room = np.maximum(0.0, 0.5 * pitch - radius.max())
    return (cell + 0.5) * pitch + rng.uniform(-1, 1, (n, 3)) * room


def particles(x: np.ndarray, radius: np.ndarray, kind: np.ndarray, density: float) -> Particles:
    """Particles at rest; group 1 holds those of type 2."""
    n = len(x)
    mass = density * 4 / 3 * np.pi * radius**3
    mask = 1 | ((kind == 2).astype(int) << 1) | ((kind == 1).astype(int) << 2)
    return Particles(np.arange(1, n + 1), kind, x, np.zeros((n, 3)), np.zeros((n, 3)), radius, mass, mask, np.zeros((n, 3), int))


def run(simulation: Simulation, steps: int, what: str, parts: int = 100) -> None:
    """Advance with a progress bar."""
    simulation.setup()
    for _ in track(range(parts), what):
        simulation.advance(steps // parts)


def write(path: Path, p: Particles, density: float, lengths: tuple[float, float, float], digits: int, title: str, lo: float = 0.0) -> None:
    """A data file both engines read (no image flags); its digits define the state. lo: lower bound of the box in x and y."""
    f = f"%.{digits}g"
    head = f"{title}\n\n{len(p.id)} atoms\n{p.type.max()} atom types\n\n" + "".join(
        f"{low:g} {low + length:g} {axis}lo {axis}hi\n" for axis, low, length in zip("xyz", (lo, lo, 0), lengths, strict=True)
    )
    atoms = [" ".join([f"{i} {t}", *(f % c for c in (d, density, *x))]) for i, t, d, x in zip(p.id, p.type, 2 * p.radius, p.x)]
    motion = [" ".join([f"{i}", *(f % c for c in (*v, *w))]) for i, v, w in zip(p.id, p.v, p.omega)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(head + "\nAtoms\n\n" + "\n".join(atoms) + "\n\nVelocities\n\n" + "\n".join(motion) + "\n")


def make_bed() -> None:
    """SI units: radii 4 to 7 mm, 2500 kg/m3, kn 1e4 N/m, a column of 0.1 m by 0.1 m."""
    rng = np.random.default_rng(20061)
    n, width = 1000, 0.1
    radius = rng.uniform(0.004, 0.007, n).round(6)
    p = particles(loose(n, (7, 7), (width, width), radius, rng), radius, rng.integers(1, 3, n), 2500.0)
    scene = Scene(
        Box(np.zeros(3), np.array([width, width, 0.4]), ("pp", "pp", "ff")), p, 2, 1e-5, pair=law((2, 2), 1e4, 400.0, 0.2),
        walls=(Wall("floor", Slab(2, lo=0.0), law((2,), 1e4, 400.0, 0.2)),), forces=(Gravity((0.0, 0.0, -9.81)),),
        integrate=(NveSphere(),), neighbor=Neighbor(0.002),
    )  # fmt: skip
    simulation = Simulation(scene)
    run(simulation, 150_000, "bed settles")
    stir(simulation, rng)
    title = "1,000 settled polydisperse spheres, given small random velocities; made by inputs/make_states.py"
    write(HERE / "bed" / "bed.data", simulation.particles(), 2500.0, (width, width, 0.4), 9, title)


def make_silo() -> None:
    """The law, sizes and density of the bed; a cylinder of radius 0.05 m on the floor, in an open box."""
    rng = np.random.default_rng(20062)
    n, lengths = 1000, (0.12, 0.12, 0.4)
    radius = rng.uniform(0.004, 0.007, n).round(6)
    x = loose(n, (4, 4), (0.066, 0.066), radius, rng) - (0.033, 0.033, 0.0)
    pair, wall = law((2, 2), 1e4, 400.0, 0.2), law((2,), 1e4, 400.0, 0.2)
    scene = Scene(
        Box(np.array([-0.06, -0.06, 0.0]), np.array([0.06, 0.06, 1.0]), ("ff", "ff", "ff")),
        particles(x, radius, rng.integers(1, 3, n), 2500.0), 2, 1e-5, pair=pair,
        walls=(Wall("floor", Slab(2, lo=0.0), wall), Wall("side", Cylinder(2, (0.0, 0.0), 0.05, "curved"), wall)),
        forces=(Gravity((0.0, 0.0, -9.81)),), integrate=(NveSphere(),), neighbor=Neighbor(0.002),
    )  # fmt: skip
    simulation = Simulation(scene)
    run(simulation, 200_000, "silo settles")
    stir(simulation, rng)
    title = "1,000 polydisperse spheres settled in a cylinder of radius 0.05, given small random velocities; made by inputs/make_states.py"
    write(HERE / "bed" / "silo.data", simulation.particles(), 2500.0, lengths, 9, title, -0.06)


def stir(simulation: Simulation, rng: np.random.Generator) -> None:
    """Reports the settled state, then gives it small random velocities."""
    b = simulation.bodies
    print(f"speed {np.abs(b.v).max():.1e} m/s, height {b.x[:, 2].max():.3f} m, {(simulation.pairs.touching & 1).sum()} contacts")
    b.v[:] = rng.normal(0.0, 0.02, b.v.shape)
    b.omega[:] = rng.normal(0.0, 5.0, b.v.shape)


def make_chute() -> None:
    """lj units: diameters 0.9 to 1.1, density 6/pi, kn 2e5, a base of 20 by 10."""
    rng = np.random.default_rng(2002)
    n, lengths, density = 10_000, (20.0, 10.0, 60.0), 1.9099
    radius = rng.uniform(0.45, 0.55, n).round(4)
    x = loose(n, (18, 9), lengths[:2], radius, rng)
    settle = Scene(
        Box(np.zeros(3), np.array([*lengths[:2], 100.0]), ("pp", "pp", "ff")), particles(x, radius, np.ones(n, int), density), 1, 1e-4,
        pair=law((1, 1), 2e5, 100.0, 0.5), walls=(Wall("floor", Slab(2, lo=0.0), law((1,), 2e5, 100.0, 0.5)),),
        forces=(Gravity((0.0, 0.0, -1.0)),), integrate=(NveSphere(),), neighbor=Neighbor(0.2),
    )  # fmt: skip
    falling = Simulation(settle)
    run(falling, 150_000, "chute settles")
    x = falling.bodies.x.copy()
    kind = np.where(x[:, 2] < 1.2, 2, 1)
    tilt = np.radians(24.0)
    flow = Scene(
        Box(np.zeros(3), np.array(lengths), ("pp", "pp", "ff")), particles(x, radius, kind, density), 2, 1e-4,
        pair=law((2, 2), 2e5, 50.0, 0.5), forces=(Gravity((float(np.sin(tilt)), 0.0, -float(np.cos(tilt)))), Freeze(1)),
        integrate=(NveSphere(2),), neighbor=Neighbor(0.1, exclude=((1, 1),)),
    )  # fmt: skip
    flowing = Simulation(flow)
    run(flowing, 100_000, "chute flows")
    print(f"mean speed {np.linalg.norm(flowing.bodies.v, axis=1).mean():.2f}, height {flowing.bodies.x[:, 2].max():.1f}, frozen {(kind == 2).sum()}")
    title = "10,000 spheres flowing down a rough base (type 2, to be frozen); made by inputs/make_states.py"
    write(HERE / "chute" / "chute.data", flowing.particles(), density, lengths, 7, title)


def make_gas() -> None:
    """200 spheres of 10 mm at random in a periodic box of 70 mm, none nearer than 1 % of a diameter, 0.2 m/s each way and no momentum."""
    rng = np.random.default_rng(1)
    n, radius, length = 200, 0.005, 0.07
    x: list[np.ndarray] = []
    while len(x) < n:
        new = rng.uniform(0.0, length, 3)
        if all(np.linalg.norm((new - old + length / 2) % length - length / 2) > 2.02 * radius for old in x):
            x.append(new)
    v = rng.normal(0.0, 0.2, (n, 3))
    p = replace(particles(np.array(x), np.full(n, radius), np.ones(n, int), 2500.0), v=v - v.mean(axis=0))
    title = "200 spheres at random in a periodic box, with Maxwell's velocities and no momentum; made by inputs/make_states.py"
    write(HERE / "bench" / "elastic-gas" / "gas.data", p, 2500.0, (length,) * 3, 9, title)


def make_loose() -> None:
    """225 spheres of 9 to 11 mm over a floor of 60 mm each way, at rest."""
    rng = np.random.default_rng(3)
    n, length = 225, 0.06
    radius = rng.uniform(0.0045, 0.0055, n).round(5)
    p = particles(loose(n, (5, 5), (length, length), radius, rng), radius, np.ones(n, int), 2500.0)
    title = "225 spheres in loose layers, at rest; made by inputs/make_states.py"
    write(HERE / "bench" / "settling-bed" / "loose.data", p, 2500.0, (length, length, 0.12), 9, title)


if __name__ == "__main__":
    for name in sys.argv[1:] or ["bed", "silo", "chute", "gas", "loose"]:
        {"bed": make_bed, "silo": make_silo, "chute": make_chute, "gas": make_gas, "loose": make_loose}[name]()

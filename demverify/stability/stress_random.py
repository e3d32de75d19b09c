"""Random scenes: whatever is drawn, a run ends finite, with energy and momentum within their bounds, or it is refused or warned.

A Draw is a row of plain numbers, so that a property-based generator can make and shrink it; `scene_of` makes the scene. Few combinations of laws
and features are drawn (the loop is compiled for each), but everything else that a scene has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from demsolver import ContactLaw, Scene, Simulation
    from demsolver.scene import Particles
    from demverify.frames import Floats

Laws = Literal["hooke", "hertz"]
LAWS: tuple[Laws, ...] = ("hooke", "hertz")
RADIUS, DENSITY = 0.005, 2500.0
STEPS = 300
GROWN = 1.0
"""Of the kinetic and elastic energy that a run starts with, and of what gravity has given since: more growth must have been told (guard.GROWTH)."""
MOST_RATIO = 30.0
"""Of sizes: neighbour cells and cost stay small."""


@dataclass(frozen=True)
class Draw:
    """One scene. seed: of places and directions. count: spheres. law: of pairs and walls. periodic: all axes, without walls and gravity; else six
    walls and gravity. ratio: largest over smallest radius; heavier: the same of densities. stiffness: force of a contact an overlap of a radius
    deep [N]. damping: gamma over the critical one of a contact. friction. speed: of the spheres, in smallest radii a step. spin: surface speed in
    the same measure. step: over the limit of the lightest contact. filling: how close the spheres start, 1: as on a grid that just
    holds them; above: they overlap."""

    seed: int
    count: int
    law: Laws
    periodic: bool
    ratio: float
    heavier: float
    stiffness: float
    damping: float
    friction: float
    speed: float
    spin: float
    step: float
    filling: float


@dataclass(frozen=True)
class Ran:
    """What became of a draw. outcome: stayed, refused, warned, lied or crashed. message: what was said, or what is wrong. growth: of the energy, over
    what it may grow by; drift: of momentum, over its rounding; NaN where not measured."""

    draw: Draw
    outcome: str
    message: str
    growth: float
    drift: float


def draws(count: int, seed: int, laws: Sequence[Laws] = LAWS) -> list[Draw]:
    """So many draws, from safe to absurd: numbers over decades."""
    rng = np.random.default_rng(seed)
    return [_draw(rng, laws) for _ in range(count)]


def _draw(rng: np.random.Generator, laws: Sequence[Laws]) -> Draw:
    def decades(low: float, high: float) -> float:
        return float(10.0 ** rng.uniform(low, high))

    return Draw(
        seed=int(rng.integers(2**31)), count=int(rng.integers(2, 41)), law=laws[int(rng.integers(len(laws)))], periodic=bool(rng.integers(2)),
        ratio=float(MOST_RATIO ** rng.uniform(0.0, 1.0)), heavier=decades(0.0, 3.0), stiffness=decades(-2.0, 8.0),
        damping=float(rng.uniform(0.0, 2.0)), friction=decades(-2.0, 2.0), speed=decades(-6.0, 0.5), spin=decades(-6.0, 1.0),
        step=decades(-2.5, 0.7), filling=float(rng.uniform(0.5, 1.3)),
    )  # fmt: skip


def scene_of(draw: Draw) -> Scene:
    """The scene of a draw."""
    from demsolver import Box, Gravity, Neighbor, NveSphere, Scene, Slab, Wall

    rng = np.random.default_rng(draw.seed)
    radius = RADIUS * draw.ratio ** -rng.uniform(0.0, 1.0, draw.count)
    mass = DENSITY * draw.heavier ** rng.uniform(0.0, 1.0, draw.count) * 4.0 / 3.0 * pi * radius**3
    x, size = _places(rng, radius, draw.filling)
    lightest = 0.5 * float(mass.min())
    kn = draw.stiffness / float(radius.min()) if draw.law == "hooke" else draw.stiffness / float(radius.min()) ** 2
    spring = kn if draw.law == "hooke" else kn * float(radius.min())
    dt = draw.step * 2.0 * sqrt(lightest / spring)
    pace = float(radius.min()) / dt
    gamma = draw.damping * 2.0 * sqrt(spring / lightest)
    p = _particles(rng, x, radius, mass, draw.speed * pace, draw.spin * pace)
    faces = "pp" if draw.periodic else "ff"
    room = np.zeros(3) if draw.periodic else size
    walls = () if draw.periodic else tuple(Wall(f"{'xyz'[a]} walls", Slab(a, 0.0, float(size[a])), _law(draw, kn, gamma, (1,))) for a in range(3))
    forces = () if draw.periodic else (Gravity((0.0, 0.0, -9.81)),)
    return Scene(
        Box(-room, size + room, (faces,) * 3), p, 1, dt, pair=_law(draw, kn, gamma, (1, 1)), walls=walls, forces=forces, integrate=(NveSphere(),),
        neighbor=Neighbor(0.2 * float(radius.min())),
    )  # fmt: skip


def _places(rng: np.random.Generator, radius: Floats, filling: float) -> tuple[Floats, Floats]:
    """Near a grid, in any order, as far within it as the room allows; (n, 3), and the size of the box (3,)."""
    side = max(2, int(np.ceil(len(radius) ** (1.0 / 3.0))))
    pitch = 2.0 * float(radius.max()) / filling
    cells = rng.permutation(side**3)[: len(radius)]
    grid = np.stack(np.unravel_index(cells, (side,) * 3), axis=1).astype(float)
    jitter = np.maximum(0.5 * pitch - radius, 0.0)[:, None] * rng.uniform(-1.0, 1.0, (len(radius), 3))
    return (grid + 0.5) * pitch + jitter, np.full(3, side * pitch)


def _particles(rng: np.random.Generator, x: Floats, radius: Floats, mass: Floats, speed: float, surface: float) -> Particles:
    from demsolver import Particles

    n = len(x)
    v, omega = (rng.normal(0.0, 1.0, (n, 3)) / sqrt(3.0) for _ in range(2))
    return Particles(
        np.arange(1, n + 1), np.ones(n, int), x, speed * v, surface * omega / radius[:, None], radius, mass, np.ones(n, int), np.zeros((n, 3), int)
    )


def _law(draw: Draw, kn: float, gamma: float, shape: tuple[int, ...]) -> ContactLaw:
    from demsolver import ContactLaw

    values = {"kn": kn, "gamman": gamma, "shear_stiffness": 2.0 / 7.0 * kn, "xt": 0.5, "mu": draw.friction}
    tangential = "constant" if draw.law == "hooke" else "mindlin"
    return ContactLaw(
        draw.law, "mass_velocity", tangential, "scaled", "classic_history", {name: np.full(shape, value) for name, value in values.items()}
    )


def try_draw(draw: Draw, steps: int = STEPS) -> Ran:
    """Runs a draw and says what became of it. Never raises for what the scene or the solver does."""
    from demsolver import LostParticles, Simulation, Unstable
    from demsolver.stability_watch import StepWatch

    said: list[str] = []
    scene = scene_of(draw)
    try:
        simulation = Simulation(scene, tell=said.append)
        simulation.setup()
        StepWatch(said.append).look(simulation)
        start, carried = _energy(scene, simulation), _momentum(simulation)
        simulation.advance(steps)
        simulation.look()
    except (Unstable, LostParticles, ValueError) as error:
        return Ran(draw, "refused", f"{error}", np.nan, np.nan)
    except Exception as error:  # noqa: BLE001 (a traceback is an outcome here)
        return Ran(draw, "crashed", f"{type(error).__name__}: {error}", np.nan, np.nan)
    return _judged(draw, said, (start, _energy(scene, simulation)), (carried, _momentum(simulation)), steps)


def _judged(
    draw: Draw, said: Sequence[str], energies: tuple[tuple[float, float], tuple[float, float]], momenta: tuple[tuple[Floats, float], ...], steps: int
) -> Ran:
    (lively, high), (lively_now, high_now) = energies
    allowed = GROWN * lively + abs(high - high_now) * (1.0 + GROWN) + 1e-9 * (abs(high) + abs(high_now))
    growth = (lively_now + high_now - lively - high) / allowed if allowed > 0.0 else lively_now
    (before, size), (after, size_now) = momenta
    rounding = 1e-15 * steps * draw.count * max(size, size_now)
    drift = float(np.abs(after - before).max()) / rounding if draw.periodic and rounding > 0.0 else 0.0
    wrong = [] if growth <= 1.0 else [f"the energy grew by {growth:.3g} of what it may"]
    wrong += [] if drift <= 1.0 else [f"momentum drifted by {drift:.3g} roundings"]
    if not wrong:
        return Ran(draw, "stayed", "; ".join(said), growth, drift)
    return Ran(draw, "warned" if said else "lied", "; ".join([*wrong, *said]), growth, drift)


def _energy(scene: Scene, simulation: Simulation) -> tuple[float, float]:
    """Kinetic and normal elastic energy; that in the field. By numpy alone, not by the solver's own account."""
    from demsolver import Slab

    p, size = simulation.particles(), np.asarray(scene.box.hi) - np.asarray(scene.box.lo)
    kinetic = 0.5 * float(p.mass @ (p.v**2).sum(axis=1) + 0.4 * (p.mass * p.radius**2) @ (p.omega**2).sum(axis=1))
    i, j = np.triu_indices(len(p.id), 1)
    apart = p.x[i] - p.x[j]
    if scene.box.periodic[0]:
        apart -= size * np.round(apart / size)
    overlap = p.radius[i] + p.radius[j] - np.linalg.norm(apart, axis=1)
    assert scene.pair is not None
    elastic = _springs(scene.pair, overlap, p.radius[i] * p.radius[j] / (p.radius[i] + p.radius[j]))
    for wall in scene.walls:
        assert isinstance(wall.shape, Slab)
        for face in (wall.shape.lo, wall.shape.hi):
            elastic += _springs(wall.law, p.radius - np.abs(p.x[:, wall.shape.axis] - face), p.radius)
    return kinetic + elastic, float(9.81 * p.mass @ p.x[:, 2]) if scene.walls else 0.0


def _springs(law: ContactLaw, overlap: Floats, radius: Floats) -> float:
    kn, deep = float(law.coefficients["kn"].flat[0]), np.maximum(overlap, 0.0)
    return float((0.5 * kn * deep**2 if law.normal == "hooke" else 0.4 * kn * np.sqrt(radius) * deep**2.5).sum())


def _momentum(simulation: Simulation) -> tuple[Floats, float]:
    """(3,), and the sum of its sizes."""
    p = simulation.particles()
    return np.asarray(p.mass @ p.v), float(p.mass @ np.linalg.norm(p.v, axis=1)) or inf

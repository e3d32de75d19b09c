"""Scenes held in contact, a little disturbed: does the disturbance grow at a step, or stay what it was?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from demsolver import Box, ContactLaw, EulerSphere, Gravity, LostParticles, Neighbor, NveSphere, Particles, Scene, Simulation, Slab, Unstable, Wall
from demverify.frames import Floats

KN, RADIUS, OVERLAP, DENSITY = 1e4, 5e-3, 1e-5, 2500.0
MASS = DENSITY * 4 / 3 * np.pi * RADIUS**3
HELD = KN * OVERLAP / MASS
"""Acceleration that keeps one sphere of MASS pressed OVERLAP deep into a linear contact."""
NUDGE = 1e-8
"""Of the overlap in a step: grows a thousandfold and more before the contact opens."""
SLIGHT, LIGHTLY = 1e-8, 1e-5
"""Overlap of spheres in a row, and the part of it that a disturbance is. A row pressed at its ends buckles, at a rate of the square root of the
force, for which no step is to blame: in 2,000 steps by a few times with these."""
DISTURBANCE = 1e-6
"""m/s, in packings: a millionth of the overlaps in a step."""
GROWN = 1e3
"""A disturbance grows so many times or it holds. Below its limit an undamped mode swells up to 1/sqrt(1 - K/4) times, which is 22 times at
a thousandth below, and K = 4 times that is its force."""
STEPS = 2000
"""At the limit of a spring a step is half an oscillation: 1,000 oscillations."""
INTEGRATORS: dict[str, tuple[NveSphere, ...] | tuple[EulerSphere, ...]] = {"velocity Verlet": (NveSphere(),), "semi-implicit Euler": (EulerSphere(),)}


def spheres(x: Floats, radius: Floats, *, v: Floats | None = None, omega: Floats | None = None, density: float = DENSITY) -> Particles:
    """Particles of one type; (n, 3) positions, (n,) radii."""
    n = len(x)
    zero = np.zeros((n, 3))
    mass = density * 4 / 3 * np.pi * radius**3
    numbers = np.arange(1, n + 1), np.ones(n, dtype=int)
    motion = zero if v is None else v, zero if omega is None else omega
    return Particles(*numbers, x, *motion, radius, mass, np.ones(n, dtype=int), np.zeros((n, 3), int))


def linear(shape: tuple[int, ...], *, gamman: float = 0.0, kt: float = 0.0, xt: float = 0.0, mu: float = 1e6, **names: str) -> ContactLaw:
    """Linear springs and dashpots; with this mu a contact never slips."""
    values = {"kn": KN, "gamman": gamman, "shear_stiffness": kt, "xt": xt, "mu": mu}
    chosen = {"damping": "mass_velocity", "tangential_stiffness": "constant", "tangential_damping": "scaled", "friction": "classic_history"} | names
    return ContactLaw("hooke", **chosen, coefficients={name: np.full(shape, value) for name, value in values.items()})  # type: ignore[arg-type]


def pair(dt: float, law: ContactLaw, *, along: float = 0.0, across: float = 0.0, overlap: float = OVERLAP, pull: float = HELD) -> Scene:
    """Two equal spheres pressed together along x by opposite forces; disturbed along x and along y."""
    p = spheres(np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]) * (RADIUS - 0.5 * overlap), np.full(2, RADIUS))
    p.v[:] = np.array([[along, across, 0.0], [-along, -across, 0.0]])
    p = replace(p, mask=np.array([1 | 2, 1 | 4]))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    held = (Gravity((pull, 0.0, 0.0), 1), Gravity((-pull, 0.0, 0.0), 2))
    return Scene(box, p, 1, dt, pair=law, walls=floors(law), forces=held, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


def on_floor(dt: float, law: ContactLaw, *, along: float = 0.0, across: float = 0.0, overlap: float = OVERLAP, pull: float = HELD) -> Scene:
    """A sphere pressed onto a floor; disturbed along z and along x. law: of a wall. The pair law is the same, for one compiled loop."""
    p = spheres(np.array([[0.0, 0.0, RADIUS - overlap]]), np.array([RADIUS]), v=np.array([[across, 0.0, along]]))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    table = {name: np.broadcast_to(value, (1, 1)).copy() for name, value in law.coefficients.items()}
    held = (Gravity((0.0, 0.0, -pull), 0), Gravity((0.0, 0.0, 0.0), 1))
    walls = (Wall("floor", Slab(2, lo=0.0), law),)
    return Scene(box, p, 1, dt, pair=replace(law, coefficients=table), walls=walls, forces=held, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


def floors(law: ContactLaw) -> tuple[Wall, ...]:
    """A floor far below, of the same law."""
    return (Wall("floor", Slab(2, lo=-0.09), at_wall(law)),)


def at_wall(law: ContactLaw) -> ContactLaw:
    """The law of pairs of type 1 as that of a wall."""
    return replace(law, coefficients={name: np.ravel(table)[:1] for name, table in law.coefficients.items()})


def chain(dt: float, law: ContactLaw, v: float = 0.0, *, overlap: float = SLIGHT) -> Scene:
    """Two unequal spheres pressed between two walls; disturbed at random. law: of pairs."""
    radius = np.array([1.0, 0.8]) * RADIUS
    first = radius[0] - overlap
    x = np.array([[first, 0.0, 0.0], [first + radius.sum() - overlap, 0.0, 0.0]])
    walls = (Wall("ends", Slab(0, 0.0, x[1, 0] + radius[1] - overlap), at_wall(law)),)
    rng = np.random.default_rng(7)
    p = spheres(x, radius, v=v * rng.normal(size=x.shape), omega=v / RADIUS * rng.normal(size=x.shape))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    return Scene(box, p, 1, dt, pair=law, walls=walls, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))


def packing(x: Floats, radius: Floats, size: float, dt: float, law: ContactLaw, v: float = 0.0) -> Scene:
    """Spheres in a periodic cube, disturbed at random."""
    rng = np.random.default_rng(7)
    p = spheres(x, radius, v=v * rng.normal(size=x.shape), omega=v / RADIUS * rng.normal(size=x.shape))
    return Scene(Box(np.zeros(3), np.full(3, size)), p, 1, dt, pair=law, integrate=(NveSphere(),), neighbor=Neighbor(2e-4))


@cache
def relaxed(n: int) -> tuple[Floats, Floats, float]:
    """Positions, radii and box of n unequal spheres pressed together by some 5 % of their radius, at rest."""
    rng = np.random.default_rng(3)
    radius = rng.uniform(0.8, 1.2, n) * RADIUS
    size = float(np.cbrt(4 / 3 * np.pi * (radius**3).sum() / 0.72))
    law = linear((1, 1), gamman=1500.0, mu=0.0)
    scene = packing(rng.uniform(0, size, (n, 3)), radius, size, 2e-5, law)
    for dt, steps in ((2e-5, 500), (1.2e-4, 3500)):  # forces that are left: 1e-8 of those in the contacts
        # they start at random, deep in one another
        simulation = Simulation(replace(scene, timestep=dt), on_instability="off")
        simulation.setup()
        simulation.advance(steps)
        scene = replace(scene, particles=simulation.particles())
    return scene.particles.x, radius, size


@dataclass(frozen=True)
class Growth:
    """size: largest change of any force or torque since the start, as the way it makes in a step, over the way that the disturbance makes in one: a
    few for springs that hold; inf when the run ended in nonsense. each_step: factor of a step, 1 or more, at the end: of a disturbance that grows,
    the spectral radius."""

    size: float
    each_step: float


def grown(scene: Scene, steps: int = STEPS, *, swings_only: bool = False) -> Growth:
    """Runs a held scene until the disturbance has grown GROWN times, or so many steps. (Ways themselves may grow without harm: a ball rolls on.)

    swings_only: of forces only what flips from step to step counts, as it does where a step is too long (an eigenvalue below -1): a quarter of the
    second difference in time. The run also ends, and counts as holding, when the rest has changed by GROWN: for spheres that do not stay where they
    are held by themselves, as a row that buckles."""
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    p = scene.particles
    first = scene.timestep * max(np.abs(p.v).max(), (p.radius[:, None] * np.abs(p.omega)).max())
    with np.errstate(divide="ignore"):  # points do not turn
        per_torque = np.where(p.radius > 0.0, scene.timestep**2 / (0.4 * p.mass * p.radius), 0.0)
    ways = np.column_stack([np.repeat(scene.timestep**2 / p.mass[:, None], 3, axis=1), np.repeat(per_torque[:, None], 3, axis=1)]) / first
    start = _ways(simulation, ways)
    size, before, drift, done, pause = 0.0, 0.0, 0.0, 0, 0
    while done < steps and size <= GROWN and drift <= GROWN:
        before, pause = size, 0 if done < 20 else 8  # the fastest grow a thousandfold in a few steps
        try:
            simulation.advance(pause)
            a = _ways(simulation, ways)
            simulation.advance(1)
            b = _ways(simulation, ways)
            simulation.advance(1)
            c = _ways(simulation, ways)
        except (Unstable, LostParticles):
            return Growth(np.inf, np.inf)
        done += pause + 2
        if swings_only:
            drift = float(np.abs((a + 2.0 * b + c) / 4.0 - start).max())
        size = max(size, float(np.abs((a - 2.0 * b + c) / 4.0 if swings_only else c - start).max()))
    return Growth(size, (size / before) ** (1.0 / (pause + 2)) if before else 1.0)


def _ways(simulation: Simulation, ways: Floats) -> Floats:
    """(n, 6) forces and torques as what they do in a step."""
    found: Floats = np.concatenate(simulation.forces(), axis=1) * ways
    return found


def growth(scene: Scene, steps: int = 200) -> float:
    """Size of `grown`."""
    return grown(scene, steps).size


@dataclass(frozen=True)
class Longest:
    """The longest stable step lies between holds and grows. runs: (k, 2) steps tried and the growth in one of each, in order of the step."""

    holds: float
    grows: float
    runs: Floats

    @property
    def step(self) -> float:
        """The middle."""
        return float(np.sqrt(self.holds * self.grows))


def longest(make: Callable[[float], Scene], guess: float, *, to: float, steps: int = STEPS, swings_only: bool = False) -> Longest:
    """Bisects the step of make(step) to a relative width `to`, from around a guess; the bracket widens until it holds at one end and grows at the
    other. steps, swings_only: as `grown`. Raises ValueError where it never does one of them within a factor of a thousand."""
    tried: dict[float, float] = {}

    def grows(dt: float) -> bool:
        found = grown(make(dt), steps, swings_only=swings_only)
        tried[dt] = found.each_step
        return found.size > GROWN

    low, high, wide = guess / 1.3, guess * 1.2, 1e3  # not the guess in the middle
    while grows(low):
        low, high = low / 1.5, low
        if low < guess / wide:
            message = f"a step of {low:.3g}, a thousandth of {guess:.3g}, still grows"
            raise ValueError(message)
    while not grows(high):
        low, high = high, high * 1.5
        if high > guess * wide:
            message = f"a step of {high:.3g}, a thousand times {guess:.3g}, still holds"
            raise ValueError(message)
    while high > low * (1.0 + to):
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if grows(middle) else (middle, high)
    return Longest(low, high, np.array(sorted(tried.items())))

"""Energy of a gas of elastic spheres, which nothing but the step can change; precision and threads in one of 1,600."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State
from demverify.bench._ways import EULER, GRADIENT, MENDED, VERLET, engines, euler, gradient, mended
from demverify.frames import Floats

if TYPE_CHECKING:
    from demsolver import Scene
    from demsolver.simulate import Precision

TITLE = "energy of an elastic gas"
STIFFNESS = {"hooke": 1e4, "hertz": 1e7}
MASS = 2500.0 * 4.0 / 3.0 * pi * 0.005**3
CONTACT = pi * sqrt(0.5 * MASS / STIFFNESS["hooke"])
DURATION, INSTANTS = 0.05, 20
COPIES = 2  # of the gas along each axis
READINGS = (
    "Model P keeps the energy of one straight contact alone; here spheres meet askew and several at once, each of which changes it (docs/energy.md).",
    "200 spheres of 10 mm in a periodic box of 70 mm, a volume fraction of 0.31, 0.2 m/s each way; some 0.05 s, that is 60 contact times.",
    "Threads share rows of 1,024 and more: in the gas of 200 there is nothing to share, hence the one of 1,600, eight times the same.",
)


def energy(x: Floats, v: Floats, scene: Scene, model: str) -> float:
    """Of motion and springs; no spins, for all are smooth. Periodic box, pairs by the nearest image."""
    from scipy.spatial import cKDTree

    p, low, length = scene.particles, scene.box.lo, scene.box.hi - scene.box.lo
    wrapped = np.mod(x - low, length)
    pairs = cKDTree(wrapped, boxsize=length).query_pairs(2.0 * float(p.radius.max()), output_type="ndarray")
    apart = wrapped[pairs[:, 0]] - wrapped[pairs[:, 1]]
    apart -= length * np.round(apart / length)
    r, other = p.radius[pairs[:, 0]], p.radius[pairs[:, 1]]
    overlap = np.maximum(r + other - np.linalg.norm(apart, axis=1), 0.0)
    kn = STIFFNESS[model]
    stored = 0.5 * kn * overlap**2 if model == "hooke" else 0.4 * kn * np.sqrt(r * other / (r + other)) * overlap**2.5
    return float(0.5 * (p.mass[: len(v)] @ (v**2).sum(axis=1)) + stored.sum())


def error(scene: Scene, states: Sequence[State], model: str) -> float:
    """Largest change of the energy over the moments, relative to that at the start."""
    first = energy(scene.particles.x, scene.particles.v, scene, model)
    return float(max(abs(energy(state.x, state.v, scene, model) / first - 1.0) for state in states))


def error_of_copies(scene: Scene, states: Sequence[State], model: str) -> float:
    """The same of the eightfold gas."""
    return error(copied(scene), states, model)


def copied(scene: Scene) -> Scene:
    """COPIES^3 of the gas side by side in a box as many times as large."""
    p, length = scene.particles, scene.box.hi - scene.box.lo
    shifts = np.array(list(np.ndindex(COPIES, COPIES, COPIES))) * length
    m, n = len(shifts), len(p.id)
    particles = replace(
        p, id=np.arange(1, m * n + 1), type=np.tile(p.type, m), x=(shifts[:, None, :] + p.x).reshape(-1, 3), v=np.tile(p.v, (m, 1)),
        omega=np.tile(p.omega, (m, 1)), radius=np.tile(p.radius, m), mass=np.tile(p.mass, m), mask=np.tile(p.mask, m),
        image=np.tile(p.image, (m, 1)),
    )  # fmt: skip
    return replace(scene, box=replace(scene.box, hi=scene.box.lo + COPIES * length, margin=None), particles=particles)


def problems(quick: bool) -> tuple[Problem, ...]:
    """Linear spring, Hertz, and the large gas."""
    contacts = (2, 5, 12, 30, 60) if quick else (1, 2, 4, 6, 10, 16, 25, 40, 63, 100, 160)
    shares = tuple(1.0 / (n + 0.5) for n in contacts)
    linear = (
        Contender(VERLET, 0, orders={"energy": 2.0}), Contender(EULER, 1, change=euler, orders={"energy": 1.0}),
        Contender(GRADIENT, 2, change=gradient, exact=True),
        Contender(MENDED, 3, change=mended),
    )  # fmt: skip
    found = [_problem("hooke", "Linear spring", shares, linear[::2] if quick else (*linear, *engines({"energy": 2.0})))]
    if not quick:
        hertz = (Contender(VERLET, 0, orders={"energy": 2.0}), Contender(EULER, 1, change=euler, orders={"energy": 1.0}))
        found.append(_problem("hertz", "Hertz", shares, (*hertz, *engines({"energy": 2.0}))))
        few = tuple(1.0 / (n + 0.5) for n in (1, 2, 3, 4, 6, 8, 12, 16))
        large = _problem("hooke", "Linear spring, 1,600 spheres, native", few, _modes())
        measure = replace(large.measures[0], error=partial(error_of_copies, model="hooke"))
        found.append(replace(large, measures=(measure,)))
    return tuple(found)


def _problem(model: str, name: str, shares: tuple[float, ...], contenders: tuple[Contender, ...]) -> Problem:
    measure = Measure("energy at 20 moments, the largest change, relative", "energy", partial(error, model=model), energy=True)
    return Problem(
        "elastic-gas", name, {"model": model, "kn": repr(STIFFNESS[model])}, DURATION, CONTACT, "a contact time", shares, (measure,), contenders,
        "the energy at the start.", instants=INSTANTS,
    )  # fmt: skip


def _modes() -> tuple[Contender, ...]:
    ways: tuple[tuple[int, Precision], ...] = ((1, "double"), (2, "double"), (1, "mixed"), (2, "mixed"))
    return tuple(
        Contender(f"{precision}, {threads} thread{'s' if threads > 1 else ''}", style, change=copied, precision=precision, threads=threads,
                  orders={"energy": 2.0} if precision == "double" else {})
        for style, (threads, precision) in enumerate(ways)
    )  # fmt: skip

"""A free asymmetric top, four spheres on a cross: rotation schemes against each other and against LAMMPS' rigid bodies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from math import pi, sqrt
from time import perf_counter

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State
from demverify.frames import Floats

TITLE = "a free asymmetric top"
RADIUS, DENSITY = 0.005, 2500.0
MASS = DENSITY * 4.0 / 3.0 * pi * RADIUS**3
ARMS = np.array([[0.02, 0.0, 0.0], [-0.02, 0.0, 0.0], [0.0, 0.012, 0.0], [0.0, -0.012, 0.0]])
"""(4, 3) from the centre to the spheres, along the principal axes."""
OWN = 0.4 * MASS * RADIUS**2  # of a sphere about itself
MOMENTS = np.array([[np.sum(MASS * (np.delete(ARMS, k, 1) ** 2)) + 4.0 * OWN for k in range(3)]])
"""Principal moments, (1, 3): one to 2.6 to 3.4."""
OMEGA = np.array([[60.0, 20.0, 50.0]])
TURN = 2.0 * pi / float(np.linalg.norm(OMEGA))
DURATION, INSTANTS = 0.5, 10
TOLERANCES = (1e-8, 1e-10, 1e-12, 1e-13)
READINGS = (
    "No torque, no contact: some six turns. LAMMPS has the same spheres as one rigid body, by Richardson (fix rigid) and NO_SQUISH (fix rigid/nve).",
    "The exact scheme is Jacobi's elliptic functions from step to step; the reference is not: it is the equations of motion by DOP853.",
    "LIGGGHTS' multisphere is not there: its body is put together by an insertion, at a place that chance gives.",
)


def positions(quat: Floats) -> Floats:
    """Of the spheres, (4, 3), in the orientation quat (4,)."""
    from demsolver.shapes.rotation import matrix

    return np.asarray(ARMS @ matrix(quat[None])[0].T)


@cache
def reference(tolerance: float) -> Floats:
    """(INSTANTS, 4, 3) positions by q' = q o omega/2, omega = I^-1 R^T L."""
    from scipy.integrate import solve_ivp

    from demsolver.shapes.rotation import matrix

    angmom = (MOMENTS * OMEGA)[0]  # it begins upright

    def rate(_: float, q: Floats) -> Floats:
        a, b, c = (matrix(q[None])[0].T @ angmom) / MOMENTS[0]
        w, x, y, z = q
        return np.array([-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a]) / 2.0

    times = DURATION / INSTANTS * np.arange(1, INSTANTS + 1)
    found = solve_ivp(rate, (0.0, DURATION), [1.0, 0.0, 0.0, 0.0], "DOP853", times, rtol=tolerance, atol=0.1 * tolerance).y
    return np.array([positions(q) for q in found.T])


def error(_: None, states: Sequence[State], tolerance: float) -> float:
    """Root mean square distance of the spheres from where they belong, at all moments, over that from the centre."""
    x = np.array([state.x - state.x.mean(axis=0) for state in states])
    return float(sqrt(np.sum((x - reference(tolerance)) ** 2) / (INSTANTS * np.sum(ARMS**2))))


def energy_error(_: None, states: Sequence[State]) -> float:
    """Largest change of the energy of the spheres' velocities and spins, relative."""
    first = 0.5 * float(np.sum(MOMENTS * OMEGA**2))
    now = [0.5 * (MASS * float(np.sum(state.v**2)) + OWN * float(np.sum(state.omega**2))) for state in states]
    return max(abs(one / first - 1.0) for one in now)


def solve(name: str, steps: int) -> tuple[list[State], float]:
    """States by a scheme of the native solver, and the seconds of its steps."""
    from demsolver import rotation

    now, states, spent = rotation.turning(np.array([[1.0, 0.0, 0.0, 0.0]]), OMEGA, MOMENTS), [], 0.0
    for _ in range(INSTANTS):
        began = perf_counter()
        now = rotation.freely(name, now, MOMENTS, DURATION / steps, steps // INSTANTS)
        spent += perf_counter() - began
        x, omega = positions(now.quat[0]), np.repeat(now.omega, 4, axis=0)
        states.append(State(x, np.cross(omega, x), omega))
    return states, spent


def problems(quick: bool) -> tuple[Problem, ...]:
    """One top."""
    each = (8, 100, 200, 400, 800) if quick else (6, 10, 16, 25, 40, 63, 100, 160, 250, 400, 630, 1000)
    second, drifts = {"attitude": 2.0, "energy": 2.0}, {"attitude": 2.0, "energy": 3.0}
    own = tuple(
        Contender(shown, style, solve=partial(solve, name), exact=exact, orders=orders)
        for style, (name, shown, exact, orders) in enumerate((
            ("exact", "exact", True, {}), ("midpoint", "implicit midpoint", True, {"attitude": 2.0}), ("no_squish", "NO_SQUISH", False, second),
            ("richardson", "Richardson", False, drifts),
        ))
    )  # fmt: skip
    engines = (
        Contender("LAMMPS rigid", 4, "lammps", words={"style": "rigid"}, orders=drifts),
        Contender("LAMMPS rigid/nve", 5, "lammps", words={"style": "rigid/nve"}, orders=second),
    )
    finest = TOLERANCES[1 if quick else -1]
    measures = (
        Measure("place of the spheres about their centre, relative", "attitude", partial(error, tolerance=finest)),
        Measure("energy at ten moments, the largest change, relative", "energy", energy_error, energy=True),
    )
    return (Problem(
        "free-top", "Four spheres", {}, DURATION, TURN, "a turn", tuple(1.0 / (n + 0.5) for n in each), measures, own if quick else (*own, *engines),
        "the equations of motion by DOP853.", partial(convergence, finest), instants=INSTANTS,
    ),)  # fmt: skip


def convergence(finest: float) -> tuple[tuple[str, float], ...]:
    """Of the reference, with its tolerance."""
    last = reference(finest)
    return tuple((f"tolerance {one:g}", float(np.abs(reference(one) - last).max() / ARMS.max())) for one in TOLERANCES if one > finest)

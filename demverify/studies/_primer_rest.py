"""What comes of the primer's tangential spring where a contact should rest: it trembles and creeps, by the step."""

from __future__ import annotations

from math import sqrt

import numpy as np

from demverify.report.axes import logarithmic, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Table
from demverify.studies._primer_scenes import KN, MASS, RADIUS, G, path, squeezed, started

PRESS = 0.5 * RADIUS * KN  # normal force of each of two planes
PULL = 0.05  # of what friction could hold


def resting(quick: bool) -> Finding:
    """Growth of the tremble, where it ends, and the creep under a steady pull."""
    cases = [(0.01, 0.0), (0.01, 0.01)] if quick else [(0.003, 0.0), (0.01, 0.0), (0.01, 0.01), (0.03, 0.0), (0.03, 0.1), (0.1, 0.0)]
    growth = [(k, h, _growth(k, h), _factor(k, h)) for k, h in cases]
    off = max(abs(measured / computed - 1.0) for *_, measured, computed in growth)
    steps = np.array([2e-5, 1e-5] if quick else [4e-5, 2e-5, 1e-5, 5e-6])
    laws = {"primer": "primer", "LAMMPS": "rotated_history"}
    creep = {name: np.array([_creep(float(dt), friction) for dt in steps]) for name, friction in laws.items()}
    over = creep["primer"] / (G * steps)
    ends = _end()
    claims = (
        Claim("A contact that does not slide keeps its spring (1.16), and so holds what is pulled by less than mu |Fn|.",
              f"Pulled with T, {PULL:g} of that, it creeps with {', '.join(f'{v:.3f}' for v in over)} T dt/m at steps of "
              f"{', '.join(scientific(float(dt)) for dt in steps)} s.",
              float(np.abs(over).max()) < 0.01,
              "In steps dt the velocity of a contact at rest is never 0 but changes sign, and the spring turns round with it each time (1.15). On "
              "average it pulls back with T, at a mean velocity of T dt/m."),
        Claim("The spring of LAMMPS holds it, with a dashpot at rest.",
              f"Its speed over T dt/m: {scientific(float(np.abs(creep['LAMMPS'] / (G * steps)).max()))} at most.",
              float(np.abs(creep["LAMMPS"] / (G * steps)).max()) < 1e-6, whose="ours"),
        Claim("The tremble grows in each step by the larger root of lambda^2 - (K + H) lambda - (1 - H) = 0, above one for every step and dashpot.",
              f"Measured growth agrees to {scientific(off)}.", off < 1e-6 and all(computed > 1.0 for *_, computed in growth), whose="ours"),
        Claim("It ends at the limit, where each step turns the velocity round by mu |Fn| dt/m.", f"Measured over that: {ends:.6f}.",
              abs(ends - 1.0) < 1e-6, whose="ours"),
    )  # fmt: skip
    rows = tuple((f"K = {k:g}, H = {h:g}", measured, computed) for k, h, measured, computed in growth)
    svg = chart(
        "mean speed under a steady pull", "Creep of a sphere held by friction over the step, by the primer's spring",
        [Series("primer", steps, creep["primer"], 0, "both")],
        (logarithmic(float(steps.min()), float(steps.max())), logarithmic(0.5 * G * float(steps.min()), 2.0 * G * float(steps.max()))),
        ("step in s", "in m/s"), [Rule("T dt/m", steps[::-1], G * steps[::-1])],
    )  # fmt: skip
    return Finding(
        "(1.15), (1.16): what rests on the primer's spring", claims,
        f"A sphere squeezed between two planes, so that it cannot spin, pulled along them by its weight in velocity Verlet, with a dashpot; or given "
        f"{1e-9:g} m/s and left alone in semi-implicit Euler. K = kt dt^2/m, H = eta dt/m of both contacts together.",
        (Figure("creep", "Mean speed of a sphere that friction should hold.", svg),),
        (Table("Growth of the tremble in one step", ("", "measured", "lambda"), rows),),
        {"step": steps, "speed": creep, "growth": [{"K": k, "H": h, "measured": m, "lambda": c} for k, h, m, c in growth]},
    )  # fmt: skip


def _factor(k: float, h: float) -> float:
    return 0.5 * (k + h + sqrt((k + h) ** 2 + 4.0 * (1.0 - h)))


def _growth(k: float, h: float) -> float:
    """Of the velocity in one step, once the other mode, which shrinks by (1 - H)/lambda, is gone."""
    dt = 1e-5
    still = squeezed(dt, v=1e-12, along=0, mu=1e6, shear_stiffness=0.5 * k * MASS / dt**2, gammat=0.5 * h * MASS / dt)
    _, v = path(still, round(12.0 / (_factor(k, h) - 1.0)), 0)
    return float(np.abs(v[-1] / v[-41]) ** (1.0 / 40.0))


def _creep(dt: float, friction: str) -> float:
    """Mean speed over 0.1 s, 0.2 s after the start."""
    mu = MASS * G / (2.0 * PRESS * PULL)
    simulation = started(squeezed(dt, along=0, pull=G, euler=False, friction=friction, mu=mu, shear_stiffness=KN, gammat=1.0))
    simulation.advance(round(0.2 / dt))
    before = float(simulation.bodies.x[0, 0])
    simulation.advance(round(0.1 / dt))
    return (float(simulation.bodies.x[0, 0]) - before) / 0.1


def _end() -> float:
    """Change of velocity in a step, over mu |Fn| dt/m, of a sphere left to tremble."""
    dt, mu = 1e-5, 0.1
    _, v = path(squeezed(dt, v=1e-6, along=0, mu=mu, shear_stiffness=10.0 * KN), 6000, 0)
    return float(abs(v[-1] - v[-2]) / (2.0 * mu * PRESS * dt / MASS))

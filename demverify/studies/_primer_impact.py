"""Appendix B of the primer: the damping that gives a restitution, (B.9), in impacts of the native solver."""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demsolver.restitution import fraction_for, of_fraction
from demverify.report.axes import logarithmic, scientific
from demverify.report.charts import Series, chart
from demverify.studies import Claim, Figure, Finding, Table
from demverify.studies._primer_scenes import KN, MASS, RADIUS, spheres, stage, started

if TYPE_CHECKING:
    from demverify.frames import Floats

WANTED = 1e-4  # how near the restitution has to come
RATIO = 1.5  # of the radii of an unlike pair
SPEED = 0.1


def restitution(quick: bool) -> Finding:
    """Impacts on a wall and between unlike spheres, with and without the pulling tail, with the right mass and with the primer's m."""
    asked = np.array([0.2, 0.5, 0.9] if quick else [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99])
    per_contact = np.array([50, 800, 12800] if quick else [25, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12800, 25600])
    runs = {int(n): impacts(asked, int(n)) for n in per_contact}
    best = runs[int(per_contact[-1])]
    cut, wrong = (np.array([of_fraction(f * fraction_for(e, "hooke"), "hooke", limit_damping=cut) for e in asked])
                  for f, cut in ((1.0, True), (sqrt(2.0), False)))  # fmt: skip
    expected = {"wall": asked, "pair": asked, "wall, never pulling": cut, "like pair, eta from m": wrong}
    off = {name: float(np.abs(best[name] - expected[name]).max()) for name in expected}
    rows: tuple[tuple[str | float, ...], ...] = tuple((f"{e:g}", *(float(best[name][k]) for name in expected)) for k, e in enumerate(asked))
    steps = int(per_contact[-1])
    claims = (
        Claim("(B.9) gives the restitution e at a wall.", f"Off by at most {scientific(off['wall'])}, e from {asked[0]:g} to {asked[-1]:g}.",
              off["wall"] < WANTED),
        Claim("(B.9) holds between two particles too, with the reduced mass in the place of m.",
              f"Off by at most {scientific(off['pair'])}, radii 1 to {RATIO:g}.", off["pair"] < WANTED, whose="ours"),
        Claim("With the m of one particle, as printed for walls, two like spheres are damped sqrt(2) times too much, for m/2 moves.",
              f"{_some(asked, best['like pair, eta from m'])}; off from the closed form by at most {scientific(off['like pair, eta from m'])}, from "
              f"what is asked by up to {float(np.abs(best['like pair, eta from m'] - asked).max()):.3f}.", off["like pair, eta from m"] < WANTED,
              whose="ours"),
        Claim("Cut off where the force would pull (limit_damping), it gives exp(-2 b arccos b/sqrt(1 - b^2)), b = eta/(2 sqrt(m k)).",
              f"Off by at most {scientific(off['wall, never pulling'])}: {_some(asked, cut)}.", off["wall, never pulling"] < WANTED, whose="ours"),
    )  # fmt: skip
    return Finding(
        "Appendix B: damping from restitution", claims,
        f"Head-on impacts at {SPEED} m/s, velocity Verlet with {steps} steps in pi sqrt(m/k). In decks: damping coeff_restitution of the granular "
        "styles, which takes the reduced mass.",
        (_figure(per_contact, runs, asked),), (Table("Restitution", ("asked", *expected), rows),),
        {"asked": asked, "measured": best, "expected": expected, "steps per contact": per_contact,
         "largest error at a wall": [float(np.abs(runs[int(n)]["wall"] - asked).max()) for n in per_contact]},
    )  # fmt: skip


def _some(asked: Floats, found: Floats) -> str:
    half = int(np.argmin(np.abs(asked - 0.5)))
    return f"{found[half]:.4f} where {asked[half]:g} is asked"


def _figure(per_contact: Floats, runs: dict[int, dict[str, Floats]], asked: Floats) -> Figure:
    errors = {name: np.array([np.abs(runs[int(n)][name] - asked).max() for n in per_contact]) for name in ("wall", "pair")}
    low, high = min(float(e.min()) for e in errors.values()), max(float(e.max()) for e in errors.values())
    svg = chart(
        "restitution off by", "Largest error of the restitution over the number of steps in a contact",
        [Series(name, per_contact.astype(float), e, style, "both") for style, (name, e) in enumerate(errors.items())],
        (logarithmic(float(per_contact[0]), float(per_contact[-1])), logarithmic(low / 2.0, high * 2.0)), ("steps in a contact", ""),
    )  # fmt: skip
    return Figure("restitution", "Largest error of e over all asked values, against the number of steps in a contact.", svg)


def impacts(asked: Floats, per_contact: int) -> dict[str, Floats]:
    """Rebound over impact speed, (k,) each, by kind of impact; one scene, each impact on its own."""
    k = len(asked)
    kinds = np.arange(1, k + 1)
    fraction = np.array([fraction_for(float(e), "hooke") for e in asked])
    far = 0.1 * np.arange(k)[:, None] * np.array([1.0, 0.0, 0.0])
    reduced = MASS * RATIO**3 / (1.0 + RATIO**3)
    up = np.array([0.0, 0.0, 1.0])
    gap = 1e-6 * RADIUS
    groups = [  # (place, radius, speed along z, type)
        (far + (RADIUS + gap) * up, RADIUS, -SPEED, kinds),  # wall
        (far + (100.0 + RADIUS + gap) * up, RADIUS, -SPEED, kinds),  # wall, never pulling
        (far + 50.0 * up, RADIUS, 0.5 * SPEED, k + kinds),  # unlike pairs
        (far + (50.0 + gap + (1.0 + RATIO) * RADIUS) * up, RATIO * RADIUS, -0.5 * SPEED, k + kinds),
        (far + 60.0 * up, RADIUS, 0.5 * SPEED, 2 * k + kinds),  # like pairs, with the damping of one particle's mass
        (far + (60.0 + gap + 2.0 * RADIUS) * up, RADIUS, -0.5 * SPEED, 2 * k + kinds),
    ]  # fmt: skip
    particles = spheres(
        np.concatenate([g[0] for g in groups]), np.repeat([g[1] for g in groups], k), v=np.repeat([g[2] for g in groups], k)[:, None] * up,
        kind=np.concatenate([g[3] for g in groups]),
    )  # fmt: skip
    root = sqrt(KN)
    own = np.concatenate([fraction * sqrt(MASS) * root, fraction * sqrt(reduced) * root, fraction * sqrt(MASS) * root])
    dt = pi * sqrt(MASS / KN) / per_contact
    simulation = started(stage(particles, dt, pair={"gamman": np.diag(own)}, wall={"gamman": own}))
    # the contact lasts pi/alpha, which grows as e falls: 2.5 times pi sqrt(m/k) at e = 0.05
    simulation.advance(3 * per_contact)
    v = simulation.bodies.v[:, 2].reshape(6, k)
    return {
        "wall": v[0] / SPEED, "pair": (v[3] - v[2]) / SPEED, "wall, never pulling": v[1] / SPEED, "like pair, eta from m": (v[5] - v[4]) / SPEED,
    }  # fmt: skip

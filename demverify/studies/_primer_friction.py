"""The primer's tangential spring, (1.11)-(1.18), beside those of LAMMPS and LIGGGHTS: the same laws on the same paths."""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from demverify.report.axes import linear, scientific
from demverify.report.charts import Series, chart
from demverify.studies import Claim, Figure, Finding, Table
from demverify.studies._primer_scenes import KN

if TYPE_CHECKING:
    from demverify.frames import Floats

LAWS = {"primer": "primer", "LAMMPS": "rotated_history", "LIGGGHTS": "liggghts_history"}
KT, LIMIT = 2.0 / 7.0 * KN, 1.0  # tangential spring, and mu |Fn|
REACH = LIMIT / KT  # the stretch at which it slides
ENERGY = REACH * LIMIT
HOW = (
    "The friction laws of the solver alone, led along a path at constant speed, no dashpot. LAMMPS: pair granular, linear_history; LIGGGHTS: "
    "tangential history. Forces in units of mu |Fn|, lengths of mu |Fn|/kt, the stretch at which a contact slides."
)


@dataclass(frozen=True)
class Ride:
    """One law led along one path. force: (k, 3) on the particle. power: (k,) work done by the law in each step."""

    force: Floats
    power: Floats

    @property
    def taken(self) -> float:
        """Work done against the law."""
        return -float(self.power.sum())

    @property
    def end(self) -> float:
        """Size of the last force."""
        return float(np.linalg.norm(self.force[-1]))


def led(way: Floats) -> dict[str, Ride]:
    """Every law led along a path of k + 1 points (k + 1, 3) in the plane z = 0."""
    return {name: _ride(law, way) for name, law in LAWS.items()}


def _ride(name: str, way: Floats) -> Ride:
    from demsolver import contact

    law = contact.law("friction", name)
    names, slots, dt = tuple(inspect.signature(law.force).parameters), tuple(law.MEMORY), 1.0 / (len(way) - 1)
    known: dict[str, Any] = {"critical_force": LIMIT, "kt": KT, "gt": 0.0, "mu": 1.0, "nx": 0.0, "ny": 0.0, "nz": 1.0, "dt": dt, "advance": True}
    known |= dict.fromkeys(slots, 0.0)
    forces = []
    for v in np.diff(way, axis=0) / dt:
        known |= dict(zip(("vtx", "vty", "vtz"), v.tolist(), strict=True))
        result = law.force(*(known[parameter] for parameter in names))
        forces.append(result[:3])
        known |= dict(zip(slots, result[3:], strict=True))
    force = np.array(forces)
    return Ride(force, (force * np.diff(way, axis=0)).sum(axis=1))


def _to_and_fro(amplitude: float, n: int) -> Floats:
    """0, A, -A, 0 along x."""
    t = np.linspace(0.0, 1.0, n + 1)
    x = np.interp(t, [0.0, 0.25, 0.75, 1.0], [0.0, amplitude, -amplitude, 0.0])
    return np.asarray(x[:, None] * np.array([1.0, 0.0, 0.0]))


def _each(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {scientific(value)}" for name, value in values.items())


def sticking(quick: bool) -> Finding:
    """(1.13)-(1.16): to and fro below the limit."""
    n, amplitude = 400 if quick else 4000, 0.2 * REACH
    way = _to_and_fro(amplitude, n)
    rides, length = led(way), 4.0 * amplitude
    end, taken = ({name: getattr(ride, what) for name, ride in rides.items()} for what in ("end", "taken"))
    jump = {name: float(abs(ride.force[n // 4, 0] / ride.force[n // 4 - 1, 0] - 1.0)) for name, ride in rides.items()}
    engines = [name for name in LAWS if name != "primer"]
    claims = (
        Claim("The spring is the integral of vt since the contact began (1.13), which is nothing after a closed path.",
              f"At the end of the path, force over kt times its length: {_each({k: v / (KT * length) for k, v in end.items()})}.",
              end["primer"] < 1e-6 * LIMIT,
              "(1.14) adds lengths instead of vectors: the spring is turned to today's t and grows, so where the sliding turns back it turns round "
              "as a whole and never unloads."),
        Claim("Where the sliding turns back, the primer's force turns round in one step; the engines' springs unload from there.",
              f"Change in that step over the force before it: {_each(jump)}.", jump["primer"] > 1.9 and max(jump[k] for k in engines) < 0.1,
              whose="ours"),
        Claim("The primer's spring only takes: Ft.vt <= 0 in every step; over the path kt length^2/2, of which nothing comes back. The engines' "
              "springs give back all they took.", f"Taken over kt length^2/2: {_each({k: 2.0 * v / (KT * length**2) for k, v in taken.items()})}.",
              bool((rides["primer"].power <= 0.0).all()) and abs(2.0 * taken["primer"] / (KT * length**2) - 1.0) < 0.01
              and max(abs(taken[k]) for k in engines) < 0.01 * taken["primer"], whose="ours"),
    )  # fmt: skip
    return Finding(
        "1.1.2: the tangential spring to and fro, below the limit", claims, HOW, (_loop("sticking", way, rides),), (),
        {"x": way[1:, 0] / REACH, "force": {k: r.force[:, 0] / LIMIT for k, r in rides.items()}},
    )  # fmt: skip


def sliding(quick: bool) -> Finding:
    """(1.17), (1.18): to and fro beyond the limit."""
    n, amplitude = 1200 if quick else 12000, 3.0 * REACH
    way = _to_and_fro(amplitude, n)
    rides = led(way)
    taken = {name: ride.taken / ENERGY for name, ride in rides.items()}
    most = {name: float(np.abs(ride.force).max()) / LIMIT for name, ride in rides.items()}
    expected = {"primer": 11.5, "LAMMPS": 7.5, "LIGGGHTS": 7.5}
    claims = (
        Claim("|Ft| <= mu |Fn| (1.17).", f"Largest |Ft|: {_each(most)}.", most["primer"] <= 1.0 + 1e-12),
        Claim("While it slides the spring stays as it was (1.18): the primer's is at its limit ever after, whichever way the sliding goes; that of "
              "the engines unloads and loads again, over twice the sliding stretch, at each turn.",
              f"Taken on the path 0, 3, -3, 0: {_each(taken)}; closed forms 1/2 + 2 + 6 + 3 = 11.5 and 1/2 + 2 + 4 + 1 = 7.5.",
              all(abs(taken[k] / expected[k] - 1.0) < 0.01 for k in LAWS), whose="ours"),
    )  # fmt: skip
    table = Table("Work taken on the path 0, 3, -3, 0, in (mu |Fn|)^2/kt", ("law", "measured", "closed form"),
                  tuple((k, taken[k], expected[k]) for k in LAWS))  # fmt: skip
    return Finding(
        "1.1.3: the tangential spring to and fro, with sliding", claims, HOW, (_loop("sliding", way, rides),), (table,),
        {"x": way[1::10, 0] / REACH, "force": {k: r.force[::10, 0] / LIMIT for k, r in rides.items()}, "taken": taken},
    )  # fmt: skip


def _loop(name: str, way: Floats, rides: dict[str, Ride]) -> Figure:
    x, high = way[1:, 0] / REACH, max(float(np.abs(ride.force).max()) for ride in rides.values()) / LIMIT
    reach = float(np.abs(x).max())
    svg = chart(
        "tangential force", "Tangential force over displacement, to and fro, of three laws",
        [Series(law, x, ride.force[:, 0] / LIMIT, style) for style, (law, ride) in enumerate(rides.items())],
        (linear(-1.1 * reach, 1.1 * reach), linear(-1.1 * high, 1.1 * high)), ("displacement in mu |Fn|/kt", "in mu |Fn|"),
    )  # fmt: skip
    return Figure(name, "Force over displacement: the primer's, and those of LAMMPS and LIGGGHTS, which coincide.", svg)


def circling(quick: bool) -> Finding:
    """(1.14), (1.15) where the direction of sliding turns all the time."""
    n, radius = 400 if quick else 4000, 0.1 * REACH
    angle = np.linspace(0.0, 2.0 * pi, n + 1)
    way = radius * np.stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle], axis=1)
    rides, arc = led(way), 2.0 * pi * radius
    size = {name: np.linalg.norm(ride.force, axis=1) / LIMIT for name, ride in rides.items()}
    behind = np.array([-np.cos(angle[1:] - pi / n), -np.sin(angle[1:] - pi / n), 0.0 * angle[1:]]).T
    turned = float(np.abs((rides["primer"].force / np.linalg.norm(rides["primer"].force, axis=1)[:, None] * behind).sum(axis=1) - 1.0).max())
    chord = float(np.abs(size["LAMMPS"] - 2.0 * KT * radius * np.sin(angle[1:] / 2.0) / LIMIT).max())
    taken = {name: 2.0 * ride.taken / (KT * arc**2) for name, ride in rides.items()}
    claims = (
        Claim("The spring has the direction of today's sliding (1.15), and the length of the whole way (1.14).",
              f"-Ft/|Ft| is t to {scientific(turned)}; after one turn |Ft| is {rides['primer'].end / (KT * arc):.4f} of kt times the circumference.",
              turned < 1e-6 and abs(rides["primer"].end / (KT * arc) - 1.0) < 1e-3),
        Claim("The engines' springs are the vector from the start: their force is kt times the chord, and gone after one turn.",
              f"Off from the chord by at most {scientific(chord)} mu |Fn|; taken in one turn, over kt arc^2/2: {_each(taken)}.",
              chord < 1e-3 and rides["LIGGGHTS"].end < 1e-6 * LIMIT and abs(taken["LAMMPS"]) < 0.01, whose="ours"),
    )  # fmt: skip
    svg = chart(
        "size of the tangential force", "Size of the tangential force over the angle gone round a circle, of three laws",
        [Series(law, angle[1:] / pi, values, style) for style, (law, values) in enumerate(size.items())],
        (linear(0.0, 2.0), linear(0.0, 1.05 * KT * arc / LIMIT)), ("angle in pi", "in mu |Fn|"),
    )  # fmt: skip
    return Finding(
        "1.1.2: the tangential spring round a circle", claims, HOW,
        (Figure("circle", "Size of the force round a circle of a tenth of the sliding stretch.", svg),), (), {"angle": angle[1:], "|force|": size},
    )  # fmt: skip

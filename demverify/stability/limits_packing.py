"""The longest stable step of whole packings, measured against the eigenvalue: one sphere on springs in a medium, two between walls, 10 and 1,000."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from demsolver import Box, Neighbor, Scene, Slab, Viscous, Wall
from demsolver.stability import contact_limits
from demsolver.stability_contacts import contacts_of
from demsolver.stability_packing import packing_limit
from demverify.report.axes import logarithmic, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.stability import held
from demverify.stability.held import DISTURBANCE, INTEGRATORS, KN, NUDGE, OVERLAP, RADIUS, STEPS, Longest, at_wall, linear, longest
from demverify.stability.limits import WITHIN
from demverify.studies import Claim, Figure, Finding, Progress, Table

LAWS: dict[str, dict[str, Any]] = {
    "springs": {"mu": 0.0},
    "springs and dashpots": {"mu": 0.0, "gamman": 1500.0},
    "friction": {"kt": 2 / 7 * KN},
    "friction and dashpots": {"kt": 2 / 7 * KN, "gamman": 1500.0, "xt": 0.5},
}
"""Linear laws, as `held.linear` takes them."""
SIZES = (2, 10, 1000)
DRAGGED = "drag and two springs"
HOW = (
    "Two unequal spheres between two walls, 10 and 1,000 unequal ones pressed together in a periodic box until nothing moves, then given velocities "
    "and spins at random, a millionth of the overlaps in a step. Every contact is as it is: normal and tangential springs and dashpots. Predicted is "
    "the step at which the largest eigenvalue of dt^2 K' + 2 dt C' is 4. It holds if no force grows a thousandfold in 2,000 steps."
)


@dataclass(frozen=True)
class PackingSweep:
    """What came out. single: the limit of the contact that has the shortest."""

    spheres: int
    law: str
    integrator: str
    predicted: float
    single: float
    contacts: int
    found: Longest

    @property
    def ratio(self) -> float:
        """Measured over predicted step."""
        return self.found.step / self.predicted


def made(n: int, law: str) -> Callable[[float], Scene]:
    """The packing at a step."""
    chosen = linear((1, 1), **LAWS[law]) if law in LAWS else linear((1, 1), mu=0.0)
    if law == DRAGGED:
        return dragged
    if n == 2:
        return lambda dt: held.chain(dt, chosen, 0.1 * held.LIGHTLY * held.SLIGHT / dt)
    return lambda dt: held.packing(*held.relaxed(n), dt, chosen, DISTURBANCE)


def dragged(dt: float) -> Scene:
    """A sphere between two walls in a medium: what the dashpots and the drag take together."""
    law = linear((1, 1), mu=0.0)
    p = held.spheres(np.array([[RADIUS - OVERLAP, 0.0, 0.0]]), np.array([RADIUS]), v=np.array([[NUDGE * OVERLAP / dt, 0.0, 0.0]]))
    walls = (Wall("ends", Slab(0, lo=0.0), at_wall(law)), Wall("other", Slab(0, hi=2.0 * (RADIUS - OVERLAP)), at_wall(law)))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    return Scene(box, p, 1, dt, pair=law, walls=walls, forces=(Viscous(np.array([3.0])),), neighbor=Neighbor(1e-3))


def sweep(n: int, law: str, integrator: str, to: float, steps: int) -> PackingSweep:
    """Measures one packing."""

    def make(dt: float) -> Scene:
        return replace(made(n, law)(dt), integrate=INTEGRATORS[integrator])

    scene = make(1e-6)
    contacts = contacts_of(scene)
    limit = packing_limit(scene, contacts)
    single = min(one.combined for one in contact_limits(scene, contacts))
    return PackingSweep(n, law, integrator, limit.combined, single, limit.contacts, longest(make, limit.combined, to=to, steps=steps))


def packings(quick: bool, progress: Progress) -> Finding:
    """The part."""
    wanted = [(1, DRAGGED), *((n, law) for n in SIZES for law in LAWS if not quick or n < 1000 or law in ("springs", "friction and dashpots"))]
    sweeps = []
    for k, (n, law) in enumerate(wanted):
        for integrator in INTEGRATORS:
            progress(f"packing of {n:,}, {law}", k / len(wanted))
            many = n == max(SIZES)
            to, steps = (1e-2, STEPS // 4) if quick and many else (5e-3, STEPS) if quick or many else (1e-3, STEPS)
            sweeps.append(sweep(n, law, integrator, to, steps))
    return finding(sweeps)


def finding(sweeps: list[PackingSweep]) -> Finding:
    """A claim for each size, and that single contacts do not do."""
    claims = [agreement(n, [one for one in sweeps if one.spheres == n]) for n in dict.fromkeys(one.spheres for one in sweeps)]
    worst = min((one for one in sweeps if one.spheres > 2), key=lambda one: one.found.step / one.single)
    claims.append(
        Claim("A sphere in many contacts is stiffer than any one of them: the limit of a packing is below that of its single contacts.",
              f"{worst.found.step / worst.single:.3f} of it among {worst.spheres:,} spheres ({worst.law}).",
              all(one.found.grows < one.single for one in sweeps if one.spheres > 2)),
    )  # fmt: skip
    rows = tuple(_row(*both) for both in zip(sweeps[0::2], sweeps[1::2], strict=True))
    head = ("packing", "contacts", "single contact (s)", "predicted step (s)", "measured, Verlet", "measured, Euler")
    table = Table("Longest stable step of packings: predicted, and measured over predicted", head, rows)
    numbers = {
        f"{one.spheres} spheres, {one.law}, {one.integrator}": {
            "predicted": one.predicted, "single contact": one.single, "contacts": one.contacts, "holds": one.found.holds, "grows": one.found.grows,
            "steps tried": one.found.runs[:, 0], "growth in a step": one.found.runs[:, 1],
        }
        for one in sweeps
    }  # fmt: skip
    return Finding("Packings of springs and dashpots", tuple(claims), HOW, (picture(sweeps),), (table,), numbers)


def _row(a: PackingSweep, b: PackingSweep) -> tuple[str, ...]:
    name = f"{a.spheres:,} sphere{'s' * (a.spheres > 1)}, {a.law}"
    return name, f"{a.contacts:,}", scientific(a.single, 4), scientific(a.predicted, 4), f"{a.ratio:.4f}", f"{b.ratio:.4f}"


def agreement(n: int, sweeps: list[PackingSweep]) -> Claim:
    """All limits measured of packings of n spheres are those predicted."""
    worst = max(sweeps, key=lambda one: abs(one.ratio - 1.0))
    what = "A packing of one sphere" if n == 1 else f"A packing of {n:,} spheres"
    return Claim(
        f"{what} holds up to its own eigenvalue, with both integrators, within {WITHIN:.0%}.",
        f"{len(sweeps)} limits measured; furthest off: {worst.law}, {worst.integrator}, {worst.ratio:.4f} of the predicted step.",
        abs(worst.ratio - 1.0) <= WITHIN and {one.integrator for one in sweeps} == set(INTEGRATORS),
    )


def picture(sweeps: list[PackingSweep]) -> Figure:
    """Measured over predicted step: every packing, both integrators."""
    series = []
    low, high = 0.8 * min(one.predicted for one in sweeps), 1.25 * max(one.predicted for one in sweeps)
    for style, name in enumerate(INTEGRATORS):
        chosen = [one for one in sweeps if one.integrator == name]
        series.append(Series(name, np.array([one.predicted for one in chosen]), np.array([one.found.step for one in chosen]), 3 * style, "marks"))
    ends = np.array([low, high])
    of, single = np.array([(one.predicted, one.single) for one in sweeps]).T
    series.append(Series("limit of a single contact", of, single, 4, "marks"))
    top = max(high, 1.25 * float(single.max()))
    svg = chart(
        "longest stable step", "Measured longest stable step of packings over the predicted one, both logarithmic: all on the line of equals", series,
        (logarithmic(low, high), logarithmic(low, top)), ("predicted (s)", "measured (s)"), [Rule("equal", ends, ends)],
    )  # fmt: skip
    return Figure("packings", "Measured against predicted limit of packings of 1 to 1,000 spheres; crosses: what a single contact would allow.", svg)


"""The longest stable step of a deck: the contacts of its first run as they stand, measured against what `demverify timestep` predicts of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np

from demsolver import Cylinder, Gravity, LostParticles, Plane, Scene, SetForce, Simulation, Unstable, Wall
from demsolver.stability import contact_limits
from demsolver.stability_contacts import contacts_in, contacts_of, mobility
from demsolver.stability_packing import buckling_rate, packing_limit
from demverify.errors import InputError, Place
from demverify.frames import Floats
from demverify.report.axes import linear as axis
from demverify.report.charts import Rule, Series, chart
from demverify.stability.held import GROWN, Growth, Longest, grown, longest
from demverify.stability.limits import WITHIN
from demverify.studies import Claim, Figure, Finding, Progress, Study, Table
from demverify.timestep import StepReport, refuse_clumps, step_report

MOST_STEPS, LOOK = 200_000, 10
"""A deck in which nothing touches is run at most so far, looking every so many steps."""
STEPS = 300
"""Of a measurement: a hundredth beyond its limit an undamped contact needs thirty, one of H = 1 a hundred."""
PART = 1e-5
"""Of the deepest overlap: a velocity in a step. A thousand times that is a hundredth of it. Less where a contact is stiffer across than along, so
that it does not slip."""
BUCKLES = 0.05
"""E-folds in a step from which a state leaves the place where it is held before its limit could be measured."""
DIGITS = 20
TOUCH = 1e-8
"""Of the smallest radius: what overlaps less has been put side by side, and opens at the least disturbance."""


@dataclass(frozen=True)
class Standing:
    """The contacts that are looked at. scene: everything at rest, held by constant forces. waited: steps that the deck was run to get them.
    part: PART, or less of it. predicted: the longest stable step of them; single: of the contact that has the shortest. buckling: rate at which
    they leave their place by themselves."""

    deck: Path
    scene: Scene
    report: StepReport
    waited: int
    contacts: int
    deepest: float
    part: float
    predicted: float
    single: float
    buckling: float
    law: str


def standing(deck: Path, variables: Mapping[str, Sequence[str]]) -> Standing:
    """Reads a deck and brings its first run into contact. Raises InputError for a deck that the native engine cannot read, in which nothing touches,
    or whose contacts limit no step."""
    from demverify.runs import plan

    run = plan(deck, variables).runs[0]
    refuse_clumps(run.scene, deck)
    scene, waited = in_contact(run.scene, run.steps, Place(deck))
    still = at_rest(scene)
    contacts = contacts_of(still)
    limit, singles = packing_limit(still, contacts), contact_limits(still, contacts)
    predicted = min([limit.combined, *(one.combined for one in singles if one.law == "added force")])
    if predicted == inf:
        message = f"the contacts of the first run ({limit.law or 'none of what moves'}) limit no step"
        raise InputError(message, Place(deck))
    single = min((one.combined for one in singles), default=inf)
    deepest = float(contacts.overlap.max(initial=0.0))
    along, across = (max((one.stiffness for one in singles if one.motion == name), default=0.0) for name in ("normal", "tangential"))
    part = PART * min(1.0, along / across if along and across else 1.0)
    rate = buckling_rate(still, contacts)
    return Standing(deck, held(still), step_report(deck, variables), waited, limit.contacts, deepest, part, predicted, single, rate, limit.law)


def in_contact(scene: Scene, steps: int, place: Place) -> tuple[Scene, int]:
    """The scene as it is if something touches, else run at its own step to the first moment at which the deepest contact is deepest; and after how
    many steps that is. Raises InputError when nothing touches in the deck's run."""
    touch = TOUCH * float(scene.particles.radius[scene.particles.radius > 0.0].min(initial=np.inf))
    if contacts_of(scene).overlap.max(initial=0.0) > touch:
        return scene, 0
    most = min(steps, MOST_STEPS)
    simulation, best = Simulation(scene), (0.0, scene, 0)
    try:
        simulation.setup()
        while simulation.step < most:
            simulation.advance(min(LOOK, most - simulation.step))
            if not simulation.touches:
                continue
            depth = float(contacts_in(scene, simulation.bodies, simulation.pairs, simulation.box_hi - simulation.box_lo).overlap.max(initial=0.0))
            if depth < best[0]:
                break
            if depth <= touch:
                continue
            best = depth, replace(scene, box=simulation.box(), particles=simulation.particles()), simulation.step
    except (Unstable, LostParticles) as error:
        if not best[2]:
            message = f"nothing touches before the run ends: {error}"
            raise InputError(message, place) from error
    if not best[2]:
        message = f"nothing touches in the first {most} steps, so there is no contact whose step could be measured"
        raise InputError(message, place)
    return best[1], best[2]


def at_rest(scene: Scene) -> Scene:
    """The scene with nothing in motion: particles, walls; prescribed forces are zero."""
    p = scene.particles
    forces = tuple(_unforced(force) if isinstance(force, SetForce) else force for force in scene.forces)
    still = replace(p, v=np.zeros_like(p.v), omega=np.zeros_like(p.omega))
    return replace(scene, particles=still, walls=tuple(map(_stopped, scene.walls)), forces=forces)


def _unforced(force: SetForce) -> SetForce:
    x, y, z = (None if one is None else 0.0 for one in force.force)
    return SetForce((x, y, z), force.bit)


def _stopped(wall: Wall) -> Wall:
    shape = wall.shape
    if isinstance(shape, Cylinder):
        shape = replace(shape, rotation=None)
    if isinstance(shape, Plane):
        shape = replace(shape, velocity=(0.0, 0.0, 0.0), omega=(0.0, 0.0, 0.0))
    return replace(wall, shape=shape, velocity=(0.0, 0.0, 0.0))


def held(scene: Scene) -> Scene:
    """A scene at rest that stays there: a constant force on each particle against all that acts on it, to 2^-20 of the largest.

    Forces go by groups, so each particle gets its own as a binary number: one group a digit and direction, and an offset for all."""
    simulation = Simulation(scene, on_instability="off")
    simulation.setup()
    p = scene.particles
    wanted = np.where(mobility(scene).translation > 0.0, -simulation.forces()[0] / p.mass[:, None], 0.0)
    used = sorted({0, *_bits(scene)})
    free = [bit for bit in range(1, 63) if bit not in used]
    digits = min(DIGITS, len(free) // 3)
    top = np.abs(wanted).max(axis=0)
    mask = p.mask & sum(1 << bit for bit in used)
    fields = [Gravity((-top[0], -top[1], -top[2]))]
    for c in np.flatnonzero(top):
        whole = np.clip(np.rint((wanted[:, c] + top[c]) / (2.0 * top[c]) * (2**digits - 1)), 0, 2**digits - 1).astype(np.int64)
        for k in range(digits):
            bit = free.pop()
            step = np.zeros(3)
            step[c] = 2.0 * top[c] * 2**k / (2**digits - 1)
            fields.append(Gravity((step[0], step[1], step[2]), bit))
            mask = mask | ((whole >> k & 1) << bit)
    return replace(scene, particles=replace(simulation.particles(), mask=mask), forces=(*fields, *scene.forces))


def _bits(scene: Scene) -> list[int]:
    """Groups that the scene names."""
    named = [one.bit for one in (*scene.integrate, *scene.walls, *scene.forces)]
    return [*named, *(bit for pair in scene.neighbor.exclude for bit in pair)]


def disturbed(stand: Standing, dt: float) -> Scene:
    """The held scene at a step, with velocities and spins at random, `part` of the deepest overlap in a step."""
    p, rng = stand.scene.particles, np.random.default_rng(7)
    speed = stand.part * (stand.deepest or float(p.radius.max())) / dt
    moves = mobility(stand.scene)
    v = np.where(moves.translation > 0.0, speed * rng.uniform(-1.0, 1.0, p.v.shape), 0.0)
    with np.errstate(divide="ignore"):
        omega = np.where(moves.rotation > 0.0, speed * rng.uniform(-1.0, 1.0, p.v.shape) / p.radius[:, None], 0.0)
    return replace(stand.scene, particles=replace(p, v=v, omega=omega), timestep=dt)


def of_deck(stand: Standing, quick: bool, progress: Progress) -> Study:
    """Sweeps the step and bisects it."""
    progress("bisecting", 0.0)
    found = longest(lambda dt: disturbed(stand, dt), stand.predicted, to=1e-2 if quick else 2e-3, steps=STEPS, swings_only=True)
    progress("at the deck's own step", 0.5)
    own = grown(disturbed(stand, stand.report.step), STEPS, swings_only=True)
    parts = np.linspace(0.7, 1.3, 13 if quick else 61)
    rates = []
    for k, part in enumerate(parts.tolist()):
        progress(f"{part:.3g} of the predicted step", 0.5 + 0.5 * k / len(parts))
        rates.append(grown(disturbed(stand, part * stand.predicted), STEPS, swings_only=True).each_step)
    readings = [
        ("All stands still, and each particle is held by a constant force, so that the contacts stay as they are; springs of friction start "
         "unstretched. Velocities and spins at random, some 1e-5 of the deepest overlap in a step, are to grow a thousandfold, "
         "swinging from step to step, in 300 steps, or hold."),
    ]  # fmt: skip
    if stand.waited:
        readings.insert(0, f"Nothing touches where the run begins: the deck was run for {stand.waited:,} steps, to where its contact was deepest.")
    found_out = finding(stand, found, own, parts, np.array(rates))
    return Study(f"Where the step of {stand.deck.name} breaks", _source(stand), (found_out,), tuple(readings), "theory")


def _source(stand: Standing) -> str:
    return f"{stand.deck}: {stand.report.particles:,} particles, {stand.contacts:,} contacts ({stand.law}), step {stand.report.step:g}."


def finding(stand: Standing, found: Longest, own: Growth, parts: Floats, rates: Floats) -> Finding:
    """Claims, picture, and the limits that `demverify timestep` prints."""
    ratio, step = found.step / stand.predicted, stand.report.step
    holds, rate = own.size <= GROWN, stand.buckling * stand.predicted
    buckles = (
        f"Pressed like this without friction, the contacts do not stay where they are held: they buckle, by a factor of {np.exp(rate):.3g} in a step."
        if rate > BUCKLES else ""
    )  # fmt: skip
    claims = (
        Claim(f"The contacts as they stand hold steps up to {stand.predicted:.6g}, within {WITHIN:.0%}.",
              f"Measured {found.step:.6g}, {ratio:.4f} of it; a single contact would allow {stand.single:.6g}.", abs(ratio - 1.0) <= WITHIN,
              buckles),
        Claim(f"The deck's step {step:g} holds.", f"It is {step / found.step:.3g} of the measured limit, and a disturbance "
              + ("holds." if holds else "grows."), holds and step < found.grows),
    )  # fmt: skip
    rows = tuple((row.name, row.formula, "absent" if row.value is None else f"{row.value:.6g}", row.what) for row in stand.report.rows)
    table = Table("Limits of the first run as demverify timestep prints them", ("limit", "formula", "value", "of"), rows)
    numbers = {
        "predicted": stand.predicted, "holds": found.holds, "grows": found.grows, "single contact": stand.single, "buckling": stand.buckling,
        "contacts": stand.contacts,
        "own step": step, "steps run before": stand.waited, "step over predicted": parts, "growth in a step": rates,
    }  # fmt: skip
    return Finding("The longest stable step", claims, "", (picture(parts, rates),), (table,), numbers)


def picture(parts: Floats, rates: Floats) -> Figure:
    """Growth in a step over the step."""
    top = max(1.5, 1.1 * float(rates[np.isfinite(rates)].max(initial=1.0)))
    series = [Series("", parts, np.minimum(rates, top), 0, "both")]
    svg = chart(
        "growth in a step", "Growth of a disturbance in one step over the step: none up to the limit", series,
        (axis(0.7, 1.3), axis(0.9, top)), ("step over the predicted limit", "times"), [Rule("predicted", np.array([1.0, 1.0]), np.array([0.9, top]))],
    )  # fmt: skip
    return Figure("growth", "Growth in one step: 1 while the disturbance holds.", svg)

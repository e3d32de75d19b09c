"""Elastic spheres bounce on a floor three times; what the entry into a contact costs, at every phase of a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import exp, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender, Measure, Problem, State, scene_of
from demverify.bench._orders import Order, fit_order
from demverify.bench._page import LEEWAY, order_text
from demverify.bench._ways import EULER, GRADIENT, MENDED, VERLET, engines, euler, gradient, mended
from demverify.frames import Floats
from demverify.report.axes import linear, logarithmic
from demverify.report.charts import Series, chart
from demverify.studies import Claim, Figure, Finding, Progress, Table

if TYPE_CHECKING:
    from demsolver import Scene

TITLE = "elastic spheres bounce three times"
GRAVITY, DURATION = 9.81, 0.18  # at the end all are rising after the third bounce
STIFFNESS = {"hooke": 1e4, "hertz": 1e7}  # contacts of both laws last about a millisecond
BOUNCES = 3
READINGS = (
    ("Model P keeps the speed of a contact and not its time: it turns the approach round within some three steps, however short. So its height "
    "does not converge to that of a spring, and no order is asked of it."),
    ("Ten spheres of 10 mm, 2500 kg/m³, fall from 5 to 5.1 mm, each by itself; errors are root mean squares over the ten, so over ten phases of "
    "each touch."),
    "A sphere on a wall has nothing to share out among threads, and walls are felt in double precision: neither is varied here.",
)
PHASES = 64


def contact_time(speed: float, mass: float, radius: float, model: str, gravity: float, nodes: int = 80) -> float:
    """How long a sphere that falls on the floor with `speed` stays: 2 times the integral of dd/sqrt(v^2 + 2 g d - 2 E(d)/m) from 0 to the deepest d,
    E = kn d^2/2, or 2/5 kn sqrt(R) d^(5/2); with d = deepest cos^2(theta), by Gauss and Legendre."""
    from scipy.optimize import brentq

    kn = STIFFNESS[model]
    power, factor = (2.0, kn / mass) if model == "hooke" else (2.5, 0.8 * kn * sqrt(radius) / mass)

    def square_at(d: float) -> float:
        return speed**2 + 2.0 * gravity * d - factor * float(d**power)

    deepest = float(brentq(square_at, 0.0, radius, xtol=1e-300, rtol=1e-15))
    x, weight = np.polynomial.legendre.leggauss(nodes)
    theta = 0.25 * pi * (x + 1.0)
    left = np.sin(theta) ** 2  # 1 - d/deepest: differences to the deepest, where the speed is 0, lose no digits
    square = factor * deepest**power * -np.expm1(power * np.log1p(-left)) - 2.0 * gravity * deepest * left
    return 2.0 * float(0.25 * pi * weight @ (2.0 * deepest * np.cos(theta) * np.sin(theta) / np.sqrt(square)))


def heights(scene: Scene, model: str, time: float, nodes: int = 80) -> Floats:
    """(n,) of the centres at `time`, which lies in the flight after BOUNCES elastic bounces, from rest."""
    p = scene.particles
    return np.array([_height(float(z), float(r), float(m), model, time, nodes) for z, r, m in zip(p.x[:, 2], p.radius, p.mass, strict=True)])


def _height(z: float, radius: float, mass: float, model: str, time: float, nodes: int) -> float:
    speed = sqrt(2.0 * GRAVITY * (z - radius))
    flown = time - (2.0 * BOUNCES - 1.0) * speed / GRAVITY - BOUNCES * contact_time(speed, mass, radius, model, GRAVITY, nodes)
    return radius + speed * flown - 0.5 * GRAVITY * flown**2


def height_error(scene: Scene, states: Sequence[State], model: str) -> float:
    """Root mean square over the spheres, each relative to its height of fall."""
    fall = scene.particles.x[:, 2] - scene.particles.radius
    return float(np.sqrt(np.mean(((states[-1].x[:, 2] - heights(scene, model, DURATION)) / fall) ** 2)))


def energy_error(scene: Scene, states: Sequence[State]) -> float:
    """Root mean square over the spheres of v^2/2 + g z, each relative to what it falls with."""
    fall = GRAVITY * (scene.particles.x[:, 2] - scene.particles.radius)
    now = 0.5 * (states[-1].v ** 2).sum(axis=1) + GRAVITY * (states[-1].x[:, 2] - scene.particles.radius)
    return float(np.sqrt(np.mean((now / fall - 1.0) ** 2)))


def problems(quick: bool) -> tuple[Problem, ...]:
    """Linear spring, and Hertz."""
    return tuple(_problem(model, quick) for model in STIFFNESS)


def _problem(model: str, quick: bool) -> Problem:
    contacts = (4, 10, 25, 50, 100) if quick else (2, 4, 6, 10, 16, 25, 40, 63, 100, 160, 250, 400)
    shares = tuple(1.0 / (n + 0.5) for n in contacts)  # see `entry_finding`
    problem = Problem(
        "bouncing-sphere", "Linear spring" if model == "hooke" else "Hertz", {"model": model, "kn": repr(STIFFNESS[model])}, DURATION, 1.0,
        "a contact time", shares,
        (Measure("height after three bounces, relative to the height of fall", "height", partial(height_error, model=model)),
         Measure("energy after three bounces, relative to that of the fall", "energy", energy_error, energy=True)),
        _contenders(model, quick), "flights are ballistic, and a contact lasts an integral over its depth, by Gauss and Legendre.",
    )  # fmt: skip
    scene = scene_of(problem, 1)
    p = scene.particles
    speed = sqrt(2.0 * GRAVITY * float((p.x[:, 2] - p.radius).mean()))
    finest = heights(scene, model, DURATION, 160)
    told = tuple((f"{nodes} nodes", float(np.abs(heights(scene, model, DURATION, nodes) / finest - 1.0).max())) for nodes in (10, 20, 40, 80))
    return replace(problem, unit=contact_time(speed, float(p.mass[0]), float(p.radius[0]), model, GRAVITY), convergence=lambda: told)


_BOTH = (
    "It has Verlet's error of contact entry, of order two with a large factor, and half a step of gravity, of order one with a small one: at these "
    "steps the second does not rule yet."
)
_SMOOTH = (
    "Contact entry gives order 2.5 with a large factor, the smooth rest of the contact order two with a small one: at these steps the second does "
    "not rule yet."
)


def _contenders(model: str, quick: bool) -> tuple[Contender, ...]:
    orders = {"height": 2.0, "energy": 2.0 if model == "hooke" else 2.5}
    why = {} if model == "hooke" else {"height": _SMOOTH}
    own: tuple[Contender, ...] = (
        Contender(VERLET, 0, orders=orders, why=why),
        Contender(EULER, 1, change=euler, orders={} if quick else {"height": 1.0, "energy": 1.0}, why={"height": _BOTH, "energy": _BOTH}),
    )
    if model == "hooke":
        own += (
            Contender(GRADIENT, 2, change=gradient, exact=True, orders={"height": 2.0}),
            Contender(MENDED, 3, change=mended, orders={} if quick else {"energy": 1.0}),
        )
    return own if quick and model == "hertz" else (*own, *engines(orders, why))


def findings(quick: bool, progress: Progress) -> tuple[Finding, ...]:
    """What contact entry does."""
    progress("phases of a contact", 0.96)
    return (entry_finding((4, 8, 16, 32, 64) if quick else (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)),)


@dataclass(frozen=True)
class Entry:
    """One way into a contact. more: beyond a whole number of steps that it takes. order: of the root mean square over the phases."""

    name: str
    order: float
    model: str = "hooke"
    gamma: float = 0.0
    by_euler: bool = False
    more: float = 0.5


ENTRIES = (
    Entry("Verlet, linear spring", 2.0),
    Entry("Verlet, linear spring, whole steps", 3.0, more=0.0),
    Entry("Verlet, Hertz", 2.5, "hertz"),
    Entry("Verlet, spring and dashpot", 1.0, gamma=400.0),
    Entry("Euler, linear spring", 2.0, by_euler=True),
)


def contact_steps(entry: Entry, whole: int) -> float:
    """Steps in a contact time."""
    return whole + entry.more


def entry_errors(entry: Entry, whole: int) -> Floats:
    """(PHASES,) of the speed after one impact without gravity, relative, signed; the k-th sphere touches (k + 1/2)/PHASES of a step after a step
    began."""
    from demsolver import Simulation

    scene, expected = _impact(entry, contact_steps(entry, whole))
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(2 * whole + 8)
    return np.asarray(simulation.bodies.v[:, 2] / expected - 1.0)


def _impact(entry: Entry, steps: float) -> tuple[Scene, float]:
    """The scene, and the speed after."""
    words = {"model": entry.model, "kn": repr(STIFFNESS[entry.model]), "gamma": repr(entry.gamma)}
    scene = scene_of(Problem("bouncing-sphere", "", words, DURATION, 1.0, "", (1.0,), (), (), ""), 1)
    p, speed = scene.particles, 0.3
    radius, mass = float(p.radius[0]), float(p.mass[0])
    half = 0.5 * entry.gamma
    swing = sqrt(STIFFNESS["hooke"] / mass - half * half)  # of the damped oscillator
    dt = (pi / swing if entry.model == "hooke" else contact_time(speed, mass, radius, entry.model, 0.0)) / steps
    x = np.zeros((PHASES, 3))
    x[:, 0] = 4.0 * radius * np.arange(PHASES)
    x[:, 2] = radius + speed * dt * (1.0 + phases())
    one = np.ones(PHASES)
    many = replace(
        p, id=np.arange(1, PHASES + 1), type=np.ones(PHASES, dtype=np.int64), x=x, v=np.outer(one, [0.0, 0.0, -speed]), omega=np.zeros((PHASES, 3)),
        radius=radius * one, mass=mass * one, mask=np.ones(PHASES, dtype=np.int64), image=np.zeros((PHASES, 3), dtype=np.int64),
    )  # fmt: skip
    box = replace(scene.box, lo=np.full(3, -10.0), hi=np.full(3, 10.0), margin=None)
    scene = replace(scene, box=box, particles=many, forces=(), timestep=dt, pair=None)
    return euler(scene) if entry.by_euler else scene, speed * exp(-pi * half / swing)


def phases() -> Floats:
    """(PHASES,) when within a step a sphere touches, in steps."""
    return (np.arange(PHASES) + 0.5) / PHASES


def kink(phase: Floats, steps: float) -> Floats:
    """What Verlet makes of the speed after a contact with a linear spring that takes so many steps, to second order, relative.

    A step that ends the part s of itself after the touch leaves v^2 (1 - K s(1 - s)), K = k dt^2/m, of what Verlet's step keeps within the contact,
    v^2 + (k/m) x^2 (1 - K/4); leaving is the same backwards, with its own s'. So the error is K [s'(1 - s') - s(1 - s)]/2."""
    entering, leaving = 1.0 - phase, (steps - (1.0 - phase)) % 1.0
    return np.asarray(0.5 * (pi / steps) ** 2 * (leaving * (1.0 - leaving) - entering * (1.0 - entering)))


def entry_finding(wholes: Sequence[int]) -> Finding:
    """Order over many phases of the touch, and the error over the phase."""
    found = {entry: np.array([entry_errors(entry, whole) for whole in wholes]) for entry in ENTRIES}
    rms = {entry: np.sqrt((errors**2).mean(axis=1)) for entry, errors in found.items()}
    mean = {entry: np.abs(errors.mean(axis=1)) for entry, errors in found.items()}
    steps = {entry: np.array([1.0 / contact_steps(entry, whole) for whole in wholes]) for entry in ENTRIES}
    orders = {entry: fit_order(steps[entry], rms[entry]) for entry in ENTRIES}
    plain = ENTRIES[0]
    predicted = kink(phases(), contact_steps(plain, wholes[-1]))
    off = float(np.abs(found[plain][-1] - predicted).max() / np.abs(predicted).max())
    claims = (
        *(_entry_claim(entry, orders[entry]) for entry in ENTRIES),
        Claim("Verlet, linear spring: the error is K [s'(1 - s') - s(1 - s)]/2, K = k dt²/m; s, s': parts of a step in contact, at entry and exit.",
              f"At {contact_steps(plain, wholes[-1]):g} steps a contact off by {100.0 * off:.1f} % of the largest.", off < 2.0 * pi / wholes[-1]),
        Claim("Verlet, linear spring: over the phases of entry it averages out.",
              f"Its mean is {float(mean[plain][-1] / rms[plain][-1]):.2g} of its root mean square at the shortest step.",
              bool(mean[plain][-1] < 0.1 * rms[plain][-1])),
    )  # fmt: skip
    rows = tuple(
        (entry.name, order_text(order) if (order := orders[entry]) else "none", float(rms[entry][-1]), float(mean[entry][-1])) for entry in ENTRIES
    )
    told = "Over all phases: root mean square (rms) and mean at the shortest step"
    head = ("contact", "order of the rms", "rms", "mean")
    return Finding(
        "What contact entry does", claims,
        f"One impact without gravity, {PHASES} spheres that touch at {PHASES} phases of a step: relative error of the speed after it. Within a "
        f"contact Verlet "
        "keeps an energy of its own; the kink with which the force of a spring begins and ends leaves an error of order two whose factor hangs on "
        "both "
        "phases. Where a contact takes a whole number of steps the two cancel, and order three is seen. All diagrams of this page have whole numbers "
        "and a half instead. Hertz begins more smoothly, with overlap^1.5, which gives order 2.5; a dashpot begins with a jump and takes one "
        "order. Without "
        "gravity Euler moves as Verlet does.",
        (_entry_picture(wholes, found[plain], plain), _entry_orders(steps, rms)), (Table(told, head, rows),),
        {entry.name: {"step": steps[entry], "phase": phases(), "error": found[entry]} for entry in ENTRIES},
    )  # fmt: skip


def _entry_claim(entry: Entry, order: Order | None) -> Claim:
    found = f"Order {order_text(order)}, root mean square over the phases." if order else "No order can be fitted."
    return Claim(f"{entry.name}: order {entry.order:g}.", found, order is not None and order.within(entry.order, LEEWAY))


def _entry_picture(wholes: Sequence[int], errors: Floats, entry: Entry) -> Figure:
    chosen = [k for k in range(len(wholes)) if k in (0, len(wholes) // 2, len(wholes) - 1)]
    scaled = [errors[k] * contact_steps(entry, wholes[k]) ** 2 for k in chosen]
    top = 1.1 * max(float(np.abs(one).max()) for one in scaled)
    named = [f"{contact_steps(entry, wholes[k]):g} steps" for k in chosen]
    series = [Series(name, phases(), one, style, "marks") for style, (name, one) in enumerate(zip(named, scaled, strict=True))]
    many = contact_steps(entry, 10**6)
    series.append(Series("theory", phases(), kink(phases(), many) * many**2, 5))
    svg = chart(
        "speed after an impact off by", "Relative error of the speed after an impact over the phase of the touch, times the square of the steps in "
        "a contact",
        series, (linear(0.0, 1.0), linear(-top, top)), ("when within a step it touches, in steps", "relative, times (steps in a contact)²"),
    )  # fmt: skip
    return Figure("entry-phases", "Velocity Verlet, linear spring: the error over the phase of the touch.", svg)


def _entry_orders(steps: Mapping[Entry, Floats], rms: Mapping[Entry, Floats]) -> Figure:
    series = [Series(entry.name, steps[entry], rms[entry], style, "both") for style, entry in enumerate(ENTRIES[:4])]
    low, high = (float(of([of(one.y) for one in series])) for of in (min, max))
    last = float(max(one.x.max() for one in series))
    svg = chart(
        "speed after an impact off by", "Root mean square over the phases of the error of the speed after an impact, over the step", series,
        (logarithmic(0.8 * float(min(one.x.min() for one in series)), 1.25 * last), logarithmic(0.5 * low, 2.0 * high)),
        ("step in contact times", "relative, root mean square over the phases"),
    )  # fmt: skip
    return Figure("entry-orders", "The same for springs, Hertz, and a dashpot, over the step.", svg)

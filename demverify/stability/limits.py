"""The longest stable step of one contact, measured against predicted: every motion, spring, damper and both, at a wall and between two spheres; by
both integrators; Hertz where it is pressed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from demsolver import ContactLaw, Scene, Viscous
from demsolver.stability import ContactLimit, contact_limits
from demsolver.stability_contacts import contacts_of
from demverify.report.axes import linear as axis
from demverify.report.axes import scientific
from demverify.report.charts import Rule, Series, chart
from demverify.stability.held import HELD, INTEGRATORS, KN, LIGHTLY, MASS, NUDGE, OVERLAP, RADIUS, SLIGHT, Longest, longest, on_floor, pair
from demverify.studies import Claim, Figure, Finding, Progress, Table

WITHIN = 0.03
"""What a measured limit may be off the predicted one by."""
HERTZ_KN, PRESSED = 3e7, 2e-5
HOW = (
    "One sphere pressed onto a floor, or two pressed together, at rest but for a velocity or spin that is a tiny part of the overlap in a step. The "
    "disturbance holds if no force or torque grows a thousandfold in 2,000 steps, which at the limit of a spring are 1,000 oscillations; the step is "
    "bisected."
)

Make = Callable[[float], Scene]


@dataclass(frozen=True)
class Case:
    """One contact, held, of which one motion is disturbed. make: the scene at a step. motion: which, as `contact_limits` names it."""

    name: str
    where: str
    motion: str
    make: Make


@dataclass(frozen=True)
class Sweep:
    """What came out of one case with one integrator. predicted: the limit that rules."""

    case: Case
    integrator: str
    predicted: ContactLimit
    found: Longest

    @property
    def ratio(self) -> float:
        """Measured over predicted step."""
        return self.found.step / self.predicted.combined


def jointed(shape: tuple[int, ...], **given: float) -> ContactLaw:
    """A linear law with springs and dashpots in every motion, those that are not given of strength zero, and no slip: one compiled loop for all."""
    zero = ("kn", "gamman", "shear_stiffness", "xt", "rolling_stiffness", "rolling_damping", "twisting_stiffness", "twisting_damping")
    values = dict.fromkeys(zero, 0.0) | {"mu": 1e6, "rolling_friction": 1e6, "twisting_friction": 1e6} | given
    return ContactLaw(
        "hooke", "mass_velocity", "constant", "scaled", "classic_history", {name: np.full(shape, value) for name, value in values.items()},
        rolling="sds", twisting="sds",
    )  # fmt: skip


WALL, PAIR = "wall", "pair"
SPRINGS: dict[str, dict[str, dict[str, float]]] = {
    "normal": {
        "spring": {"kn": KN},
        "damper": {"gamman": 3000.0},
        "both": {"kn": KN, "gamman": 3000.0},
    },
    "tangential": {
        "spring": {"kn": KN, "shear_stiffness": 2.0 * KN},
        "damper": {"kn": KN, "gamman": 4000.0, "xt": 2.0},
        "both": {"kn": KN, "gamman": 2000.0, "shear_stiffness": 2.0 * KN, "xt": 0.5},
    },
    "rolling": {
        "spring": {"kn": KN, "rolling_stiffness": 4.0 * KN},
        "damper": {"kn": KN, "rolling_damping": 30.0},
        "both": {"kn": KN, "rolling_stiffness": 4.0 * KN, "rolling_damping": 6.0},
    },
    "twisting": {
        "spring": {"kn": KN, "twisting_stiffness": 4.0 * KN * RADIUS**2},
        "damper": {"kn": KN, "twisting_damping": 30.0 * RADIUS**2},
        "both": {"kn": KN, "twisting_stiffness": 4.0 * KN * RADIUS**2, "twisting_damping": 6.0 * RADIUS**2},
    },
}  # fmt: skip
"""By motion and kind of limit: coefficients of `jointed` with which that limit rules."""


def disturbed(scene: Scene, motion: str, where: str, way: float = NUDGE * OVERLAP) -> Scene:
    """The scene with a velocity or spin of its first sphere, and of the second against it, of that way in a step."""
    along, across = (2, 0) if where == WALL else (0, 1)
    speed = way / scene.timestep
    p = scene.particles
    signs = np.array([1.0, -1.0])[: len(p.id)]
    if motion in ("normal", "tangential"):
        p.v[:, along if motion == "normal" else across] = speed * signs
    else:
        p.omega[:, along if motion == "twisting" else across] = speed / RADIUS * signs
    return scene


def jointed_case(motion: str, kind: str, where: str) -> Case:
    """A linear contact. Without a normal spring nothing presses it."""
    values = SPRINGS[motion][kind]

    pressed = "kn" in values

    def make(dt: float) -> Scene:
        if where == WALL:
            return disturbed(with_drag(on_floor(dt, jointed((1,), **values), pull=HELD if pressed else 0.0)), motion, where)
        scene = pair(dt, jointed((1, 1), **values), overlap=SLIGHT, pull=KN * SLIGHT / MASS if pressed else 0.0)
        return disturbed(with_drag(scene), motion, where, LIGHTLY * SLIGHT)

    return Case(f"{motion} {kind}" if kind != "both" else f"{motion} spring and damper", where, motion, make)


def drag_case() -> Case:
    """Viscous drag, in the air."""

    def make(dt: float) -> Scene:
        return disturbed(with_drag(on_floor(dt, jointed((1,)), overlap=-RADIUS, pull=0.0), 5.0), "normal", WALL)

    return Case("viscous drag", "no contact", "drag", make)


def with_drag(scene: Scene, gamma: float = 0.0) -> Scene:
    """Drag in every scene, also none, for one compiled loop."""
    return replace(scene, forces=(*scene.forces, Viscous(np.array([gamma]))))


def hertz_case(damped: bool, where: str) -> Case:
    """Hertz at the overlap to which it is pressed."""
    values = {"kn": HERTZ_KN, "gamman": 5e6 if damped else 0.0}
    reff = RADIUS if where == WALL else 0.5 * RADIUS
    pull = HERTZ_KN * np.sqrt(reff * (PRESSED if where == WALL else OVERLAP)) * (PRESSED if where == WALL else OVERLAP) / MASS

    def make(dt: float) -> Scene:
        shape = (1,) if where == WALL else (1, 1)
        law = ContactLaw("hertz", "viscoelastic", "none", "none", "none", {name: np.full(shape, value) for name, value in values.items()})
        scene = on_floor(dt, law, overlap=PRESSED, pull=pull) if where == WALL else pair(dt, law, pull=pull)
        return disturbed(scene, "normal", where)

    return Case("Hertz spring and damper" if damped else "Hertz spring", where, "normal", make)


def linear_cases() -> list[Case]:
    """All linear ones."""
    found = [jointed_case(motion, kind, where) for motion, kinds in SPRINGS.items() for kind in kinds for where in (WALL, PAIR)]
    return [*found, drag_case()]


def hertz_cases() -> list[Case]:
    """All of Hertz."""
    return [hertz_case(damped, where) for damped in (False, True) for where in (WALL, PAIR)]


def predicted(scene: Scene, motion: str, where: str) -> ContactLimit:
    """The limit of what touches, or of drag. Raises ValueError where another motion rules."""
    between = {WALL: "type 1 and wall floor", PAIR: "types 1 and 1"}.get(where, "type 1 and the medium")
    found = min((one for one in contact_limits(scene, contacts_of(scene)) if one.between == between), key=lambda limit: limit.combined)
    if found.motion != motion:
        message = f"the {found.motion} motion rules, not the {motion} one"
        raise ValueError(message)
    return found


def sweep(case: Case, integrator: str, to: float) -> Sweep:
    """Measures one case."""

    def make(dt: float) -> Scene:
        return replace(case.make(dt), integrate=INTEGRATORS[integrator])

    limit = predicted(make(1e-6), case.motion, case.where)
    return Sweep(case, integrator, limit, longest(make, limit.combined, to=to))


def one_contact(quick: bool, progress: Progress) -> list[Finding]:
    """The part: linear contacts, then Hertz."""
    cases, hertz, to = linear_cases(), hertz_cases(), 5e-3 if quick else 1e-3
    wanted = [(case, integrator) for case in (*cases, *hertz) for integrator in INTEGRATORS]
    sweeps = []
    for k, (case, integrator) in enumerate(wanted):
        progress(f"{case.name}, {case.where}", k / len(wanted))
        sweeps.append(sweep(case, integrator, to))
    straight, curved = sweeps[: len(INTEGRATORS) * len(cases)], sweeps[len(INTEGRATORS) * len(cases) :]
    return [
        finding("One linear contact", straight, to, [growths(straight)]),
        finding("A Hertz contact at its overlap", curved, to, []),
    ]


def finding(title: str, sweeps: list[Sweep], to: float, figures: list[Figure]) -> Finding:
    """Claims by integrator, that both agree, and the table."""
    claims = [agreement(name, [one for one in sweeps if one.integrator == name]) for name in INTEGRATORS]
    claims.append(same(sweeps))
    numbers = {
        f"{one.case.name}, {one.case.where}, {one.integrator}": {
            "predicted": one.predicted.combined, "holds": one.found.holds, "grows": one.found.grows, "mass": one.predicted.mass,
            "stiffness": one.predicted.stiffness, "damping": one.predicted.damping, "steps tried": one.found.runs[:, 0],
            "growth in a step": one.found.runs[:, 1],
        }
        for one in sweeps
    }  # fmt: skip
    return Finding(title, tuple(claims), f"{HOW[:-1]} to {to:.1%}.", tuple(figures), (table(sweeps),), numbers)


def agreement(integrator: str, sweeps: list[Sweep]) -> Claim:
    """All limits measured with one integrator are those predicted."""
    worst = max(sweeps, key=lambda one: abs(one.ratio - 1.0))
    return Claim(
        f"By {integrator} a step holds up to 4 m/(eta + sqrt(eta^2 + 4 k m)) of the motion that rules, within {WITHIN:.0%}.",
        f"{len(sweeps)} limits measured; furthest off: {worst.case.name} ({worst.case.where}), {worst.ratio:.4f} of the predicted step.",
        abs(worst.ratio - 1.0) <= WITHIN,
    )


def same(sweeps: list[Sweep]) -> Claim:
    """The two integrators have one limit; it holds on both sides, so the width of two bisections is what they may differ by."""
    pairs = list(zip(sweeps[0::2], sweeps[1::2], strict=True))
    off, worst = max(((abs(a.found.step / b.found.step - 1.0), a) for a, b in pairs), key=lambda found: found[0])
    return Claim(
        "Both integrators have the same limits.", f"They differ by {off:.2%} at most ({worst.case.name}, {worst.case.where}).", off <= WITHIN,
    )  # fmt: skip


def table(sweeps: list[Sweep]) -> Table:
    """Predicted and measured, both integrators in a row."""
    rows = []
    for a, b in zip(sweeps[0::2], sweeps[1::2], strict=True):
        limit = a.predicted
        K, H = limit.stiffness * limit.combined**2 / limit.mass, limit.damping * limit.combined / limit.mass
        rows.append((f"{a.case.name}, {a.case.where}", f"{K:.2f}", f"{H:.2f}", scientific(limit.combined, 4), f"{a.ratio:.4f}", f"{b.ratio:.4f}"))
    head = ("limit", "K", "H", "predicted step (s)", "measured, Verlet", "measured, Euler")
    return Table("Longest stable step: predicted, and measured over predicted", head, tuple(rows))


def growths(sweeps: list[Sweep]) -> Figure:
    """Growth in a step over the step, of the normal motion at a wall by Verlet, with the spectral radius."""
    wanted = ("normal", WALL, "velocity Verlet")
    shown = [one for one in sweeps if (one.case.motion, one.case.where, one.integrator) == wanted]
    series = []
    for style, one in enumerate(shown):
        steps, each = one.found.runs.T
        series.append(Series(one.case.name.removeprefix("normal "), steps / one.predicted.combined, each, style, "marks"))
        over = np.linspace(0.7, 1.3, 241)
        series.append(Series("", over, np.array([spectral_radius(one.predicted, s * one.predicted.combined) for s in over]), style, "line"))
    svg = chart(
        "growth in a step", "Growth of a disturbance in one step over the step: none up to the limit, the spectral radius beyond", series,
        (axis(0.75, 1.25), axis(0.75, 4.5)), ("step over the predicted limit", "times"), [Rule("limit", np.array([1.0, 1.0]), np.array([0.75, 4.5]))],
    )  # fmt: skip
    return Figure("growth", "Growth in one step as measured (marks) and the spectral radius of a step (lines).", svg)


def spectral_radius(limit: ContactLimit, dt: float) -> float:
    """The larger |lambda| of lambda^2 - (2 - K - H) lambda + 1 - H."""
    K, H = limit.stiffness * dt**2 / limit.mass, limit.damping * dt / limit.mass
    return float(np.abs(np.roots([1.0, -(2.0 - K - H), 1.0 - H])).max())

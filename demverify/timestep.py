"""How long a deck's step may be: every limit there is for the scene of its first run, each with its formula and its source."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from demverify.errors import InputError, Place

if TYPE_CHECKING:
    from demsolver.scene import Scene
    from demsolver.stability import ContactLimit
    from demsolver.stability_packing import PackingLimit
    from demverify.deck.setup import Setup
    from demverify.deck.timestep_gran import Material, Times

PRIMER = "primer"
NOTES = (
    "Velocity Verlet with forces from half-step velocities (LAMMPS, LIGGGHTS, this solver) and semi-implicit Euler share these limits.",
    "Rayleigh and Hertz times are measures of a contact, not limits of stability; steps of 0.1 to 0.2 of them are usual.",
)


@dataclass(frozen=True)
class Row:
    """One limit. value: a time; inf where nothing limits, None where it is not known: `where` says what sets it, or why it is absent.
    law: of the contact that sets it. stable: whether a longer step is unstable."""

    name: str
    formula: str
    source: str
    value: float | None
    where: str
    law: str = ""
    stable: bool = False

    @property
    def what(self) -> str:
        """What sets it, with its law."""
        return f"{self.where} ({self.law})" if self.law else self.where


@dataclass(frozen=True)
class StepReport:
    """Of the scene of a deck's first run. said: what LIGGGHTS would say, by its own fixes."""

    deck: Path
    step: float
    particles: int
    rows: Sequence[Row]
    contacts: Sequence[ContactLimit]
    packing: PackingLimit
    said: Sequence[str]

    @property
    def ruling(self) -> Row:
        """The shortest step beyond which the run is unstable."""
        return min((row for row in self.rows if row.stable), key=lambda row: inf if row.value is None else row.value)

    @property
    def exceeded(self) -> str:
        """One line when the step is too long, else nothing."""
        limit = self.ruling
        if limit.value is None or self.step <= limit.value:
            return ""
        return f"the step {self.step:.6g} is above {limit.value:.6g}, the stability limit of {limit.what}"


def step_report(deck: Path, variables: Mapping[str, Sequence[str]]) -> StepReport:
    """Reads a deck without running it. Raises InputError for a deck that the native engine cannot read."""
    from demsolver.stability import contact_limits
    from demsolver.stability_contacts import contacts_of
    from demsolver.stability_packing import packing_limit
    from demverify.runs import plan

    run = plan(deck, variables).runs[0]
    scene = run.scene
    refuse_clumps(scene, deck)
    touching = contacts_of(scene)
    limits, packing = contact_limits(scene, touching), packing_limit(scene, touching)
    material = _material(run.setup)
    times = None if isinstance(material, str) else _times(run.setup, scene, material)
    rows = (*_contact_rows(limits), *_packing_rows(packing), *_liggghts_rows(times, material if isinstance(material, str) else "", scene))
    return StepReport(deck, scene.timestep, len(scene.particles.id), rows, limits, packing, tuple(_said(run.setup, scene)))


def refuse_clumps(scene: Scene, deck: Path) -> None:
    """Raises InputError where a scene has clumps: a push at a member moves and turns the whole, and the limits here are those of single bodies."""
    if scene.particles.clumps is not None:
        message = "this deck has clumps, and the longest stable step of clumps is not worked out here: only that of spheres and superquadrics"
        raise InputError(message, Place(deck))


def refuse(report: StepReport) -> None:
    """Raises InputError when the step is above the limit."""
    if report.exceeded:
        raise InputError(report.exceeded, Place(report.deck))


def _contact_rows(limits: Sequence[ContactLimit]) -> list[Row]:
    ways = (
        ("spring alone", "2 sqrt(m/k)", f"{PRIMER} (2.24)", "spring", False),
        ("damper alone", "2 m/eta", f"{PRIMER} (2.30)", "damper", False),
        ("the smaller of both", "min of the two", f"{PRIMER} (2.31)", "apart", False),
        ("spring and damper", "4 m/(eta + sqrt(eta^2 + 4 k m))", "K + 2 H < 4", "combined", True),
    )
    return [Row(name, formula, source, *_least(limits, key), stable) for name, formula, source, key, stable in ways]


def _least(limits: Sequence[ContactLimit], key: str) -> tuple[float, str, str]:
    worst = min(limits, key=lambda limit: float(getattr(limit, key)), default=None)
    if worst is None:
        return inf, "no two particles or walls can meet", ""
    value = float(getattr(worst, key))
    return (value, f"{worst.between}, {worst.motion}", worst.law) if isfinite(value) else (value, "no contact has one", "")


def _packing_rows(packing: PackingLimit) -> list[Row]:
    count = packing.contacts
    where = f"the packing of {count} contact{'s' * (count != 1)}" if count else "nothing touches now"
    return [
        Row("packing, springs", "2/omega_max", "eigenvalue", packing.undamped, where, packing.law, stable=True),
        Row("packing, damped", "max eig (dt^2 K' + 2 dt C') = 4", "K + 2 H < 4", packing.combined, where, packing.law, stable=True),
    ]


def _liggghts_rows(times: Times | None, absent: str, scene: Scene) -> list[Row]:
    source = "LIGGGHTS"
    rayleigh = "pi R sqrt(rho/G)/(0.1631 nu + 0.8766)"
    hertz = "2.87 (m^2/(R/2 Ye^2 v))^(1/5)"
    if times is None:
        return [Row("Rayleigh time", rayleigh, source, None, absent), Row("Hertz time", hertz, source, None, absent)]
    ids, speed = scene.particles.id, times.relative_speed
    slow = f"particle {ids[times.rayleigh_particle]}" if times.rayleigh_particle >= 0 else "no particle has a material"
    moving = times.hertz_particle >= 0
    hit = f"particle {ids[times.hertz_particle]} and its like at v = {speed:.4g}" if moving else "nothing moves"
    skin = scene.neighbor.skin / speed if speed > 0.0 else inf
    return [
        Row("Rayleigh time", rayleigh, source, times.rayleigh if times.rayleigh_particle >= 0 else None, slow),
        Row("Hertz time", hertz, source, times.hertz if moving else inf, hit),
        Row("time to cross the skin", "skin/v", source, skin, f"v = {speed:.4g}, twice the largest speed" if speed > 0.0 else "nothing moves"),
    ]


def _material(setup: Setup) -> Material | str:
    """Young's modulus and Poisson's ratio of the types, or why the deck gives none."""
    import numpy as np

    from demverify.deck.materials_lammps import elastic
    from demverify.deck.properties_liggghts import Properties
    from demverify.deck.timestep_gran import Material

    if setup.dialect == "liggghts":
        given = {fix.args[0] for fix in setup.fixes.values() if fix.style == "property/global" and fix.args}
        missing = [name for name in ("youngsModulus", "poissonsRatio") if name not in given]
        if missing:
            return f"the deck has no property/global {' and no '.join(missing)}"
        return Material(*Properties(setup, "timestep", None).elastic())
    found = Material(*elastic(setup))
    style = (setup.pair_style or ("none",))[0]
    return found if np.isfinite(found.young).any() else f"pair_style {style} gives no Young's modulus; granular hertz/material does"


def _times(setup: Setup, scene: Scene, material: Material, **settings: Any) -> Times:
    from demverify.deck.timestep_gran import times_of

    return times_of(scene.particles, material, dimension=setup.dimension, **settings)


def _said(setup: Setup, scene: Scene) -> list[str]:
    """By the deck's fixes check/timestep/gran, at the state of the first run."""
    from demverify.deck.timestep_gran import STYLE, check_of, liggghts_material

    said = []
    for spec in setup.fixes.values():
        if spec.style == STYLE:
            check = check_of(setup, spec)
            times = _times(setup, scene, liggghts_material(setup, spec), vmax=check.vmax, bit=check.bit)
            rayleigh, hertz, skin = times.fractions(scene.timestep, scene.neighbor.skin)
            said.append(f"fix {spec.id}: f_{spec.id}[1..3] = {rayleigh:.8g} {hertz:.8g} {skin:.8g}; limits {check.rayleigh:g} {check.hertz:g}")
            said += [f"fix {spec.id}: {text}" for text in times.complaints(check, scene.timestep, scene.neighbor.skin) if check.warn or check.error]
    return said

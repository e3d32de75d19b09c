"""The other linear laws of the folder, each with a limit of its own: measured against predicted, at a wall, by both integrators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from demsolver import ContactLaw, Scene
from demsolver.bind_law import law_coefficients
from demverify.stability.held import HELD, INTEGRATORS, KN, MASS, on_floor
from demverify.stability.limits import WALL, Case, disturbed, finding, sweep
from demverify.studies import Finding, Progress


@dataclass(frozen=True)
class Form:
    """A law that sets the limit of one motion. names: its parts, where they are not `hooke` alone. values: coefficients that are not zero."""

    motion: str
    names: Mapping[str, str]
    values: Mapping[str, float]

    @property
    def name(self) -> str:
        """The law's parts."""
        return f"{self.motion}: {', '.join(('hooke', *self.names.values()))}"

    def law(self) -> ContactLaw:
        """For a wall; no slip."""
        parts = {"damping": "none", "tangential_stiffness": "none", "tangential_damping": "none", "friction": "none"} | dict(self.names)
        law = ContactLaw("hooke", coefficients={}, **parts)  # type: ignore[arg-type]
        values = {"kn": KN, "mu": 1e6} | dict(self.values)
        coefficients = {name: np.full((1,), values.get(name, 0.0)) for name in law_coefficients(law)}
        return ContactLaw("hooke", coefficients=coefficients, **parts)  # type: ignore[arg-type]

    def case(self) -> Case:
        """Pressed onto a floor."""

        def make(dt: float) -> Scene:
            return disturbed(on_floor(dt, self.law(), pull=HELD), self.motion, WALL)

        return Case(self.name, WALL, self.motion, make)


def _tangential(friction: str, damping: str, **values: float) -> Form:
    names = {"tangential_stiffness": "constant", "tangential_damping": damping, "friction": friction}
    return Form("tangential", names, {"shear_stiffness": 2.0 * KN} | values)


FORMS = (
    Form("normal", {"damping": "velocity"}, {"gamman": 3000.0 * MASS}),
    _tangential("rotated_history", "mass", gammat=1000.0),
    _tangential("liggghts_history", "absolute", gammat=1000.0 * MASS),
    _tangential("classic_history", "none"),
    Form("rolling", {"rolling": "epsd"}, {"rolling_friction": 2.0, "rolling_damping_ratio": 0.2}),
)
QUICK = 2
"""Forms of a quick run: each is two loops to compile."""


def other_laws(quick: bool, progress: Progress) -> Finding:
    """The part."""
    wanted = [(form, name) for form in (FORMS[:QUICK] if quick else FORMS) for name in INTEGRATORS]
    sweeps = []
    for k, (form, integrator) in enumerate(wanted):
        progress(form.name, k / len(wanted))
        sweeps.append(sweep(form.case(), integrator, 5e-3 if quick else 1e-3))
    return finding("Other linear laws", sweeps, 5e-3 if quick else 1e-3, [])

"""Every contact law of the folder once, in a ContactLaw that lets it act: for tests that hold for all laws alike.

Numbers suit spheres of 5 mm and 1.3 g that overlap by some 50 um: a normal force of half a newton.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from demsolver import ContactLaw, contact
from demsolver.bind_law import law_coefficients

STEP_LAWS = tuple(name for name in contact.listing("normal") if contact.is_step_law(name))
HERTZIAN = ("mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force")

# A coefficient means what its law says it means: the first line that fits counts.
VALUES: Mapping[str, float] = {
    "normal_hertz.kn": 3e7, "normal_dmt.kn": 3e7, "kn": 1e4, "normal_jkr.yeff": 2e7, "yeff": 1e7, "characteristic_velocity": 1.0,
    "surface_energy": 1.0, "restitution": 0.7, "damping_mass_velocity.gamman": 700.0, "damping_viscoelastic.gamman": 2e6, "gamman": 0.5,
    "damping_fraction": 0.2, "log_restitution": -0.1, "critical_stokes": 100.0, "fluid_viscosity": 1e-3, "cohesion_energy_density": 3e4,
    "tangential_stiffness_mindlin.shear_stiffness": 8e6, "shear_stiffness": 3e3, "stiffness_ratio": 0.3, "tangential_damping_mass.gammat": 300.0,
    "tangential_damping_mass_radius.gammat": 1e6, "gammat": 0.2, "tangential_fraction": 0.2, "xt": 0.5, "mu": 0.4, "rolling_friction": 0.2,
    "rolling_stiffness": 3e3, "rolling_damping": 0.1, "rolling_damping_ratio": 0.3, "torsion": 0.0, "twisting_stiffness": 0.05,
    "twisting_damping": 2e-6, "twisting_friction": 3e-4,
}  # fmt: skip


def contact_law(shape: tuple[int, ...] = (1, 1), *, values: Mapping[str, float] | None = None, **names: str) -> ContactLaw:
    """A law of the named files, hooke with rotated history and contact arms where nothing is named; `values` overrule VALUES."""
    chosen = {
        "normal": "hooke", "damping": "none", "tangential_stiffness": "constant", "tangential_damping": "none", "friction": "rotated_history",
    } | names  # fmt: skip
    law = ContactLaw(**chosen, coefficients={}, surface_arm="contact", torque_arm="contact")  # type: ignore[arg-type]
    found = {}
    for name in law_coefficients(law):
        own = [f"{family}_{getattr(law, family)}.{name}" for family in contact.FAMILIES]
        key = next((k for k in own if k in VALUES), name)
        found[name] = (values or {}).get(name, VALUES[key]) * np.ones(shape)
    return ContactLaw(**chosen, coefficients=found, surface_arm="contact", torque_arm="contact")  # type: ignore[arg-type]


def around(family: contact.Family, name: str) -> dict[str, str]:
    """The other laws to put beside one so that it acts."""
    names: dict[str, str] = {family: name}
    if family == "normal" or name == "viscoelastic":
        names = {"normal": "hertz", "friction": "none"} | names
    if name in HERTZIAN:
        names = {"normal": "hertz", "tangential_stiffness": "mindlin"} | names
    if family == "tangential_damping":
        names = {"normal": "hertz", "friction": "liggghts_history"} | names
    return names


EVERY = [(family, name) for family in contact.FAMILIES for name in contact.listing(family)]


def every_law(family: contact.Family, name: str, shape: tuple[int, ...] = (1, 1), *, values: Mapping[str, float] | None = None) -> ContactLaw:
    """The law `family`/`name` among others that let it act."""
    return contact_law(shape, values=values, **around(family, name))

"""Contact laws, one a file: `<family>_<name>.py`, undecorated pure functions of scalars.

A law's parameter names say what it wants: a name in `GIVEN` is handed over by the kernel, a name in the law's own `MEMORY` is what the law
stored at the last step, every other name is a coefficient of the pair of types.

    overlap; radius of the particle, partner_curvature = 1/radius of the partner (0: wall); reff, meff; contact_radius = sqrt(reff overlap) unless
        the normal law has its own; n from partner to particle; vn < 0 on approach; vt surface velocity; w omega less the partner's, twist_rate = w.n
    normal_elastic, stiffness = normal_elastic/overlap, gn, normal_force (with damping, after limit_damping), kt, gt
    critical_force: what mu multiplies in a limit; |normal_force| unless the normal law, or tangential_reduce, says otherwise
    rolling_inertia: 1/I = 1/(f m_i R_i^2) + 1/(f m_j R_j^2), f = 1.4, or 1.5 in two dimensions
    arm_ratio: (R - overlap/2)/(R - overlap) at a wall, 1 in a pair
    dt; advance: False at set-up, when forces are computed but memories stay

What the entry function of a family returns, and what states its energy:

    normal                force(...) -> F > 0 apart; energy(...) with F = dE/d(overlap). Optional: contact_radius(...); critical_force(...);
                          reach(...), the gap up to which a contact that has touched goes on; or a step law, see below
    damping               coefficient(...) -> gn; takes gn vn^2
    cohesion              force(...) -> F, negative where it pulls; energy(...). Added behind limit_damping
    tangential_stiffness  stiffness(...) -> kt
    tangential_damping    coefficient(...) -> gt
    friction              force(...) -> fx, fy, fz, *memory; energy(...) of the spring
    rolling               torque(...) -> qx, qy, qz on the particle, *memory; energy(...). The partner feels the opposite, times its radius over the
                          particle's where the law says SCALES_WITH_RADIUS
    twisting              torque(...) -> q along n, *memory; energy(...)

MEMORY maps each stored name to its sign when the two particles change places.

A step law is a normal law that maps the state of a contact to the state of the next step. In place of `force` it has
step(...) -> F, shift, loss: the mean force over the coming step, all damping included (the damping law is "none"); by how much the overlap is made
smaller on top of what F does; the energy taken in this step. Its energy(...) may ask for vn, meff and dt.

An implicit law has, beside force and energy, solve(overlap, approach, compliance, ...) -> F, the mean force over the coming step, where the overlap
(negative: a gap) would grow by `approach` without it and grows by `compliance` less per unit of F. kernel_gradient.py takes such steps.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import sys
from collections.abc import Callable, Mapping
from functools import cache
from types import ModuleType
from typing import Literal

Family = Literal["normal", "damping", "cohesion", "tangential_stiffness", "tangential_damping", "friction", "rolling", "twisting"]
FAMILIES: tuple[Family, ...] = (
    "normal", "damping", "cohesion", "tangential_stiffness", "tangential_damping", "friction", "rolling", "twisting",
)  # fmt: skip
ENTRY: dict[Family, str] = {
    "normal": "force",
    "damping": "coefficient",
    "cohesion": "force",
    "tangential_stiffness": "stiffness",
    "tangential_damping": "coefficient",
    "friction": "force",
    "rolling": "torque",
    "twisting": "torque",
}
OPTIONAL: dict[Family, tuple[str, ...]] = {"normal": ("contact_radius", "critical_force", "reach", "solve")}
STORING: tuple[Family, ...] = ("normal", "cohesion", "friction", "rolling", "twisting")
REMEMBERING: tuple[Family, ...] = ("friction", "rolling", "twisting")
GIVEN = frozenset({
    "overlap", "radius", "partner_curvature", "reff", "meff", "contact_radius", "vn", "normal_elastic", "stiffness", "gn", "normal_force",
    "critical_force", "kt", "gt", "nx", "ny", "nz", "vtx", "vty", "vtz", "wx", "wy", "wz", "twist_rate", "rolling_inertia", "arm_ratio",
    "dt", "advance", "approach", "compliance",
})  # fmt: skip


def listing(family: Family) -> tuple[str, ...]:
    """Names of the laws of a family, read off the folder."""
    prefix = f"{family}_"
    found = (module.name for module in pkgutil.iter_modules(__path__))
    others = [f"{other}_" for other in FAMILIES if other != family and other.startswith(prefix)]
    return tuple(sorted(n.removeprefix(prefix) for n in found if n.startswith(prefix) and not n.startswith(tuple(others))))


def law(family: Family, name: str) -> ModuleType:
    """The module of one law. Raises ValueError naming the family, the name and what exists."""
    module = f"{__name__}.{family}_{name}"
    if module not in sys.modules and name not in listing(family):
        message = f"{family} law {name!r} is not one of {', '.join(listing(family))}"
        raise ValueError(message)
    return importlib.import_module(module)


def is_step_law(name: str) -> bool:
    """Whether a normal law maps a state to the next one, instead of giving the force of a state."""
    return hasattr(law("normal", name), "step")


def is_implicit(name: str) -> bool:
    """Whether a normal law solves for the mean force over the step."""
    return hasattr(law("normal", name), "solve")


def entry(family: Family, name: str) -> str:
    """The name of a law's main function."""
    return "step" if family == "normal" and is_step_law(name) else ENTRY[family]


def functions(family: Family, name: str) -> tuple[str, ...]:
    """The functions of a law: its entry, its energy where the family stores any, and the optional ones it has."""
    module = law(family, name)
    stored = ("energy",) if family in STORING else ()
    return (entry(family, name), *stored, *(f for f in OPTIONAL.get(family, ()) if hasattr(module, f)))


def memory(family: Family, name: str) -> Mapping[str, int]:
    """What a law stores from step to step: name -> sign on exchange of the particles."""
    found: Mapping[str, int] = law(family, name).MEMORY if family in REMEMBERING else {}
    return found


def parameters(family: Family, name: str, function: str | None = None) -> tuple[str, ...]:
    """Parameter names of one function of a law (its entry), in order."""
    return _signature(getattr(law(family, name), function or entry(family, name)))


@cache
def _signature(function: Callable[..., object]) -> tuple[str, ...]:
    return tuple(inspect.signature(function).parameters)


def coefficients(family: Family, name: str) -> tuple[str, ...]:
    """The parameters a law needs from the material: those nobody hands over and it does not store itself."""
    own = memory(family, name)
    asked = (p for function in functions(family, name) for p in parameters(family, name, function))
    return tuple(dict.fromkeys(p for p in asked if p not in GIVEN and p not in own))

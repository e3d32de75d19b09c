"""Contact laws, one a file: `<family>_<name>.py`, undecorated pure functions of scalars.

A law's parameter names say what it wants. The kernel hands over the names in `GIVEN`; every
other name is a coefficient of the pair of types.

    overlap, reff, meff, contact_radius = sqrt(reff overlap); vn < 0 on approach; n from partner to particle; vt surface velocity
    normal_elastic, stiffness = normal_elastic/overlap, gn, normal_force (with damping, after limit_damping), kt, gt
    s history; dt; advance: False at set-up, when forces are computed but histories stay
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from types import ModuleType
from typing import Literal

Family = Literal["normal", "damping", "tangential_stiffness", "tangential_damping", "friction"]
FAMILIES: tuple[Family, ...] = ("normal", "damping", "tangential_stiffness", "tangential_damping", "friction")
ENTRY: dict[Family, str] = {
    "normal": "force",
    "damping": "coefficient",
    "tangential_stiffness": "stiffness",
    "tangential_damping": "coefficient",
    "friction": "force",
}
GIVEN = frozenset({
    "overlap", "reff", "meff", "contact_radius", "vn", "normal_elastic", "stiffness", "gn", "normal_force", "kt", "gt",
    "nx", "ny", "nz", "vtx", "vty", "vtz", "sx", "sy", "sz", "dt", "advance",
})  # fmt: skip


def listing(family: Family) -> tuple[str, ...]:
    """Names of the laws of a family, read off the folder."""
    prefix = f"{family}_"
    found = (module.name for module in pkgutil.iter_modules(__path__))
    others = [f"{other}_" for other in FAMILIES if other != family and other.startswith(prefix)]
    return tuple(sorted(n.removeprefix(prefix) for n in found if n.startswith(prefix) and not n.startswith(tuple(others))))


def law(family: Family, name: str) -> ModuleType:
    """The module of one law. Raises ValueError naming the family, the name and what exists."""
    if name not in listing(family):
        message = f"{family} law {name!r} is not one of {', '.join(listing(family))}"
        raise ValueError(message)
    return importlib.import_module(f"{__name__}.{family}_{name}")


def parameters(family: Family, name: str) -> tuple[str, ...]:
    """Parameter names of a law's entry function, in order."""
    return tuple(inspect.signature(getattr(law(family, name), ENTRY[family])).parameters)


def coefficients(family: Family, name: str) -> tuple[str, ...]:
    """The parameters a law needs from the material: those the kernel does not hand over."""
    return tuple(p for p in parameters(family, name) if p not in GIVEN)

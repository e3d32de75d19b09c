"""One ContactLaw as the source of the functions the loop calls: its laws chained, each called with the names in its own signature."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from demsolver import contact
from demsolver.scene import ContactLaw
from demsolver.state import Floats

SIGNATURE = (
    "memory, k, overlap, radius, partner_curvature, reff, meff, rolling_inertia, arm_ratio, vn, nx, ny, nz, vtx, vty, vtz, wx, wy, wz, "
    "dt, advance, push, coefficients, row"
)
ASKED: dict[str, contact.Family] = {"gt": "tangential_damping", "kt": "tangential_stiffness"}  # in this order: a dashpot may ask for kt
STORED = "memory, k, overlap, radius, partner_curvature, reff, meff, vn, dt, coefficients, row"


def in_use(law: ContactLaw) -> tuple[contact.Family, ...]:
    """The families that `law` needs: those it names, and the tangential spring and dashpot if one of these asks for kt or gt."""
    optional: tuple[contact.Family, ...] = ("cohesion", *contact.REMEMBERING)
    named: list[contact.Family] = ["normal", "damping", *(family for family in optional if getattr(law, family) != "none")]
    for wanted, family in ASKED.items():
        if any(wanted in _asked(law, other) for other in named):
            named.append(family)
    return tuple(family for family in contact.FAMILIES if family in named)


def _asked(law: ContactLaw, family: contact.Family) -> set[str]:
    name = getattr(law, family)
    return {p for function in contact.functions(family, name) for p in contact.parameters(family, name, function)}


def law_coefficients(law: ContactLaw) -> tuple[str, ...]:
    """Names of the coefficients that the laws of `law` need, each once, in the order of the families."""
    return tuple(dict.fromkeys(c for family in in_use(law) for c in contact.coefficients(family, getattr(law, family))))


def coefficient_table(law: ContactLaw) -> Floats:
    """(rows, c) table: one row a type pair (or type, for a wall), one column a coefficient. Raises ValueError for a missing one."""
    names = law_coefficients(law)
    missing = [name for name in names if name not in law.coefficients]
    if missing:
        message = f"coefficient {missing[0]!r} of the contact law is missing; given: {', '.join(law.coefficients) or 'none'}"
        raise ValueError(message)
    rows = max((np.size(law.coefficients[name]) for name in names), default=1)
    return np.column_stack([np.ravel(law.coefficients[name]) for name in names]) if names else np.zeros((rows, 1))


def memory_signs(law: ContactLaw | None) -> Floats:
    """(m,) sign of each column of the law's memory when the two particles change places; m columns."""
    families = in_use(law) if law else ()
    return np.array([float(sign) for family in families for sign in contact.memory(family, getattr(law, family)).values()])


def is_step_law(law: ContactLaw) -> bool:
    """Whether the normal law is a step law."""
    return contact.is_step_law(law.normal)


def is_implicit(law: ContactLaw) -> bool:
    """Whether the normal law solves for the mean force over the step."""
    return contact.is_implicit(law.normal)


def goes_beyond(law: ContactLaw) -> bool:
    """Whether a contact of this law can go on where the spheres do not overlap any more."""
    return "reach" in contact.functions("normal", law.normal)


def longest_reach(law: ContactLaw, reff: float) -> float:
    """How far beyond touching contacts of this effective radius go on: the most of all pairs of types."""
    if not goes_beyond(law):
        return 0.0
    names = contact.parameters("normal", law.normal, "reach")
    columns = np.broadcast_arrays(*(np.ravel(reff if name == "reff" else law.coefficients[name]) for name in names))
    return max(float(contact.law("normal", law.normal).reach(*row)) for row in zip(*columns, strict=True))


def check_law(law: ContactLaw) -> None:
    """Raises ValueError for laws that do not go together."""
    if is_implicit(law) and law.cohesion != "none":
        message = f"normal law {law.normal} cannot be solved for together with cohesion {law.cohesion}"
        raise ValueError(message)
    if not is_step_law(law):
        return
    if law.damping != "none":
        message = f"normal law {law.normal} holds all damping in its step: damping must be none, not {law.damping}"
        raise ValueError(message)
    for family in in_use(law):
        name = getattr(law, family)
        if family != "normal" and {"stiffness", "normal_elastic", "gn"} & set(contact.parameters(family, name)):
            message = f"{family} law {name} asks for the spring or the dashpot of a state, which the step law {law.normal} does not have"
            raise ValueError(message)


def contact_source(name: str, law: ContactLaw, *, one: bool = False, lanes: bool = False) -> str:
    """Source of `<name>_contact`, `<name>_stored`, `<name>_reach`, `<name>_rolling_share` and, of implicit laws, `<name>_solve`.

    one: the coefficients come as one row, the same for all types, not as a table. lanes: `<name>_contact` finds the memory of contact k in
    lane k of a block (kernel_contact.py), not in row k of a table.
    """
    check_law(law)
    parts = [_contact, _stored, _reach, _rolling_share, *([_solve] if is_implicit(law) else [])]
    sources = ["\n".join(part(name, law)) for part in parts]
    if lanes:
        sources[0] = re.sub(r"memory\[k, (\d+)\]", r"memory[np.uint64(\1 * BLOCK) + k]", sources[0])
    text = "\n\n".join(sources) + "\n\n"
    return text.replace("coefficients[row, ", "coefficients[") if one else text


def _call(name: str, law: ContactLaw, family: contact.Family, function: str | None = None) -> str:
    chosen = getattr(law, family)
    function = function or contact.entry(family, chosen)
    return f"{name}_{family}_{function}({', '.join(contact.parameters(family, chosen, function))})"


def _coefficients(law: ContactLaw) -> list[str]:
    return [f"    {c} = coefficients[row, {k}]" for k, c in enumerate(law_coefficients(law))]


def _memory_names(law: ContactLaw) -> tuple[str, ...]:
    return tuple(name for family in in_use(law) for name in contact.memory(family, getattr(law, family)))


def _recall(law: ContactLaw) -> list[str]:
    return [f"    {name} = memory[k, {column}]" for column, name in enumerate(_memory_names(law))]


def _contact_radius(name: str, law: ContactLaw) -> str:
    own = "contact_radius" in contact.functions("normal", law.normal)
    return f"    contact_radius = {_call(name, law, 'normal', 'contact_radius') if own else 'sqrt(reff * overlap)'}"


def _normal(name: str, law: ContactLaw) -> list[str]:
    if is_step_law(law):
        return [f"    normal_force, shift, loss = {_call(name, law, 'normal')}", "    normal_elastic = normal_force"]
    return [
        f"    normal_elastic = {_call(name, law, 'normal')}",
        "    stiffness = normal_elastic / overlap if overlap > 0.0 else 0.0",
        f"    gn = {_call(name, law, 'damping')}",
        "    normal_force = normal_elastic - gn * vn",
        *(["    normal_force = max(normal_force, 0.0)"] if law.limit_damping else []),
        "    shift = loss = 0.0",
    ]


def _limit(name: str, law: ContactLaw) -> str:
    if "critical_force" in contact.functions("normal", law.normal):
        return f"    critical_force = push * {_call(name, law, 'normal', 'critical_force')}"
    return f"    critical_force = push * abs(normal_force{' + cohesive_force' if law.tangential_reduce else ''})"


def _contact(name: str, law: ContactLaw) -> list[str]:
    families = in_use(law)

    def remembering(family: contact.Family, results: str, nothing: str) -> str:
        if family not in families:
            return f"    {nothing}"
        return f"    {', '.join([results, *contact.memory(family, getattr(law, family))])} = {_call(name, law, family)}"

    return [
        "@inlined",
        f"def {name}_contact({SIGNATURE}):",
        *_coefficients(law),
        *_recall(law),
        _contact_radius(name, law),
        *_normal(name, law),
        f"    cohesive_force = {_call(name, law, 'cohesion') if 'cohesion' in families else '0.0'}",
        _limit(name, law),
        *([f"    kt = {_call(name, law, 'tangential_stiffness')}"] if "tangential_stiffness" in families else []),
        *([f"    gt = {_call(name, law, 'tangential_damping')}"] if "tangential_damping" in families else []),
        remembering("friction", "fx, fy, fz", "fx = fy = fz = 0.0"),
        remembering("rolling", "qx, qy, qz", "qx = qy = qz = 0.0"),
        *(["    twist_rate = wx * nx + wy * ny + wz * nz"] if "twisting" in families else []),
        remembering("twisting", "twist", "twist = 0.0"),
        *(["    qx, qy, qz = qx + twist * nx, qy + twist * ny, qz + twist * nz"] if "twisting" in families else []),
        *(f"    memory[k, {column}] = {stored}" for column, stored in enumerate(_memory_names(law))),
        "    return normal_force + cohesive_force, normal_force - normal_elastic, fx, fy, fz, qx, qy, qz, shift, loss",
    ]


def _stored(name: str, law: ContactLaw) -> list[str]:
    families = in_use(law)
    spring = f"    normal_elastic = {'0.0' if is_step_law(law) else _call(name, law, 'normal')}"
    energies = {family: _call(name, law, family, "energy") if family in families else "0.0" for family in contact.STORING}
    return [
        "@compiled",
        f"def {name}_stored({STORED}):",
        *_coefficients(law),
        *_recall(law),
        _contact_radius(name, law),
        spring,
        "    stiffness = normal_elastic / overlap if overlap > 0.0 else 0.0",
        *([f"    kt = {_call(name, law, 'tangential_stiffness')}"] if "tangential_stiffness" in families else []),
        f"    return {energies['normal']} + {energies['cohesion']}, {energies['friction']}, {energies['rolling']} + {energies['twisting']}",
    ]


def _reach(name: str, law: ContactLaw) -> list[str]:
    gap = _call(name, law, "normal", "reach") if goes_beyond(law) else "0.0"
    return ["@inlined", f"def {name}_reach(reff, coefficients, row):", *_coefficients(law), f"    return {gap}"]


def _rolling_share(name: str, law: ContactLaw) -> list[str]:
    scales = law.rolling != "none" and getattr(contact.law("rolling", law.rolling), "SCALES_WITH_RADIUS", False)
    return ["@inlined", f"def {name}_rolling_share(radius, partner_radius):", f"    return {'partner_radius / radius' if scales else '1.0'}"]


def _solve(name: str, law: ContactLaw) -> list[str]:
    head = ["@compiled", f"def {name}_solve(overlap, approach, compliance, coefficients, row):"]
    return [*head, *_coefficients(law), f"    return {_call(name, law, 'normal', 'solve')}"]


def law_functions(name: str, law: ContactLaw) -> dict[str, Callable[..., object]]:
    """The plain Python functions that `contact_source` calls, by the names it calls them."""
    return {
        f"{name}_{family}_{function}": getattr(contact.law(family, getattr(law, family)), function)
        for family in in_use(law)
        for function in contact.functions(family, getattr(law, family))
    }


def law_imports(name: str, law: ContactLaw) -> str:
    """Source that binds `law_functions` in the generated module."""
    lines = [f"{key} = inlined({f.__module__}.{f.__name__})" for key, f in law_functions(name, law).items()]
    return "\n".join([*(f"import {m}" for m in sorted({f.__module__ for f in law_functions(name, law).values()})), *lines]) + "\n"

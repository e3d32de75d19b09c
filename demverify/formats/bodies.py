"""Columns of the body dumps of clumps: LIGGGHTS' `compute multisphere property P` and LAMMPS' `compute rigid/local`, as `dump local` writes them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from demsolver.scene import Box, Clumps
from demverify.deck.setup import Spec
from demverify.errors import InputError, Place
from demverify.frames import Floats, Frame

COLUMN = re.compile(r"c_([^\[\]]+)(?:\[(\d+|\*)\])?$")
STYLES = ("multisphere", "rigid/local")


@dataclass(frozen=True)
class Bodies:
    """The clumps at one step, and the force and torque (m, 3) on each."""

    clumps: Clumps
    box: Box
    force: Floats
    torque: Floats


PROPERTIES: dict[str, Callable[[Bodies], np.ndarray]] = {
    "id_multisphere": lambda b: b.clumps.id,
    "masstotal": lambda b: b.clumps.mass,
    "xcm": lambda b: _wrapped(b)[0],
    "vcm": lambda b: b.clumps.v,
    "omega": lambda b: b.clumps.omega,
    "angmom": lambda b: b.clumps.angmom,
    "quat": lambda b: b.clumps.quat,
    "inertia": lambda b: b.clumps.inertia,
    "fcm": lambda b: b.force,
    "torquecm": lambda b: b.torque,
}
"""LIGGGHTS' properties -> (m,) or (m, c)."""


def _wrapped(b: Bodies) -> tuple[Floats, Floats]:
    """Centres of mass in the box (m, 3), and how many boxes they are away from it."""
    edge = np.asarray(b.box.hi) - np.asarray(b.box.lo)
    turns = np.where(b.box.periodic, np.floor((b.clumps.x - b.box.lo) / edge), 0.0)
    return b.clumps.x - turns * edge, turns


def _vector(prefix: str, get: Callable[[Bodies], np.ndarray], ends: str = "xyz") -> dict[str, Callable[[Bodies], np.ndarray]]:
    return {prefix + end: (lambda b, i=i: get(b)[:, i]) for i, end in enumerate(ends)}  # type: ignore[misc]


ATTRIBUTES: dict[str, Callable[[Bodies], np.ndarray]] = {
    "mol": lambda b: b.clumps.id,
    "mass": lambda b: b.clumps.mass,
    **_vector("", lambda b: _wrapped(b)[0]),
    **{f"{axis}u": get for axis, get in _vector("", lambda b: b.clumps.x).items()},
    **_vector("i", lambda b: _wrapped(b)[1]),
    **_vector("v", lambda b: b.clumps.v),
    **_vector("f", lambda b: b.force),
    **_vector("omega", lambda b: b.clumps.omega),
    **_vector("angmom", lambda b: b.clumps.angmom),
    **_vector("quat", lambda b: b.clumps.quat, "wijk"),
    **_vector("tq", lambda b: b.torque),
    **_vector("inertia", lambda b: b.clumps.inertia),
}
"""LAMMPS' attributes -> (m,)."""


def check_compute(spec: Spec) -> None:
    """Raises InputError for a compute of bodies whose words are not known."""
    what = f"compute {spec.id} {spec.style}"
    if spec.style == "multisphere":
        if len(spec.args) != 2 or spec.args[0] != "property" or spec.args[1] not in PROPERTIES:
            raise InputError(f"{what} expects property {' | '.join(PROPERTIES)}, got {' '.join(spec.args) or 'nothing'}", spec.place)
    elif wrong := [name for name in spec.args[1:] if name not in ATTRIBUTES]:
        raise InputError(f"{what}: attribute {wrong[0]!r} is not one of {', '.join(ATTRIBUTES)}", spec.place)
    elif len(spec.args) < 2:
        raise InputError(f"{what} expects a fix and attributes", spec.place)


def expanded(names: Sequence[str], computes: Mapping[str, Spec], place: Place) -> tuple[str, ...]:
    """The columns with c_ID[*] written out. Raises InputError for one that is not of a compute of bodies."""
    return tuple(column for name in names for column in _expanded(name, computes, place))


def _expanded(name: str, computes: Mapping[str, Spec], place: Place) -> Iterator[str]:
    found = COLUMN.fullmatch(name)
    spec = computes.get(found[1]) if found else None
    if found is None or spec is None or spec.style not in STYLES:
        known = ", ".join(f"c_{one.id}" for one in computes.values() if one.style in STYLES) or "none"
        raise InputError(f"dump local: column {name!r} is not of a compute {' or '.join(STYLES)}; there are: {known}", place)
    width = _width(spec)
    if found[2] == "*":
        yield from (f"c_{spec.id}[{k}]" for k in range(1, width + 1))
        return
    alone = (0,) if spec.style == "multisphere" else (0, 1)
    if int(found[2] or 0) not in (alone if width == 1 else range(1, width + 1)):
        raise InputError(f"dump local: {name}: this compute has c_{spec.id}{'' if width == 1 else f'[1] to c_{spec.id}[{width}]'}", place)
    yield name


def _width(spec: Spec) -> int:
    if spec.style == "rigid/local":
        return len(spec.args) - 1
    return {"quat": 4, "id_multisphere": 1, "masstotal": 1}.get(spec.args[1], 3)


def body_frame(step: int, bodies: Bodies, names: Sequence[str], computes: Mapping[str, Spec]) -> Frame:
    """One frame of a dump local: the named columns, a row a clump."""
    columns = {name: np.asarray(_column(bodies, name, computes), dtype=np.float64) for name in names}
    return Frame(step, np.column_stack([bodies.box.lo, bodies.box.hi]).astype(np.float64), bodies.box.boundary, columns)


def _column(bodies: Bodies, name: str, computes: Mapping[str, Spec]) -> np.ndarray:
    found = COLUMN.fullmatch(name)
    assert found
    spec, index = computes[found[1]], int(found[2] or 1)
    if spec.style == "rigid/local":
        return ATTRIBUTES[spec.args[index]](bodies)
    values = PROPERTIES[spec.args[1]](bodies)
    return values if values.ndim == 1 else values[:, index - 1]

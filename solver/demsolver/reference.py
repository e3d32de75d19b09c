"""Contact forces of a scene in plain Python and numpy: every pair, every wall, no neighbour list, no compiler.

Written to be read next to the laws: geometry here, physics in `demsolver/contact`, each law called with what its signature names.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demsolver import contact
from demsolver.bind_law import in_use
from demsolver.expression import COLUMNS, value
from demsolver.scene import AddForce, Box, ContactLaw, Cylinder, Freeze, Plane, Rotation, Scene, Slab, Wall

Floats = NDArray[np.float64]
Key = tuple[str, int, int]
History = Mapping[Key, Floats]
"""Memory (m,) of the law of each contact: ("pair", i, j), i < j, as felt by i; (wall name, its number, i). Rows from 0. A contact that is
there has an entry, also where its law remembers nothing."""

TOUCHING = 1e-200  # overlap offered to the laws at exactly zero gap, so that secant stiffnesses have their limit


@dataclass(frozen=True)
class Touch:
    """One contact as particle i feels it. n: (3,) unit normal towards i. v: (3,) velocity against the partner's centre or the
    wall. spin: (3,) sum of arm times omega. w: (3,) omega less the partner's. partner: row of the other particle, or None. radius: of i;
    partner_radius: inf for a wall."""

    key: Key
    law: ContactLaw
    row: int | tuple[int, int]
    i: int
    partner: int | None
    n: Floats
    overlap: float
    reff: float
    meff: float
    v: Floats
    spin: Floats
    w: Floats
    radius: float
    partner_radius: float
    rolling_inertia: float


@dataclass(frozen=True)
class Action:
    """What one contact does to particle i: normal force, tangential force (3,), rolling and twisting torque (3,), correction of the overlap
    by a step law, the energy that step takes, and the new memory of the law."""

    normal: float
    tangential: Floats
    rolling: Floats
    shift: float
    loss: float
    memory: Floats


def forces(
    scene: Scene, x: Floats, v: Floats, omega: Floats, history: History, advance: bool
) -> tuple[Floats, Floats, dict[Key, Floats]]:
    """Force (n, 3), torque (n, 3) and the new history of all contacts at x, v, omega, each (n, 3).

    advance False is the set-up of a run: histories are read but do not grow. The history of a parted wall contact ends; that
    of a parted pair too, unless the scene says that history outlives the contact.
    """
    force, torque = np.zeros_like(x), np.zeros_like(x)
    kept = dict(history) if scene.history_outlives_contact else {}
    new = {key: s for key, s in kept.items() if key[0] == "pair"}
    scene = scene if advance else _at_setup(scene)
    radius = scene.particles.radius
    for touch in touches(scene, x, v, omega, history):
        act = action(touch, history.get(touch.key), scene.timestep, advance)
        new[touch.key] = act.memory
        pull = act.normal * touch.n + act.tangential
        turn = -np.cross(touch.n, act.tangential)
        force[touch.i] += pull
        torque[touch.i] += _arm(touch.law.torque_arm, radius[touch.i], touch.overlap) * turn + act.rolling
        if touch.partner is not None:
            force[touch.partner] -= pull
            torque[touch.partner] += _arm(touch.law.torque_arm, radius[touch.partner], touch.overlap) * turn - _share(touch) * act.rolling
    return force, torque, new


def _at_setup(scene: Scene) -> Scene:
    """The scene with the walls at rest that a set-up finds so."""
    return replace(scene, walls=tuple(_still(wall) for wall in scene.walls))


def _still(wall: Wall) -> Wall:
    shape = wall.shape
    if not isinstance(shape, Cylinder) or shape.rotation is None or not shape.rotation.still_at_setup:
        return wall
    return replace(wall, shape=replace(shape, rotation=None))


def added(scene: Scene, x: Floats, v: Floats) -> Floats:
    """What the added forces of the scene do at x, v, each (n, 3): their sum (n, 3); NaN where a formula has no finite value."""
    p, force = scene.particles, np.zeros_like(x)
    for field in scene.forces:
        if isinstance(field, AddForce):
            for i in np.flatnonzero((p.mask >> field.bit) & 1):
                known = dict(zip(COLUMNS, (*x[i], *v[i], p.mass[i], p.radius[i], p.type[i]), strict=True))
                force[i] += [value(component, known) for component in field.force]
    return force


def _share(touch: Touch) -> float:
    """The partner's rolling torque over the particle's."""
    scales = touch.law.rolling != "none" and getattr(_law("rolling", touch.law.rolling), "SCALES_WITH_RADIUS", False)
    return touch.partner_radius / touch.radius if scales else 1.0


def _arm(kind: str, radius: float, overlap: float) -> float:
    return radius - 0.5 * overlap if kind == "contact" else radius


def touches(scene: Scene, x: Floats, v: Floats, omega: Floats, history: History) -> Iterator[Touch]:
    """All contacts at x, v, omega; `history` says which there were at the last step."""
    if scene.pair is not None:
        for i in range(len(x)):
            for j in range(i + 1, len(x)):
                yield from _pair_touch(scene, scene.pair, i, j, x, v, omega, history)
    for number, wall in enumerate(scene.walls):
        for i in range(len(x)):
            if (scene.particles.mask[i] >> wall.bit) & 1:
                yield from _wall_touch(scene, wall, number, i, x, v, omega, history)


def _beyond(law: ContactLaw, row: int | tuple[int, int], reff: float, touched: bool) -> float:
    """How far beyond touching the contact goes on."""
    reach = getattr(_law("normal", law.normal), "reach", None)
    return float(_call(reach, _coefficients(law, row) | {"reff": reff})) if reach and touched else 0.0


def _pair_touch(
    scene: Scene, law: ContactLaw, i: int, j: int, x: Floats, v: Floats, omega: Floats, history: History
) -> Iterator[Touch]:
    p = scene.particles
    ri, rj = float(p.radius[i]), float(p.radius[j])
    d = _nearest(scene.box, x[i] - x[j])
    square = float(d @ d)
    row = (int(p.type[i]) - 1, int(p.type[j]) - 1)
    reff, meff = ri * rj / (ri + rj), _pair_mass(scene, i, j)
    if square >= (ri + rj + _beyond(law, row, reff, ("pair", i, j) in history)) ** 2:
        return
    overlap = ri + rj - sqrt(square)
    spin = _arm(law.surface_arm, ri, overlap) * omega[i] + _arm(law.surface_arm, rj, overlap) * omega[j]
    inertia = scene.rolling_inertia / (1.0 / (p.mass[i] * ri * ri) + 1.0 / (p.mass[j] * rj * rj))
    n = d / sqrt(square)
    yield Touch(("pair", i, j), law, row, i, j, n, overlap, reff, meff, v[i] - v[j], spin, omega[i] - omega[j], ri, rj, inertia)


def _nearest(box: Box, d: Floats) -> Floats:
    size = box.hi - box.lo
    return np.where(box.periodic, d - size * np.round(d / size), d)


def _pair_mass(scene: Scene, i: int, j: int) -> float:
    mass, bits = scene.particles.mass, [f.bit for f in scene.forces if isinstance(f, Freeze)]
    frozen_i, frozen_j = (any((scene.particles.mask[k] >> bit) & 1 for bit in bits) for k in (i, j))
    if frozen_i or frozen_j:
        return float(mass[j] if frozen_i else mass[i])
    return float(mass[i] * mass[j] / (mass[i] + mass[j]))


def _wall_touch(
    scene: Scene, wall: Wall, number: int, i: int, x: Floats, v: Floats, omega: Floats, history: History
) -> Iterator[Touch]:
    radius, row, key = float(scene.particles.radius[i]), int(scene.particles.type[i]) - 1, (wall.name, number, i)
    away = _away(wall.shape, x[i])
    distance, reff = sqrt(float(away @ away)), _wall_radius(wall.shape, x[i], radius)
    beyond = _beyond(wall.law, row, reff, key in history)
    if distance > radius + beyond or distance == 0.0 or (distance == radius + beyond and not wall.touch_closed):
        return
    overlap = radius - distance if beyond else max(radius - distance, TOUCHING)
    spin = _arm(wall.law.surface_arm, radius, overlap) * omega[i]
    mass = float(scene.particles.mass[i])
    against = v[i] - np.array(wall.velocity) - _shape_velocity(wall.shape, x[i], away)
    inertia = scene.rolling_inertia * mass * radius**2
    rotation = _rotation(wall.shape)
    turning = np.array(wall.shape.omega) if isinstance(wall.shape, Plane) else _spin(wall.shape) if rotation and rotation.rolls else np.zeros(3)
    yield Touch(key, wall.law, row, i, None, away / distance, overlap, reff, mass, against, spin, omega[i] - turning, radius, np.inf, inertia)


def _away(shape: Slab | Cylinder | Plane, x: Floats) -> Floats:
    """Vector from the nearest point of the wall to x."""
    if isinstance(shape, Plane):
        normal = np.array(shape.normal)
        high = float(x @ normal + shape.offset)
        away: Floats = high / float(normal @ normal) * normal
        return 0.0 * away if shape.one_sided and high < 0.0 else away
    return _slab(shape, x) if isinstance(shape, Slab) else _cylinder(shape, x)


def _shape_velocity(shape: Slab | Cylinder | Plane, x: Floats, away: Floats) -> Floats:
    """Velocity by its own motion of a wall that a particle at x touches at x - away; planes stand where the scene has them."""
    if isinstance(shape, Plane):
        return np.array(shape.velocity) + np.cross(shape.omega, x - away - np.array(shape.pivot))
    rotation = _rotation(shape)
    if not isinstance(shape, Cylinder) or rotation is None:
        return np.zeros(3)
    center = np.zeros(3)
    center[[(shape.axis + 1) % 3, (shape.axis + 2) % 3]] = shape.center
    return np.asarray(np.cross(_spin(shape), (x - away if rotation.at == "surface" else x) - center))


def _rotation(shape: Slab | Cylinder | Plane) -> Rotation | None:
    return shape.rotation if isinstance(shape, Cylinder) else None


def _spin(shape: Slab | Cylinder) -> Floats:
    """Angular velocity (3,) of a cylinder that turns."""
    rotation = _rotation(shape)
    return np.asarray((rotation.rate if rotation else 0.0) * np.eye(3)[shape.axis])


def _slab(slab: Slab, x: Floats) -> Floats:
    """Vector from the nearer plane to x."""
    away = np.zeros(3)
    low, high = x[slab.axis] - slab.lo, slab.hi - x[slab.axis]
    away[slab.axis] = low if low < high else -high
    return away


def _across(cylinder: Cylinder, x: Floats) -> tuple[list[int], Floats]:
    axes = [(cylinder.axis + 1) % 3, (cylinder.axis + 2) % 3]
    return axes, x[axes] - np.array(cylinder.center)


def _cylinder(cylinder: Cylinder, x: Floats) -> Floats:
    """Vector from the nearest point of the surface to x; towards the axis from inside."""
    axes, d = _across(cylinder, x)
    off = sqrt(float(d @ d))
    away = np.zeros(3)
    felt = cylinder.side == "both" or (off < cylinder.radius) == (cylinder.side == "in")
    away[axes] = d * ((off - cylinder.radius) / off) if off > 0.0 and felt else 0.0
    return away


def _wall_radius(shape: Slab | Cylinder | Plane, x: Floats, radius: float) -> float:
    if not isinstance(shape, Cylinder) or shape.effective_radius == "flat":
        return radius
    _, d = _across(shape, x)
    rw = 2.0 * shape.radius * (-1.0 if float(d @ d) < shape.radius**2 else 1.0)
    return radius * rw / (radius + rw)


def action(touch: Touch, memory: Floats | None, dt: float, advance: bool) -> Action:
    """What a contact does; memory (m,) of its law, None for a new contact."""
    law = touch.law
    names = {family: tuple(contact.memory(family, getattr(law, family))) for family in contact.REMEMBERING if getattr(law, family) != "none"}
    slots = [name for family in names.values() for name in family]
    known = _geometry(touch) | {"dt": dt, "advance": advance} | dict(zip(slots, np.zeros(len(slots)) if memory is None else memory, strict=True))
    shift, loss = _normal(law, known)
    cohesive = _call(_law("cohesion", law.cohesion).force, known) if law.cohesion != "none" else 0.0
    known["critical_force"] = _critical(law, known, cohesive)
    _tangential(law, known)
    found = {family: _remembering(law, family, known) for family in names}
    rolling = np.array(found.get("rolling", np.zeros(3))[:3])
    if "twisting" in found:
        rolling = rolling + found["twisting"][0] * touch.n
    stored = [value for family, own in names.items() for value in found[family][len(found[family]) - len(own) :]]
    return Action(known["normal_force"] + cohesive, np.array(found.get("friction", np.zeros(3))[:3]), rolling, shift, loss, np.array(stored))


def stored(touch: Touch, memory: Floats, dt: float) -> tuple[float, float, float]:
    """Energy that a contact holds: (normal and cohesion, friction, rolling and twisting)."""
    law, known = touch.law, _geometry(touch) | {"dt": dt}
    families = in_use(law)
    names = [name for family in families for name in contact.memory(family, getattr(law, family))]
    known |= dict(zip(names, memory, strict=True))
    if not contact.is_step_law(law.normal):
        _normal(law, known)
    _tangential(law, known)
    found = {f: float(_call(_law(f, getattr(law, f)).energy, known)) for f in contact.STORING if f in families}
    normal = found["normal"] + found.get("cohesion", 0.0)
    return normal, found.get("friction", 0.0), found.get("rolling", 0.0) + found.get("twisting", 0.0)


def _geometry(touch: Touch) -> dict[str, Any]:
    """What the laws can know of a contact before any force."""
    n, w = touch.n, touch.w
    vn = float(touch.v @ n)
    vt = touch.v - vn * n - np.cross(touch.spin, n)
    known = _coefficients(touch.law, touch.row)
    known |= dict(zip(("nx", "ny", "nz", "vtx", "vty", "vtz", "wx", "wy", "wz"), map(float, (*n, *vt, *w)), strict=True))
    known |= {"overlap": touch.overlap, "radius": touch.radius, "partner_curvature": 1.0 / touch.partner_radius}
    known |= {"reff": touch.reff, "meff": touch.meff}
    ratio = (touch.radius - 0.5 * touch.overlap) / (touch.radius - touch.overlap) if touch.partner is None else 1.0
    known |= {"vn": vn, "rolling_inertia": touch.rolling_inertia, "arm_ratio": ratio, "twist_rate": float(w @ n)}
    own = getattr(_law("normal", touch.law.normal), "contact_radius", None)
    return known | {"contact_radius": _call(own, known) if own else sqrt(touch.reff * touch.overlap)}


def _normal(law: ContactLaw, known: dict[str, Any]) -> tuple[float, float]:
    """Fills in the normal force and what it is made of; returns the shift and the loss of a step law."""
    module = _law("normal", law.normal)
    if contact.is_step_law(law.normal):
        known["normal_force"], shift, loss = _call(module.step, known)
        return shift, loss
    known["normal_elastic"] = _call(module.force, known)
    known["stiffness"] = known["normal_elastic"] / known["overlap"] if known["overlap"] > 0.0 else 0.0
    known["gn"] = _call(_law("damping", law.damping).coefficient, known)
    fn = known["normal_elastic"] - known["gn"] * known["vn"]
    known["normal_force"] = max(fn, 0.0) if law.limit_damping else fn
    return 0.0, 0.0


def _critical(law: ContactLaw, known: Mapping[str, Any], cohesive: float) -> float:
    own = getattr(_law("normal", law.normal), "critical_force", None)
    return float(_call(own, known)) if own else abs(known["normal_force"] + (cohesive if law.tangential_reduce else 0.0))


def _tangential(law: ContactLaw, known: dict[str, Any]) -> None:
    families = in_use(law)
    if "tangential_stiffness" in families:
        known["kt"] = _call(_law("tangential_stiffness", law.tangential_stiffness).stiffness, known)
    if "tangential_damping" in families:
        known["gt"] = _call(_law("tangential_damping", law.tangential_damping).coefficient, known)


def _remembering(law: ContactLaw, family: contact.Family, known: Mapping[str, Any]) -> tuple[float, ...]:
    result = _call(getattr(_law(family, getattr(law, family)), contact.ENTRY[family]), known)
    return result if isinstance(result, tuple) else (result,)


def _coefficients(law: ContactLaw, row: int | tuple[int, int]) -> dict[str, Any]:
    return {name: float(table[row]) for name, table in law.coefficients.items()}


def _call(law: Callable[..., Any], known: Mapping[str, Any]) -> Any:
    return law(*(known[name] for name in _parameters(law)))


@cache
def _parameters(law: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(inspect.signature(law).parameters)


_law = cache(contact.law)

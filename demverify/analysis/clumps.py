"""Rigid bodies from the spheres that are their members, as dumps of particles list them.

Members carry the angular velocity of their body in both engines (LIGGGHTS fix_multisphere.cpp, set_v; LAMMPS fix_rigid.cpp, set_v, there
only spheres, not points). What else they carry is a convention of the engine:

    LIGGGHTS fix multisphere    the mass of the whole body; its inertia is that of the union of the spheres
    LAMMPS fix rigid            the mass of the sphere; inertia as if spheres did not overlap, seed compute-erotate, eq. (5)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.population import Population, RigidBodies
from demsolver.shapes.multisphere import Template, solid_of
from demsolver.shapes.rotation import quaternion
from demsolver.shapes.union import steiner
from demverify.analysis.congruence import Placed, Tolerance, alike, by_template
from demverify.analysis.meanings import Meanings
from demverify.analysis.needed import POSITIONS
from demverify.errors import InputError
from demverify.frames import UNKNOWN_BOUNDARY, Floats, Frame

Ints = NDArray[np.int64]
Inertia = Literal["union", "spheres"]

DIGITS = 1e-5
"""What equal numbers may differ by, relative to the largest of their kind: `%g` prints six digits, so each is off by up to 5e-6."""
_IN_LINE = 1e-6
"""Centres count as in one line when their least moment is less than this part of the greatest."""


@dataclass(frozen=True)
class _Members:
    """m bodies of k spheres each, in each row by id. body: (m,). x: (m, k, 3), in one piece. mass, v, omega: None: not known.

    reach: the largest coordinate of the frame, which tells how many decimals a position of six digits has.
    """

    body: Ints
    x: Floats
    radius: Floats
    mass: Floats | None
    v: Floats | None
    omega: Floats | None
    reach: float

    def rows(self, mine: Ints) -> _Members:
        """Some of the bodies."""
        columns: dict[str, Any] = {item.name: getattr(self, item.name) for item in fields(self)}
        some: dict[str, Any] = {name: column[mine] for name, column in columns.items() if isinstance(column, np.ndarray)}
        return replace(self, **some)


@dataclass(frozen=True)
class _Bodies:
    """mass: (m,). x: (m, 3), centre of mass. inertia: (m, 3, 3) about it, along the axes of space."""

    mass: Floats
    x: Floats
    inertia: Floats


@dataclass(frozen=True)
class _Conventions:
    """whole: a column `mass` holds the mass of the body, not of the sphere. column: the masses are from a column. union: the inertia is."""

    whole: bool
    column: bool
    union: bool


def rigid_bodies(
    population: Population,
    frame: Frame,
    meanings: Meanings,
    inertia: Inertia | None = None,
) -> RigidBodies:
    """The bodies whose members are in `population`, in the order of their numbers, with omega and, where the members have v, v.

    frame: the population's box, and which columns it had. inertia: "union" of a body's spheres; "spheres": seed compute-erotate, eq. (5);
    None: as the engine that wrote the dump. meanings.templates: the clumps there are; where there are none, bodies that are alike (to six
    digits) get the inertia of the first. Without a column mass: density times the volume of the union, or of each sphere.

    Raises InputError where a column is missing, where members do not turn or move as one body, and for a body that fits no template or
    reaches over half a periodic box.
    """
    _check_columns(population, frame)
    whole = _engine(frame, meanings) == "liggghts"
    conventions = _Conventions(whole, "mass" in frame.columns, whole if inertia is None else inertia == "union")
    parts = []
    for members in _by_size(population, frame):
        bodies = _unions(members, meanings.templates, conventions) if conventions.union else _sums(members, conventions)
        parts.append(_moving(members, bodies))
    return _joined(parts)


def _engine(frame: Frame, meanings: Meanings) -> Literal["lammps", "liggghts"]:
    """Whose conventions hold; of a file that does not show it, LIGGGHTS' where bodies are its multispheres."""
    dialect = meanings.dialect_of(frame)
    if dialect is not None:
        return dialect
    return "liggghts" if meanings.rigid == "multisphere" or "id_multisphere" in frame.columns else "lammps"


def _check_columns(population: Population, frame: Frame) -> None:
    missing = [names for names, values in (("x y z", population.x), ("radius", population.radius)) if values is None]
    if population.omega is None and population.v is None:
        missing.append("omegax omegay omegaz")
    if missing:
        message = f"erotate/multisphere needs the columns {' '.join(missing)} of the members, or a dump of bodies; got {' '.join(frame.columns)}"
        raise InputError(message)
    if population.shape is not None and population.body is not None and population.shape[population.body > 0].any():
        message = "members of rigid bodies have shapes of their own: expected spheres, or a dump of bodies (LAMMPS compute rigid/local)"
        raise InputError(message)


def _by_size(population: Population, frame: Frame) -> Iterator[_Members]:
    """The members, bodies of equally many spheres together."""
    body, x, radius = population.body, population.x, population.radius
    assert body is not None
    assert x is not None
    assert radius is not None
    reach = float(max(np.abs(x).max(initial=0.0), np.abs(frame.edges).max()))
    rows = np.flatnonzero(body > 0)
    rows = rows[np.lexsort((population.id[rows], body[rows]))]
    number, start, count = np.unique(body[rows], return_index=True, return_counts=True)
    for k in np.unique(count):
        mine = rows[start[count == k][:, None] + np.arange(k)]
        mass, v, omega = (None if values is None else values[mine] for values in (population.mass, population.v, population.omega))
        yield _Members(number[count == k], _in_one_piece(x[mine], number[count == k], frame), radius[mine], mass, v, omega, reach)


def _in_one_piece(x: Floats, body: Ints, frame: Frame) -> Floats:
    """Every member (m, k, 3) at the image that is nearest to the first of its body."""
    names = next((names for names in POSITIONS if all(name in frame.columns for name in names)), ("x",))
    periodic = np.array([faces == "pp" for faces in frame.boundary])
    maybe = frame.boundary == UNKNOWN_BOUNDARY and bool(np.isfinite(frame.edges).all())
    if names[0].endswith("u") or not (periodic.any() or maybe):
        return x
    arms = x - x[:, :1]
    turns = arms @ np.linalg.pinv(frame.edges)  # of a box without depth too
    if maybe:
        _check_none_reaches_far(turns, body)
        return x
    images = np.round(turns) * periodic
    turns -= images
    wide = ((np.ptp(turns, axis=1) >= 0.5) & periodic).any(axis=1)
    if wide.any():
        message = (
            f"body {body[wide][0]} reaches over half the periodic box, so x y z do not tell which images of its spheres belong together: "
            "expected the columns xu yu zu"
        )
        raise InputError(message)
    return np.asarray(x[:, :1] + (arms - images @ frame.edges))


def _check_none_reaches_far(turns: Floats, body: Ints) -> None:
    """Where the file does not tell whether its box is periodic, a body as long as half of it may be one whose spheres were wrapped."""
    far = (np.ptp(turns, axis=1) >= 0.5).any(axis=1)
    if far.any():
        message = (
            f"body {body[far][0]} reaches over half the box, and the file does not tell whether that is periodic: "
            "expected the columns xu yu zu, or a dump of another kind"
        )
        raise InputError(message)


def _sums(members: _Members, conventions: _Conventions) -> _Bodies:
    """Spheres as if they did not overlap; the mass of a whole body they share by their volumes."""
    mass = _mass(members)
    if conventions.whole and conventions.column:
        share = members.radius**3
        mass = _common(mass, members, "mass")[:, None] * share / share.sum(axis=1, keepdims=True)
    return _Bodies(*steiner(mass, members.x, members.radius))


def _unions(members: _Members, templates: tuple[Template, ...], conventions: _Conventions) -> _Bodies:
    points = (members.radius <= 0.0).any(axis=1)
    if points.any():
        message = f"a member of body {members.body[points][0]} has no radius above zero: expected spheres, or the inertia of spheres apart"
        raise InputError(message)
    m = len(members.body)
    bodies = _Bodies(np.empty(m), np.empty((m, 3)), np.empty((m, 3, 3)))
    for kind in _kinds(members, templates):
        solid = solid_of(kind.template)
        mass = _mass_of_union(members.rows(kind.rows), kind.template.density, solid.volume, conventions)
        bodies.mass[kind.rows] = mass
        bodies.x[kind.rows] = kind.points(solid.centroid)
        bodies.inertia[kind.rows] = kind.tensors(solid.inertia / solid.volume) * mass[:, None, None]
    return bodies


def _kinds(members: _Members, templates: tuple[Template, ...]) -> list[Placed]:
    """The bodies of each template; without templates, of each shape."""
    tolerance = Tolerance(min(DIGITS * members.reach, 0.1 * float(members.radius.min())), DIGITS)
    if not templates:
        return alike(members.x, members.radius, tolerance)
    kinds, others = by_template(members.x, members.radius, templates, tolerance)
    if len(others):
        there = ", ".join(f"type {one.kind} of {len(one.radius)} spheres" for one in templates)
        message = (
            f"body {members.body[others[0]]} has {members.x.shape[1]} spheres in this frame, which fit none of the templates ({there}): "
            "spheres are missing, or it is another clump"
        )
        raise InputError(message)
    return kinds


def _mass_of_union(members: _Members, density: float | None, volume: float, conventions: _Conventions) -> Floats:
    """Mass of each body, (m,): from the members' column, else density times volume; the template's density goes before the particles'."""
    if conventions.column:
        mass = _mass(members)
        return _common(mass, members, "mass") if conventions.whole else np.asarray(mass.sum(axis=1))
    if density is not None:
        return np.full(len(members.body), density * volume)
    spheres = 4.0 / 3.0 * np.pi * members.radius**3
    return _common(_mass(members) / spheres, members, "density") * volume


def _mass(members: _Members) -> Floats:
    if members.mass is None:
        message = "erotate/multisphere needs the column mass (or density, or --density X, --deck DECK) of the members, or a dump of bodies"
        raise InputError(message)
    return members.mass


def _common(values: Floats, members: _Members, what: str) -> Floats:
    """The value that all members of a body share, (m,)."""
    low, high = values.min(axis=1), values.max(axis=1)
    apart = high - low > DIGITS * np.abs(values).max(axis=1)
    if apart.any():
        i = int(np.argmax(apart))
        message = f"expected the same {what} for all spheres of body {members.body[i]}, got {low[i]:g} to {high[i]:g}"
        raise InputError(message)
    return np.asarray(values[:, 0])


def _moving(members: _Members, bodies: _Bodies) -> RigidBodies:
    """The bodies with their velocities, and principal axes."""
    omega = _omega(members)
    moments, axes = np.linalg.eigh(bodies.inertia)
    axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]
    v = None if members.v is None else _v(members, members.v, bodies.x, omega)
    return RigidBodies(members.body, np.maximum(moments, 0.0), quaternion(axes), bodies.mass, v, omega)


def _omega(members: _Members) -> Floats:
    """Angular velocity of each body, (m, 3): that of its members; from their velocities where it is not known, or some are points
    (which do not carry it in LAMMPS)."""
    if members.omega is None or not members.radius.all():
        return _omega_from_v(members)
    return _of_most(members.omega, DIGITS * np.abs(members.omega).max(axis=(1, 2)), members.body, "turn at different angular velocities")


def _v(members: _Members, v: Floats, x: Floats, omega: Floats) -> Floats:
    """Velocity of each centre of mass, (m, 3): v - omega × (x_j - x), the same for every member j."""
    each = v - np.cross(omega[:, None], members.x - x[:, None])
    return _of_most(each, _allowed(members, v, omega), members.body, "do not move as one")


def _allowed(members: _Members, v: Floats, omega: Floats) -> Floats:
    """What v - omega × x may be off by, (m,), for the digits of each."""
    return np.asarray(DIGITS * (np.abs(v).max(axis=(1, 2)) + np.abs(omega).max(axis=1) * members.reach))


def _of_most(values: Floats, allowed: Floats, body: Ints, what: str) -> Floats:
    """The mean (m, 3) of those values (m, k, 3) that are `allowed` (m,) from the median or less: more than half of the members must be.

    Not all of them: in LIGGGHTS decks with `fix nve/sphere` for all particles a member in contact gets half a step of acceleration on its own.
    """
    k = values.shape[1]
    median = np.asarray(np.sort(values, axis=1)[:, k // 2])
    near = np.abs(values - median[:, None]).max(axis=2) <= allowed[:, None]
    count = near.sum(axis=1)
    if (2 * count <= k).any():
        raise _not_rigid(body[2 * count <= k][0], what)
    return np.asarray(np.einsum("mk,mki->mi", near / count[:, None], values))


def _omega_from_v(members: _Members) -> Floats:
    """Least squares of v - mean v = omega × (x - mean x)."""
    if members.v is None or members.x.shape[1] < 3:
        raise _untold(members.body[0])
    arms, speeds = (values - values.mean(axis=1, keepdims=True) for values in (members.x, members.v))
    spread = np.einsum("mki,mkj->mij", arms, arms)
    about = np.trace(spread, axis1=1, axis2=2)[:, None, None] * np.eye(3) - spread
    least, _, greatest = np.linalg.eigvalsh(about).T
    in_line = least <= _IN_LINE * greatest
    if in_line.any():
        raise _untold(members.body[in_line][0])
    omega = np.asarray(np.linalg.solve(about, np.cross(arms, speeds).sum(axis=1)[..., None])[..., 0])
    off = np.abs(speeds - np.cross(omega[:, None], arms)).max(axis=(1, 2)) > _allowed(members, members.v, omega)
    if off.any():
        raise _not_rigid(members.body[off][0], "do not move as one")
    return omega


def _not_rigid(body: int, what: str) -> InputError:
    return InputError(
        f"the spheres of body {body} {what}: it is not rigid, or another fix moves its spheres too (fix nve/sphere for all?); "
        "expected a dump of bodies, or another column that numbers them"
    )


def _untold(body: int) -> InputError:
    return InputError(
        f"the velocities of the spheres of body {body}, which lie in one line, do not tell its spin about that line: "
        "expected the columns omegax omegay omegaz"
    )


def _joined(parts: list[RigidBodies]) -> RigidBodies:
    """The bodies of all parts, by number. Of all parts v is known, or of none."""
    if not parts:
        return RigidBodies(np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 4)), np.empty(0), np.empty((0, 3)), np.empty((0, 3)))
    order = np.argsort(np.concatenate([part.id for part in parts]))
    columns = {item.name: [getattr(part, item.name) for part in parts] for item in fields(RigidBodies)}
    return RigidBodies(**{name: np.concatenate(column)[order] for name, column in columns.items() if column[0] is not None})

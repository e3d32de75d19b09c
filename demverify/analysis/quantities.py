"""From the columns of a frame to the quantities that the computes of rotational energy take."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.erotate import children
from demsolver.computes.erotate_sphere import INERTIA
from demsolver.computes.population import Population, RigidBodies
from demsolver.shapes import superquadric
from demverify.analysis.meanings import Meanings
from demverify.analysis.needed import POSITIONS
from demverify.deck.setup import Dialect
from demverify.errors import InputError
from demverify.formats.columns import volume
from demverify.frames import Floats, Frame

Ints = NDArray[np.int64]

_COLUMNS = {
    "mass": "mass or density (or --density X, --deck DECK)",
    "radius": "radius or diameter",
    "omega": "omegax omegay omegaz",
    "angmom": "angmomx angmomy angmomz",
    "quat": "quat1 quat2 quat3 quat4",
    "shape": "shapex shapey shapez",
}
ANY_TYPE = 0
"""The type under which Meanings.density holds a density for all particles."""
_UNNAMED = ("c_", "f_", "v_", "d_", "i_", "d2_", "i2_")


class MissingColumnError(InputError):
    """A frame lacks what the energy is made of."""


def vector(frame: Frame, names: tuple[str, ...]) -> Floats | None:
    """Columns side by side, (n, len(names)), or None if one is missing."""
    if any(name not in frame.columns for name in names):
        return None
    return np.column_stack([frame.columns[name] for name in names])


def xyz(frame: Frame, prefix: str) -> Floats | None:
    """prefix + x, y, z as (n, 3), or None."""
    return vector(frame, tuple(prefix + axis for axis in "xyz"))


def population_of(frame: Frame, meanings: Meanings, *, halfstep: bool = False) -> Population:
    """The particles of a frame. What its columns and `meanings` do not tell is None.

    halfstep: free spheres half a step later, omega + dt/2 torque / (2/5 m R^2) and v + dt/2 f / m, as the keyword of LIGGGHTS'
        computes erotate/sphere and ke.
    Raises InputError where the meaning of a column cannot be told, and MissingColumnError where `halfstep` lacks a column or the step.
    """
    dialect = meanings.dialect_of(frame)
    omega, angmom = xyz(frame, "omega"), xyz(frame, "angmom")
    quat = vector(frame, ("quat1", "quat2", "quat3", "quat4"))
    shape, radius = _shape(frame, dialect, quat, angmom), _radius(frame)
    blockiness = vector(frame, ("blockiness1", "blockiness2"))
    blockiness = vector(frame, ("roundness1", "roundness2")) if blockiness is None else blockiness
    if shape is not None and dialect == "lammps":
        if angmom is None and shape.any():
            message = "the energy of ellipsoids needs the columns angmomx angmomy angmomz: LAMMPS keeps no omega of them"
            raise MissingColumnError(message)
        if "sphere" not in meanings.atom_style:  # then what has no shape is a point
            radius = np.zeros(frame.n) if radius is None else radius
            omega = np.zeros((frame.n, 3)) if omega is None else omega
    elif shape is not None and angmom is not None and omega is not None:
        quat = None  # LIGGGHTS prints L . omega / 2; scheme 3 has an omega that belongs to the quaternion of one step ago
    found = Population(
        id=_ids(frame),
        radius=radius,
        omega=omega,
        x=_positions(frame),
        v=xyz(frame, "v"),
        angmom=angmom,
        quat=quat,
        shape=shape,
        blockiness=blockiness,
        body=member_of(frame, meanings),
        mass=_mass(frame, meanings, radius, shape, blockiness),
    )
    if "mass" not in frame.columns and found.mass is not None and not found.mass.all():
        found = replace(found, v=None)  # the mass of points, and so their energy of translation, does not follow from a density
    return _half_a_step_later(found, frame, meanings) if halfstep else found


def bodies_of(frame: Frame) -> RigidBodies | None:
    """The rigid bodies that a frame of `dump local` lists, or None when its columns are not those of bodies."""
    omega, angmom = (vector(frame, tuple(f"{name}[{i}]" for i in (1, 2, 3))) for name in ("omega", "angmom"))
    inertia, v = (vector(frame, tuple(f"{name}[{i}]" for i in (1, 2, 3))) for name in ("inertia", "vcm"))
    quat = vector(frame, tuple(f"quat[{i}]" for i in (1, 2, 3, 4)))
    if inertia is None or quat is None or (omega is None and angmom is None):
        return None
    ids = frame.columns.get("id_multisphere", np.arange(1.0, len(inertia) + 1.0))
    return RigidBodies(_integers(ids), inertia, quat, frame.columns.get("masstotal"), v, omega, angmom)


def check_complete(population: Population, present: list[str]) -> None:
    """Raises MissingColumnError unless every shape that is there has what its energy needs. present: the columns of the file."""
    if population.shape is None and any(values is not None for values in (population.angmom, population.quat, population.blockiness)):
        message = f"angmom, quat, blockiness are not of spheres: expected shapex shapey shapez too; the dump has {' '.join(present)}"
        raise MissingColumnError(message)
    free = np.ones(len(population.id), dtype=bool)
    for shape, child in children():
        mine = child.owned(population) & free
        free &= ~mine
        if shape != "multisphere" and mine.any():
            _check_one(shape, child.NEEDS, population, present)


def _check_one(shape: str, needs: tuple[tuple[str, ...], ...], population: Population, present: list[str]) -> None:
    lacking = [[name for name in names if getattr(population, name) is None] for names in needs]
    if all(lacking):
        missing = " and ".join(_COLUMNS[name] for name in min(lacking, key=len))
        unnamed = [name for name in present if name.startswith(_UNNAMED)]
        hint = f"; what {' '.join(unnamed)} hold, --deck or --columns can say" if unnamed else ""
        message = f"erotate/{shape} needs the columns {missing}; the dump has {' '.join(present)}{hint}"
        raise MissingColumnError(message)


def _ids(frame: Frame) -> Ints:
    return _integers(frame.columns["id"]) if "id" in frame.columns else np.arange(1, frame.n + 1)


def _integers(values: Floats) -> Ints:
    return np.where(np.isfinite(values), values, 0.0).astype(np.int64)


def _radius(frame: Frame) -> Floats | None:
    if "radius" in frame.columns:
        return frame.columns["radius"]
    return 0.5 * frame.columns["diameter"] if "diameter" in frame.columns else None


def _shape(frame: Frame, dialect: Dialect | None, quat: Floats | None, angmom: Floats | None) -> Floats | None:
    """Semi-axes: LIGGGHTS' shapex is one, LAMMPS' is a diameter (since July 2020). Zeros: a sphere or a point.

    For those, LAMMPS' compute property/atom gives a shape of 1 1 1 and a quaternion of 1 0 0 0; as they have no angmom either, a ball at
    rest, which looks the same, has no less energy for it.
    """
    shape = xyz(frame, "shape")
    if shape is None:
        return None
    if dialect is None:
        message = "shapex is a semi-axis in LIGGGHTS and a diameter in LAMMPS, and this file does not show which wrote it: give --deck DECK"
        raise InputError(message)
    if dialect == "liggghts":
        return shape
    none = (shape == 1.0).all(axis=1)
    none &= True if quat is None else (quat == (1.0, 0.0, 0.0, 0.0)).all(axis=1)
    none &= True if angmom is None else ~angmom.any(axis=1)
    return np.where(none[:, None], 0.0, 0.5 * shape)


def _positions(frame: Frame) -> Floats | None:
    for names in POSITIONS:
        found = vector(frame, names)
        if found is not None:
            scaled = names[0].startswith("xs")
            return frame.box[:, 0] + found @ frame.edges if scaled else found
    return None


def member_of(frame: Frame, meanings: Meanings) -> Ints | None:
    """The rigid body of each particle, (n,); 0 or less: none. None: the frame has no bodies.

    LIGGGHTS writes the same number as `mol` and `id_multisphere`. A dump_modify format that prints such a column as %g prints another
    number, though, often the column before it: of two columns that differ, the one with more bodies is right.
    Raises InputError when `mol` is there and nobody has said whether molecules are rigid.
    """
    mol, body = frame.columns.get("mol"), frame.columns.get("id_multisphere")
    if body is not None:
        return _whole(mol if mol is not None and _bodies_in(mol) > _bodies_in(body) else body)
    if mol is None or meanings.rigid == "none" or (meanings.rigid is None and not _shared(mol)):
        return None
    if meanings.rigid is None:
        message = (
            "column mol may number rigid bodies or not: give --deck DECK, or say it with --columns "
            "(call the column id_multisphere where molecules are rigid, otherwise anything else)"
        )
        raise InputError(message)
    return _whole(mol)


def _bodies_in(column: Floats) -> int:
    """The number of bodies that a column tells apart; 0 when it is no column of whole numbers."""
    return len(np.unique(column[column > 0])) if (column == np.rint(column)).all() else 0


def _whole(column: Floats) -> Ints:
    if (bad := np.flatnonzero((column != np.rint(column)) | (np.abs(column) > 2.0**53))).size:
        message = f"a body has the number {column[bad[0]]:.9g}: expected whole numbers (dump_modify format must print them with %d)"
        raise InputError(message)
    return column.astype(np.int64)


def _shared(mol: Floats) -> bool:
    """True when two particles have the same molecule."""
    of_one = mol[mol > 0]
    return len(np.unique(of_one)) < len(of_one)


def _mass(frame: Frame, meanings: Meanings, radius: Floats | None, shape: Floats | None, blockiness: Floats | None) -> Floats | None:
    if "mass" in frame.columns:
        return frame.columns["mass"]
    if {"ellipsoid", "sphere"} <= set(meanings.atom_style):  # LAMMPS then takes the density for that of a sphere of radius 0.5
        return None
    density = _density(frame, meanings)
    if density is None:
        return None
    if shape is not None:
        solid = np.flatnonzero(shape.any(axis=1))
        whole = np.zeros(len(shape)) if radius is None else volume(radius)
        whole[solid] = superquadric.volume(shape[solid], None if blockiness is None else blockiness[solid])
        return density * whole
    if radius is None:
        return None
    discs = meanings.dimension == 2 and meanings.dialect_of(frame) == "liggghts"  # LAMMPS takes discs for spheres here
    return density * volume(radius, 2 if discs else 3)


def _density(frame: Frame, meanings: Meanings) -> Floats | None:
    if "density" in frame.columns:
        return frame.columns["density"]
    if ANY_TYPE in meanings.density:
        return np.full(frame.n, meanings.density[ANY_TYPE])
    if not meanings.density and not meanings.unknown_density:
        return None
    if "type" not in frame.columns:
        if len(set(meanings.density.values())) == 1 and not meanings.unknown_density:
            return np.full(frame.n, next(iter(meanings.density.values())))
        message = "the deck does not tell one density for all types, and the dump has no column type: give --density X"
        raise MissingColumnError(message)
    kinds = _integers(frame.columns["type"])
    unknown = sorted(set(np.unique(kinds).tolist()) - set(meanings.density))
    if unknown:
        known = " ".join(map(str, sorted(meanings.density)))
        why = "; ".join(meanings.unknown_density) or f"the deck does not tell the density of type {unknown[0]} (known: {known})"
        message = f"{why}: give --density X or a dump with column mass"
        raise MissingColumnError(message)
    table = np.zeros(max(meanings.density, default=0) + 1)
    table[list(meanings.density)] = list(meanings.density.values())
    return np.asarray(table[kinds])


def _half_a_step_later(population: Population, frame: Frame, meanings: Meanings) -> Population:
    """Spins and velocities of free spheres where the next half kick takes them; without forces v is not known."""
    torque, omega, mass, radius = xyz(frame, "tq"), population.omega, population.mass, population.radius
    if torque is None or omega is None or mass is None or radius is None:
        message = "the half-step option needs the columns tqx tqy tqz, omegax omegay omegaz, radius and mass"
        raise MissingColumnError(message)
    if meanings.timestep is None:
        message = "the half-step option needs the time step: give --deck DECK or --timestep DT"
        raise InputError(message)
    free = np.ones(len(mass), dtype=bool) if population.body is None else population.body <= 0
    spun = omega + _kick(meanings.timestep, INERTIA * mass * radius**2, free) * torque
    force, v = xyz(frame, "f"), population.v
    pushed = None if v is None or force is None else v + _kick(meanings.timestep, mass, free) * force
    return replace(population, omega=spun, v=pushed)


def _kick(timestep: float, inertia: Floats, free: NDArray[np.bool_]) -> Floats:
    """dt / 2 I, (n, 1); zero for members of bodies and for points."""
    return np.divide(0.5 * timestep, inertia, out=np.zeros_like(inertia), where=free & (inertia > 0.0))[:, None]

"""How far two frames are apart: one number a quantity, in units of what that quantity is made of. Arrays in, numbers
out, no verdict.

Every difference is divided by a scale, so that a verdict does not change with the units of the deck. A scale is the
largest value of the quantity itself, with one addition: a quantity that is zero by physics (the torque of a
frictionless scene, the spin it gives) holds nothing but rounding, and rounding is no measure of itself. Torques, spins
and speeds are therefore never measured against less than SMALL of what they are computed from.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from demverify.frames import Floats, Frame

QUANTITIES: dict[str, tuple[str, str, str]] = {
    "force": ("fx", "fy", "fz"),
    "torque": ("tqx", "tqy", "tqz"),
    "position": ("x", "y", "z"),
    "velocity": ("vx", "vy", "vz"),
    "omega": ("omegax", "omegay", "omegaz"),
}
"""Quantity -> its columns in a frame."""

SMALL = 1e-2
"""A torque is an arm times the tangential part of a contact force, got by subtracting the normal part of the relative
velocity: it carries rounding of the full force times the arm, F R, however small it is itself. Measured against at
least 1e-2 F R, the limit of tier 1 (1e-12) is never below 1e-14 F R, some 45 roundings; and a friction of 1e-2 or more
that is at work sets the scale by itself."""

COORDINATE = 1e-3
"""A coordinate far from the origin is rounded to 2e-16 of itself: against at least 1e-3 of the largest coordinate, the
limit of tier 1 is never below 1e-15 of it, 4 units in the last place."""

REST = 1e-12
"""An energy below 1e-12 of the largest kinetic energy so far (speeds below 1e-6 of the largest) is rest: measured
against that floor."""


class Difference(NamedTuple):
    """Largest difference of one quantity: absolute, relative to its scale, and a note (where it is, or why there is none).

    max_abs and max_rel are NaN where a value is not finite: the note then says which engine and which particle.
    """

    max_abs: float
    max_rel: float
    note: str = ""


class Figure(NamedTuple):
    """A bulk figure: a sum over particles.

    size: its own magnitude as a scale, now (0: none). floor: its least scale, kept as a maximum over time. parts: (n,) what
    each particle adds, rows in order of ids; their sum is the value. None for a mere count.
    """

    value: float
    size: float
    floor: float
    parts: Floats | None = None


@dataclass(frozen=True)
class Scales:
    """What the differences of each quantity are measured against; `a | b` takes the larger of each (a trajectory so far)."""

    force: float = 0.0
    torque: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    omega: float = 0.0

    def __or__(self, other: Scales) -> Scales:
        """The larger of each."""
        return Scales(*map(max, astuple(self), astuple(other)))

    @classmethod
    def of(cls, frame: Frame) -> Scales:
        """The scales of one frame. Columns that are missing, and values that are not finite, count as zero."""
        largest = {name: _largest(lengths(frame, name)) for name in QUANTITIES}
        radius, mass = _largest(radii(frame)), _largest(frame.columns.get("mass"))
        arm = largest["force"] * radius
        # The speed that the largest force gives the heaviest particle over one radius: what a particle at rest is
        # measured against.
        speed = max(largest["velocity"], SMALL * np.sqrt(arm / mass) if mass else 0.0)
        return cls(
            force=largest["force"],
            torque=max(largest["torque"], SMALL * arm),
            position=max(radius, COORDINATE * largest["position"]),
            velocity=speed,
            omega=max(largest["omega"], SMALL * speed / radius if radius else 0.0),
        )


def lengths(frame: Frame, quantity: str) -> Floats | None:
    """(n,) Euclidean lengths of a vector quantity (no overflow or underflow on the way), or None if a column is missing."""
    columns = QUANTITIES[quantity]
    return np.hypot.reduce(frame.vectors(*columns), axis=1) if frame.columns.keys() >= set(columns) else None


def radii(frame: Frame) -> Floats | None:
    """(n,) radii, from the column radius or diameter, or None."""
    if "radius" in frame.columns:
        return frame.columns["radius"]
    return 0.5 * frame.columns["diameter"] if "diameter" in frame.columns else None


def ids_apart(a: Frame, b: Frame, engines: tuple[str, str]) -> Difference | None:
    """None when both frames hold the same particles, each once; else how many ids are not shared, and a note that names them."""
    for name, frame in zip(engines, (a, b), strict=True):
        if frame.n and "id" not in frame.columns:
            return Difference(float(frame.n), 1.0, f"{name} wrote no column id: particles cannot be matched")
        if len(repeated := _repeated(_ids(frame))):
            return Difference(float(len(repeated)), 1.0, f"{name} holds {_some(repeated)} more than once")
    only = [np.setdiff1d(_ids(p), _ids(q)) for p, q in ((a, b), (b, a))]
    count = len(only[0]) + len(only[1])
    if not count:
        return None
    note = "; ".join(f"only {name} has {_some(ids)}" for name, ids in zip(engines, only, strict=True) if len(ids))
    return Difference(float(count), count / max(a.n, b.n), note)


def difference(a: Frame, b: Frame, quantity: str, scale: float, engines: tuple[str, str]) -> Difference | None:
    """The largest difference of one vector quantity between frames with the same ids (see `ids_apart`); None if no
    engine pair wrote it.

    scale: what max_rel is relative to, in the quantity's units. Periodic positions differ by their minimum image.
    """
    columns = QUANTITIES[quantity]
    if not (a.columns.keys() >= set(columns) and b.columns.keys() >= set(columns)):
        return None
    order_a, order_b = np.argsort(_ids(a)), np.argsort(_ids(b))
    ids, va, vb = _ids(a)[order_a], a.vectors(*columns)[order_a], b.vectors(*columns)[order_b]
    for name, values in zip(engines, (va, vb), strict=True):
        if len(bad := ids[~np.isfinite(values).all(axis=1)]):
            return Difference(np.nan, np.nan, f"{name}: {quantity} not finite for {_some(bad)}")
    apart = np.hypot.reduce(_minimum_image(va - vb, a, b) if quantity == "position" else va - vb, axis=1)
    worst = int(np.argmax(apart))
    return Difference(*_scaled(float(apart[worst]), scale), f"largest at particle {ids[worst]:.0f}")


def bulk(frame: Frame) -> dict[str, Figure]:
    """The figures that a chaotic run still has in common with its neighbours; those whose columns are there.

    number; ke = sum m v^2/2; erotate = sum (2/5 m R^2) w^2/2 (spheres), sum L.w/2 (superquadrics); mean_speed = mean |v|; com_x, com_y, com_z: centre
    of mass along each axis that is not periodic, measured against the extent of the packing.
    """
    figures = {"number": Figure(frame.n, frame.n, 0.0)}
    speed, spin, mass, radius = lengths(frame, "velocity"), lengths(frame, "omega"), frame.columns.get("mass"), radii(frame)
    if not frame.n or speed is None:
        return figures
    order = np.argsort(_ids(frame))
    figures["mean_speed"] = _positive(speed[order] / frame.n, np.sqrt(REST))
    if mass is None:
        return figures
    energies = {"ke": 0.5 * mass * speed**2}
    if radius is not None and spin is not None:
        energies["erotate"] = _turning(frame, mass, radius * spin)
    total = float(sum(parts.sum() for parts in energies.values()))
    figures |= {name: _positive(parts[order], REST, total) for name, parts in energies.items()}
    return figures | _centres(frame, mass, radius, order)


def _turning(frame: Frame, mass: Floats, surface: Floats) -> Floats:
    """(n,) energy of the spin; surface: radius times spin."""
    spheres = np.asarray(0.2 * mass * surface**2)
    if not {"shapex", "angmomx", "angmomy", "angmomz"} <= set(frame.columns):
        return spheres
    own = 0.5 * (frame.vectors("angmomx", "angmomy", "angmomz") * frame.vectors("omegax", "omegay", "omegaz")).sum(axis=1)
    return np.where(frame.columns["shapex"] > 0.0, own, spheres)


def bulk_difference(name: str, a: Figure, b: Figure, floor: float, engines: tuple[str, str]) -> Difference:
    """How far one bulk figure is apart; `floor`: the largest floor of either run so far."""
    return scalar_difference(name, a.value, b.value, max(a.size, b.size, floor), engines)


def bulk_spread(a: Figure, b: Figure, floor: float) -> float:
    """How far chance may part a bulk figure of two runs with the same particles, relative to its scale.

    The root of the sum of squares of what each particle adds to the difference: the standard deviation of the figure if the
    particles part independently. Unlike the difference of the sums it is not small by accident. At least that difference.
    """
    apart = abs(a.value - b.value)
    if a.parts is not None and b.parts is not None and len(a.parts) == len(b.parts):
        apart = max(apart, float(np.linalg.norm(a.parts - b.parts)))
    return _scaled(apart, max(a.size, b.size, floor))[1]


def scalar_difference(name: str, a: float, b: float, scale: float, engines: tuple[str, str]) -> Difference:
    """How far two numbers are apart, relative to `scale`. A number that is not finite makes it NaN."""
    for engine, value in zip(engines, (a, b), strict=True):
        if not np.isfinite(value):
            return Difference(np.nan, np.nan, f"{engine}: {name} is {value}")
    return Difference(*_scaled(abs(a - b), scale), f"{engines[0]} {a:.6g}, {engines[1]} {b:.6g}")


def _positive(parts: Floats, rest: float, whole: float | None = None) -> Figure:
    """A sum of positive parts, measured against itself, and against `rest` of the whole (itself, if not given) at least."""
    value = float(parts.sum())
    return Figure(value, value, rest * (value if whole is None else whole), parts)


def _centres(frame: Frame, mass: Floats, radius: Floats | None, order: NDArray[np.int64]) -> dict[str, Figure]:
    """com_<axis> along the axes that are not periodic; scale: extent of the particles, plus a radius for a single one."""
    if not frame.columns.keys() >= {"x", "y", "z"} or not mass.sum():
        return {}
    x = frame.vectors("x", "y", "z")
    parts, extent = (mass / mass.sum())[:, None] * x, np.ptp(x, axis=0) + _largest(radius)
    axes = [k for k in range(3) if frame.boundary[k] != "pp"]
    return {f"com_{'xyz'[k]}": Figure(float(parts[:, k].sum()), 0.0, float(extent[k]), parts[order, k]) for k in axes}


def _minimum_image(d: Floats, a: Frame, b: Frame) -> Floats:
    """Differences (n, 3) of periodic coordinates, the shortest over both boxes: LIGGGHTS prints its box with six digits only."""
    periodic = np.array([faces == "pp" for faces in a.boundary])
    images = [d - np.where(periodic, box, 0.0) * np.round(d / np.where(periodic, box, np.inf)) for box in (_edges(a), _edges(b))]
    return np.where(np.abs(images[0]) <= np.abs(images[1]), images[0], images[1])


def _edges(frame: Frame) -> Floats:
    edges = frame.box[:, 1] - frame.box[:, 0]
    return np.where(edges > 0, edges, np.inf)


def _scaled(apart: float, scale: float) -> tuple[float, float]:
    """(absolute, relative); equal values are 0 apart whatever the scale, and a scale of zero hides nothing."""
    return apart, (apart / scale if scale else np.inf) if apart else 0.0


def _largest(values: Floats | None) -> float:
    if values is None or not np.isfinite(values).any():
        return 0.0
    return float(np.max(values, where=np.isfinite(values), initial=0.0))


def _ids(frame: Frame) -> Floats:
    return frame.columns["id"] if frame.n else np.empty(0)


def _repeated(ids: Floats) -> Floats:
    values, counts = np.unique(ids, return_counts=True)
    return values[counts > 1]


def _some(ids: Floats, most: int = 5) -> str:
    names = ", ".join(f"{i:.0f}" for i in ids[:most])
    more = f" and {len(ids) - most} more" if len(ids) > most else ""
    return f"particle{'s' if len(ids) > 1 else ''} {names}{more}"

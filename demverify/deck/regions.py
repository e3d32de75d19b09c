"""Regions of space: block, cylinder, sphere, plane, unions and intersections. Surfaces belong to the inside, as in LAMMPS."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from demverify.deck.command import Command
from demverify.deck.setup import Floats, Setup

Bools = NDArray[np.bool_]
_AXES = ("x", "y", "z")
_STYLES = ("block", "cylinder", "sphere", "plane", "union", "intersect")
_FAR = 1e20  # what LAMMPS takes for INF


@dataclass(frozen=True)
class Tube:
    """A cylinder. axis: 0, 1, 2; center: of the other two, ascending; endless: it has no caps; outer: the region lies outside."""

    axis: int
    center: tuple[float, float]
    radius: float
    endless: bool
    outer: bool = False


@dataclass(frozen=True)
class Region:
    """inside: (n, 3) positions -> (n,) bool. lo, hi: (3,) bounds, None where it has none (side out, planes, unions).

    plane: of style plane, its normal into the region (3) and offset d, n.x + d = 0. tube: of style cylinder, what it is as a wall.
    angle: the variable that turns it, "" if none does; turns: 1 about the positive axis, -1 about the negative one.
    """

    style: str
    inside: Callable[[Floats], Bools]
    lo: Floats | None = None
    hi: Floats | None = None
    plane: tuple[Floats, float] | None = None
    tube: Tube | None = None
    angle: str = ""
    turns: float = 1.0

    def contains(self, x: Floats) -> Bools:
        """Which of the (n, 3) positions lie in the region."""
        return self.inside(x)


def read_region(setup: Setup, cmd: Command) -> Region:
    """A region from the words after its ID. Raises InputError."""
    style = cmd.choice("style", _STYLES)
    cmd.what = f"region {style}"
    if style in ("union", "intersect"):
        return _combined(setup, cmd, style)
    scale = region_scale(setup, cmd)
    region = {"block": _block, "cylinder": _cylinder, "sphere": _sphere, "plane": _plane}[style](setup, cmd, scale)
    return _options(setup, cmd, region, scale)


def region_scale(setup: Setup, cmd: Command) -> Floats:
    """(3,) lengths of one unit of the command's numbers: the lattice's spacings or 1.

    Without the keyword `units` LAMMPS means lattice units, LIGGGHTS box units (measured on both)."""
    units = "lattice" if setup.dialect == "lammps" else "box"
    if "units" in cmd.args[:-1]:
        units = cmd.args[cmd.args.index("units") + 1]
    if units == "lattice" and setup.lattice is not None:
        return np.asarray(setup.lattice.spacing, dtype=float)
    return np.ones(3)


def _block(setup: Setup, cmd: Command, scale: Floats) -> Region:
    bounds = [_bound(setup, cmd, scale, axis, side) for axis in range(3) for side in (0, 1)]
    lo, hi = np.array(bounds[0::2]), np.array(bounds[1::2])
    if np.any(lo > hi):
        axis = _AXES[int(np.argmax(lo > hi))]
        raise cmd.error(f"{axis}lo must not exceed {axis}hi")
    return Region("block", lambda x: np.all((x >= lo) & (x <= hi), axis=1), lo, hi)


def _bound(setup: Setup, cmd: Command, scale: Floats, axis: int, side: int) -> float:
    """One limit as a length; INF and EDGE need a box."""
    name = f"{_AXES[axis]}{('lo', 'hi')[side]}"
    if cmd.peek() not in ("INF", "EDGE"):
        return float(cmd.number(name) * scale[axis])
    word = cmd.take(name)
    if setup.box is None:
        raise cmd.error(f"{word} for {name} needs a simulation box, and there is none yet")
    if word == "INF":
        return _FAR if side else -_FAR
    return float((setup.box.hi if side else setup.box.lo)[axis])


def _cylinder(setup: Setup, cmd: Command, scale: Floats) -> Region:
    axis = _AXES.index(cmd.choice("dim", _AXES))
    a, b = (k for k in range(3) if k != axis)  # LAMMPS: (y, z), (x, z), (x, y)
    c1, c2 = cmd.number("c1") * scale[a], cmd.number("c2") * scale[b]
    # LIGGGHTS scales the radius of a cylinder along x by the x spacing, LAMMPS by the y spacing
    radius = cmd.positive("radius") * scale[a if setup.dialect == "lammps" else 0]
    low, high = (_bound(setup, cmd, scale, axis, side) for side in (0, 1))
    if low > high:
        raise cmd.error("lo must not exceed hi")
    lo, hi = np.empty(3), np.empty(3)
    lo[[axis, a, b]] = low, c1 - radius, c2 - radius
    hi[[axis, a, b]] = high, c1 + radius, c2 + radius

    def inside(x: Floats) -> Bools:
        distance = np.sqrt((x[:, a] - c1) * (x[:, a] - c1) + (x[:, b] - c2) * (x[:, b] - c2))
        return np.asarray((distance <= radius) & (x[:, axis] >= low) & (x[:, axis] <= high))

    return Region("cylinder", inside, lo, hi, tube=Tube(axis, (float(c1), float(c2)), float(radius), low <= -_FAR and high >= _FAR))


def _sphere(setup: Setup, cmd: Command, scale: Floats) -> Region:
    center = np.array(cmd.vector("x", "y", "z")) * scale
    radius = cmd.positive("radius") * scale[0]

    def inside(x: Floats) -> Bools:
        d = x - center
        return np.asarray(np.sqrt(d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1] + d[:, 2] * d[:, 2]) <= radius)

    return Region("sphere", inside, center - radius, center + radius)


def _plane(setup: Setup, cmd: Command, scale: Floats) -> Region:
    """px py pz nx ny nz; LAMMPS scales the normal like the point."""
    point, normal = (np.array(cmd.vector(*names)) * scale for names in (("px", "py", "pz"), ("nx", "ny", "nz")))
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        raise cmd.error("the normal of the plane must not be zero")
    normal = normal / length
    return Region("plane", lambda x: np.asarray((x - point) @ normal >= 0.0), plane=(normal, -float(normal @ point)))


def _combined(setup: Setup, cmd: Command, style: str) -> Region:
    count = cmd.integer("number of regions", low=2)
    parts = [find_region(setup, cmd, cmd.take("region ID")) for _ in range(count)]
    together = np.logical_or if style == "union" else np.logical_and
    return _options(setup, cmd, Region(style, lambda x: np.asarray(together.reduce([part.contains(x) for part in parts]))), np.ones(3))


def _options(setup: Setup, cmd: Command, region: Region, scale: Floats) -> Region:
    side = "in"
    while cmd:
        keyword = cmd.choice("keyword", ("side", "units", "rotate" if setup.dialect == "lammps" else "volume_limit"))
        if keyword == "side":
            side = cmd.choice("side", ("in", "out"))
        elif keyword == "volume_limit":
            cmd.positive("volume_limit")  # what LIGGGHTS would refuse as too small
        elif keyword == "rotate":
            region = _turning(cmd, region, scale)
        else:
            cmd.choice("units", ("lattice", "box"))
    if side == "in":
        return region
    plane = None if region.plane is None else (-region.plane[0], -region.plane[1])
    tube = None if region.tube is None else replace(region.tube, outer=True)
    return replace(region, inside=lambda x: ~region.contains(x), lo=None, hi=None, plane=plane, tube=tube)


def _turning(cmd: Command, region: Region, scale: Floats) -> Region:
    """`rotate v_theta Px Py Pz Rx Ry Rz`: of a cylinder about its own axis, so that it stays what it is."""
    variable = cmd.take("v_theta")
    if not variable.startswith("v_"):
        raise cmd.error(f"the angle of rotate must be a variable, v_NAME, got {variable!r}")
    point, direction = np.array(cmd.vector("px", "py", "pz")) * scale, np.array(cmd.vector("rx", "ry", "rz"))
    tube = region.tube
    if tube is None or np.delete(direction, tube.axis).any() or tuple(np.delete(point, tube.axis)) != tube.center:
        raise cmd.error("rotate is supported for a cylinder about its own axis alone")
    turns = float(direction[tube.axis])
    if abs(turns) != 1.0:
        fault = "LAMMPS turns the surface so much faster (lammps-region-axis-length)"
        raise cmd.error(f"the axis of rotate must have the length 1, got {abs(turns):g}: {fault}")
    return replace(region, angle=variable[2:], turns=turns)


def find_region(setup: Setup, cmd: Command, name: str) -> Region:
    """The region of that ID. Raises InputError listing those there are."""
    if name not in setup.regions:
        raise cmd.error(f"region {name!r} does not exist; defined: {', '.join(setup.regions) or 'none'}")
    found: Region = setup.regions[name]
    return found

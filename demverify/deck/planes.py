"""Walls of LAMMPS decks that are no words of fix wall/gran: regions of style plane and cylinder in fix wall/gran/region, and the native engine's
own `plane`, which may move and turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from demsolver.scene import Cylinder, Plane, Rotation
from demverify.deck.materials_common import AXES, Words
from demverify.deck.regions import Tube
from demverify.deck.setup import Setup

Vector = tuple[float, float, float]


def moving_plane(words: Words) -> Plane:
    """`A B C D [velocity VX VY VZ] [rotate PX PY PZ WX WY WZ]`: a x + b y + c z + d = 0, seen from both sides, of the native engine alone.

    velocity: of the pivot (PX, PY, PZ). W: angular velocity about it [radian/time].
    """
    plane = Plane(_vector(words, "a", "b", "c"), words.number("d"))
    if not any(plane.normal):
        raise words.error("the plane needs a normal: a, b and c must not all be zero")
    while words:
        if words.choice("option", ("velocity", "rotate")) == "velocity":
            plane = replace(plane, velocity=_vector(words, "vx", "vy", "vz"))
        else:
            plane = replace(plane, pivot=_vector(words, "px", "py", "pz"), omega=_vector(words, "wx", "wy", "wz"))
    return plane


def _vector(words: Words, *names: str) -> Vector:
    x, y, z = (words.number(name) for name in names)
    return x, y, z


def region_shape(words: Words, setup: Setup) -> Plane | Cylinder:
    """`region ID` of fix wall/gran/region: a plane or an endless cylinder felt from the region's inside, as LAMMPS has it."""
    words.choice("wall", ("region",))
    name = words.take("region ID")
    if name not in setup.regions:
        raise words.error(f"region {name!r} does not exist; defined: {', '.join(setup.regions) or 'none'}")
    region = setup.regions[name]
    if region.tube:
        return _region_cylinder(words, setup, name, region.tube)
    if region.plane is None:
        raise words.error(f"region {name} is a {region.style}: supported as walls are plane, cylinder")
    normal, offset = region.plane
    x, y, z = (float(part) for part in normal)
    return Plane((x, y, z), offset, one_sided=True)


def _region_cylinder(words: Words, setup: Setup, name: str, tube: Tube) -> Cylinder:
    if not tube.endless:
        raise words.error(f"region {name} is a cylinder with ends: supported as a wall is one from INF to INF")
    center = tube.center[::-1] if tube.axis == 1 else tube.center  # in cyclic order
    turn = setup.turns.get(name)
    rotation = Rotation(turn.rate, "surface", rolls=False, still_at_setup=True) if turn and turn.rate else None
    return Cylinder(tube.axis, center, tube.radius, "curved", "out" if tube.outer else "in", rotation)


def checked(words: Words, shape: Plane | Cylinder, setup: Setup) -> Plane | Cylinder:
    """The wall, if the words end here and it goes with the box: in a periodic direction everything repeats, a plane and its motion too.

    Raises InputError."""
    words.skip("contacts")
    words.end()
    if isinstance(shape, Cylinder):
        check_across(words, [k for k in range(3) if k != shape.axis], "the cylinder", setup)
        return shape
    plane = shape
    for axis, faces in enumerate(setup.boundary):
        turns = np.cross(plane.omega, np.eye(3)[axis]).any()
        if faces == "pp" and (plane.normal[axis] != 0.0 or turns):
            raise words.error(f"the plane {'turns about another axis than' if turns else 'is tilted against'} the periodic direction {AXES[axis]}")
    return plane


def check_across(words: Words, axes: Sequence[int], what: str, setup: Setup) -> None:
    """Raises InputError for a wall across a periodic direction, which it would cut."""
    periodic = [k for k in axes if setup.boundary[k] == "pp"]
    if periodic:
        raise words.error(f"{what} cannot stand in the periodic direction {AXES[periodic[0]]}")

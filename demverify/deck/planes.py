"""Plane walls of LAMMPS decks: `region` of style plane in fix wall/gran/region, and the native engine's own `plane`, which may move and turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demsolver.scene import Plane
from demverify.deck.materials_common import AXES, Words
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


def region_plane(words: Words, setup: Setup) -> Plane:
    """`region ID` of fix wall/gran/region: a plane felt from its inside, as LAMMPS has it."""
    words.choice("wall", ("region",))
    name = words.take("region ID")
    if name not in setup.regions:
        raise words.error(f"region {name!r} does not exist; defined: {', '.join(setup.regions) or 'none'}")
    region = setup.regions[name]
    if region.plane is None:
        raise words.error(f"region {name} is a {region.style}: supported as a wall is plane alone")
    normal, offset = region.plane
    x, y, z = (float(part) for part in normal)
    return Plane((x, y, z), offset, one_sided=True)


def checked(words: Words, plane: Plane, setup: Setup) -> Plane:
    """The plane, if the words end here and it goes with the box: in a periodic direction everything repeats, a plane and its motion too.

    Raises InputError."""
    words.skip("contacts")
    words.end()
    for axis, faces in enumerate(setup.boundary):
        turns = np.cross(plane.omega, np.eye(3)[axis]).any()
        if faces == "pp" and (plane.normal[axis] != 0.0 or turns):
            raise words.error(f"the plane {'turns about another axis than' if turns else 'is tilted against'} the periodic direction {AXES[axis]}")
    return plane

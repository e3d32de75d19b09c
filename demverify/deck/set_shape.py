"""`set ... shape, blockiness, quat, quat_direct, density, mass, omegax ...` of superquadrics."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np

from demsolver.shapes import superquadric
from demverify.deck.command import Command
from demverify.deck.particles import reshape, turn_with
from demverify.deck.setup import Atoms, Ints

SHAPES = ("shape", "blockiness", "roundness", "quat", "quat_direct")


def set_shape(cmd: Command, atoms: Atoms, rows: Ints, keyword: str) -> None:
    """One keyword, as LIGGGHTS takes them, from left to right: what follows from it is computed at once.

    quat ax ay az angle turns by `angle` degrees; the quaternion is normalised, the axis is not. Angular momenta follow from omega when that is set.
    """
    shapes = atoms.superquadrics
    assert shapes is not None
    density = atoms.mass[rows] / superquadric.volume(shapes.axes[rows], shapes.blockiness[rows])
    if keyword == "shape":
        shapes.axes[rows] = [cmd.positive(f"semi-axis {axis}") for axis in "abc"]
        reshape(atoms, rows, density)
    elif keyword in ("blockiness", "roundness"):
        shapes.blockiness[rows] = [cmd.number("n1"), cmd.number("n2")]
        if (shapes.blockiness[rows] < superquadric.LEAST_EXPONENT).any():
            raise cmd.error(f"blockiness must be {superquadric.LEAST_EXPONENT:g} or more")
        reshape(atoms, rows, density)
    elif keyword == "density":
        reshape(atoms, rows, cmd.positive("density"))
    elif keyword == "mass":
        reshape(atoms, rows, cmd.positive("mass") / superquadric.volume(shapes.axes[rows], shapes.blockiness[rows]))
    elif keyword in ("quat", "quat_direct"):
        shapes.quat[rows] = _quat(cmd, keyword)
    else:
        atoms.omega[rows, "xyz".index(keyword[-1])] = cmd.number(keyword)
        turn_with(atoms, rows)


def _quat(cmd: Command, keyword: str) -> np.ndarray:
    one, two, three, four = cmd.vector("quaternion", "quaternion", "quaternion", "quaternion")
    if keyword == "quat":
        half = four * pi / 360.0
        one, two, three, four = cos(half), one * sin(half), two * sin(half), three * sin(half)
    length = hypot(one, two, three, four)
    if not length > 0.0:
        raise cmd.error("the quaternion must not be zero")
    return np.array([one, two, three, four]) / length

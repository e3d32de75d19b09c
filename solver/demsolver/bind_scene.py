"""The arrays that the loop is given of a scene's walls, fields and pair law (bind_law.py and bind_walls.py write the code that reads them)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demsolver.bind_law import coefficient_table, memory_signs
from demsolver.bind_walls import wall_geometry
from demsolver.scene import AddForce, Gravity, Scene, SetForce, Viscous, Wall
from demsolver.state import Floats, Ints


def wall_arrays(wall: Wall, n: int, extra: int) -> tuple[Floats, int, Floats, Floats, NDArray[np.uint8]]:
    """Geometry, group bit, coefficients, and of n particles memory (n, c) and touching (n,). extra: columns of memory behind those of the law."""
    columns = len(memory_signs(wall.law)) + extra
    return wall_geometry(wall), wall.bit, coefficient_table(wall.law), np.zeros((n, columns)), np.zeros(n, dtype=np.uint8)


def pair_coefficients(scene: Scene, *, one: bool) -> Floats | tuple[float, ...]:
    """The table of the pair law; of one law for all types its row."""
    table = coefficient_table(scene.pair) if scene.pair else np.zeros((1, 1))
    return tuple(table[0].tolist()) if one else table


def field_arrays(scene: Scene) -> tuple[Floats, Ints, Floats, Floats]:
    """Numbers (f, 3) and group bits (f,) of the fields; of viscous ones coefficients by type; room for the last force (3,) on each particle of those
    whose work is counted: viscous ones, then added forces."""
    drags = [f for f in scene.forces if isinstance(f, Viscous)]
    return (
        np.array([_field_numbers(f) for f in scene.forces]).reshape(-1, 3),
        np.array([f.bit for f in scene.forces], dtype=np.int64),
        np.array([d.gamma for d in drags], dtype=float).reshape(len(drags), scene.ntypes if drags else 0),
        np.zeros((len(drags) + sum(isinstance(f, AddForce) for f in scene.forces), len(scene.particles.id), 3)),
    )


def _field_numbers(force: object) -> tuple[float, float, float]:
    if isinstance(force, Gravity):
        return force.acceleration
    if isinstance(force, SetForce):
        x, y, z = (0.0 if c is None else c for c in force.force)
        return x, y, z
    return 0.0, 0.0, 0.0

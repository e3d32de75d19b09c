"""The guard and superquadrics: how deep is too deep for a body that is thin one way and long another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from demsolver import Box, Scene, Simulation, Slab, Unstable, Wall
from demsolver.guard import DEEPEST
from demsolver.scene import ContactLaw, NveSuperquadric
from tests.support.superquadrics import particles

LONG, THIN = 0.05, 0.0025
PLATE = np.array([LONG, LONG, THIN])
LYING, STANDING = np.array([1.0, 0.0, 0.0, 0.0]), np.array([1.0, 1.0, 0.0, 0.0]) / np.sqrt(2.0)


def hertz(shape: tuple[int, ...]) -> ContactLaw:
    """Springs so soft that a plate of some metres a second sinks in by more than it is thick."""
    return ContactLaw("hertz", "none", "none", "none", "none", {"kn": np.full(shape, 1e5)})


FLOOR = Wall("floor", Slab(2, lo=0.0), hertz((1,)))


def told(heights: Sequence[float], quat: np.ndarray = LYING, *, second: float = 1.0, speed: float = 0.0, steps: int = 0, floor: bool = False) -> str:
    """What stops plates one above the other, the second with `second` times the axes, all of which fall with `speed`."""
    n = len(heights)
    x = np.column_stack([np.zeros((n, 2)), heights])
    axes = np.array([PLATE, second * PLATE])[:n]
    p = particles(x, axes, np.full((n, 2), 4.0), np.tile(quat, (n, 1)), np.tile([0.0, 0.0, -speed], (n, 1)))
    box = Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))
    walls = (FLOOR,) if floor else ()
    try:
        simulation = Simulation(Scene(box, p, 1, 4e-5, hertz((1, 1)), walls=walls, integrate=(NveSuperquadric(),)))
        simulation.setup()
        simulation.advance(steps)
    except Unstable as error:
        return str(error)
    return ""


def test_a_plate_does_not_fall_through_a_floor_unseen() -> None:
    """Law: where a centre comes to the other side of a wall, something is said, however thin the body is."""
    assert told([1.1 * THIN], speed=3.0, steps=300, floor=True).startswith("particle 1 and wall floor overlap by 0.")


@pytest.mark.parametrize("part", [0.48, 0.52])
@pytest.mark.parametrize(("quat", "reach"), [(LYING, THIN), (STANDING, LONG)])
def test_depth_at_a_wall_is_measured_along_the_normal(quat: np.ndarray, reach: float, part: float) -> None:
    """Law: half of what reaches to the wall may be in it: of a lying plate half its thickness, of a standing one half its height."""
    said = told([(1.0 - part) * reach], quat, floor=True)
    assert said.startswith("particle 1 and wall floor overlap by 0.52 of the smaller radius in step 0") == (part > DEEPEST)


@pytest.mark.parametrize("part", [0.48, 0.52])
@pytest.mark.parametrize(("quat", "reach"), [(LYING, THIN), (STANDING, LONG)])
@pytest.mark.parametrize("second", [1.0, 1.2])
def test_depth_of_two_is_measured_along_the_normal(second: float, quat: np.ndarray, reach: float, part: float) -> None:
    """Law: of two plates on each other, flat or edge to edge, half of what the smaller reaches to the other may be in it."""
    said = told([0.0, (1.0 + second - part) * reach], quat, second=second)
    assert said.startswith("particles 1 and 2 overlap by 0.5") == (part > DEEPEST)

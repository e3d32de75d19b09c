"""What a run can die of, and how it is said."""

from __future__ import annotations

import numpy as np

from demsolver.scene import AddForce, Scene
from demsolver.state import Bodies, Floats

BLUNTEST = 300.0
"""Exponent up to which contact points of superquadrics are found: the third power of 2^(2 - n), a determinant, is a number to there."""
NOT_SOLVED = -2  # what an implicit step may answer; else -1: out of the list
_SAID = {"x": "positions", "v": "velocities", "omega": "spins", "force": "forces", "torque": "torques"}


class LostParticles(RuntimeError):
    """Particles left the box through a fixed face, or went off to infinity."""


class Unstable(RuntimeError):
    """A position, velocity or force became infinite or NaN."""


def check_finite(bodies: Bodies, step: int, scene: Scene, *names: str) -> None:
    """Raises Unstable; looks at everything that moves, or only at `names`."""
    for name in names or _SAID:
        if not np.isfinite(getattr(bodies, name)).all():
            message = f"{_SAID[name]} became infinite by step {step}: {_why(scene)}"
            raise Unstable(message)


def check_flight(low: Floats, high: Floats, box_lo: Floats, box_hi: Floats, step: int, scene: Scene) -> None:
    """Raises Unstable where a particle flew farther than through one face of the periodic box since the last list: nobody knows where it is.
    low, high: (3,) outermost coordinates."""
    length = np.where(scene.box.periodic, box_hi - box_lo, np.inf)
    if ((low < box_lo - length) | (high >= box_hi + length)).any():
        message = f"a particle flew through the whole periodic box by step {step}: {_why(scene)}"
        raise Unstable(message)


def _why(scene: Scene) -> str:
    added = any(isinstance(force, AddForce) for force in scene.forces)
    formula = "the formula of an added force has no finite value (division by zero, root of a negative number ...), " if added else ""
    return f"{formula}{'or ' if added else ''}the timestep {scene.timestep:g} is too long, or particles overlap too far"


def lost_points(count: int, step: int, scene: Scene) -> str:
    """That contact points of superquadrics were not found."""
    gauge = "" if scene.contact_point == "gauge" else ", or have the contact point by growth (contact_point gauge), which exists at any depth"
    shapes = scene.particles.superquadrics
    most = shapes.blockiness.max(initial=0.0) if shapes else 0.0
    cause = f"they overlap too deeply; start them apart, make the contact stiffer, shorten the timestep {scene.timestep:g}{gauge}"
    if most > BLUNTEST:
        cause = f"a blockiness of {most:g} leaves rounding alone of its equations; make it {BLUNTEST:g} at most{gauge}"
    return f"{count} contacts of superquadrics had no contact point that was found by step {step}: {cause}"


def refused(code: int, step: int, scene: Scene) -> str:
    """What an implicit step that gave up means by its answer."""
    if code == NOT_SOLVED:
        return f"the contacts of step {step + 1} could not be solved together: shorten the timestep {scene.timestep:g}"
    return (
        f"a particle moves more than half the skin {scene.neighbor.skin:g} of the neighbour list in step {step + 1}: "
        f"make the skin longer, or shorten the timestep {scene.timestep:g}"
    )

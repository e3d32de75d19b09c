"""The step loop on decks of superquadrics against LIGGGHTS 3.8.0: step by step from its dumped states, and whole motions.

LIGGGHTS ends the iteration for a contact point at an angle of 1e-5, here it is converged: forces are equal to some 1e-6 of the largest. With planes
both have the same closed form. Measured here, largest difference over the largest force: step by step 7e-7, planes 3e-13; whole motions 3e-6.
"""

from __future__ import annotations

import numpy as np
import pytest

from demsolver import Simulation
from tests.support.superquadric_decks import Worst, frames_of, scene_of, steps_from, vectors

PLANES = ("plane_elastic", "plane_friction", "planes_xy")
STEPS = (
    "pair_friction", "plane_friction", "planes_xy", "hooke_friction", "roll_cdt", "roll_epsd", "roll_epsd2", "integ_s0", "integ_s2", "integ_s3",
    "curv_gauss", "curv_mean", "curv_limit", "setup_friction",
)  # fmt: skip
MOTIONS = (*STEPS, "pair_elastic", "plane_elastic", "retouch", "free_s0", "free_s1", "free_s2", "free_s3")


@pytest.mark.parametrize("name", STEPS)
def test_each_step_is_liggghts(name: str) -> None:
    """Law: from each dumped state the next follows: forces and torques to 1e-5 of the largest, with planes alone to rounding."""
    frames = frames_of(name)
    worst = Worst(frames)
    for simulation, frame in steps_from(scene_of(name), frames):
        worst.look(simulation, frame)
        assert simulation.particles().x == pytest.approx(vectors(frame, ""), abs=1e-14)
    assert worst.most[0] > 1.0
    limit = 1e-12 if name in PLANES else 1e-5
    assert worst.force <= limit
    assert worst.torque <= limit


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_is_liggghts(name: str) -> None:
    """Law: from the first state on forces, torques, spins and ways stay within 1e-4 of the largest."""
    frames = frames_of(f"motions/{name}")
    worst, simulation = Worst(frames), Simulation(scene_of(name))
    simulation.setup()
    way = max(np.abs(vectors(frame, "") - vectors(frames[0], "")).max() for frame in frames)
    spin = max(np.abs(vectors(frame, "omega")).max() for frame in frames)
    for frame in frames:
        simulation.advance(frame.step - simulation.step)
        if worst.most[1] > 0.0:
            worst.look(simulation, frame)
        p = simulation.particles()
        assert np.abs(p.x - vectors(frame, "")).max() <= 1e-4 * way
        assert np.abs(p.omega - vectors(frame, "omega")).max() <= 1e-4 * spin
    assert simulation.step > 25
    assert worst.force <= 1e-4
    assert worst.torque <= 1e-4

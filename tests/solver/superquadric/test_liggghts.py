"""The step loop on decks of superquadrics against LIGGGHTS 3.8.0: step by step from its dumped states, and whole motions.

LIGGGHTS ends the iteration for a contact point at an angle of 1e-5, here it is converged: forces are equal to some 1e-6 of the largest. With planes
both have the same closed form. Measured here, largest difference over the largest force: step by step 1e-7, planes 8e-13; whole motions
2e-6, planes 2e-11.
"""

from __future__ import annotations

import numpy as np
import pytest

from demsolver import Simulation
from tests.support.superquadric_decks import DATA, Worst, frames_of, scene_of, steps_from, vectors

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


def test_energies_after_impact() -> None:
    """Law: eight pairs and eight bodies that hit a plane, e = 0.6, friction 0.4: translational and rotational energy are those LIGGGHTS printed
    within 1 % (measured: within 2e-7), before, in and after the impacts, and so is the last state."""
    printed = np.genfromtxt(DATA / "collide.thermo", names=True)
    simulation = Simulation(scene_of("collide"))
    simulation.setup()
    for row in printed:
        simulation.advance(int(row["Step"]) - simulation.step)
        p = simulation.particles()
        assert p.superquadrics
        assert 0.5 * float(p.mass @ (p.v**2).sum(axis=1)) == pytest.approx(row["kin"], rel=1e-6)
        assert 0.5 * float(np.sum(p.superquadrics.angmom * p.omega)) == pytest.approx(row["rot"], rel=1e-6)
    assert printed["kin"][-1] < 0.9 * printed["kin"][0]
    last = frames_of("collide")[-1]
    assert last.step == simulation.step == 6000
    assert np.abs(simulation.particles().x - vectors(last, "")).max() < 1e-7
    assert np.abs(simulation.particles().omega - vectors(last, "omega")).max() < 1e-5 * np.abs(vectors(last, "omega")).max()


def test_the_begin_of_a_bed() -> None:
    """Law: 60 bodies of six shapes fall into a box of five planes: forces stay within 1e-4 of the largest to step 1000 (1e-5 measured), until chaos
    has made of LIGGGHTS' 1e-6 what it will."""
    frames = frames_of("motions/dense")
    simulation = Simulation(scene_of("dense"))
    simulation.setup()
    for frame in frames:
        simulation.advance(frame.step - simulation.step)
        wanted = vectors(frame, "f")
        assert np.abs(simulation.forces()[0] - wanted).max() <= 1e-4 * np.abs(wanted).max()
    assert simulation.step == 1000
    assert (simulation.pairs.touching & 1).sum() > 5

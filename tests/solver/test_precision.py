"""Mixed precision: the geometry and the force of a contact as float32, all that is kept as float64."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demsolver import Simulation
from tests.support.scenes import GAMMAN, KN, bed

ULP = 2.0**-24  # of a float32, relative
STEP = 1e-5


def pair_of(steps: int) -> tuple[Simulation, Simulation]:
    """The bed in both precisions, so many steps on."""
    both = Simulation(bed(STEP), on_instability="off"), Simulation(bed(STEP), precision="mixed", on_instability="off")
    for simulation in both:
        simulation.setup()
        simulation.advance(steps)
    return both


def test_forces_are_off_by_float32_of_a_diameter() -> None:
    """Law: of one state the force is off by what rounding the vector between two particles to float32 moves them: a few ulp of a diameter times the
    stiffness, and of a velocity times the damping."""
    double, mixed = pair_of(0)
    b = double.bodies
    stiff = KN * 2.0 * b.radius.max() + GAMMAN * b.mass.max() * 2.0 * np.abs(b.v).max()
    error = np.abs(mixed.bodies.force - b.force).max()
    assert 0.0 < error < 16.0 * ULP * stiff  # up to a dozen contacts a sphere, a few roundings each


def test_momentum_is_kept_as_well_as_ever() -> None:
    """Law: both particles of a contact are given the same float32 force, so their sum stays nothing to the rounding of float64."""
    scene = replace(bed(STEP), forces=(), walls=())
    simulation = Simulation(scene, precision="mixed", on_instability="off")
    simulation.setup()
    b = simulation.bodies
    before, scale = b.mass @ b.v, b.mass @ np.abs(b.v).max(axis=1)
    simulation.advance(300)
    b = simulation.bodies
    assert np.abs(b.mass @ b.v - before).max() < 1e-12 * scale


def test_a_bed_stays_where_it_is() -> None:
    """Law: what rounding does to a settled bed does not add up: after 2,000 steps positions differ by less than 2e-4 of a radius (3e-5 was
    found), and no spring has lost what it remembers."""
    double, mixed = pair_of(2000)
    a, b = double.bodies, mixed.bodies
    assert np.abs(a.x - b.x).max() < 2e-4 * a.radius.min()
    # the weight is carried by springs that remember: had they forgotten, kinetic energy would show it
    assert abs(0.5 * b.mass @ (b.v**2).sum(axis=1) / (0.5 * a.mass @ (a.v**2).sum(axis=1)) - 1.0) < 1e-2

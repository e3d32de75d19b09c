"""The budget of the settled bed: what is held plus what was taken stays put, with the square of the step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import eigsh

from demsolver import Simulation
from demsolver.listed import Listed
from demsolver.neighbors import HOME, SHIFTS
from demsolver.state import Bodies
from tests.support.scenes import KN, bed

UNDAMPED = {"gamman": 0.0, "mu": 0.0, "friction": "none"}
SPAN = 0.01  # seconds: some 12 periods of the stiffest contact


def critical_step() -> float:
    """2/omega_max of the bed: the largest eigenvalue of the mass-weighted contact stiffness of the packing (central forces)."""
    simulation = Simulation(bed(1e-6, **UNDAMPED), on_instability="off")
    simulation.setup()
    bodies, pairs = simulation.bodies, simulation.pairs
    entries = []
    for k in np.flatnonzero(pairs.touching & 1):
        entries += _pair_block(bodies, pairs, k, simulation.box_hi - simulation.box_lo)
    row, column, value = (np.concatenate(part) for part in zip(*entries, strict=True))
    n = 3 * len(bodies.x)
    stiffness = sparse.coo_matrix((value, (row, column)), shape=(n, n)).tocsr()
    return float(2.0 / np.sqrt(eigsh(stiffness, k=1, which="LA", return_eigenvectors=False)[0]))


def _pair_block(b: Bodies, pairs: Listed, k: int, size: np.ndarray):
    i, j, shift = pairs.i[k], pairs.j[k], SHIFTS[pairs.shift[k]] * size
    d = b.x[i] - b.x[j] - shift
    block = KN * np.outer(d, d) / (d @ d)
    half = 1.0 if pairs.shift[k] == HOME else 0.5
    for first, second, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
        scaled = sign * half * block / np.sqrt(b.mass[first] * b.mass[second])
        row, column = np.meshgrid(3 * first + np.arange(3), 3 * second + np.arange(3), indexing="ij")
        yield row.ravel(), column.ravel(), scaled.ravel()


def errors(dt: float, samples: int = 50, **settings: object) -> tuple[float, float]:
    """Root mean square and largest deviation of the total over SPAN, relative to the energy that contacts and motion hold."""
    simulation = Simulation(bed(dt, **settings), budget=True, on_instability="off")  # type: ignore[arg-type]
    simulation.setup()
    start = simulation.energy_budget()
    steps, totals = round(SPAN / dt), []
    for _ in range(samples):
        simulation.advance(steps // samples)
        totals.append(simulation.energy_budget().total)
    drift = (np.array(totals) - start.total) / (start.kinetic + start.rotational + start.elastic_normal)
    return float(np.sqrt(np.mean(drift**2))), float(np.abs(drift).max())


@pytest.mark.parametrize("settings", [UNDAMPED, {}], ids=["undamped and frictionless", "damping and friction"])
def test_the_budget_closes_with_the_square_of_the_step(settings: dict[str, object]) -> None:
    """Law: total plus dissipated drifts as dt^2 (order 2 +- 0.3 over four steps), with and without dissipation."""
    steps = [4e-5, 2e-5, 1e-5, 5e-6]
    rms = [errors(dt, **settings)[0] for dt in steps]
    order = np.polyfit(np.log(steps), np.log(rms), 1)[0]
    assert 1.7 < order < 2.3, f"order {order:.2f}, errors {rms}"


@pytest.mark.parametrize("settings", [UNDAMPED, {}], ids=["undamped and frictionless", "damping and friction"])
def test_a_hundredth_of_the_critical_step_keeps_the_budget(settings: dict[str, object]) -> None:
    """Law: over 10,000 steps of a hundredth of the critical step the total stays within 1e-5 of the energy in motion and contacts."""
    dt = critical_step() / 100
    simulation = Simulation(bed(dt, **settings), budget=True, on_instability="off")  # type: ignore[arg-type]
    simulation.setup()
    start = simulation.energy_budget()
    scale = start.kinetic + start.rotational + start.elastic_normal
    for _ in range(50):
        simulation.advance(200)
        assert abs(simulation.energy_budget().total - start.total) < 1e-5 * scale


def test_friction_and_damping_only_take() -> None:
    """Law (second law of thermodynamics): what damping took never falls, and friction gives nothing back beyond its springs."""
    simulation = Simulation(bed(1e-5), budget=True, on_instability="off")
    simulation.setup()
    damped, rubbed = [0.0], [0.0]
    for _ in range(40):
        simulation.advance(25)
        budget = simulation.energy_budget()
        damped.append(budget.damped)
        rubbed.append(budget.rubbed)
    # a trapezoid over a step may overshoot by its own error, of order dt^2
    assert np.diff(damped).min() >= -1e-6 * damped[-1]
    assert np.diff(rubbed).min() >= -1e-6 * rubbed[-1]
    assert damped[-1] > 0 < rubbed[-1]


def test_the_budget_must_be_asked_for() -> None:
    """Law: a simulation without the account says so, instead of a zero."""
    with pytest.raises(ValueError, match="budget=True"):
        Simulation(bed(1e-5), on_instability="off").energy_budget()

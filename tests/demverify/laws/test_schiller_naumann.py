"""Falling through a gas: the path, the terminal slip, and how steps near them."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from demverify import laws
from demverify.cases import load_case
from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.errors import Place
from demverify.laws import linear_drag, schiller_naumann, terminal_slip
from tests.support.law_frames import frame, off

INPUTS = Path(__file__).parents[3] / "inputs"
G, RHO, GAS, MU, D, UP = 9.80665, 2000.0, 1.2, 1.8e-5, 1e-4, 0.4  # MFIX-DEM V&V, DEM-06
MASS = RHO * pi / 6.0 * D**3


def fall(t: np.ndarray, start: np.ndarray, gas: tuple[float, float, float] = (0.0, 0.0, UP), *, gas_density: float = GAS):
    """Positions and velocities (m, 1, 3) of the law."""
    rates = schiller_naumann.acceleration(np.array([MASS]), np.array([D / 2]), G, gas_density, MU, np.array(gas))
    return schiller_naumann.path(np.zeros((1, 3)), start, t, rates)


def test_the_numbers_of_mfix():
    """Law: DEM-06: slip 0.457401688 m/s and Re 3.049345 in the end; velocities on the way there."""
    slip = terminal_slip.terminal_slip(RHO, D, G, GAS, MU)
    assert slip == pytest.approx(0.457401688, abs=5e-10)
    assert GAS * D * slip / MU == pytest.approx(3.049345, abs=5e-7)
    _, v = fall(np.array([0.0, 0.01, 0.05, 0.1, 0.35]), np.zeros((1, 3)))
    assert v[1:, 0, 2] == pytest.approx([-0.01255261, -0.04078891, -0.05263133, -0.05739251], abs=5e-9)


@given(st.floats(2e-5, 1.4e-3), st.floats(100.0, 8000.0), st.floats(1e-6, 1e-2))
@example(1e-3, 900.0, 1e-3)
def test_at_the_terminal_slip_nothing_changes(d: float, density: float, mu: float):
    """Law: drag and buoyancy carry the weight there, for heavy and light spheres."""
    slip = terminal_slip.terminal_slip(density, d, G, 900.0, mu)
    rates = schiller_naumann.acceleration(np.array([density * pi / 6 * d**3]), np.array([d / 2]), G, 900.0, mu, np.zeros(3))
    assert np.abs(rates(np.array([[0.0, 0.0, -slip]]))).max() < 1e-11 * G * max(1.0, 900.0 / density)
    assert (slip >= 0.0) == (density >= 900.0)


def test_without_inertia_of_the_gas_it_is_stokes():
    """Law: for a gas of no density the path is the exponential of linear drag with c = 3 pi mu d, to the accuracy of the integral."""
    t, start = np.linspace(0.0, 0.3, 31), np.array([[0.7, -0.2, 0.1]])
    x, v = fall(t, start, (0.0, 0.0, 0.0), gas_density=0.0)
    frames = [frame(k, x[k], v[k], mass=MASS, radius=D / 2) for k in range(len(t))]
    found = linear_drag.measure(frames, 0.01, 3.0 * pi * MU * D, 1.0, G, 0.0, 0.0, -1.0)
    assert max(off(found).values()) < 1e-11


def test_an_integral_in_parts_is_the_integral():
    """Law: going on from the middle changes nothing: the integral is good to 1e-11."""
    start = np.array([[0.7, -0.2, 0.1]])
    x, v = fall(np.array([0.0, 0.05, 0.2]), start)
    y, w = fall(np.array([0.05, 0.2]), v[1])
    assert np.abs(w[1] - v[2]).max() < 1e-11
    assert np.abs(x[1] + y[1] - x[2]).max() < 1e-12


def test_another_drag_is_seen():
    """Law: a gas of twice the density brakes more; the path is off by percents."""
    t = np.linspace(0.0, 0.3, 31)
    x, v = fall(t, np.zeros((1, 3)), gas_density=2.0 * GAS)
    frames = [frame(k, x[k], v[k], mass=MASS, radius=D / 2) for k in range(len(t))]
    assert off(schiller_naumann.measure(frames, 0.01, G, GAS, MU, 0.0, 0.0, UP))["velocity"] > 0.01
    assert off(terminal_slip.measure(frames, G, GAS, MU, 0.0, 0.0, UP))["slip of particle 1"] > 0.01


def test_half_the_step_halves_the_error(tmp_path: Path):
    """Law: forces of half-step velocities are of first order: the miss goes with dt, and the end state has none."""
    case = load_case(INPUTS / "terminal-velocity", "mfix")
    law, end = case.laws
    missed, slips = [], []
    for dt in (4e-4, 2e-4, 1e-4):
        settings = {name: list(values) for name, values in case.variables.items()} | {"dt": [f"{dt}"], "steps": [f"{round(2.6 / dt)}"]}
        job = Job(case.decks["lammps"], tmp_path / f"{dt}", settings, round(0.01 / dt))
        _, outputs = ENGINE.run_with(job, keep=True, on_instability="off")
        found = laws.measure(law.name, outputs.frames, {**law.parameters, "dt": dt}, Place(case.folder))
        missed.append(off(found)["velocity"])
        slips.append(max(off(laws.measure(end.name, outputs.frames, end.parameters, Place(case.folder))).values()))
    assert np.log2(missed[0] / missed[1]) == pytest.approx(1.0, abs=0.1)
    assert np.log2(missed[1] / missed[2]) == pytest.approx(1.0, abs=0.1)
    assert max(slips) < 1e-8

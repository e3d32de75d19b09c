"""Rotation of bodies with three moments of inertia: closed forms, conserved quantities, orders, and LIGGGHTS' four schemes step by step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk, ellipkm1

from demsolver import rotation
from demsolver.rotation import Floats, Turning
from demsolver.shapes.rotation import matrix, to_body
from demverify.formats.dump import read_dump
from demverify.frames import Frame

DATA = Path(__file__).parents[2] / "data/superquadric"
LIGGGHTS = ("richardson", "no_squish", "midpoint", "woodem")  # integration schemes 0 to 3
UPRIGHT = np.array([[1.0, 0.0, 0.0, 0.0]])
MOMENTS = np.array([[1.0, 2.0, 3.0]])
R1 = rotation.turning(UPRIGHT, np.array([[1.0, 0.0, 0.8]]), MOMENTS)
"""k^2 = 25/48, rate 0.8: omega along the body axes is (cn, sn, 0.8 dn)."""
TUMBLING = rotation.turning(UPRIGHT, np.array([[0.0, 1.0, 1e-4]]), MOMENTS)
"""Dzhanibekov: about the middle axis, all but."""


def energy(state: Turning) -> float:
    return 0.5 * float(np.sum(state.omega * state.angmom))


def apart(q: Floats, other: Floats) -> float:
    """Largest difference, q and -q being the same orientation."""
    return float(min(np.abs(q - other).max(), np.abs(q + other).max()))


def by_equations(state: Turning, moments: Floats, time: float) -> Floats:
    """Orientation by q' = q o omega/2, omega = I^-1 R^T L, one body, to 1e-13."""

    def rate(_: float, q: Floats) -> Floats:
        a, b, c = (matrix(q[None])[0].T @ state.angmom[0]) / moments[0]
        w, x, y, z = q
        return 0.5 * np.array([-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a])

    q = solve_ivp(rate, (0.0, time), state.quat[0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return np.asarray(q / np.linalg.norm(q))[None]


def test_the_folder_is_the_listing() -> None:
    """Law: a module is a scheme; a name that is none is refused with those that are."""
    assert set(LIGGGHTS) < set(rotation.schemes())
    with pytest.raises(ValueError, match=r"'euler' is not one of exact, midpoint"):
        rotation.scheme("euler")


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(*(st.sampled_from((0.6, 1.0, 1.0 + 1e-9, 1.7, 2.5)) for _ in range(3))),
    st.tuples(*(st.sampled_from((-1.3, -0.2, 0.0, 1e-7, 0.9)) for _ in range(3))),
    st.floats(0.01, 4.0),
)
def test_exact_is_the_solution_of_the_equations(moments: tuple[float, ...], omega: tuple[float, ...], time: float) -> None:
    """Law: in one step of any length, and in many, the top is where the equations of motion have it; spheres, symmetric tops, fixed axes and all."""
    inertia = np.array([moments])
    start = rotation.turning(np.array([[0.3, -0.5, 0.7, 0.1]]), np.array([omega]), inertia)
    once, often = (rotation.freely("exact", start, inertia, time / n, n) for n in (1, 50))
    assert apart(once.quat, by_equations(start, inertia, time)) < 1e-11
    assert apart(once.quat, often.quat) < 1e-12


def test_a_top_in_closed_form() -> None:
    """Law: R1: omega along the body axes is (cn, sn, 0.8 dn)(0.8 t, 25/48), and it is back after 4 K/0.8."""
    for time in (0.1, 1.0, 5.0, 4.0 * ellipk(25 / 48) / 0.8):
        found = rotation.freely("exact", R1, MOMENTS, time / 10, 10)
        sn, cn, dn, _ = ellipj(0.8 * time, 25 / 48)
        assert to_body(found.quat, found.omega)[0] == pytest.approx([cn, sn, 0.8 * dn], abs=1e-13)
    assert to_body(found.quat, found.omega) == pytest.approx(R1.omega, abs=1e-12)


def test_exact_keeps_energy_and_momentum_over_a_million_steps() -> None:
    """Law: energy and angular momentum in space drift by less than 1e-13 over 1,000,000 steps."""
    last = rotation.freely("exact", R1, MOMENTS, 1e-3, 1_000_000)
    assert abs(energy(last) / energy(R1) - 1.0) < 1e-13
    assert np.abs(last.angmom - R1.angmom).max() == 0.0
    spin = to_body(last.quat, last.omega)[0]
    sn, cn, dn, _ = ellipj(0.8 * 1000.0, 25 / 48)
    assert spin == pytest.approx([cn, sn, 0.8 * dn], abs=1e-10)  # the phase: a rate that is off by 1e-13 for a time of 1,000


@pytest.mark.parametrize("seed", range(3))
def test_exact_in_any_orientation(seed: int) -> None:
    """Law: so does a top that is turned before it starts: 1,000,000 roundings of the orientation are a random walk of some 2e-14 of the energy."""
    rng = np.random.default_rng(seed)
    first = rotation.turning(rng.normal(size=(1, 4)), rng.normal(size=(1, 3)), MOMENTS)
    last = rotation.freely("exact", first, MOMENTS, 1e-3, 1_000_000)
    assert np.array_equal(last.angmom, first.angmom)
    assert abs(energy(last) / energy(first) - 1.0) < 1e-13


def test_a_tumbling_top_flips_at_the_exact_times() -> None:
    """Law: R2: omega2 passes zero at (2 j + 1) K/n, n = 0.57735..., to 1e-6: 17.402 + 34.805 j."""
    # M^2 - 2 E I2 = 3e-8 and M^2 - 2 E I1 = 2 + 6e-8: k'^2 = 2 3e-8/(2 + 6e-8), n^2 = (2 + 6e-8)/6; it begins where omega2 is largest, at K
    other = float(ellipkm1(6e-8 / (2.0 + 6e-8)) / np.sqrt((2.0 + 6e-8) / 6.0))
    dt, steps = 0.05, 1800
    spins = np.empty(steps + 1)
    state = TUMBLING
    for k in range(steps + 1):
        spins[k] = to_body(state.quat, state.omega)[0, 1]
        state = rotation.freely("exact", state, MOMENTS, dt, 1)
    found = []
    for k in np.flatnonzero(spins[:-1] * spins[1:] < 0.0):
        low, high = 0.0, dt
        before = rotation.freely("exact", TUMBLING, MOMENTS, dt, int(k))
        for _ in range(40):
            middle = 0.5 * (low + high)
            now = rotation.freely("exact", before, MOMENTS, middle, 1)
            same = to_body(now.quat, now.omega)[0, 1] * spins[k] > 0.0
            low, high = (middle, high) if same else (low, middle)
        found.append(k * dt + low)
    assert found == pytest.approx([(2 * j + 1) * other for j in range(len(found))], abs=1e-6)
    assert found[:2] == pytest.approx([17.402, 52.207], abs=1e-3)


@pytest.mark.parametrize(("name", "order"), [("richardson", 2), ("no_squish", 2), ("midpoint", 2), ("woodem", 1)])
def test_orders(name: str, order: int) -> None:
    """Law: the error of the orientation after 5 falls with the square of the step; of scheme 3, with its old orientation, with the step."""
    exact = rotation.freely("exact", R1, MOMENTS, 5.0, 1).quat
    errors = [apart(rotation.freely(name, R1, MOMENTS, 5.0 / n, n).quat, exact) for n in (2000, 4000)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize(("name", "energies", "momenta"), [
    ("exact", 1e-14, 0.0), ("midpoint", 1e-12, 1e-4), ("no_squish", 0.2 * 0.01**2, 1e-11), ("richardson", np.inf, 0.0), ("woodem", np.inf, 0.0),
])  # fmt: skip
def test_what_a_scheme_keeps(name: str, energies: float, momenta: float) -> None:
    """Law: energy: exact and midpoint to rounding, NO_SQUISH within 0.2 dt^2; angular momentum: all but midpoint, which swings within dt^2."""
    state, worst, drift = R1, 0.0, 0.0
    for _ in range(200):
        state = rotation.freely(name, state, MOMENTS, 0.01, 50)
        worst, drift = max(worst, abs(energy(state) / energy(R1) - 1.0)), max(drift, float(np.abs(state.angmom - R1.angmom).max()))
    assert worst <= energies
    assert drift <= momenta


def test_richardson_gains_energy_steadily() -> None:
    """Law: its energy drifts with t dt^3: eight times less at half the step, and twice as much in twice the time."""

    def gained(dt: float, time: float) -> float:
        return energy(rotation.freely("richardson", R1, MOMENTS, dt, round(time / dt))) / energy(R1) - 1.0

    assert gained(0.02, 100.0) / gained(0.01, 100.0) == pytest.approx(8.0, rel=0.05)
    assert gained(0.01, 200.0) / gained(0.01, 100.0) == pytest.approx(2.0, rel=0.05)


def state_of(frame: Frame) -> tuple[Turning, Floats]:
    """Orientations, angular momenta, spins and moments of a dump."""
    quat = np.stack([frame.columns[f"quat{k}"] for k in range(1, 5)], 1)
    angmom, omega, inertia = (frame.vectors(f"{kind}x", f"{kind}y", f"{kind}z") for kind in ("angmom", "omega", "inertia"))
    return Turning(quat, angmom, omega), inertia


@pytest.mark.parametrize("scheme", range(4))
def test_each_step_of_liggghts(scheme: int) -> None:
    """Law: from a dumped state the next one follows to 1e-13 of its size, for LIGGGHTS' schemes 0 to 3, and the 80th from the eighth."""
    frames = list(read_dump(DATA / f"scheme{scheme}.dump.gz"))
    states, inertia = [state_of(frame)[0] for frame in frames], state_of(frames[0])[1]
    begin = 1 if scheme == 3 else 0  # at step 0 its angular momentum is not yet that of half a step before
    for k in range(begin, len(frames) - 1):
        steps = frames[k + 1].step - frames[k].step
        found = rotation.freely(LIGGGHTS[scheme], states[k], inertia, 4e-5, steps)
        for part, wanted in zip(found, states[k + 1], strict=True):
            assert np.abs(part - wanted).max() < 1e-13 * steps * np.abs(wanted).max()


def test_ten_thousand_steps_of_liggghts() -> None:
    """Law: 24 bodies in free flight are where LIGGGHTS has them 10,000 steps later, to 1e-9."""
    frames = list(read_dump(DATA / "free.dump.gz"))
    (start, inertia), (end, _) = state_of(frames[0]), state_of(frames[-1])
    assert frames[-1].step - frames[0].step == 10_000
    found = rotation.freely("no_squish", start, inertia, 1e-5, 10_000)
    for part, wanted in zip(found, end, strict=True):
        assert np.abs(part - wanted).max() < 1e-9 * np.abs(wanted).max()

"""The longest stable step of one contact: the algebra, the closed forms, and simulations a little below and above."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import EulerSphere, Freeze, Neighbor, NveSphere, Scene, Viscous, contact
from demsolver.stability import ContactLimit, combined_limit, contact_limits, damper_limit, spring_limit
from demsolver.stability_contacts import contacts_of
from demverify.stability.held import KN, MASS, NUDGE, OVERLAP, RADIUS, growth, linear, on_floor, pair
from tests.support.laws import contact_law


def euler(K: float, H: float) -> np.ndarray:
    """One step of semi-implicit Euler for (x, v dt)."""
    return np.array([[1.0 - K, 1.0 - H], [-K, 1.0 - H]])


def verlet(K: float, H: float) -> np.ndarray:
    """One step of velocity Verlet for (x(n), v(n - 1/2) dt), the force at step n from the half-step velocity: kick, kick, drift."""
    kick = np.array([[1.0, 0.0], [-0.5 * K, 1.0]])  # the elastic half of a kick; damping uses the velocity before both
    damped = np.array([[1.0, 0.0], [0.0, 1.0 - H]])
    drift = np.array([[1.0, 1.0], [0.0, 1.0]])
    return drift @ kick @ kick @ damped


def radius_of(matrix: np.ndarray) -> float:
    """Spectral radius."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


@given(K=st.floats(1e-3, 6.0), H=st.floats(1e-3, 3.0))
def test_the_combined_condition_is_that_of_the_eigenvalues(K: float, H: float) -> None:
    """Law: |lambda| < 1 exactly where H < 2 and K + 2 H < 4, for Euler and for Verlet with half-step velocities, whose matrices are similar."""
    assert np.trace(euler(K, H)) == pytest.approx(np.trace(verlet(K, H)), abs=1e-12)
    assert np.linalg.det(euler(K, H)) == pytest.approx(np.linalg.det(verlet(K, H)), abs=1e-12)
    margin = 4.0 - K - 2.0 * H
    if abs(margin) > 1e-6 and abs(H - 2.0) > 1e-6:  # nearer than that the sign is rounding's
        assert (radius_of(euler(K, H)) < 1.0) == (margin > 0.0)


@given(K=st.floats(1e-6, 3.999))
def test_without_damping_the_eigenvalues_lie_on_the_unit_circle(K: float) -> None:
    """Law: neutrally stable up to K = 4; the primer's (2.23) has |lambda| < 1 there. At K = 4 lambda = -1, beyond it grows."""
    assert np.abs(np.linalg.eigvals(euler(K, 0.0))) == pytest.approx(1.0, abs=1e-9)
    assert radius_of(euler(4.0 + K, 0.0)) > 1.0


def test_a_damper_alone_has_the_primers_eigenvalues() -> None:
    """Law: without a spring lambda = 1 and 1 - H (2.29), so the (1, 1) entry of (2.28) is 2 - eta dt/m, not 2 - k dt^2/m."""
    for H in (0.5, 1.0, 1.9, 2.1):
        assert sorted(np.linalg.eigvals(euler(0.0, H))) == pytest.approx(sorted((1.0, 1.0 - H)))
        two_step = np.array([[2.0 - H, H - 1.0], [1.0, 0.0]])  # (2.28), mended
        assert sorted(np.linalg.eigvals(two_step)) == pytest.approx(sorted((1.0, 1.0 - H)))


@given(m=st.floats(1e-6, 1e3), k=st.floats(1e-3, 1e9), ratio=st.just(0.0) | st.floats(1e-6, 50.0))
def test_the_combined_limit_solves_its_condition(m: float, k: float, ratio: float) -> None:
    """Law: at the limit K + 2 H = 4 and H <= 2; it never exceeds spring or damper alone and is the one where the other is absent."""
    eta = ratio * np.sqrt(k * m)
    dt = combined_limit(m, k, eta)
    assert k * dt**2 / m + 2 * eta * dt / m == pytest.approx(4.0)
    assert dt <= min(spring_limit(m, k), damper_limit(m, eta)) * (1 + 1e-12)
    assert combined_limit(m, k, 0.0) == pytest.approx(spring_limit(m, k), rel=1e-14)
    assert combined_limit(m, 0.0, eta) == (pytest.approx(damper_limit(m, eta), rel=1e-14) if eta else np.inf)


def test_the_smaller_of_both_is_too_long() -> None:
    """Law: at H = 1 the limit is K = 2, not 4: a step of (2.31) grows."""
    m, k, eta = 1.0, 1.0, np.sqrt(0.5)
    dt = combined_limit(m, k, eta)
    assert eta * dt / m == pytest.approx(1.0)
    assert k * dt**2 / m == pytest.approx(2.0)
    too_long = min(spring_limit(m, k), damper_limit(m, eta))
    assert radius_of(euler(k * too_long**2 / m, eta * too_long / m)) > 1.5


def limits(scene: Scene) -> dict[tuple[str, str], ContactLimit]:
    """The limits of a scene by (between, motion)."""
    return {(limit.between, limit.motion): limit for limit in contact_limits(scene, contacts_of(scene))}


@pytest.mark.parametrize("gamman", [0.0, 3000.0], ids=["undamped", "damped"])
@pytest.mark.parametrize(
    ("make", "between", "mass"), [(pair, "types 1 and 1", 0.5 * MASS), (on_floor, "type 1 and wall floor", MASS)], ids=["pair", "wall"]
)
def test_a_linear_contact_holds_below_its_limit_and_grows_above(make: Callable[..., Scene], between: str, mass: float, gamman: float) -> None:
    """Law: the limit of one contact, normal motion, to 1 %: 2 sqrt(m*/k) without damping, 4 m*/(eta + sqrt(eta^2 + 4 k m*)) with it."""
    law = linear((1, 1) if make is pair else (1,), gamman=gamman, mu=0.0)
    limit = limits(make(1e-6, law))[between, "normal"]
    assert (limit.mass, limit.stiffness, limit.damping) == pytest.approx((mass, KN, gamman * mass), rel=1e-9)
    dt = limit.combined
    for part, grows in ((0.99, False), (1.01, True)):
        found = growth(make(part * dt, law, along=NUDGE * OVERLAP / dt))
        # below, the eigenvectors are nearly parallel: an undamped mode swells up to 1/sqrt(1 - K/4) = 7 times, and K = 4 times that is its force
        assert found > 1e3 if grows else found < 30.0


@pytest.mark.parametrize("xt", [0.0, 0.5], ids=["undamped", "damped"])
@pytest.mark.parametrize(
    ("make", "between", "mass"), [(pair, "types 1 and 1", 0.5 * MASS), (on_floor, "type 1 and wall floor", MASS)], ids=["pair", "wall"]
)
def test_the_contact_point_of_a_sphere_has_two_sevenths_of_the_mass(make: Callable[..., Scene], between: str, mass: float, xt: float) -> None:
    """Law: 1/m_t = 1/m* + R^2/I summed, 7/2 of 1/m* for solid spheres: a stiff tangential spring rules the step, to 1 %."""
    law = linear((1, 1) if make is pair else (1,), gamman=2000.0, kt=2.0 * KN, xt=xt)
    limit = limits(make(1e-6, law))[between, "tangential"]
    assert (limit.mass, limit.stiffness, limit.damping) == pytest.approx((2 / 7 * mass, 2.0 * KN, xt * 2000.0 * mass), rel=1e-9, abs=1e-12)
    dt = limit.combined
    assert dt < 0.6 * limits(make(1e-6, law))[between, "normal"].combined
    for part, grows in ((0.99, False), (1.01, True)):
        found = growth(make(part * dt, law, across=NUDGE * OVERLAP / dt))
        assert found > 1e3 if grows else found < 30.0


@pytest.mark.parametrize("gamman", [0.0, 3000.0], ids=["undamped", "damped"])
def test_semi_implicit_euler_has_the_same_limit(gamman: float) -> None:
    """Law: the limit of velocity Verlet with half-step velocities is that of semi-implicit Euler."""
    law = linear((1,), gamman=gamman, mu=0.0)
    dt = limits(on_floor(1e-6, law))["type 1 and wall floor", "normal"].combined
    for part, grows in ((0.99, False), (1.01, True)):
        scene = replace(on_floor(part * dt, law, along=NUDGE * OVERLAP / dt), integrate=(EulerSphere(),))
        found = growth(scene)
        assert found > 1e3 if grows else found < 30.0


def test_rolling_and_twisting_springs_have_limits_of_their_own() -> None:
    """Law: a torque spring k on a sphere of inertia I = 2/5 m R^2 at a wall holds up to 4 I/(eta + sqrt(eta^2 + 4 k I)), to 1 %."""
    values = {"kn": KN, "rolling_stiffness": 4 * KN, "rolling_damping": 2.0, "twisting_stiffness": 2 * KN * RADIUS**2, "twisting_damping": 1e-5,
              "rolling_friction": 1e6, "twisting_friction": 1e6}  # fmt: skip
    law = contact_law((1,), values=values, friction="none", rolling="sds", twisting="sds")
    inertia = 0.4 * MASS * RADIUS**2
    for motion, axis, stiffness, damping in (("rolling", 0, 4 * KN * RADIUS**2, 2.0 * RADIUS**2), ("twisting", 2, 2 * KN * RADIUS**2, 1e-5)):
        limit = limits(on_floor(1e-6, law))["type 1 and wall floor", motion]
        assert (limit.mass, limit.stiffness, limit.damping) == pytest.approx((inertia, stiffness, damping), rel=1e-9)
        dt = limit.combined
        for part, grows in ((0.99, False), (1.01, True)):
            scene = on_floor(part * dt, law)
            scene.particles.omega[0, axis] = NUDGE * OVERLAP / RADIUS / dt
            found = growth(scene)
            assert found > 1e3 if grows else found < 30.0


HERTZ_KN = 3e7


def hertz(shape: tuple[int, ...]) -> object:
    """Hertz without damping or friction."""
    return contact_law(shape, values={"kn": HERTZ_KN}, normal="hertz", friction="none")


def test_a_hertz_contact_is_taken_as_deep_as_it_is() -> None:
    """Law: at overlap d the stiffness is 3/2 kn sqrt(R* d); the step of the sphere at rest there holds and grows at 2 sqrt(m/k), to 1 %."""
    overlap = 2e-5
    force = HERTZ_KN * np.sqrt(RADIUS * overlap) * overlap
    scene = on_floor(1e-6, hertz((1,)), overlap=overlap, pull=force / MASS)
    limit = limits(scene)["type 1 and wall floor", "normal"]
    assert (limit.overlap, limit.at) == (pytest.approx(overlap), "the largest now")
    assert limit.stiffness == pytest.approx(1.5 * HERTZ_KN * np.sqrt(RADIUS * overlap), rel=1e-9)
    dt = 2 * np.sqrt(MASS / limit.stiffness)
    for part, grows in ((0.99, False), (1.01, True)):
        found = growth(on_floor(part * dt, hertz((1,)), along=NUDGE * overlap / dt, overlap=overlap, pull=force / MASS))
        assert found > 1e3 if grows else found < 30.0


@given(speed=st.floats(1e-3, 30.0))
def test_an_impact_reaches_the_closed_form(speed: float) -> None:
    """Law: nothing touches: the overlap of a Hertz impact, [5 m v^2/(4 kn sqrt(R*))]^(2/5), of the largest closing speed."""
    scene = on_floor(1e-6, hertz((1,)), overlap=-RADIUS, along=-speed)
    limit = limits(scene)["type 1 and wall floor", "normal"]
    assert limit.overlap == pytest.approx((1.25 * MASS * speed**2 / (HERTZ_KN * np.sqrt(RADIUS))) ** 0.4, rel=1e-9)
    assert limit.at == f"closing in at {speed:.3g}"


def test_nothing_that_touches_or_closes_in_limits_nothing() -> None:
    """Law: a Hertz contact that is not there has no stiffness; a linear one has it at once."""
    resting = limits(on_floor(1e-6, hertz((1,)), overlap=-RADIUS))["type 1 and wall floor", "normal"]
    assert (resting.combined, resting.at) == (np.inf, "nothing touches or closes in")
    assert limits(on_floor(1e-6, linear((1,)), overlap=-RADIUS))["type 1 and wall floor", "normal"].combined < np.inf


def test_a_faster_approach_counts_beyond_the_present_overlap() -> None:
    """Law: of the largest overlap now and the one that closing speed would reach the larger is taken."""
    scene = on_floor(1e-6, hertz((1,)), overlap=1e-7, along=-10.0)
    assert limits(scene)["type 1 and wall floor", "normal"].at == "closing in at 10"


def test_only_who_can_meet_has_a_limit() -> None:
    """Law: excluded, frozen and unmoved partners: no limit, or that of one mass; the two lightest of a pair of types set it."""
    law = linear((2, 2))
    scene = replace(pair(1e-6, law), ntypes=2, walls=())
    scene = replace(scene, particles=replace(scene.particles, type=np.array([1, 2])))
    assert [limit.between for limit in contact_limits(scene, contacts_of(scene))] == ["types 1 and 2"]
    frozen = replace(scene, forces=(Freeze(2),))
    assert limits(frozen)["types 1 and 2", "normal"].mass == pytest.approx(MASS)
    unmoved = replace(scene, integrate=(NveSphere(1),))
    assert limits(unmoved)["types 1 and 2", "normal"].mass == pytest.approx(MASS)
    assert not limits(replace(scene, forces=(Freeze(1), Freeze(2))))
    apart = replace(scene, neighbor=Neighbor(1e-3, exclude_types=((1, 2),)))
    assert not limits(apart)


def test_drag_is_a_damper() -> None:
    """Law: F = -gamma v holds up to 2 m/gamma."""
    scene = replace(on_floor(1e-6, linear((1,))), forces=(Viscous(np.array([0.5])),))
    assert limits(scene)["type 1 and the medium", "drag"].combined == pytest.approx(2 * MASS / 0.5)


@pytest.mark.parametrize("name", [n for n in contact.listing("normal") if contact.is_step_law(n) or contact.is_implicit(n)])
def test_step_laws_limit_nothing_and_say_so(name: str) -> None:
    """Law: a law that maps a step, or solves for it, has no longest step; the limit is inf and the reason is told."""
    found = limits(on_floor(1e-6, contact_law((1,), normal=name, friction="none")))["type 1 and wall floor", "normal"]
    assert found.combined == np.inf
    assert "no limit" in found.at

"""The DEM primer's tangential spring (1.11)-(1.18), torque (1.19), rolling resistance (1.20) and sign of (1.12)."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from demsolver import Box, ContactLaw, EulerSphere, Gravity, Neighbor, NveSphere, Plane, Scene, Simulation, Wall
from demsolver.contact import friction_primer, friction_rotated_history, rolling_primer
from tests.support.scenes import spheres

Floats = NDArray[np.float64]
KT, GT, MU, DT = 1e4, 2.0, 0.5, 1e-5
BOX = Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff"))
R, KN = 0.005, 1e4


def slide(vt: Floats, s: Floats, *, load: float = 3.0, gt: float = GT, advance: bool = True) -> tuple[Floats, Floats]:
    """Force (3,) and spring (3,) of one step of the primer's law."""
    found = np.array(friction_primer.force(load, KT, gt, MU, *vt, *s, DT, advance))
    return found[:3], found[3:]


numbers = st.integers(-1000, 1000).map(lambda k: k * 1e-3)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)


@settings(deadline=None)
@given(vt=vectors, s=vectors)
def test_the_spring_turns_to_the_sliding_and_grows(vt: Floats, s: Floats) -> None:
    """Law (1.14), (1.15), (1.11): s' = (|s| + |vt| dt) t and Ft = -kt s' - eta vt, t = vt/|vt|: below the limit."""
    assume(vt.any())
    spring = 1e-5 * s
    force, new = slide(vt, spring, load=1e9)
    t = vt / np.linalg.norm(vt)
    assert new == pytest.approx((np.linalg.norm(spring) + np.linalg.norm(vt) * DT) * t, rel=1e-12)
    assert force == pytest.approx(-KT * new - GT * vt, rel=1e-12)


def test_at_rest_the_spring_stays_and_pulls() -> None:
    """Law (1.16): where vt = 0 the spring is what it was, and so is its force; a fresh contact at rest feels nothing."""
    s = np.array([1e-5, -2e-5, 0.0])
    force, new = slide(np.zeros(3), s)
    assert (new == s).all()
    assert force == pytest.approx(-KT * s)
    assert not np.any(slide(np.zeros(3), np.zeros(3)))


@settings(deadline=None)
@given(vt=vectors, s=vectors, load=st.floats(0.01, 5.0))
def test_sliding_keeps_the_spring(vt: Floats, s: Floats, load: float) -> None:
    """Law (1.17), (1.18): |Ft| <= mu |Fn|; over it Ft = -mu |Fn| t and the spring stays as it was, long as it may be."""
    spring = 1e-4 * s
    force, new = slide(vt, spring, load=load)
    assert np.linalg.norm(force) <= MU * load * (1.0 + 1e-12)
    wanted = KT * (np.linalg.norm(spring) + np.linalg.norm(vt) * DT) + GT * np.linalg.norm(vt)
    if wanted > MU * load * (1.0 + 1e-12):
        assert (new == spring).all()
        away = vt if vt.any() else spring
        assert force == pytest.approx(-MU * load * away / np.linalg.norm(away), rel=1e-12)


def test_setup_stores_nothing() -> None:
    """Law: set-up computes -kt |s| t - eta vt of the spring as it is, and leaves it."""
    vt, s = np.array([0.0, 0.1, 0.0]), np.array([1e-5, 0.0, 0.0])
    force, new = slide(vt, s, advance=False)
    assert (new == s).all()
    assert force == pytest.approx([0.0, -KT * 1e-5 - GT * 0.1, 0.0])


@settings(deadline=None)
@given(vt=vectors, s=vectors, load=st.floats(0.0, 5.0))
def test_it_only_takes(vt: Floats, s: Floats, load: float) -> None:
    """Law: Ft.vt <= 0 whatever the spring: nothing that it took can be got back, so its energy is 0."""
    force, _ = slide(vt, 1e-4 * s, load=load)
    assert force @ vt <= 0.0
    assert friction_primer.energy() == 0.0


def driven(speeds: Floats, law: str) -> tuple[Floats, float]:
    """Force over a prescribed motion along x, speeds (n,), and the work done against it; without dashpot, far below the limit."""
    s, forces, work = np.zeros(3), [], 0.0
    for v in speeds:
        vt = np.array([v, 0.0, 0.0])
        if law == "primer":
            f, s = slide(vt, s, load=1e9, gt=0.0)
        else:
            found = np.array(friction_rotated_history.force(1e9, KT, 0.0, MU, 0.0, 0.0, 1.0, *vt, *s, DT, True))
            f, s = found[:3], found[3:]
        forces.append(float(f[0]))
        work -= float(f @ vt) * DT
    return np.array(forces), work


def test_there_and_back() -> None:
    """Law: led 1 mm there and back, LAMMPS' spring gives back what it took and ends at zero; the primer's never unloads: its force turns round
    at once where the sliding does, grows on to kt times the whole path, and the whole cycle took kt path^2/2."""
    n = 1000
    path = 2 * n * 0.1 * DT
    speeds = np.array([0.1] * n + [-0.1] * n)
    force, work = driven(speeds, "primer")
    assert force[n - 1] == pytest.approx(-KT * path / 2)
    assert force[n] == pytest.approx(KT * path / 2, rel=2.0 / n)
    assert force[-1] == pytest.approx(KT * path)
    assert work == pytest.approx(0.5 * KT * path**2, rel=1.0 / n)  # a sum of n steps
    back, nothing = driven(speeds, "rotated")
    assert abs(back[-1]) < 1e-9 * KT * path
    assert abs(nothing) < 1e-3 * work


def squeezed(kt: float, gt: float, v: float, *, mu: float = 0.5, dt: float = 1e-5, euler: bool = True) -> Scene:
    """A sphere between two planes that press on it from above and below, thrown along them: the two friction forces add, their torques cancel."""
    tables = {"kn": KN, "shear_stiffness": kt, "gammat": gt, "mu": mu}
    one = ContactLaw("hooke", "none", "constant", "absolute", "primer", {name: np.full(1, value) for name, value in tables.items()})
    walls = tuple(Wall(name, Plane((0.0, 0.0, 1.0), offset), one) for name, offset in (("low", 0.5 * R), ("high", -0.5 * R)))
    p = spheres(np.zeros((1, 3)), np.full(1, R), v=np.array([[v, 0.0, 0.0]]))
    return Scene(BOX, p, 1, dt, walls=walls, integrate=(EulerSphere(),) if euler else (NveSphere(),))


@pytest.mark.parametrize("gt", [0.0, 1.0])
@pytest.mark.parametrize("euler", [True, False])
def test_a_contact_that_should_stick_trembles_and_grows(gt: float, euler: bool) -> None:
    """Law: in steps dt the spring of a contact at rest grows by |vt| dt each step while vt changes sign, so that both grow by the larger root of
    lambda^2 - (K + H) lambda - (1 - H) = 0, K = k dt^2/m, H = eta dt/m: above one for every step and dashpot, in Euler and Verlet alike."""
    scene = squeezed(10.0 * KN, gt, 1e-9, euler=euler)
    mass = float(scene.particles.mass[0])
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(1500)
    speeds = []
    for _ in range(60):
        simulation.advance(1)
        b = simulation.bodies
        speeds.append(b.v[0, 0] if euler else b.v[0, 0] - 0.5e-5 * b.force[0, 0] / mass)
    k, h = 20.0 * KN * 1e-10 / mass, 2.0 * gt * 1e-5 / mass
    factor = 0.5 * (k + h + np.sqrt((k + h) ** 2 + 4.0 * (1.0 - h)))
    measured = (abs(speeds[-1]) / abs(speeds[1])) ** (1.0 / 58.0)
    assert all(a * b < 0.0 for a, b in pairwise(speeds))
    assert factor > 1.0 + k / 3.0
    # the part of the other root, -(1 - H)/lambda, has faded to lambda^-3000 of this one
    assert measured == pytest.approx(factor, rel=1e-7)


def test_the_tremble_grows_to_the_limit() -> None:
    """Law: a sphere all but at rest ends trembling at the limit, each step turning its velocity round by 2 mu |Fn| dt/m (two walls): of order dt,
    and out of nothing."""
    scene = squeezed(10.0 * KN, 0.0, 1e-6, mu=0.1)
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(6000)
    speeds = []
    for _ in range(2):
        simulation.advance(1)
        speeds.append(abs(float(simulation.bodies.v[0, 0])))
    assert sum(speeds) == pytest.approx(2.0 * 0.1 * 0.5 * R * KN * 1e-5 / float(scene.particles.mass[0]), rel=1e-9)
    assert max(speeds) > 1e4 * 1e-6


def test_nothing_rests_under_a_load() -> None:
    """Law: pulled with a 40th of what friction could hold, the sphere creeps with T dt/m for ever (T the pull), for all its dashpot; LAMMPS' spring
    holds it at rest."""
    dt, speeds = 1e-5, {}
    for friction in ("primer", "rotated_history"):
        base = squeezed(KN, 1.0, 0.0, mu=0.01, dt=dt, euler=False)
        walls = tuple(replace(wall, law=replace(wall.law, friction=friction)) for wall in base.walls)
        simulation = Simulation(replace(base, walls=walls, forces=(Gravity((9.81, 0.0, 0.0)),)))
        simulation.setup()
        simulation.advance(20000)
        before = float(simulation.bodies.x[0, 0])
        simulation.advance(20000)
        speeds[friction] = (float(simulation.bodies.x[0, 0]) - before) / 0.2
    # the phase of the tremble wanders: parts in a hundred
    assert speeds["primer"] == pytest.approx(9.81 * dt, rel=0.05)
    assert abs(speeds["rotated_history"]) < 1e-9 * 9.81 * dt


def test_rolling_resistance_of_the_primer() -> None:
    """Law (1.20): M_i = -mu_r R_i |Fn| w/|w|; nothing at w = 0; stores nothing."""
    w = np.array([3.0, -4.0, 12.0])
    torque = np.array(rolling_primer.torque(2.0, 0.3, 0.1, *w))
    assert torque == pytest.approx(-0.1 * 0.3 * 2.0 * w / 13.0)
    assert rolling_primer.torque(2.0, 0.3, 0.1, 0.0, 0.0, 0.0) == (0.0, 0.0, 0.0)
    assert rolling_primer.energy() == 0.0


def pair(radii: tuple[float, float], law: ContactLaw, *, v: Floats | None = None, omega: Floats | None = None) -> Simulation:
    """Two spheres with a hundredth of a radius of overlap, the first above the second along (0.6, 0, 0.8); set up."""
    n = np.array([0.6, 0.0, 0.8])
    x = np.array([(sum(radii) - 0.01 * radii[0]) * n, np.zeros(3)]) + 0.1
    simulation = Simulation(Scene(BOX, spheres(x, np.array(radii), v=v, omega=omega), 1, DT, pair=law, integrate=(NveSphere(),)))
    simulation.setup()
    return simulation


def rolling_law(mu_r: float) -> ContactLaw:
    """A spring with the primer's rolling resistance and nothing else."""
    tables = {"kn": np.full((1, 1), KN), "rolling_friction": np.full((1, 1), mu_r)}
    return ContactLaw("hooke", "none", "none", "none", "none", tables, rolling="primer")


@pytest.mark.parametrize(("radii", "balance"), [((R, R), 0.0), ((R, 2.0 * R), 1.0)])
def test_rolling_resistance_between_unlike_spheres_is_no_couple(radii: tuple[float, float], balance: float) -> None:
    """Law (1.20): the torques are in the ratio of the radii, so they cancel between equal spheres only: else angular momentum is made."""
    omega = np.array([[30.0, 0.0, 10.0], [-20.0, 5.0, 0.0]])
    torque = pair(radii, rolling_law(0.2), omega=omega).bodies.torque
    w = omega[0] - omega[1]
    assert torque[0] == pytest.approx(-0.2 * radii[0] * 0.01 * R * KN * w / np.linalg.norm(w))
    assert torque[1] == pytest.approx(-radii[1] / radii[0] * torque[0])
    assert torque.sum(axis=0) == pytest.approx(-balance * torque[0], abs=1e-18)


def test_rolling_resistance_can_give_energy() -> None:
    """Law (1.20): its power is -mu_r |Fn| (R_i w_i - R_j w_j).(w_i - w_j)/|w_i - w_j|: above zero where both spheres spin the same way and the larger
    one more slowly. Between equal spheres it never is."""
    omega = np.array([[50.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    for radii, gives in (((R, 2.0 * R), True), ((R, R), False)):
        torque = pair(radii, rolling_law(0.2), omega=omega).bodies.torque
        assert bool(float(np.sum(torque * omega)) > 0.0) is gives


VISCOUS = {"kn": KN, "gammat": 3.0, "mu": 1e9}


def viscous(shape: tuple[int, ...], arm: str = "radius") -> ContactLaw:
    """Ft = -gammat vt: shows the velocity at the contact as a force."""
    return ContactLaw(
        "hooke", "none", "none", "absolute", "no_history", {name: np.full(shape, value) for name, value in VISCOUS.items()},
        surface_arm=arm, torque_arm=arm,
    )  # fmt: skip


@pytest.mark.parametrize("axis", range(3))
def test_a_ball_that_rolls_on_a_wall_slides_not(axis: int) -> None:
    """Law (1.12): v = R omega x n rolls without slip, vt = 0; with the other sign of the rotation term it would be 2 v. To rounding."""
    n = np.eye(3)[axis]
    omega = np.array([7.0, -11.0, 13.0])
    v = R * np.cross(omega, n)
    p = spheres((0.99 * R * n)[None], np.full(1, R), v=v[None], omega=omega[None])
    simulation = Simulation(Scene(BOX, p, 1, DT, walls=(Wall("w", Plane(tuple(n), 0.0), viscous((1,))),)))
    simulation.setup()
    across = simulation.bodies.force[0] - (simulation.bodies.force[0] @ n) * n
    assert np.abs(across).max() < 1e-15 * VISCOUS["gammat"] * np.linalg.norm(v)


@pytest.mark.parametrize("rolls", ["over a ball at rest", "as two gears", "about the common centre"])
def test_a_ball_that_rolls_on_a_ball_slides_not(rolls: str) -> None:
    """Law (1.12): the surfaces move together where v_i - v_j = (R_i w_i + R_j w_j) x n: vt = 0, to rounding."""
    radii, n, w = (R, 1.7 * R), np.array([0.6, 0.0, 0.8]), np.array([5.0, -3.0, 8.0])
    omega = {"over a ball at rest": [w, 0.0 * w], "as two gears": [w, -radii[0] / radii[1] * w], "about the common centre": [w, 0.4 * w]}[rolls]
    v = np.array([np.cross(radii[0] * omega[0] + radii[1] * omega[1], n), np.zeros(3)])
    b = pair(radii, viscous((1, 1)), v=v, omega=np.array(omega)).bodies
    across = b.force[0] - (b.force[0] @ n) * n
    assert np.abs(across).max() < 1e-14 * VISCOUS["gammat"] * R * np.linalg.norm(w)


def moments(arm: str, radii: tuple[float, float]) -> tuple[Floats, Floats, Floats]:
    """Change of angular momentum by orbit, by spin, and x_ij x f_t of a sliding pair."""
    v, omega = np.array([[0.3, 0.2, -0.1], [0.0, 0.0, 0.0]]), np.array([[9.0, 1.0, 4.0], [-2.0, 3.0, 5.0]])
    b = pair(radii, viscous((1, 1), arm), v=v, omega=omega).bodies
    return np.cross(b.x, b.force).sum(axis=0), b.torque.sum(axis=0), np.cross(b.x[0] - b.x[1], b.force[0])


@pytest.mark.parametrize("radii", [(R, R), (R, 3.0 * R)])
def test_the_torque_acts_at_the_contact_point(radii: tuple[float, float]) -> None:
    """Law (1.19): x_ji x f_t on both particles, read literally, has the arm |x_ij| twice, and makes as much angular momentum as the force carries,
    the wrong way round. With arms that end at the contact point, R - overlap/2, orbit and spin cancel to rounding; with arms R, which reach past
    each other, there is left over the part overlap/|x_ij|."""
    orbit, spin, carried = moments("contact", radii)
    assert np.abs(orbit + spin).max() < 1e-13 * np.abs(orbit).max()
    assert orbit == pytest.approx(carried)
    literal = -2.0 * carried  # x_ji x f_t on i, and x_ij x (-f_t) on j, which is the same
    assert orbit + literal == pytest.approx(-orbit)
    orbit, spin, _ = moments("radius", radii)
    overlap, distance = 0.01 * R, sum(radii) - 0.01 * R
    assert orbit + spin == pytest.approx(-overlap / distance * orbit, rel=1e-9, abs=1e-12 * float(np.abs(orbit).max()))


def crowd(dt: float) -> Scene:
    """Spheres of one size about to collide on a plane, with the primer's friction and rolling resistance and damping."""
    rng = np.random.default_rng(3)
    x = np.stack(np.meshgrid(*[np.arange(2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * 0.0105 + 0.005
    p = spheres(x, np.full(8, R), v=rng.normal(0, 0.3, (8, 3)) - 20.0 * (x - 0.01), omega=rng.normal(0, 60, (8, 3)))
    tables = {"kn": KN, "gamman": 1.0, "shear_stiffness": 2 / 7 * KN, "xt": 0.5, "mu": 0.3, "rolling_friction": 0.05}
    pair_law, wall_law = (
        ContactLaw("hooke", "velocity", "constant", "scaled", "primer", {k: np.full(shape, v) for k, v in tables.items()}, "contact", "contact",
                   rolling="primer")
        for shape in ((1, 1), (1,))
    )  # fmt: skip
    return Scene(BOX, p, 1, dt, pair=pair_law, walls=(Wall("floor", Plane((0.1, 0.2, 1.0), -0.0012), wall_law),), integrate=(NveSphere(),),
                 neighbor=Neighbor(0.001))  # fmt: skip


def test_the_budget_closes_with_the_square_of_the_step() -> None:
    """Law: with the primer's laws held plus taken stays put, of order dt^2; over collisions, friction and rolling resistance take."""
    steps, drifts = (4e-6, 2e-6, 1e-6), []
    for dt in steps:
        simulation = Simulation(crowd(dt), budget=True)
        simulation.setup()
        start, off = simulation.energy_budget(), []
        for _ in range(20):
            simulation.advance(round(2e-4 / dt))
            off.append(simulation.energy_budget().total - start.total)
        drifts.append(float(np.sqrt(np.mean(np.square(off)))))
        end = simulation.energy_budget()
        assert min(end.rubbed, end.rolled, end.damped) > 1e-3 * start.kinetic
        assert end.elastic_tangential == end.elastic_rolling == 0.0
    order = np.polyfit(np.log(steps), np.log(drifts), 1)[0]
    assert 1.5 < order < 2.6, f"order {order:.2f}, {drifts}"


def test_the_cluster_keeps_its_momenta() -> None:
    """Law: without walls, spheres of one size under the primer's laws with contact arms keep momentum and angular momentum to rounding."""
    from demsolver.computes import angular_momentum, momentum
    from demsolver.state import inertia_of

    scene = replace(crowd(1e-5), walls=())
    p, inertia = scene.particles, inertia_of(scene)
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(400)
    b = simulation.bodies
    start, end = ((momentum(q.mass, q.v), angular_momentum(q.mass, q.x, q.v, inertia, q.omega)) for q in (p, b))
    scale = float((p.mass * np.linalg.norm(p.v, axis=1)).sum())
    assert np.abs(b.omega - p.omega).max() > 1.0
    assert np.abs(end[0] - start[0]).max() < 1e-13 * scale
    assert np.abs(end[1] - start[1]).max() < 1e-12 * scale * 0.02

"""Spin in the primer: the sign of (1.12), the lever of (1.19), rolling resistance (1.20)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from demverify.report.axes import linear, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Table
from demverify.studies._primer_scenes import KN, MASS, RADIUS, G, spheres, stage, started

if TYPE_CHECKING:
    from demsolver import Particles
    from demverify.frames import Floats

N = np.array([0.6, 0.0, 0.8])  # from the second sphere of a pair to the first
RADII = (RADIUS, 1.7 * RADIUS)
OVERLAP = 0.01 * RADIUS
ETA = 3.0  # a dashpot without limit: Ft = -eta vt, so that the force shows vt


def _pair(v: Floats, omega: Floats, *, radii: tuple[float, float] = RADII, **given: float) -> tuple[Floats, Floats, Floats]:
    """Positions, forces and torques (2, 3) of a pair at set-up, far from the planes; v of the first, omega (2, 3)."""
    x = np.array([(sum(radii) - OVERLAP) * N, np.zeros(3)]) + 50.0
    b = started(stage(spheres(x, radii, v=np.array([v, np.zeros(3)]), omega=omega), 1e-5, pair=given)).bodies
    return b.x.copy(), b.force.copy(), b.torque.copy()


def levers() -> Finding:
    """(1.12) and (1.19)."""
    w = np.array([[5.0, -3.0, 8.0], [-2.0, 1.0, 4.0]])
    arms = np.array(RADII) - 0.5 * OVERLAP
    rolling = np.cross(arms[0] * w[0] + arms[1] * w[1], N)
    slip, turned = (_across(_pair(sign * rolling, w, gammat=ETA, mu=1e9)[1][0]) / ETA for sign in (1.0, -1.0))
    scale = float(np.linalg.norm(rolling))
    x, force, torque = _pair(np.array([0.3, 0.2, -0.1]), w, gammat=ETA, mu=1e9)
    orbit, spin, carried = np.cross(x, force).sum(axis=0), torque.sum(axis=0), np.cross(x[0] - x[1], force[0])
    size = float(np.linalg.norm(carried))
    distance = sum(RADII) - OVERLAP
    of_radii = -carried * sum(RADII) / distance
    kept, literal, radius = (float(np.linalg.norm(orbit + torques)) / size for torques in (spin, -2.0 * carried, of_radii))
    claims = (
        Claim("vt = v - (v.n) n - (r_i w_i + r_j w_j) x n (1.12); many texts have the sign of the last term wrong.",
              f"Spheres that roll over one another, v = (r_i w_i + r_j w_j) x n, have |vt| = {scientific(slip / scale)} |v|; rolling the other way "
              f"round, which the wrong sign would take for it, {turned / scale:.3f} |v|.", slip < 1e-11 * scale and abs(turned / scale - 2.0) < 1e-9),
        Claim("The torque on i is x_ji x ft (1.19).",
              f"With it the pair makes angular momentum, {literal:.6f} of the moment x_ij x ft that the force carries.", literal < 1e-9,
              "x_ji is the way from centre to centre. Taken so, the lever is |x_ij| on both sides, twice what there is to share. It is to mean the "
              "way to the contact point, as section 3 has it for walls."),
        Claim("With levers r - overlap/2, to the middle of the overlap, angular momentum is kept (surface_arm, torque_arm: contact).",
              f"Orbit and spin together: {scientific(kept)} of the moment.", kept < 1e-11, whose="ours"),  # 50 m off the origin
        Claim("With the levers r_i and r_j of (1.12), which reach past each other, it is not, by overlap/|x_ij| of the moment.",
              f"{radius:.6f}; overlap/|x_ij| = {OVERLAP / distance:.6f}.", abs(radius * distance / OVERLAP - 1.0) < 1e-6, whose="ours"),
    )  # fmt: skip
    return Finding(
        "(1.12), (1.19): rolling without slip, and the lever of the torque", claims,
        "Forces of a pair of unlike spheres at one moment, with a tangential dashpot alone, so that the force shows vt.", (), (),
        {"slip": slip, "wrong sign": turned / scale, "angular momentum made": {"centre to centre": literal, "contact point": kept, "radius": radius}},
    )  # fmt: skip


def _across(force: Floats) -> float:
    return float(np.linalg.norm(force - (force @ N) * N))


def slip_to_roll(quick: bool) -> Finding:
    """A ball thrown along a plane under the primer's law: sliding, then rolling with 5/7 of its speed."""
    speed, mu, dt = 1.0, 0.3, 1e-5
    time = 2.0 * speed / (7.0 * mu * G)
    simulation = started(stage(_resting(speed, 0.0), dt, gravity=G, wall={"mu": mu, "gammat": 1.0}))
    steps = 40 if quick else 200
    t, v, w = (np.empty(steps + 1) for _ in range(3))
    for k in range(steps + 1):
        t[k], v[k], w[k] = dt * simulation.step, simulation.bodies.v[0, 0], simulation.bodies.omega[0, 1] * RADIUS
        simulation.advance(round(2.0 * time / dt / steps))
    rolled = float(v[t > 1.3 * time].mean())
    slid = t < 0.9 * time
    off = float(np.abs(v[slid] - (speed - mu * G * t[slid])).max())
    claims = (
        Claim("While it slides, friction is mu |Fn| (1.17): the ball slows by mu g.", f"Its speed is u - mu g t to {scientific(off / speed)} of u.",
              off < 1e-3 * speed),
        Claim("It rolls once vt = 0 (1.12), at 5/7 of its speed, whatever the friction.", f"{rolled / speed:.5f}; 5/7 = {5.0 / 7.0:.5f}.",
              abs(rolled / speed * 1.4 - 1.0) < 1e-3, whose="ours"),
    )  # fmt: skip
    svg = chart(
        "speed", "Speed and rim speed of a ball thrown along a plane over time",
        [Series("v", t / time, v, 0), Series("R omega", t / time, w, 1)], (linear(0.0, 2.0), linear(0.0, 1.05 * speed)),
        ("time in 2 u/(7 mu g)", "in m/s"), [Rule("5/7 u", np.array([0.0, 2.0]), np.full(2, speed * 5.0 / 7.0))],
    )  # fmt: skip
    return Finding(
        "1.1 and 1.2 together: from sliding to rolling", claims, f"A ball at {speed:g} m/s on a plane, mu = {mu:g}, velocity Verlet.",
        (Figure("slip_to_roll", "Speed and rim speed; both are 5/7 of the first speed from t = 2 u/(7 mu g) on.", svg),), (),
        {"time": t, "speed": v, "rim speed": w},
    )  # fmt: skip


def _resting(speed: float, spin: float) -> Particles:
    """A ball on the floor, its weight borne, moving along x and spinning about y; and one far off, so that the scene is compiled as one of pairs."""
    first = np.array([[1.0], [0.0]])
    return spheres([[0.0, 0.0, RADIUS - MASS * G / KN], [0.0, 0.0, 50.0]], v=first * [speed, 0.0, 0.0], omega=first * [0.0, spin, 0.0])


def rolling(quick: bool) -> Finding:
    """(1.20)."""
    coefficients = (0.02, 0.05) if quick else (0.01, 0.02, 0.05, 0.1)
    slowed = [(c, _deceleration(c), 5.0 / 7.0 * c * G) for c in coefficients]
    off = max(abs(measured / expected - 1.0) for _, measured, expected in slowed)
    w = np.array([[30.0, 0.0, 10.0], [-20.0, 5.0, 0.0]])
    _, force, torque = _pair(np.zeros(3), w, rolling_friction=0.2)
    relative = w[0] - w[1]
    expected = -0.2 * RADII[0] * float(np.linalg.norm(force[0])) * relative / np.linalg.norm(relative)
    law = float(np.abs(torque[0] - expected).max() / np.abs(expected).max())
    left = float(np.linalg.norm(torque.sum(axis=0)) / np.linalg.norm(torque[0]))
    ratio = RADII[1] / RADII[0]
    same = np.array([[50.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    power = {radii: float((_pair(np.zeros(3), same, radii=radii, rolling_friction=0.2)[2] * same).sum()) for radii in (RADII, (RADIUS, RADIUS))}
    claims = (
        Claim("M_ij = -mu_r r_i |fn| (w_i - w_j)/|w_i - w_j| (1.20).", f"The torque on i is, to {scientific(law)}.", law < 1e-12),
        Claim("A rolling ball is slowed by 5/7 mu_r g.", f"Measured decelerations agree to {scientific(off)}.", off < 1e-3, whose="ours"),
        Claim("The factor r_i differs for the two: only between equal spheres do the torques cancel, else angular momentum is not conserved.",
              f"Radii 1 and {ratio:g}: {left:.3f} of the torque on i is left over, r_j/r_i - 1.", abs(left - ratio + 1.0) < 1e-12, whose="ours"),
        Claim("Its power is -mu_r |fn| (r_i w_i - r_j w_j).(w_i - w_j)/|w_i - w_j|: it gives energy where both spin the same way and the larger "
              "sphere more slowly; between equal spheres and at walls it only takes.",
              f"Spins of 50 and 40 1/s: {scientific(power[RADII])} W with radii 1 and {ratio:g}, {scientific(power[RADIUS, RADIUS])} W with equal "
              "ones.", power[RADIUS, RADIUS] < 0.0 < power[RADII], whose="ours"),
    )  # fmt: skip
    table = Table("Deceleration of a rolling ball, m/s²", ("mu_r", "measured", "5/7 mu_r g"), tuple((f"{c:g}", m, e) for c, m, e in slowed))
    return Finding("(1.20): rolling resistance", claims, "A ball that rolls on a plane; pairs at one moment.", (), (table,),
                   {"mu_r": coefficients, "deceleration": [m for _, m, _ in slowed], "left over": left})  # fmt: skip


def _deceleration(coefficient: float) -> float:
    """Of a ball that rolls with 0.5 m/s, over 0.2 s."""
    simulation = started(stage(_resting(0.5, 0.5 / RADIUS), 1e-5, gravity=G, wall={"mu": 0.5, "gammat": 1.0, "rolling_friction": coefficient}))
    simulation.advance(1000)
    t, v = 1e-3 * np.arange(200), np.empty(200)
    for k in range(200):
        v[k] = simulation.bodies.v[0, 0]
        simulation.advance(100)
    return -float(np.polyfit(t, v, 1)[0])

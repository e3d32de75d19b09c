"""What every law of the folder must hold to, whoever writes it: tests/support/laws.py lists them off the folder."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from demsolver import Box, ContactLaw, Scene, contact
from demsolver.reference import Action, History, Touch, action, forces, stored, touches
from tests.support.laws import EVERY, STEP_LAWS, around, contact_law, every_law
from tests.support.scenes import spheres
from tests.support.turns import rotation

Floats = NDArray[np.float64]
STATIC = [name for name in contact.listing("normal") if name not in STEP_LAWS]
STENCIL = ((1, 4.0 / 5.0), (2, -1.0 / 5.0), (3, 4.0 / 105.0), (4, -1.0 / 280.0))  # central difference of order 8

HERTZ = {"normal": "hertz", "tangential_stiffness": "mindlin"}
RESET = "on slip it stores -(F + g v)/k: a dashpot stronger than the limit stretches the spring with what nobody paid"
STIFFENS = "its stiffness grows with the contact, so a stretched spring gains energy as the contact closes"
# Laws that can give energy from nothing: files, coefficients, why. All others never do, nor do these without what stands here.
ACTIVE: dict[str, tuple[dict[str, str], dict[str, float], str]] = {
    "tangential_stiffness mindlin": (HERTZ, {}, STIFFENS),
    "tangential_stiffness ratio": ({**HERTZ, "tangential_stiffness": "ratio"}, {}, STIFFENS),
    "friction classic_history": ({"friction": "classic_history", "tangential_damping": "absolute"}, {}, RESET),
    "friction rotated_history": ({"friction": "rotated_history", "tangential_damping": "absolute"}, {}, RESET),
    "friction mindlin_rescale": ({**HERTZ, "friction": "mindlin_rescale"}, {}, STIFFENS),
    "friction mindlin_force": ({**HERTZ, "friction": "mindlin_force"}, {}, "F^2/(2 kt) of the stored force grows while the contact opens"),
    "friction mindlin_rescale_force": ({**HERTZ, "friction": "mindlin_rescale_force", "tangential_damping": "absolute"}, {}, RESET),
    "rolling epsd": ({**HERTZ, "friction": "none", "rolling": "epsd"}, {"rolling_damping_ratio": 0.0, "rolling_friction": 1.0}, STIFFENS),
    "rolling epsd2": ({**HERTZ, "friction": "none", "rolling": "epsd2"}, {"rolling_friction": 1.0}, STIFFENS),
    "rolling sds": ({"rolling": "sds"}, {"rolling_damping": 1.0}, RESET),
    "twisting sds": ({"twisting": "sds"}, {"twisting_damping": 1e-4}, RESET),
    "twisting marshall": ({"twisting": "marshall", "tangential_damping": "absolute"}, {}, RESET),
}


def cluster(law: ContactLaw, *, n: int = 6, seed: int = 1) -> Scene:
    """Equal spheres thrown together, all touching some others, moving and spinning."""
    rng = np.random.default_rng(seed)
    x = np.array([(i, j, k) for i in range(2) for j in range(2) for k in range(2)], float)[:n] * 0.00993 + rng.uniform(-2e-5, 2e-5, (n, 3))
    p = spheres(x, np.full(n, 0.005), v=rng.normal(0.0, 0.3, (n, 3)), omega=rng.normal(0.0, 30.0, (n, 3)))
    return Scene(Box(np.full(3, -1.0), np.full(3, 1.0), ("ff",) * 3), p, 1, 1e-5, pair=law)


def two_steps(scene: Scene, turn: Floats, drift: Floats) -> tuple[Floats, Floats]:
    """Force and torque (n, 3) at the second step of a scene turned by `turn` and moving with `drift`, turned back."""
    p = scene.particles
    x, v, omega = p.x @ turn.T, p.v @ turn.T + drift, p.omega @ turn.T
    history: History = {}
    force = torque = np.zeros_like(x)
    for _ in range(2):
        force, torque, history = forces(scene, x, v, omega, history, True)
        x = x + scene.timestep * v
    return force @ turn, torque @ turn


@pytest.mark.parametrize(("family", "name"), EVERY)
def test_action_equals_reaction(family: contact.Family, name: str) -> None:
    """Law: the forces of a cluster of equal spheres add up to nothing, and so do their moments with the torques."""
    scene = cluster(every_law(family, name))
    history: History = {}
    for _ in range(2):
        force, torque, history = forces(scene, scene.particles.x, scene.particles.v, scene.particles.omega, history, True)
    scale = np.abs(force).max()
    assert scale > 0.0
    assert np.abs(force.sum(axis=0)).max() < 1e-13 * scale
    assert np.abs((np.cross(scene.particles.x, force) + torque).sum(axis=0)).max() < 1e-13 * 0.01 * scale


@pytest.mark.parametrize(("family", "name"), EVERY)
def test_no_frame_is_special(family: contact.Family, name: str) -> None:
    """Law: a turned cluster that drifts feels the turned forces and torques, memory included."""
    scene = cluster(every_law(family, name), seed=2)
    still = two_steps(scene, np.eye(3), np.zeros(3))
    turned = two_steps(scene, rotation(np.array([1.0, 2.0, -0.5]), 1.1), np.array([3.0, -2.0, 1.0]))
    # velocities of 3 m/s lose 1e-15 m/s of differences of 0.3 m/s; positions 1e-17 m of overlaps of 1e-5 m
    scale = np.abs(still[0]).max()
    for one, other, arm in zip(still, turned, (1.0, 0.005), strict=True):
        assert np.abs(one - other).max() < 1e-9 * scale * arm


@pytest.mark.parametrize(("family", "name"), EVERY)
def test_nothing_acts_apart(family: contact.Family, name: str) -> None:
    """Law: spheres that do not overlap and did not touch feel nothing, and a contact that has ended leaves no memory."""
    scene = cluster(every_law(family, name))
    _, _, history = forces(scene, scene.particles.x, scene.particles.v, scene.particles.omega, {}, True)
    wide = 1.2 * scene.particles.x
    force, torque, left = forces(scene, wide, scene.particles.v, scene.particles.omega, history, True)
    assert history
    assert not force.any()
    assert not torque.any()
    assert not left


@pytest.mark.parametrize("name", STATIC)
@pytest.mark.parametrize("overlap", [1e-6, 2e-5, 3e-4])
def test_normal_force_is_the_slope_of_energy(name: str, overlap: float) -> None:
    """Law: F = dE/d(overlap), also where it pulls, by a difference of order 8."""
    law = every_law("normal", name)
    h = 0.02 * overlap
    slope = sum(w * (energy_at(law, overlap + k * h) - energy_at(law, overlap - k * h)) for k, w in STENCIL) / h
    scale = abs(slope) + energy_at(law, 3e-4) / 3e-4  # where an adhesive force passes zero, its parts do not
    assert slope == pytest.approx(act(law, overlap).normal, rel=1e-8, abs=1e-8 * scale)


@pytest.mark.parametrize("overlap", [1e-6, 2e-5, 3e-4])
@pytest.mark.parametrize("name", contact.listing("cohesion"))
def test_cohesion_is_the_slope_of_energy(name: str, overlap: float) -> None:
    """Law: a cohesive force has an energy too."""
    with_it, without = (contact_law(friction="none", **names) for names in ({"cohesion": name}, {}))
    h = 0.02 * overlap
    ends = {k: energy_at(with_it, overlap + k * h) - energy_at(without, overlap + k * h) for k in range(-4, 5)}
    slope = sum(w * (ends[k] - ends[-k]) for k, w in STENCIL) / h
    force = act(with_it, overlap).normal - act(without, overlap).normal
    assert force < 0.0
    assert slope == pytest.approx(force, rel=1e-7)  # the difference of energies, of which hooke's part is up to 100 times larger


def touch(law: ContactLaw, overlap: float, *, n: Floats | None = None, **moving: Floats) -> Touch:
    """A pair of unequal spheres at an overlap; v, spin, w as of Touch."""
    ri, rj, mi, mj = 0.005, 0.007, 1.3e-3, 3.6e-3
    zero = np.zeros(3)
    motion = {"v": zero, "spin": zero, "w": zero} | moving
    direction = np.array([0.6, 0.0, 0.8]) if n is None else n
    reff, meff = ri * rj / (ri + rj), mi * mj / (mi + mj)
    inertia = 1.4 / (1.0 / (mi * ri**2) + 1.0 / (mj * rj**2))
    return Touch(("pair", 0, 1), law, (0, 0), 0, 1, direction, overlap, reff, meff, **motion, radius=ri, partner_radius=rj, rolling_inertia=inertia)


def act(law: ContactLaw, overlap: float) -> Action:
    """What a contact at rest does."""
    return action(touch(law, overlap), None, 1e-5, True)


def energy_at(law: ContactLaw, overlap: float) -> float:
    """Stored energy of a contact at rest, memory empty."""
    one = touch(law, overlap)
    return stored(one, action(one, None, 1e-5, False).memory, 1e-5)[0]


def ride(law: ContactLaw, steps: int = 600) -> tuple[Floats, Floats]:
    """Dissipated so far, and stored, (steps,) each, while one sphere is led about another: towards it, harder and softer against it, rolling,
    twisting and sliding to and fro in all directions, and off again."""
    scene = couple(law)
    dt, t = scene.timestep, np.arange(steps + 1) / steps
    x, omega = path(t)
    history: History = {}
    force, torque, work, held = np.zeros((2, 3)), np.zeros((2, 3)), [0.0], [0.0]
    for k in range(1, steps + 1):
        v = (x[k] - x[k - 1]) / dt
        last_force, last_torque = force, torque
        force, torque, history = forces(scene, x[k], v, omega[k], history, True)
        power = np.sum((force + last_force) * v) + np.sum((torque + last_torque) * omega[k])
        work.append(work[-1] - 0.5 * dt * float(power))
        held.append(sum(sum(stored(one, history[one.key], dt)) for one in touches(scene, x[k], v, omega[k], history)))
    return np.array(work) - np.array(held), np.array(held)


def couple(law: ContactLaw) -> Scene:
    """Two spheres of unequal size."""
    p = spheres(np.zeros((2, 3)), np.array([0.005, 0.007]))
    return Scene(Box(np.full(3, -1.0), np.full(3, 1.0), ("ff",) * 3), p, 1, 1e-6, pair=law)


def path(t: Floats) -> tuple[Floats, Floats]:
    """Positions (s, 2, 3) and angular velocities (s, 2, 3) of the couple at times t (s,) from 0 to 1."""
    overlap = 5e-5 * (np.minimum(1.0, 8.0 * np.minimum(t - 0.02, 0.98 - t)) + 0.5 * np.sin(6.0 * pi * t) * np.sin(pi * t) ** 2)
    angle = 0.01 * np.sin(4.0 * pi * t)
    n = np.stack([np.cos(angle), np.sin(angle), 0.5 * np.sin(angle)], axis=1)
    n /= np.linalg.norm(n, axis=1)[:, None]
    x = np.zeros((len(t), 2, 3))
    x[:, 0] = (0.012 - overlap)[:, None] * n
    amplitude = np.array([[20.0, 50.0, 30.0], [-30.0, 15.0, -40.0]])
    phase = np.array([[0.3, 0.0, 1.0], [0.5, 0.9, 0.0]])
    return x, amplitude * np.sin(2.0 * pi * (np.array([[2, 3, 2], [3, 2, 4]]) * t[:, None, None] + phase))


def deepest_fall(law: ContactLaw) -> float:
    """How much of its dissipated energy a law gives back at most on the ride, over the most it stores."""
    dissipated, held = ride(law)
    return float((np.maximum.accumulate(dissipated) - dissipated).max() / held.max())


@pytest.mark.parametrize(("family", "name"), [one for one in EVERY if one not in [("normal", n) for n in STEP_LAWS]])
def test_dissipation_is_never_negative(family: contact.Family, name: str) -> None:
    """Law: on a ride to and fro in all directions a contact never gives more than it took (but for those ways of ACTIVE)."""
    names = around(family, name)
    if names.get("tangential_stiffness") == "mindlin" and f"{family} {name}" in ACTIVE:
        return  # shown below
    # 600 steps of the trapezoid rule; where a law jumps (dmt at touch, springs at the limit) it errs by some 1/600 of the jump
    assert deepest_fall(contact_law(**names)) < 2e-3


@pytest.mark.parametrize("label", ACTIVE)
def test_laws_that_give_energy(label: str) -> None:
    """Law: what ACTIVE says is so: on the ride the law gives back more than half a percent of the most it stores."""
    names, values, _ = ACTIVE[label]
    assert deepest_fall(contact_law(**names, values=values)) > 5e-3


@pytest.mark.parametrize("name", STEP_LAWS)
@settings(max_examples=200, deadline=None)
@given(a=st.floats(1e-3, 100.0), s=st.floats(-3.0, 30.0), e=st.floats(0.05, 1.0))
def test_step_laws_take_and_never_give(name: str, a: float, s: float, e: float) -> None:
    """Law: a step law never pulls; what a step ends with (kinetic and stored) is at most what it began with, less what it says it took."""
    law = contact.law("normal", name)
    overlap, dt, meff = 1e-5, 1e-4, 1e-3
    kn, vn = a * meff / dt**2, -s * overlap / dt
    force, shift, loss = law.step(overlap, vn, meff, dt, kn, e)
    vn_after = vn + force * dt / meff
    after = overlap - shift - vn_after * dt
    assert force >= 0.0
    assert loss >= 0.0
    began = 0.5 * meff * vn**2 + law.energy(overlap, vn, meff, dt, kn, e) + loss
    ended = 0.5 * meff * vn_after**2 + (0.5 * kn * after**2 if after > 0.0 else 0.0) + loss
    assert ended <= began * (1.0 + 1e-12) + 1e-12 * meff * vn**2

"""A sphere hits a plane obliquely, at any angle: Hertz contact with the simplified Mindlin law of the engines, integrated as an ODE.

    m u' = -Fn,  Fn = K d^(3/2) + c d^(1/4) u,  K = 4/3 E* sqrt(R),  c = 2 sqrt(5/6) b sqrt(2 E* sqrt(R) m),  b = -ln e/sqrt(pi^2 + ln^2 e)
    m w' = -7/2 Ft,  Ft = 8 G* sqrt(R d) s, s' = w,  s cut so that |Ft| <= mu |Fn|          (u = d', w: slip of the contact point)

1/E* = sum (1 - nu^2)/E, 1/G* = sum 2 (2 - nu)(1 + nu)/E. The spring holds the whole displacement and has no dashpot (A. Di Renzo, F. P. Di
Maio, Chem. Eng. Sci. 59 (2004) 525, doi:10.1016/j.ces.2003.09.037; cases: Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, tests 4 and 5).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import copysign, sqrt
from typing import Literal

from demverify.frames import Frame
from demverify.impact import damping_ratio
from demverify.laws import Measured

STEPS = 20_000  # of a contact; the outcome then stands to some 1e-6


def measure(
    frames: Sequence[Frame],
    young: float,
    poisson: float,
    wall_young: float,
    wall_poisson: float,
    restitution: float,
    friction: float,
    pulling: Literal["yes", "no"],
) -> list[Measured]:
    """Rebound of the first particle from a plane z = const, moving along x, spinning about y.

    wall_young: 1e30 for a rigid wall. restitution: that of the dashpot while it may pull; pulling "no": the contact ends with its force."""
    first = frames[0]
    eeff = 1.0 / ((1.0 - poisson**2) / young + (1.0 - wall_poisson**2) / wall_young)
    geff = 1.0 / (2.0 * (2.0 - poisson) * (1.0 + poisson) / young + 2.0 * (2.0 - wall_poisson) * (1.0 + wall_poisson) / wall_young)
    radius, mass, vn, slip = state(first)
    bounce, impulse = hertz_mindlin(eeff * sqrt(radius) / mass, geff * sqrt(radius) / mass, restitution, friction, vn, slip, pulling == "yes")
    return rebound(frames, bounce, impulse)


def state(first: Frame) -> tuple[float, float, float, float]:
    """Radius and mass of the first particle, its speed towards the plane and the slip of its lowest point, v_x - R omega_y."""
    radius, mass = float(first.columns["radius"][0]), float(first.columns["mass"][0])
    return radius, mass, -float(first.columns["vz"][0]), float(first.columns["vx"][0] - radius * first.columns["omegay"][0])


def rebound(frames: Sequence[Frame], bounce: float, impulse: float) -> list[Measured]:
    """What is left of velocity and spin. bounce: normal speed after; impulse: tangential, over the mass, against x.

    Differences are relative to the greater of speed before and change, so that a velocity near zero does not blow them up."""
    first, last = frames[0], frames[-1]
    radius, vn, slip = float(first.columns["radius"][0]), -float(first.columns["vz"][0]), state(first)[3]
    spin, vx = float(first.columns["omegay"][0]) + 2.5 * impulse / radius, float(first.columns["vx"][0]) - impulse
    return [
        Measured("normal velocity", last.step, float(last.columns["vz"][0]), bounce, vn),
        Measured("tangential velocity", last.step, float(last.columns["vx"][0]), vx, max(abs(vx), abs(impulse))),
        Measured("spin", last.step, float(last.columns["omegay"][0]), spin, max(abs(spin), 2.5 * abs(impulse) / radius)),
        Measured("slip", last.step, state(last)[3], slip - 3.5 * impulse, max(abs(slip), 3.5 * abs(impulse))),
    ]


@lru_cache(maxsize=64)
def hertz_mindlin(eeff: float, geff: float, restitution: float, friction: float, vn: float, slip: float, pulling: bool) -> tuple[float, float]:
    """(normal speed after, tangential impulse over mass). eeff, geff: E* and G* times sqrt(R)/m."""
    loss = damping_ratio(restitution)
    spring, dashpot = 4.0 / 3.0 * eeff, 2.0 * sqrt(5.0 / 6.0) * loss * sqrt(2.0 * eeff)
    contact_time = 2.943275184 * (1.25 * vn**2 / spring) ** 0.4 / vn

    def normal(d: float, u: float) -> float:
        return float(spring * d**1.5 + dashpot * d**0.25 * u)

    return impact(normal, lambda d: 8.0 * geff * sqrt(d), friction, vn, slip, contact_time / STEPS, pulling)


def impact(
    normal: Callable[[float, float], float], shear: Callable[[float], float], friction: float, vn: float, slip: float, dt: float, pulling: bool
) -> tuple[float, float]:
    """Integrates an impact, all forces over the mass; leapfrog, whose force is taken half a step on, so that the dashpot is of second order.
    Returns the normal speed after and the tangential impulse."""
    overlap, u, w, impulse = 0.0, vn, slip, 0.0
    wound = -0.5 * dt * w  # it is half a step to the first middle
    while True:
        middle = overlap + 0.5 * dt * u
        if middle <= 0.0:
            return -u, impulse
        guess = u - 0.5 * dt * normal(middle, u)
        force = normal(middle, guess)
        if force < 0.0 and not pulling:
            force = 0.0
        k = shear(middle)
        wound += dt * w
        drag = k * wound
        if abs(drag) > friction * abs(force):
            drag = copysign(friction * abs(force), drag)
            wound = drag / k
        u -= dt * force
        w -= dt * 3.5 * drag
        impulse += dt * drag
        overlap = middle + 0.5 * dt * u

"""A sphere falls on the plane z = 0, a linear spring and dashpot, and rises again: three stages, each exact (MFIX-DEM V&V, DEM-01).

    fall     z = z0 - g t^2/2, until z = R with the speed v
    contact  z = R - g/w^2 + exp(-b w s) [g/w^2 cos(p s) + (b g/w - v)/p sin(p s)],  p = w sqrt(1 - b^2), until z = R again
    flight   ballistic
    w = sqrt(k/m),  b = -ln e / sqrt(pi^2 + ln^2 e)

R: radius; the contact pulls at its end, so it lasts until z = R.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, exp, pi, sin, sqrt

import numpy as np

from demverify.frames import Frame
from demverify.impact import damping_ratio
from demverify.laws import Measured


def measure(frames: Sequence[Frame], stiffness: float, restitution: float, gravity: float, timestep: float) -> list[Measured]:
    """Height and speed of the first particle, each where it is farthest from the law; relative to the height of fall and the speed of impact."""
    first = frames[0]
    height, radius, mass = (float(first.columns[name][0]) for name in ("z", "radius", "mass"))
    fall = sqrt(2.0 * (height - radius) / gravity)
    speed = gravity * fall
    contact = _Contact(sqrt(stiffness / mass), damping_ratio(restitution), gravity, speed)

    def law(time: float) -> tuple[float, float]:
        if time < fall:
            return height - 0.5 * gravity * time**2, -gravity * time
        if time < fall + contact.duration:
            z, v = contact.at(time - fall)
            return radius + z, v
        flown = time - fall - contact.duration
        leaving = contact.at(contact.duration)[1]
        return radius + leaving * flown - 0.5 * gravity * flown**2, leaving - gravity * flown

    expected = np.array([law((frame.step - first.step) * timestep) for frame in frames])
    measured = np.array([(frame.columns["z"][0], frame.columns["vz"][0]) for frame in frames])
    worst = np.abs(measured - expected).argmax(axis=0)
    return [
        Measured(name, frames[at].step, float(measured[at, k]), float(expected[at, k]), scale)
        for k, (name, at, scale) in enumerate(zip(("height", "velocity"), worst, (height - radius, speed), strict=True))
    ]


class _Contact:
    """The damped oscillator between touch and parting, z = 0 at both."""

    def __init__(self, frequency: float, ratio: float, gravity: float, speed: float) -> None:
        """frequency: undamped. ratio: of the damping to the critical one."""
        from scipy.optimize import brentq

        self.frequency, self.ratio, self.gravity, self.speed = frequency, ratio, gravity, speed
        self.damped = frequency * sqrt(1.0 - ratio**2)
        self.duration = float(brentq(lambda s: self.at(s)[0], 0.5 * pi / self.damped, 1.5 * pi / self.damped, xtol=1e-15))

    def at(self, s: float) -> tuple[float, float]:
        """Height above R and velocity at the time s after touch."""
        w, b, p, g, v = self.frequency, self.ratio, self.damped, self.gravity, self.speed
        decay = exp(-b * w * s)
        z = decay * (g / w**2 * cos(p * s) + (b * g / w - v) / p * sin(p * s)) - g / w**2
        return z, decay * (-v * cos(p * s) + (b * w * v - g) / p * sin(p * s))

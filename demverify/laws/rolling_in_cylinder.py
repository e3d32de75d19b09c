"""A rigid sphere inside a cylinder whose axis lies level and that turns with W: it slides with Coulomb's friction until the slip is gone, then rolls.

With L = Rc - R, f the angle of the sphere from the lowest line towards the way of W, w its spin, N the normal force and F the friction per mass:

    N = g cos f + L f'^2      slip s = L f' + R w - W Rc      L f'' = -g sin f + F      (2/5) R w' = F
    F = -mu N s/|s|  while it slides;   F = (2/7) g sin f  while it rolls, as long as |F| <= mu N

Rolling is the pendulum L f'' = -(5/7) g sin f, whatever W: small swings take 2 pi sqrt(7 L/(5 g)), without friction 2 pi sqrt(L/g).
Equations of Newton and Euler (Routh, Dynamics of a System of Rigid Bodies, 1905, on spheres in cylinders) with Coulomb's law, integrated to 1e-11."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from demverify.errors import InputError
from demverify.frames import Floats, Frame
from demverify.laws import Measured, largest_miss
from demverify.mechanics import positions, spins, times, velocities

MOST_TURNS = 200  # from sliding to rolling and back


@dataclass(frozen=True)
class Drum:
    """cylinder, sphere: radii. rate: of the cylinder."""

    cylinder: float
    sphere: float
    rate: float
    friction: float
    gravity: float

    @property
    def length(self) -> float:
        """Of the pendulum."""
        return self.cylinder - self.sphere

    def slip(self, y: Floats) -> float:
        """Velocity of the sphere's surface less the cylinder's; y: angle, its rate, spin."""
        return float(self.length * y[1] + self.sphere * y[2] - self.cylinder * self.rate)

    def load(self, y: Floats) -> float:
        """Normal force over mass."""
        return float(self.gravity * np.cos(y[0]) + self.length * y[1] ** 2)

    def held(self, y: Floats) -> float:
        """Friction over mass that keeps the sphere rolling."""
        return float(2.0 / 7.0 * self.gravity * np.sin(y[0]))

    def spare(self, y: Floats) -> float:
        """What friction could hold beyond that."""
        return self.friction * self.load(y) - abs(self.held(y))

    def motion(self, y: Floats, friction: float) -> Floats:
        """Time derivative of y under this friction over mass."""
        return np.array([y[1], (friction - self.gravity * np.sin(y[0])) / self.length, 2.5 * friction / self.sphere])


def motion(drum: Drum, start: Floats, t: Floats) -> Floats:
    """Angle, its rate and spin (k, 3) at the times (k,), from the state (3,) at t[0]. Raises InputError where the sphere leaves the wall."""
    found, y, now = np.empty((len(t), 3)), np.array(start, dtype=float), float(t[0])
    slides = _direction(drum, y, drum.slip(y))
    for _ in range(MOST_TURNS):
        run = _stretch(drum, y, slides, now, float(t[-1]))
        here = (t >= now) & (t <= run.t[-1])
        found[here] = run.sol(t[here]).T
        if run.status == 0:
            return found
        now, y = float(run.t[-1]), run.y[:, -1]
        if len(run.t_events[0]):
            message = f"law rolling_in_cylinder: the sphere leaves the wall at time {now:g}"
            raise InputError(message)
        slides = _direction(drum, y, 0.0) if slides else -float(np.sign(drum.held(y)))
    message = "law rolling_in_cylinder: the sphere changes between sliding and rolling without end"
    raise InputError(message)


def _direction(drum: Drum, y: Floats, slip: float) -> float:
    """Sign of the slip from here on; 0: it rolls."""
    if slip != 0.0 or drum.friction == 0.0:
        return float(np.sign(slip)) or 1.0
    return 0.0 if drum.spare(y) > 0.0 else -float(np.sign(drum.held(y)))


def _stretch(drum: Drum, y: Floats, slides: float, now: float, end: float) -> Any:
    """Sliding to the end of the slip, or rolling to the end of what friction can hold."""
    from scipy.integrate import solve_ivp

    def rate(_: float, y: Floats) -> Floats:
        return drum.motion(y, -slides * drum.friction * drum.load(y) if slides else drum.held(y))

    def off(_: float, y: Floats) -> float:
        return drum.load(y)

    def changes(_: float, y: Floats) -> float:
        return slides * drum.slip(y) if slides else drum.spare(y)

    off.terminal, changes.terminal, changes.direction = True, drum.friction > 0.0, -1.0  # type: ignore[attr-defined]
    return solve_ivp(rate, (now, end), y, method="DOP853", rtol=1e-11, atol=1e-13, events=(off, changes), dense_output=True)


def measure(
    frames: Sequence[Frame], dt: float, cylinder: float, rate: float, friction: float, gravity: float, cx: float, cy: float
) -> list[Measured]:
    """Angle, speed and spin of the first particle: the largest misses, relative to the largest angle, speed and surface speed over radius. The axis
    goes through (cx, cy) along z, gravity along -y; rate: of the cylinder about +z."""
    t = times(frames, dt)
    x = np.array([positions(frame)[0, :2] for frame in frames]) - [cx, cy]
    v = np.array([velocities(frame)[0, :2] for frame in frames])
    angle = np.unwrap(np.arctan2(x[:, 0], -x[:, 1]))
    speed = v[:, 0] * np.cos(angle) + v[:, 1] * np.sin(angle)
    spin = np.array([spins(frame)[0, 2] for frame in frames])
    radius = float(frames[0].columns["radius"][0])
    drum = Drum(cylinder, radius, rate, friction, gravity)
    expected = motion(drum, np.array([angle[0], speed[0] / drum.length, spin[0]]), t)
    fastest = float(np.abs(expected[:, 1]).max()) * drum.length
    return [
        largest_miss("angle", frames, np.abs(angle - expected[:, 0]), float(np.abs(expected[:, 0]).max())),
        largest_miss("speed", frames, np.abs(speed - drum.length * expected[:, 1]), fastest),
        largest_miss("spin", frames, np.abs(spin - expected[:, 2]), max(float(np.abs(expected[:, 2]).max()), fastest / radius)),
    ]

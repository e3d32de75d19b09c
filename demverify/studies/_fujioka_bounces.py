"""One sphere that bounces: every contact as the row of its states and the energies before and after, through `Simulation`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt

import numpy as np

from demsolver import Simulation
from demverify.frames import Floats
from demverify.studies._fujioka_models import DIAMETER, FAR, GRAVITY, Model, Spheres, law, over_floor, simulation, sphere_mass, stiffness

AT_REST = 5000  # steps in contact after which a sphere is held to lie still: ten times the longest contact of T, at a speed of g dt for dt = 1e-5 s
THICKNESS = 10.0  # radius of the frozen sphere that stands for a half-space, over that of the other


@dataclass(frozen=True)
class Contact:
    """One contact. states: (k, 2) overlap d and approach u per step, over the diameter, of each step in contact. ratio: energy after over before."""

    states: Floats
    ratio: float

    @property
    def steps(self) -> int:
        """How many steps it took."""
        return len(self.states)


@dataclass
class Faller:
    """The first particle of a simulation, falling along z; it touches where its centre is lower than `touching`."""

    running: Simulation
    touching: float
    gravity: float = GRAVITY

    @property
    def overlap(self) -> float:
        """What z is below touching."""
        return self.touching - float(self.running.bodies.x[0, 2])

    @property
    def speed(self) -> float:
        """Upwards."""
        return float(self.running.bodies.v[0, 2])

    @property
    def energy(self) -> float:
        """v^2/2 + g height - g dt v/2, over the mass: what semi-implicit Euler keeps exactly in free fall."""
        return 0.5 * self.speed**2 - self.gravity * (self.overlap + 0.5 * self.running.scene.timestep * self.speed)

    def fall(self, most: int) -> int:
        """Flies up to the next contact, `most` steps at most; the steps it took. n steps of free fall rise n dt v - g dt^2 n (n + 1)/2."""
        drop, rise = 0.5 * self.gravity * self.running.scene.timestep**2, self.running.scene.timestep * self.speed
        height, taken = -self.overlap, 0
        if height > 0.0:
            half = 0.5 * (rise - drop)
            taken = max(0, min(most, int((half + sqrt(half * half + drop * height)) / drop) - 2))
            self.running.advance(taken)
        while self.overlap <= 0.0 and taken < most:
            self.running.advance(1)
            taken += 1
        return taken


def contacts(faller: Faller, most: int) -> Iterator[Contact]:
    """Contact after contact, until the sphere lies still, or `most` steps are over. Their energies leave out none: one is after the last."""
    dt, left = faller.running.scene.timestep, most
    while left > 0:
        before = faller.energy
        left -= faller.fall(left)
        states: list[tuple[float, float]] = []
        while faller.overlap > 0.0 and left > 0 and len(states) < AT_REST:
            states.append((faller.overlap, -dt * faller.speed))
            faller.running.advance(1)
            left -= 1
        if left == 0 or len(states) == AT_REST:
            return
        yield Contact(np.array(states) / DIAMETER, faller.energy / before)


def steps_in_contact(faller: Faller, total: int) -> int:
    """In how many of the first `total` steps the sphere touches. Raises ArithmeticError if it does not stay where it came to rest."""
    touched = flown = 0
    while flown + touched < total:
        flown += faller.fall(total - flown - touched)
        long = 0
        while faller.overlap > 0.0 and flown + touched < total:
            faller.running.advance(1)
            touched, long = touched + 1, long + 1
            if long == AT_REST:
                return touched + _resting(faller, total - flown - touched)
    return touched


def _resting(faller: Faller, left: int) -> int:
    """All the steps that are left, if the sphere is still where it came to rest in the end."""
    faller.running.advance(left)
    if faller.overlap <= 0.0:
        message = "a sphere that lay still left the floor again"
        raise ArithmeticError(message)
    return left


def dropped(model: Model, height: float, dt: float) -> Faller:
    """A sphere over the native plane wall, its lowest point at `height`, at rest. (A second one, alike, keeps to itself.)"""
    return Faller(over_floor(model, np.full(2, height), 0.0, dt), DIAMETER / 2)


def shot(model: Model, height: float, speed: float, dt: float, gravity: float = GRAVITY) -> Faller:
    """A sphere shot down at a half-space: a frozen sphere, THICKNESS times as large, is felt until the centres meet, and not from the far side."""
    radius = DIAMETER / 2
    large = THICKNESS * radius
    x = np.array([[0.0, 0.0, radius + height], [0.0, 0.0, -large]])
    v = np.array([[0.0, 0.0, -speed], [0.0, 0.0, 0.0]])
    mass = sphere_mass(radius)
    spheres = Spheres(x, v, np.array([radius, large]), np.array([mass, 1e3 * mass]), (False, True))
    kn = stiffness(model, mass, radius * large / (radius + large), DIAMETER, dt)
    pair, floor = law(model, np.full((1, 1), kn)), law(model, np.full(1, kn))
    return Faller(simulation(spheres, pair, floor, dt, level=-0.5 * FAR, skin=FAR / 1e6, gravity=gravity), radius, gravity)


def crosses_the_plane(model: Model, height: float, speed: float, dt: float) -> bool:
    """Whether a sphere shot at the native plane wall, which is felt from both sides, comes out behind it."""
    running = over_floor(model, np.full(2, height), speed, dt)
    running.advance(100)
    return bool(running.bodies.x[0, 2] < 0.0)

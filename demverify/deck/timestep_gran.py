"""LIGGGHTS' `fix check/timestep/gran`: its words, and the Rayleigh and Hertz times it compares the step with.

    Rayleigh time   min over particles of  pi R sqrt(rho/G) / (0.1631 nu + 0.8766),   G = Y / (2 (nu + 1))
    Hertz time      min over particles of  2.87 [m^2 / (R/2 Ye^2 v)]^(1/5),           1/Ye = 2 (1 - nu^2)/Y

with v, twice the largest speed, the speed of two particles that meet head on, and m the whole mass of one particle, not the effective mass m/2 of the
two: so it is 2^(2/5) = 1.32 times the duration of that collision. Only particles of the fix's group count, and only collisions of each with its like.
Source: LIGGGHTS 3.8.0, fix_check_timestep_gran.cpp; N. V. Brilliantov et al., Phys. Rev. E 53 (1996) 5382 (duration of a Hertz collision,
2.868 (m^2/(R Ye^2 v))^(1/5)); measured, test_timestep_gran.py. Meshes, whose speed counts in LIGGGHTS, are not there.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from demsolver.scene import Particles
from demsolver.state import selected
from demverify.deck.materials_common import Words, group_bit
from demverify.deck.properties_liggghts import Properties
from demverify.deck.setup import Floats, Setup, Spec
from demverify.formats.columns import volume

STYLE = "check/timestep/gran"
LEAST_SPEED = 1e-13
"""Below it LIGGGHTS takes a speed for none."""
NO_RAYLEIGH, NO_HERTZ = 1e20, 1e6
"""What LIGGGHTS has where there are no particles, or nothing moves."""


@dataclass(frozen=True)
class Material:
    """Young's modulus and Poisson's ratio of each type, (ntypes,); NaN where the deck gives a type none."""

    young: Floats
    poisson: Floats


@dataclass(frozen=True)
class Check:
    """One fix: every so many steps; rayleigh, hertz: largest fractions without a warning; vmax: least speed to reckon with."""

    every: int
    rayleigh: float
    hertz: float
    warn: bool = True
    error: bool = False
    vmax: float = 0.0
    bit: int = 0


@dataclass(frozen=True)
class Times:
    """rayleigh, hertz: times. relative_speed: twice the largest. radius: the smallest. rayleigh_particle, hertz_particle: row of the particle that
    has them, or -1."""

    rayleigh: float
    hertz: float
    relative_speed: float
    radius: float
    rayleigh_particle: int = -1
    hertz_particle: int = -1

    def fractions(self, dt: float, skin: float) -> tuple[float, float, float]:
        """f_ID[1] to f_ID[3]: the step over the Rayleigh time and over the Hertz time, the way of a step over the skin."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return dt / self.rayleigh, dt / self.hertz, float(np.float64(self.relative_speed * dt) / skin)

    def complaints(self, check: Check, dt: float, skin: float) -> list[str]:
        """What LIGGGHTS says of this step, in its words."""
        rayleigh, hertz, way = self.fractions(dt, skin)
        moved = self.relative_speed * dt
        said = {
            f"time-step is {100.0 * rayleigh:f} % of rayleigh time": rayleigh > check.rayleigh,
            f"time-step is {100.0 * hertz:f} % of hertz time": hertz > check.hertz,
            "time step too large or skin too small - particles may relatively travel a distance of "
            f"{moved:f} per time-step, but skin is {skin:f}": way > 1.0,
            "time step way too large - particles relativley move further than the minimum radius in one step": moved > self.radius,
        }
        return [text for text, so in said.items() if so]


def check_of(setup: Setup, spec: Spec) -> Check:
    """The words of a fix. Raises InputError."""
    words = Words(spec.args, f"fix {spec.id} {STYLE}", spec.place)
    words.skip("check_every_time")
    numbers = words.integer("number of steps", 1), words.number("fraction of the Rayleigh time", 0.0), words.number("fraction of the Hertz time", 0.0)
    flags, vmax = {"warn": True, "error": False}, 0.0
    while words:
        keyword = words.choice("keyword", ("warn", "error", "vmax"))  # LIGGGHTS 3.8.0 hangs on any other
        if keyword == "vmax":
            vmax = words.number("vmax", 0.0)
        else:
            flags[keyword] = words.choice(keyword, ("yes", "no")) == "yes"
    return Check(*numbers, flags["warn"], flags["error"], vmax, group_bit(setup, spec))


def liggghts_material(setup: Setup, spec: Spec) -> Material:
    """Of the deck's `fix property/global`. Raises InputError where one is missing: LIGGGHTS stops there."""
    properties = Properties(setup, f"fix {spec.id} {STYLE}", spec.place)
    return Material(*properties.elastic())


def times_of(particles: Particles, material: Material, *, vmax: float = 0.0, bit: int = 0, dimension: int = 3) -> Times:
    """Rayleigh and Hertz time of the particles of a group whose material is known."""
    known = np.isfinite(material.young)[particles.type - 1] & (particles.radius > 0.0)
    rows = np.flatnonzero(selected(particles.mask, bit) & known)
    if not len(rows):
        return Times(NO_RAYLEIGH, NO_HERTZ, 2.0 * vmax, NO_RAYLEIGH)
    radius, kind = particles.radius[rows], particles.type[rows] - 1
    young, nu = material.young[kind], material.poisson[kind]
    density = particles.mass[rows] / volume(radius, dimension)
    rayleigh = pi * radius * np.sqrt(density / (young / (2.0 * (nu + 1.0)))) / (0.1631 * nu + 0.8766)
    speed = 2.0 * max(vmax, float(np.sqrt((particles.v[rows] ** 2).sum(axis=1)).max()))
    slowest, least = int(np.argmin(rayleigh)), float(radius.min())
    if speed < LEAST_SPEED:
        return Times(float(rayleigh[slowest]), NO_HERTZ, speed, least, int(rows[slowest]))
    effective = young / (2.0 * (1.0 - nu * nu))
    mass = 4.0 / 3.0 * pi * radius**3 * density
    hertz = 2.87 * (mass * mass / (0.5 * radius * effective * effective * speed)) ** 0.2
    quickest = int(np.argmin(hertz))
    return Times(float(rayleigh[slowest]), min(float(hertz[quickest]), NO_HERTZ), speed, least, int(rows[slowest]), int(rows[quickest]))

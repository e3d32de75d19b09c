"""Values of thermo keywords, computes and variables of a running native simulation, with the engines' own definitions."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from demsolver.computes import Population, RigidBodies, erotate, erotate_sphere, ke
from demsolver.computes.erotate import erotate_by_shape
from demsolver.scene import Particles
from demsolver.simulate import Simulation
from demsolver.state import Floats, selected
from demverify.deck.setup import Setup, Spec
from demverify.deck.state_values import KEYWORDS as _STATE_KEYWORDS
from demverify.deck.state_values import state_value
from demverify.engines._checks import FIX, StepChecks
from demverify.errors import InputError
from demverify.formats.columns import COLUMNS, Snapshot

BOLTZMANN = {
    "lammps": {"lj": 1.0, "si": 1.380649e-23, "cgs": 1.380649e-16, "micro": 1.380649e-8},
    "liggghts": {"lj": 1.0, "si": 1.3806504e-23, "cgs": 1.3806504e-16, "micro": 1.3806504e-8},
}
INDEXED = re.compile(r"c_([^\[\]]+)(?:\[(\d+)\])?$")
BIG = 1e20  # where the engines start looking for a minimum
REDUCE: dict[str, Callable[[Floats], float]] = {
    "sum": lambda a: float(a.sum()),
    "min": lambda a: float(a.min(initial=BIG)),
    "max": lambda a: float(a.max(initial=-BIG)),
    "ave": lambda a: float(a.mean()) if len(a) else 0.0,
    "sumsq": lambda a: float(a @ a),
    "avesq": lambda a: float(a @ a) / len(a) if len(a) else 0.0,
}
FORCES = ("fx", "fy", "fz", "tqx", "tqy", "tqz")
EXTENSIVE_MODES = ("sum", "sumsq")


@dataclass(frozen=True)
class Meter:
    """Reads values off a simulation. start: step at which the run began; began: its clock. checks: of the run's fixes check/timestep/gran."""

    setup: Setup
    simulation: Simulation
    start: int
    began: float
    checks: StepChecks = field(default_factory=StepChecks)
    _seen: dict[int, Particles] = field(default_factory=dict)

    def value(self, keyword: str, *, normalise: bool) -> float:
        """The value of a thermo keyword, c_ID, c_ID[i], f_ID[i] or v_NAME. normalise: extensive values per particle (thermo_modify norm yes).

        Raises InputError naming what exists.
        """
        if keyword.startswith("v_"):
            return float(self.setup.variables.exact(keyword[2:], self.setup.thermo.place))
        if found := INDEXED.match(keyword):
            return self._compute(found[1], int(found[2] or 0), normalise=normalise)
        if found := FIX.match(keyword):
            number = self.checks.value(self.setup, found[1], int(found[2] or 0))
            return number / self.count if normalise and self.count else number  # LIGGGHTS counts it among the extensive ones
        if keyword in _KEYWORDS:
            number = _KEYWORDS[keyword](self)
            extensive = normalise and keyword in _EXTENSIVE
            return number / self.count if extensive and self.count else number
        if (known := state_value(self.setup, keyword)) is not None:
            return known
        message = f"thermo keyword {keyword!r} is not one of {', '.join(KEYWORDS)}, c_ID, f_ID[i], v_NAME"
        raise InputError(message)

    @property
    def particles(self) -> Particles:
        """The particles at this step, copied out of the simulation once."""
        if self.simulation.step not in self._seen:
            self._seen.clear()
            self._seen[self.simulation.step] = self.simulation.particles()
        return self._seen[self.simulation.step]

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.simulation.id)

    @property
    def degrees(self) -> float:
        """Translational degrees of freedom as `compute temp` counts them: d N - d."""
        return float(self.setup.dimension * (self.count - 1))

    @property
    def kinetic(self) -> float:
        """Kinetic energy; zero for one particle, to which the engines leave no degree of freedom."""
        return _kinetic(self.particles) if self.degrees > 0 else 0.0

    @property
    def temperature(self) -> float:
        """2 ke / (degrees k_B)."""
        return 2.0 * self.kinetic / (self.degrees * self.boltzmann) if self.degrees > 0 else 0.0

    @property
    def boltzmann(self) -> float:
        """k_B in the deck's units."""
        return BOLTZMANN[self.setup.dialect][self.setup.units]

    @property
    def pressure(self) -> float:
        """Kinetic part and pair virial over the volume; walls do not count, as in the engines."""
        if not self.simulation.virial:
            message = "a formula can use press only where thermo_style prints it, as in LAMMPS"
            raise InputError(message, self.setup.thermo.place)
        volume = float(np.prod((self.simulation.box_hi - self.simulation.box_lo)[: self.setup.dimension]))
        return (self.temperature * self.degrees * self.boltzmann + self.simulation.pair_virial()) / (
            self.setup.dimension * volume
        )

    def _compute(self, name: str, index: int, *, normalise: bool) -> float:
        spec = self.setup.computes.get(name)
        if spec is None:
            message = f"compute {name!r} is not one of {', '.join(self.setup.computes) or 'none'}"
            raise InputError(message)
        members = self._members(spec.group)
        if spec.style == "reduce":
            number, extensive = self._reduce(spec, members, index)
        else:
            number, extensive = _ENERGIES[spec.style](members), True
        return number / self.count if normalise and extensive and self.count else number

    def _members(self, group: str) -> Particles:
        everything = self.particles
        chosen = selected(everything.mask, self.setup.groups[group])
        return everything if chosen.all() else everything.rows(chosen)

    def _reduce(self, spec: Spec, members: Particles, index: int) -> tuple[float, bool]:
        mode, *inputs = spec.args
        wanted = inputs[max(0, index - 1)] if index <= len(inputs) else ""
        if mode not in REDUCE or wanted not in COLUMNS:
            message = f"compute reduce {mode} {wanted} is not supported; modes: {' '.join(REDUCE)}; inputs: {' '.join(COLUMNS)}"
            raise InputError(message, spec.place)
        force = torque = np.zeros((0, 3))
        if wanted in FORCES:
            chosen = selected(self.particles.mask, self.setup.groups[spec.group])
            force, torque = (array[chosen] for array in self.simulation.forces())
        snapshot = Snapshot(self.simulation.step, self.simulation.box(), members, force, torque, members.id)
        return REDUCE[mode](COLUMNS[wanted](snapshot).astype(np.float64)), mode in EXTENSIVE_MODES


def population_of(p: Particles) -> Population:
    """For the energy computes."""
    shapes, c = p.superquadrics, p.clumps
    found = Population(p.id, p.mass, p.radius, p.omega, p.x, p.v)
    if shapes is not None:
        found = replace(found, shape=shapes.axes, blockiness=shapes.blockiness, quat=shapes.quat, angmom=shapes.angmom)
    if c is not None:
        bodies = RigidBodies(c.id, c.inertia, c.quat, c.mass, c.v, c.omega, c.angmom)
        found = replace(found, body=np.where(c.body >= 0, c.id[c.body], 0), bodies=bodies)
    return found


def _of_shape(p: Particles, shape: str) -> float:
    return sum(energies.total for name, energies in erotate_by_shape(population_of(p)) if name == shape)


def _counted(p: Particles) -> NDArray[np.bool_]:
    """Whom the computes of spheres count: LAMMPS all, LIGGGHTS those that are no member of a clump."""
    return np.ones(len(p.id), dtype=bool) if p.clumps is None or p.clumps.members_weigh else p.clumps.body < 0


def _of_bodies(p: Particles) -> float:
    return ke(p.clumps.mass, p.clumps.v) if p.clumps else 0.0


def _kinetic(p: Particles) -> float:
    """Of translation: in LAMMPS of every sphere, in LIGGGHTS of free ones and of clumps as wholes (measured)."""
    counted = _counted(p)
    return ke(p.mass[counted], p.v[counted]) + (0.0 if counted.all() else _of_bodies(p))


_ENERGIES: dict[str, Callable[[Particles], float]] = {
    "ke": _kinetic,
    "ke/multisphere": _of_bodies,
    "ke/rigid": _of_bodies,
    "erotate/sphere": lambda p: float(erotate_sphere(p.mass, p.radius, p.omega)[_counted(p)].sum()),
    "erotate/multisphere": lambda p: _of_shape(p, "multisphere"),
    "erotate/rigid": lambda p: _of_shape(p, "multisphere"),
    "erotate/superquadric": lambda p: _of_shape(p, "superquadric"),
    "erotate": lambda p: erotate(population_of(p)),
}
_KEYWORDS: dict[str, Callable[[Meter], float]] = {
    "ke": lambda m: m.kinetic,
    "pe": lambda m: 0.0,
    "epair": lambda m: 0.0,
    "emol": lambda m: 0.0,
    "evdwl": lambda m: 0.0,
    "etotal": lambda m: m.kinetic,
    "temp": lambda m: m.temperature,
    "press": lambda m: m.pressure,
    "erotate": lambda m: _ENERGIES["erotate"](m.particles),
    "elapsed": lambda m: m.simulation.step - m.start,
    "cpu": lambda m: perf_counter() - m.began if m.simulation.step > m.start else 0.0,
    "density": lambda m: float(m.particles.mass.sum() / np.prod(m.simulation.box_hi - m.simulation.box_lo)),
}
KEYWORDS = (*_STATE_KEYWORDS, *_KEYWORDS)
_EXTENSIVE = ("ke", "etotal", "erotate")

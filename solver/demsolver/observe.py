"""What can be asked of a running simulation: its particles in the scene's order, its forces, its energies. Copies, never the arrays of the run."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demsolver import neighbors
from demsolver.energy_budget import EnergyBudget
from demsolver.guard import Good, Guard
from demsolver.listed import Listed, listed
from demsolver.neighbor_grid import bounds_of
from demsolver.scene import Box, Clumps, Gravity, Particles, Scene, Superquadrics
from demsolver.sleep import Sleepers
from demsolver.specialise import Features, compiling
from demsolver.state import Bodies, Floats, Ints, Pairs, Rigid, clumped_of, inertias, of_each, outside, selected, shaped_of

if TYPE_CHECKING:
    from types import ModuleType

ACCOUNT, LOST_POINTS, TALLIES = 6, 7, 8  # columns of a tally that are the account of energy, contact points not found, and all: see kernel_contact.py


class Observed:
    """The arrays of a run, and what is asked of them. Rows stand in an order of their own; id: (n,) of the particles that are left."""

    scene: Scene
    step: int
    id: Ints
    box_lo: Floats
    box_hi: Floats
    virial: bool
    _budget: bool
    _has: Features
    _threads: int
    _kernel: ModuleType
    _order: Ints
    _image: NDArray[np.int32]
    _bodies: Bodies
    _rigid: Rigid
    _still: Floats
    _walls: tuple[tuple[Any, ...], ...]
    _coefficients: Floats | tuple[float, ...]
    _pairs: Pairs
    _tallies: Floats
    _margin: Any
    _sleepers: Sleepers | None
    _guard: Guard | None

    @property
    def bodies(self) -> Bodies:
        """The arrays of the particles in the scene's order, as they are now: copies."""
        shown = of_each(self._bodies, lambda array: outside(array, self._order))
        shown.force[self.asleep], shown.torque[self.asleep[: len(shown.torque)]] = 0.0, 0.0
        if self._has.ROTATES:
            return shown
        return shown._replace(omega=self._still.copy(), torque=np.zeros_like(shown.force))

    @property
    def pairs(self) -> Listed:
        """The neighbour list in the scene's numbers: a copy."""
        return listed(self._pairs, self._order)

    @property
    def image(self) -> Ints:
        """(n, 3) periodic wraps, in the scene's order."""
        return outside(self._image, self._order).astype(np.int64)

    @property
    def asleep(self) -> NDArray[np.bool_]:
        """(n,) who sleeps, in the scene's order: their forces count as zero."""
        return outside(self._sleepers.asleep, self._order) if self._sleepers else np.zeros(len(self.id), dtype=bool)

    @property
    def threads(self) -> int:
        """How many share the work."""
        return self._threads

    def here(self) -> Good:
        """What moves, as it is now: copies."""
        b = self._bodies
        omega = b.omega.copy() if self._has.ROTATES else self._still[self._order]
        return Good(self.step, self.id[self._order], b.x.copy(), b.v.copy(), omega, self._image.copy(), self.box_lo.copy(), self.box_hi.copy())

    @property
    def deep(self) -> bool:
        """Whether the loop has met a contact that is too deep; kept where a guard is."""
        return bool(self._tallies[:, ACCOUNT].any())

    @property
    def touches(self) -> bool:
        """Whether anything touches anything."""
        return bool((self._pairs.touching & 1).any()) or any(wall[-1].any() for wall in self._walls)

    @property
    def last_good(self) -> Good | None:
        """The last state that the guard found well; None without a guard, or before its first look."""
        return self._guard.good if self._guard else None

    def energy_budget(self) -> EnergyBudget:
        """The account of energy now; needs budget=True."""
        if not self._budget:
            message = "the energy budget was not kept: make the Simulation with budget=True"
            raise ValueError(message)
        spent = -self._account()
        (kinetic, rotational), (normal, tangential, rolling) = self._kinetic(), self._stored()
        return EnergyBudget(
            kinetic=kinetic,
            rotational=rotational,
            elastic_normal=normal,
            elastic_tangential=tangential,
            elastic_rolling=rolling,
            gravitational=float(self._heights().sum()),
            damped=float(spent[0]),
            rubbed=float(spent[1]) - tangential,
            rolled=float(spent[4]) - rolling,
            dragged=float(spent[2]),
            driven=-float(spent[5]),
        )

    def visible_energy(self) -> tuple[float, float, float]:
        """Kinetic energy with that of the spins; potential energy of gravity; the sum of the magnitudes that the latter is made of."""
        heights = self._heights()
        return sum(self._kinetic()), float(heights.sum()), float(np.abs(heights).sum())

    def farthest(self) -> float:
        """The largest coordinate in size; 0 when nobody is there."""
        return float(np.abs(bounds_of(self._bodies.x)).max()) if len(self.id) else 0.0

    def elastic_energy(self) -> float:
        """Of all contacts."""
        return sum(self._stored())

    def _account(self) -> Floats:
        account: Floats = self._tallies[:, :ACCOUNT].sum(axis=0)
        return account

    def _kinetic(self) -> tuple[float, float]:
        """Of translation and rotation."""
        b = self._bodies
        omega = b.omega if self._has.ROTATES else self._still[self._order]
        mass, inertia = b.mass, inertias(self.scene, b.mask, b.mass, b.radius)
        kinetic = rotational = 0.0
        if more := shaped_of(b):
            shaped = more.axes[:, 0] > 0.0
            rotational += 0.5 * float(np.sum(more.angmom[shaped] * omega[shaped]))
            inertia = np.where(shaped, 0.0, inertia)
        if members := clumped_of(b):
            c, member = self._rigid, members.clump >= 0
            kinetic += 0.5 * float(np.einsum("i,ic,ic", c.mass, c.v, c.v))
            rotational += 0.5 * float(np.sum(c.angmom * c.omega))
            mass, inertia = np.where(member, 0.0, mass), np.where(member, 0.0, inertia)
        kinetic += 0.5 * float(np.einsum("i,ic,ic", mass, b.v, b.v))
        return kinetic, rotational + 0.5 * float(np.einsum("i,ic,ic", inertia, omega, omega))

    def _stored(self) -> tuple[float, float, float]:
        with compiling():
            normal, tangential, rolling = self._kernel.stored(
                self._bodies, self._pairs, self._shifts(), self._coefficients, self.scene.ntypes, self._flat_walls(), self.scene.timestep
            )
        return normal, tangential, rolling

    def pair_virial(self) -> float:
        """Sum of r.F over the pairs at the last force evaluation; needs virial=True."""
        if not self.virial:
            message = "the virial was not kept: make the Simulation with virial=True"
            raise ValueError(message)
        return float(self._tallies[:, 3].sum())

    def particles(self) -> Particles:
        """The particles as they are now: copies."""
        b, order = self._bodies, self._order
        omega = outside(b.omega, order) if self._has.ROTATES else self._still.copy()
        return Particles(
            id=self.id.copy(), type=outside(b.kind, order) + 1, x=outside(b.x, order), v=outside(b.v, order), omega=omega,
            radius=outside(b.radius, order), mass=outside(b.mass, order), mask=outside(b.mask, order), image=self.image,
            superquadrics=self._superquadrics(), clumps=self._clumps(),
        )  # fmt: skip

    def _superquadrics(self) -> Superquadrics | None:
        names = ("axes", "blockiness", "quat", "inertia", "angmom")
        found = shaped_of(self._bodies)
        return Superquadrics(**{name: outside(getattr(found, name), self._order) for name in names}) if found else None

    def _clumps(self) -> Clumps | None:
        """The clumps as they are now: copies."""
        was, c, members = self.scene.particles.clumps, self._rigid, clumped_of(self._bodies)
        if was is None or members is None:
            return None
        offset = np.zeros((len(self.id), 3))
        offset[self._order[c.member]] = c.offset
        moved = {name: getattr(c, name).copy() for name in ("x", "v", "quat", "angmom", "omega")}
        return replace(was, body=outside(members.clump, self._order), offset=offset, **moved)

    def clump_forces(self) -> tuple[Floats, Floats]:
        """Forces and torques about the centres of mass (m, 3) of the clumps as they are now: copies."""
        return self._rigid.force.copy(), self._rigid.torque.copy()

    def forces(self) -> tuple[Floats, Floats]:
        """Forces and torques (n, 3) as they are now: copies."""
        force = outside(self._bodies.force, self._order)
        torque = outside(self._bodies.torque, self._order) if self._has.ROTATES else np.zeros_like(force)
        force[self.asleep], torque[self.asleep] = 0.0, 0.0
        return force, torque

    def box(self) -> Box:
        """The box as it is now: shrink-wrapped faces follow the particles at every list rebuild."""
        return Box(self.box_lo.copy(), self.box_hi.copy(), self.scene.box.boundary, self._margin)

    def _flat_walls(self) -> tuple[Any, ...]:
        return tuple(array for wall in self._walls for array in wall)

    def _shifts(self) -> Floats:
        shifts: Floats = neighbors.SHIFTS * (self.box_hi - self.box_lo)
        return shifts

    def _heights(self) -> Floats:
        """Potential energy of gravity of each row that it can move on its own, asleep or awake, then of each clump."""
        b = self._bodies
        falls = (b.moving | self._sleepers.asleep if self._sleepers else b.moving) & ~b.frozen
        unwrapped = b.x + self._image * (self.box_hi - self.box_lo)
        heights = np.zeros(len(b.x))
        if members := clumped_of(b):
            falls &= members.clump < 0
        for field in self.scene.forces:
            if isinstance(field, Gravity):
                heights -= np.where(selected(b.mask, field.bit) & falls, b.mass * (unwrapped @ np.array(field.acceleration)), 0.0)
        return np.concatenate([heights, self._clump_heights()])

    def _clump_heights(self) -> Floats:
        """The same of each clump."""
        c, was = self._rigid, self.scene.particles.clumps
        heights = np.zeros(len(c.mass))
        if was is None:
            return heights
        for field in self.scene.forces:
            if isinstance(field, Gravity):
                heights -= np.where(selected(was.mask, field.bit), c.mass * (c.x @ np.array(field.acceleration)), 0.0)
        return heights

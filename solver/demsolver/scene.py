"""The frozen description of a scene: what is simulated, never how.

Nothing here computes. A scene is built by hand, or by `demverify.deck` from an input deck, and handed to `demsolver.Simulation`.
Units are those of the deck (any consistent set); angles are radians; particle types count from 1 as in LAMMPS.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from demsolver.expression import Expression

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Rows = NDArray[np.int64] | NDArray[np.bool_]
Arm = Literal["radius", "contact"]


@dataclass(frozen=True)
class Box:
    """An orthogonal box. `lo`, `hi`: (3,) lengths. `boundary`: per axis two letters of p f s m, lower face first ("pp", "fs").

    margin: (3,) how far shrink-wrapped faces keep off the outermost centre; None for 1e-4 of the box, as LAMMPS takes it of the box
    that the deck names and then keeps.
    """

    lo: Floats
    hi: Floats
    boundary: tuple[str, str, str] = ("pp", "pp", "pp")
    margin: Floats | None = None

    @property
    def periodic(self) -> tuple[bool, bool, bool]:
        """Per axis, whether particles leaving one face enter at the other."""
        return tuple(faces == "pp" for faces in self.boundary)  # type: ignore[return-value]


@dataclass(frozen=True)
class Superquadrics:
    """What makes particles superquadrics (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1, n rows; a row of zeros in `axes` is a sphere.

    axes (n, 3) semi-axes. blockiness (n, 2) n1, n2, at least 2. quat (n, 4) w x y z, body to space. inertia (n, 3) principal moments. angmom (n, 3)
    in space.
    """

    axes: Floats
    blockiness: Floats
    quat: Floats
    inertia: Floats
    angmom: Floats

    def rows(self, chosen: Rows) -> Superquadrics:
        """Copies of some rows, in their order."""
        return Superquadrics(*(getattr(self, field.name)[chosen] for field in fields(self)))


@dataclass(frozen=True)
class Clumps:
    """Rigid bodies of spheres. body (n,): of each particle the row of its clump, -1 if it is free; offset (n, 3): where it is, from the centre of
    mass along the principal axes. Of m clumps: id (m,); x (m, 3) centres of mass, unwrapped; v (m, 3); quat (m, 4) w x y z, principal axes to
    space; angmom, omega (m, 3) in space; mass (m,); inertia (m, 3) principal moments; mask (m,) group bits.

    members_weigh: gravity pulls at each member by its own mass (LAMMPS), or at the centre of the whole (LIGGGHTS). Contact laws see the mass of the
    whole either way.
    """

    body: Ints
    offset: Floats
    id: Ints
    x: Floats
    v: Floats
    quat: Floats
    angmom: Floats
    omega: Floats
    mass: Floats
    inertia: Floats
    mask: Ints
    members_weigh: bool = True

    def rows(self, chosen: Rows) -> Clumps:
        """The same clumps with copies of some rows of the particles, in their order."""
        return replace(self, body=self.body[chosen], offset=self.offset[chosen])


@dataclass(frozen=True)
class Particles:
    """Spheres, some of which are superquadrics, or members of clumps. All arrays have n rows; n may be 0.

    id (n,) unique, from 1. type (n,) from 1. x, v (n, 3). omega (n, 3) angular velocity [rad/time]. radius, mass (n,).
    mask (n,): bit b set when the particle belongs to group b (bit 0 is "all"). image (n, 3): periodic wraps, as LAMMPS ix iy iz.
    Of a superquadric radius is that of a sphere that holds it (`superquadric.bounding_radius`). Of a member of a clump x, v and omega follow from
    its clump, and mass is its own share of what gravity pulls, or that of the whole clump: see Clumps.members_weigh.
    """

    id: Ints
    type: Ints
    x: Floats
    v: Floats
    omega: Floats
    radius: Floats
    mass: Floats
    mask: Ints
    image: Ints
    superquadrics: Superquadrics | None = None
    clumps: Clumps | None = None

    def rows(self, chosen: Rows) -> Particles:
        """Copies of some rows, in their order; all clumps stay."""
        own = {field.name: getattr(self, field.name)[chosen] for field in fields(self) if field.name not in ("superquadrics", "clumps")}
        shapes = self.superquadrics.rows(chosen) if self.superquadrics else None
        clumps = self.clumps.rows(chosen) if self.clumps else None
        return Particles(**own, superquadrics=shapes, clumps=clumps)


@dataclass(frozen=True)
class ContactLaw:
    """One contact law, put together from the files of `demsolver/contact`.

    normal, damping, tangential_stiffness, tangential_damping, friction: names of the laws, i.e. file stems without the family
        prefix: normal="hertz" is contact/normal_hertz.py. friction="none" means no tangential force at all; cohesion, rolling and twisting
        "none" that there is none.
    coefficients: every parameter that the chosen laws name, e.g. {"kn": ..., "gamma_n": ...}; shape (ntypes, ntypes) for pairs,
        (ntypes,) for a wall (indexed by particle type - 1).
    surface_arm: lever of the spin in the velocity at the contact point: "radius" R, or "contact" R - overlap/2.
    torque_arm: lever of the tangential force in the torque: the same two.
    limit_damping: True cuts a pulling total normal force to zero (LAMMPS limit_damping, LIGGGHTS limitForce on).
    tangential_reduce: True lets the cohesion force count in the limits of friction and rolling (LIGGGHTS tangential_reduce on).
    curvature: what the effective radius R* of superquadrics is made of: radii of spheres of the same volume, or the mean or Gaussian curvature of
    the surfaces where they touch (LIGGGHTS meanCurvature, gaussianCurvature), then at most curvature_limit times the former (curvatureLimitFactor).
    """

    normal: str
    damping: str
    tangential_stiffness: str
    tangential_damping: str
    friction: str
    coefficients: Mapping[str, Floats]
    surface_arm: Arm = "radius"
    torque_arm: Arm = "radius"
    limit_damping: bool = False
    cohesion: str = "none"
    rolling: str = "none"
    twisting: str = "none"
    tangential_reduce: bool = False
    curvature: Literal["volume", "mean", "gaussian"] = "volume"
    curvature_limit: float = np.inf


@dataclass(frozen=True)
class Slab:
    """The planes axis=lo and axis=hi as one wall: a particle sees the nearer one, from either side. axis 0, 1, 2; -inf/inf: absent."""

    axis: int
    lo: float = -np.inf
    hi: float = np.inf


@dataclass(frozen=True)
class Rotation:
    """How a wall turns about its own axis: its surface moves, its place does not. rate: angular velocity [rad/time], right-handed.

    at: where the velocity rate x (r - axis) of the surface is taken, at the "surface" where it is touched (LAMMPS) or at the "center" of the
        particle (LIGGGHTS), which from inside makes the surface slower.
    rolls: whether rolling and twisting resist motion against the turning wall; in LAMMPS and LIGGGHTS they know the particle's spin alone.
    still_at_setup: the set-up of a run finds the wall at rest (LAMMPS, which takes a rate from two steps).
    """

    rate: float
    at: Literal["surface", "center"] = "surface"
    rolls: bool = True
    still_at_setup: bool = False


@dataclass(frozen=True)
class Cylinder:
    """An endless cylinder along `axis` (0, 1, 2) with `radius` about `center`, given for the two other axes in cyclic order
    (axis 2: x, y; axis 0: y, z; axis 1: z, x). `effective_radius`: "flat" uses R* = R (LIGGGHTS); "curved" uses
    R* = R Rw/(R + Rw), Rw = -2 radius seen from inside and +2 radius from outside (LAMMPS). `side`: who feels it, centres within
    the radius ("in"), beyond it ("out"), or "both". `rotation`: None for a cylinder that does not turn."""

    axis: int
    center: tuple[float, float]
    radius: float
    effective_radius: Literal["flat", "curved"] = "flat"
    side: Literal["both", "in", "out"] = "both"
    rotation: Rotation | None = None


@dataclass(frozen=True)
class Plane:
    """The plane a x + b y + c z + d = 0. normal: (a, b, c), of any length but zero; offset: d. Felt from both sides, or (one_sided) by spheres
    whose centres lie where the normal points.

    It moves as a rigid body from the begin of the run on: velocity (3,) of the pivot, omega (3,) [rad/time] about pivot (3,), which goes along.
    """

    normal: tuple[float, float, float]
    offset: float
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    omega: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)
    one_sided: bool = False

    @property
    def moving(self) -> bool:
        """Whether it changes its place."""
        return any(self.velocity) or any(self.omega)


@dataclass(frozen=True)
class Wall:
    """A wall for the particles of group `bit`. `touch_closed`: contact also at exactly zero gap (LIGGGHTS), else overlap > 0 (LAMMPS).
    `velocity`: (3,) constant velocity of its surface, as of a conveyor: the wall stays where it is."""

    name: str
    shape: Slab | Cylinder | Plane
    law: ContactLaw
    bit: int = 0
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    touch_closed: bool = False


@dataclass(frozen=True)
class Gravity:
    """Constant acceleration (3,) on the particles of group `bit`."""

    acceleration: tuple[float, float, float]
    bit: int = 0


@dataclass(frozen=True)
class Viscous:
    """F -= gamma[type - 1] v on group `bit`; gamma (ntypes,)."""

    gamma: Floats
    bit: int = 0


@dataclass(frozen=True)
class SetForce:
    """Sets force components of group `bit`; None leaves a component alone."""

    force: tuple[float | None, float | None, float | None]
    bit: int = 0


@dataclass(frozen=True)
class Freeze:
    """Zeroes force and torque of group `bit`; contacts see such particles as infinitely heavy (m* is the partner's mass)."""

    bit: int = 0


@dataclass(frozen=True)
class Enforce2D:
    """Zeroes v_z, f_z, omega_x, omega_y, torque_x, torque_y of group `bit`."""

    bit: int = 0


@dataclass(frozen=True)
class AddForce:
    """F += force on group `bit`, each component a formula of the particle's own state (`demsolver.expression`): of positions and velocities
    as the contact forces of a step see them. It knows neither time nor other particles: who rests goes on feeling the same."""

    force: tuple[Expression, Expression, Expression]
    bit: int = 0


Force = AddForce | Gravity | Viscous | SetForce | Freeze | Enforce2D


@dataclass(frozen=True)
class NveSphere:
    """Velocity Verlet for group `bit`; `inertia` is the factor in I = factor m R^2: 0.4, or 0.5 for discs."""

    bit: int = 0
    inertia: float = 0.4


@dataclass(frozen=True)
class EulerSphere:
    """Semi-implicit Euler for group `bit`: v += dt F/m, then x += dt v. `inertia` as in NveSphere.

    Its velocities belong half a step before its positions: v(n) is what Verlet calls v(n - 1/2). Source: K. Shobuzako, "DEM no kiso" (2025),
    eq. 2.2, who calls it forward Euler.
    """

    bit: int = 0
    inertia: float = 0.4


@dataclass(frozen=True)
class NveSuperquadric:
    """Velocity Verlet for the superquadrics of group `bit`, turned by `scheme`, a file of demsolver.rotation; its spheres as by NveSphere."""

    bit: int = 0
    scheme: str = "no_squish"


@dataclass(frozen=True)
class NveClumps:
    """Velocity Verlet for the clumps, all of which belong to group `bit`, turned by `scheme`, a file of demsolver.rotation."""

    bit: int = 0
    scheme: str = "richardson"


Integrator = NveSphere | EulerSphere | NveSuperquadric | NveClumps


@dataclass(frozen=True)
class Neighbor:
    """Neighbour list: skin length, rebuild cadence as LAMMPS' neigh_modify, and pairs left out.

    exclude: (bit, bit) of groups; exclude_types: (type, type)."""

    skin: float
    every: int = 1
    delay: int = 0
    check: bool = True
    exclude: tuple[tuple[int, int], ...] = ()
    exclude_types: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Scene:
    """Everything a run needs. `forces` act in this order after the contacts. `pair` None: particles do not see each other.

    history_outlives_contact: tangential memory of a pair survives separation until the next list rebuild (LIGGGHTS), instead
    of ending with the contact (LAMMPS). contact_point: what defines the contact of two superquadrics (demsolver.superquadric.pairs)."""

    box: Box
    particles: Particles
    ntypes: int
    timestep: float
    pair: ContactLaw | None = None
    walls: tuple[Wall, ...] = ()
    forces: tuple[Force, ...] = ()
    integrate: tuple[Integrator, ...] = ()
    neighbor: Neighbor = field(default_factory=lambda: Neighbor(skin=0.0))
    dimension: int = 3
    lost: Literal["error", "warn", "ignore"] = "error"
    history_outlives_contact: bool = False
    contact_point: Literal["potential", "gauge"] = "potential"

    @property
    def rolling_inertia(self) -> float:
        """Moment of inertia about the contact point over m R^2: 7/5 of a sphere, 3/2 of a disc, which is what rolls in two dimensions."""
        return 1.5 if self.dimension == 2 else 1.4

"""Is what a scene says of its superquadrics and clumps something that can move?"""

from __future__ import annotations

import numpy as np

from demsolver import rotation
from demsolver.bind_law import goes_beyond, is_implicit, is_step_law
from demsolver.scene import Clumps, Cylinder, Enforce2D, EulerSphere, NveClumps, NveSphere, NveSuperquadric, Particles, Scene, Superquadrics
from demsolver.shapes import superquadric
from demsolver.specialise import laws_of
from demsolver.state import Floats, selected
from demsolver.superquadric import BOUND, bounding_radius

_SHAPES = {"axes": 3, "blockiness": 2, "quat": 4, "inertia": 3, "angmom": 3}
_MOVES = {"x": 3, "v": 3, "quat": 4, "angmom": 3, "omega": 3, "inertia": 3}


def check_bodies(scene: Scene) -> None:
    """Raises ValueError for arrays of a wrong shape, numbers out of range, and what superquadrics and clumps do not go together with."""
    p = scene.particles
    for integrator in scene.integrate:
        if isinstance(integrator, NveSuperquadric | NveClumps):
            rotation.scheme(integrator.scheme)
    if p.superquadrics is not None:
        _check_superquadrics(scene, p, p.superquadrics)
    if p.clumps is not None:
        _check_clumps(p, p.clumps)
    if p.superquadrics is not None or p.clumps is not None:
        _check_company(scene)


def _check_superquadrics(scene: Scene, p: Particles, shapes: Superquadrics) -> None:
    n = len(p.id)
    for name, c in _SHAPES.items():
        _check_rows(f"superquadrics.{name}", getattr(shapes, name), n, c)
    shaped = shapes.axes.any(axis=1)
    superquadric.checked(shapes.axes[shaped], shapes.blockiness[shaped])
    _check_turning("superquadric", p.id[shaped], shapes.quat[shaped], shapes.inertia[shaped])
    _check_bounds(p.id[shaped], p.radius[shaped], bounding_radius(shapes.axes[shaped], shapes.blockiness[shaped]))
    for integrator in scene.integrate:
        if isinstance(integrator, NveSphere | EulerSphere) and (found := selected(p.mask, integrator.bit) & shaped).any():
            message = f"particle {p.id[found][0]} is a superquadric: it is moved by NveSuperquadric, not by {type(integrator).__name__}"
            raise ValueError(message)
    if cylinder := next((wall.name for wall in scene.walls if isinstance(wall.shape, Cylinder)), None):
        message = f"wall {cylinder} is a cylinder, whose contact with superquadrics is not known here: use planes"
        raise ValueError(message)
    for law in laws_of(scene):
        if law.cohesion != "none":
            message = f"cohesion {law.cohesion} is known for spheres only, not with superquadrics"
            raise ValueError(message)


def _check_clumps(p: Particles, clumps: Clumps) -> None:
    n, m = len(p.id), len(clumps.id)
    _check_rows("clumps.offset", clumps.offset, n, 3)
    for name, c in _MOVES.items():
        _check_rows(f"clumps.{name}", getattr(clumps, name), m, c)
    for name, rows in (("body", n), ("mass", m), ("mask", m)):
        if getattr(clumps, name).shape != (rows,):
            message = f"clumps.{name} must have the shape ({rows},), got {getattr(clumps, name).shape}"
            raise ValueError(message)
    if ((clumps.body < -1) | (clumps.body >= m)).any():
        message = f"clumps.body must be -1 or the row of one of {m} clumps"
        raise ValueError(message)
    if p.superquadrics is not None and (found := p.superquadrics.axes.any(axis=1) & (clumps.body >= 0)).any():
        message = f"particle {p.id[found][0]} is a superquadric and a member of clump {clumps.id[clumps.body[found][0]]}: members are spheres"
        raise ValueError(message)
    if len(empty := np.setdiff1d(np.arange(m), clumps.body)):
        message = f"clump {clumps.id[empty[0]]} has no members"
        raise ValueError(message)
    if not ((clumps.mass > 0.0) & np.isfinite(clumps.mass)).all():
        message = "the masses of clumps must be above 0"
        raise ValueError(message)
    _check_turning("clump", clumps.id, clumps.quat, clumps.inertia)


def _check_rows(name: str, values: Floats, rows: int, columns: int) -> None:
    if values.shape != (rows, columns) or not np.isfinite(values).all():
        message = f"{name} must be finite and of the shape ({rows}, {columns}), got {values.shape}"
        raise ValueError(message)


def _check_turning(what: str, ids: np.ndarray, quat: Floats, inertia: Floats) -> None:
    for name, wrong in (
        ("quat must have length 1", np.abs(np.linalg.norm(quat, axis=1) - 1.0) > 1e-6),
        ("inertia must be above 0", ~(inertia > 0.0).all(axis=1)),
    ):
        if wrong.any():
            message = f"{what} {ids[wrong][0]}: {name}"
            raise ValueError(message)


def _check_bounds(ids: np.ndarray, radius: Floats, wanted: Floats) -> None:
    """A sphere that does not hold its body loses contacts: pairs are looked at where these spheres touch."""
    if len(small := np.flatnonzero(radius * BOUND < wanted)):
        k = small[0]
        message = f"superquadric {ids[k]}: radius must be that of a sphere around it, bounding_radius {wanted[k]:.9g}, got {radius[k]:.9g}"
        raise ValueError(message)


def _check_company(scene: Scene) -> None:
    """What needs spheres that move each on its own."""
    message = ""
    for law in laws_of(scene):
        if goes_beyond(law) or is_step_law(law) or is_implicit(law):
            message = f"normal law {law.normal} is known for spheres on their own only, not with superquadrics or clumps"
    if any(isinstance(integrator, EulerSphere) for integrator in scene.integrate):
        message = "semi-implicit Euler moves spheres on their own only: superquadrics and clumps move by velocity Verlet"
    if scene.dimension == 2 or any(isinstance(force, Enforce2D) for force in scene.forces):
        message = "superquadrics and clumps move in three dimensions only"
    if scene.contact_point == "gauge" and scene.pair and scene.pair.curvature != "volume":
        message = "curvature radii go with contact_point potential only: with gauge the force would have no energy"
    if message:
        raise ValueError(message)

"""Scenes with superquadrics that cannot run as they are meant: refused in one line that names what is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Box, Cylinder, EulerSphere, NveSphere, Scene, Simulation, Sleep, Wall
from demsolver.scene import ContactLaw, NveSuperquadric, Particles, Superquadrics
from demsolver.stability_contacts import contacts_of
from tests.support.clumps import with_clumps
from tests.support.superquadrics import particles

LAW = ContactLaw("hertz", "none", "none", "none", "none", {"kn": np.full((1, 1), 1e7)})


def bodies() -> Particles:
    """Two that do not touch."""
    x, q = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.2]]), np.array([[1.0, 0.0, 0.0, 0.0]] * 2)
    return particles(x, np.full((2, 3), 0.02), np.full((2, 2), 3.0), q)


def scene(p: Particles, **changed: object) -> Scene:
    """They in a box."""
    fine = Scene(Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff")), p, 1, 1e-5, LAW, integrate=(NveSuperquadric(),))
    return replace(fine, **changed)  # type: ignore[arg-type]


def shaped(**changed: object) -> Particles:
    """The two bodies with other arrays of their shapes."""
    p = bodies()
    assert isinstance(p.superquadrics, Superquadrics)
    return replace(p, superquadrics=replace(p.superquadrics, **changed))  # type: ignore[arg-type]


@pytest.mark.parametrize(("wrong", "said"), [
    (lambda: scene(shaped(quat=np.zeros((2, 4)))), "superquadric 1: quat must have length 1"),
    (lambda: scene(shaped(inertia=np.zeros((2, 3)))), "superquadric 1: inertia must be above 0"),
    (lambda: scene(shaped(axes=np.full((3, 3), 0.02))), r"superquadrics.axes must be finite and of the shape \(2, 3\)"),
    (lambda: scene(shaped(angmom=np.full((2, 3), np.nan))), "superquadrics.angmom must be finite"),
    (lambda: scene(shaped(blockiness=np.full((2, 2), 1.5))), "1.5"),
    (lambda: scene(replace(bodies(), radius=np.full(2, 0.02))), "superquadric 1: radius must be that of a sphere around it, bounding_radius 0.024"),
    (lambda: scene(with_clumps(bodies(), np.zeros(2, dtype=int))), "particle 1 is a superquadric and a member of clump 1: members are spheres"),
    (lambda: scene(bodies(), integrate=(NveSphere(),)), "particle 1 is a superquadric: it is moved by NveSuperquadric, not by NveSphere"),
    (lambda: scene(bodies(), integrate=(EulerSphere(),)), "particle 1 is a superquadric: it is moved by NveSuperquadric, not by EulerSphere"),
    (lambda: scene(bodies(), integrate=(NveSuperquadric(scheme="euler"),)), "rotation scheme 'euler' is not one of"),
    (lambda: scene(bodies(), walls=(Wall("drum", Cylinder(2, (0.0, 0.0), 0.5), LAW),)), "wall drum is a cylinder"),
    (lambda: scene(bodies(), dimension=2), "move in three dimensions only"),
    (lambda: scene(bodies(), pair=replace(LAW, normal="jkr")), "normal law jkr is known for spheres on their own only"),
    (lambda: scene(bodies(), pair=replace(LAW, cohesion="sjkr")), "cohesion sjkr is known for spheres only"),
    (lambda: scene(bodies(), contact_point="gauge", pair=replace(LAW, curvature="mean", curvature_limit=2.0)), "with gauge the force would have no"),
])  # fmt: skip
def test_wrong_scenes_are_refused(wrong: object, said: str) -> None:
    """Law: a ValueError of one line before anything is compiled."""
    with pytest.raises(ValueError, match=said) as error:
        Simulation(wrong())  # type: ignore[operator]
    assert "\n" not in str(error.value)


def test_what_is_known_of_spheres_alone() -> None:
    """Law: limits of the step and sleep are of spheres on their own, and say so."""
    with pytest.raises(ValueError, match="the limits of a step are known for spheres on their own, not for superquadrics"):
        contacts_of(scene(bodies()))
    with pytest.raises(ValueError, match="superquadrics and clumps do not sleep"):
        Simulation(scene(bodies()), sleep=Sleep(1e-3))

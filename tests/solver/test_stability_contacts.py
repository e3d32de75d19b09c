"""Contacts as arrays: those of the plain Python reference, one by one; and how easily particles move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import Cylinder, Enforce2D, Freeze, NveSphere, Plane, Scene, SetForce, Slab, Wall, reference
from demsolver.stability import contact_limits
from demsolver.stability_contacts import PAIR, contacts_of, encounters, mobility
from demsolver.stability_packing import packing_limit
from demverify.stability.held import MASS, RADIUS, linear, on_floor
from tests.support.laws import every_law
from tests.support.scenes import cluster

WALLS = {
    "slab": Slab(1, 0.005, 0.045),
    "cylinder from inside": Cylinder(2, (0.025, 0.025), 0.03, "curved"),
    "cylinder from outside": Cylinder(0, (0.025, 0.025), 0.012, "curved"),
    "flat cylinder": Cylinder(1, (0.025, 0.025), 0.03),
    "plane": Plane((1.0, 2.0, -2.0), -0.01),
    "one-sided plane": Plane((1.0, 2.0, -2.0), -0.01, one_sided=True),
}


@pytest.mark.parametrize("shape", WALLS.values(), ids=WALLS)
@pytest.mark.parametrize("periodic", [False, True], ids=["open", "periodic"])
def test_contacts_are_those_of_the_reference(shape: Slab | Cylinder | Plane, periodic: bool) -> None:
    """Law: who touches whom, where, how deep, with which effective radius and mass: as demsolver.reference lists them; some frozen."""
    scene = cluster(np.random.default_rng(5), 40, size=0.06, periodic=periodic)
    p = replace(scene.particles, mask=np.where(np.arange(40) < 8, 3, 1))
    scene = replace(scene, particles=p, walls=(Wall("wall", shape, linear((1,))),), forces=(Freeze(1),))
    found = contacts_of(scene)
    states = encounters(scene, found.i, found.j, found.overlap, found.reff)
    ours = {
        (int(law), int(i), int(j)): (*n, *state[1:])
        for law, i, j, n, state in zip(found.law, found.i, found.j, found.n, states, strict=True)
    }
    theirs = {}
    for touch in reference.touches(scene, p.x, p.v, p.omega, {}):
        law, j = (PAIR, touch.partner) if touch.partner is not None else (0, -1)
        numbers = (touch.overlap, touch.radius, touch.partner_radius, touch.reff, touch.meff, touch.rolling_inertia)
        theirs[law, touch.i, j] = (*touch.n, *numbers)
    assert set(ours) == set(theirs)
    assert len(ours) > 15
    for key, numbers in ours.items():
        # positions of 0.1 and overlaps of 1e-4: 1e-13 of rounding
        assert numbers == pytest.approx(theirs[key], rel=1e-10, abs=1e-16)


def test_what_answers_to_a_force() -> None:
    """Law: not integrated, frozen: nothing. Force set: not those axes. Held in the plane: x, y and the spin about z. Inertia as integrated."""
    scene = on_floor(1e-6, linear((1,)))

    def of(*forces: object, inertia: float = 0.4, bit: int = 0) -> np.ndarray:
        found = mobility(replace(scene, forces=forces, integrate=(NveSphere(bit, inertia),)))  # type: ignore[arg-type]
        return np.concatenate([found.translation[0] * MASS, found.rotation[0] * MASS * RADIUS**2])

    assert of() == pytest.approx([1, 1, 1, 2.5, 2.5, 2.5])
    assert of(inertia=0.5) == pytest.approx([1, 1, 1, 2, 2, 2])
    assert not of(bit=1).any()
    assert not of(Freeze()).any()
    assert of(SetForce((0.0, None, 1.0))) == pytest.approx([0, 1, 0, 2.5, 2.5, 2.5])
    assert of(Enforce2D()) == pytest.approx([1, 1, 0, 0, 0, 2.5])


def points(scene: Scene) -> Scene:
    """The scene with particles of radius 0 among the others."""
    radius = scene.particles.radius.copy()
    radius[:5] = 0.0
    return replace(scene, particles=replace(scene.particles, radius=radius))


@pytest.mark.parametrize("seed", range(4))
def test_odd_scenes_have_limits_too(seed: int) -> None:
    """Law: points, no pair law, no particles, springs of no stiffness or of 1e308, speeds of 1e200: a number or inf, never NaN and never an error."""
    scene = cluster(np.random.default_rng(seed), 150 if seed % 2 else 24)  # solved by Lanczos iteration, or whole
    p = scene.particles
    nobody = replace(scene, particles=p.rows(np.arange(0)))
    soft, hard = (replace(scene, pair=every_law("normal", "hertz", values={"kn": kn}), walls=()) for kn in (0.0, 1e308))
    fast = replace(hard, particles=replace(p, v=1e200 * np.ones_like(p.v) * np.sign(p.v)))
    for each in (soft, hard, fast, points(scene), replace(scene, pair=None), replace(scene, walls=()), nobody):
        contacts = contacts_of(each)
        found = packing_limit(each, contacts)
        steps = [found.undamped, found.combined, *(limit.combined for limit in contact_limits(each, contacts))]
        assert not np.isnan(steps).any()
        assert min(steps) > 0.0

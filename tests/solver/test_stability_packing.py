"""The longest stable step of a packing: against closed forms, against the Jacobian of the forces, against simulations below and above."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demsolver import (
    Box,
    Freeze,
    Neighbor,
    NveSphere,
    Scene,
    Slab,
    Viscous,
    Wall,
    reference,
    stability_laws,
    stability_packing,
)
from demsolver.stability import combined_limit, contact_limits
from demsolver.stability_contacts import contacts_of
from demsolver.stability_packing import PackingLimit, buckling_rate, packing_bound, packing_limit
from demverify.stability.held import DISTURBANCE, KN, MASS, OVERLAP, RADIUS, growth, linear, on_floor, packing, pair, relaxed
from tests.support.laws import every_law
from tests.support.scenes import cluster, spheres


def limit(scene: Scene) -> PackingLimit:
    """Of the scene as it is."""
    return packing_limit(scene, contacts_of(scene))


LAWS = {
    "springs": {"mu": 0.0},
    "springs and dashpots": {"mu": 0.0, "gamman": 1500.0},
    "friction": {"kt": 2 / 7 * KN},
    "friction and dashpots": {"kt": 2 / 7 * KN, "gamman": 1500.0, "xt": 0.5},
}


@pytest.mark.parametrize(("n", "name"), [*((10, name) for name in LAWS), (1000, "springs"), (1000, "friction and dashpots")])
def test_a_packing_holds_below_its_limit_and_grows_above(n: int, name: str) -> None:
    """Law: the packing's limit to 1 %, where that of a single contact is a third to a half too long."""
    law = linear((1, 1), **LAWS[name])
    scene = packing(*relaxed(n), 1e-6, law)
    found = limit(scene)
    single = min(each.combined for each in contact_limits(scene, contacts_of(scene)))
    assert found.combined < 0.75 * single
    assert packing_bound(scene, contacts_of(scene)) < found.combined
    for part, grows in ((0.99, False), (1.01, True)):
        size = growth(packing(*relaxed(n), part * found.combined, law, DISTURBANCE), 400)
        # below: several modes near the limit swell 7 times at worst (test_stability.py), times K = 4
        assert size > 1e3 if grows else size < 60.0


def test_a_chain_between_walls_has_its_closed_form() -> None:
    """Law: n spheres and n + 1 springs: omega_max = 2 sqrt(k/m) sin(n pi/(2 n + 2)); walls are fixed."""
    n, law = 10, linear((1, 1), mu=0.0)
    gap = 2 * RADIUS - OVERLAP
    x = np.column_stack([RADIUS - OVERLAP + gap * np.arange(n), np.zeros(n), np.zeros(n)])
    end = 2 * (RADIUS - OVERLAP) + gap * (n - 1)
    walls = (Wall("ends", Slab(0, 0.0, end), linear((1,), mu=0.0)),)
    box = Box(np.full(3, -0.1), np.full(3, 0.2), ("ff", "ff", "ff"))
    scene = Scene(box, spheres(x, np.full(n, RADIUS)), 1, 1e-6, pair=law, walls=walls, integrate=(NveSphere(),), neighbor=Neighbor(1e-3))
    found = limit(scene)
    assert found.contacts == n + 1
    assert found.undamped == pytest.approx(np.sqrt(MASS / KN) / np.sin(n * np.pi / (2 * n + 2)), rel=1e-7)


@pytest.mark.parametrize("dense", [True, False], ids=["all eigenvalues", "Lanczos"])
def test_a_cubic_lattice_has_its_closed_form(dense: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: in a periodic cubic lattice planes swing against each other: omega_max = 2 sqrt(k/m), six springs k a sphere; images count."""
    monkeypatch.setattr(stability_packing, "DENSE", 10**9 if dense else 0)
    side, n = 2 * RADIUS - OVERLAP, 4
    x = side * (0.5 + np.stack(np.meshgrid(*[np.arange(n)] * 3), axis=-1).reshape(-1, 3))
    found = limit(packing(x, np.full(len(x), RADIUS), n * side, 1e-6, linear((1, 1), mu=0.0)))
    assert found.contacts == 3 * n**3
    # Lanczos stops at ROUGH = 1e-4 of the eigenvalue
    assert found.undamped == pytest.approx(np.sqrt(MASS / KN), rel=1e-7 if dense else 1e-4)


def test_the_stiffness_is_the_jacobian_of_the_forces() -> None:
    """Law: without friction omega_max^2 is the largest eigenvalue of -M^-1 dF/dx, differences of the plain Python forces; so the normal force that
    turns with its contact is in it (leaving that out is 5 % of the step here)."""
    scene = cluster(np.random.default_rng(2), 12, size=0.03, periodic=False)
    scene = replace(scene, pair=linear((1, 1), mu=0.0), walls=(replace(scene.walls[0], law=linear((1,), mu=0.0)),))
    x = scene.particles.x
    zero, h = np.zeros_like(x), 1e-8 * RADIUS

    def force(at: np.ndarray) -> np.ndarray:
        return reference.forces(scene, at, zero, zero, {}, advance=False)[0].ravel()

    columns = [(force(x + h * e) - force(x - h * e)) / (2 * h) for e in np.eye(x.size).reshape(-1, *x.shape)]
    weighted = -np.column_stack(columns) / np.repeat(scene.particles.mass, 3)[:, None]
    omega = np.sqrt(np.linalg.eigvals(weighted).real.max())
    # rounding of forces at distances of RADIUS: 1e-16/1e-8
    assert limit(scene).undamped == pytest.approx(2 / omega, rel=1e-6)


@pytest.mark.parametrize("settings", LAWS.values(), ids=LAWS)
def test_of_one_contact_it_is_the_limit_of_one_contact(settings: dict[str, float]) -> None:
    """Law: a packing of one pair has the pair's limits, with and without dampers; what is frozen does not move."""
    scene = replace(pair(1e-6, linear((1, 1), **settings)), walls=())
    for each in (scene, replace(scene, forces=(Freeze(2),))):
        limits = contact_limits(each, contacts_of(each))
        found = limit(each)
        # the pair's own tangential row lacks the normal force that turns with it: overlap/4R of the normal stiffness
        assert found.combined == pytest.approx(min(one.combined for one in limits), rel=2e-3)
        assert found.undamped == pytest.approx(min(one.spring for one in limits), rel=2e-3)


def test_drag_joins_the_dampers() -> None:
    """Law: C' holds the drag too: a sphere in a medium on two springs has 4 m/(gamma + sqrt(gamma^2 + 8 k m))."""
    law, wall = linear((1, 1), mu=0.0), linear((1,), mu=0.0)
    x = np.array([[0.0, 0.0, 0.0]])
    walls = (Wall("ends", Slab(0, lo=-RADIUS + OVERLAP), wall), Wall("other", Slab(0, hi=RADIUS - OVERLAP), wall))
    box = Box(np.full(3, -0.1), np.full(3, 0.1), ("ff", "ff", "ff"))
    drag = (Viscous(np.array([3.0])),)
    scene = Scene(box, spheres(x, np.array([RADIUS])), 1, 1e-6, pair=law, walls=walls, forces=drag, integrate=(NveSphere(),))
    assert limit(scene).combined == pytest.approx(combined_limit(MASS, 2 * KN, 3.0), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("family", "name"), [("normal", "hertz"), ("damping", "viscoelastic"), ("tangential_damping", "mass_radius"), ("rolling", "sds")]
)
def test_the_quick_bound_never_exceeds_the_limit(family: str, name: str, seed: int) -> None:
    """Law: a step below packing_bound is stable: on random heaps with a floor, periodic or not, of several laws."""
    scene = cluster(np.random.default_rng(seed), periodic=bool(seed % 2))
    scene = replace(scene, pair=every_law(family, name), walls=(replace(scene.walls[0], law=every_law(family, name, (1,))),))  # type: ignore[arg-type]
    contacts = contacts_of(scene)
    found = packing_limit(scene, contacts)
    assert 0.0 < packing_bound(scene, contacts) < found.combined
    assert found.combined <= found.undamped


def test_many_contacts_are_answered_by_compiled_laws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: compiled or not, the answers are the same."""
    scene = cluster(np.random.default_rng(1))
    plain = limit(scene)
    monkeypatch.setattr(stability_laws, "MANY", 1)
    compiled = limit(scene)
    # the difference of two forces amplifies the rounding of one by 1/SMALL
    assert (compiled.undamped, compiled.combined) == pytest.approx((plain.undamped, plain.combined), rel=1e-9)


def test_two_spheres_between_two_forces_buckle() -> None:
    """Law: a force F that turns with a contact of length L is a stiffness -F/L across it: rate sqrt(F/(L m*)); on a floor there is none."""
    scene = pair(1e-6, linear((1, 1), mu=0.0))
    rate = buckling_rate(scene, contacts_of(scene))
    assert rate == pytest.approx(np.sqrt(KN * OVERLAP / (2 * RADIUS - OVERLAP) / (0.5 * MASS)), rel=1e-6)
    floor = on_floor(1e-6, linear((1,), mu=0.0))
    assert buckling_rate(floor, contacts_of(floor)) == 0.0


def test_nothing_touching_limits_nothing() -> None:
    """Law: a packing without contacts has no limit, and no particles are no packing."""
    law = linear((1, 1))
    apart = packing(np.array([[0.01, 0.01, 0.01], [0.04, 0.04, 0.04]]), np.full(2, RADIUS), 0.1, 1e-6, law)
    nobody = packing(np.zeros((0, 3)), np.zeros(0), 0.1, 1e-6, law)
    for scene in (apart, nobody):
        assert limit(scene) == PackingLimit(0, np.inf, np.inf)
        assert packing_bound(scene, contacts_of(scene)) == np.inf

"""Principal axes as the engines find them, and the three ways to the inertia of a clump: given, of the union, of the sum of spheres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver.shapes.principal import first_quaternion, principal
from demsolver.shapes.rotation import matrix
from demsolver.shapes.union import sum_of_spheres, union
from demverify.runs import plan
from tests.support.clump_decks import BODY, INPUTS, ran
from tests.support.clumps import CENTRE, RADIUS, turned

DECK = INPUTS / "clump-bounce" / "in.liggghts"


def tensor_of(seed: int, moments: tuple[float, ...]) -> np.ndarray:
    axes = turned(np.random.default_rng(seed))
    return np.asarray(axes @ np.diag(moments) @ axes.T)


tensors = st.builds(tensor_of, st.integers(0, 2**32 - 1), st.tuples(*(st.sampled_from((1.0, 1.0 + 1e-9, 1.4, 2.0)) for _ in range(3))))


@settings(max_examples=200, deadline=None)
@given(tensors, st.booleans())
def test_axes_make_the_tensor(tensor: np.ndarray, ascending: bool) -> None:
    """Law: R diag(I) R^T is the tensor, R is a rotation, right-handed; LAMMPS' moments ascend; the quaternion is R's, one part above 0."""
    tensor = 0.5 * (tensor + tensor.T)
    moments, axes = principal(tensor, ascending=ascending)
    assert np.abs(axes @ np.diag(moments) @ axes.T - tensor).max() < (3e-13 if ascending else 1e-14)  # LAMMPS leaves a thousand roundings
    assert np.abs(axes.T @ axes - np.eye(3)).max() < 1e-15 * 10
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-14)
    if ascending:
        assert (np.diff(moments) >= 0.0).all()
    quat = first_quaternion(axes)
    assert np.abs(matrix(quat[None])[0] - axes).max() < 1e-14
    assert np.linalg.norm(quat) == pytest.approx(1.0, abs=1e-15)
    assert quat[int(np.argmax(quat**2 >= 0.25 - 1e-12))] > 0.0


@given(st.permutations([1.0, 2.0, 3.0]))
def test_a_diagonal_tensor(moments: list[float]) -> None:
    """Law: LIGGGHTS leaves the axes of a diagonal tensor as they are, LAMMPS sorts them, right-handed."""
    found, axes = principal(np.diag(moments), ascending=False)
    assert (found == moments).all()
    assert (axes == np.eye(3)).all()
    found, axes = principal(np.diag(moments), ascending=True)
    assert (found == [1.0, 2.0, 3.0]).all()
    assert np.linalg.det(axes) == 1.0


@pytest.mark.lammps
def test_axes_and_quaternions_of_lammps(tmp_path: Path) -> None:
    """Law: from the spheres that LAMMPS dumps, moments, axes and quaternion of two placings are those of its compute rigid/local to 1e-13."""
    run = ran("clump-collision", "lammps", tmp_path, every=1, steps=0)
    for k in range(2):
        own = slice(4 * k, 4 * k + 4)
        x, mass, radius, body = run.members[0]["x"][own], run.members[0]["mass"][own], run.members[0]["radius"][own], run.bodies[0][k]
        arms = x - mass @ x / mass.sum()
        tensor = sum(m * ((0.4 * r * r + a @ a) * np.eye(3) - np.outer(a, a)) for m, r, a in zip(mass, radius, arms, strict=True))
        moments, axes = principal(np.asarray(tensor), ascending=True)
        assert np.abs(moments / body[BODY["inertia"]] - 1.0).max() < 1e-13
        assert np.abs(first_quaternion(axes) - body[BODY["quat"]]).max() < 1e-13


@pytest.mark.liggghts
def test_axes_and_quaternions_of_liggghts(tmp_path: Path) -> None:
    """Law: of the tensor that is given in the deck, turned by the orientation, LIGGGHTS' moments, unsorted, and quaternions come out to 1e-13."""
    run = ran("clump-collision", "liggghts", tmp_path, every=1, steps=0)
    words = (INPUTS / "clump-collision" / "in.liggghts").read_text().partition("inertia_tensor &")[2].split()[:6]
    xx, xy, xz, yy, yz, zz = map(float, words)
    moments, axes = principal(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), ascending=False)
    for k, quat in enumerate(([0.5, 0.5, -0.5, 0.5], [0.6, 0.0, 0.8, 0.0])):
        assert np.abs(moments / run.bodies[0][k, BODY["inertia"]] - 1.0).max() < 1e-13
        assert np.abs(first_quaternion(matrix(np.array([quat]))[0] @ axes) - run.bodies[0][k, BODY["quat"]]).max() < 1e-13


def moments_of(deck: Path) -> tuple[float, np.ndarray]:
    clumps = plan(deck, {}).runs[-1].scene.particles.clumps
    assert clumps is not None
    return float(clumps.mass[0]), np.sort(clumps.inertia[0])


def test_inertia_three_ways(tmp_path: Path) -> None:
    """Law: LIGGGHTS' clump has the mass and tensor it is given, else the exact ones of the union; LAMMPS' the sums over spheres."""
    summed, whole = sum_of_spheres(CENTRE, RADIUS), union(CENTRE, RADIUS)
    text = DECK.read_text()
    for name in ("clump.ms", "clump.mol"):
        (tmp_path / name).write_text((DECK.parent / name).read_text())
    start, end = text.index("mass 0.0027"), text.index("\n", text.index("use_density inertia_tensor &") + 40)
    (tmp_path / "in.liggghts").write_text(text[:start] + text[end:])
    (tmp_path / "in.lammps").write_text((DECK.parent / "in.lammps").read_text())
    for deck, solid in ((DECK, summed), (tmp_path / "in.lammps", summed), (tmp_path / "in.liggghts", whole)):
        mass, moments = moments_of(deck)
        assert mass == pytest.approx(2500.0 * solid.volume, rel=1e-12)
        assert np.abs(moments / (2500.0 * np.linalg.eigvalsh(solid.inertia)) - 1.0).max() < 1e-11
    assert summed.volume > 1.05 * whole.volume

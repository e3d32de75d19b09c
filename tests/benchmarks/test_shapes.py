"""The benchmark of superquadrics and clumps: its scenes can run, with and without each other's bodies, and it says so where a promise is broken."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import shapes
from demsolver.check import check_scene


def test_nothing_overlaps_at_the_start() -> None:
    """Law: bounding spheres of the bodies stand apart, and inside the walls."""
    for scene in (shapes.box(60), shapes.spheres(20, clumped=False)):
        check_scene(scene)
        p = scene.particles
        apart = np.linalg.norm(p.x[:, None] - p.x, axis=2) - (p.radius[:, None] + p.radius)
        assert apart[~np.eye(len(p.id), dtype=bool)].min() > 0.0
        assert (p.x - p.radius[:, None]).min() > 0.0


def test_clumps_and_spheres_are_as_many() -> None:
    """Law: the same spheres, in clumps of four or free."""
    clumped, free = (shapes.spheres(20, clumped=one).particles for one in (True, False))
    assert clumped.clumps is not None
    assert free.clumps is None
    assert np.array_equal(clumped.radius, free.radius)
    assert np.array_equal(clumped.mass, free.mass)
    assert np.bincount(clumped.clumps.body).tolist() == [4] * 20
    assert clumped.clumps.mass == pytest.approx(np.bincount(clumped.clumps.body, clumped.mass))


def test_a_broken_promise_is_the_status(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: status 1 where a native step takes longer than LIGGGHTS' in proportion, or members are slower than 0.7 of spheres; else 0."""
    for proportion, rate, status in ((0.9, 0.8, 0), (1.1, 0.8, 1), (0.9, 0.6, 1)):
        monkeypatch.setattr(shapes, "_dense", lambda rounds, found=proportion: {"dense_proportion": found})
        monkeypatch.setattr(shapes, "_box", lambda *_: {})
        monkeypatch.setattr(shapes, "_clumps", lambda *_, found=rate: {"clump_rate": found})
        assert shapes.main([]) == status


@pytest.mark.slow
def test_all_of_it_in_small(capsys: pytest.CaptureFixture[str]) -> None:
    """Law: every part runs and prints its line."""
    shapes.main(["--quick"])
    said = capsys.readouterr().out
    assert "box: 100 superquadrics" in said
    assert "clumps: 400 members" in said

"""Planted defects: each can be planted, and the library sees them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.mutations import MUTATIONS, ROOT, found_by
from demverify.library import catalogue


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_defect_can_be_planted(name: str) -> None:
    """Law: what a mutation changes stands in the solver exactly once, and the cases that should see it are in the library."""
    mutation = MUTATIONS[name]
    assert (ROOT / "solver" / "demsolver" / mutation.file).read_text().count(mutation.old) == 1
    assert mutation.old != mutation.new
    assert catalogue(mutation.cases)


@pytest.mark.parametrize("name", ["reduced-mass", *(pytest.param(name, marks=pytest.mark.slow) for name in ("coulomb-limit", "reaction"))])
def test_closed_forms_see_a_defect(name: str, tmp_path: Path) -> None:
    """Law: in a solver with a planted defect native alone misses a closed form."""
    assert found_by(name, MUTATIONS[name], ("native",), tmp_path)


def test_nothing_is_seen_where_nothing_is_planted(tmp_path: Path) -> None:
    """Law (what must be rejected): the solver with an empty mutation meets every closed form."""
    mutation = MUTATIONS["reduced-mass"]
    assert found_by("none", replace(mutation, new=mutation.old), ("native",), tmp_path) == []

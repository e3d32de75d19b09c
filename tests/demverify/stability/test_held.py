"""The instrument of `demverify stability`: a disturbance grows as fast as the eigenvalues say, and a bisection finds where it begins to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from demsolver import Scene
from demsolver.stability import combined_limit
from demverify.stability.held import GROWN, INTEGRATORS, KN, MASS, OVERLAP, grown, linear, longest, pair, relaxed
from demverify.stability.limits import predicted, spectral_radius
from demverify.stability.limits_plane import at, inside


@pytest.mark.parametrize("integrator", INTEGRATORS)
@settings(max_examples=20, deadline=None)
@given(K=st.floats(0.1, 6.0), H=st.floats(0.0, 3.0))
@example(K=2.5, H=1.0)
def test_a_disturbance_grows_by_the_spectral_radius(integrator: str, K: float, H: float) -> None:
    """Law: below K + 2 H = 4 it holds; above, each step multiplies it by the larger |lambda|."""
    margin = 4.0 - K - 2.0 * H
    if abs(margin) < 0.05:  # nearer, 2,000 steps may not be enough to tell
        return
    scene = at(K, H, integrator)
    found = grown(scene)
    assert (found.size <= GROWN) == (margin > 0.0) == bool(inside(np.array(K), np.array(H)) > 0.0)
    if margin < 0.0 and found.size < np.inf:
        # what else the disturbance holds has not all died away after two steps
        assert found.each_step == pytest.approx(spectral_radius(predicted(scene, "normal", "wall"), scene.timestep), rel=0.25)


def spring(dt: float) -> Scene:
    """K = 1 at a step of 1e-4, so the limit is 2e-4."""
    return at(1.0, 0.0, "velocity Verlet", dt)


@pytest.mark.parametrize("guess", [1e-5, 1.9e-4, 3e-3])
def test_the_bisection_forgets_its_guess(guess: float) -> None:
    """Law: from a guess far off either way it finds the limit to the width asked for: dt = 2 sqrt(m/k)."""
    found = longest(spring, guess, to=2e-3)
    assert found.holds < found.step < found.grows <= 1.002 * found.holds
    assert found.step == pytest.approx(2e-4, rel=2e-3)
    assert (np.diff(found.runs[:, 0]) > 0.0).all()


def test_what_never_breaks_or_always_does_is_said() -> None:
    """Law: no limit within a factor of a thousand of the guess is an error, not a number."""
    with pytest.raises(ValueError, match="still holds"):
        longest(lambda dt: spring(1e-5), 1e-4, to=1e-2)
    with pytest.raises(ValueError, match="still grows"):
        longest(lambda dt: spring(4e-4), 1e-4, to=1e-2)


def test_a_row_that_buckles_is_no_growth_of_swings() -> None:
    """Law: two spheres pressed together by forces of fixed direction buckle at any step: forces change a thousandfold, not from step to step; beyond
    the limit of the spring these do, buckling or not."""
    law = linear((1, 1), mu=0.0)
    limit = combined_limit(0.5 * MASS, KN, 0.0)
    holds, grows = (pair(part * limit, law, along=1e-5 * OVERLAP / limit, across=1e-5 * OVERLAP / limit) for part in (0.98, 1.02))
    assert grown(holds).size > GROWN
    assert grown(holds, swings_only=True).size < GROWN < grown(grows, swings_only=True).size


def test_a_packing_is_at_rest() -> None:
    """Law: relaxed spheres touch, and stay where they are: positions are the same every time they are asked for."""
    x, radius, size = relaxed(10)
    assert x is relaxed(10)[0]
    assert len(x) == len(radius) == 10
    assert ((x >= 0.0) & (x <= size)).all()

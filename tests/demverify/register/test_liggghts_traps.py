"""Register entries on what surprises a DEM user of LIGGGHTS around the contact laws."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.decks import Ball, Material, liggghts_deck, simulate_liggghts
from tests.support.deviations import assert_deviates
from tests.support.engines import require_liggghts, run_liggghts, run_raw

pytestmark = pytest.mark.liggghts

BALL = Ball((0.0, 0.0, 0.0), omega=(1.0, 2.0, 3.0))
SOFT = Material(1, {"kn": 1e4, "kt": 1e4, "gamman": 1.0, "gammat": 1.0, "coefficientFriction": 0.5})
ELASTIC = {"youngsModulus": 5e6, "poissonsRatio": 0.3, "coefficientRestitution": 0.5, "coefficientFriction": 0.5}
PAIR = "pair_style gran model hooke/stiffness\npair_coeff * *\n"


def refusal(entry: str, material: Material, body: str, folder: Path) -> str:
    """The log of a deck that LIGGGHTS must refuse."""
    run = run_liggghts(liggghts_deck([BALL], material, body, folder), folder, may_fail=True)
    assert run.code, f"register entry {entry} is out of date: LIGGGHTS runs the deck"
    return run.log


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("youngsModulus", 4.9e6, "youngsModulus >= 5e6 required"),
        ("coefficientRestitution", 0.05, "0.05 < coefficientRestitution"),
    ],
)
def test_sane_limits_on_materials(name: str, value: float, said: str, tmp_path: Path) -> None:
    """Law: any positive modulus and any restitution up to 1 is a material. LIGGGHTS draws its own lines, at 5e6 Pa and 0.05."""
    body = "pair_style gran model hertz\npair_coeff * *\nrun 0"
    simulate_liggghts([BALL], Material(1, ELASTIC | {"coefficientRestitution": 0.051}), body, tmp_path / "allowed")
    assert said in refusal("liggghts-material-limits", Material(1, ELASTIC | {name: value}), body, tmp_path / "refused")


def test_erotate_chats_and_equals_erotate_sphere(tmp_path: Path) -> None:
    """Law: for free spheres both computes are 1/2 (2/5 m R^2) w^2. `compute erotate` prints a debugging line besides."""
    body = f"{PAIR}compute a all erotate\ncompute b all erotate/sphere\nthermo_style custom step c_a c_b\nrun 0"
    run = simulate_liggghts([BALL], SOFT, body + "\n", tmp_path)
    columns = run.frame(0).columns
    expected = 0.2 * columns["mass"][0] * columns["radius"][0] ** 2 * (1 + 4 + 9)
    assert run.thermo[0].values[0, 1:] == pytest.approx([expected, expected], rel=1e-7)
    assert "igrpu: all" in run.log.splitlines(), "register entry liggghts-erotate-chats is out of date"


def test_error_of_one_process_is_lost_in_a_pipe(tmp_path: Path) -> None:
    """Law: a program that stops says why. Into a pipe LIGGGHTS does so only when its output is line buffered (stdbuf -oL)."""
    require_liggghts()
    (tmp_path / "in.deck").write_text("atom_style granular\nread_data no-such-file\n")
    engine = ["liggghts", "-in", "in.deck"]
    assert "Cannot open file no-such-file" in run_raw(["stdbuf", "-oL", *engine], tmp_path)[1]
    code, text = run_raw(engine, tmp_path)
    assert code
    assert "no-such-file" not in text + (tmp_path / "log.liggghts").read_text(), (
        "register entry liggghts-error-lost is out of date"
    )


def test_compressed_dumps_fail(tmp_path: Path) -> None:
    """Law: `dump custom ... file.gz` writes a compressed dump (LAMMPS does). Debian's LIGGGHTS stops."""
    assert "Cannot open gzipped file" in refusal(
        "liggghts-dump-gz", SOFT, f"{PAIR}dump z all custom 1 out.gz id x\nrun 0", tmp_path
    )


def test_no_superquadrics(tmp_path: Path) -> None:
    """Law: the manual's `atom_style superquadric` exists. Debian builds without it."""
    run = run_liggghts("atom_style superquadric\n", tmp_path, may_fail=True)
    assert "Invalid atom style" in run.log, "register entry liggghts-no-superquadric is out of date"


def test_dumped_box_has_six_digits(tmp_path: Path) -> None:
    """Law: a dump says how large the box is; a periodic distance needs every digit. LIGGGHTS writes the bounds with %g."""
    size = 1.23456789
    deck = liggghts_deck([BALL], SOFT, f"{PAIR}run 0", tmp_path)
    data = tmp_path / "data.spheres"
    data.write_text(data.read_text().replace("-1.0 1.0 xlo xhi", f"-1.0 {size!r} xlo xhi"))
    box = run_liggghts(deck, tmp_path).frame(0).box
    assert_deviates("liggghts-dump-bounds", box[0, 1], engine_rule=float(f"{size:g}"), law=size, rtol=1e-12)

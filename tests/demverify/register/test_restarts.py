"""Register entries on what the engines lose in a restart file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.decks import COLUMNS, Ball, Material, lammps_deck, liggghts_deck
from tests.support.deviations import assert_deviates
from tests.support.engines import run_lammps, run_liggghts

BALLS = [
    Ball((-0.00499, 0.0, 0.0), v=(0.05, 0.0, 0.0), omega=(0.0, 0.0, 30.0), radius=0.005),
    Ball((0.00499, 0.0005, 0.0), v=(-0.05, 0.0, 0.0), radius=0.005),
]
GRANULAR = "pair_style granular\npair_coeff * * hooke 1e4 100 tangential linear_history 7e3 1.0 0.5 damping mass_velocity\n"
LEGACY = "pair_style gran/hooke/history 1e4 7e3 100 100 0.5 1\npair_coeff * *\n"
GRAN = "pair_style gran model hooke/stiffness tangential history\npair_coeff * *\n"
SOFT = Material(1, {"kn": 1e4, "kt": 7e3, "gamman": 100.0, "gammat": 100.0, "coefficientFriction": 0.5})
MOVE = "neighbor 0.002 bin\nneigh_modify delay 0\nfix move all nve/sphere\n"
DUMP = f"dump e all custom 1 zz.dump {COLUMNS}\ndump_modify e sort id first yes "
LAMMPS_AGAIN = "newton {}\nread_restart state\ncomm_modify vel yes\n"
LIGGGHTS_AGAIN = "atom_style granular\natom_modify map array\nnewton off\ncommunicate single vel yes\nread_restart state\n"


def friction(frames, step: int) -> float:
    """Force on the first ball along y in the last frame of a step."""
    return next(frame for frame in reversed(frames) if frame.step == step).columns["fy"][0]


def lammps(folder: Path, pair: str, rest: str, newton: str = "off") -> float:
    """Friction at step 200, right after the restart (or the second `run`)."""
    body = f"{pair}fix move all nve/sphere\nrun 200\nundump d\n{rest}{DUMP}format float %.17g\nrun 1\n"
    deck = lammps_deck(BALLS, body, folder).replace("newton off", f"newton {newton}")
    return friction(run_lammps(deck, folder).frames, 200)


@pytest.mark.lammps
def test_lammps_restores_the_pair_style_without_a_cutoff(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: a contact that was there before the restart is there after it. In LAMMPS what the memory held decides: a cutoff of -1e303, 0 or
    1e306, as glibc's MALLOC_PERTURB_ (complement of each fresh byte) fills it."""
    restored = "write_restart state\nclear\n" + LAMMPS_AGAIN.format("off") + "{}" + MOVE
    law = lammps(tmp_path / "law", GRANULAR, "")
    for byte, forgotten in (("1", law), ("255", 0.0), ("128", None)):
        monkeypatch.setenv("MALLOC_PERTURB_", byte)
        assert lammps(tmp_path / f"stated-{byte}", GRANULAR, restored.format(GRANULAR)) == law
        if forgotten is not None:
            measured = lammps(tmp_path / f"restored-{byte}", GRANULAR, restored.format(""))
            assert measured == forgotten, "register entry lammps-restart-no-cutoff is out of date"
            continue
        with pytest.raises(pytest.fail.Exception, match="Cannot use neighbor bins"):
            lammps(tmp_path / f"restored-{byte}", GRANULAR, restored.format(""))


@pytest.mark.lammps
def test_lammps_legacy_pairs_lose_their_springs_after_clear(tmp_path: Path) -> None:
    """Law: the spring along the surface is there after the restart. LAMMPS begins it anew in the process that wrote it, not in another."""
    law = lammps(tmp_path / "law", LEGACY, "")
    measured = lammps(tmp_path / "cleared", LEGACY, "write_restart state\nclear\n" + LAMMPS_AGAIN.format("off") + LEGACY + MOVE)
    forgotten = lammps(tmp_path / "forgotten", LEGACY, GRANULAR + "run 0\n" + LEGACY)
    assert_deviates("lammps-restart-legacy-history", measured, engine_rule=forgotten, law=law, rtol=1e-12)
    other = tmp_path / "other"
    other.mkdir()
    (other / "state").write_bytes((tmp_path / "cleared" / "state").read_bytes())
    deck = LAMMPS_AGAIN.format("off") + LEGACY + MOVE + DUMP + "format float %.17g\nrun 1\n"
    assert friction(run_lammps(deck, other).frames, 200) == law


@pytest.mark.liggghts
def test_liggghts_restored_pair_style_slips_differently(tmp_path: Path) -> None:
    """Law: with its pair style back the motion is the one without a restart. LIGGGHTS' parts from it at the first slip."""
    moved = {}
    for name, rest in {
        "law": "",
        "stated": "write_restart state\nclear\n" + LIGGGHTS_AGAIN + SOFT.lines() + "\n" + GRAN + MOVE + "timestep 1e-6\n",
        "restored": "write_restart state\nclear\n" + LIGGGHTS_AGAIN + SOFT.lines() + "\n" + MOVE + "timestep 1e-6\n",
    }.items():
        form = 'format "%d %d' + " %.17g" * (len(COLUMNS.split()) - 2) + '"'
        body = f"{GRAN}fix move all nve/sphere\nrun 200\nundump d\n{rest}{DUMP}{form}\nrun 200\n"
        frames = run_liggghts(liggghts_deck(BALLS, SOFT, body, tmp_path / name), tmp_path / name).frames
        moved[name] = np.array([frame.columns["fy"][0] for frame in frames if frame.step >= 201])
    assert np.array_equal(moved["stated"], moved["law"])
    apart = np.abs(moved["restored"] - moved["law"]) / np.abs(moved["law"]).max()
    assert apart[:50].max() == 0.0
    assert apart.max() > 1e-3, "register entry liggghts-restart-pair-style is out of date"

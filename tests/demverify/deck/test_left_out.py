"""Commands that only watch are read, noted and left out: they cannot change the physics."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from demverify.deck.interpreter import Interpreter
from demverify.errors import InputError

Run = Callable[..., Interpreter]
BOX = "units si\natom_style sphere\nregion r block 0 1 0 1 0 1\ncreate_box 1 r\n"


def test_dumps_of_other_styles_are_left_out(run_deck: Run) -> None:
    """A VTK dump of LIGGGHTS changes no particle: it and what modifies or ends it are noted, and the log says so."""
    deck = run_deck(f"{BOX}dump d all custom/vtk 10 post/d*.vtk id type\ndump_modify d pad 5\nundump d\n")
    assert [line.words[0] for line in deck.ignored][-3:] == ["dump", "dump_modify", "undump"]
    assert not deck.setup.dumps
    assert any("dump d of style custom/vtk is left out" in line for line in deck.printed)


def test_a_style_that_no_engine_has_is_refused(run_deck: Run) -> None:
    """A misspelt dump style is an error, not a dump that is missing later."""
    with pytest.raises(InputError, match="style 'custom/vkt' is not one of custom, atom"):
        run_deck(f"{BOX}dump d all custom/vkt 10 d*.vtk id\n")


def test_fixes_that_average_are_left_out(run_deck: Run) -> None:
    """fix ave/time watches: it is noted, and unfix finds it."""
    deck = run_deck(f"{BOX}fix a all ave/time 1 1 10 c_1 file f\nunfix a\n")
    assert not deck.setup.fixes


def test_an_unknown_fix_is_named_before_the_missing_box(run_deck: Run) -> None:
    """Of a fix that stands before the box and is not supported, the style is the message: a box would not help."""
    with pytest.raises(InputError, match="fix style 'langevin' is not one of"):
        run_deck("atom_style sphere\nfix 1 all langevin 1 1 1 1\n")


def test_a_packed_data_file_is_hinted_at(run_deck: Run, tmp_path: Path) -> None:
    """LAMMPS does not look for x.gz when x is missing (22 July 2025, measured); the message says that it is there."""
    (tmp_path / "x.data.gz").write_bytes(b"")
    with pytest.raises(InputError, match=r"does not exist.*; x\.data\.gz does: unpack it"):
        run_deck("atom_style sphere\nread_data x.data\n")

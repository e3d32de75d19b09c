"""A deck with words or lines lost, doubled, swapped or put in: it is read, or refused in one line; nothing else comes out of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from demverify.deck import interpreter
from demverify.deck.convert import conversion
from demverify.errors import InputError
from demverify.runs import plan
from tests.support.cli import deck

MORE = """region half block 0 INF INF INF INF INF units box
group right region half
lattice sc 0.02
variable n index 3 4
variable k loop 2
variable e equal 0.5*v_k+step
fix down all gravity 9.81 vector 0 0 -1
fix floor all wall/gran {wall}
neigh_modify delay 0 exclude type 1 1
dump_modify frames sort id format {format} every 5
thermo_modify lost ignore norm no format float %.9g
if "${{n}} == 3" then "print '${{e}}'" else "timestep 2e-6"
label again
run ${{n}} upto
next k
jump SELF again
undump frames
unfix down
run 3
"""
LIGGGHTS = """units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05 units box
create_box 1 box
create_atoms 1 single -0.0051 0.0 0.0 units box
create_atoms 1 single 0.0051 0.002 0.0 units box
set group all diameter 0.01 density 2500.0
set atom 1 vx 0.5 vy 0.1
hard_particles yes
fix young all property/global youngsModulus peratomtype 1.0e7
fix poisson all property/global poissonsRatio peratomtype 0.3
fix rest all property/global coefficientRestitution peratomtypepair 1 0.8
fix mu all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran model hertz tangential history
pair_coeff * *
neighbor 0.002 bin
timestep 1.0e-6
fix move all nve/sphere
compute rot all erotate/sphere
thermo_style custom step atoms ke c_rot
thermo 10
dump frames all custom 10 frames.dump id x y z vx omegaz radius mass
"""
DECKS = {
    "lammps": deck(run=MORE.format(wall="hooke/history 1e4 3e3 500 200 0.5 1 zplane -0.05 NULL", format="float %.9g")),
    "liggghts": LIGGGHTS + MORE.format(wall="model hertz tangential history primitive type 1 zplane -0.05", format="'%d %g %g %g %g %g %g %g'"),
}
TOKENS = [
    "0", "1", "-1", "2", "1.5", "1e300", "-1e-300", "nan", "inf", "INF", "EDGE", "NULL", "*", "*2", "2*", "1*1", ":", "1:", "²",
    "1_0", "0x10", "99999999999999999999", "all", "half", "right", "units", "box", "x", "z", "vx", "v_e", "v_no", "c_rot",
    "c_rot[1]", "f_down", "${n}", "${no}", "$n", "$", "${", "$(", "$(1/0)", "$(step)", "$(v_e:%d)", "'", '"', '"""', "#", "&",
    "%d", "%s", "%.3f", "yes", "no", "off", "id", "none", "run", "fix", "set", "group", "region", "variable", "model", "history",
    "custom", "include", "zplane", "scale", "basis", "1", "then", "else", "loop", "equal", "é", "٣",
]  # fmt: skip


Change = tuple[str, int, int, str]


def mutations() -> st.SearchStrategy[list[Change]]:
    """Up to four changes: (what, where, where else, token); the places are taken modulo what there is."""
    place = st.integers(0, 500)
    what = st.sampled_from(["drop", "double", "swap", "insert", "replace", "drop line", "double line", "swap lines", "cut"])
    return st.lists(st.tuples(what, place, place, st.sampled_from(TOKENS)), min_size=1, max_size=4)


def mutated(text: str, changes: list[Change]) -> str:
    """The deck with the changes made, one after the other."""
    lines = [line.split(" ") for line in text.splitlines()]
    for what, first, second, token in changes:
        if "line" in what:
            _change(lines, what, first, second, [token])
        elif lines:
            _change(lines[first % len(lines)], what, second, 0, token)
    return "\n".join(" ".join(line) for line in lines)


def _change(items: list[Any], what: str, first: int, second: int, new: Any) -> None:
    if not items:
        return
    i, j = first % len(items), second % len(items)
    if what.startswith("drop"):
        del items[i]
    elif what.startswith("double"):
        items.insert(i, items[i])
    elif what.startswith("swap"):
        items[i], items[j] = items[j], items[i]
    elif what == "cut":
        del items[i:]
    else:
        items[i : i + (what == "replace")] = [new]


@pytest.mark.parametrize("dialect", DECKS)
@settings(max_examples=250, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=mutations())
@example(changes=[])
def test_a_mutated_deck_is_read_or_refused(dialect: str, changes: list[Change], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading, checking and converting raise InputError or nothing; the message is one line that names the deck."""
    monkeypatch.setattr(interpreter, "_MOST_COMMANDS", 200)  # the decks need 60; a lost `next` makes a loop without end
    path = tmp_path / f"in.{dialect}"
    path.write_text(mutated(DECKS[dialect], changes))
    try:
        known = plan(path, {})
        conversion(known, "liggghts" if dialect == "lammps" else "lammps", "data")
    except InputError as error:
        assert changes, error
        assert "\n" not in str(error)
        assert error.place is not None
        assert error.place.file == path


def test_the_mutations_reach_far(tmp_path: Path) -> None:
    """The unchanged decks are right, and make two runs and more: otherwise the fuzz would stop at their first line."""
    for dialect, text in DECKS.items():
        path = tmp_path / f"in.{dialect}"
        path.write_text(text)
        assert len(plan(path, {}).runs) == 3

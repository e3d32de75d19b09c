"""Control flow of a deck, and what the interpreter records."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from demverify.deck.dialects import detect_dialect
from demverify.deck.dry import DryBackend
from demverify.deck.interpreter import Interpreter
from demverify.errors import InputError

Run = Callable[..., Interpreter]
BOX = "units si\nboundary f f f\nregion b block 0 1 0 1 0 1 units box\ncreate_box 2 b\n"


@pytest.mark.parametrize(
    ("deck", "printed"),
    [
        ("variable i loop 3\nlabel l\nprint $i\nnext i\njump SELF l\nprint done", ["1", "2", "3", "done"]),
        (
            "variable a index 1 2 2\nlabel l\nif '$a == 2' then 'jump SELF z'\nprint $a\nnext a\njump SELF l\nlabel z\nprint $a!",
            ["1", "2!"],
        ),
        ("if '1 == 2' then 'print x' elif 2==2 'print y' 'print z' else 'print w'", ["y", "z"]),
        ("if '1 == 2' then 'print x' elif 2==3 'print y' else 'print w'", ["w"]),
        ("if '1 == 2' then 'print x'\nprint after", ["after"]),
        ("variable a index 3\nif '$a > 2 && hooke == hooke' then 'print no'", None),
        ("variable a index 3\nif '${a} > 2' then 'variable b index 7' 'print ${b}'", ["7"]),
        ("print 'a ${q}' screen no\nprint one\nquit\nprint two", None),
        ("print one\nif 1 then quit\nprint two", ["one"]),
        ("include part.x\nprint after", ["included", "after"]),
        ("if 1 then 'include part.x' 'print then'\nprint after", ["included", "then", "after"]),
        ("jump other.x there\nprint never", ["there"]),
    ],
)
def test_control_flow(deck: str, printed: list[str] | None, run_deck: Run) -> None:
    """Loops, conditions, includes and jumps run what the engines run."""
    files = {"part__x": "print included\n", "other__x": "print first\nlabel there\nprint there\n"}
    if printed is None:
        with pytest.raises(InputError):
            run_deck(deck, **files)
    else:
        assert run_deck(deck, **files).printed == printed


@pytest.mark.parametrize(("dialect", "printed"), [("lammps", "2"), ("liggghts", "$(1+1)")])
def test_quoted_strings_are_replaced_by_lammps_only(dialect: str, printed: str, run_deck: Run) -> None:
    """LAMMPS replaces variables in a quoted string variable when it is defined, LIGGGHTS never (both measured)."""
    assert run_deck("variable a string '$(1+1)'\nprint '${a}'", dialect).printed == [printed]


def test_strings_are_compared_by_lammps_only(run_deck: Run) -> None:
    """Law (what must be rejected): a LIGGGHTS deck that compares strings is refused with its line, as by LIGGGHTS; in LAMMPS it runs."""
    deck = "variable m string hooke\nif '${m} == hooke' then 'print one'"
    assert run_deck(deck, "lammps").printed == ["one"]
    with pytest.raises(InputError, match=r":2: condition 'hooke == hooke': LIGGGHTS compares numbers only, not strings such as 'hooke'"):
        run_deck(deck, "liggghts")
    assert run_deck("variable n index 2\nif '${n} == 2.0' then 'print two'", "liggghts").printed == ["two"]


def test_executed_holds_the_unrolled_deck(run_deck: Run) -> None:
    """Substituted commands in order, each with the place it was written; steering commands are left out."""
    deck = run_deck(
        "variable i loop 2\nlabel l\nprint '$i' # x\ntimestep 1e-$i\nnext i\njump SELF l\ninclude p.x\n", p__x="\nthermo 5\n"
    )
    assert [line.text for line in deck.executed] == [
        "variable i loop 2",
        "print '$i'",
        "timestep 1e-1",
        "print '$i'",
        "timestep 1e-2",
        "thermo 5",
    ]
    assert [(line.place.file.name, line.place.line) for line in deck.executed[-2:]] == [("in.deck", 4), ("p.x", 2)]


def test_ignored_lists_what_cannot_change_the_physics(run_deck: Run) -> None:
    """Such commands are accepted and reported, not silently dropped."""
    deck = run_deck(
        BOX + "echo both\nprocessors 1 1 *\ncomm_modify vel yes\nneigh_modify one 5000\nfix a all ave/time 1 1 1 c_1\nunfix a\n"
    )
    assert [line.words[0] for line in deck.ignored] == ["echo", "processors", "comm_modify", "neigh_modify", "fix", "unfix"]
    assert not deck.setup.fixes


def test_runs_are_recorded_with_copies(run_deck: Run) -> None:
    """Each run keeps the setup it started from; later commands do not reach it."""
    deck = run_deck(BOX + "timestep 0.5\nthermo 10\nrun 4\nthermo 20\nset_it 1\n".replace("set_it 1\n", "run 6\nrun 15 upto\n"))
    backend = deck.backend
    assert isinstance(backend, DryBackend)
    assert [(r.steps, r.setup.step, r.setup.time, r.setup.thermo.every) for r in backend.runs] == [
        (4, 0, 0.0, 10),
        (6, 4, 2.0, 20),
        (5, 10, 5.0, 20),
    ]


def test_static_values_in_formulas(run_deck: Run) -> None:
    """Box, counts, masses, centres and single particles are known without a run."""
    deck = run_deck(
        BOX
        + "create_atoms 1 single 0.25 0.5 0.5 units box\ncreate_atoms 2 single 0.75 0.5 0.5 units box\n"
        + "set atom 1 mass 1 vx 2\nset atom 2 mass 3\ngroup two type 2\n"
        + "print '$(vol) $(lx) $(xhi) $(count(two)) $(mass(all)) $(xcm(all,x)) $(vcm(all,x)) $(ke(all)) $(x[2])'\n"
        + "print '$(bound(two,xmin))'\n"
        + "timestep 0.5\nreset_timestep 8\nprint '$(step) $(dt) $(time) $(atoms)'"
    )
    assert deck.printed == ["1 1 1 1 4 0.625 0.5 2 0.75", "0.75", "8 0.5 4 2"]


def test_after_a_dry_run_moving_values_are_refused(run_deck: Run) -> None:
    """Nothing is made up: counts stay known, positions do not."""
    start = BOX + "create_atoms 1 single 0.25 0.5 0.5 units box\nrun 10\n"
    assert run_deck(start + "print '$(step) $(count(all)) $(mass(all):%.3f)'").printed == ["10 1 0.524"]
    with pytest.raises(InputError, match=r"in.deck:7: the formula needs x\[1\], which only a run gives"):
        run_deck(start + "print '$(x[1])'")


@pytest.mark.parametrize(
    ("name", "text", "dialect"),
    [
        ("in.liggghts", "units si\n", "liggghts"),
        ("in.chute.liggghts", "units si\n", "liggghts"),
        ("in.lammps", "communicate single vel yes\n", "lammps"),
        ("in.a", "atom_style granular\n", "liggghts"),
        ("in.insert_property_lammps", "atom_style granular\n", "liggghts"),
        ("in.a", "units si\npair_style gran model hertz\n", "liggghts"),
        ("in.a", "fix m all property/global kn peratomtypepair 1 5\n", "liggghts"),
        ("in.a", "fix m all wall/gran model hertz primitive type 1 zplane 0\n", "liggghts"),
        ("in.a", "pair_style gran/hooke/history 1 NULL 1 NULL 0.5 0\n", "lammps"),
        ("in.a", "# atom_style granular\natom_style sphere\n", "lammps"),
    ],
)
def test_dialect(name: str, text: str, dialect: str, tmp_path: Path) -> None:
    """The file's name decides, else words only LIGGGHTS knows."""
    path = tmp_path / name
    path.write_text(text)
    assert detect_dialect(path) == dialect


def test_an_endless_jump_ends(run_deck: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop without an exit is an error, not a hang."""
    monkeypatch.setattr("demverify.deck.interpreter._MOST_COMMANDS", 1000)
    with pytest.raises(InputError, match="ran 1000 commands without coming to an end"):
        run_deck("label l\njump SELF l\n")


def test_includes_that_never_end_are_refused(run_deck: Run) -> None:
    """A file that includes itself."""
    with pytest.raises(InputError, match="more than 16 files include each other"):
        run_deck("include in.deck\n")

"""A deck as a dictionary: columns, settings, and how a deck is read that is not executed."""

from __future__ import annotations

from pathlib import Path

import pytest

from demverify.analysis.meanings import DumpWords
from demverify.deck.dictionary import Dictionary, read_dictionary
from demverify.errors import InputError

ROOT = Path(__file__).parents[3]
DECKS = sorted([*ROOT.glob("inputs/*/in.*"), *ROOT.glob("tests/data/**/in.*")])
BOX = "region r block 0 1 0 1 0 1\ncreate_box 2 r\n"


@pytest.fixture
def told(tmp_path: Path):
    """told(text, name="in.lammps", variables=None, **files): the dictionary of a deck in a folder of its own."""

    def read(text: str, name: str = "in.lammps", variables: dict[str, list[str]] | None = None, **files: str) -> Dictionary:
        for file, content in files.items():
            (tmp_path / file.replace("__", ".")).write_text(content)
        (tmp_path / name).write_text(text)
        return read_dictionary(tmp_path / name, variables)

    return read


@pytest.mark.parametrize("path", DECKS, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_deck_of_the_project_is_read(path: Path) -> None:
    """Law: of decks that run, units and step are known, and nothing in them is beyond reading but densities that truly differ, or stand elsewhere."""
    found = read_dictionary(path)
    assert found.meanings.units is not None
    assert found.meanings.timestep is not None
    assert found.meanings.dialect == ("liggghts" if "communicate" in path.read_text() else "lammps")
    beyond = ("the density of", "molecules, whose densities stand elsewhere", "gives mass and inertia outright")
    assert all(any(words in note for words in beyond) for note in found.passed_over)


# ---- computes, variables and dumps -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("compute q all property/atom quatw quati quatj quatk", {f"c_q[{i}]": f"quat{i}" for i in (1, 2, 3, 4)}),
        ("compute 1 all property/atom mass", {"c_1": "mass"}),
        ("compute 1 all property/atom q d_mine shapez", {"c_1[3]": "shapez"}),
        ("compute 1 all property/atom angmomx tqy xu", {"c_1[1]": "angmomx", "c_1[2]": "tqy", "c_1[3]": "xu"}),
        ("compute b all rigid/local ms mol mass", {"c_b[1]": "id_multisphere", "c_b[2]": "masstotal"}),
        (
            "compute b all rigid/local ms id x vy omegaz angmomx quatk inertiaz",
            {"c_b[1]": "id_multisphere", "c_b[2]": "xcm[1]", "c_b[3]": "vcm[2]", "c_b[4]": "omega[3]"}
            | {"c_b[5]": "angmom[1]", "c_b[6]": "quat[4]", "c_b[7]": "inertia[3]"},
        ),
        ("compute b all multisphere property quat", {f"c_b[{i}]": f"quat[{i}]" for i in (1, 2, 3, 4)}),
        ("compute b all multisphere update_on_run_end yes property ex_space", {f"c_b[{i}]": f"ex_space[{i}]" for i in (1, 2, 3)}),
        ("compute b all multisphere property id_multisphere", {"c_b": "id_multisphere"}),
        ("compute 1 all ke/atom", {}),
        ("variable m atom mass", {"v_m": "mass"}),
        ('variable m atom "( omegax )"', {"v_m": "omegax"}),
        ("variable r atom r", {"v_r": "radius"}),
        ("variable e atom 0.5*mass*vx^2", {}),
        ("compute 1 all property/atom x mass\nvariable m atom c_1[2]", {"c_1[1]": "x", "c_1[2]": "mass", "v_m": "mass"}),
    ],
)
def test_columns_mean_what_their_compute_says(told, line: str, names: dict[str, str]) -> None:
    """Law: each column of a compute of attributes means that attribute; what is computed from them means nothing known."""
    found = told(f"{line}\n")
    assert dict(found.meanings.names) == names
    assert not [note for note in found.passed_over if "time step" not in note]


def test_what_is_undone_keeps_its_meaning(told) -> None:
    """Law: uncompute, undump and unfix change no file that was written before."""
    text = "compute w all property/atom omegax radius\ndump d all custom 1 d.txt id c_w[1] c_w[2]\nrun 1\nundump d\nuncompute w\n"
    assert dict(told(text).meanings.names) == {"c_w[1]": "omegax", "c_w[2]": "radius"}
    assert dict(told(f"{text}compute w all property/atom omegax radius\n").meanings.names) == {"c_w[1]": "omegax", "c_w[2]": "radius"}


def test_a_compute_with_two_meanings_has_none(told) -> None:
    """Law: a name that was defined in two ways does not say what a column is, also where one of the ways is not understood."""
    for second in ("property/atom omegay", "ke/atom", "property/atom omegax radius", "property/atom ${what}", "${style} omegax"):
        found = told(f"compute 1 all property/atom omegax\nuncompute 1\ncompute 1 all {second}\n")
        assert not found.meanings.names
        assert any("c_1 is defined in several ways" in note for note in found.passed_over)


def test_zeros_of_other_particles_are_no_values(told) -> None:
    """Law: a compute of a group holds zeros for other particles, so it has a meaning only in dumps of that group."""
    compute = "compute m big property/atom mass\n"
    assert not told(f"{compute}dump 1 all custom 1 a id c_m\n").meanings.names
    assert not told(f"{compute}variable m atom c_m\ndump 1 all custom 1 a id v_m\n").meanings.names
    assert dict(told(f"{compute}dump 1 big custom 1 a id c_m\n").meanings.names) == {"c_m": "mass"}


def test_a_column_that_is_there_twice_keeps_its_own_name(told) -> None:
    """Law: names never make two columns of one dump the same."""
    text = "compute 1 all property/atom radius omegax\ncompute 2 all property/atom omegax\ndump 1 all custom 1 a id radius c_1[1] c_1[2] c_2\n"
    assert dict(told(text).meanings.names) == {"c_1[2]": "omegax"}


def test_the_header_of_a_renamed_column(told) -> None:
    """Law: colname takes a number from 1, one from -1 at the end, or the old name (of equal ones the last, as LAMMPS); default undoes all."""
    text = "compute 1 all property/atom radius omegax omegay\ndump 1 all custom 1 a id vx c_1[*] vx\n"
    renamed = told(f"{text}dump_modify 1 sort id colname c_1[1] R colname 4 w colname -2 u colname vx last\n")
    assert renamed.meanings.dumps == (DumpWords("a", "custom", ("id", "vx", "R", "w", "u", "last")),)
    headed = {name: what for name, what in renamed.meanings.names.items() if not name.startswith("c_")}
    assert headed == {"R": "radius", "w": "omegax", "u": "omegay"}  # not last: the dump has a vx of its own
    assert told(f"{text}dump_modify 1 colname 3 R colname default\n").meanings.dumps[0].columns[2] == "c_1[1]"


def test_the_columns_of_dumps(told) -> None:
    """Law: dumps have the columns that their headers have, in every style that lists particles or bodies; others are left out."""
    text = """compute b all rigid/local f mol mass x
dump 1 all atom 10 a.gz
dump 2 all atom 10 b
dump_modify 2 scale no image yes
dump 3 all custom/gz 10 c.*.gz id type
dump 4 all local 10 d index c_b[*] c_b[2*] c_b[*2]
dump 5 all image 10 e.jpg type type
dump 6 all mesh/stl 10 f.stl
dump 7 all yaml 10 g id x
write_dump all custom h id vx modify colname vx speed
"""
    found = told(text).meanings.dumps
    assert [dump.file for dump in found] == ["a.gz", "b", "c.*.gz", "d", "g", "h"]
    assert [dump.columns for dump in found] == [
        ("id", "type", "xs", "ys", "zs"),
        ("id", "type", "x", "y", "z", "ix", "iy", "iz"),
        ("id", "type"),
        ("index", "c_b[1]", "c_b[2]", "c_b[3]", "c_b[2]", "c_b[3]", "c_b[1]", "c_b[2]"),
        ("id", "x"),
        ("id", "speed"),
    ]


def test_a_part_of_a_file_name_may_be_unknown(told) -> None:
    """Law: a variable that is not known stands for anything in a file name, but columns must be known."""
    found = told("dump 1 all custom 1 post/${case}_*.txt id x\ndump 2 all custom 1 b ${columns}\n")
    assert found.meanings.dumps == (DumpWords("post/*_*.txt", "custom", ("id", "x")),)
    assert "in.lammps:2: dump has columns that are not known: variable 'columns'" in found.passed_over[0]


def test_a_wildcard_of_unknown_length_is_noted(told) -> None:
    """Law: the columns of a dump are never guessed."""
    for compute in ("pair/local dist", "property/atom mass"):
        found = told(f"compute p all {compute}\ndump 1 all local 1 a c_p[*]\n")
        assert not found.meanings.dumps
        assert "in.lammps:2: dump has the column c_p[*], and how many it stands for is not known" in found.passed_over[0]


# ---- settings ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "step"),
    [
        (f"{BOX}units si\ntimestep 1e-5\nrun 10\n", 1e-5),
        (f"{BOX}run 10\n", 0.005),  # the default of lj
        (f"units si\n{BOX}run 10\n", 1e-8),
        ("units si\nrun 10\n", None),  # a part of a deck: what came before is not known
        (f"units real\n{BOX}run 10\n", None),  # no unit of granular matter
        (f"units si\n{BOX}timestep 1e-5\nrun 10\ntimestep 1e-6\nrun 10\n", None),
        (f"units si\n{BOX}timestep 1e-5\nrun 10\ntimestep 1e-6\n", 1e-5),
        (f"units si\n{BOX}timestep 1e-5\nrun 0\ntimestep 1e-6\nrun 10\n", 1e-6),
        (f"units si\n{BOX}timestep 1e-5\nrun 10\nreset_timestep 0\ntimestep 1e-6\nrun 10\n", 1e-6),
        (f"units si\n{BOX}timestep 1e-5\ndump 1 all custom 1 a id\nrun 10\nreset_timestep 0\ntimestep 1e-6\nrun 10\n", None),
        ("units si\nread_restart r\nrun 10\n", None),
        ("units si\nread_restart r\ntimestep 1e-5\nrun 10\n", 1e-5),
        (f"units si\n{BOX}include missing\nrun 10\n", None),
        (f"units si\n{BOX}timestep ${{dt}}\nrun 10\n", None),
        (f"units si\n{BOX}timestep 1e-5\nfix 1 all dt/reset 1 1e-6 1e-4 0.1\nrun 10\n", None),
        (f"units si\n{BOX}timestep 1e-5\nif '${{a}} == 1' then 'timestep 1e-6'\nrun 10\n", None),
        (f"units si\n{BOX}variable dt equal 2.0e-5/4\ntimestep ${{dt}}\nrun 10\n", 5e-6),
    ],
)
def test_the_time_of_a_step(told, text: str, step: float | None) -> None:
    """Law: the step is that of all runs whose steps are counted together, and is told only where it is known; else a note says why."""
    found = told(text)
    assert found.meanings.timestep == step
    assert any("time step" in note for note in found.passed_over) == (step is None)


def test_units_and_dimension(told) -> None:
    """Law: the word of the deck, the default of both engines in a whole deck, else nothing."""
    assert told(f"units cgs\ndimension 2\n{BOX}").meanings.units == "cgs"
    assert told(f"units cgs\ndimension 2\n{BOX}").meanings.dimension == 2
    assert told(BOX).meanings.units == "lj"
    assert told("compute 1 all ke\n").meanings.units is None
    assert told("read_restart r\n").meanings.units is None
    assert told(f"units ${{u}}\n{BOX}").meanings.units is None


# ---- the way through a deck --------------------------------------------------------------------------------------------------------


def test_includes_are_followed(told) -> None:
    """Law: an included file counts as part of the deck; one that is missing is noted with the line that names it."""
    found = told("include a.inc\ninclude gone.inc\n", a__inc="units si\ninclude b.inc\n", b__inc="compute 1 all property/atom mass\n")
    assert found.meanings.units == "si"
    assert dict(found.meanings.names) == {"c_1": "mass"}
    assert "in.lammps:2" in found.passed_over[0]
    assert "gone.inc: cannot read the file" in found.passed_over[0]


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("units si\ninclude in.lammps\ninclude in.lammps\n", "include leads to in.lammps more than 16 deep or 100 times"),
        ("units si\n" + "include b.inc\n" * 101, "in.lammps:102: include leads to b.inc more than 16 deep or 100 times"),
        ("units si\nlabel a\njump SELF a\n", ""),
        ("units si\njump in.lammps\n", ""),
        ("units si\njump b.inc\n", ""),
        ('units si\nvariable a string \'if "1" then "${a}"\'\nif "1" then "${a}"\n', "in.lammps:3: the deck goes on after 100000 commands"),
        ("units si\nvariable a string xx\n" + "variable a string ${a}${a}\n" * 60 + "timestep $a\n", "variable a, set in in.lammps:62, is not known"),
        ('units si\nvariable q string "\'"\nprint $q\n', "in.lammps:3: unbalanced quotes"),
    ],
)
def test_circles_end(told, text: str, note: str) -> None:
    """Law: what an engine would go round for ever is read once, or as often as is sensible; a note says where reading stopped."""
    found = told(text, b__inc="jump in.lammps\n")
    assert found.meanings.units == "si"
    others = [other for other in found.passed_over if "the time step is not known" not in other]
    assert any(note in other for other in others) == bool(note)


def test_a_loop_is_read_once_and_its_variable_is_not_known(told) -> None:
    """Law: with which value of a loop a file was written is not known, unless the command line chose it."""
    text = "variable k index 1e-5 2e-5\nlabel l\nunits si\ntimestep $k\ndump 1 all custom 10 d$k.txt id\nrun 10\nnext k\njump SELF l\n"
    found = told(text)
    assert found.meanings.timestep is None
    assert found.meanings.dumps == (DumpWords("d*.txt", "custom", ("id",)),)
    assert any("in.lammps:4: timestep time step is not known: variable k takes several values" in note for note in found.passed_over)
    assert told(text, variables={"k": ["2e-5"]}).meanings.timestep == 2e-5


def test_variables(told) -> None:
    """Law: strings take what they name when they are set, the first index wins, and what is set on an unknown condition is not known."""
    assert told("variable a string si\nvariable b string '$a'\nvariable a string cgs\nunits $b\n").meanings.units == "si"
    assert told("variable a index si cgs\nvariable a index micro\nunits $a\n").meanings.units == "si"
    assert told("variable a string si\nif '$q' then 'variable a string cgs'\nunits $a\n").meanings.units is None
    assert told("variable a string si\nvariable a string s${q}\nunits $a\n").meanings.units is None
    assert told("variable a string s${q}\nvariable a string si\nunits $a\n").meanings.units == "si"
    assert told("variable a getenv UNITS\nunits $a\n").meanings.units is None
    assert told("variable a index ${q}\nvariable a index si\nunits $a\n").meanings.units is None
    assert told("variable a string 'units si'\n$a\n").meanings.units == "si"


def test_jumps_forward_skip(told) -> None:
    """Law: what a jump leaves out is not read, but the jump that closes a loop is not taken."""
    assert told("units si\njump SELF on\nunits cgs\nlabel on\n").meanings.units == "si"
    assert told("units si\nvariable i loop 3\nlabel l\nnext i\njump SELF end\nunits cgs\nlabel end\n").meanings.units == "cgs"
    assert told("units si\njump b.inc\nunits cgs\n", b__inc="dimension 2\n").meanings.units == "si"
    assert told("units si\nvariable i loop 3\nnext i\njump b.inc\nunits cgs\n", b__inc="dimension 2\n").meanings.units == "cgs"
    assert told("units si\nif '$a' then 'jump b.inc'\nunits cgs\n", b__inc="dimension 2\n").meanings.units == "cgs"
    assert told("units si\nquit\nunits cgs\n").meanings.units == "si"
    assert told("units si\nif '$a' then quit\nunits cgs\n").meanings.units == "cgs"


@pytest.mark.parametrize(
    ("mode", "units"),
    [("a", "si"), ("b", "cgs"), ("c", "micro"), (None, None)],
)
def test_a_known_condition_decides(told, mode: str | None, units: str | None) -> None:
    """Law: of an `if` whose test is known the branch is read that an engine takes; else its settings are not known."""
    text = 'if "${mode} == a" then "units si" elif "${mode} == b" "units cgs" "dimension 2" else "units micro"\n'
    found = told(text, variables={"mode": [mode]} if mode else None)
    assert found.meanings.units == units
    assert found.meanings.dimension == (2 if mode == "b" else 3)
    assert any("in.lammps:1: units stands in an `if` whose test is not known" in note for note in found.passed_over) == (mode is None)


def test_columns_count_wherever_they_are_defined(told) -> None:
    """Law: a column that is in a file was defined, whatever the condition; two definitions leave it without meaning."""
    one = 'if "${a} == 1" then "compute 1 all property/atom mass" "dump 1 all custom 1 f id c_1"\n'
    assert dict(told(one).meanings.names) == {"c_1": "mass"}
    assert len(told(one).meanings.dumps) == 1
    assert not told(f"{one}compute 1 all property/atom radius\n").meanings.names


def test_clear_starts_anew(told) -> None:
    """Law: what stands before a `clear` counts only if a dump was written there, or if nothing follows."""
    first = f"units si\n{BOX}timestep 1e-5\ncompute 1 all property/atom mass\n"
    second = f"units si\n{BOX}timestep 2e-5\ncompute 1 all property/atom radius\n"
    dump, run = "dump 1 all custom 1 f id c_1\n", "run 10\n"
    assert told(f"{first}{run}clear\n{second}{dump}{run}").meanings.timestep == 2e-5
    assert told(f"{first}{dump}{run}clear\n{second}{run}").meanings.timestep == 1e-5
    assert told(f"{first}{dump}{run}clear\n").meanings.timestep == 1e-5
    assert told(f"{first}clear\n").meanings.timestep == 1e-5
    both = told(f"{first}{dump}{run}clear\n{second}{dump}{run}")
    assert (both.meanings.units, both.meanings.timestep, dict(both.meanings.names)) == ("si", None, {})
    assert any("timestep is not the same in the simulations" in note for note in both.passed_over)
    assert any("column c_1 means other things" in note for note in both.passed_over)
    same = told(f"{first}{dump}{run}clear\ndimension 2\n{first}fix 1 all multisphere\n{dump}{run}")
    assert (same.meanings.timestep, dict(same.meanings.names), same.meanings.rigid) == (1e-5, {"c_1": "mass"}, None)
    assert len(same.meanings.dumps) == 2
    assert sum(what in note for note in same.passed_over for what in ("dimension is not the same", "rigid is not the same")) == 2
    twice = told(f"{first}dimension 2\nfix 1 all multisphere\n{dump}{run}clear\n{first}dimension 2\nfix 1 all multisphere\n{dump}{run}")
    assert (twice.meanings.dimension, twice.meanings.rigid, twice.passed_over) == (2, "multisphere", [])


def test_other_partitions_are_uncertain(told) -> None:
    """Law: what only some processors execute is not known to be executed."""
    assert told("units si\npartition yes 2 units cgs\n").meanings.units is None


# ---- what cannot be read -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("content", [b"", b"# nothing\n", b"\x00\x01\x02", b"units 'si\n"])
def test_what_is_no_deck_is_refused(tmp_path: Path, content: bytes) -> None:
    """Law: empty, binary and unbalanced files are an InputError that names the file."""
    (tmp_path / "in.deck").write_bytes(content)
    with pytest.raises(InputError, match=r"in\.deck"):
        read_dictionary(tmp_path / "in.deck")
    with pytest.raises(InputError, match="cannot read the file"):
        read_dictionary(tmp_path)


def test_what_does_not_matter_is_silent(told) -> None:
    """Law: commands that say nothing of dumps are passed over without a word, whatever is in them, also what is not known."""
    text = f"units si\n{BOX}timestep 1e-5\nnonsense ${{a}}\nfix 1 all spring ${{k}}\npair_coeff * * ${{b}} $(c_1)\nprint '$x' screen no\n"
    assert told(text).passed_over == []


def test_a_restart_of_its_own_goes_on_with_the_simulation_before(told) -> None:
    """Law: what read_restart brings back from a file that the deck wrote is known; from another file it is not."""
    before = f"units si\natom_style sphere\ntimestep 1e-5\n{BOX}set type 1 density 2500\nrun 1\n"
    back = "write_restart state.*\nclear\nread_restart {}.1\nrun 1\n"
    straight = told(before + "run 1\n").meanings
    assert (straight.units, straight.timestep) == ("si", 1e-5)
    assert told(before + back.format("state")).meanings == straight
    assert told(before + back.format("other")).meanings.units is None

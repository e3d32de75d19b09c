"""Whatever is wrong with a deck, a file or the words of the command: one line on stderr that says where, status 2, nothing written."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.cli import LINES, Call, Called, deck, files_in, line_of

Write = Callable[..., Path]
COMMANDS = {"run": ("--out", "out"), "compare": ("--out", "out"), "convert": ("--to", "liggghts", "-o", "out.liggghts")}

# (the line that is changed, what it says then, a part of the message; the line that the message names where it is another)
DECKS = [
    ("units", "unit si", "command 'unit' is not supported; supported: atom_modify, atom_style,"),
    ("units", "units real", "units style 'real' is not one of lj, si, cgs, micro"),
    ("atom_style", "atom_style atomic", "atom_style style 'atomic' is not one of sphere"),
    ("boundary", "boundary p p", "boundary ends where z was expected"),
    ("region", "region box cone 0 1", "region style 'cone' is not one of block, cylinder, sphere"),
    ("region", "region box block -1 1 -1 1 -1", "region block ends where zhi was expected"),
    ("region", "region box block -1 1 -1 inf -1 1", "region block yhi must be a number, got 'inf'"),
    ("region", "region box block -1e200 1e200 -1e200 1e200 -1 1", "the box is too large for numbers", "box"),
    ("box", "create_box one box", "create_box number of types must be a whole number, got 'one'"),
    ("box", "create_box 1000000000 box", "number of types must be at most 1000"),
    ("box", "create_box 1 bax", "region 'bax' does not exist; defined: box"),
    ("box", "", "create_atoms needs a simulation box: create_box or read_data must come first", "first"),
    ("first", "create_atoms 1 single 0 0", "create_atoms single ends where z was expected"),
    ("first", "create_atoms 1 single 0 0 1_0", "create_atoms single z must be a number, got '1_0'"),
    ("first", "create_atoms 1 single 0.0051 0 0", "particles 1 and 2 are at one place, [0.0051, 0.0, 0.0]", "run"),
    ("first", "lattice sc 1e-9\ncreate_atoms 1 box", "the lattice has 1.0e+24 cells in this box, more than 1e+07 points", "first", 1),
    ("set", "set type 1 density 0", "set type density must be above zero, got 0"),
    ("set", "set type 1 mass nan", "set type mass must be a number, got 'nan'"),
    ("set", "set type 1 diameter 1e-200 density 1", "particle 1 has no mass: give it a density or a mass", "run"),
    ("set", "set group tops density 1", "group 'tops' does not exist; defined: all"),
    ("pair", "pair_style gran/hurtz 1 2 3", "pair_style style 'gran/hurtz' is not one of gran/hooke, gran/hooke/history", "pair"),
    ("pair", "pair_style gran/hooke 1", "pair_style gran/hooke ends where kt was expected", "pair"),
    ("pair", "", "pair_coeff needs a pair_style before it", "coeff"),
    ("skin", "neighbor -1 bin", "neighbor skin must be at least 0, got -1"),
    ("skin", "neighbor 1e300 bin", "neighbor skin must be at most 1e+100"),
    ("timestep", "timestep 0", "timestep the time step must be above zero, got 0"),
    ("timestep", "timestep -1e-6", "timestep the time step must be above zero, got -1e-06"),
    ("timestep", "timestep", "timestep ends where the time step was expected"),
    ("timestep", "timestep 1e-6 2", "timestep does not know '2' at this point"),
    ("timestep", "timestep ${dt}", "variable 'dt' is not defined; defined: none"),
    ("timestep", "timestep $(1/0)", "formula '1/0': division by zero"),
    ("nve", "fix move all nve", "fix style 'nve' is not one of gravity, nve/sphere, freeze, wall/gran"),
    ("nve", "fix move tops nve/sphere", "fix group 'tops' does not exist; defined: all"),
    ("nve", "fix g all gravity 9.81 vector 0 0", "fix g gravity ends where z was expected"),
    ("nve", "unfix move", "unfix fix 'move' does not exist; defined: none"),
    ("compute", "compute rot all temp", "compute style 'temp' is not one of erotate/sphere, ke, reduce"),
    ("compute", "compute rot all reduce sum vq", "compute rot reduce sum vq: expected a mode of sum, min,"),
    ("compute", "uncompute rot", "uncompute compute 'rot' does not exist; defined: none"),
    ("columns", "thermo_style custom step kee", "thermo keyword 'kee' is not one of step"),
    ("columns", "thermo_style custom step c_rat", "compute 'rat' is not one of rot"),
    ("columns", "thermo_style custom step c_rot[1]", "c_rot[1]: this compute has c_rot"),
    ("columns", "thermo_style custom step v_x", "variable 'x' is not defined; defined: none"),
    ("columns", "variable x equal step/zero\nthermo_style custom step v_x", "thermo keyword 'zero' is not one of step,", "run", 1),
    ("thermo", "thermo ten", "thermo number of steps must be a whole number, got 'ten'"),
    ("dump", "dump f all custom 10 f.dump id q", "dump custom column 'q' is not one of id, mol, type"),
    ("dump", "dump f all custom 0 f.dump id", "dump number of steps must be at least 1, got 0"),
    ("dump", "dump f all custom 10 ../f.dump id", "file '../f.dump' is not a relative path inside the run's folder"),
    ("dump", "dump f all custom 10 /tmp/f.dump id", "file '/tmp/f.dump' is not a relative path inside the run's folder"),
    ("dump", "dump f all custom 10 thermo.csv id", "dump f writes to 'thermo.csv', as does the run itself"),
    ("dump", "dump f all custom 1 f id\ndump g all custom 1 f id", "dump g writes to 'f', as does dump f", "dump", 1),
    ("dump", "dump f all custom 1 f id\ndump_modify f sort 2", "sort key '2' is not off, id or a column from 1 to 1", "dump", 1),
    ("dump", "dump f all custom 1 f id\ndump_modify f sort ²", "sort key '²' is not off, id or a column", "dump", 1),
    ("dump", "dump f all custom 1 f id x\ndump_modify f format float %d", "format '%d' of column x is not a printf format", "dump", 1),
    ("dump", "undump frames", "undump dump 'frames' does not exist; defined: none"),
    ("run", "run", "run ends where number of steps was expected"),
    ("run", "run -5", "run number of steps must be at least 0, got -5"),
    ("run", "run 1e3", "run number of steps must be a whole number, got '1e3'"),
    ("run", "run 99999999999999999999", "run number of steps: the engines count to 9223372036854775807"),
    ("run", "run 5\nminimize 0 0 1 1", "command 'minimize' is not supported; supported:", "run", 1),
    ("run", "run 5\nunfix moves", "unfix fix 'moves' does not exist; defined: move", "run", 1),
    ("run", "include nothing.in", "the file 'nothing.in' does not exist"),
    ("run", "print 'open", "unbalanced quotes: ' has no partner"),
]  # fmt: skip


def assert_refused(found: Called, message: str, folder: Path, before: set[str]) -> None:
    """One line, begun by `demverify: `; status 2; silence on stdout; not one file more than before."""
    assert found.status == 2
    assert found.out == ""
    assert found.err.startswith("demverify: ")
    assert found.err.count("\n") == 1
    assert message in found.err
    assert files_in(folder) == before


@pytest.fixture
def refuse(demverify: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """refuse(message, *words): the command, called in the test's folder, is refused with this message and writes nothing."""
    monkeypatch.chdir(tmp_path)

    def check(message: str, *words: object) -> None:
        before = files_in(tmp_path)
        assert_refused(demverify(*words), message, tmp_path, before)

    return check


Refuse = Callable[..., None]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("case", DECKS, ids=[f"{case[0]}-{case[1]}" for case in DECKS])
def test_a_wrong_line_of_a_deck(command: str, case: tuple[str, ...], refuse: Refuse, write: Write) -> None:
    """Each command names file and line, what was expected, and leaves the folder as it was."""
    name, text, message, *where = case
    write(deck(**{name: text}))
    line = line_of(str((where or [name])[0])) + sum(int(more) for more in where[1:])
    refuse(message, command, "in.lammps", *COMMANDS[command])
    refuse(f"demverify: in.lammps:{line}: ", command, "in.lammps", *COMMANDS[command])


def test_the_deck_of_these_tests_is_right(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Were the deck wrong of itself, the table would prove nothing."""
    assert demverify("run", write(deck()), "--out", tmp_path / "out").status == 0
    assert len(set(LINES)) == len(deck().splitlines())


LAWS = ["pair_style gran/hooke 1 1 1 1 1 0\npair_coeff * *", "pair_coeff * *", "fix w all wall/gran hooke 1 1 1 1 1 0 zplane -1 1"]


@pytest.mark.parametrize("change", LAWS)
def test_a_law_that_changes_between_runs_is_not_converted(change: str, refuse: Refuse, write: Write) -> None:
    """The tables of the converted deck hold for all its runs; a deck that needs more is refused, not half converted."""
    write(deck(run=f"run 5\n{change}\nrun 5"))
    shown = " ".join(change.splitlines()[0].split()[:4])
    message = f"in.lammps:{line_of('run') + 1}: {shown}: contact laws that change between runs are not converted"
    refuse(message, "convert", "in.lammps", *COMMANDS["convert"])


def test_a_wall_that_became_two_goes_as_two(demverify: Call, write: Write, tmp_path: Path) -> None:
    """A slab is two planes in LIGGGHTS: unfix takes both. One that was gone before the first run is not there at all."""
    slab = "wall/gran hooke/history 1e4 3e3 500 200 0.5 1 zplane -0.04 0.04"
    gone = f"fix a all {slab}\nunfix a"
    write(deck(columns=f"{gone}\nfix b all {slab}", run="run 5\nunfix b\nrun 5"))
    assert demverify("convert", tmp_path / "in.lammps", "--to", "liggghts", "-o", tmp_path / "in.liggghts").status == 0
    walls = [line.split()[:2] for line in (tmp_path / "in.liggghts").read_text().splitlines() if "wall/gran" in line or "unfix" in line]
    assert walls == [["fix", "b"], ["fix", "b_1"], ["unfix", "b"], ["unfix", "b_1"]]
    assert demverify("convert", tmp_path / "in.liggghts", "--to", "lammps", "-o", tmp_path / "back.lammps").status == 0


FILES = [
    ("", "in.lammps: the deck is empty: it holds no command"),
    ("# only a comment\n\n", "in.lammps: the deck is empty: it holds no command"),
    (b"\x7fELF\0\1\2" * 20, "in.lammps:1: expected a text file, found a binary one"),
    ("units si\nrun 10\n", "in.lammps:2: run needs a simulation box: create_box or read_data must come first"),
    (deck(run=""), "in.lammps: the deck has no run command"),
    ("include in.lammps\n", "in.lammps:1: more than 16 files include each other"),
]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(("content", "message"), FILES, ids=["empty", "comment", "binary", "no box", "no run", "circle"])
def test_a_file_that_is_no_deck(command: str, content: str | bytes, message: str, refuse: Refuse, write: Write) -> None:
    """Empty, binary, without box, without run, including itself: told at once."""
    write(content)
    refuse(message, command, "in.lammps", *COMMANDS[command])


@pytest.mark.parametrize("command", COMMANDS)
def test_a_deck_that_is_not_there(command: str, refuse: Refuse, tmp_path: Path) -> None:
    """A missing deck is named; a folder is no deck, and for compare one without decks is no case."""
    (tmp_path / "folder").mkdir()
    refuse("nothing.in", command, "nothing.in", *COMMANDS[command])
    refuse("no in.lammps or in.liggghts" if command == "compare" else "folder is a folder", command, "folder", *COMMANDS[command])


def test_an_included_file_is_named_with_its_own_line(refuse: Refuse, write: Write) -> None:
    """The place is that of the wrong line, not of the include."""
    write("# settings\nfoo bar\n", "part.in")
    write(f"include part.in\n{deck()}")
    refuse("demverify: part.in:2: command 'foo' is not supported", "run", "in.lammps", "--out", "out")


HEAD = "spheres\n\n2 atoms\n1 atom types\n-0.05 0.05 xlo xhi\n-0.05 0.05 ylo yhi\n-0.05 0.05 zlo zhi\n\nAtoms\n\n"  # 10 lines
DATA = [
    (b"\0\1\2" * 50, "data.two:1: expected a text file, found a binary one"),
    ("", "data.two: the data file is empty"),
    (HEAD + "1 1 0.01 2500 0 0 0\n", "data.two: the header says 2 atoms, the section Atoms holds 1"),
    (HEAD + "1 1 0.01 2500 0 0 0\n2 1 0.01 2500 0.02 nan 0\n", "data.two:12: expected a number for y, got 'nan'"),
    (HEAD + "1 1 0.01 2500 0 0 0\n2 1 0.01 2500 0.02 1_0 0\n", "data.two:12: expected a number for y, got '1_0'"),
    (HEAD + "1 1 0.01 2500 0 0 0\n1e30 1 0.01 2500 0.02 0 0\n", "data.two:12: the id must be a whole number"),
    (HEAD + "1 1 0.01 2500 0 0 0 0 0 0\n2 1 0.01 2500 0.02 0 0 0 0 .5\n", "data.two:12: ix iy iz must be whole numbers"),
    (HEAD + "1 1 0.01 0 0 0 0\n2 1 0.01 2500 0.02 0 0\n", "data.two:11: the density must be above zero"),
    (HEAD + "1 1 0.01 2500 0.02 0 0\n2 1 0.01 2500 0.02 0 0\n", "in.lammps:7: particles 1 and 2 are at one place"),
    (HEAD.replace("2 atoms", "² atoms"), "data.two:3: expected a whole number for the number of atoms"),
    (HEAD.replace("1 atom types", "100000000 atom types"), "in.lammps:3: read_data number of types must be at most 1000"),
    (HEAD + "1 1 0 2500 0 0 0\n2 1 0.01 2500 0.02 0 0\n", "in.lammps:6: fix 1 nve/sphere: particle 1 has radius 0"),
    (None, "in.lammps:3: read_data the file 'data.two' does not exist"),
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(("content", "message"), DATA, ids=[message[:60] for _, message in DATA])
def test_a_wrong_data_file(command: str, content: str | bytes | None, message: str, refuse: Refuse, write: Write) -> None:
    """The data file is named with its line, or the command that wanted it."""
    if content is not None:
        write(content, "data.two")
    write("atom_style sphere\nboundary f f f\nread_data data.two\npair_style gran/hooke 1 1 1 1 1 0\npair_coeff * *\nfix 1 all nve/sphere\nrun 1\n")
    refuse(message, command, "in.lammps", *COMMANDS[command])


def test_a_periodic_box_smaller_than_a_contact(refuse: Refuse, write: Write) -> None:
    """The solver sees one image of a neighbour; where a sphere would touch two, it says so."""
    write(deck(boundary="boundary p p p", skin="neighbor 0.2 bin"))
    refuse(f"in.lammps:{line_of('run')}: the periodic box is 0.1 long in x, shorter than", "run", "in.lammps")


@pytest.mark.parametrize("line", ["echo both", "log other.log", "timer full", "processors * * *", "restart 100 a b", "comm_modify mode single"])
def test_a_command_that_cannot_change_the_physics_is_accepted(line: str, demverify: Call, write: Write, tmp_path: Path) -> None:
    """Read, noted and without effect: the run goes on, and no file comes of it."""
    assert demverify("run", write(deck(newton=line)), "--out", tmp_path / "out").status == 0
    assert files_in(tmp_path / "out") == {"log.native", "frames.dump", "thermo.csv", "trajectory.h5"}


LAW = '[[law]]\nname = "{}"\ntolerance = {}\nreason = "because"\nparameters = {}\n'
CASES = [
    ('titel = "x"\n', "case/case.toml: key 'titel' is not one of title, what"),
    ("title =\n", "case/case.toml:1: not a readable case.toml"),
    (b"\xff\xfe\0", "case/case.toml: not a readable case.toml"),
    ("title = 3\n", "case/case.toml: key 'title' must be a text, got 3"),
    ("every = 0\n", "case/case.toml: every must be a whole number of steps from 1, got 0"),
    ('accept = ["nothing-known"]\n', "accepted difference 'nothing-known' is not in the register"),
    ('accept = "x"\n', "case/case.toml: key 'accept' must be a list of texts, got 'x'"),
    ('[[law]]\nname = "slip_cessation"\nreason = "x"\n', "a [[law]] needs name, tolerance and reason; tolerance is missing"),
    ('[law]\nname = "slip_cessation"\n', "key 'law' must be [[law]] tables"),
    (LAW.format("slip", 1, "{}"), "law 'slip' is not one of adhesive_contact,"),
    (LAW.format("slip_cessation", '"a"', "{}"), "law key 'tolerance' must be a number, got 'a'"),
    (LAW.format("slip_cessation", -1, "{}"), "the tolerance of law slip_cessation must be a number above zero, got -1"),
    (LAW.format("slip_cessation", "nan", "{}"), "the tolerance of law slip_cessation must be a number above zero, got nan"),
    (LAW.format("slip_cessation", 1, "{ e = 1 }"), "law slip_cessation takes no parameters; got e"),
    (LAW.format("wall_restitution", 1, '{ restitution = "a", axis = "z" }'), "law wall_restitution: restitution must be a number, got 'a'"),
    (LAW.format("wall_restitution", 1, '{ restitution = 1, axis = "q" }'), "law wall_restitution: axis must be one of x, y, z, got 'q'"),
]  # fmt: skip


@pytest.mark.parametrize(("toml", "message"), CASES, ids=[message[-50:] for _, message in CASES])
def test_a_malformed_case(toml: str | bytes, message: str, refuse: Refuse, write: Write) -> None:
    """What is wrong in a case.toml is told before any engine has started."""
    write(deck(), "case/in.lammps")
    write(toml, "case/case.toml")
    refuse(message, "compare", "case", "--out", "out")


WORDS = [
    ("run in.lammps --engine gromacs", "engine 'gromacs' is not one of lammps, liggghts, native"),
    ("compare in.lammps --engine gromacs", "engine 'gromacs' is not one of"),
    ("compare in.lammps --accept nothing-known", "accepted difference 'nothing-known' is not in the register; it has "),
    ("convert in.lammps --to gromacs -o x", "--to gromacs is not one of lammps, liggghts"),
    ("convert in.lammps --to lammps -o x", "in.lammps: this is a lammps deck already"),
    ("convert in.lammps --to liggghts -o in.lammps", "in.lammps is the deck that is converted"),
    ("convert in.lammps --to liggghts -o folder", "cannot write folder: it is a folder"),
    ("convert in.lammps --to liggghts -o no/where", "cannot write where: there is no folder no"),
    ("run in.lammps --var", "Option '--var' requires an argument"),
    ("run in.lammps --var a", "--var a: expected NAME VALUE"),
    ("run in.lammps --var a-b 1", "--var a-b=1: expected NAME VALUE, a name of letters"),
    ("run in.lammps --threads 0", "Invalid value for '--threads'"),
    ("run in.lammps --threads two", "Invalid value for '--threads'"),
    ("run in.lammps --ranks -1", "Invalid value for '--ranks'"),
    ("compare in.lammps --timeout nan", "Invalid value for '--timeout'"),
    ("run in.lammps --precision half", "--precision half is not one of double, mixed"),
    ("run in.lammps --engine lammps --precision mixed", "--precision, --sleep and --on-instability are of the native engine; lammps has no"),
    ("run in.lammps --sleep -1 --out out", "in.lammps:21: --sleep -1: sleep needs a speed above 0 and steps between looks, not speed -1"),
    ("run in.lammps --out file", "file: File exists"),
    ("run in.lammps --out file/below", "file/below: Not a directory"),
    ("compare in.lammps --out file", "Not a directory"),
    ("run in.lammps --out /proc/nowhere", "/proc/nowhere: No such file or directory"),
    ("run in.lammps --json no/where.json", "cannot write where.json: there is no folder no"),
    ("compare in.lammps --json folder", "cannot write folder: it is a folder"),
    ("doctor --json no/where.json", "cannot write where.json: there is no folder no"),
    ("run in.lammps --engine lammps --out .", "is the deck's own; name another"),
    ("run", "Missing argument 'deck' (demverify run --help)"),
    ("run in.lammps another", "Got unexpected extra argument"),
    ("run in.lammps --colour red", "No such option: --colour"),
    ("simulate in.lammps", "No such command 'simulate'"),
    ("", "Missing command (demverify --help)"),
]


@pytest.mark.parametrize(("words", "message"), WORDS, ids=[words for words, _ in WORDS])
def test_wrong_words_on_the_command_line(words: str, message: str, refuse: Refuse, write: Write, tmp_path: Path) -> None:
    """A wrong option is told in one line, whether by us or by the library that reads the words, and before anything runs."""
    write(deck())
    write("", "file")
    (tmp_path / "folder").mkdir()
    refuse(message, *words.split())


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write and read everything")
def test_folders_and_decks_that_may_not_be_used(refuse: Refuse, write: Write, tmp_path: Path) -> None:
    """A deck that may not be read and a folder that may not be written are wrong input like any other."""
    write(deck()).chmod(0)
    refuse("in.lammps: cannot read the file: Permission denied", "run", "in.lammps")
    write(deck(), "open.lammps")
    (tmp_path / "closed").mkdir(mode=0o500)
    refuse("closed/out: Permission denied", "run", "open.lammps", "--out", "closed/out")

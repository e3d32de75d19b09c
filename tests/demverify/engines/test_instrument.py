"""The copy of a deck: which words change, what is provided beside it, what is refused, and how lines lead back."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from demverify.engines.instrument import prepare
from demverify.errors import InputError


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A deck folder with files to read, beside it another with one more."""
    folder = tmp_path / "home"
    (folder / "meshes").mkdir(parents=True)
    for name in ("data.x", "data.a1", "data.a2", "all", "5", "meshes/box.stl", "restart.10", "with blank.data"):
        (folder / name).write_text(name)
    (folder / "data.zip.gz").write_bytes(gzip.compress(b"packed"))
    (tmp_path / "data.up").write_text("up")
    return folder


def copied(home: Path, text: str, *, every: int | None = None, **variables: list[str]) -> str:
    """The copy's text for a deck of this text."""
    (home / "in.deck").write_text(text)
    return prepare(home / "in.deck", home.parent / "out", "lammps", variables, every).deck.read_text()


@pytest.mark.parametrize(
    "line, expected",
    [
        ("read_data data.x", "read_data in.lammps.files/data.x"),
        ('read_data "data.x" add append # data.x', 'read_data "in.lammps.files/data.x" add append # data.x'),
        ("read_data &\n  data.x", "read_data &\n  in.lammps.files/data.x"),
        ("read_data ../data.up", "read_data in.lammps.files/up/data.up"),
        ("read_data 'with blank.data'", "read_data 'in.lammps.files/with_blank.data'"),
        ("read_data data.zip.gz", "read_data in.lammps.files/data.zip"),
        ("read_data data.zip", "read_data in.lammps.files/data.zip"),
        ("variable f index x\nread_data data.$f", "variable f index x\nread_data in.lammps.files/data.x"),
        ("variable i loop 2\nread_data data.a${i}", "variable i loop 2\nread_data in.lammps.files/data.a${i}"),
        ("variable n string data\nvariable f string ${n}.x\nread_data ${f}", None),
        ("read_restart restart.*", "read_restart in.lammps.files/restart.*"),
        ("fix m all mesh/surface file meshes/box.stl", "fix m all mesh/surface file in.lammps.files/meshes/box.stl"),
        ('if "1 > 0" then "read_data data.x" else "run 1"', 'if "1 > 0" then "read_data in.lammps.files/data.x" else "run 1"'),
        ("group all type 1", "group all type 1"),
        ("fix 5 all nve/sphere", "fix 5 all nve/sphere"),
        ("fix a all ave/time 1 1 1 c_1 file data.x", "fix a all ave/time 1 1 1 c_1 file data.x"),
        ("write_data data.x", "write_data data.x"),
        ("dump d all custom 5 data.x id", "dump d all custom 5 data.x id"),
        ('print "data.x" file data.x', 'print "data.x" file data.x'),
        ("echo none", "echo both"),
        ("write_data made.data\nread_data made.data", "write_data made.data\nread_data made.data"),
        ("write_restart restart.10\nread_restart restart.10", "write_restart restart.10\nread_restart restart.10"),
        ("write_restart restart.*\nread_restart restart.10", "write_restart restart.*\nread_restart restart.10"),
        ("write_restart other.*\nread_restart restart.10", "write_restart other.*\nread_restart in.lammps.files/restart.10"),
        ('if "1" then "write_restart r" clear "read_restart r"', 'if "1" then "write_restart r" clear "read_restart r"'),
        ("jump SELF again", "jump SELF again"),
        ("jump in.deck again", "jump in.lammps again"),
    ],
)
def test_words_that_are_read_are_provided_and_no_others_change(home, line, expected):
    """A word naming a file to read points to an entry beside the copy; ids, outputs and comments stay as they are."""
    text = copied(home, line + "\n")
    if expected is None:
        expected = line.replace("read_data ${f}", "read_data in.lammps.files/data.x")
    assert text == expected + "\n"


def test_entries_lead_to_the_users_files(home):
    """A link for a plain file, every candidate of a loop, the unpacked text of a zipped one; the deck's folder gains nothing."""
    before = sorted(home.rglob("*"))
    copied(home, "variable i loop 2\nread_data data.a${i}\nread_data data.zip\nread_data ../data.up\n")
    files = home.parent / "out/in.lammps.files"
    assert {str(path.relative_to(files)): path.read_text() for path in files.rglob("*") if path.is_file()} == {
        "data.a1": "data.a1",
        "data.a2": "data.a2",
        "data.zip": "packed",
        "up/data.up": "up",
    }
    assert sorted({*before, home / "in.deck"}) == sorted(home.rglob("*"))


def test_a_command_line_variable_chooses_the_file(home):
    """`-var` wins over the deck's own index variable, as it does in the engines."""
    text = copied(home, "variable f index a1\nread_data data.${f}\n", f=["x"])
    assert "read_data in.lammps.files/data.x" in text


def test_includes_are_copied_by_the_same_rules(home):
    """An included deck, and what it includes, is rewritten; its paths count from the deck's folder, as in the engines."""
    (home / "sub").mkdir()
    (home / "sub/one.inc").write_text("include sub/two.inc\n")
    (home / "sub/two.inc").write_text("read_data data.x\nrun 3\n")
    assert copied(home, "include sub/one.inc\n", every=2).endswith("include in.lammps.files/sub/one.inc\n")
    files = home.parent / "out/in.lammps.files/sub"
    assert (files / "one.inc").read_text() == "include in.lammps.files/sub/two.inc\n"
    data, dump, run = (files / "two.inc").read_text().splitlines()
    assert (data, run) == ("read_data in.lammps.files/data.x", "run 3")
    assert "dump demverify_all all custom 2 " in dump


def test_a_deck_that_includes_itself_ends(home):
    """The copying does not follow a circle of includes."""
    (home / "loop.inc").write_text("include loop.inc\n")
    assert copied(home, "include loop.inc\n") == "include in.lammps.files/loop.inc\n"


@pytest.mark.parametrize(
    "line, number",
    [
        ("dump d all custom 5 /tmp/d.txt id", 1),
        ("\nlog ../log.x", 2),
        ("restart 100 a.rst sub/../../b.rst", 1),
        ("variable d index ..\nwrite_data ${d}/x", 2),
        ("fix p all print 10 text file ../x", 1),
        ('print text append "/root/x"', 1),
        ("shell mkdir ../post", 1),
        ('if "1" then "write_restart ../r"', 1),
    ],
)
def test_outputs_outside_the_run_folder_are_refused(home, line, number):
    """An absolute output path, or one that climbs out, is an error with its file and line."""
    with pytest.raises(InputError, match="outside the run folder") as caught:
        copied(home, line + "\n")
    assert caught.value.place.line == number


def test_output_folders_are_made_in_the_run_folder(home):
    """Sub-folders of outputs exist before the engine writes, also those that a variable names; /dev/null is let pass."""
    dump = "variable p index one two\ndump d all custom 5 post/${p}/d*.txt id\n"
    copied(home, dump + "log deep/er/log.x\nlog /dev/null\nlog a/../b/c\n")
    out = home.parent / "out"
    assert {str(path.relative_to(out)) for path in out.rglob("*") if path.is_dir()} >= {"post/one", "post/two", "deep/er", "b"}


@pytest.mark.parametrize(
    "text, message",
    [
        ("read_data nothing.here\n", "no file 'nothing.here'"),
        ("units si\ninclude nothing.inc\n", ":2: include: no file"),
        ("# only a comment\n", "no command"),
        ("", "no command"),
        ("run 1\0\n", "binary"),
    ],
)
def test_decks_no_engine_could_run_are_refused(home, text, message):
    """A missing file, an empty or a binary deck is one line with its place."""
    with pytest.raises(InputError, match=message):
        copied(home, text)


def test_a_missing_deck_or_the_decks_own_folder_is_refused(home):
    """The copy must never overwrite what the user wrote."""
    with pytest.raises(InputError, match="no such deck"):
        prepare(home / "in.none", home.parent / "out", "lammps", {}, None)
    (home / "in.lammps").write_text("run 1\n")
    with pytest.raises(InputError, match="the deck's own"):
        prepare(home / "in.lammps", home, "lammps", {}, None)
    assert (home / "in.lammps").read_text() == "run 1\n"
    with pytest.raises(InputError, match="every 0 steps"):
        prepare(home / "in.lammps", home.parent / "out", "lammps", {}, 0)


def test_without_frames_nothing_is_put_in(home):
    """`every` None: the copy runs the very commands of the deck."""
    text = "units si\nrun 5\nclear\nreset_timestep 0\n"
    assert copied(home, text) == text


def test_lines_lead_back_to_the_user(home):
    """Each line of the copy, put together and squeezed, is known with file and first line, equal lines with all their places."""
    (home / "in.deck").write_text("# one\nrun   5\nfix 1 all &\n   nve\nrun 5\nread_data data.x\n")
    prepared = prepare(home / "in.deck", home.parent / "out", "lammps", {}, 1)
    lines = {line: [place.line for place in places] for line, places in prepared.places.items()}
    assert (lines["run 5"], lines["fix 1 all nve"], lines["read_data in.lammps.files/data.x"]) == ([2, 5], [3], [6])


@pytest.mark.parametrize(
    "text, total",
    [
        ("run 5\nrun 7\n", 12),
        ("variable n equal 4\nrun ${n}\n", 4),
        ("variable n equal 4*2\nrun ${n}\n", None),
        ("run 5 upto\n", None),
        ("label a\nrun 5\njump SELF a\n", None),
        ("include steps.inc\nrun 1\n", 4),
        ("include steps.inc\ninclude steps.inc\n", None),
        ("run 10 every 5 'print x'\n", 10),
    ],
)
def test_the_plan_is_the_sum_of_plain_runs(home, text, total):
    """Steps of all runs where they can be read from the deck; None where a loop or a formula hides them."""
    (home / "steps.inc").write_text("run 3\n")
    (home / "in.deck").write_text(text)
    assert prepare(home / "in.deck", home.parent / "out", "lammps", {}, None).total == total


def test_the_dump_of_superquadrics_has_shapes(home: Path) -> None:
    """Law: what tells superquadrics from spheres goes into the dump of all particles of such a deck, and of no other."""
    for style, there in (("superquadric", True), ("granular", False)):
        (home / "in.deck").write_text(f"atom_style {style}\nrun 1\n")
        prepared = prepare(home / "in.deck", home.parent / "out", "liggghts", {}, 1)
        assert (" shapex shapey shapez blockiness1 blockiness2 quat1" in prepared.deck.read_text()) == there
        assert ({"shapex", "blockiness2", "quat4", "angmomz"} <= set(prepared.columns)) == there

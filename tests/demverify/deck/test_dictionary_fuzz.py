"""Any text as a deck: a dictionary or an InputError, never anything else, and soon."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from demverify.deck.dictionary import Dictionary, read_dictionary
from demverify.errors import InputError

DATA = "a comment\n\n2 atoms\n2 atom types\n\nAtoms\n\n1 1 0.1 5 0 0 0\n2 2 0.1 6 0 0 0\n"
FILES = {"x.data": DATA, "more.inc": "include in.deck\nnext i\n", "stone.ms": "0 0 0 1\n1 0 0 1\n", "binary": "\x00\x01"}
NAMES = """
units dimension atom_style create_box create_atoms read_data read_restart set group delete_atoms compute variable dump dump_modify
write_dump undump uncompute unfix fix timestep run reset_timestep include jump label next if then elif else quit clear partition
coarsegraining"""
ARGUMENTS = """
all si lj sphere granular ellipsoid hybrid superquadric molecular single box region random basis mol offset type atom density diameter
mass shape type/fraction property/atom rigid/local multisphere property quat xcm id_multisphere quatw omegax radius custom atom local yaml custom/vtk
colname default scale image yes no pour deposit dens particletemplate/sphere particletemplate/multisphere atom_type constant uniform nspheres
ntry spheres file rigid molecule rigid/small adapt index loop string equal format delete atom getenv SELF in.deck more.inc x.data stone.ms
binary gone . / ~nobody 0 1 2 3 -1 1.5 1e400 nan inf 1_0 99999999999999999999 1* *2 * 1:3 2:1:1 a b i c_a c_a[1] c_a[*] c_a[9*] v_b v_i f_x[2]
${a} ${b} $i $(v_a) $(1/0) $(2^9999) $(step:%5d) $(1:%999999999f) ${ $( $ \" ' # & \"\"\" é \x0b + == 1==1 ${a}==1"""
LONG = ["x" * 300, "9" * 5000, "(" * 2000 + "1", "${a}" * 50]
WORD = st.one_of(st.sampled_from(ARGUMENTS.split()), st.sampled_from(ARGUMENTS.split()), st.sampled_from(LONG), st.text(max_size=5))
QUOTED = st.lists(WORD, min_size=1, max_size=6).map(lambda words: '"' + " ".join(words).replace('"', "") + '"')
LINE = st.tuples(st.sampled_from(NAMES.split()), st.lists(st.one_of(WORD, WORD, WORD, QUOTED), max_size=9)).map(lambda x: " ".join([x[0], *x[1]]))
WHOLE = """units si
atom_style sphere
region b block 0 1 0 1 0 1
create_box 2 b
variable d equal 2*1000
variable n loop 3
label l
if "${d} > 1000" then "create_atoms 1 single 0 0 0" "set type 1 density ${d}" else "read_data x.data"
include more.inc
fix p all particletemplate/multisphere 9 atom_type 1 density constant ${d} nspheres 2 ntry 9 spheres file stone.ms scale 1 type 1
fix r all rigid/small molecule
compute b all rigid/local r mol mass x quatw
compute a all property/atom omegax quatw
dump 1 all custom 10 d*.txt id type type c_a[*] &
 v_m
dump_modify 1 colname c_a[1] w sort id
timestep 1e-5
run 10
clear
next n
jump SELF l
"""


def read(text: str) -> Dictionary | None:
    """The dictionary of a deck next to files that it may name, or None for a refusal in one line."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in FILES.items():
            (Path(folder) / name).write_text(content)
        deck = Path(folder) / "in.deck"
        deck.write_text(text, encoding="utf-8", errors="surrogatepass")
        try:
            return read_dictionary(deck, {"a": ["1"], "b": ["2", "3"]})
        except InputError as error:
            assert "\n" not in str(error)
            return None


def sound(found: Dictionary | None) -> None:
    """What is told is usable, whatever it was told by."""
    if found is None:
        return
    told = found.meanings
    assert all(kind >= 1 and math.isfinite(rho) and rho > 0.0 for kind, rho in told.density.items())
    assert told.timestep is None or 0.0 <= told.timestep < math.inf
    assert told.dimension in {2, 3}
    assert all("\0" not in word for dump in told.dumps for word in (dump.file, dump.style, *dump.columns))
    assert all("\0" not in word for item in told.names.items() for word in item)
    assert all((template.radius > 0.0).all() and len(template.centre) == len(template.radius) for template in told.templates)
    assert all("\n" not in note for note in found.passed_over)


@settings(deadline=None)  # the machine may be busy; a hang meets the limit of the whole test
@given(st.text(max_size=200))
@example("$")
@example("units ${")
@example("variable a equal v_a\ntimestep ${a}\n")
def test_any_text(text: str) -> None:
    """Law: any text is a dictionary or an InputError."""
    sound(read(text))


@settings(deadline=None)
@given(st.lists(LINE, max_size=12))
@example([f"variable v{i} equal v_v{i + 1}" for i in range(3000)] + ["timestep ${v0}"])
@example(["variable a equal " + "(" * 5000, "timestep ${a}"])
@example(["include more.inc"] * 3)
@example(['read_restart """', 'units """'])
@example(["create_box 1000000000 b", "read_restart r", "set type 1*999999999 density 5", "set atom * density 5", "group g type 1:999999999"])
@example(["variable x loop " + "9" * 5000, "variable x loop 1 2 pad", "timestep ${x}"])
def test_any_commands(lines: list[str]) -> None:
    """Law: any words behind the commands that matter are a dictionary or an InputError."""
    sound(read("units si\n" + "\n".join(lines) + "\n"))


@settings(deadline=None)
@given(st.integers(0, len(WHOLE)), st.integers(0, 40), st.one_of(WORD, LINE, st.just("")))
def test_a_deck_with_a_part_replaced(at: int, length: int, new: str) -> None:
    """Law: a damaged deck is a dictionary or an InputError."""
    sound(read(WHOLE[:at] + new + WHOLE[at + length :]))


@pytest.mark.parametrize("length", range(0, len(WHOLE), 7))
def test_a_deck_that_ends_early(length: int) -> None:
    """Law: a deck cut off anywhere is a dictionary or an InputError."""
    sound(read(WHOLE[:length]))


@settings(deadline=None)
@given(st.binary(max_size=100))
def test_any_data_file(rows: bytes) -> None:
    """Law: whatever a data file and a template hold, the deck is read."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "x").write_bytes(b"\n1 atom types\nAtoms\n" + rows)
        (Path(folder) / "y.gz").write_bytes(b"\x1f\x8b" + rows)
        (Path(folder) / "in.liggghts").write_text(
            "atom_style sphere\nread_data x\nread_data y\nfix p all particletemplate/multisphere 9 atom_type 1 density constant 5 "
            "nspheres 2 ntry 9 spheres file x scale 1 type 1\n"
        )
        sound(read_dictionary(Path(folder) / "in.liggghts"))

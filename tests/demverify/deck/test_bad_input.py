"""Everything a user can get wrong: one line with file and line number, what was expected, what exists."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from demverify.deck.dry import DryBackend
from demverify.deck.interpreter import Interpreter
from demverify.errors import InputError

Run = Callable[..., Interpreter]
BOX = "units si\nboundary f f f\nregion b block 0 1 0 1 0 1 units box\ncreate_box 2 b\n"  # lines 1 to 4
GRAINS = BOX + "create_atoms 1 single 0.25 0.5 0.5 units box\ncreate_atoms 2 single 0.75 0.5 0.5 units box\n"  # 5 and 6

# (what comes before, the command, the message after "in.deck:<line of the command>: ")
COMMANDS = [
    ("", "unit si", "command 'unit' is not supported; supported: atom_modify, atom_style,"),
    ("", "units real", "units style 'real' is not one of lj, si, cgs, micro"),
    ("", "units", "units ends where style was expected"),
    (BOX, "units si", "units must come before the simulation box is made"),
    ("", "dimension 4", "dimension number must be from 2 to 3, got 4"),
    ("", "dimension x", "dimension number must be a whole number, got 'x'"),
    ("", "boundary p p q", "boundary z must be one or two letters of p f s m, got 'q'"),
    ("", "boundary p pf f", "boundary y: both faces of an axis are periodic or none, got 'pf'"),
    ("", "boundary p p", "boundary ends where z was expected"),
    ("", "atom_style ellipsoid", "atom_style style 'ellipsoid' is not one of sphere"),
    ("", "region a block 0 1 0 1 0 abc", "region block zhi must be a number, got 'abc'"),
    ("", "region a block 0 nan 0 1 0 1", "region block xhi must be a number, got 'nan'"),
    ("", "region a block 0 inf 0 1 0 1", "region block xhi must be a number, got 'inf'"),
    ("", "region a block 0 1 0 1 0", "region block ends where zhi was expected"),
    ("", "region a block 1 0 0 1 0 1", "region block xlo must not exceed xhi"),
    ("", "region a block INF 0 0 1 0 1", "region block INF for xlo needs a simulation box, and there is none yet"),
    ("", "region a cone 0 1 0 1 0 1", "region style 'cone' is not one of block, cylinder, sphere, plane, union, intersect"),
    ("", "region a sphere 0 0 0 -1", "region sphere radius must be above zero, got -1"),
    ("", "region a sphere 0 0 0 1 move v_x NULL NULL", "region sphere keyword 'move' is not one of side, units"),
    (BOX, "region b sphere 0 0 0 1", "region 'b' exists already"),
    (BOX, "region u union 2 b c", "region union region 'c' does not exist; defined: b"),
    ("region a sphere 0 0 0 1 side out\n", "create_box 1 a", "create_box the region has no bounds to make a box of"),
    ("", "create_box 1 a", "create_box region 'a' does not exist; defined: none"),
    (BOX, "create_box 1 b", "create_box must come before the simulation box is made"),
    ("", "lattice fcc 0", "lattice fcc scale must be above zero, got 0"),
    ("", "lattice hex 1", "lattice hex does not fit dimension 3"),
    ("", "lattice diamonds 1", "lattice style 'diamonds' is not one of none, sc, bcc"),
    ("", "lattice sc 1 orient x 1 1 0", "lattice sc orient vectors must be orthogonal, not zero and right-handed"),
    ("", "lattice sc 1 origin 1 0 0", "lattice sc origin x must be from 0 to 1, got 1"),
    ("", "create_atoms 1 box", "create_atoms needs a simulation box: create_box or read_data must come first"),
    (BOX, "create_atoms 3 box", "create_atoms type must be from 1 to 2, got 3"),
    (BOX, "create_atoms 1 box", "create_atoms box needs a lattice command before it"),
    (BOX, "create_atoms 1 single 1 0.5 0.5 units box", "create_atoms single x = 1 is outside the box, 0 to 1"),
    (BOX, "create_atoms 1 single 0 x 0", "create_atoms single y must be a number, got 'x'"),
    (BOX, "create_atoms 1 mesh f", "create_atoms style 'mesh' is not one of box, region, single, random"),
    ("", "read_data nothing", "read_data the file 'nothing' does not exist (looked for"),
    ("", "include nothing", "the file 'nothing' does not exist (looked for"),
    ("", "jump SELF nowhere", "label 'nowhere' is not in"),
    ("", "if 1 thn 'run 1'", "if the word after the test 'thn' is not one of then"),
    ("", "if 1 then", "if expects at least one command in each branch"),
    ("", "if '1 +' then 'run 1'", "condition '1 +': it ends too early"),
    ("", "timestep ${dt}", "variable 'dt' is not defined; defined: none"),
    ("", "timestep 0", "timestep the time step must be above zero, got 0"),
    ("", "timestep -1e-5", "timestep the time step must be above zero, got -1e-05"),
    ("", "timestep nan", "timestep the time step must be a number, got 'nan'"),
    (BOX, "set type 1 density 5", "set there are no particles yet"),
    (GRAINS, "set typ 1 density 5", "set style 'typ' is not one of atom, type, group, region"),
    (GRAINS, "set type 3 density 5", "set type '3' is not within 1 to 2"),
    (GRAINS, "set type 1a density 5", "set type expects a number or a range such as 2*5, got '1a'"),
    (GRAINS, "set type 1 density 0", "set type density must be above zero, got 0"),
    (GRAINS, "set type 1 diameter -1", "set type diameter must be above zero, got -1"),
    (GRAINS, "set group tops density 1", "set group group 'tops' does not exist; defined: all"),
    (GRAINS, "set atom 1 charge 1", "set atom keyword 'charge' is not one of type, diameter"),
    (GRAINS, "set atom 1", "set atom expects a keyword"),
    (GRAINS, "mass 1 1.0", "mass does not work with spheres"),
    (GRAINS, "group a dynamic all", "group style 'dynamic' is not one of type, id"),
    (GRAINS, "group a type 1:x", "group type expects a value, first:last or first:last:step, got '1:x'"),
    (GRAINS, "group a type 2:1", "group type the range '2:1' is empty"),
    (GRAINS, "group a subtract all", "group subtract expects at least two groups"),
    (GRAINS, "group a subtract all b", "group subtract group 'b' does not exist; defined: all"),
    (GRAINS, "group a delete", "group delete cannot delete 'a'; groups of this deck: none"),
    (GRAINS + "group a id 1\nfix f a freeze\n", "group a delete", "group delete group 'a' is in use by f"),
    (GRAINS, "velocity all spin 1", "velocity style 'spin' is not one of set, zero, ramp, create"),
    (GRAINS, "velocity all set 1 2", "velocity set ends where vz was expected"),
    (GRAINS, "velocity all set 1 2 v_q", "variable 'q' is not defined; defined: none"),
    (GRAINS, "velocity all ramp vx 0 1 x 2 2", "velocity ramp clo and chi must differ"),
    (GRAINS, "displace_atoms all shake 1", "displace_atoms style 'shake' is not one of move, random, rotate"),
    (GRAINS, "neighbor -0.1 bin", "neighbor skin must be at least 0, got -0.1"),
    (GRAINS, "neigh_modify evry 1", "neigh_modify keyword 'evry' is not one of page"),
    (GRAINS, "neigh_modify exclude group all top", "neigh_modify group 'top' does not exist; defined: all"),
    (GRAINS, "fix 1 all gravity 9.81 up", "fix 1 gravity style 'up' is not one of vector, chute, spherical"),
    (GRAINS, "fix 1 all gravity 9.81 vector 0 0", "fix 1 gravity ends where z was expected"),
    (GRAINS, "fix 1 all gravity 9.81 vector 0 0 0", "fix 1 gravity the vector must not be zero"),
    (GRAINS, "fix 1 all gravity v_g vector 0 0 1", "fix 1 gravity magnitude as a variable (v_g) is not supported"),
    (GRAINS, "fix 1 all gravity 9.81 chute 26 4", "fix 1 gravity does not know '4' at this point"),
    (GRAINS, "fix 1 all nve", "fix style 'nve' is not one of gravity, nve/sphere, freeze"),
    (GRAINS, "fix 1 all property/global kn scalar 1", "fix style 'property/global' is not one of gravity"),
    (GRAINS, "fix 1 top freeze", "fix group 'top' does not exist; defined: all"),
    (GRAINS, "fix 1 all nve/sphere disc", "fix 1 nve/sphere disc needs dimension 2"),
    (GRAINS, "fix 1 all enforce2d", "fix 1 enforce2d needs dimension 2"),
    (GRAINS, "fix 1 all setforce 0 0 z", "fix 1 setforce fz must be a number, got 'z'"),
    (GRAINS, "fix 1 all viscous 1 scale 3 2", "fix 1 viscous type must be from 1 to 2, got 3"),
    (GRAINS + "fix 1 all freeze\n", "fix 1 all nve/sphere", "fix '1' is a fix freeze already and cannot become nve/sphere"),
    (GRAINS, "unfix g", "unfix fix 'g' does not exist; defined: none"),
    (GRAINS, "fix_modify g energy yes", "fix_modify fix 'g' does not exist; defined: none"),
    (GRAINS, "compute 1 all temp", "compute style 'temp' is not one of erotate/sphere, ke, reduce"),
    (GRAINS, "uncompute c", "uncompute compute 'c' does not exist; defined: none"),
    (GRAINS, "pair_coeff * *", "pair_coeff needs a pair_style before it"),
    (GRAINS, "dump 1 all povray 10 f id", "dump style 'povray' is not one of custom, atom"),
    (GRAINS, "dump 1 all custom 0 f id", "dump number of steps must be at least 1, got 0"),
    (GRAINS, "dump 1 all custom 10 f", "dump custom expects the columns to write"),
    (GRAINS + "dump 1 all atom 10 f\n", "dump_modify 1 format 6 %g", "dump_modify format expects line, float, int, none or a"),
    (GRAINS, "undump 1", "undump dump '1' does not exist; defined: none"),
    (GRAINS, "thermo_style custom", "thermo_style custom expects keywords, got ''"),
    (GRAINS, "thermo_style fancy", "thermo_style style 'fancy' is not one of one, multi, custom"),
    (GRAINS, "thermo_modify lost maybe", "thermo_modify lost 'maybe' is not one of error, warn, ignore"),
    ("", "run 10", "run needs a simulation box: create_box or read_data must come first"),
    (GRAINS, "run -1", "run number of steps must be at least 0, got -1"),
    (GRAINS, "run 1.5", "run number of steps must be a whole number, got '1.5'"),
    (GRAINS, "run 10 every 2 NULL", "run keyword 'every' is not one of upto, pre"),
    (GRAINS, "run 10 pre no", "run pre no is not supported"),
    (GRAINS + "run 10\n", "run 5 upto", "run upto 5: the run is at step 10 already"),
    (GRAINS, "clear all", "clear does not know 'all' at this point"),
    (GRAINS, "shell ls", "shell is not supported"),
    (GRAINS, "run_style respa 2 2", "run_style style 'respa' is not one of verlet"),
    ("", "print '$(1/0)'", "formula '1/0': division by zero"),
]  # fmt: skip


@pytest.mark.parametrize(("before", "wrong", "message"), COMMANDS, ids=[command for _, command, _ in COMMANDS])
def test_a_wrong_command_is_one_line_with_its_place(before: str, wrong: str, message: str, run_deck: Run) -> None:
    """The message starts with file and line of the command, names what is wrong and lists what exists."""
    with pytest.raises(InputError) as caught:
        run_deck(f"{before}{wrong}\nrun 0\n")
    assert caught.value.place is not None
    assert (caught.value.place.file.name, caught.value.place.line) == ("in.deck", before.count("\n") + 1)
    assert caught.value.message.startswith(message)
    assert "\n" not in str(caught.value)


HEAD = "sizes\n\n2 atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\n"  # lines 1 to 8
FIRST = "Atoms\n\n1 1 0.1 2500 0.2 0.5 0.5\n"  # 9 to 11; the second particle is line 12
WHOLE = HEAD + FIRST + "2 1 0.1 2500 0.4 0.5 0.5\n\n"  # the next section starts in line 14
DATA = [
    ("", ": the data file is empty"),
    (HEAD + FIRST, ": the header says 2 atoms, the section Atoms holds 1"),
    (
        HEAD + FIRST + "2 1 0.1 2500 0.4 0.5\n",
        ":12: expected id type diameter density x y z [ix iy iz], the same in every line, got 6 columns",
    ),
    (
        HEAD + FIRST + "2 1 0.1 2500 0.4 0.5 0.5 0 0 0\n",
        ":12: expected id type diameter density x y z [ix iy iz], the same in every line",
    ),
    (HEAD + FIRST + "2 1 0.1 2500 0.4 0.5 nan\n", ":12: expected a number for z, got 'nan'"),
    (HEAD + FIRST + "2 1 0.1 2500 o.4 0.5 0.5\n", ":12: expected a number for x, got 'o.4'"),
    (HEAD + "Atoms\n\n1 1 0.1 2500 0.5 0.5 0.5 0 0 O\n2 1 0.1 2500 0.4 0.5 0.5 0 0 0\n", ":11: expected a number for iz, got 'O'"),
    (HEAD + FIRST + "1 1 0.1 2500 0.4 0.5 0.5\n", ":12: the id was given before, got '1 1 0.1"),
    (HEAD + FIRST + "2 2 0.1 2500 0.4 0.5 0.5\n", ":12: the type must be a whole number from 1 to 1, got '2 2"),
    (HEAD + FIRST + "2.5 1 0.1 2500 0.4 0.5 0.5\n", ":12: the id must be a whole number from 1, got '2.5"),
    (HEAD + FIRST + "2 1 -0.1 2500 0.4 0.5 0.5\n", ":12: the diameter must not be negative"),
    (HEAD + FIRST + "2 1 0.1 0 0.4 0.5 0.5\n", ":12: the density must be above zero"),
    (HEAD + FIRST + "2 1 0.1 2500 1.4 0.5 0.5\n", ":12: the particle is outside the box"),
    (WHOLE + "Velocities\n\n3 0 0 0 0 0 0\n1 0 0 0 0 0 0\n", ":16: the id is not in the section Atoms"),
    (WHOLE + "Velocities\n\n1 0 0 0\n2 0 0 0\n", ":16: expected id vx vy vz wx wy wz"),
    (
        WHOLE + "Bonds\n\n1 1 1 2\n",
        ":14: section 'Bonds' is not supported; supported: Atoms, Velocities",
    ),
    (HEAD + "Atoms # atomic\n\n1 1 0 0 0\n", ":9: expected Atoms of style sphere, got style 'atomic'"),
    (WHOLE + "Atoms\n", ":14: a second section Atoms"),
    ("x\n2 atms\n", ":2: expected a header line such as '10 atoms'"),
    ("x\n-2 atoms\n", ":2: expected a whole number for the number of atoms, got '-2'"),
    ("x\n0 a xlo xhi\n", ":2: expected a number for xhi, got 'a'"),
    ("x\n3 bonds\n", ":2: bonds are not supported: expected spheres only"),
    ("x\n0 1 0 xy xz yz\n", ":2: expected a header line"),
    ("x\n\0\n", ":2: expected a text file, found a binary one"),
    (WHOLE + "Velocities\n\n1 0 0 0 0 0 0\n", ": the header says 2 atoms, the section Velocities holds 1"),
]


@pytest.mark.parametrize(("content", "message"), DATA)
def test_a_wrong_data_file_is_one_line_with_its_place(content: str, message: str, run_deck: Run) -> None:
    """The message names the data file and the line in it."""
    with pytest.raises(InputError) as caught:
        run_deck("boundary f f f\nread_data d\n", d=content)
    assert caught.value.place is not None
    assert f"{str(caught.value).removeprefix(str(caught.value.place.file))}".startswith(message)


def test_an_empty_box_and_a_box_without_types(run_deck: Run) -> None:
    """A data file whose box has no volume, or that names no types, cannot be used."""
    with pytest.raises(InputError, match=r"in.deck:1: read_data the box is empty: xlo must be below xhi"):
        run_deck("read_data d\n", d="x\n1 atom types\n1 1 xlo xhi\n")
    with pytest.raises(InputError, match=r"in.deck:1: read_data d names no atom types"):
        run_deck("read_data d\n", d="x\n0 1 xlo xhi\n")


@pytest.mark.parametrize(
    ("commands", "message"),
    [
        ("create_atoms 1 single 0.25 0.5 0.5 units box\n", r"particles 1 and 3 are at one place, \[0.25, 0.5, 0.5\]"),
        ("displace_atoms all move 1e308 0 0 units box\n" * 2, "particle 1: x is not a finite number"),
    ],
)
def test_a_run_refuses_particles_that_cannot_be(commands: str, message: str, run_deck: Run) -> None:
    """Two particles at one place and positions that overflowed are found by the run that would need them."""
    with pytest.raises(InputError, match=message) as caught:
        run_deck(GRAINS + commands + "run 1\n")
    assert caught.value.place is not None
    assert caught.value.place.line == 7 + commands.count("\n")


def test_a_particle_without_mass_is_named(run_deck: Run) -> None:
    """The scene needs every mass; a particle that got none is named by its id."""
    backend = run_deck(GRAINS + "run 1\n").backend
    assert isinstance(backend, DryBackend)
    atoms = backend.runs[0].setup.atoms
    assert atoms is not None
    for nothing in (float("nan"), 0.0):
        atoms.mass[1] = nothing
        with pytest.raises(InputError, match="particle 2 has no mass"):
            _ = backend.runs[0].scene


@pytest.mark.lammps
def test_lammps_words_reach_the_user_when_it_refuses(run_deck: Run) -> None:
    """A random command is checked by LAMMPS; its complaint comes back in one line with the deck's place."""
    with pytest.raises(InputError) as caught:
        run_deck(GRAINS + "create_atoms 1 random 5 -3 NULL\n")
    assert caught.value.place is not None
    assert caught.value.place.line == 7
    assert "LAMMPS refuses this command: " in str(caught.value)
    assert "seed" in str(caught.value)

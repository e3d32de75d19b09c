"""write_restart, clear and read_restart in the native engine: what comes back, what does not, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demsolver.memories import Memories, WallMemory
from demsolver.scene import Box
from demverify.deck.convert import conversion
from demverify.deck.particles import ARRAYS
from demverify.deck.restart import Restart, newest, read_restart_file, write_restart_file
from demverify.deck.setup import Atoms
from demverify.engines.base import Job
from demverify.engines.native import ENGINE
from demverify.errors import InputError
from demverify.frames import Frame
from demverify.runs import plan

PAIR = {
    "lammps": "pair_style granular\npair_coeff * * hooke 1e4 100 tangential linear_history 7e3 1.0 0.5 rolling sds 1e3 1 0.1 damping mass_velocity\n",
    "liggghts": "pair_style gran model hooke/stiffness tangential history rolling_friction epsd\npair_coeff * *\n",
}
WALL = {
    "lammps": "fix {} all wall/gran granular hooke 1e4 100 tangential linear_history 7e3 1.0 0.5 damping mass_velocity zplane -0.05 NULL\n",
    "liggghts": "fix {} all wall/gran model hooke/stiffness tangential history primitive type 1 zplane -0.05\n",
}
ROLLING_WALL = WALL["lammps"].replace("zplane", "rolling sds 1e3 1 0.1 zplane").format("w")
MATERIAL = {
    "lammps": "",
    "liggghts": "".join(
        f"fix m{k} all property/global {name} peratomtypepair 1 {value}\n"
        for k, (name, value) in enumerate(
            {
                "kn": 1e4, "kt": 7e3, "gamman": 100, "gammat": 100, "coefficientFriction": 0.5, "coefficientRollingFriction": 0.1,
                "coefficientRollingViscousDamping": 0.1,
            }.items()
        )
    ),
}  # fmt: skip
SPIN = {"lammps": "set atom 1 omega 0 0 30\n", "liggghts": "set atom 1 omegaz 30\n"}
STYLE = {"lammps": "atom_style sphere\ncomm_modify vel yes\n", "liggghts": "atom_style granular\ncommunicate single vel yes\n"}
REST = "neighbor 0.002 bin\nneigh_modify delay 0\ntimestep 1e-6\nfix move all nve/sphere\n"
DIALECTS = ("lammps", "liggghts")


def head(dialect: str) -> str:
    """Two spheres touch, a third lies on a wall, a fourth and a fifth touch across a periodic face; 200 steps."""
    return f"""units si
{STYLE[dialect]}boundary f p f
newton off
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05
create_box 1 box
create_atoms 1 single -0.00499 0.0 0.0
create_atoms 1 single 0.00499 0.0005 0.0
create_atoms 1 single 0.0 0.02 -0.04501
create_atoms 1 single 0.02 0.04999 0.0
create_atoms 1 single 0.0205 -0.04005 0.0
set type 1 diameter 0.01 density 2500
set atom 1 vx 0.05
set atom 2 vx -0.05
set atom 3 vx 0.05
set atom 4 vy 0.2
{SPIN[dialect]}group second id 2
{MATERIAL[dialect]}{PAIR[dialect]}{WALL[dialect].format("w")}{REST}run 200
"""


def again(dialect: str, *, pair: str | None = None, wall: str | None = None) -> str:
    return MATERIAL[dialect] + (PAIR[dialect] if pair is None else pair) + (WALL[dialect].format("w") if wall is None else wall) + REST


BACK = "write_restart state.*\nclear\nread_restart state.200\n"


def run(text: str, folder: Path) -> list[Frame]:
    folder.mkdir(parents=True, exist_ok=True)
    deck = folder / "in.deck"
    deck.write_text(text)
    outcome, outputs = ENGINE.run_with(Job(deck, folder / "out", {}, 20), keep=True)
    assert outcome.status == "ok", outcome.reason
    return outputs.frames


def last_frames(text: str, folder: Path, step: int = 200) -> list[Frame]:
    """The frames after the second start, which wraps what has left through a periodic face."""
    return [frame for frame in run(text, folder) if frame.step > step]


def same(a: list[Frame], b: list[Frame]) -> bool:
    return [f.step for f in a] == [f.step for f in b] and all(
        np.array_equal(p.columns[c], q.columns[c]) for p, q in zip(a, b, strict=True) for c in p.columns
    )


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_restarted_deck_goes_on_to_the_last_bit(dialect: str, tmp_path: Path) -> None:
    """Law: `run N; run N` and `run N; write_restart; clear; read_restart; run N` are one motion, as in LAMMPS and LIGGGHTS (measured)."""
    straight = last_frames(head(dialect) + "run 200\n", tmp_path / "a")
    assert same(last_frames(head(dialect) + BACK + again(dialect) + "run 200\n", tmp_path / "b"), straight)
    if dialect == "lammps":  # the pair style and the time step come back
        text = head(dialect) + BACK + again(dialect, pair="").replace("timestep 1e-6\n", "") + "run 200\n"
        assert same(last_frames(text, tmp_path / "c"), straight)
    other = again(dialect, wall=WALL[dialect].format("other"))
    assert not same(last_frames(head(dialect) + BACK + other + "run 200\n", tmp_path / "d"), straight)
    log = (tmp_path / "d" / "out" / "log.native").read_text()
    assert "read_restart: what fix w remembered is not used, for no wall of this ID was stated again" in log


def test_a_deck_of_its_own_goes_on_from_the_file(tmp_path: Path) -> None:
    """Law: it does not matter which process goes on; the file may lie beside the deck, and `*` means the largest step."""
    straight = last_frames(head("lammps") + "run 200\n", tmp_path / "a")
    run(head("lammps") + "write_restart state.*\n", tmp_path / "b")
    (tmp_path / "c").mkdir()
    for step in ("99", "200"):
        (tmp_path / "c" / f"state.{step}").write_bytes((tmp_path / "b" / "out" / "state.200").read_bytes() if step == "200" else b"no")
    assert same(last_frames("read_restart state.*\n" + again("lammps") + "run 200\n", tmp_path / "c"), straight)


def test_what_comes_back_and_what_does_not(tmp_path: Path) -> None:
    """Law (measured in both engines): step, groups, box and particles come back, the time step in LAMMPS only; fixes and computes do not."""
    for dialect, dt in (("lammps", 1e-6), ("liggghts", 1e-8)):
        (tmp_path / dialect).mkdir()
        deck = tmp_path / dialect / "in.deck"
        deck.write_text(head(dialect) + "variable q equal 3\ncompute k all ke\n" + BACK + MATERIAL[dialect] + "variable p equal v_q+step\nrun 0\n")
        setup = plan(deck, {}).setup
        assert (setup.step, setup.dt, setup.units, setup.boundary) == (200, dt, "si", ("ff", "pp", "ff"))
        assert setup.groups["second"] > 0
        assert setup.atoms is not None
        assert (setup.atoms.n, setup.computes) == (5, {})
        assert not {"w", "move"} & set(setup.fixes)
        assert setup.variables.exact("p", None) == 203.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("read_restart state.200\n", "read_restart must come before the simulation box is made"),
        ("clear\nread_restart nofile\nrun 1\n", "the restart file 'nofile' does not exist (looked for "),
        ("clear\nread_restart in.deck\nrun 1\n", "in.deck is not a restart file of the native engine"),
        ("clear\nread_restart of_lammps\nrun 1\n", "of_lammps is not a restart file of the native engine"),
        ("clear\nread_restart empty\nrun 1\n", "empty is not a restart file of the native engine"),
        ("clear\nread_restart half\nrun 1\n", "half is damaged: not a whole restart file"),
        ("clear\nread_restart flipped\nrun 1\n", "flipped is damaged: not a whole restart file"),
        ("clear\nread_restart old\nrun 1\n", "old is a restart file of version 0; this is demverify with version 1"),
        ("clear\nread_restart poor\nrun 1\n", "poor is damaged: not a whole restart file"),
        ("clear\nread_restart archive\nrun 1\n", "archive is not a restart file of the native engine"),
        ("clear\nread_restart array\nrun 1\n", "array is not a restart file of the native engine"),
        ("clear\nread_restart theirs\nrun 1\n", "the restart file is of a liggghts deck, and this is a lammps deck"),
        ("write_restart ../out.restart\n", "write_restart writes to '../out.restart', outside the run folder"),
        ("write_restart thermo.csv\n", "write_restart writes to 'thermo.csv', as does the run itself"),
        ("write_restart a.%\n", "write_restart a '%' in the file name 'a.%' (one file a processor) is not supported"),
        ("write_restart\n", "write_restart ends where a file was expected"),
        ("clear\nwrite_restart a\n", "write_restart needs a simulation box"),
        ("clear now\n", "clear "),
        ("clear\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n", "create_box is not supported after clear: a deck describes one system"),
        (BACK + again("lammps", pair=PAIR["lammps"].replace(" rolling sds 1e3 1 0.1", "")) + "run 1\n", "read_restart: pairs: contacts remember "),
        (BACK + again("lammps", wall=ROLLING_WALL) + "run 1\n", "read_restart: wall w: contacts remember "),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_line_with_its_place(text: str, message: str, tmp_path: Path) -> None:
    """Law: a missing, foreign, damaged, old or other dialect's file, a name out of the folder, another law: one line that says so."""
    state = some_state("lammps")
    write_restart_file(tmp_path / "whole", state)
    data = (tmp_path / "whole").read_bytes()
    (tmp_path / "half").write_bytes(data[: len(data) // 2])
    at = data.index(state.atoms.x.tobytes())
    (tmp_path / "flipped").write_bytes(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
    (tmp_path / "empty").write_bytes(b"")
    (tmp_path / "of_lammps").write_bytes(b"LammpS RestartT\0\1\0\0\0" + bytes(range(256)))
    write_restart_file(tmp_path / "theirs", some_state("liggghts"))
    for name, header in {"old": {"magic": "demverify restart", "version": 0}, "poor": {"magic": "demverify restart", "version": 1}}.items():
        with (tmp_path / name).open("wb") as out:
            np.savez(out, header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8))
    with (tmp_path / "archive").open("wb") as out:
        np.savez(out, a=np.zeros(3))
    with (tmp_path / "array").open("wb") as out:
        np.save(out, np.zeros(3))
    with pytest.raises(InputError) as caught:
        run(head("lammps") + text, tmp_path)
    assert caught.value.message.startswith(message)
    assert caught.value.place is not None
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out" / "out.restart").exists()


def some_state(dialect: str, n: int = 3, seed: int = 0) -> Restart:
    rng = np.random.default_rng(seed)
    ids, whole = np.arange(1, n + 1), np.ones(n, dtype=np.int64)
    x, v, omega = rng.normal(size=(3, n, 3))
    atoms = Atoms(ids, whole, x, v, omega, rng.uniform(size=n), rng.uniform(size=n), whole, np.zeros((n, 3), dtype=np.int64), 0 * whole)
    walls = {"floor": WallMemory(("friction rotated_history",), rng.normal(size=(n, 3)), np.ones(n, dtype=np.uint8))}
    pairs = (ids[:1], ids[-1:], np.array([13]), np.ones(1, dtype=np.uint8), rng.normal(size=(1, 3)))
    memories = Memories(ids, ids[::-1].copy(), ("friction rotated_history",), *pairs, walls, rng.normal(size=6))
    settings = {
        "units": "si", "dimension": 3, "boundary": ["ff", "pp", "ss"], "ntypes": 1, "groups": {"all": 0, "b": 1}, "pair_style": ["granular"],
        "pair_coeffs": [["*", "*", "hooke", "1", "0"]], "step": 7, "time": 0.1, "timestep": 1e-6,
    }  # fmt: skip
    return Restart(dialect, settings, Box(rng.normal(size=3), 3 + rng.normal(size=3), ("ff", "pp", "ss"), np.full(3, 0.1)), atoms, memories)  # type: ignore[arg-type]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 9))
def test_what_is_written_is_read(tmp_path_factory: pytest.TempPathFactory, seed: int, n: int) -> None:
    """Law: read(write(state)) is the state, to the last bit."""
    path, state = tmp_path_factory.mktemp("r") / "state", some_state("lammps", n, seed)
    write_restart_file(path, state)
    found = read_restart_file(path)
    assert (found.dialect, found.settings, found.box.boundary) == (state.dialect, state.settings, state.box.boundary)
    arrays = [(getattr(found.atoms, name), getattr(state.atoms, name)) for name in ARRAYS]
    arrays += [(found.box.lo, state.box.lo), (found.box.hi, state.box.hi), (found.box.margin, state.box.margin)]
    a, b = found.memories, state.memories
    assert a is not None
    assert b is not None
    assert a.laws == b.laws
    arrays += [(getattr(a, name), getattr(b, name)) for name in ("id", "rows", "i", "j", "shift", "touching", "memory", "tally")]
    assert a.walls["floor"].laws == b.walls["floor"].laws
    arrays += list(zip(a.walls["floor"][1:], b.walls["floor"][1:], strict=True))
    assert all(np.array_equal(p, q) and p.dtype == q.dtype for p, q in arrays)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_no_damage_gives_a_traceback(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """Law: a file cut short or with a byte changed is read as it was, or refused in one line."""
    path = tmp_path_factory.mktemp("r") / "state"
    write_restart_file(path, some_state("lammps"))
    whole = bytearray(path.read_bytes())
    at = data.draw(st.integers(0, len(whole) - 1))
    if data.draw(st.booleans()):
        whole = whole[:at]
    else:
        whole[at] ^= data.draw(st.integers(1, 255))
    path.write_bytes(bytes(whole))
    try:
        found = read_restart_file(path)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert np.array_equal(found.atoms.x, some_state("lammps").atoms.x)


def test_nothing_half_written_is_left(tmp_path: Path) -> None:
    """Law: where writing fails the old file stands."""
    path = tmp_path / "state"
    write_restart_file(path, some_state("lammps"))
    old = path.read_bytes()
    broken = some_state("lammps")
    broken.settings["units"] = object()
    with pytest.raises(TypeError):
        write_restart_file(path, broken)
    assert path.read_bytes() == old
    assert [one.name for one in tmp_path.iterdir()] == ["state"]


def test_the_largest_step_is_a_number() -> None:
    """Law: 1000 is more than 99; a name without a star means itself."""
    assert newest("s.*", ["s.99", "s.1000", "s.x", "t.5000"]) == "s.1000"
    assert newest("s.*.r", ["s.99.r", "s.1000"]) == "s.99.r"
    assert newest("s", ["s.1"]) is None


def test_a_deck_that_restarts_is_not_converted(tmp_path: Path) -> None:
    """Law: what cannot be said in one deck of the other dialect is refused with its place."""
    deck = tmp_path / "in.deck"
    text = head("lammps") + BACK + again("lammps") + "run 1\n"
    deck.write_text(text.replace(" rolling sds 1e3 1 0.1", ""))
    with pytest.raises(InputError, match="clear: a deck that restarts is not converted"):
        conversion(plan(deck, {}), "liggghts", "data")

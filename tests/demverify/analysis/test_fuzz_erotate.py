"""`erotate` from file to rows, fuzzed: dumps cut at any byte, damaged dumps, and frames at random against a plain sum."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import demverify
from demverify import cli_erotate
from demverify.analysis.series import Series
from demverify.errors import InputError
from demverify.formats import dump
from demverify.formats.dump_binary import binary_frame
from demverify.formats.dump_text_writer import text_frame
from demverify.frames import Frame

NAMES = ("id", "radius", "mass", "omegax", "omegay", "omegaz", "vx", "vy", "vz")
BOX = np.array([[-1.0, 1.0]] * 3)
CLUMPS = """ITEM: TIMESTEP
{step}
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff pp ff
-1 1
-1 1
-1 1
ITEM: ATOMS id id_multisphere x y z omegax omegay omegaz radius mass{end}
2 1 0.3 0.1 0.1 {spin} 0 2 0.2 3{end}
3 -1 0.1 -.5 0 0 1.5 {spin} 0.3 2{end}
1 1 0.1 0.1 0.1 {spin} 0 2 0.2 3{end}
"""
FUZZ = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def spheres(step: int) -> Frame:
    """Two spheres that move and spin, not in the order of their ids."""
    rng = np.random.default_rng(step)
    values = {name: rng.integers(1, 64, 2) / 64 for name in NAMES}  # few digits
    return Frame(step, BOX, ("pp", "pp", "pp"), values | {"id": np.array([7.0, 3.0])})


def clumps(step: int) -> bytes:
    """A clump of two spheres and a free one as LIGGGHTS writes them, a blank at the end of lines."""
    return CLUMPS.format(step=step, spin=step / 64, end=" ").encode()


STEPS = (100, 200)
FILES: dict[str, list[bytes]] = {
    "lammps": [text_frame(spheres(step), NAMES, "lammps") for step in STEPS],
    "liggghts": [clumps(step) for step in STEPS],
    "binary": [binary_frame(spheres(step), NAMES, "lammps") for step in STEPS],
}
KNOWN_AT = {"lammps": len("ITEM: "), "liggghts": len("ITEM: "), "binary": 8 + len("DUMPCUSTOM")}
"""From how many bytes on a file shows what it is."""


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Series | InputError]:
    """read(content, one_block=True): the rows of a file, or the error; any other exception is a failure. Otherwise every frame is a block."""
    path = tmp_path / "d.dump"

    def outcome(content: bytes, *, one_block: bool = True, **options: Any) -> Series | InputError:
        path.write_bytes(content)
        monkeypatch.setattr(dump, "_BLOCK", 1 << 25 if one_block else 1)
        try:
            return demverify.erotate(path, **options)
        except InputError as error:
            assert "\n" not in str(error)
            assert str(path) in str(error)
            return error

    return outcome


Read = Callable[..., Series | InputError]


@pytest.mark.parametrize("kind", FILES)
def test_cut_at_every_byte(kind: str, read: Read) -> None:
    """Law: of a file cut anywhere the rows of all frames that are whole come bit for bit, and a note unless it is cut between frames; only
    a file too short to show what it is is an error."""
    frames = FILES[kind]
    whole = b"".join(frames)
    ends = np.cumsum([0, *map(len, frames)]).tolist()
    true = read(whole)
    assert isinstance(true, Series)
    assert [(row.step, row.erotate > 0.0) for row in true.rows] == [(step, True) for step in STEPS]
    for cut in range(len(whole)):
        for one_block in (True, False) if cut % 16 == 0 else (True,):
            found = read(whole[:cut], one_block=one_block)
            if cut < KNOWN_AT[kind]:
                assert isinstance(found, InputError), cut
                continue
            assert isinstance(found, Series), (cut, found)
            assert found.rows == true.rows[: sum(end <= cut for end in ends) - 1], cut
            assert [("ends" in note, "the frames before it are used" in note) for note in found.notes] == [(True, True)] * (cut not in ends), cut


WORDS = (b"0 1 -1 2 9 7 3 1e308 -1e308 1e-320 nan inf -inf 1e400 99999999999999999999 9007199254740993 1_0 0x1 + . e \xff \x00 pp "
         b"ITEM: id mol id_multisphere type quat1 shapex density diameter xs xu x radius mass omegax vx").split()  # fmt: skip
LINES = [b"ITEM: TIMESTEP", b"ITEM: UNITS\nlj", b"ITEM: TIME\n0.5", b"ITEM: ENTRIES id", b"ITEM: NUMBER OF ATOMS\n0", b"0 1", b"", b"\r"]
Change = tuple[str, int, int, bytes]


def changes() -> st.SearchStrategy[list[Change]]:
    """Up to three: (what, where, where else, what to put there); places are taken modulo what there is."""
    place = st.integers(0, 1 << 12)
    letters = st.binary(min_size=1, max_size=9)
    one = st.tuples(st.sampled_from(["flip", "set", "insert", "drop"]), place, place, letters)
    word = st.tuples(st.sampled_from(["word", "word in"]), place, place, st.sampled_from(WORDS))
    line = st.tuples(st.sampled_from(["line in", "swap lines", "double line", "drop line"]), place, place, st.sampled_from(LINES))
    return st.lists(one | word | line, min_size=1, max_size=3)


def changed(content: bytes, made: list[Change]) -> bytes:
    """The content with the changes, one after the other."""
    for what, first, second, new in made:
        separator = b"\n" if "line" in what else b" " if "word" in what else None
        items: list[Any] = content.split(separator) if separator else list(content)
        i, j = (place % max(1, len(items)) for place in (first, second))
        if not items:
            return content
        if what == "flip":
            items[i] ^= 1 << second % 8
        elif what.startswith("swap"):
            items[i], items[j] = items[j], items[i]
        elif what.startswith("double"):
            items.insert(j, items[i])
        elif what.startswith("drop"):
            del items[i : i + 1 + (second % 30 if what == "drop" else 0)]
        else:
            there = what in ("set", "word")
            items[i : i + there] = [new] if separator else new
        content = separator.join(items) if separator else bytes(items)
    return content


def told(series: Series | InputError) -> object:
    """What two readings must have in common; nan equals nan."""
    return series.place if isinstance(series, InputError) else [repr(row) for row in series.rows]


@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning", "ignore:invalid value:RuntimeWarning")  # the command line hides them too
@pytest.mark.parametrize("kind", FILES)
@FUZZ
@given(made=changes())
@example(made=[("word", 40, 0, b"1e308")])
def test_a_damaged_file_is_read_or_refused(kind: str, read: Read, made: list[Change]) -> None:
    """Law: rows or an InputError, the same whether it is read in one block or in many; what is not finite is noted with its step."""
    content = changed(b"".join(FILES[kind]), made)
    found = read(content)
    if isinstance(found, Series):
        for row in found.rows:
            fine = all(map(math.isfinite, (row.erotate, row.ke or 0.0, row.time or 0.0)))
            assert fine or any(f"step {row.step}: " in note for note in found.notes), row
    assert told(found) == told(read(content, one_block=False))


def test_the_changes_reach_the_numbers(read: Read) -> None:
    """The unchanged files are right, and changes at some places are read: otherwise the fuzz would stop at the first line."""
    for kind, frames in FILES.items():
        whole = b"".join(frames)
        kept = [isinstance(read(changed(whole, [("flip", at, 0, b"")])), Series) for at in range(0, len(whole), 7)]
        assert 0.1 < np.mean(kept) < 0.95, kind


@pytest.mark.parametrize("number", ["inf", "-inf", "nan", "1e300", "1.5"])
def test_the_number_of_a_body(read: Read, number: str) -> None:
    """Law: a body has a whole number; what is none does not make its members free spheres."""
    found = read(clumps(100).replace(b" 1 0.3 0.1", f" {number} 0.3 0.1".encode()))
    assert isinstance(found, InputError)
    assert "a body has the number" in found.message


TINY, HUGE = 1e-30, 1e30  # products of eight such numbers, density r^5 omega^2, neither overflow nor lose digits
NUMBERS = st.just(0.0) | st.floats(TINY, HUGE) | st.floats(-HUGE, -TINY) | st.integers(-9, 9).map(float)
POSITIVE = st.just(0.0) | st.floats(TINY, HUGE)
ODD = st.sampled_from([math.nan, math.inf, -math.inf])
SPIN, SPEED = ("omegax", "omegay", "omegaz"), ("vx", "vy", "vz")
Rows = list[dict[str, float]]


@st.composite
def runs(draw: st.DrawFn) -> tuple[tuple[str, ...], list[tuple[int, Rows]]]:
    """The columns of a dump, and its frames: (step, rows). Steps may repeat or go back, particles come and go, in any order."""
    often = st.sampled_from([True] * 7 + [False])
    size, weight = st.sampled_from(["radius", "diameter", "radius diameter"]), st.sampled_from(["mass", "density", "type", "mass density"])
    columns = [draw(size), draw(weight)]
    columns += [" ".join(names) for names in (SPIN, SPEED) if draw(often)] + ["type x"] * draw(st.booleans())
    names = list(dict.fromkeys(["id", *" ".join(columns).split()]))
    names = draw(st.permutations(names)) if draw(st.booleans()) else names
    names = names[:-1] if draw(st.integers(0, 9)) == 0 and names[-1] != "id" else names
    frames = []
    for _ in range(draw(st.integers(0, 4))):
        ids = draw(st.lists(st.integers(1, 9), unique=True, max_size=5))
        rows = [{name: draw(_number(name)) for name in names} | {"id": float(i)} for i in ids]
        if rows and complete(names) and draw(st.integers(0, 4)) == 0:
            draw(st.sampled_from(rows))[draw(st.sampled_from([name for name in names if name != "id"]))] = draw(ODD)
        frames.append((draw(st.integers(0, 5)), rows))
    return tuple(names), frames


def complete(names: tuple[str, ...] | list[str]) -> bool:
    """Whether these columns tell the energy, the density being known."""
    return bool({"radius", "diameter"} & set(names)) and set(SPIN) <= set(names)


def _number(name: str) -> st.SearchStrategy[float]:
    return st.just(1.0) if name in ("id", "type") else NUMBERS if name in (*SPIN, *SPEED, "x") else POSITIVE


def as_text(names: tuple[str, ...], frames: list[tuple[int, Rows]]) -> bytes:
    """The dump, all digits."""
    head = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS {}\n"
    text = ""
    for step, rows in frames:
        text += head.format(step, len(rows), " ".join(names))
        text += "".join(" ".join(repr(row[name]) for name in names) + "\n" for row in rows)
    return text.encode()


DENSITY = 2.5


def used(row: dict[str, float]) -> list[float]:
    """mass, radius, spin of a row, mass from a density where there is none: what its energy is made of."""
    radius = row["radius"] if "radius" in row else 0.5 * row["diameter"]
    mass = row["mass"] if "mass" in row else row.get("density", DENSITY) * 4.0 / 3.0 * math.pi * radius**3
    return [mass, radius, *(row[name] for name in SPIN)]


def check_row(found: Any, step: int, rows: Rows, notes: tuple[str, ...]) -> None:
    """A row against the sum over its particles in plain Python; 1e-14: some ten roundings of 1.1e-16 a term, which are all positive."""
    assert (found.step, found.n, found.time) == (step, len(rows), None)
    odd = [row for row in rows if not all(map(math.isfinite, used(row)))]
    if odd:
        assert math.isnan(found.erotate)
        assert all(any(f"step {step}: " in note and f" of particle {row['id']:.0f} is not finite" in note for note in notes) for row in odd)
        return
    terms = [0.2 * m * r * r * math.fsum(w * w for w in spin) for m, r, *spin in map(used, rows)]
    assert abs(found.erotate - math.fsum(terms)) <= 1e-14 * math.fsum(terms)
    assert found.erotate == found.by_shape["sphere"]
    if rows and all(name in rows[0] for name in SPEED) and ("mass" in rows[0] or all(used(row)[0] for row in rows)):
        terms = [0.5 * used(row)[0] * math.fsum(row[name] ** 2 for name in SPEED) for row in rows]
        if all(map(math.isfinite, terms)):
            assert abs(found.ke - math.fsum(terms)) <= 1e-14 * math.fsum(terms)
        else:
            assert not math.isfinite(found.ke)
            assert any(f"step {step}: v of particle " in note for note in notes)
    else:
        assert found.ke == (None if rows else 0.0)


@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning", "ignore:invalid value:RuntimeWarning")
@FUZZ
@given(run=runs(), one_block=st.booleans())
def test_frames_at_random(read: Read, run: tuple[tuple[str, ...], list[tuple[int, Rows]]], one_block: bool) -> None:
    """Law: of every frame the energy is the sum over its rows; a step that is not beyond the last takes the place of that and all later ones; what
    is missing is an error."""
    names, frames = run
    found = read(as_text(names, frames), one_block=one_block, density=DENSITY)
    if not frames or (any(rows for _, rows in frames) and not complete(names)):
        assert isinstance(found, InputError), found
        return
    assert isinstance(found, Series), found
    left: list[tuple[int, Rows]] = []
    for step, rows in frames:
        left = [*((before, those) for before, those in left if before < step), (step, rows)]
    assert len(found.rows) == len(left)
    for row, (step, rows) in zip(found.rows, left, strict=True):
        check_row(row, step, rows, found.notes)


@pytest.mark.parametrize(("speed", "note"), [(math.nan, "step 100: v of particle 2 is not finite"), (1e200, "step 100: ke not finite")])
@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_what_is_not_finite_is_told(read: Read, speed: float, note: str) -> None:
    """Law: a speed that is none, and a sum that is too large, are noted and make the status 1; what is known of the frame stands."""
    names = ("id", *SPIN, *SPEED, "radius", "mass")
    found = read(as_text(names, [(100, [dict.fromkeys(names, 1.0), dict.fromkeys(names, 2.0) | {"vy": speed}])]))
    assert isinstance(found, Series)
    assert found.notes == (note,)
    assert found.rows[0].erotate == pytest.approx(0.2 * 3.0 + 0.2 * 2.0**3 * 12.0, rel=1e-15)
    assert not cli_erotate._sound(found)

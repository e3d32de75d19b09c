"""`demverify view`: what is in the page is what the dumps and `demverify erotate` say; what cannot be shown is told."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from demverify.formats.dump import read_dump
from demverify.view import frames as frames_module
from tests.support.cli import Call, files_in

DATA = Path(__file__).parents[2] / "data"
Write = Callable[..., Path]

HEAD = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS {faces}\n-1 1\n-1 1\n-1 1\nITEM: ATOMS {columns}\n{rows}"
COLUMNS = "id x y z vx vy vz omegax omegay omegaz radius mass id_multisphere"
CLUMPS = """1 0 0 0 0 0 2 0 0 3 0.1 7 4
2 0.15 0 0 0 0.45 2 0 0 3 0.1 7 4
3 -0.5 0.5 0 1 0 0 0 2 0 0.2 5 0
4 0.5 -0.5 0.3 0 0 0 1 0 0 0.1 9 6
5 0.5 -0.5 0.45 0 -0.15 0 1 0 0 0.1 9 6
"""


def dump(*steps: int, rows: str = CLUMPS, columns: str = COLUMNS, faces: str = "ff ff ff") -> str:
    """A text dump with the same rows at every step."""
    return "".join(HEAD.format(step=step, n=rows.count("\n"), rows=rows, columns=columns, faces=faces) for step in steps)


def array(text: str, kind: str) -> np.ndarray:
    """What a page's base64 holds."""
    return np.frombuffer(base64.b64decode(text), kind)


def shown(page: Path) -> list[dict[str, Any]]:
    """The frames in a page: id, kind, body, size, x (where it was), quat, erotate, ke, box, step, time."""
    found = re.search(r'<script type="application/json" id="numbers">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found
    numbers, frames = json.loads(found[1]), []
    for frame in numbers["frames"]:
        particles, values = numbers["particles"][frame["particles"]], array(frame["numbers"], "<f4").astype(float)
        n, widths = particles["n"], (3, 4, 1, 1) if frame["turned"] else (3, 0, 1, 1)
        x, quat, erotate, ke = np.split(values, np.cumsum([width * n for width in widths])[:-1])
        frames.append({
            **frame, "n": n, "id": array(particles["id"], "<f8"), "body": array(particles["body"], "<f8"),
            "kind": [numbers["kinds"][k] for k in array(particles["kind"], "<u1")], "size": array(particles["size"], "<f4").reshape(n, 5),
            "x": x.reshape(n, 3) + numbers["origin"], "quat": quat.reshape(-1, 4), "erotate": erotate, "ke": ke,
        })  # fmt: skip
    return frames


def energies(demverify: Call, folder: Path, *words: object) -> dict[tuple[int, str, int], float]:
    """Of (step, shape, id), as `erotate --per-particle` gives them."""
    demverify("erotate", *words, "--per-particle", "--json", folder / "energies.json")
    return {(row["step"], row["shape"], row["id"]): row["erotate"] for row in json.loads((folder / "energies.json").read_text())}


@pytest.mark.parametrize("name", ["free", "collide", "scheme3_contacts", "pair_elastic"])
def test_superquadrics_are_those_of_the_dump(demverify: Call, tmp_path: Path, name: str) -> None:
    """Law: places, orientations and shapes are those of the dump and energies those of erotate, in the seven digits of float32."""
    path, page = DATA / "superquadric" / f"{name}.dump.gz", tmp_path / "view.html"
    done = demverify("view", path, "-o", page)
    assert (done.status, done.err) == (0, "")
    frames, dumped, wanted = shown(page), list(read_dump(path)), energies(demverify, tmp_path, path)
    assert [frame["step"] for frame in frames] == [frame.step for frame in dumped]
    for frame, there in zip(frames, dumped, strict=True):
        assert set(frame["kind"]) == {"superquadric"}
        assert_array_equal(frame["id"], there.columns["id"])
        names = ("shapex", "shapey", "shapez", "blockiness1", "blockiness2")
        assert_array_equal(frame["size"], np.column_stack([there.columns[column] for column in names]).astype("f4"))
        np.testing.assert_allclose(frame["x"], there.vectors("x", "y", "z"), rtol=0, atol=1e-6 * np.abs(there.box).max())
        quat = np.column_stack([there.columns[f"quat{i}"] for i in (1, 2, 3, 4)])
        np.testing.assert_allclose(frame["quat"], quat / np.linalg.norm(quat, axis=1)[:, None], rtol=0, atol=1e-7)
        assert_array_equal(frame["erotate"], np.float32([wanted[there.step, "superquadric", int(i)] for i in frame["id"]]))
        v, mass = there.vectors("vx", "vy", "vz"), there.columns["mass"]
        np.testing.assert_allclose(frame["ke"], 0.5 * mass * (v**2).sum(axis=1), rtol=2e-7)


def test_members_of_a_clump_have_its_energy(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: spheres of one clump bear the energies of the whole clump, those that erotate gives it; free spheres their own."""
    path, page = write(dump(0, 10), "d.dump"), tmp_path / "view.html"
    assert demverify("view", path, "-o", page).status == 0
    wanted = energies(demverify, tmp_path, path)
    for frame in shown(page):
        assert frame["kind"] == ["multisphere", "multisphere", "sphere", "multisphere", "multisphere"]
        assert frame["body"].tolist() == [4, 4, 0, 6, 6]
        of = [(frame["step"], "multisphere", 4), (frame["step"], "sphere", 3), (frame["step"], "multisphere", 6)]
        assert_array_equal(frame["erotate"], np.float32([wanted[of[k]] for k in (0, 0, 1, 2, 2)]))
        np.testing.assert_allclose(frame["ke"][[0, 1, 3, 4]], np.repeat([3.5 * (4 + 0.225**2), 4.5 * 0.075**2], 2), rtol=1e-6)
        assert frame["ke"][2] == 2.5
        assert not len(frame["quat"])


BODIES = """ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n2\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1
ITEM: ENTRIES id_multisphere masstotal vcm[1] vcm[2] vcm[3] omega[1] omega[2] omega[3] quat[1] quat[2] quat[3] quat[4] {inertia}
6 9 0 1 0 1 0 0 1 0 0 0 5 2 3\n4 7 0 0 2 0 0 3 1 0 0 0 1 1 4\n""".replace("{inertia}", "inertia[1] inertia[2] inertia[3]")


def test_bodies_of_a_dump_of_their_own(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: with --bodies the members bear the energies of the bodies listed there, by number; steps that it lacks are left out, and told."""
    particles, bodies = write(dump(0, 10, 20), "d.dump"), write("".join(BODIES.format(step=step) for step in (0, 20)), "b.local")
    done = demverify("view", particles, "--bodies", bodies, "-o", tmp_path / "view.html")
    assert done.status == 0
    assert "1 steps with particles but no bodies are left out: 10" in done.err
    frames = shown(tmp_path / "view.html")
    assert [frame["step"] for frame in frames] == [0, 20]
    for frame in frames:
        assert frame["erotate"][[0, 1, 3, 4]].tolist() == [18.0, 18.0, 2.5, 2.5]
        assert frame["ke"].tolist() == [14.0, 14.0, 2.5, 4.5, 4.5]


def test_periodic_boxes(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: in a periodic box every particle is in it, and a clump across a face is in one piece, its middle in the box."""
    rows = CLUMPS.replace("1 0 0 0 ", "1 0.95 0 0 ").replace("2 0.15 0 0 ", "2 -0.9 0 0 ").replace("3 -0.5 0.5 ", "3 -2.5 3.5 ")
    demverify("view", write(dump(0, rows=rows, faces="pp pp ff"), "d.dump"), "-o", tmp_path / "view.html")
    x = shown(tmp_path / "view.html")[0]["x"]
    np.testing.assert_allclose(x[:3], [[-1.05, 0, 0], [-0.9, 0, 0], [-0.5, -0.5, 0]], atol=1e-6)


def test_shapes_are_written_once(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: ids and shapes are in the page once for all frames in which they are the same, and anew when a particle comes."""
    more = CLUMPS + "6 0 0 0.9 0 0 0 0 0 0 0.05 1 0\n"
    demverify("view", write(dump(0, 10) + dump(20, 30, rows=more), "d.dump"), "-o", tmp_path / "view.html")
    assert [(frame["particles"], frame["n"]) for frame in shown(tmp_path / "view.html")] == [(0, 5), (0, 5), (1, 6), (1, 6)]


@pytest.mark.parametrize(
    ("words", "steps", "note"),
    [
        ((), range(0, 200, 10), ""),
        (("--every", 3), range(0, 200, 30), ""),
        (("--most-frames", 20), range(0, 200, 10), ""),
        (("--most-frames", 6), range(0, 200, 40), "5 of 20 frames are in the page, one of every 4 "),
        (("--every", 3, "--most-frames", 4), range(0, 200, 60), "4 of 20 frames are in the page, one of every 6 "),
    ],
)
def test_frames_that_are_left_out(demverify: Call, write: Write, tmp_path: Path, words: tuple[object, ...], steps: range, note: str) -> None:
    """Law: --every takes one of N; of more than --most-frames every 2nd, 4th ... stays, which one line says."""
    done = demverify("view", write(dump(*range(0, 200, 10)), "d.dump"), *words, "-o", tmp_path / "view.html")
    assert [frame["step"] for frame in shown(tmp_path / "view.html")] == list(steps)
    assert done.err.count("\n") == bool(note)
    assert note in done.err


def test_a_page_stays_small(demverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: frames are left out where the page would be too large: its numbers take up no more than they may."""
    monkeypatch.setattr(frames_module, "MOST_BYTES", 20_000)
    done = demverify("view", write(dump(*range(100)), "d.dump"), "-o", tmp_path / "view.html")
    found = re.search(r'id="numbers">(.*?)</script>', (tmp_path / "view.html").read_text())
    assert found
    assert 6_000 < len(found[1]) < 20_000
    assert "of 100 frames are in the page, one of every" in done.err


def test_a_run_that_went_back(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: frames that a restart did again take the place of the earlier ones, as in erotate."""
    done = demverify("view", write(dump(0, 10, 20) + dump(10, 30), "d.dump"), "-o", tmp_path / "view.html")
    assert [frame["step"] for frame in shown(tmp_path / "view.html")] == [0, 10, 30]
    assert "the run went back to step 10" in done.err


def test_what_is_not_finite(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: a particle whose spin is nan is drawn without energies, one whose place is nan not at all; both are told, and the status is 1."""
    rows = "1 0 0 0 0 0 2 0 nan 3 0.1 7\n2 nan 0 0 0 0 2 0 0 3 0.1 7\n3 0 0 0.5 0 0 2 0 0 3 0.1 7\n"
    done = demverify("view", write(dump(0, rows=rows, columns=COLUMNS.removesuffix(" id_multisphere")), "d.dump"), "-o", tmp_path / "view.html")
    assert done.status == 1
    assert "step 0: omega of particle 1 is not finite" in done.err
    assert "step 0: particle 2 has no finite place or shape below 1e+18, and is not drawn" in done.err
    (frame,) = shown(tmp_path / "view.html")
    assert frame["id"].tolist() == [1, 3]
    assert np.isnan(frame["erotate"]).tolist() == [True, False]


def test_what_is_too_far(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: what of a run that blew up is beyond float32, in place or size, is not drawn but told, in one line each; the rest is seen as ever."""
    rows = "1 0 0 0 0 0 2 0 0 3 0.1 7\n2 1e300 0 0 0 0 2 0 0 3 0.1 7\n3 0 0 0.5 0 0 2 0 0 3 1e30 7\n"
    done = demverify("view", write(dump(0, rows=rows, columns=COLUMNS.removesuffix(" id_multisphere")), "d.dump"), "-o", tmp_path / "view.html")
    assert done.err.splitlines() == [
        f"demverify: note: step 0: particle {i} has no finite place or shape below 1e+18, and is not drawn" for i in (2, 3)
    ]
    (frame,) = shown(tmp_path / "view.html")
    assert frame["id"].tolist() == [1]
    assert frame["x"].tolist() == [[0.0, 0.0, 0.0]]


def test_a_trajectory(demverify: Call, tmp_path: Path) -> None:
    """Law: trajectory.h5 of the native engine is read as it is, with its times."""
    deck = Path(__file__).parents[3] / "inputs" / "slip-to-roll" / "in.lammps"
    assert demverify("run", deck, "--out", tmp_path / "out").status == 0
    path, page = tmp_path / "out" / "trajectory.h5", tmp_path / "view.html"
    assert demverify("view", path, "--every", 5, "-o", page).status == 0
    wanted = energies(demverify, tmp_path, path)
    assert len(shown(page)) > 1
    for frame in shown(page):
        assert frame["time"] is not None
        assert_array_equal(frame["erotate"], np.float32([wanted[frame["step"], "sphere", int(i)] for i in frame["id"]]))


def test_the_page_needs_nothing_else(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: one file: no address of a network, and a policy that forbids any; names of files cannot end its program."""
    name = "d<script>.dump"
    demverify("view", write(dump(0), name), "-o", tmp_path / "view.html")
    page = (tmp_path / "view.html").read_text()
    assert "default-src 'none'" in page
    assert not re.search(r"https?://|\bsrc=|@import|\bfetch\(", page)
    assert page.count("<script") == 2
    assert "d&lt;script&gt;.dump" in page


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("no.dump",), "no dump file no.dump; its folder has b.local d.dump"),
        ((), "Missing argument 'FILE...'"),
        (("d.dump", "-o", "no/view.html"), "cannot write view.html: there is no folder no"),
        (("d.dump", "-o", "."), "it is a folder"),
        (("d.dump", "--every", "0"), "--every"),
        (("d.dump", "--most-frames", "0"), "--most-frames"),
        (("d.dump", "--deck", "no.deck"), "no.deck: cannot read the file"),
        (("d.dump", "--columns", "id type"), "2 names were given (id type) for 13 columns"),
        (("d.dump", "--columns", COLUMNS.replace("radius", "-")), "d.dump: step 0: erotate/"),
        (("flat.dump",), "flat.dump: a view needs the columns x y z (or xu yu zu, xs ys zs); the dump has id omegax omegay omegaz radius mass"),
        (("turned.dump",), "turned.dump: a view of superquadrics needs the columns quat1 quat2 quat3 quat4; the dump has id x y z"),
        (("b.local",), "b.local: this dump local lists bodies, not the spheres they are made of: give the dump of particles, and this"),
        (("d.dump", "--bodies", "d.dump"), "d.dump: step 0: expected a dump local of bodies, got a dump of particles"),
        (("d.dump", "--bodies", "late.local"), "the dump of bodies has none of the steps of the particles (those start at 0)"),
        (("points.dump",), "nothing to be seen: no particle has an extent"),
        (("half.dump",), "nothing to be seen: there is no whole frame"),
    ],
)
def test_wrong_words(demverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], message: str) -> None:
    """Law: what cannot be shown is one line on stderr, status 2, and nothing is written."""
    solid = "id x y z omegax omegay omegaz angmomx angmomy angmomz radius mass shapex shapey shapez"
    write(dump(0), "d.dump")
    write(dump(0, columns="id omegax omegay omegaz radius mass", rows="1 0 0 0 1 1\n"), "flat.dump")
    write(dump(0, columns=solid, rows="1 0 0 0 0 0 1 0 0 1 1 1 1 1 2\n", faces="ff ff ff"), "turned.dump")
    write(dump(0, columns="id x y z omegax omegay omegaz radius mass", rows="1 0 0 0 0 0 0 0 1\n"), "points.dump")
    write(dump(0)[:-9], "half.dump")
    write(BODIES.format(step=0), "b.local")
    write(BODIES.format(step=5), "late.local")
    before = files_in(tmp_path)
    monkeypatch.chdir(tmp_path)
    if words[:1] == ("turned.dump",):
        write("units si\natom_style superquadric\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\n", "in.liggghts")
        words, before = (*words, "--deck", "in.liggghts"), files_in(tmp_path)
    done = demverify("view", *words)
    assert (done.status, done.out) == (2, "")
    assert message in done.err
    assert done.err.count("\n") == 1
    assert files_in(tmp_path) == before

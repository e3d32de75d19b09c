"""The page of `demverify view` in a browser: shapes as their formula says, a picture, and particles that can be pointed at."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from demsolver.shapes.rotation import to_body
from demverify.formats.dump import read_dump
from tests.support.browser import CHROMIUM, opened
from tests.support.cli import Call

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium")
DATA = Path(__file__).parents[2] / "data" / "superquadric"
Write = Callable[..., Path]

MAPPED = """
const gl = renderer.gl, program = compiled(gl, VERTEX, SHADE, ["at", "normal"]), points = meshOf(8).points, n = frame.n, count = points.length / 4;
gl.bindVertexArray(renderer.bodies);
renderer.put("points", points);
const caught = gl.createBuffer(), floats = new Float32Array(6 * n * count);
gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, caught);
gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, floats.byteLength, gl.STREAM_READ);
gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, caught);
renderer.use(program, eyesOf(camera));
gl.enable(gl.RASTERIZER_DISCARD);
gl.beginTransformFeedback(gl.POINTS);
gl.drawArraysInstanced(gl.POINTS, 0, count, n);
gl.endTransformFeedback();
gl.disable(gl.RASTERIZER_DISCARD);
gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, floats);
page.dataset.mapped = JSON.stringify([...floats]);
page.dataset.origin = JSON.stringify(numbers.origin);
"""


def test_points_lie_on_the_surface(demverify: Call, tmp_path: Path) -> None:
    """Law: what the graphics card makes of the unit sphere lies on |..|: (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1 in the frame of
    the body, with the gradient of the left side as normal; to float32."""
    demverify("view", DATA / "free.dump.gz", "-o", tmp_path / "view.html")
    left = opened(tmp_path / "view.html", MAPPED)
    assert "error" not in left
    frame = next(iter(read_dump(DATA / "free.dump.gz")))
    points = np.array(json.loads(left["mapped"])).reshape(frame.n, -1, 2, 3)
    quat = np.column_stack([frame.columns[f"quat{i}"] for i in (1, 2, 3, 4)])
    for i in range(frame.n):
        at, normal = points[i, :, 0] + json.loads(left["origin"]) - frame.vectors("x", "y", "z")[i], points[i, :, 1]
        turned = np.broadcast_to(quat[i], (len(at), 4))
        axes, (n1, n2) = frame.vectors("shapex", "shapey", "shapez")[i], (frame.columns[f"blockiness{k}"][i] for k in (1, 2))
        x, y, z = (to_body(turned, at) / axes).T
        around = np.abs(x) ** n2 + np.abs(y) ** n2
        np.testing.assert_allclose(around ** (n1 / n2) + np.abs(z) ** n1, 1.0, atol=3e-4)
        assert np.ptp(to_body(turned, at), axis=0) == pytest.approx(2.0 * axes, rel=1e-3)  # all of it, not a part
        factor = np.maximum(around, 1e-12) ** (n1 / n2 - 1.0)
        slope = [factor * np.sign(x) * np.abs(x) ** (n2 - 1), factor * np.sign(y) * np.abs(y) ** (n2 - 1), np.sign(z) * np.abs(z) ** (n1 - 1)]
        gradient = np.column_stack(slope) / axes
        gradient /= np.linalg.norm(gradient, axis=1)[:, None]
        along = to_body(turned, normal)
        apart = np.linalg.norm(along / np.linalg.norm(along, axis=1)[:, None] - gradient, axis=1)
        assert np.median(apart) < 1e-3
        assert apart.max() < 0.05  # where a face is flat to rounding


HEAD = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\nITEM: ATOMS "
SPHERES = HEAD + "id x y z vx vy vz omegax omegay omegaz radius mass id_multisphere\n{rows}"
ROWS = """1 0 0 0 0 0 2 0 0 3 0.4 7 0
2 0.6 0 0.6 0 0 0 0 0 0.1 0.2 7 3
3 0.6 0 0.9 0 0 0 0 0 0.1 0.2 7 3
"""
LOOK = """
Object.assign(camera, { azimuth: -Math.PI / 2, elevation: 0 });
const far = camera.distance, centre = middle.map((v, k) => v + numbers.origin[k]);
const pixelOf = (place) => {
  const eyes = eyesOf(camera), v = eyes.rows.map((row) => row.reduce((sum, part, k) => sum + part * (place[k] - numbers.origin[k] - eyes.eye[k]), 0));
  const area = canvas.getBoundingClientRect(), [x, y] = [0, 1].map((k) => 0.5 + 0.5 * eyes.projection[k] * v[k] / -v[2]);
  return { clientX: area.left + area.width * x, clientY: area.top + area.height * (1 - y) };
};
const under = (...place) => particleUnder(pixelOf(place));
paint();
const colourAt = (...place) => {
  const { clientX, clientY } = pixelOf(place), area = canvas.getBoundingClientRect(), seen = new Uint8Array(4), gl = renderer.gl;
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.readPixels(clientX - area.left, area.bottom - clientY, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, seen);
  return [...seen];
};
page.dataset.colours = JSON.stringify([[0, 0, 0], [0.6, 0, 0.6], [0.6, 0, 0.9], [-0.8, 0, 0.8]].map((place) => (paint(), colourAt(...place))));
const places = [[0, 0, 0], [0.39, 0, 0], [0, 0, -0.39], [-0.43, 0, 0], [0.3, 0, 0.3], [0.6, 0, 0.9]];
page.dataset.under = JSON.stringify(places.map((place) => under(...place)));
pin(1);
tell(1);
page.dataset.told = $("picked").textContent;
step(1);
page.dataset.step = $("when").textContent;
"""


def test_a_picture_comes_about(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: the particles are where they are: pointing finds them to their edges and nothing beside; each has its colour, members of
    a clump one colour; a particle tells who it is; the next frame comes."""
    demverify("view", write("".join(SPHERES.format(step=step, n=3, rows=ROWS) for step in (0, 10)), "d.dump"), "-o", tmp_path / "view.html")
    left = opened(tmp_path / "view.html", LOOK)
    assert "error" not in left
    assert left["drew"].endswith("3 particles")
    assert json.loads(left["under"]) == [0, 0, 0, -1, -1, 2]
    fast, *clump, nothing = np.array(json.loads(left["colours"]))[:, :3]
    np.testing.assert_allclose(clump[0], clump[1], atol=25)  # the light falls on them from one side
    assert (fast[:2] > 200).all()  # the most of all energies is yellow, in front and in the light
    assert fast[2] < 120
    assert np.abs(fast - clump[0]).max() > 60
    assert np.ptp(nothing) < 12  # the page, which is grey
    assert left["told"].split()[:4] == ["clump", "3", "spheres", "2"]
    assert "erotate" in left["told"]
    assert left["step"] == "step 10"


HANDS = """
const was = [];
const note = () => was.push([camera.azimuth, camera.elevation, camera.distance, ...camera.target, pinned ? 1 : 0, frame.index, playing ? 1 : 0]);
canvas.setPointerCapture = () => {};
const touched = (type, pointerId, clientX, clientY, more) =>
  canvas.dispatchEvent(new PointerEvent(type, { pointerId, clientX, clientY, bubbles: true, ...more }));
const key = (name, more) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, ...more }));
const drag = (more) => {
  for (const [type, x, y] of [["pointerdown", 300, 400], ["pointermove", 340, 420], ["pointerup", 340, 420]]) touched(type, 1, x, y, more);
};
const fingersMove = () => {
  for (const [type, id, x] of [["down", 1, 300], ["down", 2, 400], ["move", 2, 500], ["up", 1, 300], ["up", 2, 500]]) {
    touched(`pointer${type}`, id, x, 400, { pointerType: "touch", buttons: 1 });
  }
};
note();
for (const act of [
  () => drag({ buttons: 1 }), () => drag({ buttons: 2, button: 2 }), () => drag({ buttons: 1, shiftKey: true }), fingersMove,
  () => canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -200, cancelable: true })), () => key("ArrowLeft"),
  () => key("ArrowUp", { shiftKey: true }), () => key("+"), () => key("0"),
  () => { for (const type of ["pointerdown", "pointerup"]) touched(type, 1, ...centre()); },
  () => key("Escape"), () => key("."), () => key(" "), () => key(" "), () => { slider.value = 0; slider.dispatchEvent(new Event("input")); },
]) { act(); note(); }
function centre() {
  const area = canvas.getBoundingClientRect();
  return [area.left + area.width / 2, area.top + area.height / 2];
}
page.dataset.was = JSON.stringify(was);
"""


def test_what_hands_do(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: drag turns; right button, shift and two fingers move; wheel, fingers apart and + zoom; a click keeps a particle, Escape lets it go;
    arrow keys turn, or move with shift; 0 goes back; point, space and slider go through the frames."""
    rows = "1 0 0 0 0 0 2 0 0 3 0.4 7 0\n"
    demverify("view", write("".join(SPHERES.format(step=step, n=1, rows=rows) for step in (0, 10)), "d.dump"), "-o", tmp_path / "view.html")
    left = opened(tmp_path / "view.html", HANDS)
    assert "error" not in left
    was = np.array(json.loads(left["was"]))
    turn, place, distance, others = slice(0, 2), slice(3, 6), 2, slice(6, 9)
    changed = [[bool((a[part] != b[part]).any()) for part in (turn, slice(distance, 3), place, others)] for a, b in pairwise(was)]
    turned, zoomed, moved, other = [True, False, False, False], [False, True, False, False], [False, False, True, False], [False, False, False, True]
    assert changed == [turned, moved, moved, [False, True, True, False], zoomed, turned, moved, zoomed, [True, True, True, False], *[other] * 6]
    assert was[1, 0] < was[0, 0]  # to the right: what is in front follows the hand
    assert was[4, distance] == pytest.approx(0.5 * was[3, distance])
    assert was[5, distance] < was[4, distance]
    np.testing.assert_array_equal(was[9, :6], was[0, :6])
    np.testing.assert_array_equal(was[9:, others], [[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 1, 0], [0, 0, 0]])


def test_without_webgl(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: a browser that cannot draw says so, in one line."""
    demverify("view", write(SPHERES.format(step=0, n=3, rows=ROWS), "d.dump"), "-o", tmp_path / "view.html")
    left = opened(tmp_path / "view.html", options=("--disable-gpu", "--disable-3d-apis"))
    assert left["alert"] == "This browser shows no WebGL 2, without which the particles cannot be drawn."
    assert "error" not in left

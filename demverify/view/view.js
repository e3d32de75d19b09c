// The page around draw.js: where one looks from, what mouse, fingers and keys do, frames one after the other.

const FRAMES_A_SECOND = 20;
const CLICK = 5;  // pixels that a finger may slip on a click
const PLAY = "M4 2l9 6-9 6z", PAUSE = "M3 2h4v12H3zM9 2h4v12H9z";

const canvas = $("canvas"), slider = $("slider");
let renderer, frame, playing = 0, waiting = false, told = "", pointer = null, hovered = -1, pinned = null;  // pinned: id and whether it is of a clump

const middle = numbers.low.map((v, k) => 0.5 * (v + numbers.high[k]));
const reach = 0.5 * Math.hypot(...numbers.low.map((v, k) => numbers.high[k] - v)) || 1;
const extent = Math.max(reach, ...numbers.frames.filter((one) => one.box).map(({ box }) => farthest(edgesOf(box))));
const camera = {};

function farthest(points) {
  let most = 0;
  for (let i = 0; i < points.length; i += 3) most = Math.max(most, Math.hypot(...middle.map((v, k) => points[i + k] - v)));
  return most;
}

// All of it from the front and above, as near as the corners of what is to be seen allow.
function resetView() {
  Object.assign(camera, { azimuth: -Math.PI / 3, elevation: Math.PI / 9, distance: reach, target: [...middle] });
  const { rows, projection } = eyesOf(camera), ends = [numbers.low, numbers.high];
  for (let corner = 0; corner < 8; corner++) {
    const arm = middle.map((v, k) => ends[corner >> k & 1][k] - v);
    const [right, up, back] = rows.map((row) => row.reduce((sum, v, k) => sum + v * arm[k], 0));
    for (const aside of [right * projection[0], up * projection[1]]) camera.distance = Math.max(camera.distance, back + 1.08 * Math.abs(aside));
  }
}

// What the shaders know of the camera. rows: right, up and backwards, in space.
function eyesOf({ azimuth, elevation, distance, target }) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  const rows = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  const aspect = canvas.width / canvas.height, wide = 1 / Math.tan(ANGLE / 2) * Math.min(1, aspect);
  const depth = extent + Math.hypot(...target.map((v, k) => v - middle[k]));
  const near = Math.max(distance - depth, 1e-3 * distance), far = distance + depth;
  return {
    rows,
    eye: target.map((v, k) => v + distance * rows[2][k]),
    projection: [wide / aspect, wide, (far + near) / (near - far), 2 * far * near / (near - far)],
    space: (v) => [0, 1, 2].map((k) => v[0] * rows[0][k] + v[1] * rows[1][k] + v[2] * rows[2][k]),
  };
}

// ---- drawing

function wanted() {
  if (waiting || !renderer) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    draw();
  });
}

function draw() {
  const which = paint();
  tell(which);
  page.dataset.drew = `frame ${frame.index}: ${frame.n} particles`;
}

// The picture; gives the particle that is picked.
function paint() {
  const scale = Math.min(2, window.devicePixelRatio || 1);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((length) => Math.max(1, Math.round(scale * length)));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const eyes = eyesOf(camera), which = pinned ? pinnedAt() : hovered;
  renderer.draw(eyes, which < 0 ? -1 : frame.set.groups[which]);
  drawTriad(eyes);
  return which;
}

function drawTriad({ rows }) {
  const axes = ["x", "y", "z"].map((name, k) => ({ name, x: 27 * rows[0][k], y: -27 * rows[1][k], depth: rows[2][k] }));
  $("triad").innerHTML = axes.sort((a, b) => a.depth - b.depth).map(({ name, x, y }) =>
    `<line x2="${x}" y2="${y}" stroke="var(--${name})"/><text x="${1.32 * x}" y="${1.32 * y}" fill="var(--${name})">${name}</text>`).join("");
}

// ---- frames

function show(index) {
  frame = frameAt(index);
  renderer.load(frame);
  hovered = pointer ? particleUnder(pointer) : -1;
  slider.value = index;
  $("when").textContent = `step ${frame.step}` + (frame.time === null ? "" : ` · time ${written(frame.time)}`);
  wanted();
}

function step(by) {
  const count = numbers.frames.length;
  show((frame.index + by + count) % count);
}

function play(on) {
  clearInterval(playing);
  playing = on && numbers.frames.length > 1 ? setInterval(() => step(1), 1000 / FRAMES_A_SECOND) : 0;
  $("sign").setAttribute("d", playing ? PAUSE : PLAY);
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  $("picked").setAttribute("aria-live", playing ? "off" : "polite");
}

// ---- one particle

function pinnedAt() {
  return (pinned.clump ? frame.set.bodies : frame.set.ids).indexOf(pinned.id);
}

function pin(which) {
  const { bodies, ids } = frame.set;
  pinned = which < 0 ? null : { clump: bodies[which] > 0, id: bodies[which] || ids[which] };
  wanted();
}

function tell(which) {
  const html = which < 0 ? hint() : description(which);
  if (html !== told) $("picked").innerHTML = told = html;
}

function hint() {
  if (pinned) return `${pinned.clump ? "clump" : "particle"} ${pinned.id} is not in this frame`;
  return "<i>Point at a particle; a click keeps it. Drag turns, shift and drag moves, the wheel zooms.</i>";
}

function description(which) {
  const { bodies, ids, sizes, kinds } = frame.set, kind = numbers.kinds[kinds[which]];
  const [a, b, c, n1, n2] = sizes.subarray(5 * which, 5 * which + 5);
  const members = bodies[which] ? bodies.reduce((count, body) => count + (body === bodies[which]), 0) : 0;
  const listed = (values) => values.map(written).join(", ");
  const shape = kind === "superquadric" ? [["semi-axes", listed([a, b, c])], ["blockiness", listed([n1, n2])]]
    : members ? [["spheres", members]] : [["radius", written(a)]];
  const pairs = [...shape, ["erotate", written(frame.erotate[which])], ["ke", written(frame.ke[which])]];
  const name = `${members ? "clump" : kind} ${bodies[which] || ids[which]}`;
  return `<b>${name}</b> ` + pairs.map(([name, value]) => `<span><i>${name}</i> ${value}</span>`).join(" ");
}

function particleUnder(event) {
  const area = canvas.getBoundingClientRect(), scale = canvas.width / area.width;
  return renderer.at(scale * (event.clientX - area.left), canvas.height - 1 - scale * (event.clientY - area.top), eyesOf(camera));
}

// ---- mouse, fingers, keys

function turn(right, up) {
  camera.azimuth -= right;
  camera.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, camera.elevation + up));
}

function move(right, up) {  // by parts of the smaller side of the picture
  const length = 2 * camera.distance * Math.tan(ANGLE / 2), { rows } = eyesOf(camera);
  camera.target = camera.target.map((v, k) => v - length * (right * rows[0][k] + up * rows[1][k]));
}

function zoom(factor) {
  camera.distance = Math.max(1e-3 * reach, Math.min(50 * extent, camera.distance * factor));
}

const fingers = new Map();
let slipped = 0;

const between = () => {
  const [a, b] = [...fingers.values()];
  return { x: 0.5 * (a.x + b.x), y: 0.5 * (a.y + b.y), apart: Math.hypot(a.x - b.x, a.y - b.y) };
};

function dragged(event) {
  const before = fingers.get(event.pointerId), side = Math.min(canvas.clientWidth, canvas.clientHeight), pair = fingers.size === 2 && between();
  fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
  slipped += Math.abs(dx) + Math.abs(dy);
  if (pair) {
    const now = between();
    move((now.x - pair.x) / side, (pair.y - now.y) / side);
    zoom(pair.apart / Math.max(1, now.apart));
  } else if (event.shiftKey || event.buttons & 6) move(dx / side, -dy / side);
  else turn(dx * Math.PI / side, dy * Math.PI / side);
  wanted();
}

function listen() {
  canvas.addEventListener("pointerdown", (event) => {
    if (!fingers.size) slipped = 0;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (fingers.has(event.pointerId)) return dragged(event);
    pointer = event.pointerType === "mouse" ? event : null;
    const under = particleUnder(event);
    if (under !== hovered) wanted();
    hovered = under;
  });
  const released = (event) => {
    if (fingers.size === 1 && event.type === "pointerup" && slipped < CLICK && event.button === 0) pin(particleUnder(event));
    fingers.delete(event.pointerId);
    if (fingers.size) slipped = CLICK;
  };
  canvas.addEventListener("pointerup", released);
  canvas.addEventListener("pointercancel", released);
  canvas.addEventListener("pointerleave", () => {
    [pointer, hovered] = [null, -1];
    wanted();
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp((event.deltaMode ? 0.05 : 0.0015) * event.deltaY));
    wanted();
  }, { passive: false });
  const keys = {
    ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
    "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1 / 0.9), 0: resetView, Escape: () => pin(-1),
    ",": () => step(-1), ".": () => step(1), " ": () => play(!playing),
  };
  window.addEventListener("keydown", (event) => {
    const action = keys[event.key];
    if (!action || event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, button")) return;
    event.preventDefault();
    if (typeof action === "function") action();
    else if (event.shiftKey) move(0.05 * action[0], -0.05 * action[1]);
    else turn(0.1 * action[0], 0.1 * action[1]);
    wanted();
  });
  $("fit").addEventListener("click", () => {
    resetView();
    wanted();
  });
  $("play").addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => {
    play(false);
    show(Number(slider.value));
  });
  $("scales").addEventListener("change", (event) => {
    logarithmic = event.target.value === "log";
    drawBar();
    show(frame.index);
  });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", wanted);
  new ResizeObserver(paint).observe(canvas);
}

function say(text) {
  $("message").textContent = text;
  $("message").hidden = false;
  for (const name of ["canvas", "triad"]) $(name).style.visibility = "hidden";
  for (const name of ["scale", "footer"]) $(name).hidden = true;
}

function start() {
  drawBar();
  slider.max = numbers.frames.length - 1;
  $("player").hidden = numbers.frames.length < 2;
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) return say("This browser shows no WebGL 2, without which the particles cannot be drawn.");
  canvas.addEventListener("webglcontextlost", () => say("The graphics card has let go of the picture: load the page again."));
  renderer = new Renderer(gl);
  resetView();
  play(false);
  listen();
  show(0);
}

window.addEventListener("error", (event) => {
  page.dataset.error = event.message;
  say(`This page has a mistake in it: ${event.message}`);
});
start();

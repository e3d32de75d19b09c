"use strict";
// Draws scenes of `demverify view`: one mesh of the unit sphere, an instance a particle, WebGL 2. Lengths are relative to numbers.origin.

const $ = (id) => document.getElementById(id);
const page = document.documentElement;
const numbers = JSON.parse($("numbers").textContent);

// Superquadric (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1: the cosines and sines of latitude and longitude on the sphere, to the powers
// 2/n1 and 2/n2, are a point of it; to the powers 2 - 2/n1 and 2 - 2/n2, over a b c, its normal.
const VERTEX = `#version 300 es
layout(location = 0) in vec4 sphere;    // cos, sin of latitude; cos, sin of longitude
layout(location = 1) in vec3 place;
layout(location = 2) in vec4 quat;      // w x y z, body to space
layout(location = 3) in vec3 axes;
layout(location = 4) in vec2 blockiness;
layout(location = 5) in float level;    // 0 to 1 of the colours; below 0: not known
layout(location = 6) in int group;
uniform mat3 toView;
uniform vec3 eye;
uniform vec4 projection;
uniform float swollen;                  // above 0: only the picked group, so much larger for its distance
uniform int picked;
out vec3 at, normal, towards;
flat out float colour;
flat out int number;
vec4 raised(vec4 power) { return sign(sphere) * pow(abs(sphere), power); }
vec3 point(vec4 s) { return vec3(s.x * s.z, s.x * s.w, s.y); }
vec3 turned(vec3 v) { vec3 t = 2.0 * cross(quat.yzw, v); return v + quat.x * t + cross(quat.yzw, t); }
void main() {
  vec4 power = 2.0 / vec4(blockiness.xx, blockiness.yy);
  at = place + turned(axes * point(raised(power)));
  normal = turned(normalize(point(raised(2.0 - power)) * (min(axes.x, min(axes.y, axes.z)) / axes)));
  at += swollen * distance(eye, at) * normal;
  towards = eye - at;
  vec3 v = toView * -towards;
  gl_Position = vec4(projection.xy * v.xy, projection.z * v.z + projection.w, -v.z);
  if (swollen > 0.0 && group != picked) gl_Position = vec4(0.0, 0.0, -2.0, 1.0);
  colour = level; number = gl_InstanceID;
}`;
const SHADE = `#version 300 es
precision highp float;
precision highp int;
in vec3 at, normal, towards;
flat in float colour;
flat in int number;
uniform sampler2D colours;
uniform vec3 unknown, light;
out vec4 pixel;
void main() {
  vec3 n = normalize(normal), t = normalize(towards);
  vec3 base = colour < 0.0 ? unknown : texture(colours, vec2((colour * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  float lit = 0.5 + 0.5 * dot(n, light), glance = max(0.0, dot(reflect(-light, n), t));
  pixel = vec4(base * mix(0.5, 1.04, lit) + 0.16 * pow(glance, 24.0), 1.0);
}`;
const NUMBER = `#version 300 es
precision highp float;
precision highp int;
in vec3 at, normal, towards;
flat in float colour;
flat in int number;
out vec4 pixel;
void main() {
  int i = number + 1;
  pixel = vec4(float(i & 255), float(i >> 8 & 255), float(i >> 16 & 255), float(i >> 24 & 255)) / 255.0;
}`;
const LINE = `#version 300 es
layout(location = 0) in vec3 place;
uniform mat3 toView;
uniform vec3 eye;
uniform vec4 projection;
void main() {
  vec3 v = toView * (place - eye);
  gl_Position = vec4(projection.xy * v.xy, projection.z * v.z + projection.w, -v.z);
}`;
const STROKE = `#version 300 es
precision highp float;
uniform vec3 stroke;
out vec4 pixel;
void main() { pixel = vec4(stroke, 1.0); }`;
const OUTLINE = 0.0015;  // how much larger, for its distance, what surrounds the picked particle is

// viridis (perceptually uniform) without its darkest tenth, which a dark page would swallow
const COLOURS = ["#482576", "#414487", "#35608d", "#2a788e", "#21908c", "#22a884", "#43bf71", "#7ad151", "#bbdf27", "#fde725"];
const DECADES = 6;  // that the logarithmic scale shows at most
const ANGLE = Math.PI / 6;  // of view

// ---- numbers

function decoded(text, Kind) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Kind(bytes.buffer);
}

function particlesOf(frame) {
  const set = numbers.particles[frame.particles];
  if (!set.ids) {
    set.ids = decoded(set.id, Float64Array);
    set.bodies = decoded(set.body, Float64Array);
    set.kinds = decoded(set.kind, Uint8Array);
    set.sizes = decoded(set.size, Float32Array);
    const first = new Map();
    set.groups = Int32Array.from(set.bodies, (body, i) => {
      if (body && !first.has(body)) first.set(body, i);
      return body ? first.get(body) : i;
    });
  }
  return set;
}

function frameAt(index) {
  const frame = numbers.frames[index], set = particlesOf(frame), n = set.n, values = decoded(frame.numbers, Float32Array);
  const energies = (frame.turned ? 7 : 3) * n;
  return { ...frame, index, set, n, values, erotate: values.subarray(energies, energies + n), ke: values.subarray(energies + n) };
}

function written(value) {
  if (!Number.isFinite(value)) return "not known";
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e5)) return String(Number(value.toPrecision(6)));
  const [digits, power] = value.toExponential(5).split("e");
  return `${Number(digits)}×10${raisedText(Number(power))}`;
}

const raisedText = (power) => String(power).replace(/[-0-9]/g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]));

// ---- colours

const [least, most] = numbers.energies || [0, 0];
const lowest = Math.max(least, most * 10 ** -DECADES);
let logarithmic = least < 0.01 * most;

function levelOf(energy) {
  if (!Number.isFinite(energy)) return -1;
  if (!(most > 0)) return 0;
  const level = logarithmic ? Math.log(energy / lowest) / Math.log(most / lowest) : energy / most;
  return Math.min(1, Math.max(0, level));
}

function ticks() {
  if (!(most > 0)) return [[0, "0"]];
  const found = [];
  if (logarithmic) {
    const from = Math.ceil(Math.log10(lowest) - 1e-9), to = Math.floor(Math.log10(most) + 1e-9), by = Math.max(1, Math.ceil((to - from) / 5));
    for (let power = to; power >= from; power -= by) found.unshift([levelOf(10 ** power), `10${raisedText(power)}`]);
    if (found.length > 1) return found;
    return [[0, written(Number(lowest.toPrecision(2)))], [1, written(Number(most.toPrecision(2)))]];
  }
  const rough = most / 4, unit = 10 ** Math.floor(Math.log10(rough)), by = [1, 2, 2.5, 5, 10].find((k) => k * unit >= rough) * unit;
  for (let i = 0; i * by <= most * (1 + 1e-9); i++) found.push([levelOf(i * by), written(Number((i * by).toPrecision(3)))]);
  return found;
}

function drawBar() {
  $("bar").style.background = `linear-gradient(to right, ${COLOURS.join(", ")})`;
  $("ticks").replaceChildren(...ticks().map(([level, text]) => {
    const mark = document.createElement("span");
    mark.textContent = text;
    mark.style.left = `${100 * level}%`;
    mark.className = level < 0.04 ? "first" : level > 0.96 ? "last" : "";
    return mark;
  }));
  for (const input of document.querySelectorAll("[name=scale]")) input.checked = (input.value === "log") === logarithmic;
  $("scales").hidden = !(most > lowest);
}

const rgb = (text) => [1, 3, 5].map((i) => parseInt(text.trim().slice(i, i + 2), 16) / 255);
const themed = (name) => rgb(getComputedStyle(page).getPropertyValue(name));

function palette() {
  const anchors = COLOURS.map(rgb), bytes = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; i++) {
    const place = i / 255 * (anchors.length - 1), k = Math.min(anchors.length - 2, Math.floor(place));
    for (let c = 0; c < 3; c++) bytes[4 * i + c] = 255 * (anchors[k][c] + (place - k) * (anchors[k + 1][c] - anchors[k][c]));
    bytes[4 * i + 3] = 255;
  }
  return bytes;
}

// ---- WebGL

function meshOf(bands) {
  const around = 2 * bands, points = [], corners = [], exact = (v) => (Math.abs(v) < 1e-9 ? 0 : v);
  for (let i = 0; i <= bands; i++) {
    const latitude = Math.PI * (i / bands - 0.5);
    for (let j = 0; j < around; j++) {
      const longitude = 2 * Math.PI * j / around;
      points.push(...[Math.cos(latitude), Math.sin(latitude), Math.cos(longitude), Math.sin(longitude)].map(exact));
      if (i === bands) continue;
      const a = i * around + j, b = i * around + (j + 1) % around;
      corners.push(a, b, b + around, a, b + around, a + around);
    }
  }
  return { points: new Float32Array(points), corners: new Uint16Array(corners) };
}

function compiled(gl, vertex, fragment, caught = []) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  if (caught.length) gl.transformFeedbackVaryings(program, caught, gl.INTERLEAVED_ATTRIBS);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

// Buffers and programs of one canvas.
class Renderer {
  constructor(gl) {
    this.gl = gl;
    this.shade = compiled(gl, VERTEX, SHADE);
    this.number = compiled(gl, VERTEX, NUMBER);
    this.line = compiled(gl, LINE, STROKE);
    this.outline = compiled(gl, VERTEX, STROKE);
    this.buffers = Object.fromEntries(["points", "corners", "values", "sizes", "levels", "groups", "box"].map((name) => [name, gl.createBuffer()]));
    const most = Math.max(1, ...numbers.particles.map((set) => set.n));
    this.mesh = meshOf(Math.max(6, Math.min(32, Math.floor(Math.sqrt(1e6 / most)))));
    this.bodies = gl.createVertexArray();
    gl.bindVertexArray(this.bodies);
    this.put("corners", this.mesh.corners, gl.ELEMENT_ARRAY_BUFFER);
    this.put("points", this.mesh.points);
    this.attribute(0, 4, 0, 0, 0);
    this.lines = gl.createVertexArray();
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, palette());
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    this.one = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.one);
    for (const [where, format] of [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]]) {
      const store = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, store);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, 1, 1);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, where, gl.RENDERBUFFER, store);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
  }

  put(name, values, target = this.gl.ARRAY_BUFFER) {
    this.gl.bindBuffer(target, this.buffers[name]);
    this.gl.bufferData(target, values, this.gl.DYNAMIC_DRAW);
  }

  attribute(location, width, stride, offset, divisor = 1) {
    const gl = this.gl;
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, width, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(location, divisor);
  }

  load(frame) {
    const gl = this.gl;
    this.frame = frame;
    gl.bindVertexArray(this.bodies);
    this.put("values", frame.values);
    this.attribute(1, 3, 0, 0);
    if (frame.turned) this.attribute(2, 4, 0, 12 * frame.n);
    else {
      gl.disableVertexAttribArray(2);
      gl.vertexAttrib4f(2, 1, 0, 0, 0);
    }
    this.put("sizes", frame.set.sizes);
    this.attribute(3, 3, 20, 0);
    this.attribute(4, 2, 20, 12);
    this.put("levels", Float32Array.from(frame.erotate, levelOf));
    this.attribute(5, 1, 0, 0);
    this.put("groups", frame.set.groups);
    gl.enableVertexAttribArray(6);
    gl.vertexAttribIPointer(6, 1, gl.INT, 0, 0);
    gl.vertexAttribDivisor(6, 1);
    gl.bindVertexArray(this.lines);
    this.put("box", new Float32Array(frame.box ? edgesOf(frame.box) : []));
    this.attribute(0, 3, 0, 0, 0);
  }

  draw(eyes, picked) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(...themed("--page"), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const program = this.use(this.shade, eyes), at = (name) => gl.getUniformLocation(program, name);
    gl.uniform3fv(at("unknown"), themed("--unknown"));
    gl.uniform3fv(at("light"), eyes.space(unit([-0.45, 0.65, 0.75])));
    this.drawBodies();
    if (picked >= 0) this.drawOutline(eyes, picked);
    if (!this.frame.box) return;
    gl.uniform3fv(gl.getUniformLocation(this.use(this.line, eyes), "stroke"), themed("--edge"));
    gl.bindVertexArray(this.lines);
    gl.drawArrays(gl.LINES, 0, 24);
  }

  // Of a larger body behind the picked one, its inside.
  drawOutline(eyes, picked) {
    const gl = this.gl, program = this.use(this.outline, eyes);
    gl.uniform3fv(gl.getUniformLocation(program, "stroke"), themed("--ink"));
    gl.uniform1f(gl.getUniformLocation(program, "swollen"), OUTLINE);
    gl.uniform1i(gl.getUniformLocation(program, "picked"), picked);
    gl.cullFace(gl.FRONT);
    this.drawBodies();
    gl.cullFace(gl.BACK);
  }

  use(program, eyes) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniformMatrix3fv(gl.getUniformLocation(program, "toView"), true, eyes.rows.flat());
    gl.uniform3fv(gl.getUniformLocation(program, "eye"), eyes.eye);
    gl.uniform4fv(gl.getUniformLocation(program, "projection"), eyes.projection);
    return program;
  }

  drawBodies() {
    this.gl.bindVertexArray(this.bodies);
    this.gl.drawElementsInstanced(this.gl.TRIANGLES, this.mesh.corners.length, this.gl.UNSIGNED_SHORT, 0, this.frame.n);
  }

  // The particle at a pixel, counted from the lower left; -1: none.
  at(x, y, eyes) {
    const gl = this.gl, seen = new Uint8Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.one);
    gl.viewport(-Math.floor(x), -Math.floor(y), gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.use(this.number, eyes);
    this.drawBodies();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, seen);
    return (seen[0] | seen[1] << 8 | seen[2] << 16 | seen[3] << 24) - 1;
  }
}

function edgesOf([corner, a, b, c]) {
  const ends = [];
  for (const [along, other, third] of [[a, b, c], [b, c, a], [c, a, b]]) {
    for (const [i, j] of [[0, 0], [1, 0], [0, 1], [1, 1]]) {
      const from = corner.map((v, k) => v + i * other[k] + j * third[k]);
      ends.push(...from, ...from.map((v, k) => v + along[k]));
    }
  }
  return ends;
}

const unit = (v) => v.map((part) => part / Math.hypot(...v));

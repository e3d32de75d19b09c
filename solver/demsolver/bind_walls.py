"""Walls and fields of one scene as source: unrolled one after another, each with its own geometry and law."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import numpy as np

from demsolver.bind_law import goes_beyond, memory_signs
from demsolver.expression import Number, Writer
from demsolver.scene import AddForce, Cylinder, Enforce2D, Freeze, Gravity, Plane, Rotation, Scene, SetForce, Slab, Viscous, Wall
from demsolver.state import Floats, selected

HERE = Path(__file__).parent


# Each snippet sets: touches, n, overlap, reff, the velocity wv of the surface where it is touched, and its angular velocity `turning`.
# `gap` is how far beyond touching a contact goes on that was there at the last step.
SURFACE = "        wvx, wvy, wvz, turning = geometry[3], geometry[4], geometry[5], geometry[6:9]"
PLACE = slice(6)
"""Where a plane's normal and pivot stand in its geometry: what changes as it moves."""


def _slab(shape: Slab, closed: bool) -> str:
    a = shape.axis
    normal = ["0.0", "0.0", "0.0"]
    normal[a] = "sign"
    touch = "<=" if closed else "<"
    return f"""
        low, high = b.x[i, {a}] - geometry[0], geometry[1] - b.x[i, {a}]
        way, sign = (low, 1.0) if low < high else (high, -1.0)
        if way < 0.0:
            way, sign = -way, -sign
        touches = way > 0.0 and way {touch} b.radius[i] + gap
        nx, ny, nz = {", ".join(normal)}
        reff = b.radius[i]
{SURFACE}
"""


SIDES = {"both": "", "in": " and off < geometry[2]", "out": " and off > geometry[2]"}


def _cylinder(shape: Cylinder, closed: bool) -> str:
    a = shape.axis
    u, v = (a + 1) % 3, (a + 2) % 3
    normal = ["0.0", "0.0", "0.0"]
    normal[u], normal[v] = "sign * du / off", "sign * dv / off"
    touch = "<=" if closed else "<"
    curved = "b.radius[i] * rw / (b.radius[i] + rw)" if shape.effective_radius == "curved" else "b.radius[i]"
    return f"""
        du, dv = b.x[i, {u}] - geometry[0], b.x[i, {v}] - geometry[1]
        off = sqrt(du * du + dv * dv)
        way = geometry[2] - off
        rw, sign = (-2.0 * geometry[2], -1.0) if off < geometry[2] else (2.0 * geometry[2], 1.0)
        way = abs(way)
        touches = off > 0.0 and way > 0.0 and way {touch} b.radius[i] + gap{SIDES[shape.side]}
        nx = ny = nz = 0.0
        reff = {curved}
        if touches:
            nx, ny, nz = {", ".join(normal)}
{SURFACE}
"""


def _rotation_source(shape: Slab | Cylinder | Plane) -> str:
    """What the rotation of a cylinder adds to the velocity of its surface; du, dv lead from its axis to the particle."""
    if not isinstance(shape, Cylinder) or shape.rotation is None:
        return ""
    u, v = ("xyz"[(shape.axis + k) % 3] for k in (1, 2))
    scale = " * geometry[2] / off if off > 0.0 else 0.0" if shape.rotation.at == "surface" else ""
    return f"""
        rate, turning = (geometry[9], geometry[6:9]) if advance else (geometry[10], geometry[11:14])
        turn = rate{scale}
        wv{u} -= turn * dv
        wv{v} += turn * du
"""


def _plane(shape: Plane, closed: bool) -> str:
    touch = "<=" if closed else "<"
    side = "1.0, high" if shape.one_sided else "(1.0, high) if high > 0.0 else (-1.0, -high)"
    return f"""
        ex, ey, ez = b.x[i, 0] - geometry[3], b.x[i, 1] - geometry[4], b.x[i, 2] - geometry[5]
        high = ex * geometry[0] + ey * geometry[1] + ez * geometry[2] - geometry[6]
        sign, way = {side}
        touches = way > 0.0 and way {touch} b.radius[i] + gap
        nx, ny, nz = sign * geometry[0], sign * geometry[1], sign * geometry[2]
        reff = b.radius[i]
        ex, ey, ez = ex - way * nx, ey - way * ny, ez - way * nz
        wvx = geometry[7] + geometry[11] * ez - geometry[12] * ey + geometry[13]
        wvy = geometry[8] + geometry[12] * ex - geometry[10] * ez + geometry[14]
        wvz = geometry[9] + geometry[10] * ey - geometry[11] * ex + geometry[15]
        turning = geometry[10:13]
"""


def _geometry_source(wall: Wall) -> str:
    if isinstance(wall.shape, Slab):
        return _slab(wall.shape, wall.touch_closed)
    if isinstance(wall.shape, Plane):
        return _plane(wall.shape, wall.touch_closed)
    return _cylinder(wall.shape, wall.touch_closed)


def wall_geometry(wall: Wall) -> Floats:
    """Numbers that the generated wall code reads. Slab: lo, hi, 0; cylinder: centre and radius; both: surface velocity (3), no spin (3).

    Cylinder that turns: its angular velocity in place of no spin, where rolling knows it, and its rate; then rate and spin at set-up.
    Plane: unit normal (3), pivot (3), distance of the plane from the pivot along the normal, velocity (3), omega (3), surface velocity (3).
    """
    shape = wall.shape
    if isinstance(shape, Plane):
        size = hypot(*shape.normal)
        normal = np.array(shape.normal) / size
        return np.array([*normal, *shape.pivot, -shape.offset / size - normal @ np.array(shape.pivot), *shape.velocity, *shape.omega, *wall.velocity])
    numbers = (shape.lo, shape.hi, 0.0) if isinstance(shape, Slab) else (*shape.center, shape.radius)
    if isinstance(shape, Cylinder) and shape.rotation:
        return np.array([*numbers, *wall.velocity, *_rotation_numbers(shape.axis, shape.rotation)])
    return np.array([*numbers, *wall.velocity, 0.0, 0.0, 0.0])


def _rotation_numbers(axis: int, rotation: Rotation) -> Floats:
    """(8,) spin and rate in a step, rate and spin at set-up."""
    spin = rotation.rate * float(rotation.rolls) * np.eye(3)[axis]
    share = float(not rotation.still_at_setup)
    return np.array([*spin, rotation.rate, share * rotation.rate, *(share * spin)])


MOVE = """
@compiled
def move_plane(g, dt):
    for c in range(3):
        g[3 + c] += dt * g[7 + c]
    speed = sqrt(g[10] * g[10] + g[11] * g[11] + g[12] * g[12])
    if speed > 0.0:
        # Rodrigues: n cos + (k x n) sin + k (k.n)(1 - cos)
        kx, ky, kz = g[10] / speed, g[11] / speed, g[12] / speed
        turn, along = sin(speed * dt), 2.0 * sin(0.5 * speed * dt) ** 2
        nx, ny, nz = g[0], g[1], g[2]
        cx, cy, cz = ky * nz - kz * ny, kz * nx - kx * nz, kx * ny - ky * nx
        g[0] = nx + turn * cx + along * (ky * cz - kz * cy)
        g[1] = ny + turn * cy + along * (kz * cx - kx * cz)
        g[2] = nz + turn * cz + along * (kx * cy - ky * cx)
        size = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
        for c in range(3):
            g[c] /= size
"""


CURVATURES = {"volume": 0, "mean": 1, "gaussian": 2}
"""As surface.MEAN and surface.GAUSSIAN."""


def _shape_source(wall: Wall) -> str:
    """What is different for a superquadric: of those whose bounding sphere touches, overlap, contact point and effective radius."""
    moves = """
            wvx += turning[1] * (az + way * nz) - turning[2] * (ay + way * ny)
            wvy += turning[2] * (ax + way * nx) - turning[0] * (az + way * nz)
            wvz += turning[0] * (ay + way * ny) - turning[1] * (ax + way * nx)"""
    return f"""
        round_ = b.axes[i, 0] == 0.0
        ax = ay = az = 0.0
        if touches and not round_:
            overlap, ax, ay, az, reff = meet_plane(i, way, nx, ny, nz, b, {CURVATURES[wall.law.curvature]}, {min(wall.law.curvature_limit, 1e300)})
            touches = overlap > 0.0{moves if isinstance(wall.shape, Plane) else ""}"""


def _wall_force_source(k: int, wall: Wall) -> str:
    text = (HERE / "kernel_wall.py").read_text().partition("@inlined")
    copy = "".join(text[1:]).replace("wall_", f"wall{k}_")
    for name, arm in (("SURFACE_CONTACT", wall.law.surface_arm), ("TORQUE_CONTACT", wall.law.torque_arm)):
        copy = copy.replace(name, str(arm == "contact"))
    return copy.replace("BASE", str(len(memory_signs(wall.law)))) + "\n\n"


def wall_arrays(k: int) -> str:
    """Source of the arrays of wall k: all walls come as one flat tuple, which threads can be given."""
    return ", ".join(f"walls[{5 * k + m}]" for m in range(5))


def walls_source(scene: Scene) -> str:
    """Sources of `wall_forces` and `wall_stored`: every wall in turn, on one particle."""
    walls, shapes = scene.walls, scene.particles.superquadrics is not None
    forces, stored = [], []
    for k, wall in enumerate(walls):
        gap = f"wall{k}_reach(b.radius[i], coefficients, b.kind[i]) if touching[i] else 0.0" if goes_beyond(wall.law) else "0.0"
        overlap = "b.radius[i] - way" if goes_beyond(wall.law) else "max(b.radius[i] - way, TINY)"
        head = f"""
    geometry, bit, coefficients, memory, touching = {wall_arrays(k)}
    if {member(scene, wall.bit, "bit")}:
        gap = {gap}
{_geometry_source(wall)}
        overlap = {overlap}{_shape_source(wall) if shapes else ""}"""
        held = f"wall{k}_stored(memory, i, -gap, b.radius[i], 0.0, reff, b.mass[i], 0.0, dt, coefficients, b.kind[i])[0]"
        snap = f"\n            if BUDGET and advance:\n                tally[0] -= {held}" if goes_beyond(wall.law) else ""
        inside = "" if isinstance(wall.shape, Cylinder) else "\n        if GUARD and way == 0.0:\n            tally[6] += 1.0"  # no way out is known
        forces.append(f"""{head}{_rotation_source(wall.shape)}{inside}
        if touches:
            touching[i] = 1
            wall{k}_force(i, nx, ny, nz, overlap, reff, {"ax, ay, az, round_" if shapes else "0.0, 0.0, 0.0, True"}, wvx, wvy, wvz, turning,
                b, memory, coefficients, dt, advance, tally)
        elif touching[i]:
            touching[i] = 0{snap}
            wall_parting(i, {len(memory_signs(wall.law))}, wvx, wvy, wvz, turning, b, memory, dt, advance, tally)
""")
        stored.append(f"""{head}
        if touches:
            vn = (b.v[i, 0] - wvx) * nx + (b.v[i, 1] - wvy) * ny + (b.v[i, 2] - wvz) * nz
            en, et, er = wall{k}_stored(memory, i, overlap, rough_size(b, i), 0.0, reff, heft(b, i), vn, dt, coefficients, b.kind[i])
            normal += en
            tangential += et
            rolling += er
""")
    copies = "".join(_wall_force_source(k, wall) for k, wall in enumerate(walls))
    moves = [f"    move_plane(walls[{5 * k}], dt)" for k, wall in enumerate(walls) if isinstance(wall.shape, Plane) and wall.shape.moving]
    return f"""
{copies}
{MOVE if moves else ""}
@compiled
def move_walls(walls, dt):
{chr(10).join(moves) or "    pass"}

@inlined
def wall_forces(i, b, walls, dt, advance, tally):
    pass
{"".join(forces)}

@compiled
def wall_stored(i, b, walls, dt):
    normal = tangential = rolling = 0.0
{"".join(stored)}
    return normal, tangential, rolling
"""


def wall_sweep_source(walls: tuple[Wall, ...]) -> str:
    """Source of `wall_sweep`: kernel_gradient.pair_sweep for walls."""
    parts = []
    for k, wall in enumerate(walls):
        parts.append(f"""
    geometry, bit, coefficients, memory, touching = {wall_arrays(k)}
    for i in range(b.x.shape[0]):
        if not (b.mask[i] >> bit) & 1:
            continue
        gap = 0.0
{_geometry_source(wall)}
        if not 0.0 < way < b.radius[i] + margin:
            continue
{_mean_normal(wall.shape)}
        gain = 0.5 * dt * dt * inverse_mass[i]
        approach = -(
            nx * (path[i, 0] - dt * wvx - gain * pull[{k}, i, 0]) + ny * (path[i, 1] - dt * wvy - gain * pull[{k}, i, 1])
            + nz * (path[i, 2] - dt * wvz - gain * pull[{k}, i, 2])
        )
        mean = wall{k}_solve(b.radius[i] - way, approach, gain * (nx * nx + ny * ny + nz * nz), coefficients, b.kind[i])
        change = wall_solved(i, nx, ny, nz, b.radius[i] - way, approach, gain, mean, inverse_mass, dt, path, pull[{k}])
        largest = max(largest, change)
""")
    return f"""
@compiled
def wall_sweep(b, walls, dt, inverse_mass, path, pull, margin):
    largest = 0.0
{"".join(parts)}
    return largest
"""


def _mean_normal(shape: Slab | Cylinder | Plane) -> str:
    """Of a cylinder (r + r')/(|r| + |r'|), r from its axis; planes do not turn within a step."""
    if not isinstance(shape, Cylinder):
        return ""
    a = shape.axis
    u, v = (a + 1) % 3, (a + 2) % 3
    normal = ["0.0", "0.0", "0.0"]
    normal[u], normal[v] = f"sign * (2.0 * du + path[i, {u}]) / both", f"sign * (2.0 * dv + path[i, {v}]) / both"
    return f"""
        both = off + sqrt((du + path[i, {u}]) ** 2 + (dv + path[i, {v}]) ** 2)
        nx, ny, nz = {", ".join(normal)}
"""


def steady_source(scene: Scene) -> str:
    """Source of `steady_forces`: gravity, which a step solves together with the springs, written to b.aside."""
    lines = []
    for k, field in enumerate(scene.forces):
        if isinstance(field, Gravity):
            lines.append(f"        if (b.mask[i] >> bits[{k}]) & 1:")
            lines += [f"            b.aside[i, {c}] += b.mass[i] * numbers[{k}, {c}]" for c in range(3)]
    loop = "    numbers, bits, gammas, last_force = fields\n    for i in range(b.x.shape[0]):\n" + "\n".join(lines) if lines else "    pass"
    return f"\n@compiled\ndef steady_forces(b, fields):\n    b.aside[:] = 0.0\n{loop}\n"


def fields_source(scene: Scene, *, implicit: bool, rotates: bool) -> str:
    """Source of `field_forces`: the fields of the scene in their order, on one particle."""
    lines, drags, writer = [], 0, Writer()
    adds = sum(isinstance(field, Viscous) for field in scene.forces)
    sums = ("force", "aside") if implicit else ("force",)
    for k, field in enumerate(scene.forces):
        lines.append(f"    if {member(scene, field.bit, f'bits[{k}]')}:")
        if isinstance(field, Gravity):
            if scene.particles.clumps and not scene.particles.clumps.members_weigh:
                lines[-1] = lines[-1].replace(":", " and b.clump[i] < 0:")  # the clump as a whole is pulled
            lines += [f"        b.{array}[i, {c}] += b.mass[i] * numbers[{k}, {c}]" for array in sums for c in range(3)]
        elif isinstance(field, Viscous):
            lines.append(f"        drag(i, gammas[{drags}, b.kind[i]], b, last_force[{drags}], dt, advance, tally)")
            drags += 1
        elif isinstance(field, AddForce):
            lines += _added_lines(field, adds, writer)
            writer.names.clear()  # the next may stand behind another question
            adds += 1
        elif isinstance(field, SetForce):
            lines += [f"        b.force[i, {c}] = numbers[{k}, {c}]" for c in range(3) if field.force[c] is not None] or ["        pass"]
        elif isinstance(field, Freeze):
            lines += [f"        b.{array}[i, {c}] = 0.0" for array in (*sums, *(["torque"] if rotates else [])) for c in range(3)]
        elif isinstance(field, Enforce2D):
            names = ("b.v[i, 2]", "b.force[i, 2]", "b.omega[i, 0]", "b.omega[i, 1]", "b.torque[i, 0]", "b.torque[i, 1]")
            lines += [f"        {name} = 0.0" for name in names]
    loop = "    numbers, bits, gammas, last_force = fields\n" + "\n".join(lines) if lines else "    pass"
    head = "".join(f"{line}\n" for line in writer.imports())
    return f"\n{head}\n@inlined\ndef field_forces(i, b, fields, dt, advance, tally):\n{loop}\n"


def _added_lines(field: AddForce, k: int, writer: Writer) -> list[str]:
    """Adds the values of the formulas to the force on particle i; k: where its last force is kept."""
    lines = [line for component in field.force for line in writer.statements(component)]
    for c, component in enumerate(field.force):
        if component != Number(0.0):
            lines.append(f"add(i, {c}, {writer.names[component]}, b, last_force[{k}], dt, advance, tally)")
    return [f"        {line}" for line in lines or ["pass"]]


def member(scene: Scene, bit: int, name: str) -> str:
    """Source of the question whether particle i is in a group; of a group of all no question."""
    return "True" if selected(scene.particles.mask, bit).all() else f"(b.mask[i] >> {name}) & 1"

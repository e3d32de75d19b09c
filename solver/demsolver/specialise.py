"""Binds the laws that a scene names into one compiled loop, and nothing else.

The loop is written as a Python file of its own, `<cache>/demsolver_<digest>.py`: a generated header (laws, constants, walls, fields) in
front of the text of kernel.py. The digest covers every source that went in and the versions of Python and Numba, so that an edited law
makes a new file and Numba's cache can never serve the old physics.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from demsolver import contact
from demsolver.neighbors import HOME
from demsolver.scene import ContactLaw, Cylinder, Enforce2D, Freeze, Gravity, Scene, SetForce, Slab, Viscous, Wall
from demsolver.state import Floats

HERE = Path(__file__).parent
MEMORY, BUDGET_MEMORY = 3, 15
SIGNATURE = "overlap, reff, meff, vn, nx, ny, nz, vtx, vty, vtz, sx, sy, sz, dt, advance, coefficients, row"


def law_coefficients(law: ContactLaw) -> tuple[str, ...]:
    """Names of the coefficients that the laws of `law` need, each once, in the order of the families."""
    names = [(family, getattr(law, family)) for family in contact.FAMILIES if _in_use(law, family)]
    return tuple(dict.fromkeys(c for family, name in names for c in contact.coefficients(family, name)))


def coefficient_table(law: ContactLaw) -> Floats:
    """(rows, c) table: one row a type pair (or type, for a wall), one column a coefficient. Raises ValueError for a missing one."""
    names = law_coefficients(law)
    missing = [name for name in names if name not in law.coefficients]
    if missing:
        message = f"coefficient {missing[0]!r} of the contact law is missing; given: {', '.join(law.coefficients) or 'none'}"
        raise ValueError(message)
    rows = max((np.size(law.coefficients[name]) for name in names), default=1)
    return np.column_stack([np.ravel(law.coefficients[name]) for name in names]) if names else np.zeros((rows, 1))


def _in_use(law: ContactLaw, family: contact.Family) -> bool:
    return law.friction != "none" or family in ("normal", "damping")


def contact_source(name: str, law: ContactLaw) -> str:
    """Source of `<name>_contact` and `<name>_stored`: the chosen laws chained, each called with the names in its own signature."""

    def call(family: contact.Family, function: str | None = None) -> str:
        entry = function or contact.ENTRY[family]
        arguments = inspect.signature(getattr(contact.law(family, getattr(law, family)), entry)).parameters
        return f"{name}_{family}_{entry}({', '.join(arguments)})"

    rubbing = law.friction != "none"
    unpack = [f"    {c} = coefficients[row, {k}]" for k, c in enumerate(law_coefficients(law))]
    common = [
        *unpack,
        "    contact_radius = sqrt(reff * overlap)",
        f"    normal_elastic = {call('normal')}",
        "    stiffness = normal_elastic / overlap if overlap > 0.0 else 0.0",
    ]
    tangential = [f"    kt = {call('tangential_stiffness')}"] if rubbing else []
    lines = [
        "@compiled",
        f"def {name}_contact({SIGNATURE}):",
        *common,
        f"    gn = {call('damping')}",
        "    normal_force = normal_elastic - gn * vn",
        *(["    normal_force = max(normal_force, 0.0)"] if law.limit_damping else []),
        *tangential,
        *([f"    gt = {call('tangential_damping')}"] if rubbing else []),
        f"    fx, fy, fz, sx, sy, sz = {call('friction')}" if rubbing else "    fx = fy = fz = 0.0",
        "    return normal_force, normal_force - normal_elastic, fx, fy, fz, sx, sy, sz",
        "",
        "@compiled",
        f"def {name}_stored(overlap, reff, meff, s_squared, coefficients, row):",
        *common,
        *tangential,
        f"    return {call('normal', 'energy')}, {'0.5 * kt * s_squared' if rubbing else '0.0'}",
    ]
    return "\n".join(lines) + "\n\n"


def law_functions(name: str, law: ContactLaw) -> dict[str, Callable[..., object]]:
    """The plain Python functions that `contact_source` calls, by the names it calls them."""
    found = {}
    for family in contact.FAMILIES:
        if _in_use(law, family):
            module = contact.law(family, getattr(law, family))
            for entry in (contact.ENTRY[family], *(["energy"] if family == "normal" else [])):
                found[f"{name}_{family}_{entry}"] = getattr(module, entry)
    return found


def _law_imports(name: str, law: ContactLaw) -> str:
    lines = [f"{key} = compiled({f.__module__}.{f.__name__})" for key, f in law_functions(name, law).items()]
    return "\n".join([*(f"import {m}" for m in sorted({f.__module__ for f in law_functions(name, law).values()})), *lines]) + "\n"


def keeps_history(law: ContactLaw) -> bool:
    """Whether the friction law has a memory."""
    return law.friction != "none" and bool(contact.law("friction", law.friction).HISTORY)


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
        touches = way > 0.0 and way {touch} b.radius[i]
        nx, ny, nz = {", ".join(normal)}
        overlap, reff = max(b.radius[i] - way, TINY), b.radius[i]
"""


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
        touches = off > 0.0 and way > 0.0 and way {touch} b.radius[i]
        nx = ny = nz = 0.0
        reff = {curved}
        if touches:
            nx, ny, nz = {", ".join(normal)}
        overlap = max(b.radius[i] - way, TINY)
"""


def _geometry_source(wall: Wall) -> str:
    if isinstance(wall.shape, Slab):
        return _slab(wall.shape, wall.touch_closed)
    return _cylinder(wall.shape, wall.touch_closed)


def wall_geometry(wall: Wall) -> Floats:
    """Numbers that the generated wall code reads: slab lo, hi; cylinder centre and radius; then the surface velocity (3)."""
    shape = wall.shape
    numbers = (shape.lo, shape.hi, 0.0) if isinstance(shape, Slab) else (*shape.center, shape.radius)
    return np.array([*numbers, *wall.velocity])


def _wall_force_source(k: int, wall: Wall) -> str:
    text = (HERE / "kernel_wall.py").read_text().partition("@compiled")
    copy = "".join(text[1:]).replace("wall_", f"wall{k}_")
    for name, arm in (("SURFACE_CONTACT", wall.law.surface_arm), ("TORQUE_CONTACT", wall.law.torque_arm)):
        copy = copy.replace(name, str(arm == "contact"))
    return copy + "\n\n"


def walls_source(walls: tuple[Wall, ...]) -> str:
    """Sources of `wall_forces` and `wall_stored`: every wall in turn."""
    forces, stored = [], []
    for k, wall in enumerate(walls):
        head = f"""
    geometry, bit, coefficients, memory, touching = walls[{k}]
    for i in range(b.x.shape[0]):
        if not (b.mask[i] >> bit) & 1:
            continue
{_geometry_source(wall)}"""
        forces.append(f"""{head}
        if touches:
            touching[i] = 1
            wall{k}_force(i, nx, ny, nz, overlap, reff, geometry[3], geometry[4], geometry[5], b, memory, coefficients, dt, advance, tally)
        elif touching[i]:
            touching[i] = 0
            wall_parting(i, geometry[3], geometry[4], geometry[5], b, memory, dt, advance, tally)
""")
        stored.append(f"""{head}
        if touches:
            s = memory[i, 0] ** 2 + memory[i, 1] ** 2 + memory[i, 2] ** 2
            en, et = wall{k}_stored(overlap, reff, b.mass[i], s, coefficients, b.kind[i])
            normal += en
            tangential += et
""")
    copies = "".join(_wall_force_source(k, wall) for k, wall in enumerate(walls))
    return f"""
{copies}
@compiled
def wall_forces(b, walls, dt, advance, tally):
    pass
{"".join(forces)}

@compiled
def wall_stored(b, walls):
    normal = tangential = 0.0
{"".join(stored)}
    return normal, tangential
"""


def fields_source(scene: Scene) -> str:
    """Source of `field_forces`: the fields of the scene in their order, in one loop over the particles."""
    lines, drags = [], 0
    for k, field in enumerate(scene.forces):
        lines.append(f"        if (b.mask[i] >> bits[{k}]) & 1:")
        if isinstance(field, Gravity):
            lines += [f"            b.force[i, {c}] += b.mass[i] * numbers[{k}, {c}]" for c in range(3)]
        elif isinstance(field, Viscous):
            lines.append(f"            drag(i, gammas[{drags}, b.kind[i]], b, drag_memory[{drags}], dt, advance, tally)")
            drags += 1
        elif isinstance(field, SetForce):
            lines += [f"            b.force[i, {c}] = numbers[{k}, {c}]" for c in range(3) if field.force[c] is not None] or ["            pass"]
        elif isinstance(field, Freeze):
            lines += ["            b.force[i] = 0.0", "            b.torque[i] = 0.0"]
        elif isinstance(field, Enforce2D):
            names = ("b.v[i, 2]", "b.force[i, 2]", "b.omega[i, 0]", "b.omega[i, 1]", "b.torque[i, 0]", "b.torque[i, 1]")
            lines += [f"            {name} = 0.0" for name in names]
    loop = "    numbers, bits, gammas, drag_memory = fields\n    for i in range(b.x.shape[0]):\n" + "\n".join(lines) if lines else "    pass"
    return f"\n@compiled\ndef field_forces(b, fields, dt, advance, tally):\n{loop}\n"


def meets(scene: Scene) -> bool:
    """Whether there can be pairs at all: two particles, or one and its periodic image."""
    return len(scene.particles.id) > 1 or any(scene.box.periodic)


def constants(scene: Scene, budget: bool, virial: bool) -> dict[str, bool]:
    """What the scene has; the compiled loop drops what is False."""
    pair = scene.pair if meets(scene) else None
    return {
        "PAIRS": pair is not None,
        "FRICTION": pair is not None and pair.friction != "none",
        "HISTORY": pair is not None and keeps_history(pair),
        "OUTLIVES": scene.history_outlives_contact,
        "BUDGET": budget,
        "VIRIAL": virial,
        "PERIODIC": any(scene.box.periodic),
        "FROZEN": any(isinstance(f, Freeze) for f in scene.forces),
        "SURFACE_CONTACT": pair is not None and pair.surface_arm == "contact",
        "TORQUE_CONTACT": pair is not None and pair.torque_arm == "contact",
    }


NO_LAW = """
@compiled
def pair_contact(overlap, reff, meff, vn, nx, ny, nz, vtx, vty, vtz, sx, sy, sz, dt, advance, coefficients, row):
    return 0.0, 0.0, 0.0, 0.0, 0.0, sx, sy, sz

@compiled
def pair_stored(overlap, reff, meff, s_squared, coefficients, row):
    return 0.0, 0.0
"""


def source(scene: Scene, threads: int, *, budget: bool, virial: bool) -> str:
    """The whole text of the specialised module."""
    pair = scene.pair if meets(scene) else None
    laws = ([("pair", pair)] if pair else []) + [(f"wall{k}", wall.law) for k, wall in enumerate(scene.walls)]
    head = [
        '"""Written by demsolver.specialise; a copy of kernel.py behind the laws of one scene."""',
        "from math import sqrt",
        "from numba import njit",
        'compiled = njit(error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)',
        'entry = njit(cache=True, error_model="numpy", nogil=True, no_cfunc_wrapper=True)',
        'threaded = njit(error_model="numpy", nogil=True, parallel=True)' if threads > 1 else "threaded = compiled",
        f"THREADED = {threads > 1}",
        f"HOME = {HOME}",
        "TINY = 1e-200  # at zero overlap, where LIGGGHTS' walls touch already, stiffness is a limit",
        *(f"{name} = {value}" for name, value in constants(scene, budget, virial).items()),
        *(_law_imports(name, law) for name, law in laws),
        *(contact_source(name, law) for name, law in laws),
        NO_LAW if pair is None else "",
    ]
    kernel = (HERE / "kernel.py").read_text()
    loop, split, rest = kernel.partition("@compiled\ndef forces(")
    return "\n".join(head) + loop + walls_source(scene.walls) + fields_source(scene) + "\n\n" + split + rest


def specialise(scene: Scene, threads: int = 1, *, budget: bool = False, virial: bool = False) -> ModuleType:
    """The compiled loop for this scene: a module with run_steps and stored."""
    laws = [scene.pair] if scene.pair else []
    laws += [wall.law for wall in scene.walls]
    modules = sorted({f.__module__ for law in laws for f in law_functions("x", law).values()})
    return _load(source(scene, threads, budget=budget, virial=virial), tuple(modules))


@cache
def _load(text: str, modules: tuple[str, ...]) -> ModuleType:
    import numba

    laws = "".join(inspect.getsource(sys.modules[name]) for name in modules)
    digest = hashlib.sha256(f"{text}\x00{laws}\x00{sys.version}\x00{numba.__version__}".encode()).hexdigest()[:16]
    name = f"demsolver_{digest}"
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        _write(path, text)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def cache_folder() -> Path:
    """Where specialised loops are kept: $XDG_CACHE_HOME/demsolver or ~/.cache/demsolver, else a temporary folder."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = home / "demsolver"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"demsolver-{os.getuid()}"
        folder.mkdir(exist_ok=True)
    return folder


def _write(path: Path, text: str) -> None:
    with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".tmp", delete=False) as out:
        out.write(text)
    Path(out.name).replace(path)

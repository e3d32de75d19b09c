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
from functools import cache
from pathlib import Path
from types import ModuleType

from demsolver.bind_law import SIGNATURE, STORED, contact_source, goes_beyond, is_implicit, is_step_law, law_functions, law_imports, memory_signs
from demsolver.bind_walls import fields_source, steady_source, wall_sweep_source, walls_source
from demsolver.neighbors import HOME
from demsolver.scene import ContactLaw, EulerSphere, Freeze, Plane, Scene, SetForce

HERE = Path(__file__).parent
BUDGET_COLUMNS = 19  # of a contact's memory, behind those of its law


def meets(scene: Scene) -> bool:
    """Whether there can be pairs at all: two particles, or one and its periodic image."""
    return len(scene.particles.id) > 1 or any(scene.box.periodic)


def laws_of(scene: Scene) -> list[ContactLaw]:
    """The pair law, then those of the walls."""
    return [*([scene.pair] if scene.pair else []), *(wall.law for wall in scene.walls)]


def shifting(scene: Scene) -> bool:
    """Whether a step law of the scene corrects positions."""
    return any(is_step_law(law) for law in laws_of(scene))


def implicit(scene: Scene) -> bool:
    """Whether the normal laws of the scene solve for the step. Raises ValueError for what such a step cannot hold."""
    laws = laws_of(scene)
    if not any(is_implicit(law) for law in laws):
        return False
    message = ""
    if others := [law.normal for law in laws if not is_implicit(law)]:
        message = f"a scene with one implicit normal law can have no other: all pairs and walls, not {others[0]} for some"
    elif any(isinstance(integrator, EulerSphere) for integrator in scene.integrate):
        message = "an implicit normal law comes with a step of its own, which is not semi-implicit Euler: use nve/sphere"
    elif any(isinstance(field, SetForce) for field in scene.forces):
        message = "an implicit normal law cannot be solved for where setforce overrules it"
    if message:
        raise ValueError(message)
    return True


def constants(scene: Scene, budget: bool, virial: bool) -> dict[str, bool | int]:
    """What the scene has; the compiled loop drops what is False. Raises ValueError for two integrators in one scene."""
    pair = scene.pair if meets(scene) else None
    schemes = {type(integrator) for integrator in scene.integrate}
    if len(schemes) > 1:
        message = f"one scene has one integrator, not {' and '.join(sorted(scheme.__name__ for scheme in schemes))}"
        raise ValueError(message)
    return {
        "PAIRS": pair is not None,
        "FRICTION": pair is not None and pair.friction != "none",
        "ROLLING": pair is not None and (pair.rolling, pair.twisting) != ("none", "none"),
        "BEYOND": pair is not None and goes_beyond(pair),
        "BASE": len(memory_signs(pair)),
        "OUTLIVES": scene.history_outlives_contact,
        "BUDGET": budget,
        "VIRIAL": virial,
        "PERIODIC": any(scene.box.periodic),
        "FROZEN": any(isinstance(f, Freeze) for f in scene.forces),
        "SURFACE_CONTACT": pair is not None and pair.surface_arm == "contact",
        "TORQUE_CONTACT": pair is not None and pair.torque_arm == "contact",
        "SHIFTING": shifting(scene),
        "IMPLICIT": implicit(scene),
        "MOVING": any(isinstance(wall.shape, Plane) and wall.shape.moving for wall in scene.walls),
        "VERLET": schemes != {EulerSphere},
    }


NO_LAW = f"""
@compiled
def pair_contact({SIGNATURE}):
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

@compiled
def pair_stored({STORED}):
    return 0.0, 0.0, 0.0

@compiled
def pair_reach(reff, coefficients, row):
    return 0.0

@compiled
def pair_rolling_share(radius, partner_radius):
    return 1.0
"""


def source(scene: Scene, threads: int, *, budget: bool, virial: bool) -> str:
    """The whole text of the specialised module."""
    pair = scene.pair if meets(scene) else None
    laws = ([("pair", pair)] if pair else []) + [(f"wall{k}", wall.law) for k, wall in enumerate(scene.walls)]
    head = [
        '"""Written by demsolver.specialise; a copy of kernel.py behind the laws of one scene."""',
        "from math import sin, sqrt",
        "from numba import njit",
        'compiled = njit(error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)',
        'inlined = njit(error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True)',
        'entry = njit(cache=True, error_model="numpy", nogil=True, no_cfunc_wrapper=True)',
        'threaded = njit(error_model="numpy", nogil=True, parallel=True)' if threads > 1 else "threaded = compiled",
        f"THREADED = {threads > 1}",
        f"HOME = {HOME}",
        f"ROLLING_INERTIA = {scene.rolling_inertia}",
        "TINY = 1e-200  # at zero overlap, where LIGGGHTS' walls touch already, stiffness is a limit",
        *(f"{name} = {value}" for name, value in constants(scene, budget, virial).items()),
        *(law_imports(name, law) for name, law in laws),
        *(contact_source(name, law) for name, law in laws),
        NO_LAW if pair is None else "",
    ]
    kernel = (HERE / "kernel.py").read_text()
    loop, split, rest = kernel.partition("@compiled\ndef forces(")
    fields = fields_source(scene, implicit(scene))
    if implicit(scene):
        steps, entry, stored = rest.partition("@entry\ndef stored(")
        gradient = (HERE / "kernel_gradient.py").read_text()
        rest = steps.partition("@entry\ndef run_steps(")[0] + wall_sweep_source(scene.walls) + gradient + "\n\n" + entry + stored
        fields += steady_source(scene)
    return "\n".join(head) + loop + walls_source(scene.walls) + fields + "\n\n" + split + rest


def specialise(scene: Scene, threads: int = 1, *, budget: bool = False, virial: bool = False) -> ModuleType:
    """The compiled loop for this scene: a module with run_steps and stored."""
    modules = sorted({f.__module__ for law in laws_of(scene) for f in law_functions("x", law).values()})
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

"""Binds the laws that a scene names into one compiled loop, and nothing else.

The loop is written as a Python file of its own, `<cache>/demsolver_<digest>.py`: a generated header (laws, constants, walls, fields) in
front of the text of kernel.py. The digest covers every source that went in and the versions of Python and Numba, so that an edited law
makes a new file and Numba's cache can never serve the old physics.
"""

from __future__ import annotations

import gc
import hashlib
import importlib
import importlib.util
import inspect
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from types import ModuleType

from demsolver.bind_law import (
    SIGNATURE,
    STORED,
    coefficient_table,
    contact_source,
    goes_beyond,
    is_implicit,
    is_step_law,
    law_functions,
    law_imports,
    memory_signs,
)  # fmt: skip
from demsolver.bind_walls import CURVATURES, fields_source, steady_source, wall_sweep_source, walls_source
from demsolver.near import BLOCK, FIELDS
from demsolver.neighbors import HOME, PARTNER_FEELS
from demsolver.scene import AddForce, ContactLaw, Enforce2D, EulerSphere, Freeze, NveClumps, NveSuperquadric, Plane, Scene, SetForce
from demsolver.state import factor_of

HERE = Path(__file__).parent
CHUNK = 1024
"""Rows that are done in one go, and by one thread: enough to be worth it, few enough to stay in a core's cache. Part of what a result depends on."""
BOOKS, BOOKS_OF_SHAPES = 19, 25  # columns of a contact's memory, behind those of its law, that the energy budget needs
GEOMETRY = 7  # behind those, for superquadrics
DEEPEST = 0.5  # overlap over the smaller radius that the guard allows


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


@dataclass(frozen=True)
class Features:
    """What a scene has, as the constants of the loop (see kernel.py); what is False costs nothing; of FREE, UNIFORM and ONE_LAW what is True.

    SHAPE_CONTACT: kind of contact point of superquadrics, kind and limit of curvature (kernel_shape.meet). BOOKS, GEOMETRY: columns of a contact's
    memory (kernel_books.py). SCHEME, CLUMP_SCHEME: files of demsolver.rotation.
    """

    PAIRS: bool
    FRICTION: bool
    ROLLING: bool
    ROTATES: bool
    BEYOND: bool
    BASE: int
    OUTLIVES: bool
    BUDGET: bool
    VIRIAL: bool
    PERIODIC: bool
    FROZEN: bool
    SURFACE_CONTACT: bool
    TORQUE_CONTACT: bool
    SHIFTING: bool
    IMPLICIT: bool
    MOVING: bool
    VERLET: bool
    THREADED: bool
    CHUNK: int
    SLEEPS: bool
    FREE: bool
    UNIFORM: bool
    ONE_LAW: bool
    SAME_TORQUE: bool
    GUARD: bool
    SHAPES: bool
    CLUMPS: bool
    TORQUES: bool
    SHAPE_CONTACT: tuple[int, int, float]
    BOOKS: int
    GEOMETRY: int
    SCHEME: str
    CLUMP_SCHEME: str


def features(scene: Scene, threads: int = 1, *, budget: bool = False, virial: bool = False, sleeps: bool = False, guard: bool = False) -> Features:
    """What the loop of this scene needs. Raises ValueError for two integrators in one scene."""
    pair = scene.pair if meets(scene) else None
    curvature = (CURVATURES[pair.curvature], min(pair.curvature_limit, 1e300)) if pair else (0, 1e300)
    schemes = {type(integrator) for integrator in scene.integrate}
    if EulerSphere in schemes and len(schemes) > 1:
        message = f"one scene has one integrator, not {' and '.join(sorted(scheme.__name__ for scheme in schemes))}"
        raise ValueError(message)
    shapes, clumps = scene.particles.superquadrics is not None, scene.particles.clumps is not None
    base, books = len(memory_signs(pair)), BOOKS_OF_SHAPES if shapes else BOOKS
    rubs = any(law.friction != "none" or turns(law) for law in laws_of(scene))
    aside = shifting(scene) or implicit(scene)
    return Features(
        PAIRS=pair is not None,
        FRICTION=pair is not None and pair.friction != "none",
        ROLLING=pair is not None and turns(pair),
        ROTATES=budget or rubs or shapes or clumps or any(isinstance(f, Enforce2D) for f in scene.forces),
        BEYOND=pair is not None and goes_beyond(pair),
        BASE=base,
        OUTLIVES=scene.history_outlives_contact,
        BUDGET=budget,
        VIRIAL=virial,
        PERIODIC=any(scene.box.periodic),
        FROZEN=any(isinstance(f, Freeze) for f in scene.forces),
        SURFACE_CONTACT=pair is not None and pair.surface_arm == "contact",
        TORQUE_CONTACT=pair is not None and pair.torque_arm == "contact",
        SHIFTING=shifting(scene),
        IMPLICIT=implicit(scene),
        MOVING=any(isinstance(wall.shape, Plane) and wall.shape.moving for wall in scene.walls),
        VERLET=schemes != {EulerSphere},
        THREADED=threads > 1 and not aside and len(scene.particles.id) > CHUNK,
        CHUNK=1 << 60 if aside else CHUNK,
        SLEEPS=sleeps,
        FREE=pair is not None and not scene.forces and not scene.walls and not aside and not shapes and not clumps,
        UNIFORM=_uniform(scene),
        SAME_TORQUE=_uniform(scene) and pair is not None and not turns(pair),
        GUARD=guard,
        SHAPES=shapes,
        CLUMPS=clumps,
        TORQUES=pair is not None and (pair.friction != "none" or turns(pair) or shapes),
        SHAPE_CONTACT=(int(scene.contact_point == "gauge"), *curvature),
        BOOKS=books,
        GEOMETRY=base + (books if budget else 0),
        SCHEME=_scheme(scene, NveSuperquadric),
        CLUMP_SCHEME=_scheme(scene, NveClumps),
        ONE_LAW=pair is not None and bool((coefficient_table(pair) == coefficient_table(pair)[0]).all()),
    )


def turns(law: ContactLaw) -> bool:
    """Whether the law resists rolling or twisting."""
    return (law.rolling, law.twisting) != ("none", "none")


def _uniform(scene: Scene) -> bool:
    """Whether all particles have one radius and mass, and those that move one inertia: nothing of the kind is looked up then."""
    p = scene.particles
    factors = {factor_of(integrator) for integrator in scene.integrate}
    if p.superquadrics is not None or p.clumps is not None:
        return False
    return len(p.id) > 0 and len(factors) < 2 and bool((p.radius == p.radius[0]).all() and (p.mass == p.mass[0]).all())


def _scheme(scene: Scene, kind: type[NveSuperquadric | NveClumps]) -> str:
    """Of the bodies that integrators of this kind move. Raises ValueError where two of them differ."""
    found = {integrator.scheme for integrator in scene.integrate if isinstance(integrator, kind)}
    if len(found) > 1:
        message = f"one scene has one rotation scheme for {kind.__name__}, not {' and '.join(sorted(found))}"
        raise ValueError(message)
    return found.pop() if found else kind().scheme


NO_LAW = f"""
@inlined
def pair_contact({SIGNATURE}):
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

@compiled
def pair_stored({STORED}):
    return 0.0, 0.0, 0.0

@inlined
def pair_reach(reff, coefficients, row):
    return 0.0

@inlined
def pair_rolling_share(radius, partner_radius):
    return 1.0
"""


JIT = 'error_model="numpy", nogil=True, no_cfunc_wrapper=True'
INNER = f"{JIT}, no_cpython_wrapper=True, _nrt=False"
"""_nrt=False: no counting of references in loops that make no arrays; it would cost more than the contacts."""


def compilers(has: Features) -> list[str]:
    """Source of the decorators of the templates."""
    return [
        "from math import sin, sqrt",
        "from numba import njit",
        f"compiled = njit({INNER})",
        f"inlined = njit({INNER}, forceinline=True)",
        f"entry = njit({JIT}, cache=True)",
        f"shared = njit({INNER}, cache=True)",
        'threaded = njit(error_model="numpy", nogil=True, parallel=True)' if has.THREADED else "threaded = compiled",
        'shared_threaded = njit(error_model="numpy", nogil=True, parallel=True, cache=True)' if has.THREADED else "shared_threaded = shared",
    ]


def shared_source(name: str, has: Features) -> str:
    """The text of a template that knows no law, behind only those constants that it names: one module for all scenes that agree in them."""
    text = _template(name)
    constants = {"HOME": HOME, "PARTNER_FEELS": PARTNER_FEELS, "BLOCK": BLOCK, **asdict(has)}
    head = [f"{key} = {value!r}" for key, value in constants.items() if re.search(rf"(?<!\.)\b{key}\b", text)]
    for scheme in ("SCHEME", "CLUMP_SCHEME"):
        text = text.replace(f"demsolver.rotation.{scheme} ", f"demsolver.rotation.{constants[scheme]} ")
    return "\n\n".join([*compilers(has), *head, text])


def source(scene: Scene, has: Features) -> str:
    """The whole text of the specialised module."""
    pair = scene.pair if has.PAIRS else None
    laws = ([("pair", pair)] if pair else []) + [(f"wall{k}", wall.law) for k, wall in enumerate(scene.walls)]
    head = [
        '"""Written by demsolver.specialise: the templates kernel*.py behind the laws of one scene."""',
        *compilers(has),
        f"HOME, PARTNER_FEELS = {HOME}, {PARTNER_FEELS}",
        f"BLOCK, FIELDS = {BLOCK}, {FIELDS}",
        f"ROLLING_INERTIA = {scene.rolling_inertia}",
        f"DEEPEST = {DEEPEST}",
        "TINY = 1e-200  # at zero overlap, where LIGGGHTS' walls touch already, stiffness is a limit",
        *(f"{name} = {value!r}" for name, value in asdict(has).items()),
        *(f"from {_load(shared_source(name, has), modules).__name__} import *" for name, modules in _shared(has).items()),
        *(law_imports(name, law) for name, law in laws),
        *(contact_source(name, law, one=name == "pair" and has.ONE_LAW, lanes=name == "pair") for name, law in laws),
        NO_LAW if pair is None else "",
        _template("contact"),
        _template("books"),
        walls_source(scene),
        fields_source(scene, implicit=has.IMPLICIT, rotates=has.ROTATES),
    ]
    steps, entry, run = (HERE / "kernel.py").read_text().partition("@entry\ndef run_steps(")
    last = [wall_sweep_source(scene.walls), steady_source(scene), _template("gradient")] if has.IMPLICIT else [entry + run]
    return "\n\n".join([*head, steps, *last, _template("stored")])


def _template(name: str) -> str:
    return (HERE / f"kernel_{name}.py").read_text()


def _shared(has: Features) -> dict[str, tuple[str, ...]]:
    """The templates that know no law, and that this scene needs: name -> the modules of which they call functions."""
    found: dict[str, tuple[str, ...]] = {"motion": (), "near": ()}
    algebra, geometry = "demsolver.algebra", "demsolver.superquadric"
    if has.SHAPES:
        found["shape"] = (algebra, geometry, *(f"{geometry}.{part}" for part in ("surface", "planes", "pairs")))
        found["turn"] = (algebra, f"demsolver.rotation.{has.SCHEME}")
    if has.CLUMPS:
        found["clumps"] = (algebra, f"demsolver.rotation.{has.CLUMP_SCHEME}")
    return found


def specialise(scene: Scene, has: Features) -> ModuleType:
    """The compiled loop for this scene: a module with run_steps and stored."""
    modules = {f.__module__ for law in laws_of(scene) for f in law_functions("x", law).values()}
    if any(isinstance(field, AddForce) for field in scene.forces):
        modules.add("demsolver.expression")
    return _load(source(scene, has), tuple(sorted(modules)))


@contextmanager
def compiling() -> Iterator[None]:
    """Without garbage collection: for calls that may compile, which makes millions of objects that stay; looking through them costs a fifth more."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


ARRAYS = ("demsolver.state", "demsolver.near")
"""Where the types of the arrays are: what has been compiled for others of the same text cannot be read."""


@cache
def _load(text: str, modules: tuple[str, ...] = ()) -> ModuleType:
    """The module of this text, which binds functions of `modules`: its name says what went in."""
    import numba

    laws = "".join(inspect.getsource(importlib.import_module(name)) for name in (*ARRAYS, *modules))
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

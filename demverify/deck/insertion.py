"""LIGGGHTS' templates, distributions and `insert/pack`, as far as they say where a clump goes: native draws no random numbers of LIGGGHTS' own.

A clump is placed by a distribution of one template, a region no larger than rounding, one particle in it, and an orientation that is given. Place:
the centre of mass. LIGGGHTS inserts within the first step of the next run, behind its motion and before its forces, of which half act still:
gravity does so here, other forces are refused, and nothing may touch a clump there (measured, inputs/clump-bounce).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

import numpy as np

from demsolver.shapes.union import union
from demverify.deck.clumps import Kind, place
from demverify.deck.forces import FORCES, gravity
from demverify.deck.materials_common import Words, group_bit
from demverify.deck.setup import Floats, Setup, Spec
from demverify.errors import InputError
from demverify.formats.template import read_template

TEMPLATE, DISTRIBUTION, INSERT = "particletemplate/multisphere", "particledistribution/discrete", "insert/pack"
SMALL = 1e-6
"""Of the smallest radius of a clump: a region no larger is a place."""
UNIT = 1e-10
"""How far the square of a quaternion may be from 1, as in LIGGGHTS."""


def words_of(spec: Spec) -> Words:
    """The words of a fix."""
    return Words(spec.args, f"fix {spec.id} {spec.style}", spec.place)


def template(setup: Setup, spec: Spec) -> Kind:
    """fix particletemplate/multisphere SEED atom_type T density constant D nspheres N ntry K spheres file F scale S type C [mass M use_density
    inertia_tensor Ixx Ixy Ixz Iyy Iyz Izz]. Without mass and inertia those of the union of the spheres, exactly."""
    words, given = words_of(spec), _Template()
    if setup.atom_style == "superquadric":
        raise words.error("makes clumps of spheres: not with atom_style superquadric")
    words.integer("seed", 1)
    while words:
        _TEMPLATE_WORDS[words.choice("keyword", _TEMPLATE_WORDS)](words, given)
    if not given.file:
        raise words.error("needs spheres file NAME scale X type N")
    found = read_template(setup.folder / given.file, given.scale)
    if len(found.radius) != given.count:
        raise words.error(f"nspheres is {given.count}, and {given.file} has {len(found.radius)} spheres")
    if (given.mass is None) != (given.inertia is None):
        raise words.error("mass and inertia_tensor go together")
    if given.mass is not None and given.inertia is not None:
        if given.use != "use_density":
            raise words.error("with mass and inertia_tensor needs use_density: with use_volume LIGGGHTS moves the centre of mass by random points")
        return Kind(found.centre, found.radius, given.mass, given.inertia, given.type)
    whole = union(found.centre, found.radius)
    return Kind(found.centre - whole.centroid, found.radius, given.density * whole.volume, given.density * whole.inertia, given.type)


@dataclass
class _Template:
    type: int = 1
    density: float = 1.0
    count: int = 0
    file: str = ""
    scale: float = 1.0
    mass: float | None = None
    inertia: Floats | None = None
    use: str = ""


def _density(words: Words, given: _Template) -> None:
    words.choice("density", ("constant",))
    given.density = words.positive("density")


def _spheres(words: Words, given: _Template) -> None:
    words.choice("spheres", ("file",))
    given.file = words.take("a file")
    if words.skip("scale"):
        given.scale = words.positive("scale")


def _tensor(words: Words, given: _Template) -> None:
    xx, xy, xz, yy, yz, zz = (words.number(f"I{name}") for name in ("xx", "xy", "xz", "yy", "yz", "zz"))
    given.inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not (np.linalg.eigvalsh(given.inertia) > 0.0).all():
        raise words.error("inertia_tensor must have three moments above 0")


def _set(name: str, read: Callable[[Words], object]) -> Callable[[Words, _Template], None]:
    return lambda words, given: setattr(given, name, read(words))


_TEMPLATE_WORDS: dict[str, Callable[[Words, _Template], None]] = {
    "atom_type": _set("type", lambda words: words.integer("atom_type", 1)),
    "density": _density,
    "nspheres": _set("count", lambda words: words.integer("nspheres", 2)),
    "ntry": lambda words, _: _ignore(words, "ntry"),
    "spheres": _spheres,
    "type": lambda words, _: _ignore(words, "type"),
    "mass": _set("mass", lambda words: words.positive("mass")),
    "inertia_tensor": _tensor,
    "use_density": lambda _, given: setattr(given, "use", "use_density"),
    "use_volume": lambda _, given: setattr(given, "use", "use_volume"),
}


def _ignore(words: Words, name: str) -> None:
    words.integer(name, 1)


def distribution(setup: Setup, spec: Spec) -> Kind:
    """fix particledistribution/discrete SEED 1 TEMPLATE 1.0: of one template."""
    words = words_of(spec)
    words.integer("seed", 1)
    if (count := words.integer("number of templates", 1)) > 1:
        raise words.error(f"of {count} templates draws at random: supported is one")
    name = words.take("a template")
    words.positive("share")
    words.end()
    found = setup.fixes.get(name)
    if found is None or found.style != TEMPLATE:
        raise words.error(f"{name!r} is not a fix {TEMPLATE}")
    return template(setup, found)


@dataclass
class _Pack:
    kind: Kind | None = None
    v: Floats | None = None
    omega: Floats | None = None
    quat: Floats | None = None
    region: str = ""
    count: int = 0
    random: bool = False


def pack(setup: Setup, spec: Spec) -> tuple[Kind, Floats, Floats, Floats, Floats]:
    """fix insert/pack: what is placed, where (3,), quaternion (4,), v and omega (3,). Raises InputError for what would be drawn at random."""
    words, given = words_of(spec), _Pack(v=np.zeros(3), omega=np.zeros(3), quat=np.array([1.0, 0.0, 0.0, 0.0]))
    while words:
        _PACK_WORDS[words.choice("keyword", _PACK_WORDS)](setup, words, given)
    if given.kind is None or not given.region or given.count != 1 or given.random:
        raise words.error(
            "needs distributiontemplate, region, particles_in_region 1, and orientation constant or template: LIGGGHTS draws the rest at random"
        )
    region = setup.regions.get(given.region)
    if region is None or region.lo is None or region.hi is None:
        raise words.error(f"region {given.region!r} is not a region with bounds; defined: {', '.join(setup.regions) or 'none'}")
    size = float((region.hi - region.lo).max())
    if size > SMALL * float(given.kind.radius.min()):
        drawn = f"region {given.region} is {size:g} wide, and LIGGGHTS draws the place in it at random"
        raise words.error(f"{drawn}: a place is given by one no wider than {SMALL:g} of a radius")
    assert given.v is not None and given.omega is not None and given.quat is not None  # noqa: PT018
    return given.kind, 0.5 * (region.lo + region.hi), given.quat, given.v, given.omega


def _template_of(setup: Setup, words: Words, given: _Pack) -> None:
    name = words.take("a distribution")
    found = setup.fixes.get(name)
    if found is None or found.style != DISTRIBUTION:
        raise words.error(f"{name!r} is not a fix {DISTRIBUTION}")
    given.kind = distribution(setup, found)


def _constant(name: str) -> Callable[[Setup, Words, _Pack], None]:
    def read(_: Setup, words: Words, given: _Pack) -> None:
        words.choice(name, ("constant",))
        setattr(given, "v" if name == "vel" else "omega", np.array([words.number(f"{name} {axis}") for axis in "xyz"]))

    return read


def _orientation(_: Setup, words: Words, given: _Pack) -> None:
    how = words.choice("orientation", ("constant", "template", "random"))
    given.random = how == "random"
    if how == "constant":
        quat = np.array([words.number("quaternion") for _ in range(4)])
        if abs(float(quat @ quat) - 1.0) > UNIT:
            raise words.error(f"orientation constant: the quaternion w x y z must have length 1, got {sqrt(float(quat @ quat)):.12g}")
        given.quat = quat


def _once(_: Setup, words: Words, __: _Pack) -> None:
    words.choice("insert_every", ("once",))


def _skip(name: str, known: tuple[str, ...] = ()) -> Callable[[Setup, Words, _Pack], None]:
    def skip(_: Setup, words: Words, __: _Pack) -> None:
        words.choice(name, known) if known else words.integer(name, 1)

    return skip


def _count(_: Setup, words: Words, given: _Pack) -> None:
    given.count = words.integer("particles_in_region", 1)


def _region(_: Setup, words: Words, given: _Pack) -> None:
    given.region = words.take("a region")


_PACK_WORDS: dict[str, Callable[[Setup, Words, _Pack], None]] = {
    "seed": _skip("seed"),
    "distributiontemplate": _template_of,
    "insert_every": _once,
    "overlapcheck": _skip("overlapcheck", ("yes", "no")),
    "all_in": _skip("all_in", ("yes", "no")),
    "vel": _constant("vel"),
    "omega": _constant("omega"),
    "orientation": _orientation,
    "region": _region,
    "particles_in_region": _count,
    "ntry_mc": _skip("ntry_mc"),
}

CHECKS: dict[str, Callable[[Setup, Spec], object]] = {TEMPLATE: template, DISTRIBUTION: distribution, INSERT: pack}


def due(setup: Setup) -> list[Spec]:
    """The insertions that the next run makes, once each."""
    return [spec for spec in setup.fixes.values() if spec.style == INSERT and spec.id not in setup.inserted]


def insert(setup: Setup) -> None:
    """Places what is due. Raises InputError where a force would act within the step of insertion."""
    for spec in due(setup):
        kind, x, quat, v, omega = pack(setup, spec)
        for fix in setup.fixes.values():
            if fix.style == "gravity":
                v = v + 0.5 * setup.dt * np.array(gravity(setup, fix).acceleration)
            elif fix.style in FORCES:
                message = f"fix {spec.id} {INSERT}: fix {fix.id} {fix.style} acts within the step of insertion: define it behind a run 1"
                raise InputError(message, spec.place)
        place(setup, kind, x, quat, v, omega, 1 | 1 << group_bit(setup, spec))
        setup.inserted.add(spec.id)

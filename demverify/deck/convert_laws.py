"""Contact laws from one dialect to the other: from the ContactLaw both mean to the words that say it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import exp, pi, sqrt
from typing import NamedTuple

import numpy as np

from demsolver.scene import ContactLaw, Cylinder, Particles, Plane, Slab, Wall
from demverify.errors import InputError, Place

FRICTION = {"none": "off", "no_history": "no_history", "classic_history": "history", "rotated_history": "history", "liggghts_history": "history"}
PLAIN = {("hooke", "mass_velocity"): "hooke/stiffness", ("hooke", "velocity"): "hooke/stiffness", ("hertz", "viscoelastic"): "hertz/stiffness"}


class Table(NamedTuple):
    """A LIGGGHTS property per pair of types."""

    name: str
    values: np.ndarray


def absolute(law: ContactLaw, particles: Particles, *, wall: bool) -> ContactLaw:
    """A linear spring whose dashpot follows from restitution and mass, as the plain dashpot it is where all spheres of a type are of one
    size; any other law as it is."""
    if (law.normal, law.damping) != ("hooke", "fraction"):
        return law
    kn, fraction = law.coefficients["kn"], law.coefficients["damping_fraction"]
    gamman = np.zeros_like(kn)
    for index in np.ndindex(kn.shape):
        types = tuple(k + 1 for k in index)
        sizes = _sizes(particles, types, wall=wall)
        if sizes is None:
            return law
        gamman[index] = fraction[index] * np.sqrt(sizes[1] * kn[index])
    kept = {name: table for name, table in law.coefficients.items() if name != "damping_fraction"}
    return replace(law, damping="velocity", coefficients={**kept, "gamman": gamman})


def is_material(law: ContactLaw) -> bool:
    """Whether LIGGGHTS says this law as `model hertz`, with Young's modulus, Poisson's ratio and restitution."""
    return (law.normal, law.damping) == ("hertz", "fraction")


def material_tables(law: ContactLaw, place: Place | None) -> list[Table]:
    """youngsModulus and poissonsRatio per type, coefficientRestitution and coefficientFriction per pair, of a hertz law.

    From the like pairs: G*/E* = (1 - nu)/(2 (2 - nu)), E = 2 (1 - nu^2) E*. Raises InputError where unlike pairs are not of these
    materials, or the tangential damping is not LIGGGHTS'.
    """
    young_star, tangential = law.coefficients["kn"] * 0.75, law.friction != "none" and "shear_stiffness" in law.coefficients
    shear_star = law.coefficients["shear_stiffness"] / 8.0 if tangential else young_star * 7.0 / 34.0  # nu = 0.3 where it does not matter
    ratio = np.diag(shear_star) / np.diag(young_star)
    nu = (1.0 - 4.0 * ratio) / (1.0 - 2.0 * ratio)
    young = 2.0 * (1.0 - nu**2) * np.diag(young_star)
    soft, sheared = (1.0 - nu**2) / young, 2.0 * (2.0 - nu) * (1.0 + nu) / young
    expected = 1.0 / np.add.outer(soft, soft), 1.0 / np.add.outer(sheared, sheared)
    consistent = all(np.allclose(a, b, rtol=1e-9) for a, b in zip((young_star, shear_star), expected, strict=True))
    if (nu < 0.0).any() or (nu > 0.5).any() or not consistent:
        message = (
            "stiffnesses that no Young's moduli and Poisson's ratios give, which is all that LIGGGHTS' model hertz takes; "
            "write the LIGGGHTS deck by hand"
        )
        raise InputError(message, place)
    b = law.coefficients["damping_fraction"] / sqrt(5.0)
    restitution = np.exp(-pi * b / np.sqrt(1.0 - b * b))
    tables = [Table("youngsModulus", young), Table("poissonsRatio", nu), Table("coefficientRestitution", restitution)]
    return tables + ([Table("coefficientFriction", law.coefficients["mu"])] if law.friction != "none" else [])


def _tangential_switch(law: ContactLaw, place: Place | None) -> list[str]:
    """LIGGGHTS' hertz damps tangentially by sqrt(4 G*/E*) times the normal dashpot, or not at all."""
    if law.friction == "none" or law.tangential_damping == "fraction":
        return []
    xt = law.coefficients["xt"] if law.tangential_damping == "scaled" else 0.0 * law.coefficients["kn"]
    if not xt.any() or not law.coefficients["damping_fraction"].any():
        return ["tangential_damping off"]
    own = np.sqrt(law.coefficients["shear_stiffness"] / (1.5 * law.coefficients["kn"])) if "shear_stiffness" in law.coefficients else np.inf
    if np.allclose(xt, own, rtol=1e-9):
        return []
    wanted, there = float(xt.flat[0]), float(np.ravel(own)[0])
    message = f"tangential damping xt = {wanted:g}: LIGGGHTS' model hertz has {there:g} or none; write the LIGGGHTS deck by hand"
    raise InputError(message, place)


def material_wall_types(pair: ContactLaw, walls: list[ContactLaw], place: Place | None) -> list[int]:
    """The type of each wall: that whose column in the pair's tables is the wall's law. Raises InputError where there is none."""
    types = []
    for wall in walls:
        columns = range(len(pair.coefficients["kn"]))
        shared = set(pair.coefficients) & set(wall.coefficients)
        same = [k for k in columns if all(np.allclose(pair.coefficients[c][:, k], wall.coefficients[c], rtol=1e-9) for c in shared)]
        if not same or not is_material(wall):
            message = "a wall of another material than the particles; write the LIGGGHTS deck by hand"
            raise InputError(message, place)
        types.append(same[0] + 1)
    return types


def _check_shared(law: ContactLaw, other: str, place: Place | None) -> None:
    """Raises InputError for a part of the law that the other engine does not have."""
    alone = [f"{family} {name}" for family in ("cohesion", "rolling", "twisting") if (name := getattr(law, family)) != "none"]
    alone += [f"friction {law.friction}"] * (law.friction not in FRICTION)
    if alone:
        message = f"{other} has no law like {' and '.join(alone)}; write the {other} deck by hand"
        raise InputError(message, place)


def liggghts_style(law: ContactLaw, place: Place | None) -> str:
    """`model ... tangential ... switches` of a LAMMPS law. Raises InputError for a law LIGGGHTS does not have."""
    _check_shared(law, "LIGGGHTS", place)
    if is_material(law):
        switches = [*_tangential_switch(law, place), *(["limitForce on"] * law.limit_damping)]
        return " ".join(["model hertz tangential", FRICTION[law.friction], *switches])
    model = PLAIN.get((law.normal, law.damping))
    if model is None:
        message = (
            f"LIGGGHTS has no law like normal {law.normal} with damping {law.damping}: its stiffness models damp with the mass (mass_velocity), "
            "absolutely (velocity) or viscoelastically; write the LIGGGHTS deck by hand"
        )
        raise InputError(message, place)
    switches = ["absolute_damping on"] * (law.damping == "velocity") + ["limitForce on"] * law.limit_damping
    return " ".join(["model", model, "tangential", FRICTION[law.friction], *switches])


def liggghts_tables(law: ContactLaw) -> list[Table]:
    """The properties that `liggghts_style` needs, on the shape of the law's own coefficients: (t, t) or (t,)."""
    c, suffix = law.coefficients, "_abs" if law.damping == "velocity" else ""
    zero = 0.0 * c["kn"]
    tangential = {"mass": "gammat", "mass_radius": "gammat", "absolute": "gammat"}.get(law.tangential_damping)
    gammat = c[tangential] if tangential else c["xt"] * c["gamman"] if law.tangential_damping == "scaled" else zero
    tables = [
        Table("kn", c["kn"]),
        Table("kt", c.get("shear_stiffness", 2.0 / 7.0 * c["kn"])),
        Table(f"gamman{suffix}", c["gamman"]),
        Table(f"gammat{suffix}", gammat),
    ]
    return tables + [Table("coefficientFriction", c.get("mu", zero))] * (law.friction != "none")


def with_wall_types(pair: list[Table], walls: list[list[Table]], ntypes: int, place: Place | None) -> tuple[list[Table], list[int]]:
    """Pair tables widened by one type for each wall that differs from every column of the pair's, and the type of each wall.

    In LIGGGHTS a wall is a type, and its law that of the pair (particle type, wall type).
    """
    values = {table.name: table.values for table in pair}
    types: list[int] = []
    for wall in walls:
        if {t.name for t in wall} - values.keys():
            values |= {t.name: np.zeros((len(next(iter(values.values()), np.zeros(ntypes))),) * 2) for t in wall if t.name not in values}
        width = len(next(iter(values.values())))
        same = [k for k in range(width) if all(np.array_equal(values[t.name][:ntypes, k], t.values) for t in wall)]
        if not same:
            values = {name: _widened(v, next((t.values for t in wall if t.name == name), None)) for name, v in values.items()}
        types.append(same[0] + 1 if same else width + 1)
    return [Table(name, v) for name, v in values.items()], types


def _widened(table: np.ndarray, column: np.ndarray | None) -> np.ndarray:
    wide = np.pad(table, (0, 1), mode="edge")
    if column is not None:
        wide[: len(column), -1] = wide[-1, : len(column)] = column
    return wide


def property_lines(tables: list[Table]) -> Iterator[str]:
    """`fix ... property/global` lines."""
    for table in tables:
        numbers = " ".join(f"{value:.17g}" for value in table.values.ravel())
        kind = "peratomtype" if table.values.ndim == 1 else f"peratomtypepair {len(table.values)}"
        yield f"fix property_{table.name} all property/global {table.name} {kind} {numbers}"


def _upright(wall: Wall, place: Place | None) -> Slab | Cylinder:
    """The shape of a wall in the words both engines have. Raises InputError for one that stands across no axis, moves, or has one side."""
    shape = wall.shape
    if isinstance(shape, Cylinder) and shape.side != "both":
        message = f"wall {wall.name}: a cylinder that is felt from one side is not converted; write that wall by hand"
        raise InputError(message, place)
    if not isinstance(shape, Plane):
        return shape
    across = [axis for axis, part in enumerate(shape.normal) if part != 0.0]
    if shape.moving or shape.one_sided or len(across) != 1:
        which = "moves" if shape.moving else "is felt from one side" if shape.one_sided else "stands across no axis"
        message = f"wall {wall.name}: a plane that {which} is not converted; write that wall by hand"
        raise InputError(message, place)
    return Slab(across[0], lo=-shape.offset / shape.normal[across[0]])


def liggghts_walls(wall: Wall, style: str, kind: int, place: Place | None) -> Iterator[str]:
    """One `fix wall/gran` a plane. Raises InputError for a plane that LIGGGHTS cannot say."""
    shape = _upright(wall, place)
    axis = "xyz"[shape.axis]
    if isinstance(shape, Cylinder):
        model, switches = _before_switches(style)
        yield f"{model} primitive type {kind} {axis}cylinder {shape.radius:.17g} 0 0 {switches}".rstrip()
        return
    for height in (shape.lo, shape.hi):
        if np.isfinite(height):
            model, switches = _before_switches(style)
            yield f"{model} primitive type {kind} {axis}plane {height:.17g} {switches}".rstrip()


def _before_switches(style: str) -> tuple[str, str]:
    """`model M tangential T` and what follows: a wall's shape stands between them."""
    words = style.split()
    return " ".join(words[:4]), " ".join(words[4:])


def lammps_pair_coeffs(law: ContactLaw, particles: Particles, ntypes: int, place: Place | None) -> Iterator[str]:
    """`pair_coeff i j ...` lines of `pair_style granular` for a LIGGGHTS law. Raises InputError for a law LAMMPS does not have."""
    for i in range(ntypes):
        for j in range(i, ntypes):
            one = {name: float(table[i, j]) for name, table in law.coefficients.items()}
            yield f"pair_coeff {i + 1} {j + 1} {lammps_law(law, one, _sizes(particles, (i + 1, j + 1)), place)}"


def lammps_wall(wall: Wall, particles: Particles, place: Place | None) -> str:
    """`granular ... SHAPE` of a LIGGGHTS wall, whose law must be one for all types that meet it."""
    first = {name: float(column[0]) for name, column in wall.law.coefficients.items()}
    if any(len(set(column.tolist())) > 1 for column in wall.law.coefficients.values()):
        message = f"wall {wall.name} has another law for each particle type, which LAMMPS' wall/gran cannot say; write the LAMMPS deck by hand"
        raise InputError(message, place)
    words = lammps_law(wall.law, first, _sizes(particles, ()), place)
    shape = _upright(wall, place)
    axis = "xyz"[shape.axis]
    if isinstance(shape, Slab):
        return f"granular {words} {axis}plane {shape.lo:.17g} NULL"
    if shape.axis != 2 or shape.center != (0.0, 0.0):
        message = f"wall {wall.name}: LAMMPS' wall/gran has cylinders about the z axis only"
        raise InputError(message, place)
    return f"granular {words} zcylinder {shape.radius:.17g}"


def lammps_law(law: ContactLaw, c: dict[str, float], sizes: tuple[float, float] | None, place: Place | None) -> str:
    """`NORMAL numbers tangential ... damping ...` of pair granular. sizes: (reff, meff) where all contacts share them."""
    _check_shared(law, "LAMMPS", place)
    form = NORMALS.get((law.normal, law.damping))
    if form is None:
        message = f"LAMMPS has no law like LIGGGHTS' {law.normal} with damping {law.damping}; write the LAMMPS deck by hand"
        raise InputError(message, place)
    normal, kt, xt = form(law, c, sizes, place)
    xt = 0.0 if law.tangential_damping == "none" else xt
    kind = {"off": "linear_nohistory", "no_history": "linear_nohistory"}.get(
        FRICTION[law.friction], "mindlin" if law.tangential_stiffness == "mindlin" else "linear_history"
    )
    numbers = [xt, c.get("mu", 0.0)] if kind == "linear_nohistory" else [kt, xt, c["mu"]]
    limit = " limit_damping" if law.limit_damping else ""
    return f"{normal[0]} tangential {kind} {' '.join(f'{n:.17g}' for n in numbers)} damping {normal[1]}{limit}"


Form = tuple[tuple[str, str], float, float]


def _springs(name: str, damping: str) -> Callable[..., Form]:
    def form(law: ContactLaw, c: dict[str, float], sizes: object, place: Place | None) -> Form:
        if c["gamman"] == 0.0 and c.get("gammat", 0.0) > 0.0 and law.tangential_damping != "none":
            message = "tangential damping without normal damping: LAMMPS' granular scales the one by the other"
            raise InputError(message, place)
        xt = c["gammat"] / c["gamman"] if c["gamman"] else 0.0
        return (f"{name} {c['kn']:.17g} {c['gamman']:.17g}", damping), c.get("shear_stiffness", 0.0), xt

    return form


def _material(law: ContactLaw, c: dict[str, float], sizes: object, place: Place | None) -> Form:
    b = c["damping_fraction"] / sqrt(5.0)
    restitution = exp(-pi * b / sqrt(1.0 - b * b))
    xt = sqrt(c["shear_stiffness"] / (1.5 * c["kn"])) if "shear_stiffness" in c else 0.0
    return (f"hertz {c['kn']:.17g} {restitution:.17g}", "coeff_restitution"), c.get("shear_stiffness", 0.0), xt


def _impact(law: ContactLaw, c: dict[str, float], sizes: tuple[float, float] | None, place: Place | None) -> Form:
    """LIGGGHTS' hooke is a spring of its own for every pair of sizes; with one size it is one spring and one dashpot."""
    if sizes is None:
        message = "LIGGGHTS' model hooke has another stiffness for each pair of sizes, which LAMMPS has not; write the LAMMPS deck by hand"
        raise InputError(message, place)
    from demsolver.contact.normal_impact_hooke import force

    reff, meff = sizes
    kn = force(1.0, reff, meff, c["yeff"], c["characteristic_velocity"])
    gn = c["damping_fraction"] * sqrt(meff * kn)
    return (f"hooke {kn:.17g} {gn:.17g}", "velocity"), c["stiffness_ratio"] * kn, c["xt"]


NORMALS: dict[tuple[str, str], Callable[..., Form]] = {
    ("hooke", "mass_velocity"): _springs("hooke", "mass_velocity"),
    ("hooke", "velocity"): _springs("hooke", "velocity"),
    ("hertz", "viscoelastic"): _springs("hertz", "viscoelastic"),
    ("hertz", "fraction"): _material,
    ("impact_hooke", "fraction"): _impact,
}


def _sizes(p: Particles, types: tuple[int, ...], *, wall: bool = False) -> tuple[float, float] | None:
    """(reff, meff) if every contact of these two types has the same, or with a wall that of this type (none given: of any); else None."""
    chosen = [p.type == t for t in types] or [np.ones(len(p.id), dtype=bool)]
    radii, masses = ([np.unique(values[mask]) for mask in chosen] for values in (p.radius, p.mass))
    if any(len(values) > 1 for values in [*radii, *masses]):
        return None
    if any(len(values) == 0 for values in radii):
        return 1.0, 1.0  # no such particle: the numbers are never used
    if wall or not types:
        return float(radii[0][0]), float(masses[0][0])
    (r1,), (r2,), (m1,), (m2,) = (v.tolist() for v in (*radii, *masses))
    return r1 * r2 / (r1 + r2), m1 * m2 / (m1 + m2)

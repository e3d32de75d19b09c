"""From the state of a deck to the frozen scene of the solver."""

from __future__ import annotations

from copy import deepcopy
from importlib import import_module
from typing import Any

import numpy as np

from demsolver.bind_law import longest_reach
from demsolver.check_bodies import check_bodies
from demsolver.scene import EulerSphere, Integrator, Neighbor, NveSphere, NveSuperquadric, Particles, Scene
from demsolver.state import selected
from demverify.deck.forces import FORCES, INTEGRATORS
from demverify.deck.rigid import rigid_bodies
from demverify.deck.setup import Atoms, NeighborSpec, Setup, Spec
from demverify.errors import InputError, Place

_SKIN = {"lj": 0.3, "si": 0.001, "cgs": 0.1, "micro": 0.1}
LOST = {"lammps": "error", "liggghts": "ignore"}  # thermo_modify lost; measured
_DELAY = {"lammps": 0, "liggghts": 10}


def scene_of(setup: Setup) -> Scene:
    """The scene that a run starts from.

    Raises InputError when there is no box, a particle without mass or two at one place, and for a wrong contact law."""
    if setup.box is None or setup.atoms is None:
        raise InputError("the deck made no simulation box: create_box or read_data is missing")
    check_particles(setup.atoms)
    if setup.dialect == "lammps":
        setup.atoms.clumps = rigid_bodies(setup, setup.atoms)
    law: Any = import_module(f"demverify.deck.materials_{setup.dialect}")
    fixes = setup.fixes.values()
    scene = Scene(
        box=setup.box,
        particles=_particles(setup.atoms),
        ntypes=setup.ntypes,
        timestep=setup.dt,
        pair=law.pair_law(setup),
        walls=law.walls(setup),
        forces=tuple(FORCES[spec.style](setup, spec) for spec in fixes if spec.style in FORCES),
        integrate=_integrators(setup),
        neighbor=_neighbor(setup, setup.neighbor),
        dimension=setup.dimension,
        lost=setup.thermo.modify.get("lost", LOST[setup.dialect]),  # type: ignore[arg-type]
        history_outlives_contact=setup.dialect == "liggghts" and setup.neighbor.contact_distance_factor == 1.0 and setup.atom_style != "superquadric",
        contact_point=law.contact_point(setup) if setup.dialect == "liggghts" else "potential",
    )
    try:
        check_bodies(scene)
    except ValueError as error:
        raise InputError(str(error)) from None
    _check_reach(scene)
    return scene


def _check_reach(scene: Scene) -> None:
    """The solver sees the nearest image of a neighbour only."""
    largest = float(scene.particles.radius.max(initial=0.0))
    reach = 2.0 * largest + scene.neighbor.skin + (longest_reach(scene.pair, 0.5 * largest) if scene.pair else 0.0)
    for axis, length in enumerate(scene.box.hi - scene.box.lo):
        if scene.pair and scene.box.periodic[axis] and length < reach:
            message = f"the periodic box is {length:g} long in {'xyz'[axis]}, shorter than the reach of a contact, skin included, {reach:g}"
            raise InputError(message)


def _integrators(setup: Setup) -> tuple[Integrator, ...]:
    specs = [spec for spec in setup.fixes.values() if spec.style in INTEGRATORS]
    euler = [spec for spec in specs if spec.style == "euler/sphere"]
    if euler and (other := next((spec for spec in specs if spec.style != "euler/sphere"), None)):
        first, second = (spec for spec in specs if spec in (euler[0], other))
        message = f"fix {second.id} {second.style}: fix {first.id} is a {first.style}, and one run has one integrator"
        raise InputError(message, second.place)
    found = tuple(_integrate(setup, spec) for spec in specs)
    turning = [(one.scheme, spec) for one, spec in zip(found, specs, strict=True) if isinstance(one, NveSuperquadric)]
    for scheme, spec in turning:
        if scheme != turning[0][0]:
            message = f"fix {spec.id} {spec.style}: fix {turning[0][1].id} has another integration_scheme, and one run has one"
            raise InputError(message, spec.place)
    return found


def _integrate(setup: Setup, spec: Spec) -> Integrator:
    found, atoms = INTEGRATORS[spec.style](setup, spec), setup.atoms
    assert atoms is not None
    points = selected(atoms.mask, found.bit) & (atoms.radius == 0.0)
    if isinstance(found, NveSphere | EulerSphere) and points.any():
        message = f"fix {spec.id} {spec.style}: particle {atoms.id[points][0]} has radius 0; a point cannot turn"
        raise InputError(message, spec.place)
    return found


def _particles(atoms: Atoms) -> Particles:
    names = ("id", "type", "x", "v", "omega", "radius", "mass", "mask", "image")
    shapes = deepcopy(atoms.superquadrics), deepcopy(atoms.clumps)
    return Particles(**{name: getattr(atoms, name).copy() for name in names}, superquadrics=shapes[0], clumps=shapes[1])


def _neighbor(setup: Setup, spec: NeighborSpec) -> Neighbor:
    bits, types = [], []
    for what, a, b in spec.exclude:
        if what == "group":
            bits.append((setup.groups[a], setup.groups[b]))
        else:
            types.append((int(a), int(b)))
    skin = spec.skin if spec.skin is not None else _SKIN[setup.units]
    delay = spec.delay if spec.delay is not None else _DELAY[setup.dialect]
    return Neighbor(skin, spec.every, delay, spec.check, tuple(bits), tuple(types))


def check_particles(atoms: Atoms, place: Place | None = None) -> None:
    """Raises InputError naming a particle that is not finite, has no mass, or shares its place with another."""
    for name in ("x", "v", "omega", "radius"):
        bad = ~np.isfinite(getattr(atoms, name))
        if bad.any():
            row = int(np.argwhere(bad)[0, 0])
            raise InputError(f"particle {atoms.id[row]}: {name} is not a finite number", place)
    massless = ~(np.isfinite(atoms.mass) & (atoms.mass > 0.0))
    if massless.any():
        row = int(np.argmax(massless))
        raise InputError(f"particle {atoms.id[row]} has no mass: give it a density or a mass with `set`", place)
    _check_apart(atoms, place)


def _check_apart(atoms: Atoms, place: Place | None) -> None:
    order = np.lexsort(atoms.x.T)
    x = atoms.x[order]
    same = np.flatnonzero((x[1:] == x[:-1]).all(axis=1))
    if len(same):
        first, second = sorted(atoms.id[order[same[0] : same[0] + 2]].tolist())
        raise InputError(f"particles {first} and {second} are at one place, {x[same[0]].tolist()}", place)

"""From dumps to what a page draws: of every particle its shape, place and orientation, and the energies `demverify erotate` gives it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from demsolver.computes.erotate import BODIES, LAST
from demsolver.computes.population import Energies, Population, RigidBodies
from demverify.analysis.energies import FrameEnergies, energy_factor
from demverify.analysis.erotate import Request, measured_in, reading_of, split
from demverify.analysis.needed import POSITIONS
from demverify.analysis.quantities import population_of, vector
from demverify.analysis.series import Rows
from demverify.errors import InputError, Place
from demverify.formats.dump import blocks_of, read_block
from demverify.frames import Floats, Frame

Ints = NDArray[np.int64]

KINDS = (LAST, "superquadric", BODIES)
"""What a particle is, by its number in `Particles.kind`."""
MOST_BYTES = 28_000_000
"""Of a page, without its program."""
_FARTHEST = 1e18  # of a place and a size: the page has float32, and squares them
_NAMED = 3  # particles or steps a note names


@dataclass(frozen=True)
class Particles:
    """What n particles keep from frame to frame.

    id: (n,). kind: (n,) place in KINDS. body: (n,) the clump a sphere is a member of, 0: none. size: (n, 5) semi-axes a b c and
    exponents n1 n2 of (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1.
    """

    id: Ints
    kind: Ints
    body: Ints
    size: Floats

    def equals(self, other: Particles) -> bool:
        """Whether they are the same in every number."""
        return all(np.array_equal(mine, theirs) for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True))


@dataclass(frozen=True)
class Scene:
    """One frame. corner: (3,), edges: (3, 3) rows, of the box; None: not known. x: (n, 3). quat: (n, 4) w x y z, None: all are spheres.

    erotate, ke: (n,) of the particle, or of the clump it is a member of; NaN: not known, or not a number.
    """

    step: int
    time: float | None
    corner: Floats | None
    edges: Floats | None
    particles: Particles
    x: Floats
    quat: Floats | None
    erotate: Floats
    ke: Floats

    @cached_property
    def nbytes(self) -> int:
        """In the page: four letters for three bytes of float32, and the words about the frame."""
        return len(self.x) * (9 if self.quat is not None else 5) * 16 // 3 + 400


@dataclass(frozen=True)
class Viewed:
    """Scenes in the order of their steps; what is to be told, a sentence each; whether all energies are finite."""

    scenes: list[Scene]
    notes: list[str]
    sound: bool


@dataclass(frozen=True)
class _BodyEnergies:
    """id, erotate, ke: (m,), by id."""

    id: Ints
    erotate: Floats
    ke: Floats

    def of(self, body: Ints) -> tuple[Floats, Floats]:
        """Energies of the bodies with these numbers; NaN for one that is not there."""
        at = np.minimum(np.searchsorted(self.id, body), max(0, len(self.id) - 1))
        if not len(self.id):
            return np.full(len(body), np.nan), np.full(len(body), np.nan)
        there = self.id[at] == body
        return np.where(there, self.erotate[at], np.nan), np.where(there, self.ke[at], np.nan)


class _Kept:
    """The scenes that are kept, of those that come: every `stride`-th; the stride doubles where they become too many."""

    def __init__(self, every: int, most: int | None) -> None:
        self.stride, self._most = every, most
        self.rows, self._scenes = Rows(), dict[int, Scene]()
        self.came, self._bytes = 0, 0

    def wants_next(self) -> bool:
        """Asked once for each frame that comes."""
        self.came += 1
        return (self.came - 1) % self.stride == 0

    def add(self, scene: Scene, found: FrameEnergies, source: str) -> None:
        """Keeps a scene. Raises InputError as `Rows.add` does."""
        before = next(reversed(self._scenes.values()), None)
        if before and before.particles.equals(scene.particles):
            scene = replace(scene, particles=before.particles)
        self.rows.add(found.row, source)
        self._scenes.pop(scene.step, None)
        self._scenes[scene.step] = scene
        self._bytes += page_bytes([scene]) if before is None or scene.particles is not before.particles else scene.nbytes
        while self._bytes > MOST_BYTES or (self._most and len(self.rows.rows) > self._most):
            scenes = self.scenes()  # without those that a restart replaced
            self._bytes = page_bytes(scenes)
            if len(scenes) > 1 and (self._bytes > MOST_BYTES or len(scenes) > (self._most or len(scenes))):
                self.stride *= 2
                self.rows.rows = self.rows.rows[::2]
                scenes = self.scenes()
                self._bytes = page_bytes(scenes)
            self._scenes = {scene.step: scene for scene in scenes}
            if len(scenes) == 1:
                break

    def scenes(self) -> list[Scene]:
        """In the order of their steps."""
        return [self._scenes[row.step] for row, _ in self.rows.rows]


def page_bytes(scenes: Sequence[Scene]) -> int:
    """What the numbers of scenes take up in a page; particles that stay the same count once."""
    once = {id(scene.particles): len(scene.x) for scene in scenes}
    return sum(scene.nbytes for scene in scenes) + sum(n * 37 * 4 // 3 for n in once.values())


def viewed(
    files: Sequence[Path],
    request: Request,
    bodies: Sequence[Path] = (),
    body_columns: tuple[str, ...] | None = None,
    every: int = 1,
    most: int | None = None,
) -> Viewed:
    """The scenes in dumps. bodies: dumps of the clumps whose members are in `files`, which then give the energies of these.

    every: one of so many frames. most: frames at most; there are fewer where a page of all would be beyond MOST_BYTES.
    Raises InputError where files cannot be read, where the columns do not tell what is needed, and where nothing is to be seen.
    """
    notes: list[str] = []
    of_bodies: dict[int, _BodyEnergies] | None = None
    if bodies:
        request, request_of_bodies = split(request, body_columns)
        of_bodies = _energies_of_bodies(bodies, request_of_bodies, notes)
    kept, alone = _Kept(every, most), list[int]()
    for path, frame, present in _frames(files, request, notes):
        if of_bodies is not None and frame.step not in of_bodies:
            alone.append(frame.step)
        elif kept.wants_next():
            population, found = measured_in(path, frame, request.wanted, present)
            notes += found.notes
            known = of_bodies[frame.step] if of_bodies is not None else _body_energies(population.bodies, found, frame, request)
            try:
                kept.add(_scene(frame, request, found, known, present, notes), found, str(path))
            except InputError as error:
                raise InputError(error.message, error.place or Place(path)) from None
    scenes = kept.scenes()
    _check_something_is_seen(scenes, alone)
    notes += [f"{len(alone)} steps with particles but no bodies are left out: {_listed(alone)}"] if alone else []
    if kept.stride > every:
        notes.append(f"{len(scenes)} of {kept.came} frames are in the page, one of every {kept.stride} (--most-frames, or a page of 30 MB)")
    sound = all(np.isfinite(row.erotate) and np.isfinite(row.ke or 0.0) for row, _ in kept.rows.rows)
    return Viewed(scenes, list(kept.rows.series(notes).notes), sound)


def _frames(files: Sequence[Path], request: Request, notes: list[str]) -> Iterator[tuple[Path, Frame, list[str]]]:
    """Frames of files, with the names of all columns there."""
    for block in blocks_of(files):
        reading = reading_of(block.path, request, notes, positions=True)
        for frame in read_block(block, reading):
            yield block.path, frame, reading.seen


def _energies_of_bodies(files: Sequence[Path], request: Request, notes: list[str]) -> dict[int, _BodyEnergies]:
    """By step; of a step that comes twice the last."""
    steps = {}
    for path, frame, present in _frames(files, request, notes):
        population, found = measured_in(path, frame, request.wanted, present)
        notes += found.notes
        steps[frame.step] = _body_energies(population.bodies, found, frame, request)
    return steps


def _body_energies(bodies: RigidBodies | None, found: FrameEnergies, frame: Frame, request: Request) -> _BodyEnergies:
    if bodies is None:
        return _BodyEnergies(np.empty(0, np.int64), np.empty(0), np.empty(0))
    order = np.argsort(bodies.id)
    ke = _ke(bodies.mass, bodies.v, len(order), energy_factor(frame, request.wanted.meanings))
    return _BodyEnergies(bodies.id[order], found.by_particle[BODIES].value[order], ke[order])


def _ke(mass: Floats | None, v: Floats | None, n: int, factor: float) -> Floats:
    """Translational energies, (n,); NaN where masses or velocities are not known."""
    if mass is None or v is None:
        return np.full(n, np.nan)
    return np.asarray(0.5 * factor * mass * np.einsum("ij,ij->i", v, v))


def _scene(frame: Frame, request: Request, found: FrameEnergies, bodies: _BodyEnergies, present: list[str], notes: list[str]) -> Scene:
    """A frame whose energies were found. What has no place or no extent is left out, and told in `notes`."""
    if frame.local:
        message = "this dump local lists bodies, not the spheres they are made of: give the dump of particles, and this one with --bodies"
        raise InputError(message)
    meanings = request.wanted.meanings
    population = population_of(frame, meanings)
    n = len(population.id)
    body = np.zeros(n, np.int64) if population.body is None else np.maximum(population.body, 0)
    solid = np.zeros(n, bool) if population.shape is None else np.asarray(population.shape.any(axis=1))
    x, size = _x(population, present), _size(population, solid, present)
    quat = _quat(frame, solid, present)
    erotate, ke = _of_particles(found, population.id), _ke(population.mass, population.v, n, energy_factor(frame, meanings))
    erotate[body > 0], ke[body > 0] = bodies.of(body[body > 0])
    kind = np.where(body > 0, KINDS.index(BODIES), np.where(solid, 1, 0))
    seen = (np.abs(x) < _FARTHEST).all(axis=1) & (np.abs(size) < _FARTHEST).all(axis=1) & (quat is None or np.isfinite(quat).all(axis=1))
    unseen = f"has no finite place or shape below {_FARTHEST:g}, and is not drawn"
    notes += [f"step {frame.step}: particle {i} {unseen}" for i in population.id[~seen][:_NAMED]]
    points = seen & ~size[:, :3].any(axis=1)
    notes += ["particles without a radius are points, and are not drawn"] if points.any() else []
    rows = np.flatnonzero(seen & ~points)
    known = bool(np.isfinite(frame.box).all() and np.isfinite(frame.edges).all())
    return Scene(
        frame.step, found.row.time,
        frame.box[:, 0] if known else None, frame.edges if known else None,
        Particles(population.id[rows], kind[rows], body[rows], size[rows]),
        _in_box(x[rows], body[rows], frame) if known else x[rows],
        None if quat is None else quat[rows],
        erotate[rows], ke[rows],
    )  # fmt: skip


def _x(population: Population, present: list[str]) -> Floats:
    if population.x is None:
        message = f"a view needs the columns x y z (or xu yu zu, xs ys zs); the dump has {' '.join(present)}"
        raise InputError(message)
    return population.x


def _size(population: Population, solid: NDArray[np.bool_], present: list[str]) -> Floats:
    """(n, 5) semi-axes and exponents."""
    n = len(solid)
    if population.radius is None and not solid.all():
        message = f"a view needs the column radius or diameter; the dump has {' '.join(present)}"
        raise InputError(message)
    radius = np.zeros(n) if population.radius is None else population.radius
    size = np.column_stack([np.repeat(radius[:, None], 3, axis=1), np.full((n, 2), 2.0)])
    if population.shape is not None:
        size[solid, :3] = population.shape[solid]
        if population.blockiness is not None:
            size[solid, 3:] = population.blockiness[solid]
    return size


def _quat(frame: Frame, solid: NDArray[np.bool_], present: list[str]) -> Floats | None:
    """(n, 4) of length 1; spheres 1 0 0 0. None: all are spheres."""
    if not solid.any():
        return None
    quat = vector(frame, ("quat1", "quat2", "quat3", "quat4"))
    if quat is None:
        message = f"a view of superquadrics needs the columns quat1 quat2 quat3 quat4; the dump has {' '.join(present)}"
        raise InputError(message)
    turned = quat / np.sqrt((quat**2).sum(axis=1))[:, None]
    return np.where(solid[:, None], turned, (1.0, 0.0, 0.0, 0.0))


def _of_particles(found: FrameEnergies, ids: Ints) -> Floats:
    """Rotational energy of each free particle, (n,), NaN of all others. ids: ascending."""
    values = np.full(len(ids), np.nan)
    for energies in (energies for shape, energies in found.by_particle.items() if shape != BODIES):
        values[_rows_of(energies, ids)] = energies.value
    return values


def _rows_of(energies: Energies, ids: Ints) -> Ints:
    return np.searchsorted(ids, energies.id)


def _in_box(x: Floats, body: Ints, frame: Frame) -> Floats:
    """Every particle, and every clump in one piece by its middle, at the image that is in the box."""
    periodic = np.array([faces == "pp" for faces in frame.boundary])
    if not periodic.any():
        return x
    turns = (x - frame.box[:, 0]) @ np.linalg.pinv(frame.edges)  # of a box without depth too
    _, first, whose = np.unique(np.where(body > 0, body, -1 - np.arange(len(body))), return_index=True, return_inverse=True)
    images = np.zeros_like(turns)
    if not next(names[0] for names in POSITIONS if names[0] in frame.columns).endswith("u"):
        images = np.round(turns - turns[first][whose])
    middle = np.zeros((len(first), 3))
    np.add.at(middle, whose, turns - images)
    images += np.floor(middle / np.bincount(whose, minlength=len(first))[:, None])[whose]
    return np.asarray(x - (images * periodic) @ frame.edges)


def _check_something_is_seen(scenes: Sequence[Scene], alone: Sequence[int]) -> None:
    if alone and not scenes:
        message = f"the dump of bodies has none of the steps of the particles (those start at {alone[0]})"
        raise InputError(message)
    if not any(len(scene.x) for scene in scenes):
        message = f"nothing to be seen: {'no particle has an extent' if scenes else 'there is no whole frame'}"
        raise InputError(message)


def _listed(steps: Sequence[int]) -> str:
    return " ".join(map(str, steps[:_NAMED])) + (" ..." if len(steps) > _NAMED else "")

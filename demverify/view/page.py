"""The page: scenes as numbers, the program that draws them, and nothing from elsewhere."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demverify.formats.atomic import atomic_write
from demverify.frames import Floats
from demverify.view.frames import KINDS, Particles, Scene


def write_page(path: Path, scenes: Sequence[Scene], title: str) -> None:
    """Writes the page, whole or not at all. scenes: at least one particle in all. Raises InputError where no file can come to be."""
    with atomic_write(path) as part:
        part.write_text(render(scenes, title), encoding="utf-8")


def render(scenes: Sequence[Scene], title: str) -> str:
    """The page as text."""
    template, style, *programs = (files("demverify.view").joinpath(name).read_text(encoding="utf-8") for name in _PARTS)
    numbers = json.dumps(numbers_of(scenes), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    return Template(template).substitute(title=escape(title), style=style, program="".join(programs), numbers=numbers)


_PARTS = ("view.html", "view.css", "draw.js", "view.js")


def numbers_of(scenes: Sequence[Scene]) -> dict[str, Any]:
    """What the program is given. Arrays are base64 of little-endian numbers.

    origin: what positions are relative to, so that float32 has digits enough. low, high: corners of what is to be in the picture at first.
    energies: the least above zero and the greatest. particles: one for each change of who is there: id and body float64, kind uint8,
    size float32 a b c n1 n2. frames: which particles, and float32 x y z of all, then w x y z of all (where turned), erotate, ke.
    """
    low, high = _extent(scenes)
    origin = 0.5 * (low + high)
    sets = list({id(scene.particles): scene.particles for scene in scenes}.values())
    place = {id(particles): i for i, particles in enumerate(sets)}
    values = np.concatenate([scene.erotate for scene in scenes])
    values = values[np.isfinite(values) & (values > 0.0)]
    return {
        "kinds": KINDS,
        "origin": origin.tolist(),
        "low": (low - origin).tolist(),
        "high": (high - origin).tolist(),
        "energies": [float(values.min()), float(values.max())] if len(values) else None,
        "particles": [_particles(particles) for particles in sets],
        "frames": [_frame(scene, place[id(scene.particles)], origin) for scene in scenes],
    }


def _particles(particles: Particles) -> dict[str, Any]:
    named = {"id": (particles.id, "<f8"), "body": (particles.body, "<f8"), "kind": (particles.kind, "<u1"), "size": (particles.size, "<f4")}
    return {"n": len(particles.id), **{name: _base64(values, kind) for name, (values, kind) in named.items()}}


def _frame(scene: Scene, particles: int, origin: Floats) -> dict[str, Any]:
    parts = [scene.x - origin, *([] if scene.quat is None else [scene.quat]), scene.erotate, scene.ke]
    box = None if scene.corner is None or scene.edges is None else [(scene.corner - origin).tolist(), *scene.edges.tolist()]
    return {
        "step": scene.step,
        "time": scene.time,
        "box": box,
        "particles": particles,
        "turned": scene.quat is not None,
        "numbers": _base64(np.concatenate([part.ravel() for part in parts]), "<f4"),
    }


def _base64(values: NDArray[Any], kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def _extent(scenes: Sequence[Scene]) -> tuple[Floats, Floats]:
    """Corners around all particles of all scenes, and around their boxes too unless these are far larger."""
    reach = [(scene.x, scene.particles.size[:, :3].max(axis=1, keepdims=True)) for scene in scenes if len(scene.x)]
    low = np.min([(x - radius).min(axis=0) for x, radius in reach], axis=0)
    high = np.max([(x + radius).max(axis=0) for x, radius in reach], axis=0)
    ends = [
        scene.corner + np.array(turns) @ scene.edges
        for scene in scenes if scene.corner is not None and scene.edges is not None
        for turns in np.ndindex(2, 2, 2)
    ]  # fmt: skip
    if ends:
        wide = np.minimum(low, np.min(ends, axis=0)), np.maximum(high, np.max(ends, axis=0))
        if np.linalg.norm(wide[1] - wide[0]) <= _FAR * np.linalg.norm(high - low):
            return wide
    return low, high


_FAR = 1.8  # times: a box that is wider would leave little of the picture to its particles

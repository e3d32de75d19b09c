"""The laws of motion know no place, direction, hand or uniform motion (Galilei; Landau & Lifshitz, Mechanics, par. 3): what happens to a
group of spheres happens to its copy, moved, turned, mirrored or in uniform motion:

    x'(t) = S x(t) + D + V t,   v' = S v + V,   w' = det(S) S w        S = mirror . rotation; spins are axial vectors

D and V follow from the first frame (centres of the two groups). Across periodic faces, images of x' count."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demverify.frames import Floats, Frame
from demverify.laws import Measured
from demverify.mechanics import positions, spins, times, velocities


def measure(
    frames: Sequence[Frame], dt: float, mirror: Literal["none", "x", "y", "z"], angle: float, x: float, y: float, z: float
) -> list[Measured]:
    """The second half of the particles against the first: largest difference over all frames. Positions relative to the largest radius,
    velocities and spins to their largest in the first copy. mirror: the axis that is reversed, after a turn by angle [degrees] about
    (x, y, z)."""
    turn = _turn(mirror, angle, np.array([x, y, z]))
    count = frames[0].n // 2
    radius = frames[0].columns["radius"]
    own, other = positions(frames[0]), velocities(frames[0])
    drift = (other[count:] - other[:count] @ turn.T).mean(axis=0)
    shift = own[count] - turn @ own[0]  # of one particle: others may be images
    largest = {"position": 0.0, "velocity": 0.0, "spin": 0.0}
    sizes = {"position": float(radius.max()), "velocity": 0.0, "spin": 0.0}
    for frame, t in zip(frames, times(frames, dt), strict=True):
        apart = _image(positions(frame)[count:] - positions(frame)[:count] @ turn.T - shift - drift * t, frame)
        speed, spin = velocities(frame), spins(frame)
        missed = {
            "position": apart,
            "velocity": speed[count:] - speed[:count] @ turn.T - drift,
            "spin": spin[count:] - np.linalg.det(turn) * spin[:count] @ turn.T,
        }
        for name, values in missed.items():
            largest[name] = max(largest[name], float(np.abs(values).max()))
        sizes["velocity"] = max(sizes["velocity"], float(np.abs(speed[:count]).max()))
        sizes["spin"] = max(sizes["spin"], float(np.abs(spin[:count]).max()))
    return [Measured(f"{name} of the copy", frames[-1].step, largest[name], 0.0, sizes[name]) for name in largest if sizes[name] > 0.0]


def _turn(mirror: str, angle: float, axis: Floats) -> Floats:
    """Rodrigues: R = 1 + sin(a) K + (1 - cos(a)) K^2, K = [axis] x, then the mirror."""
    n = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]])
    phi = np.radians(angle)
    rotation = np.eye(3) + np.sin(phi) * cross + (1.0 - np.cos(phi)) * cross @ cross
    reverse = np.diag([-1.0 if mirror == name else 1.0 for name in "xyz"])
    return np.asarray(reverse @ rotation)


def _image(apart: Floats, frame: Frame) -> Floats:
    """Whole edges of the box taken off along periodic axes."""
    edge = frame.box[:, 1] - frame.box[:, 0]
    periodic = np.array([faces == "pp" for faces in frame.boundary])
    return np.asarray(apart - np.where(periodic, np.round(apart / edge) * edge, 0.0))

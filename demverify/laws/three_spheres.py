"""A smooth sphere slides down between two like ones that lie on a floor side by side, and pushes them apart (S. Fujioka, S. Ushijima,
2006, docs/fujioka2006.md, (28) to (30); rigid spheres).

All start at rest, touching. With k = h/(2 r0), h the height of the upper one above the others, energy and the constraint give
V^2 = 4 g r0 (sqrt(3)/2 - k) k^2/(1 + k^2) for the lower ones' speed V; the upper one lets go at k^3 + 3 k = sqrt(3). From there V stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cbrt, sqrt

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], gravity: float) -> list[Measured]:
    """Last speeds of the two lower spheres (particles 1 and 2, along x), and that the upper one (3) falls straight."""
    first, last = frames[0], frames[-1]
    k = cbrt((sqrt(3.0) + sqrt(7.0)) / 2.0) + cbrt((sqrt(3.0) - sqrt(7.0)) / 2.0)
    radius = float(first.columns["radius"][0])
    speed = sqrt(4.0 * gravity * radius * (sqrt(3.0) / 2.0 - k) * k * k / (1.0 + k * k))
    vx = last.columns["vx"]
    return [
        Measured("speed of the left sphere", last.step, -float(vx[0]), speed),
        Measured("speed of the right sphere", last.step, float(vx[1]), speed),
        Measured("sideways speed of the upper sphere", last.step, float(vx[2]), 0.0, speed),
        Measured("sideways momentum", last.step, float(vx @ last.columns["mass"]), 0.0, speed * float(last.columns["mass"].sum())),
    ]

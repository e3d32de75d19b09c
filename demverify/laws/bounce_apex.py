"""A sphere dropped on the plane z = 0 bounces: as hard spheres do, its apex after the k-th contact is R + e^(2k) (z0 - R)
(MFIX-DEM V&V, DEM-02, eq. 4.11). A soft contact lies below that, by what gravity does while it lasts: of order contact time / time of fall."""

from __future__ import annotations

from collections.abc import Sequence

from demverify.frames import Frame
from demverify.laws import Measured


def measure(frames: Sequence[Frame], restitution: float, gravity: float, bounces: float) -> list[Measured]:
    """Apex over the height of the drop, after each of the first `bounces` contacts. It is read off any frame on the way up, z + vz^2/(2 g)."""
    height, radius = (float(frames[0].columns[name][0]) for name in ("z", "radius"))
    found: list[Measured] = []
    rising = False
    for frame in frames:
        z, v = (float(frame.columns[name][0]) for name in ("z", "vz"))
        if v < 0.0:
            rising = False
        elif z > radius and not rising and frame.step > frames[0].step and len(found) < bounces:
            rising = True
            drop = (z + v**2 / (2.0 * gravity) - radius) / (height - radius)
            found.append(Measured(f"apex {len(found) + 1}", frame.step, drop, restitution ** (2 * (len(found) + 1))))
    if len(found) < bounces:
        message = f"{bounces:g} bounces wanted, {len(found)} seen"
        raise LookupError(message)
    return found

"""Random superquadrics."""

from __future__ import annotations

import numpy as np

from demsolver.superquadric import Body, Floats, body, surface

EXPONENTS = (2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0)


def drawn(rng: np.random.Generator, x: Floats) -> Body:
    """A body of any orientation, aspect ratios up to 5."""
    q = rng.normal(size=4)
    return body(x, q / np.linalg.norm(q), rng.uniform(0.01, 0.05, 3), rng.choice(EXPONENTS, 2))


def near(seed: int) -> tuple[Body, Body]:
    """Two bodies whose surfaces overlap by a tenth of the smallest semi-axis on the line between their centres; the first at the origin."""
    rng = np.random.default_rng(seed)
    i, way = drawn(rng, np.zeros(3)), rng.normal(size=3)
    way /= np.linalg.norm(way)
    j = drawn(rng, np.zeros(3))
    reach = surface.leaves((0.0, 0.0, 0.0), tuple(way), i) + surface.leaves((0.0, 0.0, 0.0), tuple(-way), j)
    apart = reach - 0.1 * min(*i.axes, *j.axes)
    return i, Body(tuple(apart * way), *j[1:])

"""What the user's own data show to be wrong: the inertia of clumps against that of their templates."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from demsolver.shapes.multisphere import Template
from demverify.analysis.clump_inertia import diagnose
from demverify.frames import Floats


def doubts(inertia: Floats, clumptype: Floats | None, templates: Sequence[Template]) -> list[str]:
    """One line for each kind of body whose principal moments (m, 3) are those of no template it could be of.

    clumptype: (m,) the template of each body; None: any of them.
    """
    _, kinds = np.unique(inertia.sum(axis=1), return_index=True)
    found = []
    for i in kinds if templates else ():
        own = [template for template in templates if clumptype is None or template.kind == clumptype[i]]
        told = [_doubt(inertia[i].tobytes(), t.centre.tobytes(), t.radius.tobytes(), t.kind) for t in own]
        if told and None not in told:
            found.append(min(map(str, told), key=len))
    return found


@lru_cache(maxsize=4096)
def _doubt(inertia: bytes, centre: bytes, radius: bytes, kind: int) -> str | None:
    template = Template(np.frombuffer(centre).reshape(-1, 3), np.frombuffer(radius), None, kind)
    return diagnose(np.frombuffer(inertia), template)

"""Is the inertia that LIGGGHTS wrote for clumps that of their template?"""

from __future__ import annotations

import numpy as np

from demsolver.shapes.multisphere import Template, solid_of
from demverify.frames import Floats

MONTE_CARLO = 0.005
"""What a share of LIGGGHTS' moments may be off by, relative, because it throws `ntry` random points, a number that no dump tells. It is three
standard errors of the least certain moment at ntry = 1e6, as in LIGGGHTS' tutorial: measured 0.52 % at 1e5 for four spheres, and it falls with
the root. (LIGGGHTS warns below 1e5.)"""


def liggghts_slip(inertia: Floats) -> Floats:
    """The inertia tensor (3, 3), along the axes of the template file, as LIGGGHTS 3.8.0 symmetrises it: I_yz is averaged with I_xz.

    Without a plane of symmetry z = 0 this changes the principal moments and axes. Source: fix_template_multisphere.cpp, calc_inertia;
    register entry liggghts-multisphere-inertia.
    """
    slip = inertia.copy()
    slip[1, 2] = slip[2, 1] = 0.5 * (inertia[1, 2] + inertia[0, 2])
    return slip


def diagnose(inertia: Floats, template: Template) -> str | None:
    """One line on the principal moments (m, 3) or (3,) that a dump has for bodies of a template; None: they are those of the union of its spheres.

    Moments are compared as shares of their sum, which neither density nor the defect changes.
    """
    exact = solid_of(template).inertia
    moments = np.sort(np.atleast_2d(inertia), axis=1)
    moments = moments / moments.sum(axis=1, keepdims=True)
    off = _off(moments, exact)
    if off <= MONTE_CARLO:
        return None
    which = f"the principal moments of the clumps of template {template.kind} are off by up to {off:.1%} from those of the union of its spheres"
    if _off(moments, liggghts_slip(exact)) <= MONTE_CARLO:
        defect = "the known defect of LIGGGHTS 3.8.0 with clumps that are not symmetric about z = 0 of their file"
        return f"{which}: {defect} (register: liggghts-multisphere-inertia)"
    return f"{which}, which neither the known defect of LIGGGHTS 3.8.0 nor its random points (if ntry was 1e6 or more) explain: another template?"


def forecast(template: Template) -> str | None:
    """One line on a clump whose moments LIGGGHTS 3.8.0 gets wrong: the run went by another inertia than that of its spheres. None: it does not."""
    exact = solid_of(template).inertia
    wrong = np.linalg.eigvalsh(liggghts_slip(exact))
    off = _off(np.atleast_2d(wrong / wrong.sum()), exact)
    if off <= MONTE_CARLO:
        return None
    return (
        f"LIGGGHTS 3.8.0 takes principal moments of the clumps of template {template.kind} that are off by up to {off:.1%} (register: "
        "liggghts-multisphere-inertia); the energies here are of the union of the spheres, those that such a run prints are not"
    )


def _off(shares: Floats, tensor: Floats) -> float:
    """Largest relative difference of the shares (m, 3) from those of a tensor."""
    law = np.linalg.eigvalsh(tensor)
    return float(np.abs(shares / (law / law.sum()) - 1.0).max())

"""The DEM primer, formula by formula: every equation runs in the native solver, and what it says is set beside what came out."""

from __future__ import annotations

from collections.abc import Callable

from demverify.studies import Finding, Progress, Study
from demverify.studies._primer_bodies import bodies
from demverify.studies._primer_friction import circling, sliding, sticking
from demverify.studies._primer_impact import restitution
from demverify.studies._primer_planes import planes
from demverify.studies._primer_rest import resting
from demverify.studies._primer_steps import both, damper_alone, integrators, spring_alone
from demverify.studies._primer_turning import levers, rolling, slip_to_roll

TITLE = "A primer of the discrete element method"
SOURCE = 'K. Shobuzako, "DEM no kiso" (basics of DEM, in Japanese), Kyushu University, version 1 of 23 July 2025.'
READINGS = (
    "(1.14): the last sum is read as |delta_t of the step before| t + vt dt, as the words under the formula say; the print has a factor dt too many.",
    "(1.16), (1.18): what stays is the vector; where the sliding goes on only its length matters.",
    "(1.17), (1.20): |fn| is the whole normal force, damping included.",
    "(1.17) where vt = 0 and the limit falls below the spring: the force keeps the direction of the spring.",
    "(1.19): the lever ends at the contact point, r - overlap/2 from the centre.",
    "(1.20) at walls: the spin is taken relative to that of the wall.",
    "Section 3: a plane is felt from both sides; its velocity is that of a point of it, about which it turns.",
)
PARTS: tuple[tuple[str, Callable[[bool], Finding]], ...] = (
    ("tangential spring, sticking", sticking), ("tangential spring, sliding", sliding), ("tangential spring, circling", circling),
    ("what rests", resting), ("levers", lambda _: levers()), ("sliding to rolling", slip_to_roll), ("rolling resistance", rolling),
    ("spring alone", spring_alone), ("damper alone", lambda _: damper_alone()), ("spring and damper", both), ("integrators", integrators),
    ("walls", planes), ("a crowd and its centre", bodies), ("restitution", restitution),
)  # fmt: skip


def run(quick: bool, progress: Progress) -> Study:
    """All of it; quick: fewer values, shorter runs."""
    findings = []
    for k, (what, part) in enumerate(PARTS):
        progress(what, k / len(PARTS))
        findings.append(part(quick))
    progress("done", 1.0)
    return Study(TITLE, SOURCE, tuple(findings), READINGS)

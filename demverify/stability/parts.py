"""The parts of `demverify stability`, in the order of the page, and the study that they make."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from demverify.stability.limits import one_contact
from demverify.stability.limits_laws import other_laws
from demverify.stability.limits_packing import packings
from demverify.stability.limits_plane import plane
from demverify.stability.stress import stress
from demverify.studies import Finding, Progress, Study

Part = Callable[[bool, Progress], Finding | Sequence[Finding]]

PARTS: list[tuple[str, Part]] = [
    ("one contact", one_contact),
    ("other laws", other_laws),
    ("plane", plane),
    ("packings", packings),
    ("stress", stress),
]
TITLE = "Where a step breaks"
SOURCE = "Theory: the eigenvalues of a step (docs/timestep.md; after K. Shobuzako, DEM no kiso, 2025, section 2, and E. I. Jury)."
READINGS = (
    ("A step holds if no force or torque grows a thousandfold from a tiny disturbance; below its limit an undamped contact swells, a thousandth below"
    " it a hundredfold, and stays there."),
    "The guard of the solver is off where growth is the point: it would stop these runs, as it should.",
    ("A damper alone with velocity Verlet reads up to 0.4 % too long: at H = 2 the first half step takes the whole disturbance away, and what is "
    "left needs longer to grow."),
)  # fmt: skip


def run(quick: bool, progress: Progress) -> Study:
    """Runs all parts. progress: what is done, and the share of the whole."""
    findings: list[Finding] = []
    for k, (name, part) in enumerate(PARTS):
        found = part(quick, lambda what, share: progress(f"{name}: {what}", (k + share) / len(PARTS)))  # noqa: B023
        findings += [found] if isinstance(found, Finding) else found
    return Study(TITLE, SOURCE, tuple(findings), READINGS, "theory")

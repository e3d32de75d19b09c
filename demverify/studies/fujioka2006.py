"""The paper of Fujioka & Ushijima (2006): its figures 3 to 7, 10 and 11 and its tables 1 and 2, through `Simulation`."""

from __future__ import annotations

from demverify.studies import Progress, Study
from demverify.studies._fujioka_cost import cost_finding, cost_numbers, steps_finding, steps_numbers
from demverify.studies._fujioka_hole import hole_finding, hole_numbers
from demverify.studies._fujioka_impacts import fast_finding, fast_numbers, slow_finding, slow_numbers
from demverify.studies._fujioka_models import HERTZ_STIFFNESS, STIFFNESS
from demverify.studies._fujioka_portraits import portrait_finding
from demverify.studies._fujioka_sliding import sliding_findings, sliding_numbers

TITLE = "Energy-conserving normal contact (Fujioka & Ushijima 2006)"
SOURCE = (
    "S. Fujioka, S. Ushijima, An evaluation method of normal contact force with energy conservation in distinct element method (2006); in Japanese"
)
READINGS = (
    f"Stiffness of C, F and P: a = k dt²/m = (π/10)² = {STIFFNESS:.4f}, m the reduced mass, at every step: C then takes the ten steps of table 2.",
    f"Stiffness of T: K dt² √d_c/m = {HERTZ_STIFFNESS}, force K overlap^(3/2), d_c the diameter. See table 2, for a drop of one diameter.",
    "For a drop of 0.01 diameters table 2 would ask 4.66 of T, which then gains energy in the first fast impact: figure 5 excludes that.",
    "Drop in sections 5.4 and 5.5: one diameter; the printed 0.01 diameters are off the counts of table 1 by a factor of four.",
    "Diameter 225 m, as printed: with 1e5 m/s and 1e-3 s the sphere moves 0.44 diameters a step, under the 0.5 that section 5.3 asks for.",
    "Dashpots of C and T: from the closed forms of a contact that ends at zero overlap, pulling tail and all, for restitution 0.7.",
    "Integrator: semi-implicit Euler. Its velocity is the approach of the last step, which (10) and (12) take it to be.",
    "F: reconstructed from what the paper tells of it; the paper of 2005 was not at hand.",
    "What the figures call e^(1/2) is the energy ratio e².",
    "Wall of section 5.3: a half-space. The native plane is felt from both sides and turns a sphere on whose centre is beyond it.",
)


def run(quick: bool, progress: Progress) -> Study:
    """All findings. quick: a tenth of the steps in table 1, shorter flights in figure 5, five step sizes in figures 10 and 11."""
    slow = slow_numbers(progress)
    fast = fast_numbers(quick, progress)
    costs = cost_numbers(quick, progress)
    steps = steps_numbers(progress)
    sliding = sliding_numbers(quick, progress)
    hole = hole_numbers(quick, progress)
    findings = (
        hole_finding(hole), slow_finding(slow), fast_finding(fast), portrait_finding(fast), cost_finding(costs), steps_finding(steps),
        *sliding_findings(sliding),
    )  # fmt: skip
    progress("done", 1.0)
    return Study(TITLE, SOURCE, findings, READINGS)

"""The hole in the flow chart of the paper (figure 3): restitution over the stiffness, as printed and as mended."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from demverify.frames import Floats
from demverify.report.axes import decades, logarithmic, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Progress, Table
from demverify.studies._fujioka_models import DIAMETER, MODELS, RESTITUTION, STIFFNESS, Model, over_floor

STIFFNESSES = 10.0 ** np.linspace(-3.0, 2.0, 51)
NAMED = (STIFFNESS, 0.5, 1.0, 10.0)
PHASES = 400
APPROACH = 0.3  # diameters a step
LASTING = 8  # steps, more than any of these contacts takes
Numbers = Mapping[str, Any]


def worst(a: Floats) -> Floats:
    """Largest relative error of the restitution of the printed model, in closed form: of a contact that began as late as can be, s -> 1 in mode 2."""
    return np.asarray(1.0 - np.sqrt(1.0 - a * (np.sqrt(1.0 + a + a * a) - 1.0) ** 2 / (1.0 + a) ** 3))


def error(model: Model, a: float, phases: int = PHASES) -> float:
    """Largest relative error of the restitution over as many phases of the contact; no gravity, reduced stiffness a."""
    dt = 1e-3
    speed = APPROACH * DIAMETER / dt
    running = over_floor(model, np.linspace(1e-3, 1.0 - 1e-6, phases) * APPROACH * DIAMETER, speed, dt, a=a, gravity=0.0)
    running.advance(LASTING)
    return float(np.abs(running.bodies.v[:, 2] / (RESTITUTION * speed) - 1.0).max())


def hole_numbers(quick: bool, progress: Progress) -> dict[str, Any]:
    """Largest error of P and P mended over the reduced stiffness."""
    progress("the hole", 0.95)
    stiffnesses = STIFFNESSES[:: 5 if quick else 1]
    printed, mended = MODELS[3], MODELS[4]
    return {
        "a": stiffnesses, "closed form": worst(stiffnesses),
        **{model.name: np.array([error(model, float(a)) for a in stiffnesses]) for model in (printed, mended)},
        "named": {f"{a:.4g}": {model.name: error(model, a) for model in (printed, mended)} for a in NAMED},
    }  # fmt: skip


def hole_claims(numbers: Numbers) -> tuple[Claim, ...]:
    """The paper's claim of section 4, and what becomes of it."""
    a, printed, mended = (np.asarray(numbers[name], dtype=float) for name in ("a", "P", "P mended"))
    said = ", ".join(f"{scientific(row['P'], 3)} at a = {at}" for at, row in numbers["named"].items())
    form = np.asarray(numbers["closed form"], dtype=float)
    apart = float(np.abs(printed / form - 1.0)[form > 1e-9].max())  # below, rounding shows
    return (
        Claim(
            "The model keeps the energy of a contact, but for the loss that the restitution asks for, at any restitution and step.",
            f"As printed the restitution is off by up to {said}.",
            bool(printed.max() < 1e-9),
            "For 0 < s < 1 the flow chart takes (21) also where that ends the contact, a² + (1 + a) s² ≥ 1, and the energy a d'²/2 is lost.",
        ),
        Claim(
            "With the formula of the ending, (23), used there too, the restitution is exact.",
            f"Largest error over all a from {a[0]:g} to {a[-1]:g}: {scientific(float(mended.max()))}.",
            bool(mended.max() < 1e-12),
            whose="ours",
        ),
        Claim(
            "The largest error as printed is 1 − √(1 − a (√(1 + a + a²) − 1)²/(1 + a)³).",
            f"The runs come within {100 * apart:.2g} % of it.",
            apart < 0.02,
            whose="ours",
        ),
    )


def hole_finding(numbers: Numbers) -> Finding:
    """Figure 3."""
    a = np.asarray(numbers["a"], dtype=float)
    series = [Series(model.name, a, np.asarray(numbers[model.name]), model.style, "both") for model in MODELS[3:]]
    axes = logarithmic(float(a[0]), float(a[-1])), decades(-17, 0)
    label = f"error of restitution over a: printed up to {series[0].y.max():.2f}, mended up to {series[1].y.max():.1e}"
    picture = chart("error of restitution", label, series, axes, ("a = k dt²/m", "relative"), [Rule("closed form", a, worst(a))])
    rows = tuple((at, row["P"], float(worst(np.array(float(at)))), row["P mended"]) for at, row in numbers["named"].items())
    return Finding(
        "Figure 3: the hole in the flow chart", hole_claims(numbers),
        f"Spheres against the wall at {PHASES} phases of the contact for each a, no gravity, restitution {RESTITUTION}.",
        (Figure("hole", "Largest relative error of the restitution over all phases of the contact.", picture),),
        (Table("Largest error of the restitution", ("a", "P as printed", "closed form", "P mended"), rows),), numbers,
    )  # fmt: skip

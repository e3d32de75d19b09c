"""Section 2 of the primer, eigenvalues and limits of the step, and the two integrators beside one another; all on the native solver."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np

from demsolver.stability import combined_limit, damper_limit, spring_limit
from demverify.report.axes import linear, logarithmic, scientific
from demverify.report.charts import Rule, Series, chart
from demverify.studies import Claim, Figure, Finding, Table
from demverify.studies._primer_scenes import KN, MASS, RADIUS, path, squeezed

OMEGA = sqrt(2.0 * KN / MASS)  # of a sphere between two planes
ROUNDING = 1e-8  # of what is read off a dozen positions: overlaps of RADIUS/2, each rounded to 1e-16 of it, motions from 1e-6 RADIUS on
HOW = (
    "A sphere pressed between two planes, m x'' = -k x - eta x' exactly with k and eta of both contacts together, semi-implicit Euler "
    "(fix euler/sphere); trace and determinant of a step are read off its positions by least squares. K = k dt^2/m, H = eta dt/m."
)


def trace_and_determinant(k: float, h: float) -> tuple[float, float]:
    """Of the map (x', x) -> (x'', x') that the solver makes, from a short run at K = k and H = h."""
    dt = sqrt(k) / OMEGA if k else 1.0 / OMEGA
    sphere = squeezed(dt, x=1e-6 * RADIUS, v=3e-7 * RADIUS / dt, kn=KN if k else 0.0, gamman=0.5 * h * MASS / dt)
    x, _ = path(sphere, 12)
    (trace, less_determinant), *_ = np.linalg.lstsq(np.column_stack([x[1:-1], x[:-2]]), x[2:])
    return float(trace), -float(less_determinant)


def largest(trace: float, determinant: float) -> float:
    """The larger |lambda| of lambda^2 - trace lambda + determinant."""
    return float(np.abs(np.roots([1.0, -trace, determinant])).max())


def spring_alone(quick: bool) -> Finding:
    """2.1: (2.13)-(2.24)."""
    k = np.linspace(0.3, 4.5, 7 if quick else 36)
    found = [trace_and_determinant(float(one), 0.0) for one in k]
    measured, computed = np.array([largest(*one) for one in found]), np.array([largest(2.0 - one, 1.0) for one in k])
    off, unit = float(np.abs(measured - computed).max()), max(abs(determinant - 1.0) for _, determinant in found)
    bounded = measured < 1.0 + 1e-6
    claims = (
        Claim("The eigenvalues of a step are those of (2.15).", f"The larger |lambda| is, to {scientific(off)}, for K from {k[0]:g} to {k[-1]:g}.",
              off < 1e-4),  # of a double root, rounding takes the square root
        Claim("The scheme is stable for dt < 2 sqrt(m/k), K < 4 (2.24).",
              f"Bounded at all K up to {k[bounded].max():g}, growing from {k[~bounded].min():g} on.", bool((bounded == (k < 4.0)).all())),
        Claim("Stable means |lambda| < 1 (2.13), and a^2 + b^2 < 1 below the limit (2.23).",
              f"lambda_1 lambda_2 = 1 to {scientific(unit)} at every K: below the limit |lambda| = 1, and nothing decays.", unit > ROUNDING,
              "Slip: the product of the eigenvalues is the determinant of (2.7), 1. With the root of (2.22) as sqrt(4 - (2 - K)^2), which is what is "
              "positive there, a^2 + b^2 = 1. The scheme is neutrally stable, as is right for a spring without damper."),
    )  # fmt: skip
    svg = chart(
        "largest |lambda|", "Size of the larger eigenvalue over K = k dt^2/m: one up to K = 4, growing beyond",
        [Series("(2.15)", np.linspace(0.1, 4.5, 200), np.array([largest(2.0 - one, 1.0) for one in np.linspace(0.1, 4.5, 200)]), 0),
         Series("measured", k, measured, 1, "marks")],
        (linear(0.0, 4.5), linear(0.5, 2.5)), ("K = k dt²/m", ""),
    )  # fmt: skip
    numbers = {"K": k, "|lambda| measured": measured, "|lambda| of (2.15)": computed}
    return Finding("2.1: spring alone", claims, HOW, (Figure("eigenvalues", "Larger |lambda| of the undamped step.", svg),), (), numbers)


def damper_alone() -> Finding:
    """2.2: (2.28)-(2.30)."""
    steps = (0.3, 0.9, 1.9, 2.1)
    traces = np.array([trace_and_determinant(0.0, h)[0] for h in steps])
    printed, mended = float(np.abs(traces - 2.0).max()), float(np.abs(traces - 2.0 + np.array(steps)).max())
    rows = tuple((f"{h:g}", float(trace - 1.0), 1.0 - h) for h, trace in zip(steps, traces, strict=True))
    claims = (
        Claim("The first entry of the matrix is 2 - k dt^2/m (2.28): 2 here, as there is no spring.",
              f"Its trace as measured is off from that by up to {scientific(printed)}, and 2 - eta dt/m to {scientific(mended)}.", printed < ROUNDING,
              "Slip: (2.28) has kept the entry of (2.7). From (2.27) it is 2 - eta dt/m, and with that the eigenvalues are those of (2.29)."),
        Claim("The eigenvalues are 1 and 1 - eta dt/m (2.29).", f"The second one is, to {scientific(mended)}.", mended < ROUNDING),
        Claim("Stable for dt < 2 m/eta (2.30).", f"At H = 1.9 lambda = {traces[2] - 1.0:.3f}, at H = 2.1 {traces[3] - 1.0:.3f}.",
              bool(abs(traces[2] - 1.0) < 1.0 < abs(traces[3] - 1.0))),
    )  # fmt: skip
    table = Table("Second eigenvalue of the damper alone", ("eta dt/m", "measured", "1 - eta dt/m"), rows)
    return Finding("2.2: damper alone", claims, HOW, (), (table,), {"H": steps, "trace": traces})


def both(quick: bool) -> Finding:
    """2.3: (2.31), (2.32), and the condition that holds."""
    ratios = np.array([0.05, 0.5, 1.0] if quick else [0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0])
    measured, together, apart = (np.array([of(float(b)) for b in ratios]) for of in (longest, _together, _apart))
    worst, off = float((measured / apart).min()), float(np.abs(measured / together - 1.0).max())
    several = longest(0.0) / spring_limit(1.0, 0.5)
    inside, outside = (largest(*trace_and_determinant(k, 1.0)) for k in (1.98, 2.02))
    claims = (
        Claim("With spring and damper the step may be up to min(2 sqrt(m/k), 2 m/eta) (2.31).",
              f"The measured limit is {worst:.3f} of that at worst, {float((measured / apart)[0]):.3f} at eta/(2 sqrt(m k)) = {ratios[0]:g}.",
              worst > 1.0 - 1e-3,
              "The two act in one step. The roots of lambda^2 - (2 - K - H) lambda + 1 - H lie in the unit circle exactly if H < 2 and K + 2 H < 4."),
        Claim("It may be up to 4 m/(eta + sqrt(eta^2 + 4 k m)), where K + 2 H = 4.", f"The measured limits are that to {scientific(off)}.",
              off < 1e-6, whose="ours"),
        Claim("At H = 1 the limit is K = 2, not 4.", f"|lambda| = {inside:.4f} at K = 1.98, {outside:.4f} at K = 2.02.", inside < 1.0 < outside,
              whose="ours"),
        Claim("In practice the step is that of one spring, 2 sqrt(m/k) (2.32).",
              f"For the sphere between two planes, {several:.4f} of the limit of one of its contacts.", several > 1.0 - 1e-3,
              "Contacts add up: two springs on one sphere are one of 2 k. In a packing the largest eigenvalue of all contacts decides; "
              "demverify timestep computes it."),
    )  # fmt: skip
    over = np.linspace(0.01, 2.0, 200)
    svg = chart(
        "longest stable step", "Longest stable step over the damping ratio: measured, K + 2 H < 4, and (2.31), which is longer",
        [Series("K + 2 H < 4", over, np.array([_together(b) for b in over]), 0), Series("(2.31)", over, np.array([_apart(b) for b in over]), 2),
         Series("measured", ratios, measured, 1, "marks")],
        (linear(0.0, 2.0), linear(0.0, 2.2)), ("eta/(2 sqrt(m k))", "in sqrt(m/k)"),
    )  # fmt: skip
    rows = tuple((f"{b:g}", float(m), float(t), float(a)) for b, m, t, a in zip(ratios, measured, together, apart, strict=True))
    return Finding(
        "2.3: spring and damper", claims, HOW, (Figure("limits", "Longest stable step over the damping ratio.", svg),),
        (Table("Longest stable step in units of sqrt(m/k)", ("eta/(2 sqrt(m k))", "measured", "K + 2 H < 4", "(2.31)"), rows),),
        {"damping ratio": ratios, "measured": measured, "K + 2 H = 4": together, "(2.31)": apart},
    )  # fmt: skip


def _together(b: float) -> float:
    return combined_limit(1.0, 1.0, 2.0 * b)


def _apart(b: float) -> float:
    return min(spring_limit(1.0, 1.0), damper_limit(1.0, 2.0 * b))


def longest(b: float) -> float:
    """The step, in sqrt(m/k), up to which a root outside the unit circle is not measured; bisected."""
    low, high = 0.1 * _together(b), 1.2 * _together(b)
    for _ in range(26):
        s = 0.5 * (low + high)
        trace, determinant = trace_and_determinant(s * s, 2.0 * b * s)
        stable = abs(trace) < 1.0 + determinant and determinant < 1.0 + ROUNDING  # Jury; without damper the determinant is 1
        low, high = (s, high) if stable else (low, s)
    return 0.5 * (low + high)


def integrators(quick: bool) -> Finding:
    """(2.2) beside velocity Verlet: order, energy, and what Euler keeps."""
    counts = np.array([400, 1600, 6400] if quick else [100, 200, 400, 800, 1600, 3200, 6400, 12800])
    errors = {name: np.array([_error(int(n), euler) for n in counts]) for name, euler in (("Euler", True), ("Verlet", False))}
    orders = {name: -float(np.polyfit(np.log(counts[-3:]), np.log(e[-3:]), 1)[0]) for name, e in errors.items()}
    dt, steps = 0.2 / OMEGA, 2_000 if quick else 20_000
    energies, kept = {}, 0.0
    for name, euler in (("Euler", True), ("Verlet", False)):
        x, v = path(squeezed(dt, x=0.1 * RADIUS, euler=euler), steps)
        energy = 0.5 * MASS * v**2 + KN * x**2
        energies[name] = energy / energy[0] - 1.0
        if euler:
            own = energy - KN * dt * x * v
            kept = float(np.abs(own / own[0] - 1.0).max())
    swing = {name: float(np.ptp(e)) for name, e in energies.items()}
    drift = {name: float(abs(e[-steps // 10 :].mean() - e[: steps // 10].mean())) for name, e in energies.items()}
    claims = (
        Claim("The scheme (2.2) is the forward Euler method.",
              f"Its energy drifts by {scientific(drift['Euler'])} in {steps:,} steps; forward Euler gains K = {(dt * OMEGA) ** 2:.2g} in each.",
              drift["Euler"] > 0.5 * (dt * OMEGA) ** 2 * steps,
              "With the new velocity in the second line it is the semi-implicit (symplectic) Euler method, of first order but without drift."),
        Claim("Velocity Verlet has order 2, Euler order 1.", f"Order {orders['Verlet']:.2f} and {orders['Euler']:.2f}.",
              abs(orders["Verlet"] - 2.0) < 0.1 and abs(orders["Euler"] - 1.0) < 0.1, whose="ours"),
        Claim("Euler's energy swings with the step and comes back; m u^2/2 + k x^2/2 - k dt x u/2 stays put.",
              f"Swing {scientific(swing['Euler'])} (Verlet {scientific(swing['Verlet'])}) at dt = 0.2 sqrt(m/k); the sum stays put to "
              f"{scientific(kept)}.", kept < 1e-9, whose="ours"),
    )  # fmt: skip
    some = slice(0, 160)
    over_time = chart(
        "energy off by", "Energy of an undamped oscillation over time, Euler and Verlet",
        [Series(name, dt * OMEGA * np.arange(160.0), e[some], style) for style, (name, e) in enumerate(energies.items())],
        (linear(0.0, 32.0), linear(-0.25, 0.25)), ("time in sqrt(m/k)", "relative"),
    )  # fmt: skip
    low = min(float(e.min()) for e in errors.values())
    falls = (("1/n", "Euler", 1), ("1/n²", "Verlet", 2))
    rules = [Rule(name, counts.astype(float), errors[of][0] * (counts[0] / counts) ** n) for name, of, n in falls]
    order = chart(
        "position off by", "Error of the position after ten units of time over the number of steps",
        [Series(f"{name}, order {orders[name]:.2f}", counts.astype(float), e, style, "both") for style, (name, e) in enumerate(errors.items())],
        (logarithmic(float(counts[0]), float(counts[-1])), logarithmic(low, 1.0)), ("steps", "in amplitudes"),
        rules,
    )  # fmt: skip
    return Finding(
        "(2.2): Euler and Verlet", claims, HOW + " Positions are compared after t = 10 sqrt(m/k).",
        (Figure("convergence", "Error of the position over the number of steps.", order),
         Figure("energy", "Energy over the first 32 units of time, a fifth of one in a step.", over_time)), (),
        {"steps": counts, "error": errors, "order": orders, "energy": {n: e[:: steps // 1000] for n, e in energies.items()}, "Euler's own": kept},
    )  # fmt: skip


def _error(count: int, euler: bool) -> float:
    """Of the position after t = 10 in units of sqrt(m/k), over the amplitude."""
    amplitude, phase = 0.1 * RADIUS, 1.0
    x, _ = path(squeezed(10.0 / OMEGA / count, x=amplitude * cos(phase), v=-amplitude * OMEGA * sin(phase), euler=euler), count)
    return abs(float(x[-1]) / amplitude - cos(10.0 + phase))

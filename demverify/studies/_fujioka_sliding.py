"""Figures 10 and 11: a sphere that slides down between two others and pushes them apart; lasting contacts, several at once."""

from __future__ import annotations

from collections.abc import Mapping
from math import cbrt, sqrt
from typing import Any

import numpy as np

from demverify.frames import Floats
from demverify.report.axes import logarithmic, scientific
from demverify.report.charts import Series, chart
from demverify.studies import Claim, Figure, Finding, Progress, Table
from demverify.studies._fujioka_models import GRAVITY, MODELS, PAPER, Model, Spheres, law, simulation, sphere_mass, stiffness

RADIUS = 0.02
STEPS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6)
NODES = 60  # of the Gauss rule
CLOSE = 1.0 + 1e-6  # two errors nearer than this are the same
Numbers = Mapping[str, Any]


def height_at_parting() -> float:
    """k = h/(2 r0) where the upper sphere lets go: the force between vanishes, k^3 + 3 k = sqrt(3) (29)."""
    return cbrt((sqrt(3.0) + sqrt(7.0)) / 2.0) + cbrt((sqrt(3.0) - sqrt(7.0)) / 2.0)


def final_speed() -> float:
    """d' = speed of the lower spheres at last over sqrt(4 g r0) (28)."""
    k = height_at_parting()
    return sqrt((sqrt(3.0) / 2.0 - k) * k * k / (1.0 + k * k))


def parting_time() -> float:
    """T0 over sqrt(r0/g) (30), with t = sqrt(3)/2 - y^2, which takes the pole off the upper end; Gauss' rule is then exact to rounding."""
    y_end = sqrt(sqrt(3.0) / 2.0 - height_at_parting())
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    t = sqrt(3.0) / 2.0 - (0.5 * y_end * (nodes + 1.0)) ** 2
    return float(0.5 * y_end * weights @ (2.0 * np.sqrt((1.0 + t * t) / (1.0 - t * t))))


def slide(model: Model, dt: float) -> tuple[float, float]:
    """(d', T0 in units of sqrt(r0/g)) of a run. T0 is the step at which B and C are apart for good."""
    mass, scale = sphere_mass(RADIUS), sqrt(RADIUS / GRAVITY)
    x = RADIUS * np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0 + sqrt(3.0)]])
    spheres = Spheres(x, np.zeros((3, 3)), np.full(3, RADIUS), np.full(3, mass))
    pair = law(model, np.full((1, 1), stiffness(model, mass / 2, RADIUS / 2, 2 * RADIUS, dt)))
    floor = law(model, np.full(1, stiffness(model, mass, RADIUS, 2 * RADIUS, dt)))
    running = simulation(spheres, pair, floor, dt, skin=RADIUS)
    last = 0
    for step in range(1, int(1.2 * parting_time() * scale / dt)):
        running.advance(1)
        x = running.bodies.x
        apart = x[2] - x[1]
        if apart @ apart < 4.0 * RADIUS**2:
            last = step
    return float(running.bodies.v[1, 0]) / sqrt(4.0 * GRAVITY * RADIUS), (last + 1) * dt / scale


def sliding_numbers(quick: bool, progress: Progress) -> dict[str, Any]:
    """Relative errors of d' and T0 of each model at each step size."""
    steps = STEPS[: 6 if quick else len(STEPS)]
    errors: dict[str, Any] = {}
    for k, model in enumerate(MODELS):
        progress(f"sliding, {model.name}", 0.68 + 0.05 * k)
        found = np.array([slide(model, dt) for dt in steps])
        errors[model.name] = {"d'": found[:, 0] / final_speed() - 1.0, "T0": found[:, 1] / parting_time() - 1.0}
    exact = {"k": height_at_parting(), "d'": final_speed(), "T0": parting_time() * sqrt(RADIUS / GRAVITY)}
    return {"steps": np.array(steps), "exact": exact, "errors": errors}


def _sizes(numbers: Numbers, quantity: str) -> dict[str, Floats]:
    return {name: np.abs(np.asarray(found[quantity], dtype=float)) for name, found in numbers["errors"].items()}


def _nearer(one: Floats, other: Floats) -> int:
    """At how many steps the first is nearer to the closed form, ties left out."""
    return int(np.sum(one * CLOSE < other))


def order(sizes: Floats, steps: Floats) -> float:
    """The power of the step with which an error falls from 1e-4 s to the finest step."""
    at = int(np.argmin(np.abs(steps - 1e-4)))
    return float(np.log(sizes[at] / sizes[-1]) / np.log(steps[at] / steps[-1]))


def sliding_claims(numbers: Numbers, quantity: str) -> tuple[Claim, ...]:
    """What section 5.6 states of figure 10 (d') and figure 11 (T0)."""
    size, steps = _sizes(numbers, quantity), np.asarray(numbers["steps"], dtype=float)
    many, at = len(steps), int(np.argmin(np.abs(steps - 1e-4)))
    orders = {name: order(size[name], steps) for name in PAPER}
    worse = np.maximum(size["F"], size["P"])
    of_t, of_all = _nearer(worse, size["T"]), _nearer(worse, np.minimum(size["C"], size["T"]))
    of_f, of_p = _nearer(size["F"], size["P"]), _nearer(size["P"], size["F"])
    growth, gap = float(size["C"][0] / size["C"][at]), float(np.abs(size["F"] / size["P"] - 1.0).max())

    span = f"steps of {scientific(float(steps[at]))} s to {scientific(float(steps[-1]))} s"

    def fall(name: str) -> str:
        return f"{name} from {scientific(float(size[name][at]), 3)} to {scientific(float(size[name][-1]), 3)}"

    steep = Claim(
        "Above about 10⁻⁴ s the error of C grows steeply.",
        f"From {scientific(float(steps[at]))} s to {scientific(float(steps[0]))} s it grows {growth:.0f}-fold.",
        growth > (steps[0] / steps[at]) ** 2,
    )
    return (
        Claim(
            "T: the error falls as the step is made finer.",
            f"From {span}: {fall('T')}.",
            orders["T"] > 0.4,
        ),
        Claim(
            "T needs a finer step than F and P for the same accuracy.",
            f"F and P are nearer than T at {of_t} of {many} steps.",
            of_t >= many - 1,
        ),
        Claim(
            "C gains nothing from steps finer than about 10⁻⁴ s.",
            f"From {span}: {fall('C')}; {fall('P')}. The dashpot of C sees a velocity half a step old, which on a turning line of centres holds a "
            "false parting v_t² dt/(4 r0); as it is stiffer the shorter the step, it goes on pulling where the contact should end.",
            orders["C"] < 0.2 and orders["P"] > 0.4,
        ),
        *((steep,) if quantity == "d'" else ()),
        Claim(
            "F is more accurate than P in most cases.",
            f"F is nearer at {of_f} of {many} steps, P at {of_p}; their errors differ by {100 * gap:.1g} % at most.",
            of_f > many / 2,
            "From touch at rest every contact of this run begins and lasts; F and P, which differ in the contact step alone, then do the same.",
        ),
        Claim(
            "F and P, though made for two bodies, are more accurate than C and T.",
            f"Both are nearer than either at {of_all} of {many} steps.",
            of_all > many / 2,
            "At steps from 10⁻⁴ s on the error of C passes through zero, and is small by that.",
        ),
    )


def _figure(numbers: Numbers, quantity: str, name: str, title: str) -> Figure:
    dt, size = np.asarray(numbers["steps"]), _sizes(numbers, quantity)
    series = [Series(model.name, dt, size[model.name], model.style, "both") for model in MODELS]
    values = np.concatenate(list(size.values()))
    axes = logarithmic(float(dt.min()) / 1.3, float(dt.max()) * 1.3), logarithmic(float(values[values > 0].min()) / 2.0, float(values.max()) * 2.0)
    label = f"{title}: {'; '.join(f'{one.name} from {one.y[0]:.1e} to {one.y[-1]:.1e}' for one in series)}"
    caption = f"Relative error of {quantity} over the step size, in seconds. F, P and P mended lie on one another."
    return Figure(name, caption, chart(title, label, series, axes, ("step [s]", "relative error"), ()))


def sliding_findings(numbers: Numbers) -> tuple[Finding, Finding]:
    """Figures 10 and 11."""
    exact = numbers["exact"]
    speed = exact["d'"]
    set_up = (
        f"Three spheres of radius {RADIUS:g} m, no friction, restitution 0.7, stiffnesses that go with dt⁻² as in table 2. Closed form: "
        f"k = {exact['k']:.16g}, d' = {speed:.16g}, T0 = {exact['T0']:.16g} s."
    )
    findings = []
    for number, quantity, said in ((10, "d'", "final speed"), (11, "T0", "time of parting")):
        errors = np.column_stack([numbers["errors"][m.name][quantity] for m in MODELS])
        rows = tuple((scientific(float(dt)), *row) for dt, row in zip(numbers["steps"], errors.tolist(), strict=True))
        table = Table(f"Relative error of {quantity}", ("Step [s]", *(model.name for model in MODELS)), rows)
        figure = _figure(numbers, quantity, f"figure-{number}", f"{said} {quantity}")
        kept = {"steps": numbers["steps"], "exact": exact, "errors": {m.name: numbers["errors"][m.name][quantity] for m in MODELS}}
        findings.append(Finding(f"Figure {number}: sliding, {said}", sliding_claims(numbers, quantity), set_up, (figure,), (table,), kept))
    return findings[0], findings[1]

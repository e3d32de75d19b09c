"""Reports made by hand, one for each way a comparison can end."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from demverify.compare import Check, Tolerances, explain, not_judged, verdict
from demverify.report.html import DifferenceCurve, EnergySeries, EngineInfo, Report, difference_curves

NATIVE_LAMMPS, NATIVE_LIGGGHTS, LAMMPS_LIGGGHTS = ("native", "lammps"), ("native", "liggghts"), ("lammps", "liggghts")
PAIRS = (NATIVE_LAMMPS, NATIVE_LIGGGHTS, LAMMPS_LIGGGHTS)
QUANTITIES = ("force", "torque", "position", "velocity", "omega")


@dataclass(frozen=True)
class Known:
    """An entry of the register."""

    id: str
    what: str
    engine: str = "liggghts"
    version: str = "3.8.0"
    size: str = "2e-6 of the largest force after a contact reopens"
    link: str = "https://example.org/thread?a=1&b=2"


SETTINGS = [
    (
        "pair_style",
        "gran/hooke/history 2e5 NULL 50 NULL 0.5 1",
        "gran model hooke tangential history",
        "linear spring, history, Coulomb limit",
    ),
    ("kn", "200000", "kn 2e5 (hooke/stiffness)", "normal stiffness 2e5"),
    ("gamma_n", "50 (per effective mass)", "gamman 50 absolute_damping off", "normal damping 50 m*"),
    ("neighbor", "0.1 bin", "0.1 bin", "skin 0.1"),
    ("fix gravity", "1.0 chute 22.0", "1.0 chute 22.0", "(0.3746, 0, -0.9272)"),
]
ENGINES = {
    "native": EngineInfo("0.1.0", 1.842, 4.31e6),
    "lammps": EngineInfo("22 Jul 2025", 2.105, 3.02e6),
    "liggghts": EngineInfo("3.8.0", 4.77, 1.29e6),
}


def energies(noise=0.0, last=10_000, budget=True):
    """Energies of a packing that falls and comes to rest."""
    step = np.linspace(0, last, 201)
    t = step * 1e-5
    ke = 2.4e-3 * np.exp(-((t - 0.02) ** 2) / 1.2e-4) + 1e-5
    erotate = 3.1e-4 * np.exp(-((t - 0.035) ** 2) / 3e-4)
    ripple = 1 + noise * np.sin(400 * t)
    values = {"ke": ke * ripple, "erotate": erotate * ripple}
    if budget:
        fall = 5e-3 * np.exp(-t / 0.02)
        values |= {"elastic": 4e-4 * (1 - np.exp(-t / 0.03)), "gravitational": fall}
        values |= {"dissipated": 5.4e-3 - ke - erotate - fall - values["elastic"]}
    return EnergySeries(step, t, values)


def grown(step, rate, start=3e-16, top=0.4):
    """An exponential that saturates."""
    free = start * np.exp(np.minimum(rate * step, 60))
    return free * top / (free + top)


def checks_of(pair, steps, rates, factor=1.0, tolerances=None):
    """Checks along exponential growth, some excused as chaos."""
    tolerances, made = tolerances or Tolerances(), []
    rng = np.random.default_rng(len(pair[0]) + 7 * len(pair[1]))
    for step in steps:
        tier = 1 if step == 0 else 2 if step <= 200 else 3
        for name in QUANTITIES:
            size = {"force": 1.0, "torque": 0.4, "position": 2e-3, "velocity": 0.1, "omega": 0.2}[name]
            value = float(factor * size * grown(step, rates) * rng.uniform(0.4, 1.6))
            limit = tolerances.pointwise(tier)
            outcome = "pass" if value <= limit else "skipped" if factor < 100 else "fail"
            reason = {
                "pass": "",
                "skipped": f"chaos: one unit in the last place has grown to {value / 1.3:.1e} here, the difference says nothing",
                "fail": f"largest at particle 7; not chaos: one unit in the last place has grown to {value / factor:.1e} here",
            }[outcome]
            made.append(Check(name, pair, int(step), value * 0.12, value, limit, outcome, reason, tier))
        if tier == 3:
            for name in ("number", "mean_speed", "ke", "erotate", "com_z"):
                value = 0.0 if name == "number" else float(2e-2 * grown(step, rates) * rng.uniform(0, 1))
                made.append(Check(name, pair, int(step), value * 1e-3, value, 1e-2, "pass", "", 3))
    return made


def report(checks, title, *, engines=None, series=None, rates=2.3e-3, entries=(), last=10_000):
    """A whole report around these checks."""
    steps = np.unique([c.step for c in checks] or [0]).astype(float)
    envelope = [
        DifferenceCurve(("native", "native"), q, steps, {"torque": 0.5}.get(q, 1.0) * grown(steps, rates)) for q in QUANTITIES
    ]
    return Report(
        title=title,
        verdict=verdict(checks),
        checks=checks,
        engines=engines or ENGINES,
        series={name: energies(0.0, last, budget=name == "native") for name in ENGINES} if series is None else series,
        differences=difference_curves(checks),
        envelope=envelope if len(steps) > 1 else (),
        settings=SETTINGS,
        entries=entries,
        command="git clone https://example.org/demverify && cd demverify\ndemverify compare inputs/bed",
    )


def passing():
    """Everything agrees, chaos far away."""
    laws = [Check("restitution", ("native", "closed form"), 800, 1.2e-9, 1.4e-9, 1e-6, "pass", kind="law")]
    steps = [0, 1, 2, 5, *range(10, 201, 10)]
    return report([c for p in PAIRS for c in checks_of(p, steps, 0.02)] + laws, "inputs/bed", rates=0.02, last=200)


def chaos():
    """A long run: chaos late, bulk judged."""
    steps = [0, 50, 100, 200, *range(500, 10_001, 250)]
    return report([c for p in PAIRS for c in checks_of(p, steps, 4e-3)], "bench/in.chute", rates=4e-3)


def failing():
    """LIGGGHTS computes something else; one entry explains it."""
    steps = [0, 50, 100, 200, *range(500, 10_001, 250)]
    good = checks_of(NATIVE_LAMMPS, steps, 2e-4)
    bad = [c for p in (NATIVE_LIGGGHTS, LAMMPS_LIGGGHTS) for c in checks_of(p, steps, 2e-4, factor=3e9)]
    entries = [
        Known(
            "liggghts-history",
            "LIGGGHTS keeps the tangential history of a pair after it parted, until the next rebuild of its list.",
        )
    ]
    series = {name: energies(0.3 if name == "liggghts" else 0.0, budget=name == "native") for name in ENGINES}
    return report(explain(good + bad, entries), "in.hopper <final>", rates=2e-4, entries=entries, series=series)


def skipped():
    """LIGGGHTS is not installed."""
    engines = ENGINES | {"liggghts": EngineInfo("", status="skipped", reason="not installed: apt-get install liggghts")}
    gone = [
        not_judged("all", p, "skipped", "liggghts is not installed: apt-get install liggghts")
        for p in (NATIVE_LIGGGHTS, LAMMPS_LIGGGHTS)
    ]
    one_state = checks_of(NATIVE_LAMMPS, [0], 0.0)
    return report(
        one_state + gone,
        "inputs/two_spheres_hertz",
        engines=engines,
        series={"native": energies(budget=False), "lammps": energies(budget=False)},
    )


def crashed():
    """LAMMPS died; its last words are shown."""
    log = "ERROR: Lost atoms: original 1000 current 998\n(src/thermo.cpp:494)\nLast input line: run 10000"
    engines = ENGINES | {"lammps": EngineInfo("22 Jul 2025", 0.31, None, "crashed", log)}
    dead = [not_judged("all", p, "crashed", f"lammps: {log}") for p in (NATIVE_LAMMPS, LAMMPS_LIGGGHTS)]
    alive = checks_of(NATIVE_LIGGGHTS, [0, 50, 100, 150, 200], 0.02)
    series = {"native": energies(last=200), "liggghts": energies(budget=False, last=200)}
    return report(dead + alive, "inputs/bed", engines=engines, series=series, rates=0.02)


def nothing():
    """Nothing could be judged."""
    engines = {"native": ENGINES["native"]} | {
        name: EngineInfo("", status="skipped", reason=f"not installed: install {name}") for name in ("lammps", "liggghts")
    }
    gone = [not_judged("all", p, "skipped", f"{p[1]} is not installed") for p in PAIRS]
    return replace(report(gone, "inputs/bed", engines=engines, series={}), settings=(), command="")


ALL = {f.__name__: f for f in (passing, chaos, failing, skipped, crashed, nothing)}


@pytest.fixture(params=ALL)
def any_report(request):
    """Each of the reports."""
    return ALL[request.param]()


@pytest.fixture(scope="session")
def reports():
    """Name -> report."""
    return {name: make() for name, make in ALL.items()}

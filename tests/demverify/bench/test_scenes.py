"""Scenes of the bench: their references against closed forms or against each other, their decks, and the run with --quick."""

from __future__ import annotations

from importlib import import_module
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from demverify import bench, cli
from demverify.bench import bouncing_sphere, damped_stack, elastic_gas, free_top, oblique_impact, settling_bed, slip_to_rolling
from demverify.bench._contenders import Problem, _engine_states, scene_of
from demverify.bench._ode import Spheres, solved
from demverify.errors import InputError
from demverify.laws.falling_contact import _Contact
from demverify.studies import unexplained

MASS, RADIUS = 2500.0 * 4.0 / 3.0 * pi * 0.005**3, 0.005


def problem_of(name: str, k: int = 0) -> Problem:
    """The k-th problem of a scene, as --quick has it."""
    found: Problem = import_module(f"demverify.bench.{name}").problems(True)[k]
    return found


def test_the_folder_is_the_listing() -> None:
    """Law: every module is a scene with a title and problems of its own; each has decks for the engines that contend."""
    assert "bouncing_sphere" in bench.listing()
    for name in bench.listing():
        module = import_module(f"demverify.bench.{name}")
        assert module.TITLE
        for problem in module.problems(True):
            wanted = {one.engine for one in module.problems(False)[0].contenders if not one.solve}
            assert all(problem.deck(engine).is_file() for engine in wanted)
            assert len({one.style for one in problem.contenders}) == len(problem.contenders) <= 6


@pytest.mark.parametrize("name", bench.listing())
def test_full_runs_have_eight_steps_over_a_decade(name: str) -> None:
    """Law: the full bench takes at least 8 sizes of the step over more than a decade, and ends on the duration exactly."""
    module = import_module(f"demverify.bench.{name}")
    for problem in module.problems(False):
        assert len(problem.shares) >= 8
        assert problem.shares[0] / problem.shares[-1] > 10.0
        assert all(problem.steps(share) % problem.instants == 0 for share in problem.shares)


def test_an_unknown_scene_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Law: one line that names the word and what exists, status 2, nothing written."""
    with pytest.raises(InputError, match=r"scene 'top' is not one of bouncing_sphere"):
        bench.check(["top"])
    monkeypatch.setattr("sys.argv", ["demverify", "bench", "accuracy", "top", "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_contact_time_of_a_spring_under_gravity() -> None:
    """Law: the integral over the depth is the time that the closed form of the oscillator gives."""
    exact = _Contact(sqrt(1e4 / MASS), 0.0, 9.81, 0.3).duration
    assert bouncing_sphere.contact_time(0.3, MASS, RADIUS, "hooke", 9.81) == pytest.approx(exact, rel=1e-12)


def test_contact_time_of_hertz() -> None:
    """Law: without gravity Hertz' contact takes 2.9432... (m/k)^(2/5) v^(-1/5) (5/4)^(2/5), the integral of du/sqrt(1 - u^(5/2)) twice."""
    from scipy.special import gamma

    deepest = (1.25 * MASS * 0.3**2 / (1e7 * sqrt(RADIUS))) ** 0.4
    exact = 2.0 * deepest / 0.3 * sqrt(pi) * gamma(1.4) / gamma(0.9)
    assert bouncing_sphere.contact_time(0.3, MASS, RADIUS, "hertz", 0.0) == pytest.approx(exact, rel=1e-12)


def test_a_slow_slide_is_sliding_throughout() -> None:
    """Law: where friction cannot stop the slip, it takes mu times the normal momentum, 7/2 of it from the slip (MFIX-DEM DEM-05)."""
    assert oblique_impact.rebound(MASS, 1.0, 10.0) == pytest.approx(10.0 - 3.5 * oblique_impact.FRICTION * 2.0, rel=1e-12)


def test_the_oblique_reference_against_a_fine_run_of_its_equations() -> None:
    """Law: stepping the equations of stick and slip by a small midpoint step leads to the piecewise closed form."""
    vn, slip = 0.8, 0.5
    w2, limit = oblique_impact.KN / MASS, oblique_impact.FRICTION * oblique_impact.KN / oblique_impact.KT
    n = 100_000
    dt = pi / sqrt(w2) / n
    s, u = 0.0, slip
    for k in range(n):  # kick, drift and cut, kick: s belongs to the end of a step
        d = vn / sqrt(w2) * np.sin(sqrt(w2) * (k + 1) * dt)
        u -= 0.5 * dt * 3.5 * oblique_impact.KT / MASS * s
        s = float(np.clip(s + dt * u, -limit * d, limit * d))
        u -= 0.5 * dt * 3.5 * oblique_impact.KT / MASS * s
    assert oblique_impact.rebound(MASS, vn, slip) == pytest.approx(u, abs=1e-7)  # order dt^2 with kinks: 1e-9 measured


def test_slip_ends_in_rolling() -> None:
    """Law: winding up starts with the first slip, sliding takes 7/2 mu g, and angular momentum about the line of contact stays."""
    slip = slip_to_rolling.slip_at
    assert slip(0.0, 0.1, MASS) == pytest.approx(0.1, rel=1e-15)
    assert slip(5e-3, 0.1, MASS) == pytest.approx(0.1 - 3.5 * 0.3 * 9.81 * 5e-3, rel=5e-5)  # half of the winding, 7e-8 s, too much
    assert abs(slip(slip_to_rolling.DURATION, 0.1, MASS)) < 0.005


def test_the_chain_comes_to_rest_at_its_sag() -> None:
    """Law: after long the stack carries its weight: the topmost of n sinks by m g/k (1 + 2 + ... + n), and it begins at rest, falling with g."""
    z, v = damped_stack.sag(5, 10.0)
    assert z[-1] == pytest.approx(-damped_stack.MASS * 9.81 / damped_stack.KN * 15.0, rel=1e-9)
    assert np.abs(v).max() < 1e-12
    early, _ = damped_stack.sag(5, 1e-6)
    assert early == pytest.approx(np.full(5, -0.5 * 9.81e-12), rel=1e-2)  # dashpots have begun: gamma t = 4e-3


def test_the_equation_solver_against_the_chain() -> None:
    """Law: the general solver and the matrix exponential agree on a scene that both can do, to the tolerance of the solver."""
    problem = problem_of("damped_stack")
    scene = scene_of(problem, 1000)
    x, v = solved(Spheres.of(scene, 9.81), scene.particles.x, scene.particles.v, 0.005, 1e-10, 500)
    z, dz = damped_stack.sag(5, 0.005)
    assert x[:, 2] - scene.particles.x[:, 2] == pytest.approx(z, abs=1e-6 * np.abs(z).max())
    assert v[:, 2] == pytest.approx(dz, abs=1e-6 * np.abs(dz).max())


def test_energy_of_the_gas_knows_faces_and_springs() -> None:
    """Law: two spheres that overlap by d across a periodic face store kn d^2/2; with Hertz 2/5 kn sqrt(R*) d^(5/2)."""
    scene = scene_of(problem_of("elastic_gas"), 20)
    length = float((scene.box.hi - scene.box.lo)[0])
    x = np.array([[0.004, 0.03, 0.03], [length - 0.005, 0.03, 0.03]])  # 1 mm deep
    v = np.zeros((2, 3))
    assert elastic_gas.energy(x, v, scene, "hooke") == pytest.approx(0.5 * 1e4 * 1e-6, rel=1e-9)
    assert elastic_gas.energy(x, v, scene, "hertz") == pytest.approx(0.4 * 1e7 * sqrt(0.0025) * 1e-3**2.5, rel=1e-9)


def test_eight_gases_are_one_gas_eight_times() -> None:
    """Law: the large gas has eight times the particles and the energy, and no new overlap at the seams."""
    scene = scene_of(problem_of("elastic_gas"), 20)
    large = elastic_gas.copied(scene)
    one, many = (elastic_gas.energy(s.particles.x, s.particles.v, s, "hooke") for s in (scene, large))
    assert len(large.particles.id) == 8 * len(scene.particles.id)
    assert many == pytest.approx(8.0 * one, rel=1e-12)


def test_the_kink_of_a_contact_cancels_over_whole_steps() -> None:
    """Law: a contact of a whole number of steps leaves as it entered; over all phases the error averages out; it falls with the square."""
    phase = bouncing_sphere.phases()
    assert np.abs(bouncing_sphere.kink(phase, 50.0)).max() < 1e-15
    error = bouncing_sphere.kink(phase, 50.5)
    assert abs(error.mean()) < 1e-3 * np.abs(error).max()
    assert np.abs(bouncing_sphere.kink(phase, 100.5)).max() == pytest.approx(np.abs(error).max() * (50.5 / 100.5) ** 2, rel=1e-12)


def test_bulk_figures_of_a_bed() -> None:
    """Law: contacts are the pairs nearer than their radii, the nearest image sideways and none upwards, twice; the floor's once."""
    scene = scene_of(problem_of("settling_bed"), 1000)
    p, length = scene.particles, 0.06
    x = np.random.default_rng(5).uniform([-0.01, -0.01, 0.001], [0.07, 0.07, 0.11], (225, 3))
    d = x[:, None] - x[None]
    d[..., :2] -= length * np.round(d[..., :2] / length)
    touch = np.linalg.norm(d, axis=2) < p.radius[:, None] + p.radius
    height, contacts = settling_bed.bulk(x, scene)
    assert contacts == pytest.approx((touch.sum() - 225 + (x[:, 2] < p.radius).sum()) / 225, rel=1e-15)
    assert height == pytest.approx(float(np.average(x[:, 2], weights=p.mass)), rel=1e-14)


@pytest.mark.lammps
@pytest.mark.parametrize(("name", "shown"), [("richardson", "LAMMPS rigid"), ("no_squish", "LAMMPS rigid/nve")])
def test_rigid_bodies_of_lammps_are_schemes_here(name: str, shown: str) -> None:
    """Law: fix rigid is Richardson's scheme and fix rigid/nve NO_SQUISH: 1,500 steps of a fortieth of a radian later all is alike."""
    problem = free_top.problems(False)[0]
    contender = next(one for one in problem.contenders if one.name == shown)
    theirs, ours = _engine_states(problem, contender, 1500), free_top.solve(name, 1500)[0]
    assert theirs is not None
    for one, other in zip(theirs, ours, strict=True):
        assert one.x == pytest.approx(other.x, abs=1e-10 * 0.02)
        assert one.v == pytest.approx(other.v, abs=1e-10)  # of 1 m/s: roundings of 1,500 steps


@pytest.mark.parametrize("name", bench.listing())
def test_quick(name: str) -> None:
    """Law: every statement of the quick bench comes out or has its reason, every contender has times, and something is on every front."""
    told: list[float] = []
    study = bench.run(name, True, lambda what, share: told.append(share))
    assert unexplained(study) == []
    assert told == sorted(told)
    assert told[-1] == 1.0
    for finding in study.findings:
        rows = [row for row in finding.numbers.values() if "front" in row]
        assert all(np.isfinite(row["wall time per simulated second"]).any() for row in rows)
        assert not rows or any(np.any(row["front"]) for row in rows)

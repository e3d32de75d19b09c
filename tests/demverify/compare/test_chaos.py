"""The chaos envelope, on a system whose exponential growth is known: Chirikov's standard map.

p' = p + K sin x, x' = x + p' (mod 2 pi), one map a particle. Rounding grows by about K/2 a step for large K; the force
K sin x is what an engine computes, and one that computes it in another order of operations multiplies it by 1 + a few 1e-16.
"""

from __future__ import annotations

import numpy as np
import pytest

from demverify.chaos import FACTOR, Envelope, nudge
from demverify.compare import TIER1, TIER2, compare_scalars, compare_series, verdict
from demverify.differences import bulk, bulk_spread
from demverify.frames import Frame, Thermo

PAIR = ("native", "lammps")
N, EVERY = 200, 10
TWO_PI = 2 * np.pi


def run(x, steps=60, kick=2.5, force=lambda f, step: f):
    """Frames of N maps in a periodic box of 2 pi, one iteration called EVERY steps; `force` may spoil the force."""
    p, frames = np.zeros_like(x), []
    for step in range(0, steps * EVERY, EVERY):
        f = force(kick * np.sin(x), step)
        columns = {"id": np.arange(1.0, N + 1), "mass": np.ones(N), "radius": np.ones(N)}
        columns |= {
            name: values
            for names, v in (("xyz", x), (("vx", "vy", "vz"), p), (("fx", "fy", "fz"), f))
            for name, values in zip(names, v.T, strict=True)
        }
        frames.append(Frame(step, np.array([[0.0, TWO_PI]] * 3), ("pp", "pp", "pp"), columns))
        p = p + f
        x = np.mod(x + p, TWO_PI)
    return frames


def rounded(seed):
    """An engine that sums in another order: each force off by a unit in the last place, anew at every step."""
    rng = np.random.default_rng(seed)
    return lambda f, step: f * (1 + rng.integers(-1, 2, f.shape) * 2.2e-16)


@pytest.fixture(scope="module")
def start():
    """Positions all over the box."""
    return np.random.default_rng(5).uniform(0.1, 6.1, (N, 3))


@pytest.fixture(scope="module")
def native(start):
    """The run of the native engine."""
    return run(start)


@pytest.fixture(scope="module")
def envelope(start, native):
    """Its envelope."""
    return Envelope.from_frames(native, run(nudge(start)))


def of_force(checks):
    """Step -> check of the force."""
    return {check.step: check for check in checks if check.quantity == "force"}


def test_the_envelope_grows_exponentially_from_one_unit_in_the_last_place(envelope):
    """It starts at a few 1e-16, doubles or so a step over twelve decades, and ends at the size of the forces."""
    force = envelope.relative["force"]
    assert 0 < force[0] < 1e-15
    growing = force[(force > 1e-14) & (force < 1e-3)]
    assert np.polyfit(np.arange(len(growing)), np.log(growing), 1)[0] > 0.3
    assert force[-1] > 0.1


@pytest.mark.parametrize("seed", range(5))
def test_engines_that_differ_by_rounding_agree(start, native, envelope, seed):
    """Growth of rounding is excused, at first by nothing, late as chaos; the bulk of what was excused is judged."""
    checks = compare_series(native, run(start, force=rounded(seed)), PAIR, envelope)
    force = of_force(checks)
    assert verdict(checks) == "pass"
    assert force[0].outcome == force[EVERY].outcome == "pass"
    last = force[max(force)]
    assert (last.outcome, last.reason.split(":")[0]) == ("skipped", "chaos")
    assert last.max_rel > 1e6 * TIER2
    assert {c.quantity for c in checks if c.step == last.step} >= {"ke", "mean_speed", "number"}


@pytest.mark.parametrize("seed", range(5))
def test_the_factor_is_not_used_up_by_rounding(start, native, envelope, seed):
    """Engines that differ by rounding stay within FACTOR envelopes at every step; the typical step needs a third of it."""
    force = of_force(compare_series(native, run(start, force=rounded(seed)), PAIR, envelope))
    above = [check.max_rel / envelope.at("force", step) for step, check in force.items() if check.max_rel > TIER2]
    assert above
    assert max(above) < FACTOR
    assert np.median(above) < FACTOR / 3


def test_a_systematic_error_cannot_hide_behind_the_envelope(start, native, envelope):
    """A force 1e-6 too large fails at the set-up and at every early step, as 'not chaos'; later excuses save nothing."""
    checks = compare_series(native, run(start, force=lambda f, step: f * (1 + 1e-6)), PAIR, envelope)
    force = of_force(checks)
    assert verdict(checks) == "fail"
    assert force[0].outcome == "fail"
    for step in (EVERY, 2 * EVERY, 3 * EVERY):
        assert force[step].outcome == "fail"
        assert "not chaos: one unit in the last place has grown to" in force[step].reason
    assert force[max(force)].outcome == "skipped"


def test_an_error_that_begins_after_the_set_up_is_rejected(start, native, envelope):
    """A term that acts from the second step on (history, friction) passes tier 1 and fails where it begins."""
    checks = compare_series(native, run(start, force=lambda f, step: f * (1 + 1e-6 * (step >= EVERY))), PAIR, envelope)
    force = of_force(checks)
    assert [force[0].outcome, force[EVERY].outcome] == ["pass", "fail"]


def test_an_error_in_one_particle_alone_is_rejected(start, native, envelope):
    """One force in 200, off by 1e-6 of the largest from the third step on, fails there."""
    spoil = np.zeros((N, 3))
    spoil[17, 1] = 2.5e-6
    checks = compare_series(native, run(start, force=lambda f, step: f + spoil * (step >= 2 * EVERY)), PAIR, envelope)
    check = of_force(checks)[2 * EVERY]
    assert check.outcome == "fail"
    assert check.reason.startswith("largest at particle 18; not chaos")


def test_a_late_error_of_bulk_figures_is_rejected(start, native, envelope):
    """Where every difference is chaos, kicks a fifth stronger still show in the energy."""
    strong = run(start, force=lambda f, step: f * (1.0 if step < 300 else 1.2))
    failed = {c.quantity for c in compare_series(native, strong, PAIR, envelope) if c.outcome == "fail" and c.step > 300}
    assert "ke" in failed


def test_without_chaos_late_differences_are_judged(start):
    """A regular motion (no kick to speak of) keeps its envelope at rounding: 1e-7 off at step 500 fails, in tier 3 too."""
    calm = {"kick": 1e-3, "steps": 60}
    native = run(start, **calm)
    envelope = Envelope.from_frames(native, run(nudge(start), **calm))
    late = run(start, force=lambda f, step: f * (1 + 1e-7 * (step >= 500)), **calm)
    checks = of_force(compare_series(native, late, PAIR, envelope))
    assert checks[500].tier == 3
    assert checks[500].outcome == "fail"
    assert "not chaos" in checks[500].reason
    assert verdict(compare_series(native, run(start, force=rounded(0), **calm), PAIR, envelope)) == "pass"


def test_tier_1_is_never_excused():
    """An accident at the set-up (two spheres that touch or not by one unit in the last place) excuses nothing there."""
    envelope = Envelope(np.array([0, 10, 20]), {"force": np.array([1.0, 1e-15, 1e-15])})
    start = np.full((N, 3), 1.0)
    off = run(start, steps=1, force=lambda f, step: f + 1e-3)
    assert of_force(compare_series(run(start, steps=1), off, PAIR, envelope))[0].outcome == "fail"


def test_the_envelope_is_a_maximum_over_the_younger_half():
    """Steps 11..20 at step 20; an accident at step 0 is forgotten at once, one at step 10 after step 20."""
    envelope = Envelope(np.array([0, 5, 10, 15, 20, 30]), {"force": np.array([9.0, 1e-9, 5.0, 1e-7, 1e-8, 1e-6])})
    assert [envelope.at("force", step) for step in (0, 5, 10, 19, 20, 29, 30)] == [9.0, 1e-9, 5.0, 5.0, 1e-7, 1e-7, 1e-6]


def test_the_envelope_excuses_nothing_that_it_did_not_measure():
    """Before its first step, for an unknown quantity, where empty and where the native run was not finite, it is 0."""
    envelope = Envelope(np.array([10, 20]), {"force": np.array([1.0, np.nan])})
    assert envelope.at("force", 5) == envelope.at("torque", 10) == envelope.at("force", 20) == 0.0
    assert Envelope.from_frames([], []).at("force", 0) == 0.0


def test_particles_that_leave_are_chaos_only_if_the_nudged_run_loses_them_too(native, start):
    """Other ids late in the run fail, unless the native run and its nudged twin also part in their ids."""

    def without(frames, last, after):
        cut = {k: v[: N - 1] for k, v in frames[0].columns.items()}
        assert len(cut["id"]) == N - 1
        return [
            f if f.step < after else Frame(f.step, f.box, f.boundary, {k: np.delete(v, last) for k, v in f.columns.items()})
            for f in frames
        ]

    whole = Envelope.from_frames(native, native)
    leaky = Envelope.from_frames(native, without(native, 7, 300))
    lost = without(native, 9, 300)
    assert leaky.at("force", 300) == np.inf
    assert verdict(compare_series(native, lost, PAIR, whole)) == "fail"
    checks = compare_series(native, lost, PAIR, leaky)
    assert {c.outcome for c in checks if c.quantity == "ids"} == {"skipped"}
    assert "number" in {c.quantity for c in checks if c.step == 300}


def test_a_bulk_figure_is_skipped_where_its_own_envelope_swallows_it():
    """Thermo values 50 % apart: fail alone, pass within five envelopes of 12 %, skipped where the envelope is 100 %."""

    def table(value):
        return Thermo(("Step", "ke"), np.array([[0.0, value]]))

    def judged(nudged):
        [check] = compare_scalars(table(1.0), table(0.5), PAIR, envelope=Envelope.from_thermo(table(1.0), table(nudged)))
        return check.outcome

    assert [judged(nudged) for nudged in (1.0, 0.88, 0.0)] == ["fail", "pass", "skipped"]


def test_nudging_moves_each_coordinate_by_one_unit_in_the_last_place():
    """Up or down by exactly one unit, both occur, zero stays; the same seed moves alike."""
    x = np.random.default_rng(0).normal(0, 1, (500, 3))
    x[0] = 0.0
    moved = nudge(x)
    steps = (moved - x) / np.spacing(np.abs(np.minimum(np.abs(x), np.abs(moved)))) * np.sign(x)
    assert set(steps[1:].ravel()) == {-1.0, 1.0}
    assert (moved > x).any() and (moved < x).any() and (moved[x > 0] < x[x > 0]).any()
    assert (moved[0] == 0).all()
    assert (nudge(x) == moved).all()


def test_the_tiers_are_as_promised():
    """1e-12 of the largest force at the set-up, 1e-9 up to 200 steps: the limits the README promises."""
    assert (TIER1, TIER2) == (1e-12, 1e-9)


def test_the_spread_of_a_bulk_figure_is_not_small_by_accident(make, replaced):
    """Two speeds that change by +1 and -1 leave their mean alone; the spread is sqrt(2)/n all the same."""
    still = make(v=np.tile([10.0, 0.0, 0.0], (20, 1)))
    speeds = still.columns["vx"].copy()
    speeds[:2] += [1.0, -1.0]
    a, b, c = (
        bulk(frame)["mean_speed"] for frame in (still, replaced(still, vx=speeds), replaced(still, vx=still.columns["vx"] + 1))
    )
    assert bulk_spread(a, b, floor=1.0) == pytest.approx(np.sqrt(2) / 20 / 10)
    assert bulk_spread(a, c, floor=1.0) == pytest.approx(1 / 11)
    assert a.value == b.value


def test_bulk_figures_are_what_they_say(make):
    """ke, erotate and the centre of mass of two spheres, by hand."""
    v, w, x = [[3.0, 4.0, 0.0], [0.0, 0.0, 1.0]], [[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]], [[0.1, 0.2, 0.3], [0.5, 0.2, 0.9]]
    frame = make(n=2, v=v, w=w, x=x, boundary=("pp", "ff", "fs"))
    mass, radius = frame.columns["mass"], frame.columns["radius"]
    figures = bulk(frame)
    assert figures["number"].value == 2
    assert figures["mean_speed"].value == pytest.approx(3.0)
    assert figures["ke"].value == pytest.approx(0.5 * (25 * mass[0] + mass[1]))
    assert figures["erotate"].value == pytest.approx(0.5 * 0.4 * mass[0] * radius[0] ** 2 * 4)
    assert "com_x" not in figures
    assert figures["com_z"].value == pytest.approx((0.3 * mass[0] + 0.9 * mass[1]) / mass.sum())
    assert figures["com_z"].floor == pytest.approx(0.6 + radius.max())

"""What the comparison of series, thermo tables and closed forms must accept, and what it must reject."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from demverify.compare import (
    Check,
    compare_law,
    compare_scalars,
    compare_series,
    exit_status,
    explain,
    not_judged,
    summary,
    verdict,
)
from demverify.differences import REST
from demverify.frames import Thermo

PAIR = ("native", "lammps")
STEPS = (0, 50, 200, 250)


@pytest.fixture
def series(make):
    """Four frames of one packing."""
    return [make(step=step, seed=step) for step in STEPS]


def tiers(checks):
    """Step -> tier of the force checks."""
    return {check.step: check.tier for check in checks if check.quantity == "force"}


def test_equal_series_agree_and_every_common_step_is_judged(series):
    """Step 0 is tier 1, up to 200 steps tier 2, later tier 3: there bulk figures too."""
    checks = compare_series(series, series, PAIR)
    assert verdict(checks) == "pass"
    assert tiers(checks) == {0: 1, 50: 2, 200: 2, 250: 3}
    assert {c.quantity for c in checks if c.step == 250} >= {"number", "ke", "erotate", "mean_speed", "com_x", "com_y", "com_z"}
    assert not {"ke", "number"} & {c.quantity for c in checks if c.step < 250}


def test_tiers_count_from_the_first_common_step(series):
    """A run that starts at step 1000 is set up there: tier 1."""
    late = [replace(frame, step=frame.step + 1000) for frame in series]
    assert tiers(compare_series(late, late, PAIR)) == {1000: 1, 1050: 2, 1200: 2, 1250: 3}


def test_a_truncated_series_is_rejected(series):
    """An engine that stopped early fails by name, though all that it wrote agrees."""
    [check] = [c for c in compare_series(series, series[:2], PAIR) if c.outcome == "fail"]
    assert (check.quantity, check.step, check.reason) == ("steps", 200, "lammps has no step 200, 250")
    assert verdict(compare_series(series[:2], series, PAIR)) == "fail"


def test_steps_that_do_not_match_are_rejected(series):
    """Frames of other steps are not compared with each other, and each side's gaps are named."""
    shifted = [replace(frame, step=frame.step + 1) for frame in series]
    checks = compare_series(series, shifted, PAIR)
    assert [c.quantity for c in checks] == ["steps", "steps"]
    assert {c.reason.split()[0] for c in checks} == {"native", "lammps"}
    assert verdict(checks) == "fail"


@pytest.mark.parametrize(("left", "right"), [(0, 0), (0, 4), (4, 0)])
def test_empty_series_are_rejected(series, left, right):
    """No frames at all is no agreement."""
    assert verdict(compare_series(series[:left], series[:right], PAIR)) == "fail"


def test_series_of_empty_frames_are_no_agreement(make):
    """Frames without particles have nothing in common, in no tier."""
    empty = [make(step=step, n=0) for step in STEPS]
    assert {c.outcome for c in compare_series(empty, empty, PAIR)} == {"skipped"}
    assert verdict(compare_series(empty, empty, PAIR)) == "fail"


def test_of_frames_with_one_step_the_last_counts(series, make):
    """A `run` boundary writes a step twice; the later one is judged."""
    twice = [make(step=50, seed=99), *series]
    assert verdict(compare_series(twice, series, PAIR)) == "pass"


def test_the_scale_is_the_largest_force_so_far(make):
    """After a blow of 1e3 N, 1e-9 N is 1e-12 of it: passes tier 2. Before the blow it is 1e-9 of 1 N: fails at 2e-9."""
    calm, blow = np.full((20, 3), 1.0), np.full((20, 3), 1e3)
    a = [make(step=0, f=calm), make(step=10, f=calm), make(step=20, f=blow), make(step=30, f=calm)]
    b = [a[0], make(step=10, f=calm + 4e-9), a[2], make(step=30, f=calm + 4e-9)]
    found = {c.step: c.outcome for c in compare_series(a, b, PAIR) if c.quantity == "force"}
    assert found == {0: "pass", 10: "fail", 20: "pass", 30: "pass"}


def test_nan_late_in_a_run_is_never_chaos(series, replaced):
    """A NaN in tier 3 fails even where no pointwise difference is judged, and so do the bulk figures that hold it."""
    speed = series[-1].columns["vx"].copy()
    speed[0] = np.nan
    checks = compare_series(series, [*series[:-1], replaced(series[-1], vx=speed)], PAIR)
    failed = {c.quantity for c in checks if c.outcome == "fail"}
    assert failed == {"velocity", "ke", "mean_speed"}


def test_without_envelope_late_differences_are_skipped_but_bulk_is_judged(series, make):
    """Two chaotic runs of one packing: other forces late are skipped; twice the speed shows in the energy, and fails."""
    other = make(step=250, seed=77, x=np.column_stack([series[-1].columns[c] for c in "xyz"]))
    still = replace(
        other,
        columns=other.columns
        | {c: series[-1].columns[c] for c in ("vx", "vy", "vz", "omegax", "omegay", "omegaz", "mass", "radius")},
    )
    late = [c for c in compare_series(series, [*series[:-1], still], PAIR) if c.step == 250]
    assert {c.outcome for c in late if c.quantity == "force"} == {"skipped"}
    assert verdict(late) == "pass"
    fast = replace(still, columns=still.columns | {c: 2 * still.columns[c] for c in ("vx", "vy", "vz")})
    failed = {c.quantity for c in compare_series(series, [*series[:-1], fast], PAIR) if c.outcome == "fail"}
    assert failed == {"ke", "mean_speed"}


def thermo(**columns):
    """A thermo table."""
    return Thermo(tuple(columns), np.column_stack([np.asarray(values, dtype=float) for values in columns.values()]))


def test_small_energies_off_by_half_are_rejected():
    """The trap of numpy.isclose: with its absolute 1e-8, energies of 1e-9 J always agree."""
    a, b = thermo(Step=[0, 10], KinEng=[1e-9, 2e-9]), thermo(Step=[0, 10], KinEng=[1e-9, 3e-9])
    assert [c.outcome for c in compare_scalars(a, b, PAIR)] == ["pass", "fail"]


@pytest.mark.parametrize("unit", [1.0, 1e-12, 1e-200, 1e200])
def test_units_change_no_thermo_verdict(unit):
    """Energies in any unit: 0.9 % apart passes, 1.1 % fails."""
    a, b = thermo(Step=[0, 1], ke=np.array([1, 1]) * unit), thermo(Step=[0, 1], ke=np.array([0.991, 0.989]) * unit)
    assert [c.outcome for c in compare_scalars(a, b, PAIR)] == ["pass", "fail"]


def test_thermo_columns_are_matched_by_name_and_gaps_named():
    """Columns go by name, whatever their order; one that an engine lacks is skipped by name; timings are not compared."""
    a = thermo(Step=[0], CPU=[1.0], ke=[3.0], rot=[5.0], press=[7.0])
    b = thermo(rke=[5.0], ke=[3.0], Step=[0], CPU=[9.0])
    checks = compare_scalars(a, b, PAIR)
    assert {c.quantity: c.outcome for c in checks} == {"ke": "pass", "rot": "skipped", "press": "skipped", "rke": "skipped"}
    assert next(c.reason for c in checks if c.quantity == "rke") == "native printed no column rke"
    [check] = compare_scalars(a, b, PAIR, columns={"erotate": ("rot", "rke")})
    assert (check.quantity, check.outcome) == ("erotate", "pass")


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_thermo_values_that_are_not_finite_are_rejected(bad):
    """NaN in both tables alike is no agreement."""
    table = thermo(Step=[0, 1], ke=[1.0, bad])
    assert [c.outcome for c in compare_scalars(table, table, PAIR)] == ["pass", "fail"]


def test_thermo_steps_that_do_not_match_are_rejected():
    """A table that ends early fails, though its rows agree."""
    checks = compare_scalars(thermo(Step=[0, 10], ke=[1.0, 1.0]), thermo(Step=[0], ke=[1.0]), PAIR)
    assert [(c.quantity, c.outcome) for c in checks] == [("steps", "fail"), ("ke", "pass")]


def test_a_floor_keeps_rounding_from_being_measured_against_itself():
    """Rotational energy of a frictionless scene: 0 against 1e-36 J fails alone, and passes against the rest of 1 J."""
    a, b = thermo(Step=[0], erotate=[0.0]), thermo(Step=[0], erotate=[1e-36])
    assert [c.outcome for c in compare_scalars(a, b, PAIR)] == ["fail"]
    assert [c.outcome for c in compare_scalars(a, b, PAIR, floors={"erotate": REST})] == ["pass"]


def test_a_table_without_steps_is_named():
    """A thermo table without the column Step cannot be matched."""
    with pytest.raises(ValueError, match="without the column Step: ke"):
        compare_scalars(thermo(ke=[1.0]), thermo(Step=[0], ke=[1.0]), PAIR)


def test_a_closed_form_is_a_law_and_has_its_own_tolerance():
    """Engine against law: its own kind and tolerance; zero needs a scale; NaN fails."""
    good = compare_law("restitution", "native", 0.8999, 0.9, 1e-3)
    assert (good.kind, good.engines, good.outcome, good.tolerance) == ("law", ("native", "closed form"), "pass", 1e-3)
    assert good.max_rel == pytest.approx(1e-4 / 0.9)
    assert compare_law("restitution", "native", 0.88, 0.9, 1e-3).outcome == "fail"
    assert compare_law("slip", "native", 1e-9, 0.0, 1e-3).outcome == "fail"
    assert compare_law("slip", "native", 1e-9, 0.0, 1e-3, scale=1.0).outcome == "pass"
    assert compare_law("restitution", "native", np.nan, 0.9, 1e-3).outcome == "fail"
    assert compare_law("restitution", "native", 0.9, np.nan, 1e-3).outcome == "fail"


def made(outcome, **changes):
    """A check with this outcome."""
    return replace(Check("force", PAIR, 0, 1.0, 0.5, 1.0, outcome), **changes)


@pytest.mark.parametrize(
    ("outcomes", "expected", "status"),
    [
        (["pass"], "pass", 0),
        (["pass", "skipped"], "pass", 0),
        (["pass", "fail"], "fail", 1),
        (["pass", "crashed"], "fail", 3),
        (["fail", "crashed"], "fail", 3),
        (["skipped"], "fail", 1),
        ([], "fail", 1),
    ],
)
def test_verdict_and_exit_status(outcomes, expected, status):
    """Skipped alone is no agreement, one failure is enough, a crash goes first."""
    checks = [made(outcome) for outcome in outcomes]
    assert (verdict(checks), exit_status(checks)) == (expected, status)


def test_the_summary_says_what_decided():
    """One sentence: the first failure, the crash, or why nothing was judged."""
    early, late = made("fail", step=10, quantity="torque"), made("fail", step=90)
    assert summary([made("pass"), late, early]) == "1 of 3 checks agree; first off at step 10: torque of native and lammps."
    crash = not_judged("force", PAIR, "crashed", "lammps: lost atoms\nlast line of the log")
    assert summary([made("pass"), crash]) == "lammps: lost atoms; 1 of 1 checks agree."
    missing = not_judged("force", PAIR, "skipped", "lammps is not installed")
    assert summary([missing]) == "Nothing was judged, so nothing agrees: lammps is not installed."
    assert summary([]) == "Nothing was judged, so nothing agrees."
    assert summary([made("pass", max_rel=0.1), made("pass", step=7), missing]) == (
        "All 2 checks agree, 1 skipped; closest to its limit: force at step 7."
    )


@dataclass(frozen=True)
class Known:
    """An entry of a register, as far as `explain` needs it."""

    id: str
    what: str


def test_known_deviations_are_named_where_engines_differ():
    """Failing checks of engine against engine name the entry, keep their own reason and still fail; others stay as they are."""
    checks = [
        made("fail", reason="largest at particle 3"),
        made("pass"),
        made("fail", kind="law"),
        made("skipped"),
    ]
    named = explain(checks, [Known("D7", "keeps history")])
    assert named[0].reason == "largest at particle 3; explained by D7: keeps history"
    assert named[1:] == checks[1:]
    assert verdict(named) == "fail"


def test_every_deviation_that_applies_is_named():
    """Two entries are both named, in their order; a check without a reason gets theirs."""
    [check] = explain([made("fail")], [Known("G1", "one"), Known("L2", "two")])
    assert check.reason == "explained by G1: one; explained by L2: two"


def test_energies_that_died_down_are_still_judged(make):
    """A thousandth of the energy is left, and one engine has half as much: fails. Of 1e-15 of it, that is rest: passes."""
    still, fast = np.zeros((20, 3)), np.tile([1.0, 0.0, 0.0], (20, 1))
    for speed, expected in ((0.03, "fail"), (3e-8, "pass")):
        a = [make(step=0, v=fast, w=still), make(step=300, v=speed * fast, w=still)]
        b = [a[0], make(step=300, v=0.7 * speed * fast, w=still)]
        [check] = [c for c in compare_series(a, b, PAIR) if c.quantity == "ke"]
        assert check.outcome == expected

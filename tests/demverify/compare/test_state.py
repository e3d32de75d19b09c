"""What the comparison of two states must accept, and what it must reject."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demverify.compare import TIER1, Check, compare_state, nearest, verdict
from demverify.differences import QUANTITIES, Scales

PAIR = ("native", "lammps")


def outcome(checks, quantity):
    """Outcome of one quantity."""
    return {check.quantity: check.outcome for check in checks}[quantity]


def test_nearest_to_its_limit():
    """Law: the share of the limit decides, not the size; what was not measured comes last, and of a limit of zero the difference counts."""
    checks = [
        Check("q", PAIR, step, rel, rel, limit, "pass")
        for step, (rel, limit) in enumerate([(np.nan, np.nan), (1e-3, 1e-2), (5e-10, 1e-9), (1e-13, 1e-12), (0.2, 0.0)])
    ]
    assert [check.closeness for check in checks] == pytest.approx([-1.0, 0.1, 0.5, 0.1, 0.2])
    assert nearest(checks).step == 2
    assert nearest(checks[:1]).step == 0
    assert nearest([]) is None


def test_a_frame_agrees_with_itself(make):
    """Equal frames are 0 apart in every quantity, and that is judged, not skipped."""
    checks = compare_state(make(), make(), PAIR)
    assert [(c.quantity, c.outcome, c.max_abs, c.max_rel) for c in checks] == [(q, "pass", 0.0, 0.0) for q in QUANTITIES]


def test_the_order_of_rows_is_no_difference(make, replaced):
    """Rows are matched by id: the same particles in another order agree."""
    frame = make()
    turned = replaced(frame, **{name: values[::-1] for name, values in frame.columns.items()})
    assert verdict(compare_state(frame, turned, PAIR)) == "pass"


def test_rounding_of_a_sum_in_another_order_agrees(make, replaced):
    """Forces that differ by a few units in the last place pass tier 1."""
    frame = make()
    rounded = replaced(frame, **{c: frame.columns[c] * (1 + 4e-16) for c in QUANTITIES["force"]})
    assert verdict(compare_state(frame, rounded, PAIR)) == "pass"


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_a_sign_flip_is_rejected(make, replaced, quantity):
    """One component of one vector with the wrong sign fails its quantity, and no other."""
    frame, column = make(), QUANTITIES[quantity][1]
    checks = compare_state(frame, replaced(frame, **{column: -frame.columns[column]}), PAIR)
    assert [c.quantity for c in checks if c.outcome == "fail"] == [quantity]


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("side", ["first", "second", "both"])
def test_a_number_that_is_not_finite_is_rejected(make, replaced, quantity, bad, side):
    """NaN and inf fail on either side, on both alike, and name engine and particle; equal infinities are no agreement."""
    frame, column = make(), QUANTITIES[quantity][2]
    values = frame.columns[column].copy()
    values[6] = bad
    broken = replaced(frame, **{column: values})
    a, b = {"first": (broken, frame), "second": (frame, broken), "both": (broken, broken)}[side]
    [check] = [c for c in compare_state(a, b, PAIR, tolerance=np.inf) if c.outcome == "fail"]
    assert check.quantity == quantity
    assert check.reason == f"{PAIR[side == 'second']}: {quantity} not finite for particle 7"


def test_swapped_ids_are_rejected(make, replaced):
    """The same rows under two exchanged ids are other particles."""
    frame = make()
    ids = frame.columns["id"].copy()
    ids[[3, 4]] = ids[[4, 3]]
    assert {c.outcome for c in compare_state(frame, replaced(frame, id=ids), PAIR)} == {"fail"}


@pytest.mark.parametrize(
    ("ids", "words"),
    [
        ([1, 2, 4], "only native has particle 3; only lammps has particle 4"),
        ([1, 2], "only native has particle 3"),
        ([1, 2, 3, 4], "only lammps has particle 4"),
        ([1, 2, 2], "lammps holds particle 2 more than once"),
        ([], "only native has particles 1, 2, 3"),
    ],
)
def test_other_particles_are_rejected_by_name(make, replaced, ids, words):
    """Missing, extra and repeated ids fail, without an exception, and are named."""
    b = replaced(make(n=len(ids)), id=ids)
    [check] = compare_state(make(n=3), b, PAIR, tolerance=np.inf)
    assert (check.quantity, check.outcome, check.reason) == ("ids", "fail", words)


def test_many_missing_ids_are_counted(make):
    """Of many missing particles the first few are named, the rest counted."""
    [check] = compare_state(make(n=20), make(n=10), PAIR)
    assert check.reason == "only native has particles 11, 12, 13, 14, 15 and 5 more"
    assert (check.max_abs, check.max_rel) == (10.0, 0.5)


def test_frames_without_ids_are_rejected(make, replaced):
    """Without the column id there is no telling which particle is which."""
    [check] = compare_state(replaced(make(), id=None), make(), PAIR)
    assert (check.outcome, check.reason) == ("fail", "native wrote no column id: particles cannot be matched")


def test_two_empty_frames_are_no_agreement(make):
    """Nothing compared with nothing is skipped, and so the verdict is fail."""
    checks = compare_state(make(n=0), make(n=0), PAIR)
    assert [c.outcome for c in checks] == ["skipped"]
    assert verdict(checks) == "fail"


def test_a_missing_quantity_is_skipped_by_name(make, replaced):
    """A column that one engine did not write is never silently left out."""
    checks = compare_state(make(), replaced(make(), tqy=None, tqz=None), PAIR)
    [check] = [c for c in checks if c.outcome == "skipped"]
    assert (check.quantity, check.reason) == ("torque", "lammps wrote no tqy tqz")
    assert np.isnan(check.max_rel)


@settings(max_examples=60, deadline=None)
@given(row=st.integers(0, 19), axis=st.integers(0, 2), exponent=st.floats(-11.5, 2.0), sign=st.sampled_from([-1, 1]))
def test_one_force_off_by_more_than_the_limit_is_rejected(make, replaced, row, axis, exponent, sign):
    """One component of one particle, off by more than 1e-12 of the largest force, fails; the reason names the particle."""
    frame, column = make(), QUANTITIES["force"][axis]
    largest = np.sqrt(sum(frame.columns[c] ** 2 for c in QUANTITIES["force"])).max()
    values = frame.columns[column].copy()
    values[row] += sign * 10**exponent * largest
    [check] = [c for c in compare_state(frame, replaced(frame, **{column: values}), PAIR) if c.outcome != "pass"]
    assert (check.quantity, check.outcome, check.reason) == ("force", "fail", f"largest at particle {row + 1}")
    assert check.max_abs == pytest.approx(10**exponent * largest, rel=1e-3)


def test_the_largest_force_off_by_1e_9_is_rejected(make, replaced):
    """One particle's force off by 2e-9 of itself fails tier 1 and tier 2."""
    frame = make()
    force = np.column_stack([frame.columns[c] for c in QUANTITIES["force"]])
    force[np.argmax((force**2).sum(axis=1))] *= 1 + 2e-9
    off = replaced(frame, **dict(zip(QUANTITIES["force"], force.T, strict=True)))
    assert outcome(compare_state(frame, off, PAIR), "force") == "fail"
    assert outcome(compare_state(frame, off, PAIR, tolerance=1e-9, tier=2), "force") == "fail"


@settings(max_examples=40, deadline=None)
@given(
    mass=st.floats(1e-12, 1e12),
    length=st.floats(1e-12, 1e12),
    time=st.floats(1e-9, 1e9),
    error=st.sampled_from([0.0, 1e-14, 5e-13, 2e-12, 1e-6]),
    quantity=st.sampled_from([*QUANTITIES]),
)
def test_units_change_no_verdict(make, replaced, mass, length, time, error, quantity):
    """The same physics in other units of mass, length and time has the same relative differences and outcomes."""
    dimensions = {
        "force": mass * length / time**2,
        "torque": mass * length**2 / time**2,
        "position": length,
        "velocity": length / time,
        "omega": 1 / time,
    }

    def in_units(frame):
        columns = {c: frame.columns[c] * unit for name, unit in dimensions.items() for c in QUANTITIES[name]}
        columns |= {"radius": frame.columns["radius"] * length, "mass": frame.columns["mass"] * mass}
        return replace(replaced(frame, **columns), box=frame.box * length)

    a = make()
    column = QUANTITIES[quantity][0]
    b = replaced(a, **{column: a.columns[column] + error * getattr(Scales.of(a), quantity)})
    # Adding an error rounds at 1e-16 of the value, against 2e-12 at least of the scale: far from any limit's edge.
    here, there = compare_state(a, b, PAIR), compare_state(in_units(a), in_units(b), PAIR)
    assert [c.outcome for c in here] == [c.outcome for c in there]
    assert [c.max_rel for c in there] == pytest.approx(
        [c.max_rel for c in here], rel=1e-2, abs=3e-15 if quantity != "position" else 1e-12
    )


@pytest.mark.parametrize("factor", [1e-12, 1e-150, 1e150])
def test_forces_of_any_size_are_told_apart(make, replaced, factor):
    """Squares of 1e-150 N underflow: forces that small and of the wrong sign must fail all the same."""
    frame = make()
    small = replaced(frame, **{c: frame.columns[c] * factor for c in QUANTITIES["force"]})
    wrong = replaced(small, fx=-small.columns["fx"])
    assert outcome(compare_state(small, small, PAIR), "force") == "pass"
    assert outcome(compare_state(small, wrong, PAIR), "force") == "fail"


def test_torques_of_rounding_are_no_difference(make):
    """A frictionless scene: torques of 1e-17 F R in one engine alone are rounding, and so are spins of that size."""
    none, rounding = np.zeros((20, 3)), np.full((20, 3), 1e-17 * 1e-3)
    checks = compare_state(make(t=none, w=none), make(t=rounding, w=rounding * 1e3), PAIR)
    assert verdict(checks) == "pass"


def test_a_torque_in_one_engine_alone_is_rejected(make):
    """Friction that one engine leaves out: torques of 1e-4 N m against none fail, in either order."""
    still = make(t=np.zeros((20, 3)))
    assert outcome(compare_state(make(), still, PAIR), "torque") == "fail"
    assert outcome(compare_state(still, make(), PAIR), "torque") == "fail"


def test_small_friction_is_still_judged(make):
    """Friction of 1e-3 (torques of 1e-6 N m where F R is about 3e-3) that is off by 1 % fails tier 1 and tier 2."""
    torque = np.random.default_rng(3).normal(0, 1e-6, (20, 3))
    for tolerance in (TIER1, 1e-9):
        assert outcome(compare_state(make(t=torque), make(t=1.01 * torque), PAIR, tolerance), "torque") == "fail"


def test_all_zero_forces_agree_and_a_force_from_nothing_does_not(make):
    """0 against 0 passes; 1e-30 N against 0 has no scale but itself, and fails."""
    none, some = np.zeros((20, 3)), np.zeros((20, 3))
    some[4, 1] = 1e-30
    assert outcome(compare_state(make(f=none), make(f=none), PAIR), "force") == "pass"
    assert outcome(compare_state(make(f=none), make(f=some), PAIR), "force") == "fail"


def test_periodic_images_are_one_place(make):
    """x and x + L are one place where the box is periodic, and two where it is not; half a box is a difference in both."""
    x = np.random.default_rng(0).uniform(0.25, 0.5, (20, 3))
    for axis in range(3):
        boundary = tuple("pp" if k == axis else "ff" for k in range(3))
        cases = ((1.0, "pass", "fail"), (-2.0, "pass", "fail"), (0.5, "fail", "fail"), (1e-9, "fail", "fail"))
        for shift, periodic, open_box in (*cases, (1e-16, "pass", "pass"), (-1e-16, "pass", "pass")):
            there = x + shift * np.eye(3)[axis]
            assert (
                outcome(compare_state(make(x=x, boundary=boundary), make(x=there, boundary=boundary), PAIR), "position")
                == periodic
            )
            assert outcome(compare_state(make(x=x), make(x=there), PAIR), "position") == open_box


def test_a_box_printed_with_six_digits_is_no_difference(make):
    """LIGGGHTS prints bounds with %g: a particle wrapped by the exact length still is where it was."""
    x, length, periodic = np.full((20, 3), 0.25), 1.23456789, ("pp", "pp", "pp")
    exact = replace(make(x=x, boundary=periodic), box=np.array([[0.0, length]] * 3))
    printed = replace(make(x=x + length, boundary=periodic), box=np.array([[0.0, 1.23457]] * 3))
    assert outcome(compare_state(exact, printed, PAIR), "position") == "pass"
    assert outcome(compare_state(printed, exact, PAIR), "position") == "pass"


def test_velocity_rounding_of_a_bed_at_rest_is_no_difference(make):
    """A settled bed creeps at 1e-10 m/s; speeds of 1e-14 m/s more are rounding of the forces, 1e-6 m/s are not."""
    creep = np.full((20, 3), 1e-10)
    assert outcome(compare_state(make(v=creep), make(v=creep + 1e-15), PAIR), "velocity") == "pass"
    assert outcome(compare_state(make(v=creep), make(v=creep + 1e-6), PAIR), "velocity") == "fail"


def test_diameters_serve_as_radii(make, replaced):
    """A dump with diameters has the same scales as one with radii."""
    frame = make()
    other = replaced(frame, radius=None, diameter=2 * frame.columns["radius"])
    assert Scales.of(other) == Scales.of(frame)


def test_equal_values_pass_a_tolerance_of_zero(make):
    """What is equal to the last bit agrees under any limit."""
    assert verdict(compare_state(make(), make(), PAIR, tolerance=0.0)) == "pass"


def test_a_torque_is_measured_against_torques_where_friction_is_at_work(make):
    """Torques of a twentieth of F R, off by 3e-12 of the largest torque (1.5e-13 F R), fail tier 1."""
    direction = np.tile([1.0, 0.0, 0.0], (20, 1))
    force, torque = direction, 0.05e-3 * direction
    assert outcome(compare_state(make(f=force, t=torque), make(f=force, t=torque * (1 + 3e-12)), PAIR), "torque") == "fail"


def test_a_position_is_measured_against_the_radius(make):
    """Spheres of 1 mm, 0.3 m from the origin: off by 1e-14 m (1e-11 radii) fails, by one unit in the last place passes."""
    x = np.full((20, 3), 0.3)
    assert outcome(compare_state(make(x=x), make(x=x + 1e-14), PAIR), "position") == "fail"
    assert outcome(compare_state(make(x=x), make(x=np.nextafter(x, 1)), PAIR), "position") == "pass"


def test_a_coordinate_far_away_is_rounded(make):
    """1e4 radii from the origin one unit in the last place is 2e-12 radii, and still no difference."""
    x = np.full((20, 3), 10.0)
    assert outcome(compare_state(make(x=x), make(x=np.nextafter(x, 11)), PAIR), "position") == "pass"

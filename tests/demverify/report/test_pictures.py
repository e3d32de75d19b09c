"""Axes and pictures: a number lies where it should, and extremes are never thinned away."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demverify.compare import Check, Tolerances
from demverify.report import pictures
from demverify.report.axes import decades, linear, scientific, steps
from demverify.report.content import DifferenceCurve

ORDINARY = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1e-12, "10⁻¹²"),
        (3.2e-13, "3.2 \N{MULTIPLICATION SIGN} 10⁻¹³"),
        (0.25, "0.25"),
        (-0.25, "\N{MINUS SIGN}0.25"),
        (2e5, "2 \N{MULTIPLICATION SIGN} 10⁵"),
        (9.96e-13, "10⁻¹²"),
        (float("nan"), "\N{EN DASH}"),
        (float("inf"), "∞"),
    ],
)
def test_numbers_for_people(value, text):
    """Powers of ten are superscripts, round ones stand alone, what was not measured is a dash."""
    assert scientific(value) == text


@given(a=ORDINARY, width=st.floats(1e-3, 1e6))
def test_ticks_of_a_linear_axis_are_where_they_say(a, width):
    """Each label times the axis' power of ten is the value at its place, and all lie within the axis."""
    axis = linear(a, a + width)
    exponent = re.sub("[^⁻⁰¹²³⁴⁵⁶⁷⁸⁹]", "", axis.unit).translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    for place, label in axis.ticks:
        value = a + width * place
        assert -1e-6 <= place <= 1 + 1e-6
        assert float(label.replace("\N{MINUS SIGN}", "-")) * 10.0 ** int(exponent or 0) == pytest.approx(
            value, rel=1e-3, abs=width * 1e-3 + abs(a) * 1e-3
        )
    assert 2 <= len(axis.ticks) <= 12


def test_a_logarithmic_axis_is_linear_in_the_exponent():
    """10^-17 at the foot, 1 at the top, zero and what is smaller on the foot, what is larger at the top."""
    axis = decades(-17, 0)
    assert axis.place(np.array([1e-17, 10**-8.5, 1.0, 0.0, 1e-30, 50.0])) == pytest.approx([0, 0.5, 1, 0, 0, 1])
    assert axis.ticks[0] == (0.0, "0")
    assert {label: place for place, label in axis.ticks}["10⁻⁹"] == pytest.approx(8 / 17)


@pytest.mark.parametrize("last", [0, 1, 200, 1000, 1001, 10_000, 2_000_000, 10**9])
def test_an_axis_of_steps_covers_the_run(last):
    """From 0 at the left to the last step at the right, ascending, with a readable number of ticks."""
    axis = steps(last)
    places = [place for place, _ in axis.ticks]
    assert axis.place(np.array([0.0, max(last, 1.0)])) == pytest.approx([0, 1])
    assert places == sorted(places)
    assert 2 <= len(places) <= 16


def test_thinning_keeps_ends_and_extremes():
    """Of 10,000 points a few hundred stay, among them the first, the last, and a single spike."""
    x, y = np.arange(10_000.0), np.sin(np.arange(10_000) / 500)
    y[7321] = 5.0
    kept_x, kept_y = pictures.thinned(x, y)
    assert len(kept_x) < 400
    assert {0.0, 7321.0, 9999.0} <= set(kept_x)
    assert (np.diff(kept_x) > 0).all()
    assert kept_y.max() == 5.0


def curve(values, engines=("native", "lammps")):
    """A curve over steps 0, 10, 20 ..."""
    return DifferenceCurve(engines, "force", np.arange(0.0, 10 * len(values), 10), np.array(values))


def points(picture, name):
    """The points of the path of this class."""
    path = re.search(rf'<path (?:d="([^"]*)" class="{name}"|class="{name}" d="([^"]*)")', picture)
    return [tuple(map(float, pair)) for pair in re.findall(r"([\d.]+) ([\d.]+)", path[1] or path[2])]


def test_differences_lie_at_their_decade():
    """Equal ratios are equal heights; zero lies on the foot."""
    picture = pictures.difference_picture("force", {0: curve([1e-15, 1e-13, 1e-11, 0.0])}, None, [], Tolerances())
    heights = [y for _, y in points(picture, "p0")]
    assert heights[0] - heights[1] == pytest.approx(heights[1] - heights[2], abs=0.11)
    assert heights[0] > heights[1]
    assert heights[3] == pytest.approx(pictures.BOTTOM)


def test_a_failure_is_crossed_where_it_is():
    """The cross is centred on the point of the failing check."""
    line = curve([1e-15, 1e-5, 1e-4])
    check = Check("force", ("native", "lammps"), 10, 1.0, 1e-5, 1e-9, "fail")
    picture = pictures.difference_picture("force", {0: line}, None, [check], Tolerances())
    x, y = points(picture, "cross")[0]
    assert (x + 3.5, y + 3.5) == pytest.approx(points(picture, "p0")[1], abs=0.11)


def test_the_limit_rises_with_the_envelope():
    """Beyond tier 2 the limit is flat while ten envelopes are below it; after, it is one decade above their curve."""
    steps_of = np.arange(0.0, 1001, 100)
    envelope = DifferenceCurve(("native", "native"), "force", steps_of, 1e-16 * 10 ** (steps_of / 100))
    line = DifferenceCurve(("native", "lammps"), "force", steps_of, np.full(11, 1e-15))
    limit = points(pictures.difference_picture("force", {0: line}, envelope, [], Tolerances()), "limit late")
    edge = points(pictures.difference_picture("force", {0: line}, envelope, [], Tolerances()), "envelope-edge")
    decade = edge[-2][1] - edge[-1][1]
    assert limit[0][1] == limit[1][1]
    assert edge[-1][1] - limit[-1][1] == pytest.approx(decade, abs=0.3)


def test_a_gauge_shows_a_difference_beyond_its_limit():
    """The dot is right of the bar exactly if the difference is larger; nothing is drawn of what was not measured."""

    def places(max_rel):
        drawn = pictures.gauge(max_rel, 1e-9, "pass")
        return float(re.search(r'cx="([\d.]+)"', drawn)[1]), float(re.search(r'class="limit" x1="([\d.]+)"', drawn)[1])

    dot, bar = places(1e-12)
    assert dot < bar
    dot, bar = places(1e-6)
    assert dot > bar
    assert pictures.gauge(float("nan"), 1e-9, "skipped") == pictures.gauge(1e-3, float("nan"), "crashed") == ""

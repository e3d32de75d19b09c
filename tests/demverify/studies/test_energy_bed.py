"""The study of the elastic bed: small, but through the same code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demverify.studies import energy_bed
from demverify.studies.energy_bed import EXACT, STEPS, WAYS, Course, Told, bed, contact_time, follow, over_time


@pytest.fixture(scope="module")
def courses() -> list[Course]:
    """Every way and step, 30 spheres, 200 steps."""
    told = Told(lambda *_: None, 16)
    return [follow(way, step, bed(30), 200, told) for step in STEPS for way in WAYS]


def test_the_step_is_in_contact_times() -> None:
    """Law: a pair of spheres with the spring of the study is in contact for pi sqrt(m*/k): 6.5e-4 kg, 1e4 N/m."""
    assert contact_time() == pytest.approx(np.pi * np.sqrt(0.5 * 2500.0 * 4.0 / 3.0 * np.pi * 0.005**3 / 1e4), rel=1e-14)


def test_only_the_discrete_gradient_is_exact(courses: list[Course]) -> None:
    """Law: the discrete gradient keeps the energy at every step; Verlet and Euler do not, and break above their limit of 2/pi contact times."""
    for one in courses:
        if one.way.law == "discrete_gradient":
            assert one.worst < 1e-12  # rounding of 200 steps
        else:
            assert one.worst > 1e-7
        if one.step == 1.0 and one.way.law == "hooke":
            assert not np.isfinite(one.worst)


def test_a_drift_turns_the_verdict(courses: list[Course]) -> None:
    """Law: the claim of no drift is computed: a course of the exact way that drifts beyond the bound makes it false."""
    claim, mended = over_time(courses, 30, 200).claims
    assert claim.came_out
    assert not mended.came_out
    assert mended.why
    spoilt = [replace(one, change=one.change + 2.0 * EXACT) if one.way.law == "discrete_gradient" else one for one in courses]
    assert not over_time(spoilt, 30, 200).claims[0].came_out
    broken = [replace(one, change=np.full_like(one.change, np.nan)) if one.way.law == "discrete_gradient" else one for one in courses]
    assert not over_time(broken, 30, 200).claims[0].came_out


def test_the_picture_has_a_line_for_every_way_and_step(courses: list[Course]) -> None:
    """Law: sixteen lines, four names in the legend."""
    svg = energy_bed.picture(courses)
    assert svg.count("stroke-linejoin") == 16
    assert all(svg.count(f">{way.name}<") == 1 for way in WAYS)

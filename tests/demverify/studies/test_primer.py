"""The primer's study: its quick version runs whole, finds the slips there are and no others, and its numbers are those of closed forms."""

from __future__ import annotations

from math import isfinite

import numpy as np
import pytest

from demverify.studies import Study, run, unexplained
from demverify.studies._primer_bodies import whole
from demverify.studies._primer_friction import ENERGY, KT, LIMIT, REACH, led
from demverify.studies._primer_steps import largest, longest, trace_and_determinant

NOT_SO = {  # statements of the primer that do not come out: the equation each names
    "(1.13)", "(1.16)", "(1.19)", "(2.13)", "(2.28)", "(2.31)", "(2.32)", "(2.2)", "(3.3)", "(A.13)", "(A.23)",
}  # fmt: skip


@pytest.fixture(scope="module")
def study() -> Study:
    """The quick version."""
    told: list[float] = []
    found = run("primer", True, lambda what, share: told.append(share))
    assert told == sorted(told)
    assert (told[0], told[-1]) == (0.0, 1.0)
    return found


def test_every_claim_is_settled(study: Study) -> None:
    """Law: what the primer states comes out, or the study says why not; what this project adds comes out."""
    assert not unexplained(study)
    claims = [claim for finding in study.findings for claim in finding.claims]
    assert all(claim.came_out for claim in claims if claim.whose == "ours")
    assert all(claim.states and claim.found for claim in claims)


def test_the_slips_are_those_known(study: Study) -> None:
    """Law: exactly these statements of the primer do not come out, each with its reason."""
    wrong = [claim for finding in study.findings for claim in finding.claims if not claim.came_out]
    assert len(wrong) == len(NOT_SO)
    assert all(sum(equation in claim.states for claim in wrong) == 1 for equation in NOT_SO)
    assert all(claim.why for claim in wrong)


def test_findings_have_figures_and_numbers(study: Study) -> None:
    """Law: figures have names of their own, every finding its numbers, and all of these are finite."""
    figures = [figure for finding in study.findings for figure in finding.figures]
    assert len({figure.name for figure in figures}) == len(figures) >= 10
    assert all(figure.svg.startswith("<svg") and figure.caption for figure in figures)
    assert all(finding.numbers for finding in study.findings)
    assert all(isfinite(value) for finding in study.findings for table in finding.tables for row in table.rows for value in row[1:])  # type: ignore[arg-type]


@pytest.mark.parametrize(("k", "h"), [(0.5, 0.0), (3.9, 0.0), (1.0, 0.5), (0.3, 1.8)])
def test_the_step_is_read_off_the_solver(k: float, h: float) -> None:
    """Law: trace 2 - K - H, determinant 1 - H of the solver's own step."""
    trace, determinant = trace_and_determinant(k, h)
    # rounding of overlaps of R/2 against motions of 1e-6 R
    assert trace == pytest.approx(2.0 - k - h, abs=1e-7)
    assert determinant == pytest.approx(1.0 - h, abs=1e-7)
    assert largest(0.0, 1.0) == pytest.approx(1.0)
    assert largest(-2.5, 1.0) == pytest.approx(2.0)


def test_the_longest_step_is_the_combined_limit() -> None:
    """Law: K + 2 H = 4: at eta = 2 sqrt(m k) the limit is 2 (sqrt(2) - 1) sqrt(m/k), where (2.31) says 1."""
    assert longest(1.0) == pytest.approx(2.0 * (np.sqrt(2.0) - 1.0), rel=1e-6)


def test_springs_on_a_straight_path() -> None:
    """Law: led one way, all springs are one: force kt x up to the limit, work kt x^2/2 below it."""
    way = np.linspace(0.0, 2.0 * REACH, 2001)[:, None] * np.array([0.6, 0.8, 0.0])
    for ride in led(way).values():
        size = np.linalg.norm(ride.force, axis=1)
        assert size[499] == pytest.approx(KT * 0.5 * REACH, rel=1e-9)
        assert size[-1] == pytest.approx(LIMIT, rel=1e-9)
        assert ride.taken == pytest.approx(1.5 * ENERGY, rel=1e-3)  # a sum over steps of a thousandth of REACH


def test_the_whole_splits_at_its_centre() -> None:
    """Law (A.13), (A.18): K = M V_G^2/2 + K', L = L_G + L' for any particles."""
    rng = np.random.default_rng(3)
    mass, x, v = rng.uniform(0.5, 2.0, 7), rng.normal(size=(7, 3)), rng.normal(size=(7, 3))
    all_ = whole(mass, np.ones(7), x, v, rng.normal(size=(7, 3)))
    assert all_.orbit == pytest.approx(all_.of_centre + all_.about_centre)
    assert all_.kinetic == pytest.approx(0.5 * all_.mass * float(all_.velocity @ all_.velocity) + all_.relative)
    assert all_.rest < 1e-14

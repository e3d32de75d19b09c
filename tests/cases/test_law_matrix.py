"""Contact laws on 1,000 spheres: the native solver against LAMMPS and LIGGGHTS, every deck through the deck reader.

CI runs a selection with every value of every option; `-m slow` runs the rest. Limits are relative to the engine's largest force
(torque).
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest

from demverify.chaos import FACTOR
from tests.cases.law_matrix import LAWS, STEPS, State, deck, full_jobs, quick_jobs, selection, values
from tests.cases.law_measure import Difference, difference, measured, run
from tests.support.engines import require_lammps, require_liggghts

SET_UP, AFTER_HISTORY = 1e-12, 1e-9
REQUIRE = {"lammps": require_lammps, "liggghts": require_liggghts}
QUICK = quick_jobs()
SLOW = [job for job in full_jobs() if job not in QUICK]
Measured = dict[tuple[str, State], "Future[Difference]"]


def job_id(job: tuple[str, State]) -> str:
    """State and law."""
    return f"{job[1]} {job[0]}"


@pytest.fixture(scope="module")
def futures(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Measured]:
    """(law, state) -> its measurement, for all that this session asks for: they run side by side while the tests wait in turn."""
    here = [item.callspec.params for item in request.session.items if item.path == request.path and hasattr(item, "callspec")]
    wanted = [parameters["job"] for parameters in here if "job" in parameters]
    with measured(dict.fromkeys(wanted), tmp_path_factory.mktemp("laws")) as found:
        yield found


def check(job: tuple[str, State], futures: Measured) -> None:
    """Both tiers of one law."""
    REQUIRE[LAWS[job[0]].dialect]()
    found = futures[job].result()
    assert found.force_0 < SET_UP
    assert found.torque_0 < SET_UP
    # a law that chatters parts from itself: then the difference must stay within what one unit in the last place grows to
    assert found.force < max(AFTER_HISTORY, FACTOR * found.chaos_force)
    assert found.torque < max(AFTER_HISTORY, FACTOR * found.chaos_torque)


@pytest.mark.parametrize("job", QUICK, ids=job_id)
def test_forces_equal_the_engine(job: tuple[str, State], futures: Measured) -> None:
    """Forces and torques equal the engine's to 1e-12 at set-up and, contact history and all, to 1e-9 after 200 steps, or to chaos."""
    check(job, futures)


@pytest.mark.slow
@pytest.mark.parametrize("job", SLOW, ids=job_id)
def test_all_forces_equal_the_engine(job: tuple[str, State], futures: Measured) -> None:
    """The same for every other combination of options that the engine allows."""
    check(job, futures)


def test_the_selection_exercises_every_value() -> None:
    """Every style, damping, tangential model and state of a switch that the matrix knows is in the selection of CI."""
    known = set().union(*map(values, LAWS.values()))
    assert set().union(*(values(LAWS[name]) for name, _ in QUICK)) == known
    assert len(selection(LAWS.values(), values)) < len(LAWS) / 8


STIFFNESS = "hooke/stiffness tangential history limitForce off absolute_damping off tangential_damping on"
NUMBERS = [  # law, number in its deck, the same number off by 1e-7
    ("lammps granular hooke damping mass_velocity tangential linear_history unlimited", "1e4 400", "1e4 400.00004"),
    (f"liggghts {STIFFNESS}", "2 400 500", "2 400.00004 500"),
]


@pytest.mark.parametrize(("name", "right", "wrong"), NUMBERS)
def test_a_wrong_number_is_noticed(name: str, right: str, wrong: str, tmp_path: Path) -> None:
    """A damping coefficient off by one part in ten million breaks both limits: the state has contacts that damp."""
    engine = LAWS[name].dialect
    REQUIRE[engine]()
    text = deck(LAWS[name], "bed")
    assert right in text
    found = difference(run(engine, text.replace(right, wrong), tmp_path / "wrong"), run(engine, text, tmp_path / "right"))
    assert found.force_0 > 10 * SET_UP
    assert found.force > 10 * AFTER_HISTORY


def test_histories_matter(tmp_path: Path) -> None:
    """After 200 steps the tangential springs carry: without them forces and torques are off by parts in a hundred."""
    require_liggghts()
    text = deck(LAWS[f"liggghts {STIFFNESS}"], "bed")
    frames = run("liggghts", text, tmp_path / "history")
    other = run("liggghts", text.replace("tangential history", "tangential no_history"), tmp_path / "none")
    found = difference(other, frames)
    assert min(found.force, found.torque) > 1e-2


def test_a_nan_is_a_difference(tmp_path: Path) -> None:
    """A force that is not a number never passes as small."""
    require_lammps()
    frames = run("lammps", deck(next(iter(LAWS.values())), "bed"), tmp_path)
    frames[STEPS].columns["fx"][7] = np.nan
    assert not difference(frames, frames).force < AFTER_HISTORY

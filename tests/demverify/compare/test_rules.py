"""LIGGGHTS' rules put on the scene of a LAMMPS deck."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demverify.rules import under_liggghts_rules
from tests.support.laws import contact_law
from tests.support.scenes import cluster


@pytest.mark.parametrize("friction", ["classic_history", "rotated_history", "no_history", "mindlin_rescale", "mindlin_force"])
def test_only_shared_springs_change_their_rules(friction: str) -> None:
    """Law: levers are LIGGGHTS' and the spring that both have follows its rules there; what LAMMPS alone has stays, and the decks differ."""
    law = contact_law(normal="jkr", tangential_stiffness="mindlin", friction=friction, rolling="sds", twisting="marshall")
    scene = replace(cluster(np.random.default_rng(1)), pair=replace(law, surface_arm="radius"))
    swapped = under_liggghts_rules(scene, replace(scene, history_outlives_contact=True))
    assert swapped.history_outlives_contact
    assert swapped.pair is not None
    assert swapped.pair.friction == ("liggghts_history" if friction in ("classic_history", "rotated_history") else friction)
    assert (swapped.pair.surface_arm, swapped.pair.torque_arm) == ("contact", "contact")
    assert (swapped.pair.normal, swapped.pair.rolling, swapped.pair.twisting) == ("jkr", "sds", "marshall")

"""Nothing is compiled twice, and nothing that has changed is used again."""

from __future__ import annotations

import inspect
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest

from demsolver.specialise import _shared, features, shared_source
from demverify.stability.held import linear, on_floor

ROOT = Path(__file__).parents[2]
RUN = """
import sys
from numba.core import event
seen = event.RecordingListener()
event.register("numba:compile", seen)
import numpy as np
from demsolver import Box, ContactLaw, Neighbor, NveSphere, Particles, Scene, Simulation
x = np.array([[0.0, 0.0, 0.0], [1.9, 0.0, 0.0]])
one, none = np.ones(2), np.zeros((2, 3))
p = Particles(np.array([1, 2]), np.array([1, 1]), x, none, none, one, one, np.ones(2, int), np.zeros((2, 3), int))
pair = ContactLaw("hooke", "none", "none", "none", "none", {"kn": np.full((1, 1), 10.0)})
scene = Scene(Box(np.full(3, -9.0), np.full(3, 9.0), ("ff",) * 3), p, 1, 1e-3, pair=pair, integrate=(NveSphere(),), neighbor=Neighbor(0.1))
simulation = Simulation(scene)
simulation.setup()
print(len(seen.buffer), repr(float(simulation.bodies.force[1, 0])))
"""


def run(solver: Path, cache: Path) -> tuple[int, float]:
    """Compilations and force of a run with the solver of a folder."""
    environment = {**os.environ, "PYTHONPATH": str(solver), "XDG_CACHE_HOME": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True, env=environment)
    count, force = done.stdout.split()
    return int(count), float(force)


@pytest.mark.timeout(300)
def test_a_known_scene_compiles_nothing_and_an_edited_law_is_never_stale(tmp_path: Path) -> None:
    """Law: the second process finds all it needs; after a law, or a template, has changed, the old code is not used, and back again it is."""
    solver, law = tmp_path / "solver", tmp_path / "solver" / "demsolver" / "contact" / "normal_hooke.py"
    shutil.copytree(ROOT / "solver", solver, ignore=shutil.ignore_patterns("__pycache__"))
    compiled, force = run(solver, tmp_path)
    assert compiled > 0
    assert force == pytest.approx(1.0)
    assert run(solver, tmp_path) == (0, force)
    text = law.read_text()
    law.write_text(text.replace("return kn * overlap", "return 2.0 * kn * overlap"))
    assert law.read_text() != text
    compiled, doubled = run(solver, tmp_path)
    assert compiled > 0
    assert doubled == 2.0 * force
    law.write_text(text)
    assert run(solver, tmp_path) == (0, force)
    template = solver / "demsolver" / "kernel_contact.py"
    template.write_text(template.read_text().replace("overlap = reach - distance", "overlap = 3.0 * (reach - distance)"))
    assert run(solver, tmp_path)[1] == pytest.approx(3.0 * force)


@pytest.mark.parametrize("template", ["shape", "turn", "clumps"])
def test_edited_geometry_is_never_stale(template: str) -> None:
    """Law: the name of a shared loop says what all the modules are that it calls, so that none can change unnoticed."""
    has = replace(features(on_floor(1e-5, linear((1,), mu=0.0))), SHAPES=True, CLUMPS=True)
    text = shared_source(template, has)
    called = set(re.findall(r"^from (demsolver\.\S+) import", text, re.MULTILINE))
    known = set(_shared(has)[template])
    assert called
    assert called <= known
    for name in known:
        source = inspect.getsource(import_module(name))
        assert set(re.findall(r"^from (demsolver\.(?:algebra|superquadric)\S*) import", source, re.MULTILINE)) <= known

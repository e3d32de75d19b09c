"""The linters are part of the tests."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("tool", [("ruff", "check", "--quiet", "."), ("mypy",)], ids=lambda tool: tool[0])
def test_a_linter_finds_nothing(tool: tuple[str, ...]) -> None:
    """Law: ruff (all rules but the few that pyproject.toml names) and mypy --strict are silent."""
    done = subprocess.run([sys.executable, "-m", *tool], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]

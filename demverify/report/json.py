"""The report for machines: one JSON object, valid whatever was measured (no NaN, no Infinity), written whole or not at all."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from demverify.compare import Check, verdict
from demverify.report.content import EngineInfo


def as_dict(checks: Sequence[Check] | None, engines: Mapping[str, EngineInfo]) -> dict[str, Any]:
    """The object that is written. checks None: nothing was compared (`run`), so there is no verdict (null) and no check."""
    return {
        "verdict": None if checks is None else verdict(checks),
        "checks": [_check(check) for check in checks or ()],
        "engines": {name: _engine(info) for name, info in engines.items()},
    }


def write_json(path: Path, checks: Sequence[Check] | None, engines: Mapping[str, EngineInfo]) -> None:
    """Write the object to `path`. Raises OSError if the folder cannot be written."""
    write_data(path, as_dict(checks, engines))


def write_data(path: Path, what: object) -> None:
    """Write an object of numbers (finite), texts, lists and tables as JSON. Raises OSError if the folder cannot be written."""
    write_whole(path, json.dumps(what, indent=1, allow_nan=False) + "\n")


def write_whole(path: Path, text: str) -> None:
    """Write a file so that nobody ever sees half of it: beside it first, then renamed over it."""
    handle, beside = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        Path(beside).chmod(0o666 & ~_umask())
        Path(beside).replace(path)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise


def _umask() -> int:
    """The process's umask; there is no way to read it but to set it."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _check(check: Check) -> dict[str, Any]:
    return {
        "quantity": check.quantity,
        "engines": list(check.engines),
        "step": int(check.step),
        "max_abs": _finite(check.max_abs),
        "max_rel": _finite(check.max_rel),
        "tolerance": _finite(check.tolerance),
        "outcome": check.outcome,
        "reason": check.reason,
        "tier": check.tier,
        "kind": check.kind,
    }


def _engine(info: EngineInfo) -> dict[str, Any]:
    return {
        "version": info.version,
        "wall_s": _finite(info.wall_s),
        "particle_steps_per_s": _finite(info.particle_steps_per_s),
    }


def _finite(value: float | None) -> float | None:
    """JSON has neither NaN nor Infinity: null."""
    return float(value) if value is not None and math.isfinite(value) else None

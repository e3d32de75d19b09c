"""The report for machines: the fields that were promised, and valid JSON whatever was measured."""

from __future__ import annotations

import json

import numpy as np
import pytest

from demverify.compare import Check, verdict
from demverify.report.html import EngineInfo
from demverify.report.json import write_json, write_whole

PROMISED = ("quantity", "engines", "step", "max_abs", "max_rel", "tolerance", "outcome", "reason")


def strict(path):
    """Read JSON and refuse NaN and Infinity, which Python would let pass."""

    def refuse(word):
        raise AssertionError(word)

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_the_promised_fields_are_there(any_report, tmp_path):
    """verdict, checks and engines, and of each check the promised fields, with the values that were measured."""
    write_json(tmp_path / "out.json", any_report.checks, any_report.engines)
    data = strict(tmp_path / "out.json")
    assert list(data) == ["verdict", "checks", "engines"]
    assert data["verdict"] == verdict(any_report.checks)
    assert len(data["checks"]) == len(any_report.checks)
    for told, check in zip(data["checks"], any_report.checks, strict=True):
        assert set(told) == {*PROMISED, "tier", "kind"}
        assert told["engines"] == list(check.engines)
        assert (told["outcome"], told["step"], told["reason"]) == (check.outcome, check.step, check.reason)
        assert told["max_rel"] == (None if np.isnan(check.max_rel) else check.max_rel)
    assert {frozenset(engine) for engine in data["engines"].values()} == {
        frozenset({"version", "wall_s", "particle_steps_per_s"})
    }


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, np.float64(0.25)])
def test_numbers_that_json_lacks_become_null(tmp_path, value):
    """NaN and infinities are null, numpy's numbers are numbers."""
    check = Check("force", ("a", "b"), np.int64(3), value, value, 1e-9, "fail")
    write_json(tmp_path / "out.json", [check], {"a": EngineInfo("1", value, value)})
    data = strict(tmp_path / "out.json")
    expected = 0.25 if value == 0.25 else None
    assert (data["checks"][0]["max_abs"], data["checks"][0]["max_rel"], data["checks"][0]["step"]) == (expected, expected, 3)
    assert data["engines"]["a"] == {"version": "1", "wall_s": expected, "particle_steps_per_s": expected}


def test_a_run_fills_the_engines_alone(tmp_path):
    """Nothing compared: no verdict, no check."""
    write_json(tmp_path / "out.json", None, {"native": EngineInfo("0.1", 1.5, 2e6)})
    engines = {"native": {"version": "0.1", "wall_s": 1.5, "particle_steps_per_s": 2e6}}
    assert strict(tmp_path / "out.json") == {"verdict": None, "checks": [], "engines": engines}


def test_nothing_half_written_is_left(tmp_path, monkeypatch):
    """If writing fails, the old file stays and no other is left; what was written has the usual rights."""
    target = tmp_path / "out.json"
    target.write_text("old")
    with pytest.raises(UnicodeEncodeError):
        write_whole(target, "half \udcff")
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out.json"]
    write_whole(target, "new")
    (tmp_path / "plain").write_text("")
    assert target.stat().st_mode == (tmp_path / "plain").stat().st_mode

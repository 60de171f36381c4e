"""Tables of the runs of scenarios with many seeds."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def test_a_table_contains_only_measured_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(BENCHMARKS)
    seeds = import_module("seeds")
    results = [
        seeds.Result(f"scenarios/{name}.osc", "", engine, 0, "passed", "", good, 1.0)
        for name, engine, good in (("one", "mujoco", True), ("one", "mujoco", False), ("two", "toy", True))
    ]
    assert list(seeds.table(results, ("mujoco", "pybullet", "toy"))) == [
        "| scenario | mujoco | toy |",
        "|---|---|---|",
        "| `one` | 1 of 2 |  |",
        "| `two` |  | 1 of 1 |",
    ]

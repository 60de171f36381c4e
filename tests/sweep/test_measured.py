from __future__ import annotations

import json
from pathlib import Path

from seoro.sweep.results import measured


def test_measurements_and_samples_become_columns(tmp_path: Path) -> None:
    robots = {"turtlebot4": {"path_length": 1.5, "localisation_error": None}}
    entities = {"box": {"contacts": 1, "contacts_with": {"turtlebot4": 1}}}
    (tmp_path / "measurements.json").write_text(json.dumps({"robots": robots, "entities": entities}))
    records = [
        {"seq": 0, "t": 0.0, "kind": "record", "item": "way", "value": 1.0},
        {"seq": 1, "t": 1.0, "kind": "record", "item": "way", "value": 2.0},
        {"seq": 2, "t": 1.0, "kind": "cover", "item": "both", "value": {"way": 2.0, "side": "left"}},
        {"seq": 3, "t": 1.0, "kind": "log", "level": "info", "message": "no sample"},
    ]
    (tmp_path / "trace.jsonl").write_text("\n".join(map(json.dumps, records)) + "\n")
    assert measured(tmp_path) == {
        "turtlebot4.path_length": 1.5,
        "turtlebot4.localisation_error": None,
        "box.contacts": 1,
        "box.contacts_with.turtlebot4": 1,
        "record.way": 2.0,
        "cover.both.way": 2.0,
        "cover.both.side": "left",
    }


def test_a_run_without_output_has_no_columns(tmp_path: Path) -> None:
    assert measured(tmp_path) == {}
    (tmp_path / "measurements.json").write_text("{")
    (tmp_path / "trace.jsonl").write_text('{"kind": "record"')
    assert measured(tmp_path) == {}

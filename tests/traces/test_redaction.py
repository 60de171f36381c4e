"""Redaction of traces."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from seoro.traces.redaction import Redactor

SCENARIO = """import osc.helpers

scenario main:
    do serial:
        log("tb4 of anna@lab.org drives to 10.1.2.3, see /home/anna/maps/hall.pgm and /tb4/cmd_vel")
        log("again anna")
"""


def redacted(value: Any, names: tuple[str, ...] = (), dropped: tuple[str, ...] = (), kind: str = "log") -> Any:
    record = {"seq": 0, "t": 1.0, "kind": kind, **value}
    return {name: each for name, each in Redactor(names, dropped).redact(record).items() if name in value}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("/home/anna/maps/hall.pgm", "hall.pgm"),
        ("cannot read /home/anna/x.osc:3:5 of anna", "cannot read x.osc:3:5 of user-1"),
        ("file:///tmp/run/x.sdf", "x.sdf"),
        ("in /home/anna/maps/", "in maps"),
        ("/tb4/cmd_vel and scenarios/maze.osc:3:5", "/tb4/cmd_vel and scenarios/maze.osc:3:5"),
        ("tcp/192.168.0.7:7447, tcp/robot.local:7447", "tcp/host-1:7447, tcp/host-2:7447"),
        ("tcp/127.0.0.1:7450 http://localhost:80", "tcp/127.0.0.1:7450 http://localhost:80"),
        ("10.0.0.1 10.0.0.2 10.0.0.1", "host-1 host-2 host-1"),
        ("the run of anna@lab-3", "the run of address-1"),
        ("version 0.1.0, 3 / 4", "version 0.1.0, 3 / 4"),
    ],
)
def test_texts_lose_paths_users_and_hosts(text: str, expected: str) -> None:
    assert redacted({"message": text}) == {"message": expected}


def test_names_are_replaced_everywhere_as_whole_words() -> None:
    value = {"entities": {"tb4": [1.0], "tb40": [2.0]}, "path": "main/tb4.drive", "list": ["tb4 near dock"]}
    assert redacted(value, ("tb4", "dock")) == {
        "entities": {"name-1": [1.0], "tb40": [2.0]},
        "path": "main/name-1.drive",
        "list": ["name-1 near name-2"],
    }


def test_fields_are_removed() -> None:
    value = {"wall": "2026", "message": "secret", "map": {"data": "abc"}, "shapes": [{"mesh": 1, "size": 2}]}
    dropped = ("log:message", "wall", "log:map.data", "log:shapes.mesh", "scene:shapes")
    assert redacted(value, dropped=dropped) == {
        "wall": "[redacted]",
        "message": "[redacted]",
        "map": {"data": "[redacted]"},
        "shapes": [{"size": 2}],
    }


@pytest.mark.parametrize("field", ["", "seq", "log:", ":x", "log:kind", "a..b"])
def test_invalid_fields_are_refused(field: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["redact", "-", str(tmp_path / "out.jsonl"), "--drop", field]) == 2
    assert "expected FIELD or KIND:FIELD.FIELD" in capsys.readouterr().err


def test_a_redacted_trace_can_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(SCENARIO)
    assert main(["exec", "main.osc", "--clock", "virtual", "--seed", "1", "--trace", "t.jsonl"]) == 0
    assert main(["trace", "redact", "t.jsonl", "shared.jsonl", "--drop", "wall"]) == 0
    text = Path("shared.jsonl").read_text()
    assert not [word for word in ("anna", "10.1.2.3", "/home") if word in text]
    records = [json.loads(line) for line in text.splitlines()]
    assert len(records) == len(Path("t.jsonl").read_text().splitlines())
    assert main(["trace", "shared.jsonl"]) == 0
    assert main(["trace", "redact", "t.jsonl", "t.jsonl"]) == 2


def test_a_redacted_trace_is_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text('import osc.helpers\n\nscenario main:\n    do log("here")\n')
    trace, shared = str(tmp_path / "t.jsonl"), str(tmp_path / "shared.jsonl")
    assert main(["exec", "main.osc", "--clock", "virtual", "--trace", trace]) == 0
    assert main(["redact", trace, shared]) == 0
    assert main(["accept", shared, "main.osc"]) == 0

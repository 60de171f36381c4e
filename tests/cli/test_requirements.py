"""Requirements of a scenario reach its results."""

import json
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest

from seoro.cli.main import main

TEXT = """import osc.types

# seoro: requirement REQ-12, SAFE-3
scenario first:
    do wait elapsed(1s)

# seoro: requirement REQ-9
scenario second:
    do wait elapsed(1s)
"""


def test_a_run_records_the_requirements_of_its_scenario(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "two.osc"
    file.write_text(TEXT)
    command = [
        "exec",
        str(file),
        "--clock",
        "virtual",
        "--scenario",
        "first",
        "-o",
        str(tmp_path / "out"),
        "--json",
    ]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["requirements"] == ["REQ-12", "SAFE-3"]
    start = json.loads((tmp_path / "out" / "trace.jsonl").read_text().splitlines()[0])
    assert start["requirements"] == ["REQ-12", "SAFE-3"]
    found = Xml.parse(tmp_path / "out" / "test.xml").findall(".//property[@name='requirement']")
    assert [each.get("value") for each in found] == ["REQ-12", "SAFE-3"]


def test_requirements_without_names_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "two.osc"
    file.write_text(TEXT.replace("REQ-12, SAFE-3", "REQ 12,"))
    assert main(["exec", str(file), "--clock", "virtual", "--scenario", "first"]) == 2
    assert "invalid requirements `REQ 12,`" in capsys.readouterr().err

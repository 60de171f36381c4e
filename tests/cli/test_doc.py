"""Documentation of libraries and their declarations on the terminal."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.documentation.items import all_items
from seoro.cli.documentation.reading import known_libraries, read_libraries
from seoro.cli.main import main

Show = Callable[..., str]

BEACON = """# Beacons of the hall.

import osc.types
import osc.robotics

# Light a beacon
# of the hall.
action robot.light:
    # Brightness of the lamp.
    level: float = 0.5
    within: time

scenario robot.blink:
    do light(level: 1.0, within: 2s)

struct lamp:
    colour: string = 'red'
    event burnt

struct strong_lamp inherits lamp:
    power: float
    # Switch it off.
    def off() -> bool is undefined
"""


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Show:
    """Return a function that runs `seoro doc` in a folder with a library of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seoro.libraries").mkdir()
    (tmp_path / "seoro.libraries/beacon.osc").write_text(BEACON)

    def run(*arguments: str) -> str:
        assert main(["doc", *arguments]) == 0
        return capsys.readouterr().out

    return run


def shown_json(show: Show, *arguments: str) -> Any:
    return json.loads(show("--json", *arguments))


def test_libraries_are_listed_once_each(show: Show) -> None:
    names = [each["name"] for each in shown_json(show)]
    assert "osc.nav2" in names and "osc.beacon" in names
    assert "osc.types" in names and "osc.standard.types" not in names, "both are one file"
    assert "osc.beacon" in show() and "Beacons of the hall." in show()


@pytest.mark.parametrize("name", ["osc.helpers", "helpers"])
def test_a_library_has_its_declarations_by_kind(show: Show, name: str) -> None:
    out = show(name)
    assert out.startswith("osc.helpers\n\nLogging, variables, processes")
    assert "  log(msg: string)\n      Write a message into the trace" in out
    assert out.index("actions:") < out.index("modifiers:") < out.index("structs:") < out.index("enumerations:")


@pytest.mark.parametrize(
    "name", ["nav_to_pose", "differential_drive_robot.nav_to_pose", "osc.nav2.nav_to_pose",
             "osc.nav2.differential_drive_robot.nav_to_pose"],
)  # fmt: skip
def test_an_action_has_parameters_with_types_and_defaults(show: Show, name: str) -> None:
    out = show(name)
    assert out.startswith("differential_drive_robot.nav_to_pose  (action of osc.nav2)\n\nDrive to a pose.\n")
    assert "  success_on_acceptance  bool     = false\n" in out
    assert out.endswith("  import osc.nav2\n")


def test_own_libraries_are_read_without_their_python(show: Show) -> None:
    found = {each["name"]: each for each in shown_json(show, "beacon")["items"]}
    light = found["robot.light"]
    assert light["meaning"] == "Light a beacon of the hall."
    assert "is_implemented" not in light
    assert light["parameters"] == [
        {"name": "level", "type": "float", "default": "0.5", "meaning": "Brightness of the lamp."},
        {"name": "within", "type": "time", "unit": "s"},
    ]
    strong = found["strong_lamp"]
    assert [each.get("of") for each in strong["parameters"]] == ["lamp", None]
    assert [(each["kind"], each["name"]) for each in found["lamp"]["members"]] == [("event", "lamp.burnt")]
    assert strong["members"][0]["meaning"] == "Switch it off."
    assert found["robot.blink"]["kind"] == "scenario"


def test_actors_have_the_actions_of_their_bases(show: Show) -> None:
    out = show("differential_drive_robot")
    assert "(actor of osc.ros, inherits robot)" in out
    for name in ("robot.inject_noise(", "differential_drive_robot.nav_to_pose(", "robot.light("):
        assert f"\n  {name}" in out


def test_units_have_their_type_and_enumerations_their_members(show: Show) -> None:
    assert "  kph = 0.277778\n" in show("kph")
    assert shown_json(show, "signal")[0]["values"][0] == "sighup = 1"


def test_what_can_only_be_declared_is_marked(show: Show) -> None:
    assert "Declared only: invoking it is an error before the run." in show("docker_run")
    assert shown_json(show, "docker_run")[0]["is_implemented"] is False


def test_files_are_documented(show: Show, tmp_path: Path) -> None:
    (tmp_path / "mine.osc").write_text(BEACON)
    assert shown_json(show, "mine.osc")["name"] == "mine.osc"
    assert "import" not in show("mine.osc")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nav_to_pos",), "did you mean `nav_to_pose`"),
        (("osc.nva2",), "did you mean `osc.nav2`"),
        (("qqqqqq",), "`seoro doc` lists the libraries"),
        (("missing.osc",), "cannot read missing.osc: No such file or directory"),
    ],
)
def test_unknown_names_are_errors_with_suggestions(
    show: Show, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], message: str
) -> None:
    assert main(["doc", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_files_with_errors_are_reported(show: Show, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "wrong.osc").write_text("struct a inherits b\n")
    assert main(["doc", "wrong.osc"]) == 2
    assert "wrong.osc:1:" in capsys.readouterr().err


def test_lines_fit_the_terminal_and_names_are_coloured(show: Show, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert max(len(line) for line in show("osc.helpers").splitlines()) <= 60
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "\x1b[36mlog\x1b[0m" in show("osc.helpers")


def test_every_invokable_action_and_modifier_has_a_meaning(tmp_path: Path) -> None:
    found = list(all_items(read_libraries(known_libraries(tmp_path), tmp_path)))
    assert len(found) > 250
    called = (each for each in found if each.kind in ("action", "modifier", "method") and each.is_implemented)
    assert [each.name for each in called if not each.meaning] == []

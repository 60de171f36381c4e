"""Literal arguments that name files: missing ones are found before a run."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.embed import check_file
from seoro.lang.diagnostic import Severity
from seoro.lsp.analysis import CheckCache, analyse

SPAWN = """import osc.gazebo
import osc.sim
import osc.ros
scenario main:
    barrel: osc_actor
    name: string = "barrel.sdf"
    do {action}
"""
MODEL = "barrel.spawn(spawn_pose: pose_3d(), model: {model})"


def missing(folder: Path, action: str) -> list[tuple[str, Severity]]:
    """Check a file; return the names of missing files in the diagnostics, with the severity."""
    file = folder / "main.osc"
    file.write_text(SPAWN.format(action=action), encoding="utf-8")
    found = check_file(file).checked.diagnostics
    assert {message.code for message in found} <= {"E0414"}, found
    return [(message.primary.span.text, message.severity) for message in found]


@pytest.mark.parametrize(
    ("action", "text"),
    [
        (MODEL.format(model="'barrel.sdf'"), "'barrel.sdf'"),
        (MODEL.format(model="'models/box.urdf'"), "'models/box.urdf'"),
        (MODEL.format(model="'file:///nowhere/a%20box.sdf'"), "'file:///nowhere/a%20box.sdf'"),
        ("spawn_entity('x', 'barrel.sdf')", "'barrel.sdf'"),
        ("load_world('hall.yaml')", "'hall.yaml'"),
        ("bag_play('drive_bag')", "'drive_bag'"),
        ("serial:\n        parallel:\n            bag_play(source: 'drive.mcap')", "'drive.mcap'"),
    ],
)
def test_a_missing_file_is_a_warning(action: str, text: str, tmp_path: Path) -> None:
    assert missing(tmp_path, action) == [(text, Severity.WARNING)]


@pytest.mark.parametrize(
    "action",
    [
        MODEL.format(model="'there.sdf'"),
        MODEL.format(model="'file://there.sdf'"),
        MODEL.format(model="'garden://pots/small.sdf'"),  # on the model path of some run
        MODEL.format(model="'box'"),  # a name that the simulator knows
        MODEL.format(model="name"),  # the run knows its value
        MODEL.format(model="''"),
        "load_world('maze')",
        "bag_play('there.sdf')",
        "spawn_entity('barrel.sdf', 'there.sdf')",  # the name of the entity
    ],
)
def test_other_arguments_are_not_changed(action: str, tmp_path: Path) -> None:
    (tmp_path / "there.sdf").touch()
    assert missing(tmp_path, action) == []


def test_the_working_directory_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "work"
    folder.mkdir()
    (folder / "barrel.sdf").touch()
    monkeypatch.chdir(folder)
    assert missing(tmp_path, MODEL.format(model="'barrel.sdf'")) == []


def test_editors_show_the_warning_until_the_file_exists(tmp_path: Path) -> None:
    path = tmp_path.resolve() / "main.osc"
    memory = CheckCache()

    def codes() -> list[str]:
        texts = {path: SPAWN.format(action=MODEL.format(model="'barrel.sdf'"))}
        return [message.code for message in analyse(path, texts, memory=memory).checked.diagnostics]

    assert codes() == ["E0414"]
    assert codes() == ["E0414"]
    (tmp_path / "barrel.sdf").touch()
    assert codes() == []

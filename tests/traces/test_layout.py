"""The layout for Foxglove, by the panels and settings that the package of Foxglove has."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter

from seoro.cli.main import main
from tests.traces.test_recording import film
from tests.traces.trace_records import RECORDS, trace

layouts = pytest.importorskip("foxglove.layouts", reason="the extra `recording` is not installed")
reader = pytest.importorskip("mcap.reader")

PANELS = {
    "3D": layouts.ThreeDeeConfig,
    "Image": layouts.ImageConfig,
    "Log": layouts.LogConfig,
    "RawMessages": layouts.RawMessagesConfig,
}
TOPICS = {
    "foxglove.SceneUpdate": layouts.BaseRendererSceneUpdateTopicSettings,
    "foxglove.Grid": layouts.BaseRendererGridTopicSettings,
    "foxglove.LaserScan": layouts.BaseRendererLaserScanTopicSettings,
    "foxglove.PosesInFrame": layouts.BaseRendererPosesTopicSettings,
}
PARTS = {
    "camera_state": layouts.ThreeDeeCameraState,
    "scene": layouts.BaseRendererSceneSettings,
    "image_mode": layouts.ImageModeConfig,
}


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """Folder with a recording that has all topics."""
    pytest.importorskip("av", reason="the extra `video` is not installed")
    video = film(tmp_path / "video.mp4", 2)
    recording = str(tmp_path / "run.mcap")
    assert main(["trace", trace(tmp_path, RECORDS), "--mcap", recording, "--video", str(video)]) == 0
    return tmp_path


def schemas(recording: Path) -> dict[str, str]:
    """Return the schema of each topic."""
    with recording.open("rb") as file:
        summary = reader.make_reader(file).get_summary()
    return {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}


def check(kind: Any, settings: dict[str, Any]) -> None:
    """Check that settings exist, and have valid values."""
    named = {re.sub("[A-Z]", lambda found: f"_{found[0].lower()}", name): each for name, each in settings.items()}
    kind(**named)  # raises for unknown names
    plain = {name: each for name, each in named.items() if name not in (*PARTS, "topics")}
    TypeAdapter(kind).validate_python(plain)
    for name in PARTS.keys() & named.keys():
        check(PARTS[name], named[name])


def panels_in(tree: Any) -> Iterator[str]:
    if isinstance(tree, str):
        yield tree
        return
    assert tree["direction"] in ("row", "column")
    assert 0 < tree["splitPercentage"] < 100
    for side in ("first", "second"):
        yield from panels_in(tree[side])


def test_panels_and_settings_are_those_of_foxglove(recorded: Path) -> None:
    layout = json.loads((recorded / "foxglove-layout.json").read_text())
    assert set(panels_in(layout["layout"])) == set(layout["configById"])
    found = schemas(recorded / "run.mcap")
    for name, settings in layout["configById"].items():
        check(PANELS[name.partition("!")[0]], settings)
        for topic, more in settings.get("topics", {}).items():
            check(TOPICS[found[topic]], more)


def test_panels_show_topics_of_the_recording(recorded: Path) -> None:
    panels = json.loads((recorded / "foxglove-layout.json").read_text())["configById"]
    found = schemas(recorded / "run.mcap")
    assert found[panels["Image!seoro"]["imageMode"]["imageTopic"]] == "foxglove.CompressedVideo"
    assert found[panels["Log!seoro"]["topicToRender"]] == "foxglove.Log"
    assert panels["RawMessages!seoro"]["topicPath"] in found
    # With one colour for all cells, a map is a rectangle.
    assert panels["3D!seoro"]["topics"]["/map"]["colorMode"] == "gradient"

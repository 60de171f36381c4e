"""`seoro bag`."""

import json
from pathlib import Path

import pytest

from seoro.bridges.ros2.recording import open_bag, write_bag
from seoro.cli.main import main
from tests.bridges.ros2.recording.bags import CHATTER, SCANS, START, add, talk


@pytest.fixture
async def bag(tmp_path: Path) -> Path:
    async with write_bag(tmp_path / "drive") as writer:
        add(writer, CHATTER, SCANS)
        for topic, payload, time in talk(11):
            writer.write(topic, payload, START + time)
        writer.note("notes", "/scan has lost its publisher, /lidar\n/scan has a publisher again")
    return tmp_path / "drive"


def test_topics_rates_and_notes_are_shown(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bag", str(bag)]) == 0
    first, *lines = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{bag}: 11 messages, 1.000 s, from 20")
    assert lines == [
        "  /chatter  std_msgs/msg/String        11  10.0 Hz",
        "  /scan     sensor_msgs/msg/LaserScan   0",
        "  notes: /scan has lost its publisher, /lidar",
        "  notes: /scan has a publisher again",
    ]


def test_programs_get_json(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bag", str(bag), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["messages"], summary["start"], summary["duration"]) == (11, START, 1.0)
    assert summary["topics"]["/chatter"] == {
        "type": CHATTER.type,
        "type_hash": CHATTER.type_hash,
        "messages": 11,
    }


def test_bags_that_are_cut_off_are_shown_and_mended(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = bag / "drive_0.mcap"
    content = file.read_bytes()
    file.write_bytes(content[:-10])
    assert main(["bag", str(bag)]) == 0
    assert "truncated:" in capsys.readouterr().out
    assert main(["bag", str(bag), "--repair"]) == 0
    assert "truncated:" not in capsys.readouterr().out
    assert not open_bag(bag).is_cut_off


def test_missing_and_invalid_bags_are_errors_with_hints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "drive").mkdir()
    assert main(["bag", str(tmp_path / "drve")]) == 2
    assert capsys.readouterr().err.splitlines() == [
        f"error: bag not found: {tmp_path / 'drve'}",
        "  = help: did you mean `drive`?",
    ]
    assert main(["bag", str(tmp_path / "drive")]) == 2
    assert "is not a bag: expected" in capsys.readouterr().err


async def test_an_empty_bag_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    async with write_bag(tmp_path / "empty"):
        pass
    assert main(["bag", str(tmp_path / "empty")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'empty'}: 0 messages, 0.000 s\n"

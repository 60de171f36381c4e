from datetime import datetime
from pathlib import Path

import pytest

from seoro.bridges.ros2.recording import RefusedRecording, bag_folder, check_storage


def test_bags_are_named_as_by_rosbag2() -> None:
    at = datetime(2024, 5, 31, 16, 4, 5)
    assert bag_folder(Path("out"), at=at) == Path("out/rosbag2_2024_05_31-16_04_05")
    assert bag_folder(Path("out"), "drive") == Path("out/drive")


def test_unsupported_storages_are_refused() -> None:
    check_storage("")
    check_storage("mcap")
    with pytest.raises(RefusedRecording, match="unsupported storage `sqlite3`"):
        check_storage("sqlite3")

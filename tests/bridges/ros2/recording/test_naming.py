from datetime import datetime
from pathlib import Path

from seoro.bridges.ros2.recording import bag_folder


def test_bags_are_named_as_by_rosbag2() -> None:
    at = datetime(2024, 5, 31, 16, 4, 5)
    assert bag_folder(Path("out"), at=at) == Path("out/rosbag2_2024_05_31-16_04_05")
    assert bag_folder(Path("out"), "drive") == Path("out/drive")
